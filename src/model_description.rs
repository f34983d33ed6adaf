//! `modelDescription.xml` of a Trial's FMU.

use crate::model::CrowdModel;
use lemons_core::trial::{DriveTable, Trial};
use lemons_fmi::description::{Packed, terminals_xml};
use lemons_fmi::{FmuFormat, Model, Version, description};

/// `modelName`
pub const MODEL_NAME: &str = CrowdModel::NAME;
/// `modelIdentifier`: the stem of the binaries' names.
pub const MODEL_IDENTIFIER: &str = CrowdModel::IDENTIFIER;
/// \[s\] `DefaultExperiment.stopTime`
pub const DEFAULT_STOP_TIME: f64 = CrowdModel::STOP_TIME;

/// \[byte\] Larger descriptions are neither written nor read by the master of this repository, because it keeps several
/// copies in memory. The description of 10 000 agents has 72 MB.
pub const LARGEST_DESCRIPTION: u64 = 256_000_000;

/// Returns the model description of a Trial's FMU.
pub fn model_description(trial: &Trial, format: FmuFormat) -> String {
    packed_description(trial, format, &[])
}

/// Returns the model description of an FMU that starts with this Trial, in which these are packed.
pub fn packed_description(trial: &Trial, format: FmuFormat, packed: &[Packed]) -> String {
    let mut crowd = CrowdModel::of_trial(trial.clone(), DriveTable::default());
    description::packed_description(&mut crowd, format, packed).expect("start values are in the Trial")
}

/// Returns the terminal `crowd`: drives in, motion out.
pub fn terminals(trial: &Trial, version: Version) -> String {
    let names = ["Fp", "Mp", "Active", "Position", "Theta", "Velocity", "Omega"];
    let crowd = CrowdModel::of_trial(trial.clone(), DriveTable::default());
    terminals_xml(&crowd, version, "drives in, motion out", &names)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::setup;
    use lemons_testing::{repository, trial_push};

    #[test]
    fn the_committed_ones_are_the_generated_ones() {
        let (trial, warnings) = setup::read(&trial_push()).unwrap();
        assert!(warnings.is_empty(), "{warnings}");
        for (file, format) in [
            ("fmu/modelDescription.xml", FmuFormat::default()),
            ("fmu/modelDescription3.xml", FmuFormat::Fmi3),
        ] {
            let (path, generated) = (repository().join(file), model_description(&trial, format));
            if std::env::var_os("DESCRIPTIONS").is_some_and(|what| what == "write") {
                std::fs::write(&path, &generated).unwrap();
            }
            assert!(std::fs::read_to_string(&path).unwrap() == generated, "{file}: see docs/development.md");
        }
    }
}
