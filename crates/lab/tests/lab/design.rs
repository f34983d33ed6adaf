//! Rooms, changes by hand, and requests that are none.

use crate::*;
use lemons_testing::repository;

#[test]
fn a_room_has_obstacles_doors_and_a_part_where_people_are_placed() {
    let mut lab = Lab::default();
    let room = json!({
        "outline": [[0.0, 0.0], [8.0, 0.0], [8.0, 6.0], [0.0, 6.0]],
        "obstacles": [[[1.5, 2.0], [2.0, 2.0], [2.0, 2.5], [1.5, 2.5]]],
        "doors": [{"at": [8.1, 3.0], "width": 0.9}],
    });
    let region = json!([[0.0, 0.0], [4.0, 0.0], [4.0, 6.0], [0.0, 6.0]]);
    let base = with(with(crowd(1, room.clone()), "regions", part(region)), "number", Value::Null);
    let (made, first) = ok(&mut lab, own(with(base.clone(), "density", json!(2.0))));
    // 24 m² less the obstacle.
    assert!(close(made["made"]["area"].as_f64().unwrap(), 23.75, 1e-9));
    let poses = numbers(&first);
    assert_eq!(poses.len() / COLUMNS, 48);
    let in_obstacle = |at: &[f64]| (1.5..2.0).contains(&at[0]) && (2.0..2.5).contains(&at[1]);
    assert!(poses.chunks(COLUMNS).all(|pose| pose[0] < 4.0 && !in_obstacle(pose)));
    let walls: Vec<Vec<[f64; 2]>> =
        made["scene"]["walls"].as_array().unwrap().iter().map(|wall| read(&wall["corners"])).collect();
    assert_eq!(walls.len(), 2);
    // Also where the room is a closed wall, too.
    let closed = with(base.clone(), "room", with(room.clone(), "doors", json!([])));
    let (whole, _) = ok(&mut lab, own(with(closed, "density", json!(2.0))));
    for shown in [&made, &whole] {
        let walls = shown["scene"]["walls"].as_array().unwrap().iter();
        assert!(walls.map(|wall| wall["obstacle"].as_bool().unwrap()).eq([false, true]));
    }
    let ends = [walls[0][0], *walls[0].last().unwrap()];
    assert!(ends.iter().all(|end| close(end[0], 8.0, 1e-12)), "{ends:?}");
    assert!(close((ends[0][1] - ends[1][1]).abs(), 0.9, 1e-12));
    // Walls cut the region, as those of `lemons crowd --region`.
    for (left, right, area) in [(4.0, 9.0, 24.0), (1.7, 4.0, 2.3 * 6.0 - 0.3 * 0.5)] {
        let region = json!([[left, 0.0], [right, 0.0], [right, 6.0], [left, 6.0]]);
        let wanted = with(with(base.clone(), "density", json!(1.0)), "regions", part(region));
        let made = ok(&mut lab, own(wanted)).0["made"]["area"].as_f64().unwrap();
        assert!(close(made, area, 1e-9), "{made} {area}");
    }
    for (key, value, words) in [
        ("regions", part(json!([[0.0, 0.0], [4.0, 4.0], [4.0, 0.0], [0.0, 4.0]])), "area is 0"),
        (
            "room",
            with(room.clone(), "outline", json!([[0.0, 0.0], [8.0, 6.0], [8.0, 0.0], [0.0, 4.0]])),
            "cross",
        ),
        ("room", with(room.clone(), "doors", json!([{"at": [0.0, 90.0], "width": 1.0}])), "door 0"),
        ("men", json!(1.5), "men"),
        ("density", json!(9.0), "number and density: one of them"),
    ] {
        let base = with(with(base.clone(), "number", json!(40)), key, value);
        let message = refused(&mut lab, own(base), &[]);
        assert!(message.contains(words), "{key}: {message}");
    }
}

/// A way goes straight through a pillar.
#[test]
fn where_a_way_crosses_walls_is_told() {
    let square = |low: f64, high: f64| json!([[low, low], [high, low], [high, high], [low, high]]);
    let room = json!({"outline": square(0.0, 5.0), "obstacles": [square(2.0, 3.0)], "doors": []});
    let point = |x: f64| json!({"x": x, "y": 2.5, "radius": 0.2});
    let motion = json!({"kind": "walk", "speed": 1.3, "ways": [[point(0.5), point(1.0), point(4.0)]]});
    let (made, _) = ok(&mut Lab::default(), with(own(crowd(4, room)), "motion", motion));
    let mut crossed: Vec<(usize, [f64; 2])> = read(&made["scene"]["crossed"]);
    crossed.sort_by(|one, other| one.1[0].total_cmp(&other.1[0]));
    assert_eq!(crossed, [(0, [2.0, 2.5]), (0, [3.0, 2.5])]);
}

