//! Areas, obstacles and walls that meet.

use super::*;

#[test]
fn areas_that_meet_are_united_and_obstacles_cut() {
    let of = |areas: &[(&str, [f64; 4])]| {
        plan_of_dxf(&areas.iter().map(|(layer, sides)| rectangle(layer, *sides)).collect::<String>())
    };
    // Two rooms of 4 by 3 that share a square metre, and a pillar half in the wall.
    let united = of(&[
        ("walkablearea-a", [0.0, 0.0, 4.0, 3.0]),
        ("walkablearea-b", [3.0, 2.0, 7.0, 5.0]),
        ("obstacles", [-1.0, 1.0, 1.0, 2.0]),
    ]);
    assert!((united.area().unwrap() - (12.0 + 12.0 - 1.0 - 1.0)).abs() < 1e-6);
    assert!(united.ground.is_some() && united.walls.len() == 1);
    // Where nothing meets, walls are as drawn.
    let apart = of(&[
        ("walkablearea", [0.0, 0.0, 4.0, 3.0]),
        ("obstacles", [1.0, 1.0, 2.0, 2.0]),
        ("furniture", [0.5, 0.5, 0.7, 0.7]),
    ]);
    assert!(apart.ground.is_none() && apart.walls.len() == 2 && apart.area() == Some(11.0));
    assert_eq!(apart.left_out.len(), 1);
    // Without such layers, all lines are walls, also outside.
    let plain =
        of(&[("a", [1.0, 1.0, 2.0, 2.0]), ("b", [0.0, 0.0, 4.0, 3.0]), ("c", [9.0, 9.0, 10.0, 10.0])]);
    assert_eq!((plain.walls.len(), plain.outline, plain.area()), (3, Some(1), Some(11.0)));
}

#[test]
fn an_area_between_others_is_no_double() {
    // A grid of 3 x 3 squares, the middle one last: all its sides are on those of others.
    let places = [(0, 0), (1, 0), (2, 0), (0, 1), (2, 1), (0, 2), (1, 2), (2, 2), (1, 1)];
    let square = |(x, y): (i32, i32)| {
        let (right, top) = (x + 1, y + 1);
        format!("10 {x} 20 {y} 10 {right} 20 {y} 10 {right} 20 {top} 10 {x} 20 {top}")
    };
    let closed: String =
        places.iter().map(|at| format!("0 LWPOLYLINE 8 walkablearea 70 1 {} ", square(*at))).collect();
    // The same, open, with the first corner repeated.
    let open: String = places
        .iter()
        .map(|at| format!("0 LWPOLYLINE 8 walkablearea {} 10 {} 20 {} ", square(*at), at.0, at.1))
        .collect();
    for entities in [closed, open] {
        let plan = plan(DrawingFormat::Dxf, &dxf_of("9 $INSUNITS 70 6", "", &entities));
        assert_eq!((plan.walls.len(), plan.doubles), (1, 0));
        assert!((plan.area().unwrap() - 9.0).abs() < 1e-6);
    }
}

#[test]
fn lines_that_meet_are_one_wall_where_no_third_one_ends() {
    let lines = |all: &[[f64; 4]]| {
        let line = |[a, b, c, d]: &[f64; 4]| format!("0 LINE 8 A 10 {a} 20 {b} 11 {c} 21 {d} ");
        plan_of_dxf(&all.iter().map(line).collect::<String>())
    };
    let square = [[0.0, 0.0, 1.0, 0.0], [1.0, 1.0, 1.0, 0.0], [1.0, 1.0, 0.0, 1.0], [0.0, 0.0, 0.0, 1.0]];
    let closed = lines(&square);
    assert_eq!((closed.walls.len(), closed.area()), (1, Some(1.0)));
    // A third wall begins at a corner: the others go round, and it is a wall of its own.
    let third = lines(&[&square[..], &[[0.0, 0.0, -1.0, -1.0]]].concat());
    assert_eq!((third.walls.len(), third.outline), (2, Some(0)));
    let open = lines(&[[0.0, 0.0, 1.0, 0.0], [1.0, 0.0, 2.0, 1.0]]);
    assert_eq!(open.walls, [[vec2(0.0, 0.0), vec2(1.0, 0.0), vec2(2.0, 1.0)]]);
    // A part of a longer wall is there once.
    let double = lines(&[&square[..], &[[1.0, 0.0, 0.0, 0.0]]].concat());
    assert_eq!((double.walls.len(), double.doubles), (1, 1));
}

