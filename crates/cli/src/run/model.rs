//! The model that a run steps: a Trial in memory, or FMUs.

use super::outputs::OutputValues;
use anyhow::{Error, Result};
use lemons_core::plane::Vec2;
use lemons_core::trial::{DriveTable, Trial};
use lemons_decision::Plan;
use lemons_master::{ComponentRecord, SavedRun};
use lemons_results::columns::{Column, Groups};
use lemons_sim::{Clock, RunModel};

/// A crowd whose frames a run records.
pub struct CrowdInfo {
    /// Name of its component.
    pub component: String,
    pub ids: Vec<String>,
    /// Shapes, if they are known.
    pub trial: Option<Trial>,
    pub groups: Groups,
    pub columns: Vec<Column>,
    /// Of its FMU.
    pub model_name: String,
    pub guid: String,
}

/// A model that the command runs.
pub trait RecordedModel: RunModel<Error = Error> {
    /// \[N\] The forces that drive the people of a crowd, if they are known.
    fn drive(&self) -> Option<Vec<Vec2>> {
        None
    }

    /// The outputs of what is not a crowd.
    fn outputs(&mut self) -> Result<OutputValues>;

    /// States at the last communication point.
    fn states(&mut self) -> Result<Vec<Vec<u8>>>;

    /// Ends the run.
    fn terminate(&mut self) -> Result<()> {
        Ok(())
    }

    /// Warnings since the last call.
    fn take_warnings(&mut self) -> Vec<String>;
}

/// A run that is ready: at its first communication point, or at that of the saved run.
pub struct PreparedRun {
    pub model: Box<dyn RecordedModel>,
    pub crowds: Vec<CrowdInfo>,
    /// Columns of the outputs of components that are no crowds.
    pub output_columns: Vec<Column>,
    /// Known plans of people who walk.
    pub plans: Vec<Plan>,
    /// Lines of the summary: what is coupled.
    pub coupling: Vec<String>,
    /// Mechanical steps \[s\], by the name of the parameter.
    pub mechanical_steps: Vec<(String, f64)>,
    /// Directories into which crowds write XML files, if not empty.
    pub output_directories: Vec<String>,
    pub clock: Clock,
    /// One communication point in so many is written, beginning with the first.
    pub every: u64,
    pub drive: DriveTable,
    /// The FMUs and their connections, for a saved run.
    pub components: Vec<ComponentRecord>,
    pub wiring: String,
    /// The saved run that goes on.
    pub before: Option<SavedRun>,
}
