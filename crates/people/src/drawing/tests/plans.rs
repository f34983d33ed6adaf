//! Plans as architects draw them, against areas and doors that are known by hand.

use super::made::{PlanBuilder, Random, hall};
use super::*;
use crate::Door;
use lemons_core::plane::vec2;
use std::fmt::Write;

fn drawing(dxf: &str) -> Drawing {
    Drawing::read(DrawingFormat::Dxf, dxf.as_bytes(), &Reading::default()).unwrap()
}

fn proposal(dxf: &str) -> Proposal {
    Proposal::of(&drawing(dxf), &[], None, None).unwrap().unwrap()
}

#[test]
fn plans_of_architects_have_the_areas_and_doors_that_are_known() {
    for seed in 0..300 {
        let known = hall(seed);
        let found = proposal(&known.dxf);
        let say = || format!("seed {seed}: {:#?}", found.messages());
        // 1 mm along the rim, for rounding in the file.
        assert!(
            (found.areas[0] - known.area).abs() < 0.05,
            "{} for {}; {}",
            found.areas[0],
            known.area,
            say()
        );
        let obstacles = found.areas[0] - found.areas[1];
        // Straight pieces are inside of arcs.
        assert!((obstacles - known.obstacles).abs() < 0.05 * known.obstacles, "{obstacles}; {}", say());
        let (doors, mut left) = (found.doors(), known.doors.clone());
        left.retain(|(at, width)| {
            !doors.iter().any(|door: &Door| (door.at - at).norm() < 2e-3 && (door.width - width).abs() < 2e-3)
        });
        assert!(left.is_empty() && doors.len() == known.doors.len(), "left {left:?}; {}", say());
        let count = |kind: &str| found.gaps.iter().filter(|gap| gap.kind() == kind).count();
        assert_eq!((count("passage"), count("window")), (known.passages, known.windows), "{}", say());
        assert!(found.gaps.iter().all(|gap| gap.kind() != "door" || gap.leaves > 0), "{}", say());
        let thickest = found.thicknesses.first().unwrap().0;
        assert!((thickest - known.thickness).abs() < 2e-3, "{thickest} for {}; {}", known.thickness, say());
        assert_eq!(found.close.is_some(), known.small_gap, "{}", say());
        assert_eq!(found.flights.len(), usize::from(known.stairs), "{}", say());
        // What the options take is what was proposed.
        let settings = PlanSettings {
            close: found.close,
            walls: found.walls.clone(),
            enclosing: Some(found.enclosing.clone()),
            ..PlanSettings::default()
        };
        let mut plan = FloorPlan::of(drawing(&known.dxf), &settings).unwrap();
        assert!((plan.area().unwrap() - found.areas[1]).abs() < 1e-6, "{}", say());
        doors.iter().for_each(|door| plan.add_door(door).unwrap());
        assert_eq!(plan.doors().len(), doors.len(), "{}", say());
        // Without them, nobody guesses.
        let read =
            Read::of(DrawingFormat::Dxf, known.dxf.as_bytes(), &Reading::default(), &PlanSettings::default());
        assert!(read.unwrap().doubt.is_some(), "{}", say());
    }
}

/// A DXF in m of closed and open lines on layers, and swings that hang at a place and are shut at another.
fn drawn(lines: &[(&str, &[[f64; 2]], bool)], swings: &[([f64; 2], [f64; 2])]) -> String {
    let mut plan = PlanBuilder {
        random: Random(1),
        layers: ["", "Doors", "", "", "", "", "", "", ""],
        unit: (1.0, 6),
        turned: 0.0,
        moved: Vec2::zeros(),
        blocks: String::new(),
        entities: String::new(),
    };
    for (layer, corners, closed) in lines {
        let points: String = corners.iter().map(|corner| plan.point(10, Vec2::from(*corner))).collect();
        let _ = write!(plan.entities, "0\nLWPOLYLINE\n8\n{layer}\n70\n{}\n{points}", u8::from(*closed));
    }
    for (hinge, shut) in swings {
        let (hinge, shut) = (Vec2::from(*hinge), Vec2::from(*shut));
        let way = (shut - hinge).normalize();
        plan.swing(hinge, shut, vec2(-way.y, way.x));
    }
    plan.dxf()
}

