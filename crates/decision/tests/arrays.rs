//! The decision as arrays, through the functions of FMI 3.0.

use lemons_core::plane::{Vec2, vec2};
use lemons_core::trial::{Agent, AgentDynamics, ShapeElement, Trial};
use lemons_decision::pack::description;
use lemons_decision::plan::Planned;
use lemons_decision::rule::Walker;
use lemons_decision::{DECISION_FILE, Decision, DecisionConfig, Plan};
use lemons_fmi::Status::{self, Ok as OK};
use lemons_fmi::testing::bounds;
use lemons_fmi::testing::dependencies::moved;
use lemons_fmi::testing::instance::{Arguments, VersionFunctions};
use lemons_fmi::testing::{TestInstance, Version};
use lemons_fmi::variables::Known;
use lemons_fmi::{self as fmi, FmuFormat, Model};
use lemons_testing::trial_push;
use std::ffi::CString;
use std::ops::Deref;
use std::path::Path;
use tempfile::TempDir;

/// Agents, and the way-points of each.
const AGENTS: usize = 3;
const COUNTS: [i32; AGENTS] = [2, 1, 3];
const MOST: usize = 3;

fn plan() -> Plan {
    plan_of(
        "waypoints = [{ x = 5, y = 2 }, { x = 6, y = -4, radius = 1 }]\n\
        [agents.\"two words\"]\nwaypoints = [{ x = -3, y = 1 }]\ndesired_speed = 0.9\n\
        [agents.7]\nwaypoints = [{ x = 2, y = 4 }, { x = 2.5, y = 4 }, { x = 9, y = 9 }]",
    )
}

fn trial() -> Trial {
    let (mut trial, _) = Trial::read(&trial_push()).unwrap();
    let shapes =
        vec![ShapeElement { radius: 0.2, position: Vec2::zeros(), ..trial.agents[0].shapes[0].clone() }];
    let person = |(id, x): (&str, f64)| {
        let start = AgentDynamics { position: vec2(x, 0.5), theta: 0.25 * x, ..AgentDynamics::default() };
        (Agent { shapes: shapes.clone(), ..Agent::new(id, 70.0 + x, 1.3, [2.0, 4.0]) }, start)
    };
    (trial.agents, trial.dynamics) =
        [("0", 0.0), ("two words", 1.0), ("7", 2.0)].map(person).into_iter().unzip();
    trial.geometry.walls.clear();
    trial.parameters.time_step = 0.05;
    trial
}

fn plan_of(config: &str) -> Plan {
    Plan::of(&trial(), &DecisionConfig::from_toml(config).unwrap()).unwrap()
}

fn reference(name: &str) -> u32 {
    if let Some(place) = Decision::SIZES.iter().position(|size| size.name == name) {
        return 1 + place as u32;
    }
    let variable = Decision::VARIABLES.iter().find(|variable| variable.name == name);
    let variable = variable.unwrap_or_else(|| panic!("no variable {name}"));
    fmi::reference::<Decision>(variable.quantity).unwrap()
}

/// An instance of the plan.
struct Walkers {
    instance: TestInstance,
    _resources: TempDir,
}

impl Deref for Walkers {
    type Target = TestInstance;

    fn deref(&self) -> &TestInstance {
        &self.instance
    }
}

/// An FMU holds its plan, to the last bit.
#[test]
fn a_plan_reads_back_to_the_last_bit() {
    let mut trial = trial();
    trial.agents[0].moment_of_inertia = 1.0 / 3.0;
    trial.dynamics[0].position = vec2(1e-300, -0.0);
    let config = "waypoints = [{ x = 0.1, y = 1e-320, radius = 0 }]\n[agents.7]\ndesired_speed = 0.3";
    let plan = Plan::of(&trial, &DecisionConfig::from_toml(config).unwrap()).unwrap();
    let directory = TempDir::new().unwrap();
    trial.write(directory.path()).unwrap();
    std::fs::write(directory.path().join(DECISION_FILE), plan.config.to_toml().unwrap()).unwrap();
    // 0 and -0 are written otherwise.
    assert_eq!(format!("{:?}", Plan::read(directory.path()).unwrap()), format!("{plan:?}"));
}

impl Walkers {
    fn new() -> Walkers {
        Walkers::of(Version::V3, fmi::instantiation_token::<Decision>().to_string())
    }

