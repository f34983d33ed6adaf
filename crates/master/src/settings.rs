//! What is run, and how.

use crate::decider::PlanChoice;
use crate::system::Algorithm;
use crowd_mechanics::pack::Binary;
use lemons_trial::DriveChoice;
use std::path::PathBuf;

/// What is run, and how: all that somebody has to say of a run. See [`Prepared::of`](crate::Prepared::of).
#[derive(Debug, Clone)]
pub struct Settings {
    /// A Trial (its directory, or a zip of it), an FMU, or an SSP (by its extension).
    pub input: PathBuf,
    /// Parameters and start values: names as in [`Fmu::named`](crate::Fmu::named), in an SSP `component.name`; and
    /// values as text. They are set in this order. Of people who walk, names without a component are the crowd's.
    pub parameters: Vec<(String, String)>,
    /// The number of threads of the crowd; not for an SSP, where it is a parameter of each component.
    pub threads: Option<i32>,
    /// The tolerance of the experiment, positive and finite: each FMU gets it, and makes of it what it can. A crowd takes it
    /// as the accuracy \[m\] for which it chooses its mechanical step. Default: that of an FMU's own DefaultExperiment,
    /// else none.
    pub tolerance: Option<f64>,
    /// \[s\] The communication step, finite and greater than 0. Default: the Trial's TimeStep; of several components, the smallest.
    pub step: Option<f64>,
    /// \[s\] The end of the run, finite and after its start. Default: that of the saved run, the stop time of the SSP, or 5 s.
    pub until: Option<f64>,
    /// One communication point in so many is recorded, beginning with the first: at least 1. Default: that of the saved
    /// run, or 1.
    pub every: Option<u64>,
    /// Who is pushed when; in an SSP, connections feed the inputs instead.
    pub drive: DriveChoice,
    /// Where a Trial's people walk: then the input is coupled like an SSP of the components `decision` and `crowd`.
    pub plan: PlanChoice,
    /// How coupled components exchange values.
    pub algorithm: Algorithm,
    /// A saved run, which goes on. It contains the parameters and the number of threads.
    pub resume: Option<PathBuf>,
    /// Whether the run is to be saved: then each FMU must be able to save its state.
    pub saves: bool,
    /// The crowd's shared library, with which a Trial becomes an FMU. Default: [`own_binary`](crate::own_binary).
    pub binary: Option<Binary>,
}

impl Settings {
    /// With the default of everything else.
    pub fn of(input: impl Into<PathBuf>) -> Settings {
        Settings {
            input: input.into(),
            parameters: Vec::new(),
            threads: None,
            tolerance: None,
            step: None,
            until: None,
            every: None,
            drive: DriveChoice::Own,
            plan: PlanChoice::Own,
            algorithm: Algorithm::default(),
            resume: None,
            saves: false,
            binary: None,
        }
    }
}