/// Corners of a box, from its lower left and upper right ones.
fn rect(left: f64, low: f64, right: f64, high: f64) -> [[f64; 2]; 4] {
    [[left, low], [right, low], [right, high], [left, high]]
}

#[test]
fn swings_on_walls_without_gaps_are_doors_and_passages() {
    let wall = [[6.0, 0.0], [6.0, 8.0], [6.15, 8.0], [6.15, 0.0]];
    let lines: [(&str, &[[f64; 2]], bool); 3] = [
        ("Walls", &rect(0.0, 0.0, 10.0, 8.0), true),
        ("Walls", &rect(-0.3, -0.3, 10.3, 8.3), true),
        ("Walls", &wall, false),
    ];
    let found = proposal(&drawn(&lines, &[([2.0, 0.0], [3.0, 0.0]), ([6.0, 3.0], [6.0, 4.0])]));
    assert!((found.areas[0] - (80.0 - 0.15 * 7.0)).abs() < 1e-3, "{:#?}", found.messages());
    assert_eq!(found.doors(), [Door::new(vec2(2.5, 0.0), 1.0)]);
    assert_eq!(found.gaps.iter().map(Gap::kind).collect::<Vec<_>>(), ["door", "passage"]);
}

/// A hall of two lines with a door, 14 m by 9 m, in the frame of a sheet.
#[test]
fn a_frame_around_a_room_is_asked_for() {
    let hall = [
        [5.0, 0.0],
        [0.0, 0.0],
        [0.0, 9.0],
        [14.0, 9.0],
        [14.0, 0.0],
        [6.0, 0.0],
        [6.0, -0.2],
        [14.2, -0.2],
        [14.2, 9.2],
        [-0.2, 9.2],
        [-0.2, -0.2],
        [5.0, -0.2],
    ];
    let frame = rect(-20.0, -20.0, 40.0, 30.0);
    let asks = |lines: &[(&str, &[[f64; 2]], bool)]| {
        let found = proposal(&drawn(lines, &[]));
        found.questions.iter().any(|question| question.contains("rectangle of 60 m x 50 m a frame"))
    };
    assert!(asks(&[("Walls", &hall, true), ("Walls", &frame, true)]));
    // A wall that meets it, and one alone.
    assert!(!asks(&[
        ("Walls", &hall, true),
        ("Walls", &frame, true),
        ("Walls", &[[-20.0, 0.0], [-9.0, 0.0]], false)
    ]));
    assert!(!asks(&[("Walls", &frame, true), ("Walls", &[[0.0, 0.0], [9.0, 0.0]], false)]));
    // Without a proposal, too; and a frame by its name, whatever meets it.
    let doubt = |lines: &[(&str, &[[f64; 2]], bool)], settings: &PlanSettings| {
        let read = Read::of(DrawingFormat::Dxf, drawn(lines, &[]).as_bytes(), &METRES, settings);
        read.unwrap().doubt.unwrap_or_default().text
    };
    let meets: (&str, &[[f64; 2]], bool) = ("Walls", &[[-20.0, 0.0], [-9.0, 0.0]], false);
    let lines = |layer| [("Walls", &hall[..], true), (layer, &frame[..], true), meets];
    let all = PlanSettings::default();
    assert!(doubt(&lines("Walls")[..2], &all).contains("rectangle of 60 m x 50 m a frame"));
    assert_eq!(doubt(&lines("Walls"), &all), "");
    for layer in ["A-FRAME", "Blattrahmen", "CADRE", "Title block", "border"] {
        let message = doubt(&lines(layer), &PlanSettings { to_origin: true, ..all.clone() });
        assert!(message.contains(&format!("is on layer {layer:?}, which has a frame")), "{message}");
        let walls = vec!["Walls".to_owned(), layer.to_owned()];
        assert_eq!(doubt(&lines(layer), &PlanSettings { walls, ..all.clone() }), "");
    }
    // Whoever names the walls knows of none: a hall with a kiosk in it. Lines of dimensions are no frame.
    let kiosk: [[f64; 2]; 6] =
        [[11.0, 8.0], [10.0, 8.0], [10.0, 12.0], [15.0, 12.0], [15.0, 8.0], [12.2, 8.0]];
    let outer = rect(0.0, 0.0, 30.0, 20.0);
    let in_hall = [("Walls", &outer[..], true), ("Walls", &kiosk[..], false)];
    let named = PlanSettings { walls: vec!["Walls".to_owned()], ..all.clone() };
    assert!(doubt(&in_hall, &all).contains("a frame") && doubt(&in_hall, &named).is_empty());
    let across: (&str, &[[f64; 2]], bool) = ("Walls", &[[-3.0, 10.0], [5.0, 10.0]], false);
    assert_eq!(doubt(&[in_hall[0], in_hall[1], across], &all), "");
    let ticks = [[0.0, 0.0], [30.0, 0.0], [30.0, 20.0], [0.0, 20.0]].map(|[x, y]| [[x, y], [x, y - 1.0]]);
    let mut with_ticks = vec![in_hall[0]];
    with_ticks.extend(ticks.iter().map(|tick| ("A-DIMS", &tick[..], false)));
    assert_eq!(doubt(&with_ticks, &all), "");
    // A hall and columns have none; nor is a frame of a door one.
    let columns = [rect(3.0, 3.0, 4.0, 4.0), rect(9.0, 3.0, 10.0, 4.0), rect(3.0, 9.0, 4.0, 10.0)];
    let mut hall: Vec<(&str, &[[f64; 2]], bool)> = vec![("0", &frame, true)];
    hall.extend(columns.iter().map(|column| ("A-DOOR-FRAME", &column[..], true)));
    assert_eq!(doubt(&hall, &all), "");
}

