//! `lemons crowd` in rooms with doors, and on parts of the ground.

use crate::common::{done, out};
use lemons_core::trial::Trial;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

type Point = (f64, f64);

/// The disks of everybody: centre and radius, by the definition of a pose.
fn disks(trial: &Trial) -> Vec<Vec<(Point, f64)>> {
    let people = trial.agents.iter().zip(&trial.dynamics);
    let disks = people.map(|(agent, moving)| {
        let (sin, cos) = moving.theta.sin_cos();
        let disk = agent.shapes.iter().map(|shape| {
            let (x, y) = (shape.position.x, shape.position.y);
            let at = (moving.position.x + cos * x - sin * y, moving.position.y + sin * x + cos * y);
            (at, shape.radius)
        });
        disk.collect()
    });
    disks.collect()
}

fn read(trial: &Path) -> Trial {
    Trial::read(trial).unwrap().0
}

/// From a point to a segment, by minimizing over the segment's parameter.
fn distance(p: Point, a: Point, b: Point) -> f64 {
    let away = |t: f64| (a.0 + t * (b.0 - a.0) - p.0).hypot(a.1 + t * (b.1 - a.1) - p.1);
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..200 {
        let (l, h) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if away(l) < away(h) { high = h } else { low = l }
    }
    away(0.5 * (low + high))
}

/// The least distance of any disk from any wall.
fn from_walls(trial: &Trial) -> f64 {
    let corner = |place: &lemons_core::plane::Vec2| (place.x, place.y);
    let sides: Vec<(Point, Point)> = trial
        .geometry
        .walls
        .iter()
        .flat_map(|wall| wall.corners.windows(2).map(|side| (corner(&side[0]), corner(&side[1]))))
        .collect();
    let disks = disks(trial).into_iter().flatten();
    disks
        .flat_map(|(at, radius)| sides.iter().map(move |&(a, b)| distance(at, a, b) - radius))
        .fold(f64::INFINITY, f64::min)
}

/// How many have all their disks in a box.
fn within(trial: &Trial, [x0, y0, x1, y1]: [f64; 4]) -> usize {
    let inside = |&((x, y), r): &(Point, f64)| x - r >= x0 && x + r <= x1 && y - r >= y0 && y + r <= y1;
    disks(trial).iter().filter(|disks| disks.iter().all(inside)).count()
}

/// By what `lemons check` knows of overlaps.
fn nobody_overlaps(at: &Path, trial: &str) {
    let said = out(&done(at, &["check", trial]));
    assert!(said.ends_with(": no problem\n"), "{said}");
}

/// A room of 8 m x 6 m with a door of 1 m, a pillar of half a square metre, and a screen through it with two faces.
const ROOM: &str = r#"<Geometry>
<Wall Id="room" MaterialId="concrete"><Corner Coordinates="8,3.5"/><Corner Coordinates="8,6"/>
<Corner Coordinates="0,6"/><Corner Coordinates="0,0"/><Corner Coordinates="8,0"/><Corner Coordinates="8,2.5"/></Wall>
<Wall Id="pillar" MaterialId="concrete"><Corner Coordinates="2,2"/><Corner Coordinates="3,2"/>
<Corner Coordinates="3,3"/><Corner Coordinates="2,2"/></Wall>
<Wall Id="screen" MaterialId="human_clothes"><Corner Coordinates="5,-1"/><Corner Coordinates="5,3.5"/>
<Corner Coordinates="6,4.5"/></Wall></Geometry>"#;

#[test]
fn nobody_stands_across_a_wall() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    fs::write(at.join("room.xml"), ROOM).unwrap();
    let crowds = [("dense", "6", "0"), ("dense", "5", "40"), ("paper", "0.8", "0"), ("grid", "1.2", "70")];
    for (seed, (packing, density, direction)) in crowds.into_iter().enumerate() {
        let seed = seed.to_string();
        let made =
            ["crowd", "--geometry", "room.xml", "--region", "0,0,8,6", "-d", density, "-o", "T", "--force"];
        done(at, &[&made[..], &["--packing", packing, "--direction", direction, "-s", &seed]].concat());
        nobody_overlaps(at, "T");
        let trial = read(&at.join("T"));
        assert_eq!(within(&trial, [0.0, 0.0, 8.0, 6.0]), trial.agents.len());
        assert!(from_walls(&trial) > 0.0, "{packing}: {}", from_walls(&trial));
        // Nor in the pillar, below its diagonal.
        let places = trial.dynamics.iter().map(|moving| (moving.position.x, moving.position.y));
        let in_pillar = |(x, y): &Point| (2.0..3.0).contains(x) && *y > 2.0 && *y < *x;
        assert_eq!(places.filter(in_pillar).count(), 0);
    }
}