    fn of(version: Version, token: String) -> Walkers {
        let resources = TempDir::new().unwrap();
        trial().write(resources.path()).unwrap();
        let text = plan().config.to_toml().unwrap();
        std::fs::write(resources.path().join(DECISION_FILE), text).unwrap();
        let token = CString::new(token).unwrap();
        let path = CString::new(version.location(resources.path())).unwrap();
        let functions = VersionFunctions::of_model::<Decision>(version);
        let instance = TestInstance::new(&functions, &Arguments::new(&token, &path));
        Walkers {
            instance: instance.unwrap_or_else(|messages| panic!("{messages:?}")),
            _resources: resources,
        }
    }

    fn initialized() -> Walkers {
        let instance = Walkers::new();
        instance.initialize();
        instance
    }

    #[track_caller]
    fn refuses(&self, status: Status, words: &str) {
        let message = self.refused(status);
        assert!(message.contains(words), "{message}");
    }

    fn try_set(&self, name: &str, values: &[f64]) -> Status {
        self.set_real(&[reference(name)], values)
    }

    #[track_caller]
    fn get(&self, name: &str, length: usize) -> Vec<f64> {
        let (status, values) = self.get_real(&[reference(name)], length);
        self.must(status);
        values
    }

    #[track_caller]
    fn integers(&self, name: &str, length: usize) -> Vec<i32> {
        let (status, values) = self.get_integer(&[reference(name)], length);
        self.must(status);
        values
    }

    fn try_step(&self, from: f64) -> Status {
        self.do_step(from, 0.05).status
    }

    /// As numbers, whatever the type.
    #[track_caller]
    fn output(&self, name: &str) -> Vec<f64> {
        match name {
            "Arrived" => self.integers(name, 1).into_iter().map(f64::from).collect(),
            "NextWaypoint" => self.integers(name, AGENTS).into_iter().map(f64::from).collect(),
            "Fp" => self.get(name, 2 * AGENTS),
            _ => self.get(name, AGENTS),
        }
    }
}

/// SSPs, saved runs and importers hold names, value references and tokens. `DESCRIPTIONS=write` writes the files again.
#[test]
fn the_descriptions_are_those_that_importers_know() {
    for (file, format) in [("fmi2.xml", FmuFormat::default()), ("fmi3.xml", FmuFormat::Fmi3)] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/descriptions").join(file);
        let own = description(&plan(), format);
        if std::env::var_os("DESCRIPTIONS").is_some_and(|what| what == "write") {
            std::fs::write(&path, &own).unwrap();
        }
        assert!(own == std::fs::read_to_string(&path).unwrap(), "{file}");
    }
}

/// A walk past way-points, with arrays and with the variables of FMI 2.0.
#[test]
fn arrays_have_the_bits_of_scalars() {
    let instance = Walkers::initialized();
    let table = Decision::new(plan()).scalars();
    let scalars = Walkers::of(Version::V2, fmi::guid(&table).to_string());
    scalars.initialize();
    let places = |name: &str| -> Vec<u32> {
        let rows = (0..).zip(&table).filter(|(_, row)| row.variable.name == name);
        rows.map(|(place, _)| place).collect()
    };
    for k in 0..40 {
        let along = 0.2 * f64::from(k);
        let starts = plan().agents.into_iter().map(|agent| agent.walker.waypoints[0]);
        let position: Vec<f64> = starts
            .zip(0..)
            .flat_map(|(to, i)| [to.x - 4.0 + along, to.y - 0.1 + 0.05 * f64::from(i)])
            .collect();
        for (name, values) in [("Position", &position), ("Theta", &vec![0.3 * along; AGENTS])] {
            instance.must(instance.try_set(name, values));
            scalars.must(scalars.set_real(&places(name), values));
        }
        for (name, length) in [("Fp", 2 * AGENTS), ("Mp", AGENTS)] {
            let (status, values) = scalars.get_real(&places(name), length);
            scalars.must(status);
            let same = |(a, b): (f64, &f64)| a.to_bits() == b.to_bits();
            assert!(instance.get(name, length).into_iter().zip(&values).all(same), "{name}, step {k}");
        }
        for (name, length) in [("NextWaypoint", AGENTS), ("Arrived", 1)] {
            assert_eq!((OK, instance.integers(name, length)), scalars.get_integer(&places(name), length));
        }
        for walkers in [&instance, &scalars] {
            walkers.must(walkers.try_step(0.05 * f64::from(k)));
        }
    }
    let next = instance.integers("NextWaypoint", AGENTS);
    assert!(next[0] > 0 && next[1] == 1 && next[2] > 1, "they walk past way-points: {next:?}");
}