/// A room that is drawn: a door a quarter of the way up the wall on the right, another one in an obstacle's.
fn drawing() -> Value {
    json!({
        "outline": [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]],
        "obstacles": [[[1.0, 1.0], [2.0, 1.0], [2.0, 2.0]]],
        "doors": [{"at": [4.0, 0.75], "width": 0.5}, {"at": [1.5, 1.0], "width": 0.4}],
    })
}

#[test]
fn a_drawn_room_is_seen_with_its_doors_bounds_and_the_nearest_wall() {
    let mut lab = Lab::default();
    let mut drawn =
        |room: Value, near: Value| ok(&mut lab, json!({"ask": "room", "room": room, "near": near})).0;
    let seen = drawn(drawing(), json!([4.2, 2.0]));
    assert_eq!(seen["room"], drawing());
    let doors: Vec<Vec<[f64; 2]>> = read(&seen["doors"]);
    let by_hand = [[[4.0, 0.5], [4.0, 1.0]], [[1.3, 1.0], [1.7, 1.0]]];
    for (found, by_hand) in doors.iter().flatten().flatten().zip(by_hand.as_flattened().as_flattened()) {
        assert!(close(*found, *by_hand, 1e-12), "{doors:?}");
    }
    assert_eq!(seen["rings"][0]["bounds"], json!([4.0, 3.0, 0.0, 0.0]));
    assert_eq!(seen["rings"][1]["bounds"], json!([1.0, 1.0, 1.0, 1.0]));
    assert_eq!((&seen["rings"][0]["upright"], &seen["rings"][1]["upright"]), (&json!(true), &json!(false)));
    assert_eq!(seen["rings"][1]["middles"], json!([[1.5, 1.0], [2.0, 1.5], [1.5, 1.5]]));
    let near = &seen["near"];
    assert_eq!((&near["ring"], &near["side"], &near["at"]), (&json!(0), &json!(1), &json!([4.0, 2.0])));
    assert!(close(near["away"].as_f64().unwrap(), 0.2, 1e-12));
    // On the slope of the obstacle, from (2, 2) to (1, 1): in its middle.
    let near = &drawn(drawing(), json!([1.4, 1.6]))["near"];
    assert_eq!((&near["ring"], &near["side"]), (&json!(1), &json!(2)));
    assert!(close(near["away"].as_f64().unwrap(), 0.02_f64.sqrt(), 1e-12));
    // What cannot be made can still be drawn: walls that cross, far out, with a door that is wider than they are long.
    let odd = json!({"outline": [[0.0, 0.0], [9e3, 9e3], [9e3, 0.0], [0.0, 9e3]], "obstacles": [], "doors": [{"at": [0.0, 1.0], "width": 1e9}]});
    assert_eq!(drawn(odd, Value::Null)["doors"].as_array().unwrap().len(), 1);
}

/// A request to read a drawing with no options.
fn drawn(name: &str) -> Value {
    json!({"ask": "drawing", "name": name, "unit": null, "close": null, "origin": false, "walls": []})
}

#[test]
fn a_geometry_file_becomes_a_room() {
    let mut lab = Lab::default();
    ok(&mut lab, own(crowd(1, square(3.0, 2.0))));
    let (_, zip) = ok(&mut lab, take(1, json!({"file": "trial"})));
    let text = file_in(&zip, "static/Geometry.xml");
    let (found, _) = ask(&mut lab, &drawn("Geometry.xml"), text.as_bytes());
    assert_eq!(found["ok"]["room"]["outline"], square(3.0, 2.0)["outline"], "{found}");
    let broken = text.replacen("Coordinates=\"", "Coordinates=\"east \u{20}", 1);
    let message = refused(&mut lab, drawn("Geometry.xml"), broken.as_bytes());
    assert!(message.contains("Geometry.xml") && message.contains("east"), "{message}");
    // Open walls come along; a room needs a closed one.
    let open = r#"<Wall Id="7" MaterialId="concrete"><Corner Coordinates="1.0,0.0"/><Corner Coordinates="1.0,1.0"/></Wall></Geometry>"#;
    let both = text.replace("</Geometry>", open);
    let (found, _) = ok_of(&mut lab, drawn("Geometry.xml"), both.as_bytes());
    assert_eq!(found["room"]["walls"], json!([{"corners": [[1.0, 0.0], [1.0, 1.0]], "of": null}]));
    let alone = format!("<?xml version=\"1.0\"?><Geometry>{open}");
    let message = refused(&mut lab, drawn("Geometry.xml"), alone.as_bytes());
    assert!(message.contains("none of its 1 walls is closed"), "{message}");
}

