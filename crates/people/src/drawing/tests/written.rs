//! Drawings that are written, read again.

use super::*;
use lemons_core::trial::{Geometry, Wall};

/// Sides of walls, to a micrometre.
fn sides(walls: &[Vec<Vec2>]) -> Vec<[i64; 4]> {
    let whole = |x: f64| (x * 1e6).round() as i64;
    let side = |pair: &[Vec2]| {
        let mut ends = [[whole(pair[0].x), whole(pair[0].y)], [whole(pair[1].x), whole(pair[1].y)]];
        ends.sort_unstable();
        [ends[0][0], ends[0][1], ends[1][0], ends[1][1]]
    };
    let mut all: Vec<[i64; 4]> = walls.iter().flat_map(|wall| wall.windows(2).map(side)).collect();
    all.sort_unstable();
    all
}

#[test]
fn what_is_written_is_read_back() {
    let hall = plan_of("hall.dxf", DrawingFormat::Dxf, Reading::default(), None);
    for format in written_formats() {
        let text = write_plan(&hall, format).unwrap();
        let again = plan(format, &text);
        assert_eq!(sides(&again.walls), sides(&hall.walls), "{format:?}");
        if format != DrawingFormat::Wkt {
            assert_eq!(
                (&again.exits, &again.distributions),
                (&hall.exits, &hall.distributions),
                "{format:?}"
            );
        }
    }
    assert_eq!(write_plan(&hall, DrawingFormat::Svg), None);
    // Names are of other programs, too.
    let mut named = hall.clone();
    named.exits[0].name = "Süd\n  0\nEOF".into();
    let text = write_plan(&named, DrawingFormat::Dxf).unwrap();
    assert_eq!(plan(DrawingFormat::Dxf, &text).exits[0].name, "Süd_  0_EOF");
}

fn well_known(walls: &[Vec<Vec2>]) -> String {
    let wall = |(id, wall): (usize, &Vec<Vec2>)| Wall::new(id.to_string(), "wood", wall.clone());
    let walls = walls.iter().enumerate().map(wall).collect();
    write_plan(
        &FloorPlan::of_geometry(&Geometry { walls, ..Geometry::default() }, Vec::new()),
        DrawingFormat::Wkt,
    )
    .unwrap()
}

/// Walls of closed rooms that meet are there as often as before, and so is the ground of the largest.
#[test]
fn rooms_that_meet_are_read_back_from_well_known_text() {
    let rectangle = |[x0, y0, x1, y1]: [f64; 4]| {
        [[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]].map(Vec2::from).to_vec()
    };
    let room = [0.0, 0.0, 10.0, 5.0];
    // Walls, how many polygons and lines are written, and the ground.
    for (rectangles, written, area) in [
        // Two rooms with one wall between them, that share a corner, that are a hair apart.
        (&[room, [10.0, 0.0, 20.0, 5.0]][..], [0, 2], 50.0),
        (&[room, [10.0, 5.0, 20.0, 9.0]], [0, 2], 50.0),
        (&[room, [10.012, 1.0, 20.0, 4.0]], [0, 2], 50.0),
        // A cupboard in the corner, one nearly at a wall, one that goes through it.
        (&[room, [9.0, 4.0, 10.0, 5.0]], [0, 2], 49.0),
        (&[room, [4.0, 0.01, 5.0, 1.0]], [0, 2], 50.0 - 0.99),
        (&[room, [4.0, -0.5, 5.0, 0.5]], [0, 2], 49.5),
        // With a column, which is not ground, either; and a room that is apart from both.
        (&[room, [9.0, 4.0, 10.0, 5.0], [2.0, 2.0, 3.0, 3.0], [12.0, 0.0, 15.0, 4.0]], [1, 3], 48.0),
        // Tables at each other in a room; a column in it, and an island in that.
        (&[room, [2.0, 2.0, 3.0, 3.0], [3.0, 2.0, 4.0, 3.0]], [1, 2], 48.0),
        (&[room, [2.0, 2.0, 4.0, 4.0], [2.5, 2.5, 3.5, 3.5]], [2, 0], 47.0),
        // Apart: one polygon with a hole.
        (&[room, [9.0, 3.9, 9.9, 4.9]], [1, 0], 50.0 - 0.9),
    ] {
        let walls = rectangles.iter().map(|sides| rectangle(*sides)).collect::<Vec<_>>();
        let text = well_known(&walls);
        let kinds = ["POLYGON", "LINESTRING"].map(|kind| text.matches(kind).count());
        assert_eq!(kinds, written, "{rectangles:?}: {text}");
        let again = plan(DrawingFormat::Wkt, &text);
        assert_eq!(sides(&again.walls), sides(&walls), "{rectangles:?}: {text}");
        let found = again.area();
        assert!(
            found.is_some_and(|found| (found - area).abs() < 1e-6),
            "{rectangles:?}: {found:?}, not {area}"
        );
    }
    // A wall that touches itself is a line, too: a polygon would be mended, or refused.
    let wall = [[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0], [0.0, 0.0]].map(Vec2::from).to_vec();
    assert_eq!(well_known(&[wall]), "LINESTRING (0 0, 2 2, 2 0, 0 2, 0 0)\n");
}

