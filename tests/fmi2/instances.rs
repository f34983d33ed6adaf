//! Instances do not know of each other, nor of the thread that they are called on.

use crate::fmu::*;
use std::thread;

const STEPS: usize = 14;

fn start(force: f64) -> Instance<'static> {
    let instance = Instance::new(Fmu::get());
    instance.must(instance.set_all(&[("TimeStepMechanical", 2e-5), ("agent[0].Fp.x", force)]));
    instance.initialize();
    instance
}

fn alone(force: f64) -> Bits {
    let instance = start(force);
    instance.steps(0, STEPS);
    instance.everything()
}

#[test]
fn interleaved_instances_give_what_each_gives_alone() {
    let (a, b) = (start(700.0), start(900.0));
    for k in 0..STEPS {
        a.steps(k, k + 1);
        b.steps(k, k + 1);
    }
    let (one, other) = (a.everything(), b.everything());
    assert_ne!(one, other);
    assert_eq!((one, other), (alone(700.0), alone(900.0)));
}

/// Eight Trials in one FMU; in each, agent 1 stands elsewhere.
fn eight_trials() -> Resources {
    let resources = Resources::new();
    for k in 1..8 {
        let other = resources.directory().join(format!("Trial_push_{k}"));
        copy_tree(&paper(), &other);
        let dynamics = other.join("dynamic/AgentDynamics.xml");
        let text = std::fs::read_to_string(&dynamics).unwrap();
        assert!(text.contains("0.279,0.030"));
        std::fs::write(dynamics, text.replace("0.279,0.030", &format!("0.27{k},0.030"))).unwrap();
    }
    resources
}

#[test]
fn sixty_four_instances_in_eight_threads_with_eight_trials() {
    let resources = eight_trials();
    let uri = resources.uri();
    let start = |thread: usize, k: usize| {
        let instance =
            instantiate(Fmu::get(), &Model::paper().guid, &uri).unwrap_or_else(|log| panic!("{log:?}"));
        let name = if k == 0 { "Trial_push".to_owned() } else { format!("Trial_push_{k}") };
        instance.must(instance.set_string("Trial", &name));
        let force = 700.0 + 20.0 * thread as f64;
        instance.must(instance.set_all(&[("TimeStepMechanical", 2e-5), ("agent[0].Fp.x", force)]));
        instance.initialize();
        instance
    };
    let alone = |thread: usize, k: usize| {
        let instance = start(thread, k);
        instance.steps(0, STEPS);
        instance.everything()
    };
    let together: Vec<Vec<Bits>> = thread::scope(|scope| {
        let threads: Vec<_> = (0..8)
            .map(|thread| {
                let start = &start;
                scope.spawn(move || {
                    let instances: Vec<Instance> = (0..8).map(|k| start(thread, k)).collect();
                    for k in 0..STEPS {
                        instances.iter().for_each(|instance| instance.steps(k, k + 1));
                    }
                    instances.iter().map(Instance::everything).collect()
                })
            })
            .collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    let mut seen: Vec<&Bits> = Vec::new();
    for (thread, found) in together.iter().enumerate() {
        for (k, found) in found.iter().enumerate() {
            assert_eq!(*found, alone(thread, k), "instance {k} of thread {thread}");
            assert!(!seen.contains(&found), "each differs from all others");
            seen.push(found);
        }
    }
}

#[test]
fn instances_move_between_threads() {
    let mut instance = thread::spawn(|| start(700.0)).join().unwrap();
    for k in 0..STEPS {
        instance = thread::spawn(move || {
            instance.steps(k, k + 1);
            instance
        })
        .join()
        .unwrap();
    }
    let found = instance.everything();
    thread::spawn(move || drop(instance)).join().unwrap();
    assert_eq!(found, alone(700.0));
}

/// One's failure is not another's.
#[test]
fn a_neighbour_in_the_error_state_does_not_matter() {
    let (good, bad) = (start(700.0), Instance::new(Fmu::get()));
    bad.must(bad.set_all(&[("agent[0].Mass", 1e-300), ("agent[0].Fp.x", 1e300)]));
    bad.initialize();
    good.steps(0, 7);
    bad.refused(bad.try_step(0.0, STEP));
    drop(bad);
    good.steps(7, STEPS);
    assert_eq!(good.everything(), alone(700.0));
}
