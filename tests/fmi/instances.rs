//! Instances do not know of each other, nor of the thread that they are called on.

use crate::fmu::*;
use crowd_mechanics::engine::vec2;
use crowd_mechanics::scenes::crowded;
use crowd_mechanics::setup;
use std::sync::OnceLock;
use std::thread;

const STEPS: usize = 14;

#[test]
fn sixty_four_instances_in_eight_threads_with_eight_trials() {
    let resources = Resources::new();
    for k in 1..8 {
        resources.add(&format!("Trial_push_{k}"), &format!("0.27{k},0.030"));
    }
    let start = |thread: usize, k: usize| {
        let crowd = Crowd::on(V2, &resources);
        let name = if k == 0 { "Trial_push".to_owned() } else { format!("Trial_push_{k}") };
        crowd.must(crowd.set_text("Trial", &name));
        let force = 700.0 + 20.0 * thread as f64;
        crowd.must(crowd.set_all(&[("TimeStepMechanical", 2e-5), ("agent[0].Fp.x", force)]));
        crowd.initialize();
        crowd
    };
    let run = |thread: usize| {
        let crowds: Vec<Crowd> = (0..8).map(|k| start(thread, k)).collect();
        for k in 0..STEPS {
            crowds.iter().for_each(|crowd| crowd.steps(k, k + 1));
        }
        crowds.iter().map(Crowd::everything).collect::<Vec<Bits>>()
    };
    let run = &run;
    let together: Vec<Vec<Bits>> = thread::scope(|scope| {
        let threads: Vec<_> = (0..8).map(|thread| scope.spawn(move || run(thread))).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    let mut seen: Vec<&Bits> = Vec::new();
    for (thread, found) in together.iter().enumerate() {
        for (k, found) in found.iter().enumerate() {
            let alone = start(thread, k);
            alone.steps(0, STEPS);
            assert_eq!(*found, alone.everything(), "instance {k} of thread {thread}");
            assert!(!seen.contains(&found), "each differs from all others");
            seen.push(found);
        }
    }
}

/// People: of the blocks of 512 that are shared out, three.
const PEOPLE: usize = 1100;

/// A dense crowd in which people walk into each other.
pub fn large() -> (&'static Resources, &'static Model) {
    static CROWD: OnceLock<(Resources, Model)> = OnceLock::new();
    let (resources, model) = CROWD.get_or_init(|| {
        let resources = Resources::new();
        std::fs::remove_dir_all(resources.trial()).unwrap();
        crowded(setup::read(&paper()).unwrap().0, PEOPLE, vec2(0.285, 0.5))
            .write(&resources.trial())
            .unwrap();
        let model = Model::of(&resources.trial(), V2);
        (resources, model)
    });
    (resources, model)
}

pub fn start_large(fmu: &Fmu, threads: i32) -> Crowd {
    let (resources, model) = large();
    let location = V2.location(&resources.directory());
    let mut crowd = instantiate(fmu, V2, &model.token, &location).unwrap_or_else(|log| panic!("{log:?}"));
    crowd.model = model;
    crowd.must(crowd.set("TimeStepMechanical", 5e-5));
    crowd.must(crowd.try_integer("Threads", threads));
    crowd.enter_initialization();
    // Advice on people who overlap at the start.
    assert_eq!(crowd.exit(), OK);
    crowd.take_messages();
    crowd
}
