//! Names of layers.

use super::*;

#[test]
fn layers_say_what_lines_are() {
    for (layer, expected) in [
        ("walkablearea-0", Some((LayerRole::WalkableArea, "0"))),
        ("WalkableArea", Some((LayerRole::WalkableArea, ""))),
        ("walkable_area_hall", Some((LayerRole::WalkableArea, "hall"))),
        ("JuPedSim_walkable_area", Some((LayerRole::WalkableArea, ""))),
        ("jps-walkablearea-0", Some((LayerRole::WalkableArea, "0"))),
        ("JPS-Obstacles", Some((LayerRole::Obstacle, ""))),
        ("jps-exits-north", Some((LayerRole::Exit, "north"))),
        ("jps-distributions_2", Some((LayerRole::Distribution, "2"))),
        ("jps_waypoints3", Some((LayerRole::Waypoint, "3"))),
        ("jps-journeys-0", Some((LayerRole::Unused, "0"))),
        ("journeys", Some((LayerRole::Unused, ""))),
        ("jps-parameters", Some((LayerRole::Unused, "parameters"))),
        ("plan$0$walkablearea-0", Some((LayerRole::WalkableArea, "0"))),
        ("plan$12$jps-exits-a", Some((LayerRole::Exit, "a"))),
        ("A$0$B$0$obstacles", Some((LayerRole::Obstacle, ""))),
        ("plan|exits-0", Some((LayerRole::Exit, "0"))),
        ("plan|A-WALL", None),
        ("Level 1::obstacles-b", Some((LayerRole::Obstacle, "b"))),
        ("0 - distributions-0", Some((LayerRole::Distribution, "0"))),
        ("wall beside ramp - exit 2", None),
        ("Level 1 - exits-0", None),
        ("walkablearea - 0|1", Some((LayerRole::WalkableArea, "0|1"))),
        ("plan$0$exit-signs", None),
        ("jupedsim", None),
        ("OBSTACLES-Columns", Some((LayerRole::Obstacle, "Columns"))),
        ("obstacle", Some((LayerRole::Obstacle, ""))),
        ("exit 2", Some((LayerRole::Exit, "2"))),
        ("exits-", Some((LayerRole::Exit, ""))),
        ("exit-signs", None),
        ("exitsigns", None),
        ("waypoints3", Some((LayerRole::Waypoint, "3"))),
        ("A-WALL", None),
        ("", None),
    ] {
        assert_eq!(LayerRole::of(layer), expected.map(|(role, name)| (role, name.to_owned())), "{layer}");
    }
}

/// Exits, journeys and obstacles of JuPedSim's converter, with the signs that others put before names: no walls.
#[test]
fn layers_of_jupedsim_and_of_bound_references_are_no_walls() {
    for [before, after] in
        [["jps-", "-0"], ["jps-", ""], ["", ""], ["plan$0$", "-7"], ["plan|", "-0"], ["X$0$jps-", ""]]
    {
        let layer = |name: &str| format!("{before}{name}{after}");
        let entities = rectangle(&layer("walkablearea"), [0.0, 0.0, 8.0, 6.0])
            + &rectangle(&layer("obstacles"), [4.0, 2.5, 5.0, 3.5])
            + &rectangle(&layer("distributions"), [0.5, 0.5, 3.0, 5.5])
            + &rectangle(&layer("exits"), [7.2, 2.0, 7.8, 4.0])
            + &format!("0 CIRCLE 8 {} 10 2 20 2 40 0.5 ", layer("waypoints"))
            + &format!("0 LINE 8 {} 10 1 20 3 11 7 21 3", layer("journeys"));
        let found = plan_of_dxf(&entities);
        let places = (found.exits.len(), found.distributions.len(), found.waypoints.len());
        assert_eq!((found.walls.len(), found.area(), places), (2, Some(47.0), (1, 1, 1)), "{before} {after}");
        assert_eq!(
            left_out_of(&found),
            [format!("1 LINE (of JuPedSim, not used) on layer {:?}", layer("journeys"))]
        );
    }
    // Journeys are none without areas, too.
    let text = rectangle("A", [0.0, 0.0, 8.0, 6.0]) + "0 LINE 8 jps-journeys 10 1 20 3 11 7 21 3";
    assert_eq!(plan_of_dxf(&text).walls.len(), 1);
}

