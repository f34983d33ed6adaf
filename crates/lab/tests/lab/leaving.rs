//! Exits and goals that are drawn on the page.

use crate::*;

fn line(name: &str, [a, b, c, d]: [f64; 4]) -> Value {
    json!({"name": name, "line": [[a, b], [c, d]], "polygon": null, "share": null})
}

fn go(exits: &[Value], goals: &[Value]) -> Value {
    json!({"kind": "go", "decision": {
        "model": "rotational", "desired_speed": 1.34, "seed": 1,
        "exits": exits, "goals": goals, "agents": {},
    }})
}

/// Four metres by three, with a door on the right.
fn room() -> Value {
    with(square(4.0, 3.0), "doors", json!([{"at": [4.0, 1.5], "width": 1.0}]))
}

fn trial(lab: &mut Lab, run: u32) -> (Vec<u8>, String) {
    let (_, zip) = ok(lab, take(run, json!({"file": "trial"})));
    let text = file_in(&zip, "decision.toml");
    (zip, text)
}

#[test]
fn everybody_leaves_beyond_the_door() {
    let mut lab = Lab::default();
    let base = crowd(8, room());
    let (shown, _) = ok(&mut lab, show(base.clone(), json!({"kind": "none"})));
    // A metre beyond, and two metres longer than the door.
    let beyond = &shown["scene"]["beyond_doors"];
    assert_eq!(beyond, &json!([[[5.0, 0.0], [5.0, 3.0]]]));
    assert_eq!((&shown["scene"]["targets"], &shown["scene"]["leaving"]), (&json!([]), &json!(0)));
    let door =
        json!({"name": "door 1", "line": beyond[0], "polygon": null, "share": null, "open": [[0.5, 99.0]]});
    let (shown, first) = ok(&mut lab, show(base, go(&[door], &[])));
    assert_eq!(
        shown["scene"]["targets"],
        json!([{"name": "door 1", "stay": false, "corners": [[5.0, 0.0], [5.0, 3.0]], "open": [[0.5, 99.0]]}])
    );
    assert_eq!(shown["scene"]["leaving"], 8);
    assert_eq!(first.len(), 8 * 8 * COLUMNS);
    ok(&mut lab, advance(2, 1000));
    let (_, last) = ok(&mut lab, advance(2, 1));
    assert!(numbers(&last).chunks(COLUMNS).all(|of| of[0].is_nan()));

    let (zip, text) = trial(&mut lab, 2);
    let decision: toml::Table = text.parse().unwrap();
    assert_eq!(decision["model"].as_str(), Some("rotational"));
    assert_eq!(decision["exits"][0]["name"].as_str(), Some("door 1"), "{text}");
    assert_eq!(decision["exits"][0]["open"][0].as_array().unwrap(), &[0.5.into(), 99.0.into()], "{text}");
    assert!(!text.contains("goals") && !text.contains("agents"), "{text}");
    // Opened again, it says the same.
    assert_eq!(open(&mut lab, "leave.zip", &zip)["scene"]["targets"], shown["scene"]["targets"]);
}

#[test]
fn a_wall_closes_a_door_that_is_not_open() {
    let mut lab = Lab::default();
    let doors = json!([{"at": [4.0, 1.5], "width": 1.0, "open": [[2.0, 99.0]]}]);
    let base = crowd(8, with(square(4.0, 3.0), "doors", doors));
    let (shown, _) = ok(&mut lab, show(base, go(&[line("street", [5.0, 0.0, 5.0, 3.0])], &[])));
    let walls = shown["scene"]["walls"].as_array().unwrap();
    assert_eq!(walls.len(), 2);
    assert_eq!((walls[0].get("open"), &walls[1]["open"]), (None, &json!([[2.0, 99.0]])));
    assert_eq!(walls[1]["corners"], json!([[4.0, 1.0], [4.0, 2.0]]));
    let (_, frames) = ok(&mut lab, advance(1, 200));
    assert!(numbers(&frames).chunks(COLUMNS).all(|of| of[0] < 4.0));
    let (_, frames) = ok(&mut lab, advance(1, 1000));
    assert!(numbers(&frames).chunks(COLUMNS).rev().take(8).all(|of| of[0].is_nan()));
}

