//! `lemons crowd` in rooms with doors, and on parts of the ground.

use crate::common::{assert_code, done, err, lemons, out};
use lemons_trial::Trial;
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
    let corner = |place: &lemons_plane::Vec2| (place.x, place.y);
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
fn eighty_people_in_a_room_with_a_door_leave_by_it() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let room = ["crowd", "-n", "80", "--box", "8x6", "--door", "8,3,1"];
    let made = done(at, &[&room[..], &["-o", "T"]].concat());
    assert_eq!(err(&made), "");
    nobody_overlaps(at, "T");
    let trial = read(&at.join("T"));
    assert_eq!((trial.agents.len(), within(&trial, [0.0, 0.0, 8.0, 6.0])), (80, 80));
    let corners: Vec<Point> = trial.geometry.walls[0].corners.iter().map(|c| (c.x, c.y)).collect();
    let by_hand = [(8.0, 3.5), (8.0, 6.0), (0.0, 6.0), (0.0, 0.0), (8.0, 0.0), (8.0, 2.5)];
    assert_eq!((trial.geometry.walls.len(), &corners[..]), (1, &by_hand[..]));

    let leave = ["--door", "2,0,1.5", "--leave", "--exit", "-3,0,-3,2", "-o", "M", "--zip", "m.zip"];
    let made = done(at, &[&room[..], &leave].concat());
    assert_eq!(err(&made), "");
    let text = "model = \"collision-free-speed\"\n\
                desired_speed = 1.34          # [m/s]\n\
                exits = [\n  \
                { name = \"door 0\", line = [[9.0, 1.5], [9.0, 4.5]] },   # [m]\n  \
                { name = \"door 1\", line = [[0.25, -1.0], [3.75, -1.0]] },   # [m]\n  \
                { name = \"exit 0\", line = [[-3.0, 0.0], [-3.0, 2.0]] },   # [m]\n\
                ]\n";
    assert_eq!(fs::read_to_string(at.join("M/decision.toml")).unwrap(), text);
    let mut archive = zip::ZipArchive::new(fs::File::open(at.join("m.zip")).unwrap()).unwrap();
    let packed = std::io::read_to_string(archive.by_name("M/decision.toml").unwrap()).unwrap();
    assert_eq!(packed, text);
    assert!(read(&at.join("M")).dynamics.iter().all(|moving| moving.fp == lemons_plane::Vec2::ZERO));

    // With a speed and a model; a file that was made so is replaced, one that somebody wrote is not.
    let again = ["--leave", "--speed", "0.8", "--model", "social-force", "-o", "M"];
    let made = done(at, &[&room[..], &again, &["--fmu", "m.fmu"]].concat());
    let said = err(&made);
    assert!(said.starts_with("note: decision.toml is not in m.fmu") && said.lines().count() == 2, "{said}");
    assert!(said.contains("note: M was another Trial before"), "{said}");
    let text = fs::read_to_string(at.join("M/decision.toml")).unwrap();
    assert!(text.starts_with("model = \"social-force\"\ndesired_speed = 0.8 "), "{text}");
    assert!(read(&at.join("M")).dynamics.iter().all(|moving| moving.fp == lemons_plane::Vec2::ZERO));
    fs::write(at.join("M/decision.toml"), "mine").unwrap();
    let refused = lemons(at, &[&room[..], &again].concat());
    assert_code(&refused, 1);
    assert!(err(&refused).contains("decision.toml"), "{}", err(&refused));
    assert_eq!(fs::read_to_string(at.join("M/decision.toml")).unwrap(), "mine");
    // Without --leave it stays, and that is said.
    let made = done(at, &[&room[..], &["-o", "M"]].concat());
    assert!(err(&made).contains("decision.toml of the Trial that was there stays"), "{}", err(&made));
}

