//! `modelDescription.xml` of a Trial's FMU.

use crate::arrays::{Block, sizes, starts};
use crate::model::CrowdModel;
use crate::variables::{AgentQuantity, MOST_MECHANICAL_STEPS, Quantity, Variable, in_documents, table};
use lemons_core::trial::Trial;
use lemons_core::xml::number;
use lemons_fmi::v2::description::{Description, Naming};
use lemons_fmi::v3;
use lemons_fmi::v3::description::Start;
use lemons_fmi::v3::terminals::{CROWD, Terminal, terminals_xml};

/// `modelName`
pub const MODEL_NAME: &str = "LEMONS crowd mechanics";
/// `modelIdentifier`: the stem of the binaries' names.
pub const MODEL_IDENTIFIER: &str = "CrowdMechanics";
/// \[s\] `DefaultExperiment.stopTime`
pub const DEFAULT_STOP_TIME: f64 = 5.0;

/// \[byte\] Larger descriptions are neither written nor read by the master of this repository, because it keeps several
/// copies in memory. The description of 10 000 agents has 70 MB.
pub const LARGEST_DESCRIPTION: u64 = 256_000_000;

/// Description for users.
const DESCRIPTION: &str =
    "contact mechanics of a dense crowd: rigid bodies of disks, damped springs, Coulomb friction, walls";

/// Returns the model description of a Trial's FMI 3.0 FMU.
pub fn model_description_3(trial: &Trial) -> String {
    v3::description::Description {
        model_name: MODEL_NAME,
        model_identifier: MODEL_IDENTIFIER,
        description: DESCRIPTION,
        knows_derivatives: true,
        shows_intermediate_values: true,
        stop_time: DEFAULT_STOP_TIME,
        step_size: trial.parameters.time_step,
        sizes: &sizes(trial),
        start: &|block| start_of_array(trial, block),
        // Inputs at a communication point do not affect outputs at the same point: no dependencies.
        dependencies: &|_| Vec::new(),
        initial_dependencies: &|_| Vec::new(),
    }
    .xml::<CrowdModel>()
}

/// Returns the terminal `crowd`: drives in, motion out. With an icon, `icon.png` is beside it.
pub fn terminals(icon: bool) -> String {
    let terminal = Terminal {
        name: CROWD,
        description: "drives in, motion out",
        variables: &["Fp", "Mp", "Active", "Position", "Theta", "Velocity", "Omega"],
    };
    terminals_xml::<CrowdModel>(&terminal, icon)
}

/// Returns the model description of a Trial's FMI 2.0 FMU.
pub fn model_description(trial: &Trial, naming: Naming) -> String {
    let table = table(trial);
    Description {
        model_name: MODEL_NAME,
        model_identifier: MODEL_IDENTIFIER,
        description: DESCRIPTION,
        naming,
        interpolates_inputs: true,
        knows_derivatives: true,
        stop_time: DEFAULT_STOP_TIME,
        step_size: trial.parameters.time_step,
        table: &table,
        start: &|place| start(trial, &table[place]),
        // Inputs at a communication point do not affect outputs at the same point: no dependencies.
        dependencies: &|_| Some(Vec::new()),
        initial_dependencies: &|_| Some(Vec::new()),
    }
    .xml()
}

fn start(trial: &Trial, variable: &Variable) -> Option<String> {
    match variable.quantity {
        Quantity::Threads => Some("1".into()),
        Quantity::PlayDrive | Quantity::Agent(_, AgentQuantity::Active) => Some("true".into()),
        Quantity::MostMechanicalSteps => Some(number(MOST_MECHANICAL_STEPS)),
        Quantity::Trial => Some(trial.name.clone()),
        Quantity::OutputDirectory => Some(String::new()),
        quantity => in_documents(trial, quantity).map(number),
    }
}

fn start_of_array(trial: &Trial, block: Block) -> Option<Start> {
    match block {
        Block::One(Quantity::Threads | Quantity::PlayDrive) => Some(Start::Numbers(vec![1.0])),
        Block::One(Quantity::IntermediateSteps) => Some(Start::Numbers(vec![0.0])),
        Block::One(Quantity::MostMechanicalSteps) => Some(Start::Numbers(vec![MOST_MECHANICAL_STEPS])),
        Block::One(Quantity::Trial) => Some(Start::Texts(vec![trial.name.clone()])),
        Block::One(Quantity::OutputDirectory) => Some(Start::Texts(vec![String::new()])),
        Block::Agents([AgentQuantity::Active]) => Some(Start::Numbers(vec![1.0; trial.agents.len()])),
        Block::AgentIds | Block::MaterialIds => None,
        block => starts(trial, block).map(Start::Numbers),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::setup;
    use lemons_verify::testing::{repository, trial_push};

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