#[test]
fn of_several_exits_people_take_the_quickest_unless_they_have_shares() {
    let mut lab = Lab::default();
    let exits = [line("right", [3.0, 1.0, 3.0, 2.0]), line("left", [0.5, 1.0, 0.5, 2.0])];
    let mut choice = |exits: &[Value], run| {
        ok(&mut lab, show(crowd(5, room()), go(exits, &[])));
        let decision: toml::Table = trial(&mut lab, run).1.parse().unwrap();
        decision.get("exit_choice").map(|choice| choice.as_str().unwrap().to_owned())
    };
    assert_eq!(choice(&exits, 1).as_deref(), Some("time"));
    assert_eq!(choice(&exits[..1], 2), None);
    let shares = exits.map(|exit| with(exit, "share", json!(1.0)));
    assert_eq!(choice(&shares, 3), None);
}

#[test]
fn places_that_nobody_can_reach_are_named() {
    let mut lab = Lab::default();
    let mut wrong = |place: Value, exits: &[Value], goals: &[Value], words: &str| {
        let message = refused(&mut lab, show(crowd(3, place), go(exits, goals)), &[]);
        assert!(message.contains(words), "{message}");
    };
    wrong(room(), &[line("the wall", [0.0, 0.5, 0.0, 2.5])], &[], "exit \"the wall\": lies on walls");
    let out = [line("out", [5.0, 0.0, 5.0, 3.0])];
    wrong(square(4.0, 3.0), &out, &[], "no way leads to any exit (\"out\")");
    wrong(square(4.0, 3.0), &[], &out, "no way leads to goal \"out\"");
    wrong(room(), &[line("point", [5.0, 1.0, 5.0, 1.0])], &[], "exit \"point\"");
    wrong(room(), &[], &[], "no way-point and no exit");
    let twice = [line("a", [5.0, 0.0, 5.0, 3.0])];
    wrong(room(), &twice, &twice, "\"a\" is that of another");
}

/// A wall with a gap at its upper end only: what is near in a straight line is far on foot.
#[test]
fn without_exits_everybody_goes_to_the_goal_that_is_nearest_on_foot() {
    let mut lab = Lab::default();
    let mut place = square(4.0, 4.0);
    place["obstacles"] = json!([[[1.9, 0.01], [2.1, 0.01], [2.1, 3.0], [1.9, 3.0]]]);
    let region = json!([[2.4, 0.2], [3.8, 0.2], [3.8, 1.6], [2.4, 1.6]]);
    let base = with(crowd(3, place), "regions", part(region));
    let goals = [line("left", [1.5, 0.3, 1.5, 1.3]), line("above", [2.8, 3.6, 3.6, 3.6])];
    ok(&mut lab, show(base.clone(), go(&[], &goals)));
    let decision: toml::Table = trial(&mut lab, 1).1.parse().unwrap();
    for id in ["0", "1", "2"] {
        assert_eq!(decision["agents"][id]["goal"].as_str(), Some("above"), "{decision}");
    }
    // Whom one sends to the other, goes there; nobody asks about those who are deleted.
    let mut other = go(&[], &goals);
    other["decision"]["agents"] =
        json!({"0": {"exit": null, "goal": "left"}, "1": {"exit": null, "goal": "left"}});
    let mut shown = show(base, other);
    shown["edits"] = json!([{"do": "delete", "id": "1"}]);
    ok(&mut lab, shown);
    let decision: toml::Table = trial(&mut lab, 2).1.parse().unwrap();
    let agents = decision["agents"].as_table().unwrap();
    let goal = |id: &str| agents[id]["goal"].as_str().unwrap();
    assert_eq!((agents.len(), goal("0"), goal("2")), (2, "left", "above"));
}