#[test]
fn routes_of_different_lengths_are_rows_with_zeros_behind() {
    let instance = Walkers::new();
    instance.must(instance.enter(None, 0.0, None));
    assert_eq!(instance.integers("WaypointCount", AGENTS), COUNTS);
    let mut waypoints = instance.get("Waypoint", AGENTS * MOST * 2);
    let radii = instance.get("WaypointRadius", AGENTS * MOST);
    for (i, agent) in plan().agents.iter().enumerate() {
        for k in 0..MOST {
            let given = agent.walker.waypoints.get(k).map_or([0.0; 3], |w| [w.x, w.y, w.radius]);
            let at = i * MOST + k;
            assert_eq!([waypoints[2 * at], waypoints[2 * at + 1], radii[at]], given);
        }
    }
    // What was read can be set again; what no agent has cannot be set.
    instance.must(instance.try_set("Waypoint", &waypoints));
    instance.must(instance.try_set("WaypointRadius", &radii));
    let before = instance.bytes();
    waypoints[MOST * 2 + 3] = 1.0;
    let words = "agent \"two words\" has only 1 way-points";
    instance.refuses(instance.try_set("Waypoint", &waypoints), words);
    assert!(instance.bytes() == before);
    // A way-point that is moved is where it is walked to.
    waypoints[MOST * 2 + 3] = 0.0;
    (waypoints[2 * MOST], waypoints[2 * MOST + 1]) = (1.0, 100.5);
    instance.must(instance.try_set("Waypoint", &waypoints));
    let force = instance.get("Fp", 2 * AGENTS);
    assert!(force[2] == 0.0 && force[3] > 100.0, "{force:?}");
}

#[test]
fn the_sizes_are_those_of_the_plan() {
    let instance = Walkers::new();
    instance.must(instance.enter_configuration());
    let names = ["Agents", "Waypoints"].map(reference);
    let (status, sizes) = instance.get_size(&names, 2);
    instance.must(status);
    assert_eq!(sizes, [AGENTS as u64, MOST as u64]);
    instance.must(instance.set_size(&names, &[3, 5]));
    instance.must(instance.exit_configuration());
    let words = "Waypoints is 5, but what is loaded has 3";
    instance.refuses(instance.try_set("WaypointRadius", &[0.0; 15]), words);
    instance.must(instance.try_set("Theta", &[0.0; AGENTS]));
}

/// All dependencies of an output: element, value reference, element.
#[allow(unsafe_code)] // calls C functions
fn listed(instance: &Walkers, output: &str) -> Vec<(usize, u32, usize)> {
    let mut count = 0;
    let number = instance.v3().fmi3GetNumberOfVariableDependencies;
    instance.must(unsafe { number(instance.raw, reference(output), &mut count) });
    let (mut dependents, mut elements) = (vec![0; count], vec![0; count]);
    let (mut independents, mut kinds) = (vec![0; count], vec![0; count]);
    instance.must(unsafe {
        (instance.v3().fmi3GetVariableDependencies)(
            instance.raw,
            reference(output),
            dependents.as_mut_ptr(),
            independents.as_mut_ptr(),
            elements.as_mut_ptr(),
            kinds.as_mut_ptr(),
            count,
        )
    });
    assert!(kinds.iter().all(|kind| *kind == 5), "fmi3Dependent");
    let mut listed: Vec<_> = (0..count).map(|k| (dependents[k], independents[k], elements[k])).collect();
    listed.sort_unstable();
    listed
}

