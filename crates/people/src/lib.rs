//! People and crowds from anthropometric data: the other part of the paper (sections 2.1, 3.3, 4.4, 4.5; App. A.2, D).
//!
//! A [`Person`] is drawn from statistics. Its [`Shape`] is made of five disks. Crowds of shapes are [placed](placing)
//! without overlap, in [rooms](room) with doors, and written as a Trial. SI units; angles in radians, counter-clockwise positive.

mod anthropometry;
mod bicycle;
mod body3d;
mod copula;
mod cover;
mod custom;
mod doors;
pub mod drawing;
mod error;
mod growth;
mod kinds;
mod levels;
mod light_xml;
mod materials;
mod person;
pub mod placing;
mod population;
mod random;
pub mod room;
mod shape;
mod survey;
mod table;
mod trial;

pub use anthropometry::{MeasureStatistics, SexStatistics, ansur};
pub use bicycle::{BICYCLE_MEASURES, Bicycle, PAPER_BICYCLES};
pub use body3d::{
    Body3d, BodyPart, BodySlice, CrowdSection, Figure, MeshPart, PlacedPeople, TORSO_ALTITUDE, packed,
    people_fitting, person_fitting, section, write_geojson, write_obj, write_stl, write_wkt,
};
pub use copula::Correlations;
pub use cover::{Cover, MOST_COVERING, cover};
pub use custom::Custom;
pub use doors::{Door, closed_walls, cut_doors, cut_doors_in_all, nearest_wall};
pub use error::{ALL as SENTENCES, PeopleError};
pub use kinds::{BICYCLE, BodyDisk, BodyStatistics, KindPart, Kinds, Member, PartOrigin, PersonKind, Solid};
pub use lemons_core::distribution::{Distribution, Range, TruncatedNormal};
pub use lemons_core::plane::is_closed;
pub use lemons_core::plane::{Disk, Moments};
pub use levels::{Slabs, chest_height};
pub use light_xml::light_xml;
pub use materials::{PART_MATERIALS, SKINS, materials, paper_materials};
pub use person::{BodyMeasure, Person, Sex};
pub use population::{CrowdMember, CustomMeasures, Population, PopulationSource, Statistics};
pub use shape::Shape;
pub use survey::Survey;
pub use table::{CrowdStatistics, KindStatistics, MeasureSummary, crowd_csv};
pub use trial::{
    TRIAL_FILES, TrialSettings, choose_mechanical_step, crowd_trial, heading, may_write, mechanical_step_for,
    walls, write_trial, write_trial_zip, zip_trial,
};
