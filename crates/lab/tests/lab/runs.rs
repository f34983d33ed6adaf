//! Runs, and questions of pages about frames.

use crate::*;
use lemons_core::plane::{Bounds, Vec2, vec2};
use lemons_core::trial::Wall;
use lemons_picture::{DENSITY_KERNEL, DensityMap};
use lemons_results::measure::SqueezeOverTime;

#[test]
fn a_pulse_gives_its_momentum_to_those_in_the_circle() {
    // One person without floor friction to speak of: a half sine of 100 N over 0.5 s has 2/π of 50 N s.
    let mut lab = Lab::default();
    let base = crowd(1, square(20.0, 20.0));
    let (shown, first) = ok(&mut lab, show(base.clone(), json!({"kind": "none"})));
    let mass = shown["scene"]["agents"][0]["mass"].as_f64().unwrap();
    let at = numbers(&first)[..2].to_vec();
    let pulse = |x: f64| json!({"at": [x, at[1]], "radius": 0.1, "direction": 90, "force": 100.0, "start": 0.2, "duration": 0.5});
    let pushed = show(base.clone(), json!({"kind": "push", "pushes": [pulse(at[0])]}));
    let (shown, _) = ok(&mut lab, pushed);
    assert_eq!(shown["scene"]["pushed"], json!(["0"]));
    let (_, frames) = ok(&mut lab, advance(2, 400));
    // With the floor's friction r = 4.5/s, ∫ m r v dt over all time is the momentum: the way is 2/π · 50 N s / (m r).
    let frames = numbers(&frames);
    let way = frames[frames.len() - COLUMNS + 1] - at[1];
    let expected = 2.0 / std::f64::consts::PI * 50.0 / (mass * 4.5);
    assert!(close(way / expected, 1.0, 5e-3), "{way} {expected}");
    let message = refused(&mut lab, show(base, json!({"kind": "push", "pushes": [pulse(at[0] + 1.0)]})), &[]);
    assert!(message.contains("push 1: nobody stands in its circle"), "{message}");
    // One that is over before the next communication point is told to have no effect.
    let mut short = pulse(at[0]);
    short["duration"] = json!(0.01);
    let short = show(crowd(1, square(20.0, 20.0)), json!({"kind": "push", "pushes": [short]}));
    let (shown, _) = ok(&mut lab, short);
    assert!(shown["notes"][0]["text"].as_str().unwrap().contains("are not applied"), "{}", shown["notes"]);
}

/// A crowd that was made with a speed has a propulsion, which ends as a push begins.
#[test]
fn who_is_pushed_walks_no_more() {
    let mut lab = Lab::default();
    let base = with(with(crowd(1, square(20.0, 20.0)), "speed", json!(1.0)), "direction", json!(0.0));
    let (_, first) = ok(&mut lab, own(base.clone()));
    let first = numbers(&first);
    let (_, walked) = ok(&mut lab, advance(1, 20));
    assert!(numbers(&walked)[19 * COLUMNS] > first[0] + 0.05, "it walks without a push");
    let push = json!({"at": &first[..2], "radius": 0.1, "direction": 90, "force": 100.0, "start": 0.0, "duration": 0.1});
    let (_, at) = ok(&mut lab, show(base, json!({"kind": "push", "pushes": [push]})));
    let at = numbers(&at);
    let (_, pushed) = ok(&mut lab, advance(2, 20));
    let [x, y] = [0, 1].map(|k| numbers(&pushed)[19 * COLUMNS + k] - at[k]);
    assert!(x.abs() < 1e-12 && y > 0.0, "({x}, {y})");
}

