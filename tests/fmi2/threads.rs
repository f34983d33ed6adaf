//! Threads of an instance: the same bits for any number, and none of them left behind.

use crate::fmu::*;
use crate::memory::{alone, does_not_grow};
use std::fmt::Write as _;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// People: of the blocks of 512 that are shared out, three.
const PEOPLE: usize = 1100;

/// The people of the paper's Trial again and again, in rows and nearer to each other than they are wide.
fn crowd() -> (&'static Resources, &'static Model) {
    static CROWD: OnceLock<(Resources, Model)> = OnceLock::new();
    let (resources, model) = CROWD.get_or_init(|| {
        let resources = Resources::new();
        let path = resources.trial().join("static/Agents.xml");
        let text = std::fs::read_to_string(&path).unwrap();
        let people: Vec<&str> =
            text.split("<Agent ").skip(1).map(|agent| agent.split("</Agent>").next().unwrap()).collect();
        let (mut agents, mut dynamics) = ("<Agents>".to_owned(), "<Agents>".to_owned());
        for k in 0..PEOPLE {
            let who = people[k % 5].replacen(&format!("Id=\"{}\"", k % 5), &format!("Id=\"{k}\""), 1);
            write!(agents, "<Agent {who}</Agent>").unwrap();
            let (x, y) = (0.265 * (k % 40) as f64, 0.52 * (k / 40) as f64 + 0.01 * (k % 3) as f64);
            // They walk into each other.
            let push = 600.0 * (k as f64).sin();
            write!(
                dynamics,
                "<Agent Id=\"{k}\"><Kinematics Position=\"{x:.6},{y:.6}\" Velocity=\"0,0\" Theta=\"{:.6}\" \
                 Omega=\"0\"/><Dynamics Fp=\"{push:.6},{:.6}\" Mp=\"0\"/></Agent>",
                0.2 * (k as f64).cos(),
                0.5 * push
            )
            .unwrap();
        }
        std::fs::write(path, agents + "</Agents>").unwrap();
        std::fs::write(resources.trial().join("dynamic/AgentDynamics.xml"), dynamics + "</Agents>").unwrap();
        let geometry = "<Geometry><Dimensions Lx=\"14\" Ly=\"16\"/><Wall Id=\"0\" MaterialId=\"concrete\">\
            <Corner Coordinates=\"-0.2,-1\"/><Corner Coordinates=\"-0.2,15\"/></Wall></Geometry>";
        std::fs::write(resources.trial().join("static/Geometry.xml"), geometry).unwrap();
        let model = Model::of(&resources.trial());
        (resources, model)
    });
    (resources, model)
}

fn start(fmu: &Fmu, threads: i32) -> Instance<'_> {
    let (resources, model) = crowd();
    let mut instance =
        instantiate(fmu, &model.guid, &resources.uri()).unwrap_or_else(|log| panic!("{log:?}"));
    instance.model = model;
    instance.must(instance.set("TimeStepMechanical", 5e-5));
    instance.must(instance.set_integer("Threads", threads));
    instance.enter_initialization();
    // Advice on people who overlap at the start.
    unsafe { (instance.fmu.c.fmi2ExitInitializationMode)(instance.raw) };
    instance.log.take();
    instance
}

/// Of this process.
fn threads_now() -> usize {
    std::fs::read_dir("/proc/self/task").unwrap().count()
}

/// \[s\] The system lists a thread for a moment after whoever joined it has gone on.
const LISTED: u64 = 600;

/// Waits for the system to list no more threads than `expected`, and requires that many.
fn threads_are(expected: usize, what: &str) {
    let end = Instant::now() + Duration::from_secs(LISTED);
    while threads_now() > expected && Instant::now() < end {
        std::thread::sleep(Duration::from_millis(1));
    }
    assert_eq!(threads_now(), expected, "{what}");
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let runs = [1, 2, 3, 64].map(|threads| {
        let instance = start(Fmu::get(), threads);
        instance.steps(0, 3);
        // The number of threads itself.
        instance.must(instance.set("agent[0].Fp.x", 1.0));
        let (reals, mut integers) = instance.everything();
        let own = instance.model.integers.iter().position(|(name, _)| name == "Threads").unwrap();
        assert_eq!(std::mem::take(&mut integers[own]), threads);
        assert!(instance.get_integer("AgentContacts") > 500, "a crowd in which nobody touches shows nothing");
        (reals, integers)
    });
    assert!(runs.iter().all(|run| *run == runs[0]));
}

/// `Threads` is of the state, as every parameter is.
#[test]
fn a_state_of_two_threads_runs_on_like_one_thread() {
    let fmu = Fmu::get();
    let [one, two, other] = [1, 2, 1].map(|threads| start(fmu, threads));
    one.steps(0, 3);
    two.steps(0, 1);
    other.must(other.restore_bytes(&two.bytes()));
    assert_eq!(other.get_integer("Threads"), 2);
    other.steps(1, 3);
    assert_eq!(one.everything().0, other.everything().0);
}

/// A pool is there only where it is asked for and of use, and gone when the instance is.
#[test]
fn threads_end_with_their_instance() {
    if !alone("threads::threads_end_with_their_instance") {
        return;
    }
    let before = threads_now();
    let fmu = Fmu::load(&library_path());
    for _ in 0..10 {
        let (one, two, three) = (start(&fmu, 1), start(&fmu, 2), start(&fmu, 3));
        threads_are(before + 2 + 3, "each instance has its own");
        two.steps(0, 1);
        let state = two.save();
        two.steps(1, 2);
        two.must(unsafe { (fmu.c.fmi2SetFMUstate)(two.raw, state) });
        two.free_state(state);
        threads_are(before + 2 + 3, "a state that is set keeps the threads");
        drop(two);
        threads_are(before + 3, "an instance ends with its threads");
        three.must(unsafe { (fmu.c.fmi2Reset)(three.raw) });
        threads_are(before, "a reset ends them");
        let small = Instance::new(&fmu);
        small.must(small.set_integer("Threads", 8));
        small.push_and_initialize();
        small.steps(0, 1);
        threads_are(before, "five people are not shared out");
        drop(one);
    }
}

/// Threads that outlived the library would run into nothing; and what threads need must not stay behind.
#[test]
fn the_library_may_be_unloaded_right_after() {
    if !alone("threads::the_library_may_be_unloaded_right_after") {
        return;
    }
    crowd();
    // The allocator keeps something for each thread that runs at once, 2 MB of it in unlucky runs; four stacks left
    // behind in each life, or an instance, are 5 MB and more.
    let life = || {
        let life = || {
            let fmu = Fmu::load(&library_path());
            let instance = start(&fmu, 4);
            instance.must(instance.try_step(0.0, 5e-5));
        };
        std::thread::spawn(life).join().expect("the thread ended in order");
    };
    does_not_grow(4 << 20, 150, 50, life);
}
