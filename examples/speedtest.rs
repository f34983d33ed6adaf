#![allow(missing_docs)]
use crowd_mechanics::trial::Trial;
use std::time::Instant;
fn cpu() -> f64 {
    let t = std::fs::read_to_string("/proc/self/schedstat").unwrap();
    t.split(' ').next().unwrap().parse::<f64>().unwrap() * 1e-9
}
fn main() {
    let path = std::env::args().nth(1).unwrap();
    let steps: f64 = std::env::args().nth(2).unwrap().parse().unwrap();
    let (trial, _) = Trial::read(std::path::Path::new(&path)).unwrap();
    let mut w = trial.world().unwrap();
    let dt = w.mechanical_step;
    let n = trial.agents.len() as f64;
    w.advance(dt * steps).unwrap();
    let mut best = f64::MAX;
    for _ in 0..7 {
        let before = *w.work();
        let (t, c) = (Instant::now(), cpu());
        w.advance(dt * steps).unwrap();
        let (t, c) = (t.elapsed().as_secs_f64(), cpu() - c);
        let k = *w.work();
        best = best.min(c / n / steps);
        println!(
            "dt {dt} ns/agent-step wall {:.1} cpu {:.1}; pairs/agent {:.2} contacts {:.2} sliding {:.2} rebuilds {} shortlisted {}",
            t / n / steps * 1e9,
            c / n / steps * 1e9,
            (k.pairs - before.pairs) as f64 / n / steps,
            (k.contacts - before.contacts) as f64 / n / steps,
            (k.sliding - before.sliding) as f64 / n / steps,
            k.rebuilds - before.rebuilds,
            k.shortlisted - before.shortlisted
        );
    }
    println!("best {:.1}", best * 1e9);
}