#[test]
fn a_drawing_becomes_a_room_with_exits() {
    let mut lab = Lab::default();
    let plan = |name: &str| std::fs::read(repository().join("examples/plans").join(name)).unwrap();
    let (hall, _) = ok_of(&mut lab, drawn("hall.dxf"), &plan("hall.dxf"));
    let names = |of: &Value| -> Vec<String> {
        of.as_array().unwrap().iter().map(|exit| read(&exit["name"])).collect()
    };
    assert_eq!(names(&hall["exits"]), ["north", "south"]);
    assert_eq!((&hall["layers"], hall["distributions"].as_array().unwrap().len()), (&json!([]), 1));
    // As many walls as `lemons room` says.
    let lines: Vec<[String; 2]> = read(&hall["said"]);
    let how = |what: &str| lines.iter().find(|line| line[0] == what).map(|line| line[1].clone()).unwrap();
    assert!(how("walls").starts_with("8: 8 closed"), "{lines:?}");
    assert_eq!(hall["room"]["obstacles"].as_array().unwrap().len(), 7);
    assert!(close(hall["area"].as_f64().unwrap(), how("ground")[..7].parse().unwrap(), 5e-4));
    let office = plan("office.dxf");
    let message = refused(&mut lab, drawn("office.dxf"), &office);
    assert!(
        message.contains("office.dxf: it does not say") && message.contains("mm: 9.00 m x 8.00 m"),
        "{message}"
    );
    let in_mm = with(with(drawn("office.dxf"), "unit", json!(0.001)), "origin", json!(true));
    let (apart, _) = ok_of(&mut lab, in_mm.clone(), &office);
    let (joined, _) = ok_of(&mut lab, with(in_mm, "close", json!(0.05)), &office);
    let walls = |room: &Value| {
        let count = |key: &str| room["room"][key].as_array().map_or(0, Vec::len);
        (count("obstacles"), count("walls"))
    };
    assert_eq!((walls(&apart), walls(&joined)), ((0, 3), (1, 1)));
    assert_eq!(joined["room"]["outline"].as_array().unwrap().len(), 4);
    // People stand in it, and none across the wall that is open.
    let base = with(crowd(30, joined["room"].clone()), "speed", json!(0.0));
    let (made, _) = ok(&mut lab, own(base));
    assert_eq!(made["scene"]["overlapping"], json!([]));
    assert_eq!(made["scene"]["walls"].as_array().unwrap().len(), 3);
    // An exit on a wall is a door, and a line 1 m behind it.
    let text = br#"{"type": "FeatureCollection", "features": [
        {"type": "Feature", "properties": {"layer": "walkablearea"}, "geometry": {"type": "Polygon", "coordinates": [[[0, 0], [8, 0], [8, 6], [0, 6], [0, 0]]]}},
        {"type": "Feature", "properties": {"layer": "exits-door"}, "geometry": {"type": "LineString", "coordinates": [[8, 2], [8, 3]]}}]}"#;
    let (found, _) = ok_of(&mut lab, drawn("room.geojson"), text);
    assert_eq!(found["room"]["doors"], json!([{"at": [8.0, 2.5], "width": 1.0}]));
    assert_eq!(found["exits"], json!([{"name": "door", "corners": [[9.0, 1.0], [9.0, 4.0]]}]));
    for (name, content, words) in [
        ("a.dxf", &b"0\nSECTION\n2\nENTITIES\n0\nLINE\n10\nnorth\n"[..], "a.dxf: line"),
        ("a.geojson", b"{}", "a.geojson: "),
        ("a.wkt", b"POLYGON ((0 0, 1", "a.wkt: "),
        ("a.svg", b"<!DOCTYPE svg [<!ENTITY a \"b\">]><svg/>", "a.svg: "),
    ] {
        let message = refused(&mut lab, drawn(name), content);
        assert!(message.starts_with(words), "{message}");
    }
    let message = refused(&mut lab, with(drawn("a.dxf"), "unit", json!(-1.0)), b"");
    assert!(message.contains("length of a unit [m] = -1"), "{message}");
}