#[test]
fn regions_have_their_own_densities() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    fs::write(at.join("room.xml"), ROOM.replace("</Geometry>", "</Geometry>\n")).unwrap();
    fn make<'a>(trial: &'a str, regions: &[&'a str]) -> Vec<&'a str> {
        let regions = regions.iter().flat_map(|region| ["--region", region]);
        ["crowd", "--geometry", "room.xml", "-o", trial].into_iter().chain(regions).collect()
    }
    let made = done(at, &make("T", &["0,0,4,6; number=40", "4,0 8,0 8,6 4,6; density=3"]));
    // 24 m² less the pillar's 0.5 m²; 24 m² at 3 per m².
    let said = out(&made);
    assert!(said.contains("  region 0             23.500 m²   40 people"), "{said}");
    assert!(said.contains("  region 1             24.000 m²   72 people, 3.000 /m²"), "{said}");
    assert!(said.contains("obstacle pillar") && said.contains("open walls room, screen"), "{said}");
    assert!(said.lines().all(|line| line.chars().count() <= 80), "{said}");
    nobody_overlaps(at, "T");
    let trial = read(&at.join("T"));
    assert_eq!(within(&trial, [0.0, 0.0, 4.0, 6.0]), 40);
    assert_eq!(within(&trial, [4.0, 0.0, 8.0, 6.0]), 72);
    // The walls are those of the file.
    let walls: Vec<(&str, &str, usize)> =
        trial.geometry.walls.iter().map(|wall| (&*wall.id, &*wall.material_id, wall.corners.len())).collect();
    assert_eq!(walls, [("room", "concrete", 6), ("pillar", "concrete", 4), ("screen", "human_clothes", 3)]);
    done(at, &make("U", &["0,0,4,6; number=40", "4,0 8,0 8,6 4,6; density=3"]));
    for file in ["static/Agents.xml", "static/Geometry.xml", "dynamic/AgentDynamics.xml"] {
        assert!(fs::read(at.join("T").join(file)).unwrap() == fs::read(at.join("U").join(file)).unwrap());
    }

    // By area; the ground that two share belongs to the first: 6 m² and 42 − 0.5 m².
    let shared = [&make("S", &["6,0,8,3", "0,0,8,6"])[..], &["-n", "95"]].concat();
    let said = out(&done(at, &shared));
    assert!(said.contains("  region 0              6.000 m²   12 people"), "{said}");
    assert!(said.contains("  region 1             41.500 m²   83 people"), "{said}");
    nobody_overlaps(at, "S");
    assert_eq!(within(&read(&at.join("S")), [6.0, 0.0, 8.0, 3.0]), 12);
}

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

/// The area for PedPy, by the closed form of the rooms without their openings.
#[test]
fn a_room_with_doors_is_a_walkable_area() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let room = ["crowd", "-n", "20", "--box", "8x6", "-o", "T", "--door", "8,3,1", "--door", "8,0,0.8"];
    done(at, &room);
    // The second door goes round a corner: its line cuts off half of 0.4 m x 0.4 m. The corridor of Trial_door is open
    // at its end.
    let door = crate::common::root().join("resources/Trial_door");
    let by_hand = [(at.join("T"), 48.0 - 0.08), (door, 25.0 + 0.2 * 0.9 + 8.8 * 2.0)];
    for (trial, expected) in by_hand {
        let trial = read(&trial);
        let places = trial.dynamics.iter().map(|moving| moving.position);
        let area = lemons_record::walkable_area(&trial.geometry.walls, places);
        assert!(
            area.said[0].contains("closed by") && !area.said[0].contains("bounding box"),
            "{:?}",
            area.said
        );
        let rings = lemons_plane::polygon_from_wkt(&area.wkt).unwrap();
        assert_eq!(rings.len(), 1, "{}", area.wkt);
        assert!((rings[0].area() - expected).abs() < 1e-9, "{} {}", rings[0].area(), area.wkt);
    }
}

