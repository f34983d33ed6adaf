//! `modelDescription.xml` of a Trial's FMU.

use crate::variables::{MOST_MECHANICAL_STEPS, Quantity, Variable, in_documents, table};
use lemons_fmi2::description::{Description, Naming};
use lemons_trial::Trial;
use lemons_xml::number;

/// `modelName`
pub const MODEL_NAME: &str = "LEMONS crowd mechanics";
/// `modelIdentifier`: the stem of the binaries' names.
pub const MODEL_IDENTIFIER: &str = "CrowdMechanics";
/// \[s\] `DefaultExperiment.stopTime`
pub const DEFAULT_STOP_TIME: f64 = 5.0;

/// \[byte\] Larger descriptions are neither written nor read by the master of this repository, because it keeps several
/// copies in memory. The description of 10 000 agents has 70 MB.
pub const LARGEST_DESCRIPTION: u64 = 256_000_000;

/// Returns the model description of a Trial's FMU.
pub fn model_description(trial: &Trial, naming: Naming) -> String {
    let table = table(trial);
    Description {
        model_name: MODEL_NAME,
        model_identifier: MODEL_IDENTIFIER,
        description: "contact mechanics of a dense crowd: rigid bodies of disks, damped springs, Coulomb friction, walls",
        naming,
        interpolates_inputs: true,
        stop_time: DEFAULT_STOP_TIME,
        step_size: trial.parameters.time_step,
        table: &table,
        start: &|place| start(trial, &table[place]),
        // Inputs at a communication point do not affect outputs at the same point: no dependencies.
        dependencies: &|_| Vec::new(),
        initial_dependencies: &|_| Vec::new(),
    }
    .xml()
}

fn start(trial: &Trial, variable: &Variable) -> Option<String> {
    match variable.quantity {
        Quantity::Threads => Some("1".into()),
        Quantity::MostMechanicalSteps => Some(number(MOST_MECHANICAL_STEPS)),
        Quantity::Trial => Some(trial.name.clone()),
        Quantity::OutputDirectory => Some(String::new()),
        quantity => in_documents(trial, quantity).map(number),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::setup;
    use lemons_testing::{repository, trial_push};

    #[test]
    fn the_committed_one_is_the_generated_one() {
        let (trial, warnings) = setup::read(&trial_push()).unwrap();
        assert!(warnings.is_empty(), "{warnings}");
        let committed = std::fs::read_to_string(repository().join("fmu/modelDescription.xml")).unwrap();
        assert!(
            committed == model_description(&trial, Naming::Structured),
            "regenerate it: cargo run --release -- describe resources/Trial_push > fmu/modelDescription.xml"
        );
    }
}