#[test]
fn who_is_pushed_may_have_legs() {
    let mut lab = Lab::default();
    let (_, first) = ok(&mut lab, show(crowd(1, square(20.0, 20.0)), json!({"kind": "none"})));
    let first = numbers(&first);
    // Without legs there are no feet.
    assert!(first[COLUMNS - 2].is_nan());
    let push = json!({"at": &first[..2], "radius": 0.1, "direction": 0, "force": 800.0, "start": 0.0, "duration": 0.2});
    let motion = json!({"kind": "push", "pushes": [push], "balance": "pendulum"});
    ok(&mut lab, show(crowd(1, square(20.0, 20.0)), motion));
    let (_, frames) = ok(&mut lab, advance(2, 20));
    let last = &numbers(&frames)[19 * COLUMNS..];
    // The body leans, the feet wait.
    assert!(last[0] > first[0] + 0.02 && last[COLUMNS - 3] == first[0], "{last:?}");
    let shown = [last, &[0.0]].concat().into_iter().flat_map(f64::to_le_bytes).collect::<Vec<u8>>();
    let wanted = json!({"file": "svg", "range": [0, 1], "beyond": false, "from_grey": false, "label": "speed", "unit": "m/s", "time": 0.2, "forces": false});
    let (_, svg) = ok_of(&mut lab, take(2, wanted), &shown);
    assert!(String::from_utf8(svg).unwrap().contains("class=\"leans\""));
}

/// Pages draw whose place is a number, and count as left whose place is none, and whose velocity is one.
#[test]
fn who_comes_later_has_no_place_and_has_not_left() {
    let text = "box = [6, 4]\nnumber = 2\ndoors = [[6, 2, 1]]\nleave = true\ntime_step = 0.05\n\
                [[sources]]\nline = [[1, 1], [1, 3]]\ntimes = [1, 2]\n";
    let mut lab = Lab::default();
    let text = text.as_bytes();
    let (shown, first) = ok_of(&mut lab, opened("arrive.toml", text), text);
    assert_eq!(
        (shown["scene"]["leaving"].as_u64(), shown["scene"]["overlapping"].clone()),
        (Some(4), json!([]))
    );
    let (_, frames) = ok(&mut lab, advance(1, 400));
    let all = [numbers(&first), numbers(&frames)].concat();
    let counts = |frame: &[f64]| {
        let people = frame.chunks(COLUMNS);
        let outside = people.clone().filter(|of| of[0].is_nan() && of[3].is_nan()).count();
        (outside, people.clone().filter(|of| !of[0].is_nan()).count(), people.len())
    };
    let counts: Vec<_> = all.chunks(4 * COLUMNS).map(counts).collect();
    // A frame is at the end of its step.
    let at = |time: f64| counts[(time / 0.05).round() as usize];
    assert_eq!([at(0.0), at(1.0), at(1.05), at(2.05)].map(|of| of.0), [2, 2, 1, 0]);
    let left: Vec<usize> = counts.iter().map(|(outside, there, all)| all - outside - there).collect();
    assert!(left.is_sorted() && left[0] == 0 && *left.last().unwrap() == 4, "{left:?}");
}

#[test]
fn people_walk_to_the_nearer_way_and_arrive() {
    let mut lab = Lab::default();
    let base = with(
        crowd(2, square(4.0, 1.5)),
        "regions",
        part(json!([[0.0, 0.0], [2.0, 0.0], [2.0, 1.5], [0.0, 1.5]])),
    );
    let way = json!([{"x": 3.2, "y": 0.75, "radius": 0.9, "wait": 0.0}]);
    let far = json!([{"x": 50.0, "y": 0.75, "radius": 0.5}]);
    let motion = json!({"kind": "walk", "speed": 1.3, "ways": [far, way]});
    let (shown, _) = ok(&mut lab, show(base, motion));
    assert_eq!(shown["scene"]["ways"], json!([way]));
    assert_eq!(ok(&mut lab, advance(1, 1000)).0["arrived"][999], 2);
    // The Trial that is taken says so itself.
    let (_, zip) = ok(&mut lab, take(1, json!({"file": "trial"})));
    assert_eq!(open(&mut lab, "w.zip", &zip)["scene"]["ways"], json!([way]));
    // It names nobody who is not there any more.
    let mut fewer = opened("w.zip", &zip);
    fewer["edits"] = json!([{"do": "delete", "id": "1"}]);
    let (fewer, _) = ask(&mut lab, &fewer, &zip);
    assert_eq!(fewer["ok"]["scene"]["agents"].as_array().unwrap().len(), 1, "{fewer}");
}

