//! People: their shapes, bodies, sections, and crowds of them.

use crate::*;
use std::f64::consts::PI;

#[test]
fn a_person_has_the_breadth_and_depth_that_are_asked_for_and_a_rank() {
    let mut lab = Lab::default();
    let person =
        json!({"ask": "person", "sex": "male", "breadth": 0.5, "depth": 0.3, "stature": 1.8, "mass": null});
    let (is, _) = ok(&mut lab, person);
    let disks: Vec<[f64; 3]> = read(&is["disks"]);
    let most =
        |along: fn(&[f64; 3]) -> f64| disks.iter().map(|disk| along(disk) + disk[2]).fold(0.0, f64::max);
    assert!((most(|disk| disk[1]) - 0.25).abs() < 1e-12);
    let depth = most(|disk| disk[0]) + most(|disk| -disk[0]);
    assert!((depth - 0.3).abs() < 1e-12, "{depth}");
    // Men are 1.756 m tall on average; the mass is the median.
    let rank = |k: usize| is["measures"][k]["rank"].as_f64().unwrap();
    assert!((rank(2) - 0.74).abs() < 0.02 && (rank(3) - 0.5).abs() < 0.01, "{is}");
    let broad = json!({"ask": "person", "sex": "male", "breadth": 50});
    let message = refused(&mut lab, broad, &[]);
    assert!(message.contains("50") && message.contains("breadth"), "{message}");
}

fn area(polygon: &Value) -> f64 {
    let points: Vec<[f64; 2]> = read(polygon);
    let next = points.iter().cycle().skip(1);
    0.5 * points.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>().abs()
}

