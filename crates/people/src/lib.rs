//! People and crowds from anthropometric data: the other part of the paper (sections 2.1, 3.3, 4.4, 4.5; App. A.2, D).
//!
//! A [`Person`] is drawn from statistics. Its [`Shape`] is made of five disks. Crowds of shapes are [placed](placing)
//! without overlap, in [rooms](room) with doors, and written as a Trial. SI units; angles in radians, counter-clockwise positive.

mod anthropometry;
mod bicycle;
mod body3d;
mod copula;
mod custom;
mod doors;
mod leaving;
mod light_xml;
mod normal;
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
pub use bicycle::{BICYCLE_MEASURES, Bicycle, BicycleError, BicycleStatistics};
pub use body3d::{
    BODY_DENSITY, Body3d, BodyError, CrowdSection, GIRTH_FACTORS, Mesh, MeshPart, Part, Placed, Polygon,
    TORSO_ALTITUDE, section, write_geojson, write_obj, write_stl, write_wkt,
};
pub use copula::{Correlations, CorrelationsError};
pub use custom::{Custom, CustomError};
pub use doors::{Door, DoorError, nearest_wall, with_doors};
pub use leaving::{closed_walls, cut_doors};
pub use lemons_core::plane::{Disk, Moments, union};
pub use light_xml::{
    Along, LightAgent, LightDisk, LightError, LightRectangle, LightSettings, LightShapes, light_xml,
    read_light_xml,
};
pub use normal::{TruncatedNormal, TruncatedNormalError};
pub use person::{Measure, Person, PersonError, Sex};
pub use population::{
    Agent, CustomMeasures, CustomStatistics, Population, PopulationError, Proportions, Source,
};
pub use random::{Generator, generator};
pub use shape::{Shape, ShapeError};
pub use survey::{Survey, SurveyError};
pub use table::{CrowdStatistics, Kind, KindStatistics, Summary, crowd_csv};
pub use trial::{
    Overwrite, TRIAL_FILES, TrialError, TrialSettings, crowd_trial, heading, may_write, paper_materials,
    walls, write_trial, write_trial_with, write_trial_zip, zip_trial,
};