#[test]
fn ways_have_shares() {
    let mut lab = Lab::default();
    let ways = json!([[{"x": 1.0, "y": 1.0, "radius": 0.3}], [{"x": 9.0, "y": 1.0, "radius": 0.3}]]);
    let motion = json!({"kind": "walk", "speed": 1.3, "ways": ways, "shares": [3, 1], "seed": 4});
    let (_, first) = ok(&mut lab, show(crowd(8, square(10.0, 2.0)), motion.clone()));
    let (_, zip) = ok(&mut lab, take(1, json!({"file": "trial"})));
    let decision: toml::Table = file_in(&zip, "decision.toml").parse().unwrap();
    let shares: Vec<_> =
        decision["ways"].as_array().unwrap().iter().map(|way| way["share"].as_float()).collect();
    assert_eq!((shares, decision["seed"].as_integer()), (vec![Some(3.0), Some(1.0)], Some(4)));
    // Three of four go left. Who is there has arrived, and wants to get nowhere.
    let (advanced, frames) = ok(&mut lab, advance(1, 1000));
    let (first, frames) = (numbers(&first), numbers(&frames));
    let last = &frames[frames.len() - 8 * COLUMNS..];
    assert!(first.chunks(COLUMNS).all(|of| of[COLUMNS - 1] == 1.0));
    assert_eq!(last.chunks(COLUMNS).filter(|of| of[0] < 5.0).count(), 6);
    let arrived = last.chunks(COLUMNS).filter(|of| of[COLUMNS - 1] == 0.0).count();
    assert_eq!(json!(arrived), advanced["arrived"][999]);
    let message =
        refused(&mut lab, show(crowd(8, square(10.0, 2.0)), with(motion, "shares", json!([1]))), &[]);
    assert!(message.contains("1 shares of 2 ways"), "{message}");
}

#[test]
fn who_has_left_has_no_place() {
    // Some stand in the exit from the start.
    let mut lab = Lab::default();
    let base = with(crowd(8, square(4.0, 3.0)), "direction", json!(0));
    ok(&mut lab, show(base, json!({"kind": "none"})));
    let (name, zip) = ok(&mut lab, take(1, json!({"file": "trial"})));
    let place = name["name"].as_str().unwrap().trim_end_matches(".zip");
    let decision = b"exits = [{ name = \"right\", polygon = [[3, 0], [4, 0], [4, 3], [3, 3]] }]";
    let zip = zipped_with(&zip, &format!("{place}/decision.toml"), decision);
    // One is pushed as well.
    let drive = b"t,agent,Fp.x,Fp.y,Mp\n0,0,-80,40,3\n9,0,-90,45,3\n";
    let zip = zipped_with(&zip, &format!("{place}/drive.csv"), drive);
    let (shown, first) = ask(&mut lab, &opened("leave.zip", &zip), &zip);
    assert_eq!((&shown["ok"]["scene"]["walk"], &shown["ok"]["scene"]["ways"]), (&json!(true), &json!([])));
    let (advanced, frames) = ok(&mut lab, advance(2, 150));
    let frames = [first, frames].concat();
    let wanted = take(2, json!({"file": "trajectories", "steps": 150}));
    let table = String::from_utf8(ok(&mut lab, wanted).1).unwrap();

    let header: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let column = |name: &str| header.iter().position(|column| *column == name).unwrap();
    let (x, y, there) = (column("x"), column("y"), column("active"));
    let row = |row: &str| row.split(',').map(|cell| cell.parse().unwrap()).collect();
    let rows: Vec<Vec<f64>> = table.lines().skip(1).map(row).collect();
    assert_eq!(rows.len(), 151 * 8);
    for (row, shown) in rows.iter().zip(numbers(&frames).chunks(COLUMNS)) {
        if row[there] != 0.0 {
            assert_eq!(shown[..2], [row[x], row[y]]);
        } else {
            assert!(shown[0].is_nan() && shown[1].is_nan() && shown[6..9] == [0.0; 3]);
        }
    }
    let left = |rows: &[Vec<f64>]| rows.iter().filter(|row| row[there] == 0.0).count();
    let (begin, end) = (left(&rows[..8]), left(&rows[150 * 8..]));
    assert!(begin > 0 && begin < end && end < 8, "{begin} {end}");
    assert!(advanced["arrived"].as_array().unwrap().last().unwrap().as_u64().unwrap() as usize >= end);

    // What is asked of such a frame: nobody who has left presses, is drawn, or crosses a line.
    let last = &frames[frames.len() - 8 * COLUMNS * 8..];
    let (_, forces) = ask(&mut lab, &json!({"ask": "forces", "run": 2, "time": 1.0}), last);
    assert!(numbers(&forces).iter().all(|number| number.is_finite()));
    let look = json!({"file": "svg", "range": [0.0, 1.0], "beyond": false, "from_grey": false, "label": "", "unit": "", "time": 1.5, "forces": true});
    let (_, picture) = ask(&mut lab, &take(2, look), &[last, &[0; 64]].concat());
    assert_eq!(String::from_utf8(picture).unwrap().matches("<title>").count(), 1 + 8 - end);
    let line = json!({"ask": "flow", "run": 2, "line": [[3.2, 0.0], [3.2, 3.0]]});
    assert_eq!(ask(&mut lab, &line, &frames).0["ok"]["crossings"], json!([]));
    let mesh = take(2, json!({"file": "mesh", "format": "obj"}));
    let mesh = String::from_utf8(ask(&mut lab, &mesh, last).1).unwrap();
    let named = mesh.split("agent_").skip(1).filter_map(|rest| rest.split('_').next());
    assert_eq!(named.collect::<std::collections::BTreeSet<_>>().len(), 8 - end);
}