#[test]
fn the_walls_of_an_opened_trial_are_changed_and_nothing_else_is() {
    let mut lab = Lab::default();
    let base = json!({"kind": "example", "name": "push"});
    let (before, _) = ok(&mut lab, own(base.clone()));
    let (_, zip) = ok(&mut lab, take(1, json!({"file": "trial"})));
    let walls = before["scene"]["walls"].as_array().unwrap();
    let further = |wall: &Value| json!({"corners": wall["corners"], "of": wall["id"]});
    let mut room = json!({"outline": [], "obstacles": [], "doors": [], "walls": walls.iter().map(further).collect::<Vec<_>>()});
    let edited = |room: &Value| with(own(base.clone()), "edits", json!([{"do": "room", "room": room}]));
    // Not changed, to the last bit.
    ok(&mut lab, edited(&room));
    assert_eq!(ok(&mut lab, take(2, json!({"file": "trial"}))).1, zip);
    // A wall more, with a door; across the first person.
    let at = [read::<f64>(&json!(numbers(&ok(&mut lab, own(base.clone())).1)[0])), 0.0];
    let new = json!({"corners": [[at[0], -3.0], [at[0], 3.0]], "of": null});
    room["walls"].as_array_mut().unwrap().push(new);
    room["doors"] = json!([{"at": [at[0], 2.0], "width": 1.0}]);
    let (after, _) = ok(&mut lab, edited(&room));
    assert_eq!(after["scene"]["walls"].as_array().unwrap().len(), walls.len() + 2);
    assert_eq!(after["scene"]["overlapping"], json!([0]));
    let notes = texts(&after["notes"]);
    assert!(notes.iter().any(|note| note.contains("disks and walls overlap at the start")), "{notes:?}");
    assert_eq!(after["scene"]["beyond_doors"].as_array().unwrap().len(), 1);
    let (_, changed) = ok(&mut lab, take(4, json!({"file": "trial"})));
    for file in ["Agents.xml", "AgentDynamics.xml", "Materials.xml", "Parameters.xml", "drive.csv"] {
        assert_eq!(file_in(&changed, file), file_in(&zip, file), "{file}");
    }
    let text = file_in(&changed, "Geometry.xml");
    assert_eq!(text.matches("<Wall ").count(), walls.len() + 2, "{text}");
    for (room, words) in [
        (with(room.clone(), "walls", json!([{"corners": [[0.0, 0.0]], "of": null}])), "fewer than two"),
        (
            with(room.clone(), "walls", json!([{"corners": [[0.0, 0.0], [1.0, 0.0]], "of": "none"}])),
            "not there",
        ),
        (with(room.clone(), "doors", json!([{"at": [900.0, 0.0], "width": 1.0}])), "from the nearest wall"),
        (
            with(room.clone(), "walls", json!([{"corners": [[0.0, 0.0], [1e10, 0.0]], "of": null}])),
            "x of a corner",
        ),
    ] {
        let message = refused(&mut lab, edited(&room), &[]);
        assert!(message.contains(words), "{message}");
    }
    let of_crowd = with(own(crowd(2, square(3.0, 3.0))), "edits", json!([{"do": "room", "room": room}]));
    assert!(refused(&mut lab, of_crowd, &[]).contains("has its room already"));
}

