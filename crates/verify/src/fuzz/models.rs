//! Two small FMUs, unpacked: what the calls are made on.

use crowd_mechanics::model::CrowdModel;
use crowd_mechanics::quantities::CrowdQuantity;
use crowd_mechanics::setup;
use lemons_core::plane::vec2;
use lemons_core::trial::{OpeningTimes, Trial, Wall};
use lemons_decision::{DECISION_FILE, Decision};
use lemons_fmi::testing::Version;
use lemons_fmi::testing::instance::VersionFunctions;
use lemons_fmi::variables::{Dimension, VariableType};
use lemons_fmi::{Model, guid, instantiation_token, reference};
use std::collections::BTreeMap;
use std::ffi::CString;
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::OnceLock;
use tempfile::TempDir;

/// A variable: a number or a text in FMI 2.0, an array in FMI 3.0.
pub(crate) struct FuzzVariable {
    pub reference: u32,
    pub name: String,
    pub kind: VariableType,
    pub dimensions: &'static [Dimension],
}

/// An unpacked FMU, and what its model description says.
pub(crate) struct Fmu {
    _directory: Rc<TempDir>,
    pub functions: VersionFunctions,
    pub location: CString,
    /// GUID or instantiation token.
    pub token: CString,
    /// Value references are below this number.
    pub count: u32,
    pub variables: Vec<FuzzVariable>,
    pub reals: Vec<u32>,
    pub integers: Vec<u32>,
    pub booleans: Vec<u32>,
    pub strings: Vec<u32>,
    /// References of the structural parameters of FMI 3.0.
    pub sizes: Vec<u32>,
    /// Values for strings: nothing, a directory of our own, names of Trials.
    pub texts: Vec<CString>,
    /// The OutputDirectory in the content of a serialised state: restoring the state makes it.
    pub output_directory: fn(&[u8]) -> Option<String>,
}

/// OutputDirectory is nothing or a directory of our own: the first two of [`Fmu::texts`].
pub(crate) const OUTPUTS: usize = 2;

/// A Trial of one person; the others have two.
const SMALLER: &str = "Trial_one";

/// Longer arrays are not passed: they are refused at once.
const LONGEST: u64 = 256;

/// A model to be fuzzed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum FuzzedModel {
    Crowd,
    Decision,
}

thread_local! {
    static CROWD: Rc<Resources> = Rc::new(crowd());
    static DECISION: Rc<Resources> = Rc::new(decision());
}

impl Fmu {
    /// Each thread has its directories, which are gone with it.
    pub(crate) fn of(subject: FuzzedModel, version: Version) -> Fmu {
        match subject {
            FuzzedModel::Crowd => {
                let resources = CROWD.with(Rc::clone);
                let model = CrowdModel::load(lemons_fmi::location::Location::Path(&resources.path()));
                Fmu::new(&resources, version, &model.expect("a crowd"), crowd_output_directory)
            }
            FuzzedModel::Decision => {
                let resources = DECISION.with(Rc::clone);
                let model = Decision::load(lemons_fmi::location::Location::Path(&resources.path()));
                Fmu::new(&resources, version, &model.expect("a decision"), |_| Some(String::new()))
            }
        }
    }

    fn new<M: Model>(
        resources: &Resources,
        version: Version,
        model: &M,
        output_directory: fn(&[u8]) -> Option<String>,
    ) -> Fmu {
        let text = |text: &str| CString::new(text).expect("no zero inside");
        let (mut variables, mut sizes) = (Vec::new(), Vec::new());
        let token = match version {
            Version::V2 => {
                let scalars = model.scalars();
                variables.extend((0..).zip(&scalars).map(|(reference, scalar)| FuzzVariable {
                    reference,
                    name: scalar.name.clone(),
                    kind: scalar.variable.kind,
                    dimensions: &[],
                }));
                guid(&scalars)
            }
            Version::V3 => {
                variables.extend(M::VARIABLES.iter().map(|variable| FuzzVariable {
                    reference: reference::<M>(variable.quantity).expect("a row"),
                    name: variable.name.to_owned(),
                    kind: variable.kind,
                    dimensions: variable.dimensions,
                }));
                sizes.extend((1..).take(M::SIZES.len()));
                instantiation_token::<M>()
            }
        };
        let of_kind = |wanted: fn(VariableType) -> bool| {
            let variables = variables.iter().filter(|variable| wanted(variable.kind));
            variables.map(|variable| variable.reference).collect::<Vec<u32>>()
        };
        Fmu {
            _directory: resources.directory.clone(),
            functions: VersionFunctions::of_model::<M>(version),
            location: text(&version.location(&resources.resources)),
            token: text(&token.braced().to_string()),
            count: variables.iter().map(|variable| variable.reference + 1).max().unwrap_or(0),
            reals: of_kind(|kind| matches!(kind, VariableType::Real(_))),
            integers: of_kind(|kind| kind == VariableType::Integer),
            booleans: of_kind(|kind| kind == VariableType::Boolean),
            strings: of_kind(|kind| kind == VariableType::String),
            sizes,
            texts: resources.texts.iter().map(|value| text(value)).collect(),
            variables,
            output_directory,
        }
    }