#[test]
fn forces_are_those_of_the_contacts_and_crossings_are_counted_once() {
    let mut lab = Lab::default();
    let pressed = with(with(crowd(12, square(2.2, 2.2)), "direction", json!(0)), "speed", json!(2.0));
    ok(&mut lab, own(pressed));
    let (_, frames) = ok(&mut lab, advance(1, 300));
    let frame = &frames[frames.len() - 8 * COLUMNS * 12..];
    let (value, bytes) = ask(&mut lab, &json!({"ask": "forces", "run": 1, "time": 1.0}), frame);
    assert!(value.get("ok").is_some(), "{value}");
    let forces = numbers(&bytes);
    let of: Vec<&[f64]> = forces.chunks(5).collect();
    // At rest, the mean squeeze of a step is the sum of |F_n| over a body's contacts; those of two count for both.
    let places: Vec<[f64; 2]> = numbers(frame).chunks(COLUMNS).map(|of| [of[0], of[1]]).collect();
    let counts = |force: &[f64]| if places.contains(&[force[2], force[3]]) { 2.0 } else { 1.0 };
    let sum: f64 = of.iter().map(|force| counts(force) * force[4]).sum();
    let squeezes: f64 = numbers(frame).chunks(COLUMNS).map(|of| of[6]).sum();
    assert!(of.iter().any(|force| (force[2] - 2.2).abs() < 0.01), "a wall bears it");
    assert!(squeezes > 1000.0 && close(sum / squeezes, 1.0, 0.01), "{sum} {squeezes}");

    // The row is pushed to the right: everybody who gets beyond the line has crossed it once.
    let mut lab = Lab::default();
    let (_, first) = ok(&mut lab, push());
    let (_, frames) = ok(&mut lab, advance(1, 40));
    let all = [first.clone(), frames.clone()].concat();
    let (x0, x1) = (numbers(&first)[0], numbers(&frames[frames.len() - 8 * 5 * COLUMNS..])[0]);
    let line = 0.5 * (x0 + x1);
    let crossing = |from: f64, to: f64| json!({"ask": "flow", "run": 1, "line": [[line, from], [line, to]]});
    let (value, _) = ask(&mut lab, &crossing(-9.0, 9.0), &all);
    let crossings: Vec<[i64; 3]> = read(&value["ok"]["crossings"]);
    // From left to right of a line that goes up is along +x.
    let of_first: Vec<i64> = crossings.iter().filter(|of| of[1] == 0).map(|of| of[2]).collect();
    assert_eq!(of_first, [1], "{value}");
    assert_eq!(ask(&mut lab, &crossing(90.0, 99.0), &all).0["ok"]["crossings"], json!([]));
    assert!(refused(&mut lab, crossing(0.0, 1.0), &all[1..]).contains("are not frames"));
    assert!(
        refused(&mut lab, json!({"ask": "forces", "run": 1, "time": 1.0}), &all)
            .contains("a frame of 5 people")
    );
}

