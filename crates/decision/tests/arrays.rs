//! The decision as arrays, through the functions of FMI 3.0.

#![allow(unsafe_code)] // calls the C functions

use State::*;
use lemons_decision::decision::PLAN_FILE;
use lemons_decision::rule::Pose;
use lemons_decision::{Decision, Person, Plan, Wishes};
use lemons_fmi::v2;
use lemons_fmi::v3::arrays::{array_reference, size_reference};
use lemons_fmi::v3::{ArrayModel, token};
use lemons_testing::fmi3::{Functions, Log, log};
use std::ffi::{CString, c_int, c_void};
use std::ptr::{null, null_mut};
use std::sync::Once;
use tempfile::TempDir;

const OK: c_int = 0;
const ERROR: c_int = 3;
/// Agents, and the way-points of each.
const AGENTS: usize = 3;
const COUNTS: [i32; AGENTS] = [2, 1, 3];
const MOST: usize = 3;

/// An FMU silences panics in its host; those of a test are shown.
fn show_panics() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let hook = std::panic::take_hook();
        lemons_fmi::silence_panics();
        std::panic::set_hook(hook);
    });
}

fn plan() -> Plan {
    let person = |id: &str, x| Person {
        id: id.into(),
        mass: 70.0 + x,
        moment_of_inertia: 1.3,
        floor_damping: 2.0,
        angular_damping: 4.0,
        pose: Pose { x, y: 0.5, theta: 0.25 * x },
        disks: Vec::new(),
    };
    let people = [person("0", 0.0), person("two words", 1.0), person("7", 2.0)];
    let wishes = "waypoints = [{ x = 5, y = 2 }, { x = 6, y = -4, radius = 1 }]\n\
        [agents.\"two words\"]\nwaypoints = [{ x = -3, y = 1 }]\ndesired_speed = 0.9\n\
        [agents.7]\nwaypoints = [{ x = 2, y = 4 }, { x = 2.5, y = 4 }, { x = 9, y = 9 }]";
    Plan::new(&people, &Wishes::from_toml(wishes).unwrap(), 0.05).unwrap()
}

fn reference(name: &str) -> u32 {
    if let Some(place) = Decision::SIZES.iter().position(|size| size.name == name) {
        return size_reference(place);
    }
    let place = Decision::arrays().iter().position(|array| array.name == name);
    array_reference::<Decision>(place.unwrap_or_else(|| panic!("no variable {name}")))
}

struct Instance {
    c: Functions,
    raw: *mut c_void,
    log: Box<Log>,
    _resources: TempDir,
}

impl Drop for Instance {
    fn drop(&mut self) {
        unsafe { (self.c.fmi3FreeInstance)(self.raw) };
    }
}

impl Instance {
    fn new() -> Instance {
        show_panics();
        let resources = TempDir::new().unwrap();
        std::fs::write(resources.path().join(PLAN_FILE), plan().to_toml().unwrap()).unwrap();
        let (c, log_of) = (Functions::of_model::<Decision>(), Box::<Log>::default());
        let token = CString::new(token::<Decision>().braced().to_string()).unwrap();
        let path = CString::new(resources.path().to_str().unwrap()).unwrap();
        let environment = std::ptr::from_ref(&*log_of).cast_mut().cast();
        let raw = unsafe {
            (c.fmi3InstantiateCoSimulation)(
                c"decision".as_ptr(),
                token.as_ptr(),
                path.as_ptr(),
                false,
                true,
                false,
                false,
                null(),
                0,
                environment,
                Some(log),
                None,
            )
        };
        assert!(!raw.is_null(), "{:?}", log_of.take());
        Instance { c, raw, log: log_of, _resources: resources }
    }

    fn initialized() -> Instance {
        let instance = Instance::new();
        instance.initialize();
        instance
    }

    #[track_caller]
    fn must(&self, status: c_int) {
        assert_eq!(status, OK, "{:?}", self.log.take());
    }

    #[track_caller]
    fn refused(&self, status: c_int, words: &str) {
        let said = self.log.take();
        assert!(status == ERROR && said.len() == 1 && said[0].2.contains(words), "{status}: {said:?}");
    }

    #[track_caller]
    fn initialize(&self) {
        self.must(unsafe { (self.c.fmi3EnterInitializationMode)(self.raw, false, 0.0, 0.0, false, 0.0) });
        self.must(unsafe { (self.c.fmi3ExitInitializationMode)(self.raw) });
    }