    pub(crate) fn reference_of(&self, name: &str) -> Option<u32> {
        self.variables.iter().find(|variable| variable.name == name).map(|variable| variable.reference)
    }

    /// The number of elements of variables together, for these values of the structural parameters.
    pub(crate) fn length(&self, references: &[u32], sizes: &[u64]) -> usize {
        let length = |reference: &u32| {
            let variable = self.variables.iter().find(|variable| variable.reference == *reference);
            let sizes =
                variable.into_iter().flat_map(|variable| variable.dimensions).map(|size| match *size {
                    Dimension::Fixed(size) => size,
                    Dimension::Size(place) => sizes[place].min(LONGEST),
                });
            sizes.product::<u64>().min(LONGEST)
        };
        references.iter().map(length).sum::<u64>() as usize
    }
}

fn crowd_output_directory(content: &[u8]) -> Option<String> {
    /// Phase, time, experiment, sizes.
    type OfSlave = (u32, f64, Option<(f64, Option<f64>)>, Vec<u64>);
    /// Beginning of `model::SavedCrowd`: Trial, fingerprint, settings, whether it plays, threads, most steps, intermediate steps.
    type Before = (String, u128, BTreeMap<(CrowdQuantity, usize), f64>, bool, i32, f64, i32);
    let (_, rest) = postcard::take_from_bytes::<(OfSlave, Before)>(content).ok()?;
    Some(postcard::take_from_bytes(rest).ok()?.0)
}

/// Unpacked resources.
struct Resources {
    directory: Rc<TempDir>,
    resources: PathBuf,
    texts: Vec<String>,
}

impl Resources {
    fn path(&self) -> String {
        self.resources.display().to_string()
    }
}

/// Two people of the paper's Trial that touch each other, one of them also a wall: few numbers, fast steps.
pub(crate) fn small_trial() -> Trial {
    static TRIAL: OnceLock<Trial> = OnceLock::new();
    TRIAL.get_or_init(made_small).clone()
}

fn made_small() -> Trial {
    let (mut trial, _) = setup::read(&lemons_testing::trial_push()).expect("the paper's Trial");
    trial.agents.truncate(2);
    trial.dynamics.truncate(2);
    trial.dynamics[1].position = vec2(0.248, 0.03);
    trial.geometry.walls =
        vec![Wall::new("edge", "concrete", vec![vec2(-0.1225, 1.0), vec2(-0.1225, -1.0), vec2(1.0, -1.0)])];
    (trial.parameters.time_step, trial.parameters.time_step_mechanical) = (0.01, 1e-4);
    trial
}

fn crowd() -> Resources {
    let directory = TempDir::with_prefix("lemons-fuzz-").expect("a temporary directory");
    let (resources, output) = (directory.path().join("resources"), directory.path().join("output"));
    std::fs::create_dir_all(&output).expect("its directory");
    let mut trial = small_trial();
    let door = Wall::new("door", "concrete", vec![vec2(0.4, -0.5), vec2(0.4, 0.5)]);
    trial.geometry.walls.push(Wall { open: OpeningTimes::of_numbers(&[0.01, 0.03, 0.05]).ok(), ..door });
    trial.write(&resources.join("Trial_a")).expect("a Trial can be written");
    trial.dynamics[1].position.x = 0.5;
    trial.write(&resources.join("Trial_b")).expect("a Trial can be written");
    let drive = "t,agent,Fp.x,Fp.y,Mp\n0,1,-900,3,1\n0.02,1,-900,0,0\n";
    std::fs::write(resources.join("Trial_b/drive.csv"), drive).expect("a file can be written");
    // Of another size: for FMI 3.0.
    trial.agents.truncate(1);
    trial.dynamics.truncate(1);
    trial.write(&resources.join(SMALLER)).expect("a Trial can be written");
    let output = output.to_str().expect("UTF-8").to_owned();
    let texts = ["", &output, "Trial_a", "Trial_b", "Trial_c", "../resources/Trial_a", SMALLER];
    Resources { directory: Rc::new(directory), resources, texts: texts.map(str::to_owned).to_vec() }
}

/// The Trial that a plan is made for.
pub(crate) fn walkers() -> Trial {
    let mut trial = small_trial();
    trial.agents.truncate(2);
    trial.agents[1].id = "two words".into();
    trial.dynamics.truncate(2);
    trial
}

fn decision() -> Resources {
    let directory = TempDir::with_prefix("lemons-fuzz-").expect("a temporary directory");
    let config =
        "waypoints = [{ x = 1, y = 2 }, { x = 3, y = 4, radius = 1 }]\n[agents.0]\ndesired_speed = 1";
    walkers().write(directory.path()).expect("a Trial can be written");
    std::fs::write(directory.path().join(DECISION_FILE), config).expect("a file can be written");
    let resources = directory.path().to_owned();
    Resources { directory: Rc::new(directory), resources, texts: ["", "text"].map(str::to_owned).to_vec() }
}