#[test]
fn a_map_has_the_numbers_of_plots_and_goes_on() {
    let mut lab = Lab::default();
    let (made, first) = ok(&mut lab, own(crowd(6, square(3.0, 2.0))));
    let run = made["scene"]["run"].as_u64().unwrap();
    let rows = |frame: &[u8], squeeze: f64| -> Vec<u8> {
        let row = |of: &[f64]| [of[0], of[1], squeeze];
        numbers(frame).chunks(COLUMNS).flat_map(row).flat_map(f64::to_le_bytes).collect()
    };
    let wall = |of: &Value| {
        let corners = read::<Vec<[f64; 2]>>(&of["corners"]).into_iter().map(Vec2::from).collect();
        Wall::new("", "", corners)
    };
    let asked = |of: &str, fresh: bool| json!({"ask": "map", "run": run, "of": of, "fresh": fresh});
    let one = rows(&first, 100.0);
    let (grid, bytes) = ok_of(&mut lab, asked("density", true), &one);
    assert_eq!(grid["columns"].as_u64().unwrap() * grid["rows"].as_u64().unwrap(), bytes.len() as u64 / 8);
    // As `lemons plot --density` has it in the same part of the plane: 1 m around the walls.
    let walls: Vec<Wall> = made["scene"]["walls"].as_array().unwrap().iter().map(wall).collect();
    let view = Bounds { low: vec2(-1.0, -1.0), high: vec2(4.0, 3.0) };
    let mut map = DensityMap::new(view, DENSITY_KERNEL, &walls);
    map.add(numbers(&first).chunks(COLUMNS).map(|of| vec2(of[0], of[1])));
    assert_eq!(numbers(&bytes), map.values());
    // Frames of squeeze are not added to a map of density, which stays as it was.
    let message = refused(&mut lab, asked("squeeze", false), &rows(&first, 300.0));
    assert!(message.contains("of another quantity"), "{message}");
    let twice = ok_of(&mut lab, asked("density", false), &one).1;
    map.add(numbers(&first).chunks(COLUMNS).map(|of| vec2(of[0], of[1])));
    assert_eq!(numbers(&twice), map.values());
    // The second answer has both frames; a new map has one.
    let (_, both) = ok_of(&mut lab, asked("squeeze", true), &one);
    let more = ok_of(&mut lab, asked("squeeze", false), &rows(&first, 300.0)).1;
    let third = |bytes: &[u8], k: usize| numbers(bytes).chunks(bytes.len() / 24).nth(k).unwrap().to_vec();
    assert_eq!(third(&both, 2).iter().sum::<f64>(), 6.0);
    assert_eq!(third(&more, 2).iter().sum::<f64>(), 12.0);
    let there: Vec<f64> = third(&more, 0).into_iter().filter(|mean| !mean.is_nan()).collect();
    assert!(there.iter().all(|mean| *mean == 200.0), "{there:?}");
    assert!(third(&more, 1).into_iter().filter(|most| !most.is_nan()).all(|most| most == 300.0));
    assert!(refused(&mut lab, asked("density", true), &one[..8]).contains("not frames of 6 people"));
    assert!(
        refused(&mut lab, json!({"ask": "map", "run": 99, "of": "density", "fresh": true}), &one)
            .contains("over")
    );
}