#[test]
fn mistakes_in_rooms_are_named() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    fs::write(at.join("room.xml"), ROOM).unwrap();
    let room = ["--geometry", "room.xml"];
    let cases: [(&[&str], i32, &str); 16] = [
        (&["-n", "5"], 1, "wall room is not closed"),
        (&["-n", "5"], 1, "for example --region 0,-1,8,6"),
        (&["-n", "5", "--door", "0,3,1"], 1, "close it, and give its opening as a --door, too"),
        (&["--region", "0,0,8,6", "-n", "5", "--door", "2.5,1.9,1"], 1, "is pillar, an obstacle"),
        (&["--region", "0,0,8,6"], 2, "the number of people is missing in region 0 of room.xml"),
        (&["--region", "0,0,8"], 2, "two opposite corners"),
        (&["--region", "0,0 8,0 8"], 2, "the corners of a polygon"),
        (&["--region", "0,0,8,6; people=3"], 2, "after ; stands number=N or density=D"),
        (&["--region", "0,0,8,6; density=0"], 2, "density: must be a number from 0.000001 to 100"),
        (&["--region", "0,0,8,6; number=3", "-n", "5"], 2, "--number: each --region says itself"),
        (&["--region", "2.4,2.1,2.9,2.3", "--density", "9"], 1, "1 people in region 0"),
        (&["--region", "0,0 4,4 4,0 0,3", "-n", "5"], 1, "edge 0 of the outer polygon"),
        (&["--region", "0,0,8,6", "-n", "5", "--door", "9,9,1"], 1, "door 0 at (9, 9) m is"),
        (&["--region", "0,0,8,6", "-n", "5", "--door", "8,3,0"], 2, "the width is from 0.1 to 1000"),
        (&["--region", "0,0,8,6", "-n", "5", "--leave"], 2, "there is no way out: give --door"),
        (&["--region", "0,0,8,6", "-n", "5", "--model", "straight"], 2, "--leave"),
    ];
    for (arguments, code, words) in cases {
        let refused = lemons(at, &[&["crowd", "-o", "T"], &room[..], arguments].concat());
        assert_eq!(refused.status.code(), Some(code), "{arguments:?} {}", err(&refused));
        assert!(err(&refused).contains(words), "{arguments:?} {}", err(&refused));
        assert!(!at.join("T").exists());
    }
    let open = lemons(at, &["crowd", "-n", "5", "--door", "1,1,1", "-o", "T"]);
    assert_code(&open, 2);
    assert!(err(&open).contains("--door: there is no closed wall in the open"), "{}", err(&open));
    let nowhere =
        lemons(at, &["crowd", "-n", "5", "--box", "4x4", "--door", "4,2,1", "--leave", "--fmu", "a.fmu"]);
    assert_code(&nowhere, 2);
    assert!(err(&nowhere).contains("give -o TRIAL or --zip FILE.zip"), "{}", err(&nowhere));
}

/// A door of 1 m in a corner has half of its width on each of two walls.
#[test]
fn a_door_that_goes_round_a_corner_is_told() {
    let directory = TempDir::new().unwrap();
    let made = |door: &str| {
        let words = ["crowd", "-n", "3", "--box", "4x3", "--door", door, "--leave", "-o", "room", "--force"];
        err(&done(directory.path(), &words))
    };
    assert!(made("4,0.2,1").contains("note: --door 4,0.2,1: door 0 goes round a corner"));
    let said = made("4,0.6,1");
    assert_eq!(
        said,
        "note: room was another Trial before: tables and other results made from that one no longer fit\n"
    );
    assert!(made("4,1.5,0.3").contains("door 0 is 0.3 m wide: people are about 0.5 m broad"));
}

