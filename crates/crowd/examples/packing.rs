//! What the packers reach, in processor time: `cargo run --release -p lemons-crowd --example packing [-- PICTURES]`.
//!
//! With a directory, pictures of the placings are written into it.

#[path = "../tests/placing/people.rs"]
mod people;

use crowd_mechanics::engine::{Rotation, vec2};
use lemons_crowd::Shape;
use lemons_crowd::placing::{Dense, Orientation, Packing, Paper, Region, dense, measure, paper};
use people::people;
use std::fmt::Write;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::Instant;

/// \[s\] of this thread on a processor; where the system does not tell, of the clock.
fn processor_time(start: Instant) -> f64 {
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = told.and_then(|t| t.split(' ').next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(|| start.elapsed().as_secs_f64(), |ns| ns * 1e-9)
}

struct Bench {
    start: Instant,
    pictures: Option<PathBuf>,
}

impl Bench {
    fn run(&self, name: &str, shapes: &[Shape], region: &Region, pack: impl FnOnce() -> Packing) -> Packing {
        let begin = processor_time(self.start);
        let packing = pack();
        let seconds = processor_time(self.start) - begin;
        let measured = measure(&shapes[..packing.poses.len()], region, &packing.poses);
        println!(
            "{name:<44} {:>6.3} /m² (clear {:>6.3})  overlap {:>7.4} mm  pairs {:>3}  walls {:>2}  {:>6} iterations {seconds:>7.2} s  {:?}{}",
            packing.density,
            packing.clear_density,
            1e3 * measured.largest_overlap,
            measured.overlapping_pairs,
            measured.through_boundary,
            packing.iterations,
            packing.ended,
            if packing.complete { "" } else { " INCOMPLETE" },
        );
        if let Some(directory) = &self.pictures {
            let file = directory.join(format!("packing-{}.png", name.replace([' ', ',', '.', '/'], "_")));
            let png = lemons_picture::png(&picture(shapes, region, &packing), 900).expect("a picture");
            std::fs::write(&file, png).expect("the picture is written");
        }
        packing
    }
}

fn main() {
    let pictures = std::env::args().nth(1).map(PathBuf::from);
    let bench = Bench { start: Instant::now(), pictures };
    let go = |shapes: &[Shape], region: &Region, settings: &Dense| {
        dense(shapes, region, settings, &mut |_| ControlFlow::Continue(())).expect("good shapes")
    };
    let square = |side: f64| Region::rectangle(vec2(0.0, 0.0), vec2(side, side)).expect("a square");
    let which = std::env::args().nth(2).unwrap_or_default();
    let wanted = |part: &str| which.is_empty() || which.contains(part);
    let free = Orientation::Free;
    if wanted("1") {
        for seed in 1..=4 {
            let (shapes, region) = (people(150, seed), square(4.56));
            let settings = Dense { seed, ..Dense::default() };
            bench.run(&format!("150 in 4.56 m, seed {seed}"), &shapes, &region, || {
                go(&shapes, &region, &settings)
            });
        }
        let (shapes, region) = (people(150, 1), square(4.56));
        let settings = Dense { orientation: Orientation::Fixed(0.0), seed: 1, ..Dense::default() };
        bench.run("150 in 4.56 m, fixed", &shapes, &region, || go(&shapes, &region, &settings));
        let settings = Paper { seed: 1, ..Paper::default() };
        bench.run("150 in 4.56 m, paper", &shapes, &region, || {
            paper(&shapes, &region, &settings, &mut |_| ControlFlow::Continue(())).expect("good shapes")
        });
    }
    if wanted("2") {
        for seed in 1..=3 {
            let (shapes, region) = (people(50, seed), Region::plane());
            for density in [Some(2.0), Some(6.5), None] {
                let settings = Dense { density, seed, ..Dense::default() };
                let name = format!("50 in the open, {density:?}, seed {seed}");
                bench.run(&name, &shapes, &region, || go(&shapes, &region, &settings));
            }
        }
    }
    if wanted("3") {
        let (shapes, region) = (people(10_000, 1), square((10_000.0f64 / 6.0).sqrt()));
        let settings = Dense { seed: 1, ..Dense::default() };
        bench.run("10000 at 6", &shapes, &region, || go(&shapes, &region, &settings));
    }
    if wanted("5") {
        for count in [1000, 10_000] {
            let settings = Dense { density: Some(6.5), seed: 1, ..Dense::default() };
            let shapes = people(count, 1);
            bench.run(&format!("{count} in the open at 6.5"), &shapes, &Region::plane(), || {
                go(&shapes, &Region::plane(), &settings)
            });
            let region = square((count as f64 / 8.8).sqrt());
            let settings = Dense { seed: 1, ..Dense::default() };
            bench.run(&format!("{count} at 8.8"), &shapes, &region, || go(&shapes, &region, &settings));
        }
    }
    if wanted("6") {
        for density in [9.2, 9.5, 10.0, 10.4] {
            let shapes = people(150, 1);
            let region = square((150.0 / density as f64).sqrt());
            let settings = Dense { seed: 1, ..Dense::default() };
            bench.run(&format!("150 at {density}"), &shapes, &region, || go(&shapes, &region, &settings));
        }
    }
    if wanted("4") {
        for orientation in [free, Orientation::Towards(0.0), Orientation::Fixed(0.0)] {
            for seed in 1..=3 {
                let shapes = people(150, seed);
                let mut reached = 0.0;
                for tenth in 84..110 {
                    let density = 0.1 * f64::from(tenth);
                    let region = square((150.0 / density).sqrt());
                    let settings = Dense { orientation, seed, ..Dense::default() };
                    let name = format!("150, {orientation:?}, seed {seed}, {density:.1} per m²");
                    if !bench.run(&name, &shapes, &region, || go(&shapes, &region, &settings)).complete {
                        break;
                    }
                    reached = density;
                }
                println!("most for 150 people in a box, {orientation:?}, seed {seed}: {reached:.1} /m²");
            }
        }
    }
}

/// In metres, the y axis upwards; a colour for each person, by the turn.
fn picture(shapes: &[Shape], region: &Region, packing: &Packing) -> String {
    let (low, high) = region.bounds().unwrap_or_else(|| {
        let far = packing.poses.iter().map(|p| p.position.norm()).fold(0.0, f64::max) + 0.35;
        (vec2(-far, -far), vec2(far, far))
    });
    let (wide, tall) = (high.x - low.x, high.y - low.y);
    let margin = 0.02 * wide;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"900\" height=\"{}\" viewBox=\"{} {} {} {}\">\
         <rect x=\"-1e4\" y=\"-1e4\" width=\"2e4\" height=\"2e4\" fill=\"white\"/><g transform=\"scale(1,-1)\">",
        900.0 * (tall + 2.0 * margin) / (wide + 2.0 * margin),
        low.x - margin,
        -high.y - margin,
        wide + 2.0 * margin,
        tall + 2.0 * margin
    );
    let draw = |svg: &mut String, text: std::fmt::Arguments| svg.write_fmt(text).expect("a string takes all");
    for ring in region.rings() {
        let points: Vec<String> = ring.iter().map(|c| format!("{},{}", c.x, c.y)).collect();
        let line = 0.002 * wide;
        draw(
            &mut svg,
            format_args!(
                "<polygon points=\"{}\" fill=\"none\" stroke=\"black\" stroke-width=\"{line}\"/>",
                points.join(" ")
            ),
        );
    }
    for (shape, pose) in shapes.iter().zip(&packing.poses) {
        let turn = Rotation::by(pose.orientation);
        let hue = (pose.orientation.to_degrees() + 360.0) % 360.0;
        draw(&mut svg, format_args!("<g fill=\"hsl({hue:.0},55%,62%)\" fill-opacity=\"0.75\">"));
        for disk in &shape.disks {
            let at = pose.position + disk.centre.rotated(turn);
            draw(&mut svg, format_args!("<circle cx=\"{}\" cy=\"{}\" r=\"{}\"/>", at.x, at.y, disk.radius));
        }
        let nose = pose.position + vec2(0.09, 0.0).rotated(turn);
        draw(
            &mut svg,
            format_args!("<circle cx=\"{}\" cy=\"{}\" r=\"0.02\" fill=\"black\"/></g>", nose.x, nose.y),
        );
    }
    svg + "</g></svg>"
}