/// Two people, of whom one is pressed with 800 N from 2 to 2.5 s and from 4 to 5 s, and one has left after 2.5 s, pressed with
/// 400 N since 2 s. Means over a second are above 300 N from 2.375 to 3.125 s and from 4.375 to 5.625 s; those of the other
/// from 2.75 s on, but who has left does not count.
#[test]
fn time_above_a_limit_is_that_of_the_library() {
    let mut lab = Lab::default();
    let step = 0.05;
    let frames: Vec<[f64; 2]> = (0..=160_u32)
        .map(|k| match k {
            41..=50 => [800.0, 400.0],
            81..=100 => [800.0, f64::NAN],
            _ if k > 50 => [0.0, f64::NAN],
            _ => [0.0, 0.0],
        })
        .collect();
    let bytes =
        |frames: &[[f64; 2]]| frames.concat().into_iter().flat_map(f64::to_le_bytes).collect::<Vec<u8>>();
    let asked = |from: usize, limit: f64, over: f64| json!({"ask": "limit", "number": 1, "people": 2, "step": step, "limit": limit, "over": over, "from": from});
    let (nothing, _) = ok_of(&mut lab, asked(0, 300.0, 1.0), &bytes(&frames[..20]));
    assert!(nothing["above"].is_null(), "shorter than the mean: {nothing}");
    let (half, _) = ok_of(&mut lab, asked(20, 300.0, 1.0), &bytes(&frames[20..55]));
    assert_eq!(half["above"]["people"], 1);
    let worst = |told: &Value, squeeze: f64, at: f64| {
        let worst = &told["worst"];
        assert_eq!(worst["who"], 0);
        let near = |name: &str, expected| close(worst[name].as_f64().unwrap(), expected, 1e-9);
        assert!(near("squeeze", squeeze) && near("at", at), "{worst}");
    };
    assert!(nothing["worst"].is_null());
    worst(&half, 400.0, 2.5);
    let (seen, _) = ok_of(&mut lab, asked(55, 300.0, 1.0), &bytes(&frames[55..]));
    worst(&seen, 800.0, 5.0);
    let seen = &seen["above"];
    let number = |name: &str| seen[name].as_f64().unwrap();
    for (name, expected) in
        [("people", 1.0), ("first", 2.375), ("who", 0.0), ("longest", 1.25), ("time", 2.0)]
    {
        assert!(close(number(name), expected, 1e-9), "{name}: {seen}");
    }
    // The same to the bit as of a library that gets all at once.
    let mut exposure = SqueezeOverTime::new(2, &[300.0], Some(1.0));
    for (k, frame) in frames.iter().enumerate() {
        let squeeze = frame.map(|squeeze| squeeze.is_finite().then_some((squeeze, squeeze)));
        exposure.add(k as f64 * step, squeeze.into_iter());
    }
    let one = exposure.so_far()[0].above[0].unwrap();
    assert_eq!(
        [number("first"), number("longest"), number("time")],
        [one.first.unwrap(), one.longest, one.time]
    );
    // Frames that are not the next ones, or of another limit.
    for (from, limit) in [(160, 300.0), (161, 200.0)] {
        assert!(refused(&mut lab, asked(from, limit, 1.0), &bytes(&frames[..1])).contains("begin anew"));
    }
    let (long, _) = ok_of(&mut lab, asked(0, 300.0, 0.01), &bytes(&frames));
    assert!(long["above"].is_null(), "a step is longer than the mean: {long}");
    assert!(refused(&mut lab, asked(0, 300.0, 1.0), &[0; 8]).contains("not frames of 2 people"));
}

/// The columns of the table that have these names, a row for each agent and time.
fn rows<const N: usize>(table: &str, names: [&str; N]) -> Vec<[f64; N]> {
    let header: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let places = names.map(|name| header.iter().position(|column| *column == name).unwrap());
    let row = |row: &str| -> [f64; N] {
        let cells: Vec<&str> = row.split(',').collect();
        places.map(|place| cells[place].parse().unwrap())
    };
    table.lines().skip(1).map(row).collect()
}