#[test]
fn people_are_moved_copied_and_deleted_by_hand() {
    let mut lab = Lab::default();
    let base = crowd(3, square(4.0, 4.0));
    let (_, before) = ok(&mut lab, own(base.clone()));
    let before = numbers(&before);
    let mut edited = own(base);
    edited["edits"] = json!([
        {"do": "move", "id": "1", "x": before[0] + 0.1, "y": before[1], "theta": 0.5},
        {"do": "copy", "id": "2", "as": "2 b", "x": 3.9, "y": 3.9, "theta": 0.0},
        {"do": "delete", "id": "2"},
    ]);
    let (made, after) = ok(&mut lab, edited.clone());
    let (ids, after) = (&made["scene"]["agents"], numbers(&after));
    assert_eq!((&ids[0]["id"], &ids[1]["id"], &ids[2]["id"]), (&json!("0"), &json!("1"), &json!("2 b")));
    assert_eq!(&after[COLUMNS..COLUMNS + 3], [before[0] + 0.1, before[1], 0.5]);
    assert_eq!(after[..6], before[..6], "the others stay");
    // The moved one overlaps the first; the copy is in the corner's walls.
    assert_eq!(made["scene"]["overlapping"], json!([0, 1, 2]));
    assert!(made["scene"]["overlap"].as_f64().unwrap() > 0.05);
    assert_eq!(made["scene"]["people"].as_array().unwrap().len(), 3);
    let asked =
        |x: f64, y: f64| json!({"ask": "overlaps", "run": 2, "agent": 1, "x": x, "y": y, "theta": 0.0});
    let (here, _) = ok(&mut lab, asked(before[0], before[1]));
    assert_eq!((&here["agents"], &here["wall"]), (&json!([0]), &json!(false)));
    assert_eq!(ok(&mut lab, asked(0.05, 2.0)).0["wall"], true);
    for (edit, words) in [
        (json!({"do": "delete", "id": "9"}), "nobody with the Id \"9\""),
        (json!({"do": "copy", "id": "1", "as": "0", "x": 1.0, "y": 1.0, "theta": 0.0}), "there already"),
        (json!({"do": "move", "id": "1", "x": 1e9, "y": 1.0, "theta": 0.0}), "x [m]"),
    ] {
        edited["edits"] = json!([edit]);
        assert!(refused(&mut lab, edited.clone(), &[]).contains(words));
    }
    // A person of a drive file may go; his rows go with him.
    let mut gone = push();
    gone["edits"] = json!([{"do": "delete", "id": "0"}]);
    let (made, _) = ok(&mut lab, gone);
    assert_eq!(made["scene"]["agents"].as_array().unwrap().len(), 4);
    assert_eq!(made["scene"]["pushed"], json!([]));
}

#[test]
fn a_person_of_given_measures_is_put_into_a_crowd() {
    let mut lab = Lab::default();
    let person = json!({"sex": "male", "breadth": 0.52, "depth": 0.29, "stature": 1.9, "mass": 95.0, "altitude": null});
    let mut asked = person.clone();
    asked["ask"] = json!("person");
    let (alone, _) = ok(&mut lab, asked);
    let mut edited = own(crowd(3, square(4.0, 4.0)));
    let put = |id: &str| json!({"do": "put", "id": id, "person": person, "x": 3.0, "y": 2.0, "theta": 0.5});
    edited["edits"] = json!([put("7")]);
    let (made, frame) = ok(&mut lab, edited.clone());
    let scene = &made["scene"];
    assert_eq!(scene["agents"][3]["disks"], alone["disks"]);
    assert_eq!((&scene["agents"][3]["id"], &scene["agents"][3]["mass"]), (&json!("7"), &json!(95.0)));
    assert_eq!(scene["people"][3]["stature"], 1.9);
    let frame = numbers(&frame);
    assert_eq!(frame[3 * COLUMNS..3 * COLUMNS + 3], [3.0, 2.0, 0.5]);
    // With the moment of inertia of these disks, in the files, too.
    let (_, zip) = ok(&mut lab, take(1, json!({"file": "trial"})));
    let agents = file_in(&zip, "static/Agents.xml");
    let inertia = agents.split("MomentOfInertia=\"").nth(4).unwrap().split('"').next().unwrap();
    let wanted = alone["inertia"].as_f64().unwrap();
    assert!((inertia.parse::<f64>().unwrap() / wanted - 1.0).abs() < 1e-6, "{inertia} {wanted}");
    // A light one needs a shorter step, which the engine proposes; a round crowd gets one disk more, of the same area.
    let mut round = crowd(3, square(4.0, 4.0));
    round["round"] = json!(true);
    let mut edited_round = own(round);
    let mut light = put("7");
    light["person"] = json!({"sex": "female", "breadth": null, "depth": null, "stature": null, "mass": 15.0, "altitude": null});
    let before = ok(&mut lab, edited_round.clone()).0["scene"].take();
    edited_round["edits"] = json!([light]);
    let after = ok(&mut lab, edited_round).0["scene"].take();
    assert_eq!(after["agents"][3]["disks"].as_array().unwrap().len(), 1);
    let (step, least) = (&after["mechanical_step"], &before["mechanical_step"]);
    assert!(step.as_f64() < least.as_f64(), "{step} {least}");
    let mut slim = put("8");
    slim["person"]["mass"] = json!(-5.0);
    for (edits, words) in [
        (json!([put("1")]), "there already"),
        (json!([slim]), "mass"),
        (
            json!([{"do": "delete", "id": "0"}, {"do": "delete", "id": "1"}, {"do": "delete", "id": "2"}, put("9")]),
            "nobody",
        ),
    ] {
        edited["edits"] = edits;
        assert!(refused(&mut lab, edited.clone(), &[]).contains(words));
    }
}