#[test]
fn a_body_has_the_volume_of_its_mass_and_its_sections_their_breadth() {
    let mut lab = Lab::default();
    let of = |ask: &str| json!({"ask": ask, "sex": "female", "breadth": 0.45, "depth": 0.25, "stature": 1.65, "mass": 65.0, "altitude": 1.2});
    let (counts, bytes) = ok(&mut lab, of("body"));
    let (vertices, triangles) = (counts["vertices"].as_u64().unwrap(), counts["triangles"].as_u64().unwrap());
    assert_eq!(bytes.len() as u64, 12 * (vertices + triangles));
    let (places, corners) = bytes.split_at(12 * vertices as usize);
    let place =
        |k: usize, axis: usize| f32::from_le_bytes(places[12 * k + 4 * axis..][..4].try_into().unwrap());
    let mut volume = 0.0;
    for triangle in corners.chunks(12) {
        let [a, b, c] =
            [0, 4, 8].map(|at| u32::from_le_bytes(triangle[at..at + 4].try_into().unwrap()) as usize);
        let [a, b, c] = [a, b, c].map(|k| [0, 1, 2].map(|axis| f64::from(place(k, axis))));
        volume += a[0] * (b[1] * c[2] - b[2] * c[1])
            + a[1] * (b[2] * c[0] - b[0] * c[2])
            + a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
    assert!(close(volume / 6.0 * 985.0, 65.0, 0.3), "{}", volume / 6.0);
    let (is, _) = ok(&mut lab, of("person"));
    let sum: f64 = is["sections"].as_array().unwrap().iter().map(area).sum();
    assert!((0.05..0.12).contains(&sum), "{sum}");
    let (bicycle, _) = ok(&mut lab, json!({"ask": "bicycle"}));
    assert_eq!(bicycle["rectangles"][0].as_array().unwrap().len(), 4);
}

#[test]
fn everybody_has_sections_and_bodies_also_where_only_disks_are_known() {
    let mut lab = Lab::default();
    ok(&mut lab, own(crowd(3, square(3.0, 3.0))));
    let (made, _) = ok(&mut lab, json!({"ask": "sections", "run": 1, "altitude": 1.3}));
    assert_eq!((made["cut"].as_u64(), made["estimated"].as_bool()), (Some(3), Some(false)));
    let outlines: Vec<Vec<Value>> = read(&made["bodies"]);
    let by_hand: f64 = outlines.iter().flatten().map(area).sum();
    assert!(close(made["area"].as_f64().unwrap(), by_hand, 1e-9));
    assert_eq!(ok(&mut lab, json!({"ask": "sections", "run": 1, "altitude": 2.9})).0["cut"], 0);
    let (counts, bytes) = ok(&mut lab, json!({"ask": "bodies", "run": 1}));
    let counts: Vec<[usize; 2]> = read(&counts["agents"]);
    assert_eq!(bytes.len(), 12 * counts.as_flattened().iter().sum::<usize>());
    // An opened Trial: bodies are as broad as the disks.
    let (shown, _) = ok(&mut lab, push());
    assert!(shown["scene"]["people"].is_null());
    let (made, _) = ok(&mut lab, json!({"ask": "sections", "run": 2, "altitude": 1.4}));
    assert_eq!((made["cut"].as_u64(), made["estimated"].as_bool()), (Some(5), Some(true)));
    assert!(refused(&mut lab, take(2, json!({"file": "population"})), &[]).contains("make a crowd"));
}

/// Of people in levels, a section is of the engine's disks at that height: none above the slabs.
#[test]
fn sections_of_people_in_levels_are_their_disks() {
    let mut lab = Lab::default();
    let (shown, _) = ok(&mut lab, own(with(crowd(3, square(3.0, 3.0)), "levels", json!(2))));
    let mut at = |altitude: f64| ok(&mut lab, json!({"ask": "sections", "run": 1, "altitude": altitude})).0;
    let [low, again, high] = [at(0.7), at(1.0), at(1.3)];
    assert_eq!((low["cut"].as_u64(), at(1.75)["cut"].as_u64()), (Some(3), Some(0)));
    assert!(low["area"] == again["area"] && low["area"] != high["area"]);
    let (mut sum, mut disks) = (0.0, 0);
    for agent in shown["scene"]["agents"].as_array().unwrap() {
        let own: Vec<[f64; 3]> = read(&agent["disks"]);
        let heights: Vec<[f64; 2]> = read(&agent["heights"]);
        let there = own.iter().zip(&heights).filter(|(_, [bottom, top])| (bottom..top).contains(&&0.7));
        there.for_each(|([.., radius], _)| (sum, disks) = (sum + PI * radius * radius, disks + 1));
    }
    // Five disks overlap: their union has less area than their sum, and more than the largest.
    let union = low["area"].as_f64().unwrap();
    assert!(disks == 15 && union < sum && union > 0.2 * sum, "{disks} disks, {union} of {sum} m²");
}

#[test]
fn a_crowd_is_placed_without_overlap_with_progress_and_the_same_for_the_same_seed() {
    let forty = own(crowd(40, square(4.0, 4.0)));
    let (made, first) = ok(&mut Lab::default(), forty.clone());
    assert!(made["made"]["largest_overlap"].as_f64().unwrap() <= 1e-4);
    assert_eq!(made["scene"]["overlapping"], json!([]));
    assert_eq!((made["scene"]["agents"].as_array().unwrap().len(), first.len()), (40, 40 * 8 * COLUMNS));
    assert_eq!(ok(&mut Lab::default(), forty).1, first);
    let mut lab = Lab::default();
    let request = bytes_of(&own(crowd(100, square(4.0, 4.0))), &[]);
    let mut heard = 0;
    let stopped = answer(&mut lab, &request, &mut |_| {
        heard += 1;
        if heard == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    assert!(heard == 3 && String::from_utf8_lossy(&stopped).contains("the placing was stopped"));
    assert!(refused(&mut lab, take(0, json!({"file": "trial"})), &[]).contains("run 0 is over"));
}

#[test]
fn bodies_may_be_round_and_people_have_another_friction() {
    let mut lab = Lab::default();
    let base = crowd(12, square(3.0, 3.0));
    let (real, _) = ok(&mut lab, own(base.clone()));
    let other = with(with(base.clone(), "round", json!(true)), "friction", json!(0.05));
    let (made, _) = ok(&mut lab, own(other));
    assert_eq!(made["scene"]["overlapping"], json!([]));
    assert!(made["scene"]["mechanical_step"].as_f64() <= made["scene"]["stable"].as_f64());
    let (_, zip) = ok(&mut lab, take(2, json!({"file": "trial"})));
    let agents = file_in(&zip, "static/Agents.xml");
    for (k, (round, real)) in made["scene"]["agents"]
        .as_array()
        .unwrap()
        .iter()
        .zip(real["scene"]["agents"].as_array().unwrap())
        .enumerate()
    {
        let disks: Vec<[f64; 3]> = read(&round["disks"]);
        let [[x, y, radius]] = disks[..] else { panic!("{round}") };
        assert_eq!((x, y), (0.0, 0.0));
        // The same person: the area of the five disks is that of the request "person".
        let of = &made["scene"]["people"][k];
        assert_eq!((of, &round["mass"]), (&made["scene"]["people"][k], &real["mass"]));
        let mut asked = of.clone();
        asked["ask"] = json!("person");
        let area = ok(&mut lab, asked).0["area"].as_f64().unwrap();
        assert!((PI * radius * radius / area - 1.0).abs() < 1e-9);
        // That of a disk, m r² / 2.
        let inertia = agents.split("MomentOfInertia=\"").nth(k + 1).unwrap().split('"').next().unwrap();
        let wanted = 0.5 * round["mass"].as_f64().unwrap() * radius * radius;
        assert!((inertia.parse::<f64>().unwrap() / wanted - 1.0).abs() < 1e-6);
    }
    let materials = file_in(&zip, "static/Materials.xml");
    let contacts: Vec<&str> =
        materials.lines().filter(|line| line.contains("<Contact") && line.contains("human_naked")).collect();
    assert!(
        !contacts.is_empty() && contacts.iter().all(|line| line.contains("KineticFriction=\"0.05\"")),
        "{materials}"
    );
    let message = refused(&mut lab, own(with(base, "friction", json!(3))), &[]);
    assert!(message.contains("friction") && message.contains('3'), "{message}");
}

#[test]
fn populations_are_the_survey_own_statistics_or_tables() {
    let mut lab = Lab::default();
    let base = |people: Value, men: f64| {
        with(with(crowd(30, square(6.0, 6.0)), "people", people), "men", json!(men))
    };
    let four = |breadth: f64| {
        json!({"breadth": [breadth, 0.01, 0.3, 0.65], "depth": [0.2, 0.01, 0.15, 0.45],
               "stature": [1.7, 0.05, 1.4, 2.1], "mass": [70.0, 5.0, 30.0, 130.0]})
    };
    let statistics = json!({"kind": "statistics", "male": four(0.6), "female": four(0.4)});
    let (shown, _) = ok(&mut lab, own(base(statistics, 1.0)));
    let people = shown["scene"]["people"].as_array().unwrap();
    let mean = people.iter().map(|person| person["breadth"].as_f64().unwrap()).sum::<f64>() / 30.0;
    assert!(close(mean, 0.6, 0.01) && people.iter().all(|person| person["sex"] == "male"), "{mean}");
    let kinds = shown["made"]["statistics"].as_array().unwrap();
    assert_eq!((kinds.len(), &kinds[0]["kind"], &kinds[0]["count"]), (1, &json!("male"), &json!(30)));
    let breadth = &kinds[0]["measures"][0];
    assert_eq!(breadth["measure"], "bideltoid breadth");
    assert!(close(breadth["mean"].as_f64().unwrap(), mean, 1e-9), "{kinds:?}");
    let table = "bideltoidbreadth,chestdepth,stature,weightkg\n400,200,1600,600\n";
    let tables = |text: &str| {
        let shown = own(base(json!({"kind": "tables", "female": "t.csv"}), 0.0));
        with(shown, "tables", json!([["t.csv", text.len()]]))
    };
    let (shown, _) = ask(&mut lab, &tables(table), table.as_bytes());
    assert_eq!(shown["ok"]["scene"]["people"][29]["breadth"], 0.4, "{shown}");
    let wrong = table.replace("400", "4000");
    let message = refused(&mut lab, tables(&wrong), wrong.as_bytes());
    assert!(message.contains("t.csv") && message.contains("4000"), "{message}");
}

#[test]
fn a_mix_of_kinds_is_drawn_shown_kept_and_walks_at_its_own_speeds() {
    let mut lab = Lab::default();
    let room = with(square(8.0, 6.0), "doors", json!([{"at": [8.0, 3.0], "width": 1.5}]));
    let mix = json!({"adult": 40, "child": 20, "wheelchair": 20, "with-child": 10, "suitcase": 10});
    let base = with(crowd(40, room.clone()), "mix", mix);
    let exits = json!([{"name": "door", "line": [[9.0, 1.0], [9.0, 5.0]], "polygon": null, "share": null}]);
    let decision = json!({"model": "rotational", "desired_speed": 1.34, "exits": exits, "goals": []});
    let walk = |base: &Value| show(base.clone(), json!({"kind": "go", "decision": decision}));
    let (made, _) = ok(&mut lab, walk(&base));
    let scene = &made["scene"];
    assert_eq!(scene["overlapping"], json!([]));
    let agents = scene["agents"].as_array().unwrap();
    let of = |kind: &str| agents.iter().filter(|agent| agent["kind"] == kind).collect::<Vec<_>>();
    let chairs = of("wheelchair");
    assert!(!chairs.is_empty() && !of("child").is_empty(), "{agents:?}");
    for chair in &chairs {
        assert_eq!(
            (chair["things"].as_array().unwrap().len(), chair["things"][0].as_str()),
            (5, Some("frame"))
        );
        // Who sits there is between the wheels.
        let seated: Vec<[f64; 3]> = read(&chair["seated"]);
        assert!(seated.len() == 5 && seated.iter().all(|disk| disk[1].abs() + disk[2] < 0.35), "{seated:?}");
        assert!((0.13..=1.35).contains(&chair["speed"].as_f64().unwrap()), "{chair}");
    }
    assert!(of("adult").iter().all(|adult| adult["things"].is_null() && adult["seated"].is_null()));
    assert_eq!(scene["kinds"]["suitcase"], json!(["suitcase"]));
    assert_eq!(scene["kinds"]["with-child"], json!(["child"]));
    // Frames are lighter than people and as stiff: the step is shorter than that of adults.
    assert_eq!((&scene["mechanical_step"], scene["people"].as_array().unwrap().len()), (&json!(5e-5), 40));
    let (_, zip) = ok(&mut lab, take(1, json!({"file": "trial"})));
    let (texts, decision_kept) = (file_in(&zip, "Agents.xml"), file_in(&zip, "decision.toml"));
    assert_eq!(texts.matches("Kind=\"wheelchair\"").count(), chairs.len());
    assert_eq!(decision_kept.matches("desired_speed").count(), 1 + 40, "{decision_kept}");
    let (_, table) = ok(&mut lab, take(1, json!({"file": "population"})));
    assert!(String::from_utf8(table).unwrap().lines().next().unwrap().ends_with("desired_speed_m_per_s"));
    // In three dimensions with chairs and suitcases, also of the Trial that was kept.
    let bodies = |lab: &mut Lab, run: u64| {
        let (counts, bytes) = ok(lab, json!({"ask": "bodies", "run": run}));
        let (agents, things): (Vec<[usize; 2]>, Vec<[usize; 2]>) =
            (read(&counts["agents"]), read(&counts["things"]));
        let all = agents.iter().chain(&things).flatten().sum::<usize>();
        assert_eq!((bytes.len(), counts["without"].as_u64()), (12 * all, Some(0)));
        things
    };
    let things = bodies(&mut lab, 1);
    assert_eq!(things.iter().filter(|counts| counts[0] > 0).count(), chairs.len() + of("suitcase").len());
    let again = open(&mut lab, "kept.zip", &zip);
    assert!(again["scene"]["people"].is_null() && again["scene"]["agents"][0]["kind"].is_string());
    assert_eq!(bodies(&mut lab, 2), things);
    // By hand: a copy keeps its kind and its speed, whoever is new is of no kind.
    let first = &chairs[0]["id"];
    let person = json!({"sex": "male", "breadth": null, "depth": null, "stature": null, "mass": null});
    let edits = json!([
        {"do": "copy", "id": first, "as": "twin", "x": 20, "y": 20, "theta": 0},
        {"do": "put", "id": "new", "person": person, "x": 25, "y": 20, "theta": 0},
    ]);
    let (made, _) = ok(&mut lab, with(walk(&base), "edits", edits));
    let agents = made["scene"]["agents"].as_array().unwrap();
    let last = &agents[agents.len() - 2..];
    assert_eq!((&last[0]["kind"], &last[0]["speed"]), (&json!("wheelchair"), &chairs[0]["speed"]));
    assert_eq!(
        (&last[1]["kind"], &last[1]["speed"], &last[1]["things"]),
        (&Value::Null, &json!(1.34), &Value::Null)
    );
    // What cannot be.
    for (mix, words) in [
        (json!({"adlt": 1}), "the mix of kinds: there is no kind \"adlt\" (did you mean \"adult\"?)"),
        (json!({"adult": 0}), "the mix of kinds: the shares must sum up to more than 0"),
        (
            json!({"adult": -1, "child": 2}),
            "the mix of kinds: the share of \"adult\" = -1: must not be negative",
        ),
    ] {
        let message = refused(&mut lab, walk(&with(base.clone(), "mix", mix)), &[]);
        assert!(message.starts_with(words), "{message}");
    }
    let message = refused(&mut lab, walk(&with(base.clone(), "round", json!(true))), &[]);
    assert!(message.contains("round bodies are of adults with nothing"), "{message}");
    let full = with(crowd(60, square(5.0, 5.0)), "mix", json!({"wheelchair": 1}));
    let message = refused(&mut lab, own(full), &[]);
    // 60 chairs of 0.7 m² have more than 25 m²: about half of them fit.
    let count: f64 =
        message.split("about ").nth(1).and_then(|rest| rest.split(' ').next()?.parse().ok()).unwrap();
    assert!(
        message.starts_with("60 people do not fit on 25.00 m²") && (15.0..36.0).contains(&count),
        "{message}"
    );
    // All kinds, with a picture of each.
    let (kinds, _) = ok(&mut lab, json!({"ask": "kinds"}));
    let kinds = kinds.as_array().unwrap();
    assert_eq!(kinds.len(), lemons_people::Kinds::built_in().unwrap().iter().count());
    assert!(kinds.iter().all(|kind| kind["disks"].as_array().unwrap().len() >= 5));
    assert_eq!(kinds.iter().filter(|kind| !kind["seated"].is_null()).count(), 3);
}