/// As shapely unites them.
#[test]
fn polygons_of_well_known_text_are_one_area() {
    for (text, walls, area, within) in [
        // Two halls and a passage, which touch; that overlap; a collection in a collection.
        (
            "MULTIPOLYGON (((0 0, 10 0, 10 5, 0 5, 0 0)), ((10 2, 20 2, 20 3, 10 3, 10 2)), ((20 0, 30 0, 30 5, 20 5, 20 0)))",
            1,
            110.0,
            0,
        ),
        (
            "GEOMETRYCOLLECTION (POLYGON ((0 0, 10 0, 10 5, 0 5, 0 0)), GEOMETRYCOLLECTION (POLYGON ((9 2, 20 2, 20 3, 9 3, 9 2))), \
             POLYGON ((19 0, 30 0, 30 5, 19 5, 19 0)))",
            1,
            50.0 + 55.0 + 9.0,
            0,
        ),
        // Apart: all of it counts.
        ("MULTIPOLYGON (((0 0, 10 0, 10 5, 0 5, 0 0)), ((12 0, 15 0, 15 4, 12 4, 12 0)))", 2, 62.0, 0),
        // A hole that another polygon covers in part; holes that overlap; one that holds an island.
        (
            "MULTIPOLYGON (((0 0, 10 0, 10 5, 0 5, 0 0), (2 2, 4 2, 4 4, 2 4, 2 2)), ((3 1, 5 1, 5 3, 3 3, 3 1)))",
            2,
            47.0,
            0,
        ),
        (
            "POLYGON ((0 0, 10 0, 10 5, 0 5, 0 0), (2 2, 4 2, 4 4, 2 4, 2 2), (3 1, 5 1, 5 3, 3 3, 3 1))",
            2,
            43.0,
            0,
        ),
        (
            "MULTIPOLYGON (((0 0, 10 0, 10 5, 0 5, 0 0), (2 1, 5 1, 5 4, 2 4, 2 1)), ((3 2, 4 2, 4 3, 3 3, 3 2)))",
            3,
            42.0,
            0,
        ),
        // What lies within another one changes nothing, and is said.
        (
            "GEOMETRYCOLLECTION (POLYGON ((0 0, 10 0, 10 5, 0 5, 0 0)), POLYGON ((2 1, 5 1, 5 4, 2 4, 2 1)))",
            1,
            50.0,
            1,
        ),
        // Also where it touches the rim, at a side or in a corner, or rounding puts it a millimetre beyond.
        (
            "GEOMETRYCOLLECTION (POLYGON ((0 0, 10 0, 10 5, 0 5, 0 0)), POLYGON ((9 4, 10 4, 10 5, 9 5, 9 4)))",
            1,
            50.0,
            1,
        ),
        (
            "GEOMETRYCOLLECTION (POLYGON ((0 0, 10 0, 10 5, 0 5, 0 0)), POLYGON ((10 2, 9 3, 8 2, 9 1, 10 2)))",
            1,
            50.0,
            1,
        ),
        (
            "GEOMETRYCOLLECTION (POLYGON ((9 4, 10 4, 10 5, 9 5, 9 4)), POLYGON ((0 0, 9.999999 0, 9.999999 5, 0 5, 0 0)))",
            1,
            50.0,
            1,
        ),
        // Not where a part of it is beyond the rim, though all its corners are within; nor in a hole.
        (
            "GEOMETRYCOLLECTION (POLYGON ((0 0, 10 0, 10 5, 6 5, 6 2, 4 2, 4 5, 0 5, 0 0)), POLYGON ((3 3, 7 3, 7 4, 3 4, 3 3)))",
            2,
            44.0 + 2.0,
            0,
        ),
        // One polygon is as drawn, and lines are walls.
        (
            "GEOMETRYCOLLECTION (POLYGON ((0 0, 10 0, 10 5, 0 5, 0 0), (2 1, 5 1, 5 4, 2 4, 2 1)), LINESTRING (6 0, 6 3))",
            3,
            41.0,
            0,
        ),
        // A corner that is repeated, and one that is nearly so; a spike; a hole that is reached by a bridge.
        ("POLYGON ((0 0, 10 0, 10 0, 10 5, 10 5.0000001, 0 5, 0 0, 0 0))", 1, 50.0, 0),
        ("POLYGON ((0 0, 10 0, 12 0, 10 0, 10 5, 0 5, 0 0))", 1, 50.0, 0),
        ("POLYGON ((0 0, 10 0, 10 5, 0 5, 0 0, 2 1, 2 4, 5 4, 5 1, 2 1, 0 0))", 2, 41.0, 0),
    ] {
        let found = plan(DrawingFormat::Wkt, text);
        let of = found.area().unwrap();
        assert!((of - area).abs() < 1e-5, "{text}: {of}");
        assert_eq!((found.walls.len(), found.within.len()), (walls, within), "{text}: {:?}", found.walls);
    }
    // What is said of it.
    let room = "POLYGON ((0 0, 10 0, 10 5, 0 5, 0 0))";
    let boxes = ["POLYGON ((9 4, 10 4, 10 5, 9 5, 9 4))", "POLYGON ((2 1, 5 1, 5 4, 2 4, 2 1))"];
    let messages = |text: String| read_as(DrawingFormat::Wkt, &text).unwrap().messages("x");
    let find = |messages: &[(&str, String)], key: &str| {
        messages.iter().find(|(what, _)| *what == key).map(|(_, how)| how.clone()).unwrap()
    };
    let one = messages(format!("GEOMETRYCOLLECTION ({room}, {})", boxes[0]));
    assert_eq!(
        find(&one, "warning"),
        "POLYGON 1 lies within another polygon and is counted as floor; if it is an obstacle, draw it as a hole"
    );
    assert_eq!(find(&one, "ground"), "50.000 m² of all areas, without obstacles");
    assert_eq!(find(&messages(room.to_owned()), "ground"), "50.000 m² within the outline, without obstacles");
    let two = messages(format!("GEOMETRYCOLLECTION ({room}, {}, {})", boxes[0], boxes[1]));
    assert!(
        find(&two, "warning").starts_with("POLYGON 1, POLYGON 2 lie within other polygons and are counted")
    );
    let messages =
        read_as(DrawingFormat::Wkt, "POLYGON ((0 0, 10 0, 0 5, 10 5, 0 0))").unwrap_err().to_string();
    assert_eq!(messages, "POLYGON 0: its sides cross or touch each other");
}