#[test]
fn requests_that_are_none_are_refused() {
    let mut lab = Lab::default();
    for request in [&b""[..], b"\xff\xff\xff\x7f{}", b"\x02\0\0\0{}", b"\x03\0\0\0{]}"] {
        let answer = answer(&mut lab, request, &mut |_| ControlFlow::Continue(()));
        assert!(String::from_utf8_lossy(&answer).contains("refused"));
    }
    assert!(refused(&mut lab, advance(0, 1), &[]).contains("run 0 is over"));
    ok(&mut lab, push());
    assert!(refused(&mut lab, advance(1, 1001), &[]).contains("at most 1000"));
    let short = take(1, json!({"file": "fmu", "version": 2, "binaries": [["linux64", 5]]}));
    assert!(refused(&mut lab, short, b"1234").contains("its content is missing"));
    let many = own(crowd(40, square(1.0, 1.0)));
    let message = refused(&mut lab, many, &[]);
    assert!(message.contains("40 people do not fit") && message.contains("about 8 of them do"), "{message}");
    assert!(refused(&mut lab, own(json!({"kind": "example", "name": "moon"})), &[]).contains("moon"));
}

/// A person at rest at a place.
fn moved(id: &str, x: f64, y: f64) -> Value {
    json!({"do": "move", "id": id, "x": x, "y": y, "theta": 0.0})
}

#[test]
fn changes_by_hand_that_do_not_fit_are_left_out_where_that_is_wanted() {
    let mut lab = Lab::default();
    let base = crowd(3, square(8.0, 8.0));
    let (_, before) = ok(&mut lab, own(base.clone()));
    let before = numbers(&before);
    let at = |agent: usize| (before[COLUMNS * agent], before[COLUMNS * agent + 1]);
    let away = |(x, y): (f64, f64)| {
        (0..3).map(|agent| (x - at(agent).0).hypot(y - at(agent).1)).fold(f64::MAX, f64::min)
    };
    let mut corners = [(1.0, 1.0), (1.0, 7.0), (7.0, 1.0), (7.0, 7.0)];
    corners.sort_by(|one, other| away(*other).total_cmp(&away(*one)));
    let [free, also_free, ..] = corners;
    assert!(away(also_free) > 1.0);
    let mut wanted = own(base);
    wanted["fitting"] = json!(true);
    wanted["edits"] = json!([
        moved("0", free.0, free.1),
        moved("1", 0.02, 4.0),
        {"do": "delete", "id": "9"},
        {"do": "copy", "id": "2", "as": "2 b", "x": at(2).0 + 0.05, "y": at(2).1, "theta": 0.0},
        moved("2 b", at(2).0 + 0.06, at(2).1),
        {"do": "copy", "id": "2", "as": "2 c", "x": also_free.0, "y": also_free.1, "theta": 0.0},
    ]);
    let (made, bytes) = ok(&mut lab, wanted.clone());
    let after = numbers(&bytes);
    let ids: Vec<&Value> =
        made["scene"]["agents"].as_array().unwrap().iter().map(|agent| &agent["id"]).collect();
    assert_eq!(ids, [&json!("0"), &json!("1"), &json!("2"), &json!("2 c")]);
    assert_eq!(after[..2], [free.0, free.1]);
    // Who would stand in a wall stays where he was.
    assert_eq!(after[COLUMNS..COLUMNS + 3], before[COLUMNS..COLUMNS + 3]);
    assert_eq!(made["scene"]["overlapping"], json!([]));
    let left_out: Vec<(usize, Value)> = read(&made["left_out"]);
    let left_out: Vec<(usize, &str)> =
        left_out.iter().map(|(k, why)| (*k, why["text"].as_str().unwrap())).collect();
    let words = [
        "person \"1\" would overlap a wall",
        "nobody with the Id \"9\"",
        "\"2 b\" would overlap somebody",
        "\"2 b\"",
    ];
    assert_eq!(left_out.iter().map(|(k, _)| *k).collect::<Vec<_>>(), [1, 2, 3, 4]);
    for ((_, why), words) in left_out.iter().zip(words) {
        assert!(why.contains(words), "{why} {words}");
    }
    // Those that fit are those that the scene has.
    wanted["fitting"] = json!(false);
    wanted["edits"] = json!([wanted["edits"][0], wanted["edits"][5]]);
    assert_eq!(ok(&mut lab, wanted).1, bytes);
}