/// Against what changes when an input or, before initialization has ended, a parameter is changed.
#[test]
fn outputs_depend_on_what_is_listed() {
    // Near the first way-points, so that the numbers of way-points react, too.
    let poses = [
        ("Position", vec![4.8, 2.1, -2.7, 1.2, 2.1, 3.8]),
        ("Theta", vec![0.1, 0.2, 0.3]),
        ("Velocity", vec![0.02, 0.01, -0.01, 0.02, 0.01, -0.02]),
    ];
    // A little less than what everybody would push with: who wants to go more slowly pushes less.
    let force = |agent: &Planned| {
        let Walker { mass, floor_damping, desired_speed, .. } = agent.walker;
        mass * floor_damping * desired_speed - 25.0
    };
    let push: Vec<f64> = plan().agents.iter().map(force).collect();
    let parameters = [
        ("Mass", AGENTS),
        ("MomentOfInertia", AGENTS),
        ("FloorDamping", AGENTS),
        ("AngularDamping", AGENTS),
        ("DesiredSpeed", AGENTS),
        ("Push", AGENTS),
        ("Waypoint", 2 * MOST * AGENTS),
        ("WaypointRadius", MOST * AGENTS),
    ];
    for initialized in [true, false] {
        let instance = Walkers::new();
        instance.must(instance.enter(None, 0.0, None));
        instance.must(instance.try_set("Push", &push));
        if initialized {
            instance.must(instance.exit());
        }
        let start = |(name, length): (&'static str, usize)| (name, instance.get(name, length));
        let mut known: Vec<(&str, Vec<f64>)> = poses.to_vec();
        if !initialized {
            known.extend(parameters.map(start));
        }
        for (name, values) in &known {
            instance.must(instance.try_set(name, values));
        }
        for output in ["Fp", "Mp", "NextWaypoint", "Arrived"] {
            let listed = listed(&instance, output);
            let before = instance.output(output);
            let mut seen = Vec::new();
            for (name, values) in &known {
                for element in 0..values.len() {
                    for by in [-0.5, -0.1, 0.1, 0.5] {
                        let mut moved = values.clone();
                        moved[element] += by;
                        if instance.try_set(name, &moved) != OK {
                            // Below 0, or of a way-point that nobody has.
                            instance.take_messages();
                            continue;
                        }
                        let after = instance.output(output);
                        let changed = before.iter().zip(&after).enumerate().filter(|(_, (a, b))| a != b);
                        seen.extend(changed.map(|(at, _)| (at + 1, reference(name), element + 1)));
                    }
                    instance.must(instance.try_set(name, values));
                }
            }
            seen.sort_unstable();
            seen.dedup();
            assert!(seen.iter().all(|on| listed.contains(on)), "{output}: {seen:?} not all in {listed:?}");
            // Numbers jump only near here, and a way-point counts only when those before it are reached.
            if initialized && ["Fp", "Mp"].contains(&output) {
                assert_eq!(listed, seen, "{output}");
            } else {
                assert!(!seen.is_empty(), "{output}");
            }
            let of = |name| listed.iter().filter(|(_, on, _)| *on == reference(name)).count();
            if !initialized {
                let waypoints = COUNTS.iter().sum::<i32>() as usize;
                let both = if output == "Fp" { 2 } else { 1 };
                assert_eq!((of("Waypoint"), of("WaypointRadius")), (2 * both * waypoints, both * waypoints));
                assert_eq!(of("Mass"), if output == "Fp" { 2 * AGENTS } else { 0 });
            } else {
                assert_eq!(of("Mass") + of("Waypoint"), 0);
            }
        }
    }
}

/// The same of models of walking and of balance.
#[test]
fn whatever_people_do_depends_on_what_is_declared() {
    let plans = [
        "model = \"straight\"\nwaypoints = [{ x = 5, y = 2 }]",
        "model = \"rotational\"\nwaypoints = [{ x = 5, y = 2 }]\n[agents.7]\nwaypoints = [{ x = 2.3, y = 0.6 }]",
        "model = \"collision-free-speed\"\nbalance = \"pendulum\"\nwaypoints = [{ x = 0.3, y = 0.6 }]",
        "balance = \"two-level\"\nwaypoints = [{ x = 0.1, y = 0.5 }]\n[agents.7]\nwaypoints = [{ x = 5, y = 2 }]",
    ];
    for config in plans {
        let make = || Decision::new(plan_of(config));
        let initially = moved(make, Known::Starts);
        for on in ["Position", "DesiredSpeed"] {
            assert!(initially.contains(&("Fp", on)), "{config}: {on}");
        }
        let initialized = || {
            let mut decision = make();
            decision.initialize(0.0).unwrap();
            decision
        };
        assert!(moved(initialized, Known::Inputs).contains(&("Fp", "Position")), "{config}");
    }
}

/// Checks the bounds that a description declares, in both versions.
#[test]
fn declared_bounds_are_kept() {
    bounds::are_kept(|| Decision::new(plan()));
}

#[test]
fn a_state_remembers_waypoints_and_damaged_bytes_are_refused() {
    let (instance, other) = (Walkers::initialized(), Walkers::new());
    instance.must(instance.try_set("Position", &[5.0, 2.0, -3.0, 1.0, 2.0, 4.0]));
    instance.must(instance.try_step(0.0));
    instance.must(instance.try_set("Position", &[0.0; 6]));
    let bytes = instance.bytes();
    other.must(other.restore(&bytes));
    assert_eq!(other.integers("NextWaypoint", AGENTS), [1, 1, 1]);
    for output in ["Fp", "Mp", "NextWaypoint", "Arrived"] {
        assert_eq!(other.output(output), instance.output(output));
    }
    other.must(other.try_step(0.05));
    let before = other.bytes();
    for k in (0..bytes.len()).step_by(5) {
        let mut damaged = bytes.clone();
        damaged[k] ^= 0x55;
        other.refuses(other.restore(&damaged), "state");
    }
    assert!(other.bytes() == before);
    other.must(other.reset());
    other.initialize();
    assert_eq!(other.integers("NextWaypoint", AGENTS), [0; AGENTS]);
}
