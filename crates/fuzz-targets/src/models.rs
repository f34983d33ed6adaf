//! Two small FMUs, unpacked: what the calls are made on.

use crowd_mechanics::model::CrowdModel;
use crowd_mechanics::setup;
use crowd_mechanics::variables::{Quantity, table};
use lemons_decision::decision::PLAN_FILE;
use lemons_decision::{Decision, rule::Pose};
use lemons_decision::{Person, Plan, Wishes};
use lemons_fmi::Model;
use lemons_fmi::v2::guid;
use lemons_fmi::variables::{Kind, Variable};
use lemons_plane::vec2;
use lemons_trial::{Trial, Wall};
use std::collections::BTreeMap;
use std::ffi::CString;
use std::fmt::Debug;
use std::path::Path;
use std::rc::Rc;
use std::sync::OnceLock;
use tempfile::TempDir;

/// An unpacked FMU, and what its model description says.
pub(crate) struct Fmu {
    _directory: TempDir,
    pub uri: CString,
    pub guid: CString,
    /// How many value references there are.
    pub count: u32,
    pub reals: Vec<u32>,
    pub integers: Vec<u32>,
    pub strings: Vec<u32>,
    /// The reference of the mechanical step, which bounds the work of a communication step.
    pub mechanical_step: Option<u32>,
    /// The reference of OutputDirectory, where files are written.
    pub output: Option<u32>,
    /// Values for strings: nothing, a directory of our own, names of Trials.
    pub texts: Vec<CString>,
}

/// OutputDirectory is nothing or a directory of our own: the first two of [`Fmu::texts`].
pub(crate) const OUTPUTS: usize = 2;

/// A Trial of one person; the others have two.
pub(crate) const SMALLER: &str = "Trial_one";

/// A model to be fuzzed.
pub(crate) trait Fuzzed: Model {
    /// Its FMU, one for each thread: gone with the thread.
    fn fmu() -> Rc<Fmu>;

    /// The OutputDirectory in the content of a serialised state: restoring the state makes it.
    fn output_directory(content: &[u8]) -> Option<String>;
}

thread_local! {
    static CROWD: Rc<Fmu> = Rc::new(crowd());
    static DECISION: Rc<Fmu> = Rc::new(decision());
}

impl Fuzzed for CrowdModel {
    fn fmu() -> Rc<Fmu> {
        CROWD.with(Rc::clone)
    }

    fn output_directory(content: &[u8]) -> Option<String> {
        /// Phase, time, experiment, sizes.
        type OfSlave = (u32, f64, Option<(f64, Option<f64>)>, Vec<u64>);
        /// Of `model::Saved`: Trial, fingerprint, settings, whether it plays, threads, most steps, intermediate steps.
        type Before = (String, u128, BTreeMap<Quantity, f64>, bool, i32, f64, i32);
        let (_, rest) = postcard::take_from_bytes::<(OfSlave, Before)>(content).ok()?;
        Some(postcard::take_from_bytes(rest).ok()?.0)
    }
}

impl Fuzzed for Decision {
    fn fmu() -> Rc<Fmu> {
        DECISION.with(Rc::clone)
    }

    fn output_directory(_: &[u8]) -> Option<String> {
        Some(String::new())
    }
}

impl Fmu {
    fn new<Q: Debug>(directory: TempDir, resources: &Path, table: &[Variable<Q>], texts: &[&str]) -> Fmu {
        let text = |text: &str| CString::new(text).expect("no zero inside");
        let of_kind = |wanted: fn(Kind) -> bool| {
            let rows = table.iter().zip(0..).filter(|(row, _)| wanted(row.kind));
            rows.map(|(_, reference)| reference).collect::<Vec<u32>>()
        };
        let named = |name: &str| table.iter().zip(0..).find(|(row, _)| row.name == name).map(|(_, at)| at);
        Fmu {
            _directory: directory,
            uri: text(&format!("file://{}", resources.display())),
            guid: text(&guid(table).braced().to_string()),
            count: u32::try_from(table.len()).expect("a small table"),
            reals: of_kind(|kind| matches!(kind, Kind::Real(_))),
            integers: of_kind(|kind| kind == Kind::Integer),
            strings: of_kind(|kind| kind == Kind::String),
            mechanical_step: named("TimeStepMechanical"),
            output: named("OutputDirectory"),
            texts: texts.iter().map(|value| text(value)).collect(),
        }
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
    trial.geometry.walls = vec![Wall {
        id: "edge".into(),
        material_id: "concrete".into(),
        corners: vec![vec2(-0.1225, 1.0), vec2(-0.1225, -1.0), vec2(1.0, -1.0)],
    }];
    (trial.parameters.time_step, trial.parameters.time_step_mechanical) = (0.01, 1e-4);
    trial
}

fn crowd() -> Fmu {
    let directory = TempDir::with_prefix("lemons-fuzz-").expect("a temporary directory");
    let (resources, output) = (directory.path().join("resources"), directory.path().join("output"));
    std::fs::create_dir_all(&output).expect("its directory");
    let mut trial = small_trial();
    let table = table(&trial);
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
    Fmu::new(
        directory,
        &resources,
        &table,
        &["", &output, "Trial_a", "Trial_b", "Trial_c", "../resources/Trial_a"],
    )
}

/// The people that a plan is made for.
pub(crate) fn people() -> Vec<Person> {
    let person = |id: &str, x| Person {
        id: id.into(),
        mass: 70.0,
        moment_of_inertia: 1.3,
        floor_damping: 2.0,
        angular_damping: 4.0,
        pose: Pose { x, y: 0.0, theta: 0.0 },
        disks: Vec::new(),
    };
    vec![person("0", 0.0), person("two words", 1.0)]
}

fn decision() -> Fmu {
    let directory = TempDir::with_prefix("lemons-fuzz-").expect("a temporary directory");
    let wishes =
        "waypoints = [{ x = 1, y = 2 }, { x = 3, y = 4, radius = 1 }]\n[agents.0]\ndesired_speed = 1";
    let wishes = Wishes::from_toml(wishes).expect("good wishes");
    let plan = Plan::new(&people(), &wishes, 0.05).expect("a good plan");
    let text = plan.to_toml().expect("a plan can be written");
    std::fs::write(directory.path().join(PLAN_FILE), text).expect("a file can be written");
    let (table, path) = (lemons_decision::decision::table(&plan), directory.path().to_owned());
    Fmu::new(directory, &path, &table, &["", "text"])
}