/// Only the property `layer` may have something before a role: the others are free text.
#[test]
fn free_text_of_geojson_is_no_exit() {
    let of = |properties: &str| {
        let line = r#""geometry": {"type": "LineString", "coordinates": [[1, 1], [2, 1]]}"#;
        let wall = format!(r#"{{"type": "Feature", "properties": {properties}, {line}}}"#);
        let found = plan(
            DrawingFormat::GeoJson,
            &collection(&[feature("A", &[vec2(0.0, 0.0), vec2(9.0, 0.0), vec2(9.0, 5.0)]), wall]),
        );
        (found.walls.len(), found.exits.len())
    };
    for properties in [
        r#"{"layer": "A-WALL", "name": "wall beside ramp - exit 2"}"#,
        r#"{"layer": "A-WALL", "name": "ramp/exit 2"}"#,
        r#"{"name": "0 - exits-0"}"#,
        r#"{"name": "hall|exits-0", "type": "stairs$0$exits"}"#,
        r#"{"layer": "ramp - exit 2"}"#,
    ] {
        assert_eq!(of(properties), (2, 0), "{properties}");
    }
    for properties in [
        r#"{"layer": "0 - exits-0"}"#,
        r#"{"layer": "plan|exits-0", "name": "north"}"#,
        r#"{"layer": "A-WALL", "name": "exit 2"}"#,
    ] {
        assert_eq!(of(properties), (1, 1), "{properties}");
    }
    // Nor is the id of a shape.
    let text = "<svg viewBox='0 0 9 9'><path d='M0,0 h9 v9 z'/><path id='ramp/exit 2' d='M1,1 h1'/></svg>";
    assert!(plan(DrawingFormat::Svg, text).exits.is_empty());
}

#[test]
fn walls_on_layers_that_are_not_there_are_refused() {
    let text = dxf_of(
        "",
        "",
        "0 LINE 8 A-WALL 10 0 20 0 11 9 21 0 0 LINE 8 A-DOOR 10 0 20 1 11 9 21 1 0 TEXT 8 A-TEXT 1 x",
    );
    let of = |walls: &[&str]| {
        let walls = walls.iter().map(|wall| (*wall).to_owned()).collect();
        FloorPlan::of(
            drawing(DrawingFormat::Dxf, &text).unwrap(),
            &PlanSettings { walls, ..PlanSettings::default() },
        )
    };
    let message = of(&["A-WALL", "A-WAL"]).unwrap_err().to_string();
    let expected =
        r#"there is no layer "A-WAL" for walls in this drawing; there are "A-DOOR", "A-TEXT", "A-WALL""#;
    assert_eq!(message, expected);
    // Names of layers are the same in upper and lower case.
    assert_eq!(of(&["a-wall"]).unwrap().walls.len(), 1);
}

/// The outside: by hand. A name that is in the file is one layer; others are parted at commas.
#[test]
fn names_of_layers_may_have_commas() {
    let square = |layer: &str, from: u32| {
        format!(
            r#"{{"type": "Feature", "properties": {{"layer": "{layer}"}}, "geometry": {{"type": "LineString",
            "coordinates": [[{from}, {from}], [9, {from}], [9, 9], [{from}, 9], [{from}, {from}]]}}}}"#
        )
    };
    let all = ["Wände, EG", "A", "B", "Kern, 1"].iter().zip(0..).map(|(layer, k)| square(layer, k));
    let text =
        format!(r#"{{"type": "FeatureCollection", "features": [{}]}}"#, all.collect::<Vec<_>>().join(", "));
    let of = |walls: &[&str]| {
        let walls: Vec<String> = walls.iter().map(|wall| (*wall).to_owned()).collect();
        let settings = PlanSettings { walls, ..PlanSettings::default() };
        let read = Read::of(DrawingFormat::GeoJson, text.as_bytes(), &METRES, &settings);
        read.map(|read| read.plan.walls.len()).map_err(|error| error.to_string())
    };
    assert_eq!((of(&["Wände, EG"]), of(&["wände, eg", "A,B"]), of(&["A,B"])), (Ok(1), Ok(3), Ok(2)));
    assert!(of(&["Wände, OG"]).unwrap_err().contains("no layer \"Wände\""));
    // A proposal is repeated as it is.
    let drawing = drawing(DrawingFormat::GeoJson, &text).unwrap();
    let given = Enclosing { obstacles: vec!["Kern, 1".to_owned()], ..Enclosing::default() };
    let walls = ["Wände, EG".to_owned(), "A,B".to_owned()];
    let found = Proposal::of(&drawing, &walls, None, Some(&given)).unwrap().unwrap();
    let expected = ["--walls", "Wände, EG", "--walls", "A", "--walls", "B", "--obstacles", "Kern, 1"];
    assert_eq!(found.options()[1..9], expected);
}