/// The outside: by hand. Walls of 45 cm with a door; and a round wall of 24 cm, with a door of 1.2 m in it.
#[test]
fn thick_walls_are_named_and_round_ones_have_doors() {
    let ring = |thick: f64| {
        let (low, right, top) = (-thick, 12.0 + thick, 9.0 + thick);
        let inner = [[7.0, 0.0], [12.0, 0.0], [12.0, 9.0], [0.0, 9.0], [0.0, 0.0], [6.0, 0.0]];
        let outer = [[6.0, low], [low, low], [low, top], [right, top], [right, low], [7.0, low]];
        drawn(&[("Walls", &[inner, outer].concat(), true)], &[])
    };
    assert_eq!(proposal(&ring(0.4)).doors(), [Door::new(vec2(6.5, 0.0), 1.0)]);
    let thick = ring(0.45);
    let words = "lines are 45 cm apart, and walls are at most 40 cm thick";
    let found = proposal(&thick);
    assert!(found.questions.iter().any(|question| question.contains(words)), "{:?}", found.questions);
    let settings = PlanSettings { enclosing: Some(found.enclosing), ..PlanSettings::default() };
    let refused = FloorPlan::of(drawing(&thick), &settings).unwrap_err().to_string();
    assert!(refused.contains(words), "{refused}");

    let half = (0.6f64 / 3.0).asin();
    let at = |radius: f64, k: u32| {
        let angle = half + 2.0 * (std::f64::consts::PI - half) * f64::from(k) / 72.0;
        [radius * angle.cos(), radius * angle.sin()]
    };
    let round: Vec<[f64; 2]> =
        (0..=72).map(|k| at(3.0, k)).chain((0..=72).rev().map(|k| at(3.24, k))).collect();
    let found = proposal(&drawn(&[("Walls", &round, true)], &[]));
    let doors = found.doors();
    assert!(doors.len() == 1 && (doors[0].width - 1.2).abs() < 1e-3, "{:#?}", found.messages());
    assert!((doors[0].at - vec2(3.0 * half.cos(), 0.0)).norm() < 2e-3, "{doors:?}");
}