    fn try_set(&self, name: &str, values: &[f64]) -> c_int {
        let set = self.c.fmi3SetFloat64;
        unsafe { set(self.raw, &reference(name), 1, values.as_ptr(), values.len()) }
    }

    fn try_get(&self, name: &str, length: usize) -> (c_int, Vec<f64>) {
        let mut values = vec![f64::NAN; length];
        let get = self.c.fmi3GetFloat64;
        (unsafe { get(self.raw, &reference(name), 1, values.as_mut_ptr(), length) }, values)
    }

    #[track_caller]
    fn get(&self, name: &str, length: usize) -> Vec<f64> {
        let (status, values) = self.try_get(name, length);
        self.must(status);
        values
    }

    #[track_caller]
    fn integers(&self, name: &str, length: usize) -> Vec<i32> {
        let (mut values, get) = (vec![-7; length], self.c.fmi3GetInt32);
        self.must(unsafe { get(self.raw, &reference(name), 1, values.as_mut_ptr(), length) });
        values
    }

    fn try_step(&self, from: f64) -> c_int {
        let (mut no, mut time) = ([false; 3], 0.0);
        let [event, terminate, early] = &mut no;
        unsafe { (self.c.fmi3DoStep)(self.raw, from, 0.05, true, event, terminate, early, &mut time) }
    }

    fn save(&self) -> *mut c_void {
        let mut state = null_mut();
        self.must(unsafe { (self.c.fmi3GetFMUState)(self.raw, &mut state) });
        state
    }

    fn free(&self, mut state: *mut c_void) {
        self.must(unsafe { (self.c.fmi3FreeFMUState)(self.raw, &mut state) });
    }

    fn bytes(&self) -> Vec<u8> {
        let (state, mut size) = (self.save(), 0);
        self.must(unsafe { (self.c.fmi3SerializedFMUStateSize)(self.raw, state, &mut size) });
        let mut bytes = vec![0; size];
        self.must(unsafe { (self.c.fmi3SerializeFMUState)(self.raw, state, bytes.as_mut_ptr(), size) });
        self.free(state);
        bytes
    }

