//! Writes the mean man and the mean woman of the US Army ANSUR II survey (2012) side by side: `bodies.obj` and
//! `bodies.geojson` (slices every 5 cm), into the given directory.
//!
//! `cargo run --release -p lemons-people --example bodies -- DIRECTORY`

use lemons_people::{Body3d, Person, Placed, Sex, crowd_parts, section, write_geojson, write_obj};
use lemons_plane::{Pose, vec2};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let directory = PathBuf::from(std::env::args_os().nth(1).ok_or("which directory?")?);
    let man = Person { sex: Sex::Male, breadth: 0.5104, depth: 0.2539, stature: 1.7562, mass: 85.5 };
    let woman = Person { sex: Sex::Female, breadth: 0.4503, depth: 0.2474, stature: 1.6285, mass: 67.8 };
    let bodies = [Body3d::of(&man)?, Body3d::of(&woman)?];
    let crowd: Vec<Placed> = bodies
        .iter()
        .enumerate()
        .map(|(k, body)| Placed {
            body,
            pose: Pose { position: vec2(0.0, 0.8 * k as f64), orientation: 0.0 },
        })
        .collect();
    let mut obj = BufWriter::new(File::create(directory.join("bodies.obj"))?);
    write_obj(crowd_parts(&crowd), &mut obj)?;
    obj.flush()?;
    let sections: Vec<_> = (0..=35).map(|k| section(&crowd, 0.05 * f64::from(k))).collect();
    let mut geojson = BufWriter::new(File::create(directory.join("bodies.geojson"))?);
    write_geojson(&sections, &mut geojson)?;
    geojson.flush()?;
    for body in &bodies {
        println!("{:?}: {:.4} m³, girth factor {:.3}", body.person().sex, body.volume(), body.girth_factor());
    }
    Ok(())
}
