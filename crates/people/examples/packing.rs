//! Measures what density the placing algorithms reach, and in how much processor time:
//! `cargo run --release -p lemons-people --example packing [-- PICTURES]`.
//!
//! If a directory is given, pictures of the placings are written into it.

#[path = "../tests/placing/people.rs"]
mod people;

use lemons_people::Shape;
use lemons_people::placing::{Dense, Orientation, Packing, Paper, Region, dense, measure, paper};
use lemons_plane::{Bounds, Rotation, vec2};
use people::people;
use std::fmt::Write;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::Instant;

/// Returns the processor time of this thread \[s\], or elapsed time where the system does not measure that.
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
            let file = directory.join(format!("packing-{}.png", name.replace([' ', ',', '.', '\''], "-")));
            let png = lemons_picture::png(&picture(shapes, region, &packing), 900).expect("a picture");
            std::fs::write(&file, png).expect("the picture is written");
        }
        packing
    }
}

fn go(shapes: &[Shape], region: &Region, settings: &Dense) -> Packing {
    dense(shapes, region, settings, &mut |_| ControlFlow::Continue(())).expect("good shapes")
}

fn square(side: f64) -> Region {
    Region::rectangle(vec2(0.0, 0.0), vec2(side, side)).expect("a square")
}

fn main() {
    let bench = Bench { start: Instant::now(), pictures: std::env::args().nth(1).map(PathBuf::from) };
    println!("-- the paper's box, 4.56 m: 7.2 per m²");
    for seed in 1..=4 {
        let (shapes, region) = (people(150, seed), square(4.56));
        let settings = Dense { seed, ..Dense::default() };
        bench
            .run(&format!("150 in a box, seed {seed}"), &shapes, &region, || go(&shapes, &region, &settings));
    }
    let (shapes, region) = (people(150, 1), square(4.56));
    for (name, orientation) in [("fixed", Orientation::Fixed(0.0)), ("towards", Orientation::Towards(0.0))] {
        let settings = Dense { orientation, seed: 1, ..Dense::default() };
        bench.run(&format!("150 in a box, {name}"), &shapes, &region, || go(&shapes, &region, &settings));
    }
    for count in [150, 165] {
        let shapes = people(count, 1);
        let settings = Paper { seed: 1, orientation: Orientation::Free, ..Paper::default() };
        bench.run(&format!("{count} in a box, the paper's algorithm"), &shapes, &region, || {
            paper(&shapes, &region, &settings, &mut |_| ControlFlow::Continue(())).expect("good shapes")
        });
    }
    println!("-- open plane: per m² of the convex hull");
    for seed in 1..=3 {
        let (shapes, region) = (people(50, seed), Region::plane());
        for (name, density) in [("at 6.5", Some(6.5)), ("as dense as possible", None)] {
            let settings = Dense { density, seed, ..Dense::default() };
            let name = format!("50 in the open plane {name}, seed {seed}");
            bench.run(&name, &shapes, &region, || go(&shapes, &region, &settings));
        }
    }
    println!("-- an L with a pillar");
    let outer =
        [(0.0, 0.0), (5.0, 0.0), (5.0, 2.0), (1.0, 2.0), (1.0, 4.0), (0.0, 4.0)].map(|(x, y)| vec2(x, y));
    let pillar = [(2.0, 0.6), (2.8, 0.6), (2.8, 1.4), (2.0, 1.4)].map(|(x, y)| vec2(x, y));
    let region = Region::polygon(&outer, &[pillar.to_vec()]).expect("a polygon");
    let settings = Dense { density: Some(7.0), seed: 1, ..Dense::default() };
    bench.run("an L at 7", &shapes, &region, || go(&shapes, &region, &settings));
    println!("-- many");
    let shapes = people(10_000, 1);
    for density in [6.0f64, 8.0, 8.8] {
        let region = square((10_000.0 / density).sqrt());
        let settings = Dense { seed: 1, ..Dense::default() };
        bench.run(&format!("10000 at {density}"), &shapes, &region, || go(&shapes, &region, &settings));
    }
    let settings = Dense { density: Some(6.5), seed: 1, ..Dense::default() };
    let plane = Region::plane();
    bench.run("10000 in the open plane at 6.5", &shapes, &plane, || go(&shapes, &plane, &settings));
    println!("-- the highest density of 150 people in a box, in steps of 0.1 per m²");
    for (name, orientation, first) in [
        ("free", Orientation::Free, 86),
        ("towards", Orientation::Towards(0.0), 86),
        ("fixed", Orientation::Fixed(0.0), 80),
    ] {
        for seed in 1..=3 {
            let shapes = people(150, seed);
            for tenth in first..120 {
                let region = square((1500.0 / f64::from(tenth)).sqrt());
                let settings = Dense { orientation, seed, ..Dense::default() };
                let what = format!("150 {name}, seed {seed}, at {}_{}", tenth / 10, tenth % 10);
                if !bench.run(&what, &shapes, &region, || go(&shapes, &region, &settings)).complete {
                    break;
                }
            }
        }
    }
}

/// An SVG picture in metres, the y axis upwards. The colour shows the orientation of a person.
fn picture(shapes: &[Shape], region: &Region, packing: &Packing) -> String {
    let Bounds { low, high } = region.bounds().unwrap_or_else(|| {
        let far = packing.poses.iter().map(|p| p.position.norm()).fold(0.0, f64::max) + 0.35;
        Bounds { low: vec2(-far, -far), high: vec2(far, far) }
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
        let points: Vec<String> = ring.corners().iter().map(|c| format!("{},{}", c.x, c.y)).collect();
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
