//! Bits of many crowds.
use lemons_core::plane::{Pose, vec2};
use lemons_people::placing::{Method, Orientation, Region, Settings};
use lemons_people::*;
use std::ops::ControlFlow;

fn main() {
    let outer =
        [(0.0, 0.0), (9.0, 0.0), (9.0, 4.0), (3.0, 4.0), (3.0, 8.0), (0.0, 8.0)].map(|(x, y)| vec2(x, y));
    let hole = [(4.0, 1.0), (5.0, 1.0), (5.0, 2.0), (4.0, 2.0)].map(|(x, y)| vec2(x, y));
    let regions = [
        ("l", Region::polygon(&outer, &[hole.to_vec()]).unwrap()),
        ("plane", Region::plane()),
        ("sparse", Region::rectangle(vec2(0.0, 0.0), vec2(60.0, 40.0)).unwrap()),
    ];
    for seed in 0..6u64 {
        let proportions = Proportions { men: 0.4, pedestrians: if seed == 3 { 0.8 } else { 1.0 } };
        let source = if seed % 2 == 0 {
            Source::ansur().unwrap()
        } else {
            Source::custom(
                &Custom::from_toml(
                    "[male]\nspearman = [[1,0.9,-0.9,0],[0.9,1,0.9,0],[-0.9,0.9,1,0],[0,0,0,1]]",
                )
                .unwrap()
                .people,
            )
            .unwrap()
        };
        let population = Population::new(source, proportions, PAPER_BICYCLES).unwrap();
        for (name, region) in &regions {
            for method in Method::ALL {
                for orientation in [Orientation::Free, Orientation::Towards(0.4), Orientation::Fixed(1.0)] {
                    let count = if *name == "sparse" {
                        120
                    } else if method == Method::Dense {
                        60
                    } else {
                        40
                    };
                    let agents: Vec<Agent> = population.agents(seed).take(count).collect();
                    let shapes: Vec<Shape> = agents.iter().map(|a| a.shape().unwrap()).collect();
                    let density = (*name == "plane" && method == Method::Dense).then_some(if seed % 2 == 0 {
                        0.3
                    } else {
                        5.0
                    });
                    let settings = Settings { orientation, seed, density, limit: Some(3000) };
                    let packed = method.place(&shapes, region, &settings, &mut |_| ControlFlow::Continue(()));
                    let Ok(packing) = packed else {
                        println!("{seed} {name} {method:?} {orientation:?} refused");
                        continue;
                    };
                    let bits = |p: &Pose| [p.position.x, p.position.y, p.orientation].map(f64::to_bits);
                    let fold = packing.poses.iter().flat_map(bits).fold(0u64, |m, b| m.rotate_left(7) ^ b);
                    println!(
                        "{seed} {name} {method:?} {orientation:?} {fold:016x} {:?} {:?} {:?} {}",
                        packing.density, packing.clear_density, packing.largest_overlap, packing.iterations
                    );
                }
            }
        }
        for agent in population.agents(seed).take(20).filter_map(Agent::pedestrian) {
            if let Ok(body) = Body3d::of(&agent) {
                let all = body
                    .mesh()
                    .into_iter()
                    .flat_map(|p| p.vertices)
                    .flatten()
                    .fold(0u64, |m, v| m.rotate_left(5) ^ v.to_bits());
                println!("body {all:016x} {:?}", section(&[(&body, Pose::default())], 1.0).covered());
            }
        }
    }
}