/// A hall of 8 m x 6 m and, in it, something of 1.5 m x 2 m: a pillar or a smaller room.
const HALL: &str = r#"<Geometry>
<Wall Id="hall" MaterialId="concrete"><Corner Coordinates="0,0"/><Corner Coordinates="8,0"/>
<Corner Coordinates="8,6"/><Corner Coordinates="0,6"/><Corner Coordinates="0,0"/></Wall>
<Wall Id="inner" MaterialId="concrete"><Corner Coordinates="6,2"/><Corner Coordinates="7.5,2"/>
<Corner Coordinates="7.5,4"/><Corner Coordinates="6,4"/><Corner Coordinates="6,2"/></Wall></Geometry>"#;

/// It opened the pillar: people left into it.
#[test]
fn a_door_is_in_a_wall_of_a_room_that_people_stand_in() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    fs::write(at.join("hall.xml"), HALL).unwrap();
    let hall = ["crowd", "--geometry", "hall.xml", "-o", "T", "--force"];
    let walls = || {
        let trial = read(&at.join("T"));
        let closed = |wall: &lemons_trial::Wall| wall.corners.first() == wall.corners.last();
        trial.geometry.walls.iter().map(|wall| (wall.id.clone(), closed(wall))).collect::<Vec<_>>()
    };
    let ground: [&[&str]; 2] = [&["-n", "5"], &["-n", "5", "--region", "0,0,8,6"]];
    for ground in ground {
        let refused = lemons(at, &[&hall[..], ground, &["--door", "7.6,3,1"]].concat());
        assert_code(&refused, 1);
        let said = err(&refused);
        assert!(
            said.starts_with("lemons: --door 7.6,3,1: the nearest closed wall is inner, an obstacle"),
            "{said}"
        );
        // What it proposes does.
        assert!(said.ends_with("in wall hall it is --door 8,3,1\n"), "{said}");
        done(at, &[&hall[..], ground, &["--door", "8,3,1", "--leave"]].concat());
        assert_eq!(walls(), [("hall".into(), false), ("inner".into(), true)]);
    }
    // People in the smaller room, or in both.
    for regions in [
        &["--region", "6,2,7.5,4;number=2"][..],
        &["--region", "6,2,7.5,4;number=2", "--region", "0,0,8,6;number=5"],
    ] {
        done(at, &[&hall[..], regions, &["--door", "7.6,3,1"]].concat());
        assert_eq!(walls(), [("hall".into(), true), ("inner".into(), false)]);
    }
}

/// The advice was --region, with which there was no closed wall either.
#[test]
fn what_is_proposed_for_a_door_beside_an_opening_does() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let open = r#"<Geometry><Wall Id="hall" MaterialId="concrete"><Corner Coordinates="8,2.5"/><Corner Coordinates="8,0"/>
        <Corner Coordinates="0,0"/><Corner Coordinates="0,6"/><Corner Coordinates="8,6"/><Corner Coordinates="8,3.5"/>
        </Wall></Geometry>"#;
    let closed = open.replace("</Wall>", "<Corner Coordinates=\"8,2.5\"/></Wall>");
    fs::write(at.join("open.xml"), open).unwrap();
    fs::write(at.join("closed.xml"), closed).unwrap();
    let door = ["--door", "0,3,1", "--leave", "-n", "5", "-o", "T"];
    for region in [&[][..], &["--region", "0,0,8,6"]] {
        let said = err(&lemons(at, &[&["crowd", "--geometry", "open.xml"][..], region, &door].concat()));
        let advice =
            ["repeat", "give its opening as a --door, too; or leave out --door: --region takes walls"];
        assert!(advice.iter().all(|words| said.contains(words)), "{said}");
    }
    done(at, &[&["crowd", "--geometry", "closed.xml", "--door", "8,3,1"][..], &door].concat());
    let region = ["--region", "0,0,8,6", "--leave", "--exit", "9,1.5,9,4.5", "-n", "5", "-o", "U"];
    done(at, &[&["crowd", "--geometry", "open.xml"][..], &region].concat());
    for trial in ["T", "U"] {
        nobody_overlaps(at, trial);
    }
}