/// Two rooms that share a part of a side, turned by each angle, in millimetres: the wall between them is open.
#[test]
fn areas_that_share_a_side_are_united_at_each_angle() {
    for degrees in 0..360 {
        let turn = lemons_core::plane::rotation(f64::from(degrees).to_radians());
        let room = |[x0, y0, x1, y1]: [f64; 4]| {
            let corners = [vec2(x0, y0), vec2(x1, y0), vec2(x1, y1), vec2(x0, y1)];
            corners.map(|at| (turn * at).map(|x| (x * 1e3).round() / 1e3))
        };
        let features =
            [[0.0, 0.0, 6.0, 4.0], [2.0, 4.0, 4.0, 9.0]].map(|sides| feature("walkablearea-0", &room(sides)));
        let found = plan(DrawingFormat::GeoJson, &collection(&features));
        assert_eq!((found.walls.len(), found.walls[0].len() < 12), (1, true), "{degrees}: {:?}", found.walls);
        assert!((found.area().unwrap() - 34.0).abs() < 0.02, "{degrees}: {:?}", found.area());
        let (a, b) = (turn * vec2(3.0, 3.5), turn * vec2(3.0, 4.5));
        let shut =
            found.walls[0].windows(2).any(|side| lemons_core::plane::segments_touch(a, b, side[0], side[1]));
        assert!(!shut, "{degrees}");
    }
}