    fn restore(&self, bytes: &[u8]) -> c_int {
        let (mut state, read) = (null_mut(), self.c.fmi3DeserializeFMUState);
        let status = unsafe { read(self.raw, bytes.as_ptr(), bytes.len(), &mut state) };
        if status != OK {
            return status;
        }
        let status = unsafe { (self.c.fmi3SetFMUState)(self.raw, state) };
        self.free(state);
        status
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

#[derive(Debug, Clone, Copy, PartialEq)]
enum State {
    Instantiated,
    Configuration,
    Initialization,
    StepComplete,
    Terminated,
}

fn reach(state: State) -> Instance {
    let instance = Instance::new();
    match state {
        Instantiated => {}
        Configuration => instance.must(unsafe { (instance.c.fmi3EnterConfigurationMode)(instance.raw) }),
        Initialization => instance.must(unsafe {
            (instance.c.fmi3EnterInitializationMode)(instance.raw, false, 0.0, 0.0, false, 0.0)
        }),
        StepComplete | Terminated => instance.initialize(),
    }
    if state == Terminated {
        instance.must(unsafe { (instance.c.fmi3Terminate)(instance.raw) });
    }
    instance
}

type Call = fn(&Instance) -> c_int;

/// Function, where it is allowed (in the order of the states), and a call that is right there.
const TABLE: [(&str, &str, Call); 18] = [
    ("fmi3EnterConfigurationMode", "x - - - -", |i| unsafe { (i.c.fmi3EnterConfigurationMode)(i.raw) }),
    ("fmi3ExitConfigurationMode", "- x - - -", |i| unsafe { (i.c.fmi3ExitConfigurationMode)(i.raw) }),
    ("fmi3EnterInitializationMode", "x - - - -", |i| unsafe {
        (i.c.fmi3EnterInitializationMode)(i.raw, true, 1e-6, 0.5, true, 2.0)
    }),
    ("fmi3ExitInitializationMode", "- - x - -", |i| unsafe { (i.c.fmi3ExitInitializationMode)(i.raw) }),
    ("fmi3Terminate", "- - - x -", |i| unsafe { (i.c.fmi3Terminate)(i.raw) }),
    ("fmi3Reset", "x x x x x", |i| unsafe { (i.c.fmi3Reset)(i.raw) }),
    ("fmi3GetFloat64", "- x x x x", |i| i.try_get("Fp", 2 * AGENTS).0),
    ("fmi3GetInt32", "- x x x x", |i| unsafe {
        (i.c.fmi3GetInt32)(i.raw, &reference("Arrived"), 1, &mut 0, 1)
    }),
    ("fmi3GetUInt64", "- x x x x", |i| unsafe {
        (i.c.fmi3GetUInt64)(i.raw, &reference("Waypoints"), 1, &mut 0, 1)
    }),
    ("fmi3GetString", "- x x x x", |i| unsafe {
        let mut texts = [null(); AGENTS];
        (i.c.fmi3GetString)(i.raw, &reference("AgentId"), 1, texts.as_mut_ptr(), AGENTS)
    }),
    ("fmi3SetFloat64", "x - x x -", |i| i.try_set("Theta", &[1.0; AGENTS])),
    ("fmi3SetFloat64", "x - x - -", |i| i.try_set("DesiredSpeed", &[1.0; AGENTS])),
    ("fmi3SetUInt64", "- x - - -", |i| unsafe {
        (i.c.fmi3SetUInt64)(i.raw, &reference("Agents"), 1, &(AGENTS as u64), 1)
    }),
    ("fmi3GetNumberOfVariableDependencies", "x x x x x", |i| unsafe {
        (i.c.fmi3GetNumberOfVariableDependencies)(i.raw, reference("Fp"), &mut 0)
    }),
    ("fmi3SetFMUState", "x x x x x", |i| {
        let state = i.save();
        let status = unsafe { (i.c.fmi3SetFMUState)(i.raw, state) };
        i.free(state);
        status
    }),
    ("fmi3SerializeFMUState", "x x x x x", |i| {
        i.bytes();
        OK
    }),
    ("fmi3DeserializeFMUState", "x x x x x", |i| i.restore(&i.bytes())),
    ("fmi3DoStep", "- - - x -", |i| i.try_step(0.0)),
];

#[test]
fn functions_are_allowed_where_the_standard_allows_them() {
    for (name, states, call) in TABLE {
        let reached = [Instantiated, Configuration, Initialization, StepComplete, Terminated];
        for (state, cell) in reached.into_iter().zip(states.split(' ')) {
            let instance = reach(state);
            let before = instance.bytes();
            let status = call(&instance);
            let said = instance.log.take();
            let case = format!("{name} in {state:?}: {status}, {said:?}");
            if cell == "x" {
                assert_eq!(status, OK, "{case}");
            } else {
                assert_eq!(status, ERROR, "{case}");
                assert!(said.len() == 1 && said[0].2.starts_with(&format!("{name}: ")), "{case}");
                assert!(instance.bytes() == before, "{case} has changed something");
            }
        }
    }
}

/// A walk past way-points, with arrays and with the variables of FMI 2.0.
#[test]
fn arrays_have_the_bits_of_scalars() {
    let instance = Instance::initialized();
    let decision = Decision::new(plan());
    let table = lemons_decision::decision::table(&plan());
    let mut scalars = v2::Slave::new(decision, &v2::guid(&table).to_string()).unwrap();
    let place = |name: String| table.iter().position(|row| row.name == name).unwrap() as u32;
    scalars.setup_experiment(0.0, None, None).unwrap();
    scalars.enter_initialization().unwrap();
    scalars.exit_initialization().unwrap();
    for k in 0..40 {
        let along = 0.2 * f64::from(k);
        let (mut position, mut theta) = (Vec::new(), Vec::new());
        for i in 0..AGENTS {
            let to = &plan().agents[i].walker.waypoints[0];
            let pose = [to.x - 4.0 + along, to.y - 0.1 + 0.05 * i as f64, 0.3 * along];
            for (name, value) in ["Position.x", "Position.y", "Theta"].into_iter().zip(pose) {
                scalars.set_real(&[place(format!("agent[{i}].{name}"))], &[value]).unwrap();
            }
            position.extend(&pose[..2]);
            theta.push(pose[2]);
        }
        instance.must(instance.try_set("Position", &position));
        instance.must(instance.try_set("Theta", &theta));
        let mut one = |name: String| {
            let mut value = [f64::NAN];
            scalars.get_real(&[place(name)], &mut value).unwrap();
            value[0].to_bits()
        };
        let force = instance.get("Fp", 2 * AGENTS);
        let torque = instance.get("Mp", AGENTS);
        for i in 0..AGENTS {
            assert_eq!(force[2 * i].to_bits(), one(format!("agent[{i}].Fp.x")));
            assert_eq!(force[2 * i + 1].to_bits(), one(format!("agent[{i}].Fp.y")));
            assert_eq!(torque[i].to_bits(), one(format!("agent[{i}].Mp")));
        }
        let mut next = [0; AGENTS + 1];
        let names = (0..AGENTS).map(|i| place(format!("agent[{i}].NextWaypoint")));
        let names: Vec<u32> = names.chain([place("Arrived".into())]).collect();
        scalars.get_integer(&names, &mut next).unwrap();
        assert_eq!(instance.integers("NextWaypoint", AGENTS), next[..AGENTS]);
        assert_eq!(instance.integers("Arrived", 1), next[AGENTS..]);
        let time = 0.05 * f64::from(k);
        instance.must(instance.try_step(time));
        scalars.do_step(time, 0.05).unwrap();
    }
    let next = instance.integers("NextWaypoint", AGENTS);
    assert!(next[0] > 0 && next[1] == 1 && next[2] > 1, "they walk past way-points: {next:?}");
}

#[test]
fn routes_of_different_lengths_are_rows_with_zeros_behind() {
    let instance = Instance::new();
    instance
        .must(unsafe { (instance.c.fmi3EnterInitializationMode)(instance.raw, false, 0.0, 0.0, false, 0.0) });
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
    instance.refused(instance.try_set("Waypoint", &waypoints), words);
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
    let instance = Instance::new();
    instance.must(unsafe { (instance.c.fmi3EnterConfigurationMode)(instance.raw) });
    let mut sizes = [0; 2];
    let names = ["Agents", "Waypoints"].map(reference);
    instance
        .must(unsafe { (instance.c.fmi3GetUInt64)(instance.raw, names.as_ptr(), 2, sizes.as_mut_ptr(), 2) });
    assert_eq!(sizes, [AGENTS as u64, MOST as u64]);
    instance.must(unsafe { (instance.c.fmi3SetUInt64)(instance.raw, names.as_ptr(), 2, [3, 5].as_ptr(), 2) });
    instance.must(unsafe { (instance.c.fmi3ExitConfigurationMode)(instance.raw) });
    let words = "Waypoints is 5, but what is loaded has 3";
    instance.refused(instance.try_set("WaypointRadius", &[0.0; 15]), words);
    instance.must(instance.try_set("Theta", &[0.0; AGENTS]));
}

/// All dependencies of an output: element, value reference, element.
fn listed(instance: &Instance, output: &str) -> Vec<(usize, u32, usize)> {
    let mut count = 0;
    let number = instance.c.fmi3GetNumberOfVariableDependencies;
    instance.must(unsafe { number(instance.raw, reference(output), &mut count) });
    let (mut dependents, mut elements) = (vec![0; count], vec![0; count]);
    let (mut independents, mut kinds) = (vec![0; count], vec![0; count]);
    instance.must(unsafe {
        (instance.c.fmi3GetVariableDependencies)(
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
    let poses = [("Position", vec![4.8, 2.1, -2.7, 1.2, 2.1, 3.8]), ("Theta", vec![0.1, 0.2, 0.3])];
    let parameters = [
        ("Mass", AGENTS),
        ("MomentOfInertia", AGENTS),
        ("FloorDamping", AGENTS),
        ("AngularDamping", AGENTS),
        ("DesiredSpeed", AGENTS),
        ("Waypoint", 2 * MOST * AGENTS),
        ("WaypointRadius", MOST * AGENTS),
    ];
    for initialized in [true, false] {
        let instance = reach(if initialized { StepComplete } else { Initialization });
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
                            instance.log.take();
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

#[test]
fn a_state_remembers_waypoints_and_damaged_bytes_are_refused() {
    let (instance, other) = (Instance::initialized(), Instance::new());
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
        other.refused(other.restore(&damaged), "state");
    }
    assert!(other.bytes() == before);
    other.must(unsafe { (other.c.fmi3Reset)(other.raw) });
    other.initialize();
    assert_eq!(other.integers("NextWaypoint", AGENTS), [0; AGENTS]);
}
