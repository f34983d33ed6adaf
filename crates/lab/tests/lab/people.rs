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
    let said = refused(&mut lab, broad, &[]);
    assert!(said.contains("50") && said.contains("breadth"), "{said}");
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
    let said = refused(&mut lab, own(with(base, "friction", json!(3))), &[]);
    assert!(said.contains("friction") && said.contains('3'), "{said}");
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
    let of = json!({"kind": "table", "files": [["female", "t.csv", table.len()]]});
    let (shown, _) = ask(&mut lab, &own(base(of.clone(), 0.0)), table.as_bytes());
    assert_eq!(shown["ok"]["scene"]["people"][29]["breadth"], 0.4, "{shown}");
    let wrong = table.replace("400", "4000");
    let of = json!({"kind": "table", "files": [["female", "t.csv", wrong.len()]]});
    let said = refused(&mut lab, own(base(of, 0.0)), wrong.as_bytes());
    assert!(said.contains("t.csv") && said.contains("4000"), "{said}");
}