#[test]
fn what_is_not_clear_is_asked_for() {
    // A gap of 4 m, one without a leaf, a layer that says nothing.
    let ring = [
        [7.0, 0.0],
        [10.0, 0.0],
        [10.0, 8.0],
        [0.0, 8.0],
        [0.0, 0.0],
        [3.0, 0.0],
        [3.0, -0.24],
        [-0.24, -0.24],
        [-0.24, 8.24],
        [10.24, 8.24],
        [10.24, -0.24],
        [7.0, -0.24],
    ];
    let strange = [[1.0, 5.0], [2.0, 6.0], [3.0, 5.0]];
    let lines: [(&str, &[[f64; 2]], bool); 3] =
        [("Walls", &ring, true), ("Q7", &strange, false), ("Furniture", &rect(4.0, 3.0, 6.0, 4.0), true)];
    let dxf = drawn(&lines, &[]);
    let found = proposal(&dxf);
    let asks =
        |found: &Proposal, words: &str| found.questions.iter().any(|question| question.contains(words));
    assert!(found.ground.is_empty() && found.doors().is_empty());
    for words in
        ["The walls enclose nothing", "gap of 4 m from 3,-0.12 to 7,-0.12", "on layer \"Q7\"? 1 line"]
    {
        assert!(asks(&found, words), "{:?}", found.questions);
    }
    let settings = |widest| PlanSettings {
        walls: found.walls.clone(),
        enclosing: Some(Enclosing { obstacles: found.enclosing.obstacles.clone(), widest }),
        ..PlanSettings::default()
    };
    let refused = FloorPlan::of(drawing(&dxf), &settings(3.0)).unwrap_err().to_string();
    assert!(refused.contains("the walls enclose nothing: gaps of more than 3 m are not closed"), "{refused}");
    let plan = FloorPlan::of(drawing(&dxf), &settings(4.0)).unwrap();
    assert!((plan.area().unwrap() - 78.0).abs() < 1e-9);
    let missing = PlanSettings { walls: vec!["Wall".into()], ..settings(4.0) };
    let refused = FloorPlan::of(drawing(&dxf), &missing).unwrap_err().to_string();
    assert!(
        refused.contains(
            "there is no layer \"Wall\" for walls in this drawing; there are \"Furniture\", \"Q7\", \"Walls\""
        ),
        "{refused}"
    );
}

