//! The *Trial* directory: the XML files of the paper's section 3.1 and App. C, as typed documents.
//!
//! A [`Trial`] contains the checked content of the files, with their names and in their order. `crowd_mechanics::setup`
//! builds the engine's world from it. A parameter of the FMU is an edit of these documents.

mod agents;
mod documents;
mod drive;
mod dynamics;
mod geometry;
mod ground;
mod heights;
mod interactions;
mod link;
mod materials;
mod opening;
mod panels;
mod parameters;
mod problem;
mod schema;
mod xml;

pub use crate::rule::{Rule, Severity};
pub use crate::xml::{Problem, quoted};
pub use agents::{Agent, BODY_MASS_INDEX, ShapeElement};
pub use documents::{FileNames, INTERACTIONS, Trial, output_names};
pub use drive::{DRIVE_FILE, DriveChoice, DriveTable, DriveValues, EVER, half_sine, own_drive};
pub use dynamics::{AgentDynamics, DynamicsElement, dynamics_xml};
pub use geometry::{Geometry, Wall};
pub use ground::{GRAVITY, Ground, Grounds, Incline};
pub use heights::{Heights, LOAD_LENGTH};
pub use interactions::{AgentInteraction, ContactForce, Interactions, WallInteraction, interactions_xml};
pub use link::{Link, LinkPassage, carried_from};
pub use materials::{ContactCoefficients, Material, Materials, pairs_that_touch, stiffness};
pub use opening::OpeningTimes;
pub use panels::{PanelChoice, Stretch};
pub use parameters::Parameters;
pub use problem::Problems;
pub use xml::{Checked, FARTHEST};