/// The outside: by hand. What is written is read as the same ground: ground in an obstacle, and that in one there; areas apart,
/// nearly touching, and touching in a corner; a thin wall; a wall of one line; obstacles at a rim.
#[test]
fn ground_that_is_written_is_read_back() {
    let hall = ("walkablearea", [0.0, 0.0, 30.0, 20.0]);
    let ring = |low: f64, high: f64| {
        let (a, b) = (low + 1.0, high - 1.0);
        [[low, low, high, a], [low, b, high, high], [low, low, a, high], [b, low, high, high]]
            .map(|sides| ("obstacles-ring", sides))
    };
    let with = |more: &[(&'static str, [f64; 4])]| [&[hall], more].concat();
    let nested = [&ring(1.0, 17.0)[..], &ring(4.0, 14.0), &[("obstacles", [8.0, 8.0, 9.0, 9.0])]].concat();
    for (areas, expected) in [
        (with(&ring(1.0, 9.0)), 600.0 - 28.0),
        (with(&nested), 600.0 - 60.0 - 36.0 - 1.0),
        (with(&[("walkablearea", [40.0, 0.0, 45.0, 5.0])]), 625.0),
        (with(&[("obstacles", [10.0, -1.0, 10.01, 21.0])]), 600.0 - 0.2),
        (with(&[&ring(1.0, 9.0)[..], &[("obstacles", [2.0, 5.0, 8.0, 5.01])]].concat()), 600.0 - 28.0 - 0.06),
        (with(&[("walkablearea", [30.0, 20.0, 35.0, 25.0]), ("obstacles", [0.0, 0.0, 1.0, 1.0])]), 624.0),
        (with(&[("obstacles", [5.0, 5.0, 6.0, 6.0]), ("obstacles", [6.0, 5.0, 7.0, 6.0])]), 598.0),
        (with(&[("obstacles", [5.0, 5.0, 6.0, 6.0])]), 599.0),
    ] {
        let entities: String = areas.iter().map(|(layer, sides)| rectangle(layer, *sides)).collect();
        let line = "0 LINE 8 obstacles 10 25 20 3 11 28 21 3";
        let room = plan_of_dxf(&(entities + line));
        let area = room.area().unwrap();
        assert!((area - expected).abs() < 1e-4, "{areas:?}: {area}");
        for format in [DrawingFormat::GeoJson, DrawingFormat::Dxf] {
            let text = write_plan(&room, format).unwrap();
            let again = plan(format, &text);
            assert!((again.area().unwrap() - area).abs() < 1e-6, "{areas:?}: {text}: {:?}", again.area());
            assert_eq!(again.walls.len(), room.walls.len(), "{areas:?}: {text}");
        }
    }
}

/// The crates wkt and geojson read the same.
#[test]
fn other_readers_agree() {
    let hall = plan_of("hall.dxf", DrawingFormat::Dxf, Reading::default(), None);
    let text = write_plan(&hall, DrawingFormat::GeoJson).unwrap();
    let ::geojson::GeoJson::FeatureCollection(all) = text.parse().unwrap() else { panic!("no collection") };
    let is_wall = |feature: &&::geojson::Feature| {
        ["walkablearea", "obstacles"].iter().any(|layer| feature.property("layer").unwrap() == layer)
    };
    let corners: Vec<usize> = all
        .features
        .iter()
        .filter(is_wall)
        .map(|feature| match &feature.geometry.as_ref().unwrap().value {
            ::geojson::GeometryValue::Polygon { coordinates } => coordinates[0].len(),
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(corners, hall.walls.iter().map(Vec::len).collect::<Vec<_>>());
    let text = write_plan(&hall, DrawingFormat::Wkt).unwrap();
    // The outline is the first wall, the others are in it.
    let ::wkt::Wkt::Polygon(polygon) = text.trim().parse::<::wkt::Wkt<f64>>().unwrap() else {
        panic!("no polygon")
    };
    assert_eq!(polygon.rings().len(), hall.walls.len());
    for (ring, wall) in polygon.rings().iter().zip(&hall.walls) {
        let corners: Vec<Vec2> = ring.coords().iter().map(|c| vec2(c.x, c.y)).collect();
        assert_eq!(corners, *wall);
    }
}