#[test]
fn an_outline_of_single_lines_with_a_gap_is_not_the_table_in_it() {
    let walls = [[5.6, 0.0], [10.0, 0.0], [10.0, 8.0], [0.0, 8.0], [0.0, 0.0], [4.4, 0.0]];
    let table = rect(3.0, 3.0, 5.0, 4.0);
    let lines: [(&str, &[[f64; 2]], bool); 2] = [("0", &walls, false), ("0", &table, true)];
    let dxf = drawn(&lines, &[]);
    let read = Read::of(DrawingFormat::Dxf, dxf.as_bytes(), &METRES, &PlanSettings::default()).unwrap();
    assert!(
        read.doubt
            .is_some_and(|doubt| doubt.contains("lies around 2.0 m², all walls together around 80.0 m²"))
    );
    let found = proposal(&dxf);
    assert!((found.areas[0] - 78.0).abs() < 1e-9);
    assert_eq!(found.doors(), [Door::new(vec2(5.0, 0.0), 1.2)]);
    assert!(found.questions.iter().any(|question| question.contains("1.2 m wide at 5,0 a door")));
    // Where nothing is in doubt, nobody is asked.
    let closed: [(&str, &[[f64; 2]], bool); 2] =
        [("0", &rect(0.0, 0.0, 10.0, 8.0), true), ("0", &table, true)];
    let read =
        Read::of(DrawingFormat::Dxf, drawn(&closed, &[]).as_bytes(), &METRES, &PlanSettings::default())
            .unwrap();
    assert_eq!(read.doubt, None);
    // A partition of one line, with a gap in it, stays, and one that ends in the room.
    let mut lines: Vec<(&str, &[[f64; 2]], bool)> = vec![("0", &walls, false)];
    let parts = [[[7.0, 0.0], [7.0, 3.0]], [[7.0, 4.0], [7.0, 8.0]], [[2.0, 8.0], [2.0, 6.0]]];
    lines.extend(parts.iter().map(|part| ("0", &part[..], false)));
    let dxf = drawn(&lines, &[]);
    let found = proposal(&dxf);
    assert!((found.areas[0] - 80.0).abs() < 1e-6, "{:#?}", found.messages());
    let open: f64 = found.open.iter().map(|[a, b]| (b - a).norm()).sum();
    assert!((open - 9.0).abs() < 1e-9, "{:?}", found.open);
    let settings = PlanSettings { enclosing: Some(found.enclosing.clone()), ..PlanSettings::default() };
    assert_eq!(FloorPlan::of(drawing(&dxf), &settings).unwrap().walls.len(), 4);
    // Column by column along the middle, no gap is a passage.
    let columns: Vec<[[f64; 2]; 4]> =
        (0..4).map(|k| 1.0 + 2.4 * f64::from(k)).map(|x| rect(x, 5.0, x + 0.4, 5.4)).collect();
    let mut lines: Vec<(&str, &[[f64; 2]], bool)> = vec![("0", &walls, false)];
    lines.extend(columns.iter().map(|column| ("0", &column[..], true)));
    let found = proposal(&drawn(&lines, &[]));
    assert_eq!(found.gaps.iter().map(Gap::kind).collect::<Vec<_>>(), ["door"], "{:#?}", found.messages());
    assert!((found.areas[0] - (80.0 - 0.64)).abs() < 1e-6);
}

#[test]
fn the_plan_of_an_architect_has_384_square_metres() {
    let path =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/cases/plan_dirty/plan.dxf");
    let Ok(dxf) = std::fs::read_to_string(&path) else {
        return eprintln!("{} is not here: nothing is tested", path.display());
    };
    let found = proposal(&dxf);
    // 24 m by 16 m; a partition of 0.1 m by 5.2 m; six columns and a bar, of straight pieces.
    assert!((found.areas[0] - (384.0 - 0.52)).abs() < 1e-6);
    let obstacles =
        3.0 * 0.16 + 3.0 * 0.09 * std::f64::consts::PI + (3.6 * 3.6 - 9.0) * std::f64::consts::PI / 3.0;
    assert!((found.areas[0] - found.areas[1] - obstacles).abs() < 0.05);
    assert_eq!(found.doors(), [Door::new(vec2(125.0, 45.0), 1.2), Door::new(vec2(144.0, 52.9), 1.8)]);
    assert_eq!(found.closed.len(), 3);
}

#[test]
fn too_many_lines_are_refused_with_a_number() {
    let refused = |lines: Vec<[[f64; 2]; 2]>| {
        let lines: Vec<(&str, &[[f64; 2]], bool)> =
            lines.iter().map(|line| ("0", &line[..], false)).collect();
        Proposal::of(&drawing(&drawn(&lines, &[])), &[], None, None).unwrap_err().to_string()
    };
    let place = |k: u32| 0.2 * f64::from(k);
    let crossing =
        (0..500).flat_map(|k| [[[place(k), -1.0], [place(k), 101.0]], [[-1.0, place(k)], [101.0, place(k)]]]);
    let message = refused(crossing.collect());
    assert!(message.contains("cross each other at more than 200000 places"), "{message}");
    let many = (0..20_001).map(|k| [[place(k), 0.0], [place(k), 0.1]]).collect();
    assert!(refused(many).contains("more than 20000 straight pieces"));
    let near = (0..5000).map(|k| [[0.001 * place(k), 0.0], [0.001 * place(k), 9.0]]).collect();
    assert!(refused(near).contains("too many lines are near each other"));
}
