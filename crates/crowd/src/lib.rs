//! People and crowds from anthropometric data: the other half of the paper (sections 2.1, 3.3, 4.4, 4.5; App. A.2, D).
//!
//! A [`Person`] is drawn from statistics; five disks are fitted to it, its [`Shape`]; crowds of shapes are placed
//! without overlap and written as a Trial. SI units; angles in radians, counter-clockwise positive.

mod anthropometry;
mod bicycle;
mod copula;
mod normal;
mod person;
mod population;
mod random;
mod shape;
mod survey;
mod union;

pub use anthropometry::{MeasureStatistics, SexStatistics, ansur};
pub use bicycle::{BICYCLE_MEASURES, Bicycle, BicycleError, BicycleStatistics};
pub use copula::{Correlations, CorrelationsError};
pub use normal::{TruncatedNormal, TruncatedNormalError};
pub use person::{Measure, Person, PersonError, Sex};
pub use population::{
    Agent, CustomMeasures, CustomStatistics, Population, PopulationError, Proportions, Source,
};
pub use random::{Generator, generator};
pub use shape::{Disk, Shape, ShapeError};
pub use survey::{BadCell, BadCells, Survey, SurveyError};
pub use union::{Moments, union};
