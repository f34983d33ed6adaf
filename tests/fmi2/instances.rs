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

#[test]
fn eight_threads_of_four_instances() {
    let force = |k: u32| 700.0 + 50.0 * f64::from(k % 4);
    let expected: Vec<Bits> = (0..4).map(|k| alone(force(k))).collect();
    thread::scope(|scope| {
        for _ in 0..8 {
            scope.spawn(|| {
                let instances: Vec<Instance> = (0..4).map(|k| start(force(k))).collect();
                for k in 0..STEPS {
                    instances.iter().for_each(|instance| instance.steps(k, k + 1));
                }
                let found: Vec<Bits> = instances.iter().map(Instance::everything).collect();
                assert_eq!(found, expected);
            });
        }
    });
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