/// Frames have the chest's columns of the table, and levels add up to its squeeze at each time.
#[test]
fn frames_have_the_load_on_chests_and_at_levels() {
    const PEOPLE: usize = 12;
    let crowd = with(with(crowd(12, square(2.0, 2.0)), "direction", json!(0)), "speed", json!(1.3));
    let (plain, first) = ok(&mut Lab::default(), own(crowd.clone()));
    assert_eq!((&plain["scene"]["chests"], &plain["scene"]["levels"]), (&json!(false), &json!([])));
    assert_eq!((&plain["scene"]["further"], first.len()), (&json!(0), 8 * COLUMNS * PEOPLE));

    let mut lab = Lab::default();
    let (shown, first) = ok(&mut lab, own(with(crowd.clone(), "levels", json!(3))));
    assert_eq!((&shown["scene"]["chests"], &shown["scene"]["further"]), (&json!(true), &json!(8)),);
    assert_eq!(shown["scene"]["levels"], json!([[0.5, 0.9], [0.9, 1.3], [1.3, 1.7]]));
    let frames = [first, ok(&mut lab, advance(1, 120)).1].concat();
    let table = ok(&mut lab, take(1, json!({"file": "trajectories", "steps": 120}))).1;
    let chest = ["chest_force", "chest_wall_force", "chest_front", "chest_side", "chest_least"];
    let table = String::from_utf8(table).unwrap();
    let (chests, squeezes) = (rows(&table, chest), rows(&table, ["normal_force"]));
    let mut pressed = [0; 3];
    for (k, frame) in numbers(&frames).chunks((COLUMNS + 8) * PEOPLE).enumerate() {
        let of = |column: usize, agent: usize| frame[(COLUMNS + column) * PEOPLE + agent];
        for agent in 0..PEOPLE {
            let (row, levels) = (PEOPLE * k + agent, [5, 6, 7].map(|column| of(column, agent)));
            assert_eq!([0, 1, 2, 3, 4].map(|column| of(column, agent)), chests[row]);
            let (sum, [squeeze]) = (levels.iter().sum::<f64>(), squeezes[row]);
            assert!(close(sum, squeeze, 1e-9 * squeeze.max(1.0)), "{levels:?} of {squeeze} N");
            [0, 1, 2].into_iter().for_each(|level| pressed[level] += i32::from(levels[level] > 1.0));
        }
    }
    assert!(pressed.iter().all(|count| *count > 50), "{pressed:?}");
    // What a page sends back is the first part of a frame.
    let last = &frames[frames.len() - 8 * (COLUMNS + 8) * PEOPLE..];
    let (_, forces) =
        ask(&mut lab, &json!({"ask": "forces", "run": 1, "time": 1.2}), &last[..8 * COLUMNS * PEOPLE]);
    assert!(!forces.is_empty());

    // In the plan there may be chests without levels.
    let (plan, first) = ok(&mut lab, own(with(crowd, "levels", json!(1))));
    assert_eq!((&plan["scene"]["chests"], &plan["scene"]["levels"]), (&json!(true), &json!([])));
    assert_eq!((&plan["scene"]["further"], first.len()), (&json!(5), 8 * (COLUMNS + 5) * PEOPLE));
}

/// A low wall presses the lowest level alone; the picture of another height does not show it.
#[test]
fn a_low_wall_presses_the_lowest_level() {
    let base = with(
        with(with(crowd(1, square(1.0, 1.0)), "direction", json!(0)), "speed", json!(1.3)),
        "levels",
        json!(3),
    );
    let mut lab = Lab::default();
    ok(&mut lab, own(base));
    let (_, zip) = ok(&mut lab, take(1, json!({"file": "trial"})));
    let geometry = file_in(&zip, "Geometry.xml");
    let low = geometry.replace("<Wall ", "<Wall Top=\"0.9\" ");
    assert!(low != geometry);
    let zip = changed(&zip, &geometry, &low);
    let shown = open(&mut lab, "low.zip", &zip);
    assert_eq!(shown["scene"]["walls"][0]["heights"], json!([0.0, 0.9]));
    let (_, frames) = ok(&mut lab, advance(2, 200));
    let last = numbers(&frames[frames.len() - 8 * (COLUMNS + 8)..]);
    let [.., low, middle, high] = last[..] else { unreachable!() };
    assert!(low > 100.0 && middle == 0.0 && high == 0.0, "{low} {middle} {high} N");

    let frame = &frames[frames.len() - 8 * (COLUMNS + 8)..][..8 * COLUMNS];
    let mut picture = |height: f64| {
        let look = json!({"file": "svg", "range": [0.0, 1.0], "beyond": false, "from_grey": true, "label": "", "unit": "", "time": 2.0, "forces": false, "height": height});
        let (_, svg) = ok_of(&mut lab, take(2, look), &[frame, &[0; 8]].concat());
        let svg = String::from_utf8(svg).unwrap();
        svg.matches("<path").count()
    };
    assert!(picture(0.7) > picture(1.1));
}
