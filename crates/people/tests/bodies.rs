//! Bodies against what they are to follow: a person's measures, Euler's and Gauss's theorems, other tools' readers.

use lemons_core::plane::{Pose, Vec2, vec2};
use lemons_people::*;
use std::collections::BTreeMap;

/// A hundred men, a hundred women; each measure within 2.5 SDs.
fn people() -> Vec<Person> {
    let drawn = |sex: Sex| {
        let men = if sex == Sex::Male { 1.0 } else { 0.0 };
        let usual = |person: &Person| {
            let mut all = person.measures().into_iter().zip(&ansur(sex).measures);
            all.all(|(value, survey)| (value - survey.mean).abs() <= 2.5 * survey.sd)
        };
        let population = Population::new(PopulationSource::ansur().unwrap(), men).unwrap();
        let people = population.agents(2012).flat_map(|agent| agent.people()).map(|(person, _)| person);
        people.filter(usual).take(100).collect::<Vec<_>>()
    };
    Sex::ALL.into_iter().flat_map(drawn).collect()
}

/// With the survey's mean measures.
fn mean_person(sex: Sex) -> Person {
    Person::from_measures(sex, std::array::from_fn(|k| ansur(sex).measures[k].mean))
}

fn mean_body(sex: Sex) -> Body3d {
    Body3d::of(&mean_person(sex)).unwrap()
}

/// \[m\] Girth of an outline.
fn girth(polygon: &BodySlice) -> f64 {
    let around = polygon.points.iter().zip(polygon.points.iter().cycle().skip(1));
    around.map(|(&a, &b)| (b - a).norm()).sum()
}

fn extent(polygons: &[BodySlice], along: fn(&Vec2) -> f64) -> f64 {
    let all = || polygons.iter().flat_map(|polygon| &polygon.points).map(along);
    all().fold(f64::MIN, f64::max) - all().fold(f64::MAX, f64::min)
}

fn area(body: &Body3d, z: f64) -> f64 {
    body.slice_at(z).iter().map(BodySlice::area).sum()
}

fn surfaces((body, pose): &(&Body3d, Pose)) -> Vec<MeshPart> {
    body.surfaces("0", pose).collect()
}

fn sum_of_areas(section: &CrowdSection) -> f64 {
    section.bodies.iter().flatten().map(BodySlice::area).sum()
}

fn volume(mesh: &[MeshPart]) -> f64 {
    mesh.iter().map(|part| signed_volume(&part.vertices, &indices(part))).sum()
}

/// Triangles about a fixed point, apart from the library's own sums.
fn signed_volume(vertices: &[[f64; 3]], triangles: &[[usize; 3]]) -> f64 {
    let six: f64 = triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|k| vertices[k]);
            a[0] * (b[1] * c[2] - b[2] * c[1])
                + a[1] * (b[2] * c[0] - b[0] * c[2])
                + a[2] * (b[0] * c[1] - b[1] * c[0])
        })
        .sum();
    six / 6.0
}

/// Every edge twice, once in each direction; V − E + F = 2.
fn assert_closed(vertices: usize, triangles: &[[usize; 3]], name: &str) {
    let mut edges: BTreeMap<(usize, usize), i32> = BTreeMap::new();
    for t in triangles {
        assert!(t[0] != t[1] && t[1] != t[2] && t[2] != t[0], "{name}: {t:?}");
        for k in 0..3 {
            *edges.entry((t[k], t[(k + 1) % 3])).or_default() += 1;
        }
    }
    for (&(a, b), &count) in &edges {
        assert_eq!((count, edges.get(&(b, a))), (1, Some(&1)), "{name}: edge {a}-{b}");
    }
    assert_eq!(vertices as i64 - edges.len() as i64 / 2 + triangles.len() as i64, 2, "{name}: Euler");
}

fn indices(part: &MeshPart) -> Vec<[usize; 3]> {
    part.triangles.iter().map(|t| t.map(|k| k as usize)).collect()
}

#[test]
fn two_hundred_bodies_follow_their_people() {
    let mut worst_volume = 0.0f64;
    for person in people() {
        let body = Body3d::of(&person).unwrap();
        let torso = body.slice_at(body.torso_altitude());
        assert_eq!(body.torso_altitude(), 0.8124 * person.stature);
        assert!((extent(&torso, |p| p.y) - person.breadth).abs() < 1e-3, "{person:?}");
        assert!((extent(&torso, |p| p.x) - person.depth).abs() < 1e-3, "{person:?}");
        // From the ground to the stature, and nothing beyond.
        assert_eq!(body.slice_at(0.0).len(), 2);
        assert_eq!(body.slice_at(person.stature).len(), 1);
        assert!(body.slice_at(-1e-9).is_empty() && body.slice_at(person.stature + 1e-9).is_empty());
        let tops = body.mesh().iter().flat_map(|part| &part.vertices).fold(f64::MIN, |z, v| z.max(v[2]));
        assert_eq!(tops, person.stature);
        worst_volume = worst_volume.max((body.volume() / (person.mass / 985.0) - 1.0).abs());
    }
    assert!(worst_volume < 0.1, "{worst_volume}");
}

#[test]
fn heavier_people_have_larger_waists() {
    // Waist girth at the navel [m].
    for (sex, survey) in [(Sex::Male, 0.941), (Sex::Female, 0.861)] {
        let mean = mean_person(sex);
        let [lean, usual, heavy] = [-1.5, 0.0, 1.5].map(|heavier| {
            let mass = mean.mass + heavier * ansur(sex).measures[3].sd;
            let body = Body3d::of(&Person { mass, ..mean }).unwrap();
            let trunk = body.slice_at(0.6 * mean.stature).remove(0);
            assert_eq!(trunk.part, BodyPart::Trunk);
            girth(&trunk)
        });
        assert!((usual / survey - 1.0).abs() < 0.06, "{usual} {survey}");
        assert!(heavy > usual + 0.05 && usual > lean + 0.05, "{lean} {usual} {heavy}");
    }
}

#[test]
fn meshes_are_closed_and_face_outwards() {
    for person in people().iter().step_by(10) {
        let body = Body3d::of(person).unwrap();
        let mesh = body.mesh();
        assert_eq!(mesh.len(), 5);
        let coarse = body.coarse_mesh();
        for part in mesh.iter().chain(&coarse) {
            assert_closed(part.vertices.len(), &indices(part), &part.name);
            assert!(signed_volume(&part.vertices, &indices(part)) > 0.0, "{}", part.name);
        }
        assert!((volume(&mesh) / body.volume() - 1.0).abs() < 0.01);
        assert!((volume(&coarse) / body.volume() - 1.0).abs() < 0.05);
        let triangles = |mesh: &[MeshPart]| mesh.iter().map(|part| part.triangles.len()).sum::<usize>();
        assert!(10 * triangles(&coarse) < triangles(&mesh));
        // The area integrated apart from Simpson's exact slabs.
        let areas: Vec<f64> = body.layers(0.002).map(|z| area(&body, z)).collect();
        let mean = areas.iter().sum::<f64>() / areas.len() as f64;
        assert!((mean * person.stature / body.volume() - 1.0).abs() < 2e-3);
    }
}

/// Whatever the custom statistics of the paper can draw, and beyond: closed, rising, breadth and depth.
#[test]
fn nobody_is_too_odd() {
    for case in 0..48 {
        let odd = |size: usize, values: &[f64]| values[case / size % values.len()];
        let (breadth, depth, stature) =
            (odd(2, &[0.3, 0.65]), odd(16, &[0.15, 0.3, 0.45]), odd(4, &[1.4, 2.4]));
        let person =
            Person { sex: Sex::ALL[case % 2], breadth, depth, stature, mass: odd(8, &[30.0, 160.0]) };
        let body = match Body3d::of(&person) {
            Ok(body) => body,
            Err(error) => {
                assert!(depth > breadth, "{error}");
                continue;
            }
        };
        let torso = body.slice_at(body.torso_altitude());
        assert!((extent(&torso, |p| p.y) - breadth).abs() < 1e-3, "{person:?}");
        assert!((extent(&torso, |p| p.x) - depth).abs() < 1e-3, "{person:?}");
        for part in body.mesh() {
            assert_closed(part.vertices.len(), &indices(&part), &part.name);
            assert!(signed_volume(&part.vertices, &indices(&part)) > 0.0);
            assert!(part.vertices.windows(2).all(|pair| pair[1][2] >= pair[0][2]), "{person:?}");
        }
        for z in body.layers(0.05) {
            let slice = body.slice_at(z);
            assert!(slice.iter().all(|polygon| polygon.area() > 0.0), "{person:?} at {z}");
            let placed = [(&body, Pose::default())];
            let (union, sum) = (section(&placed, z).covered(), area(&body, z));
            assert!((union - sum).abs() < 1e-8, "{person:?} at {z}: {union} of {sum}");
            // Left and right mirror each other.
            let side: f64 = slice.iter().map(|polygon| polygon.area() * polygon.centroid().y).sum();
            assert!(side.abs() < 1e-12, "{person:?} at {z}");
        }
    }
}

#[test]
fn nobodies_are_refused_by_name() {
    let man = mean_person(Sex::Male);
    for (person, message) in [
        (Person { breadth: f64::NAN, ..man }, "bideltoid breadth = NaN m"),
        (Person { stature: 0.0, ..man }, "stature = 0 m"),
        (Person { mass: f64::INFINITY, ..man }, "mass = inf kg"),
        (Person { depth: 0.5, breadth: 0.4, ..man }, "must not exceed the bideltoid breadth"),
    ] {
        assert!(Body3d::of(&person).unwrap_err().to_string().contains(message));
    }
}

#[test]
fn sections_of_a_crowd() {
    let bodies: Vec<Body3d> = people().iter().step_by(20).map(|person| Body3d::of(person).unwrap()).collect();
    let apart = |k: usize| Pose { position: vec2(k as f64, -0.5 * k as f64), orientation: 0.7 * k as f64 };
    let crowd: Vec<(&Body3d, Pose)> = bodies.iter().enumerate().map(|(k, body)| (body, apart(k))).collect();
    let mean = 1.4;
    for z in [0.3, mean, 1.5] {
        let cut = section(&crowd, z);
        let own: f64 = bodies.iter().map(|body| area(body, z)).sum();
        // Neither turning nor moving changes areas; apart, nothing is counted twice.
        assert!((sum_of_areas(&cut) - own).abs() < 1e-12 && (cut.covered() - own).abs() < 1e-7, "{z}");
        assert_eq!(cut.cut(), crowd.len());
    }
    // The gaze of the second: its toes lie that way from the axis.
    let feet = section(&crowd[1..2], 0.01);
    let sum = feet.bodies[0].iter().fold(Vec2::zeros(), |sum, foot| sum + foot.centroid());
    let ahead = sum * 0.5 - vec2(1.0, -0.5);
    assert!((libm::atan2(ahead.y, ahead.x) - 0.7).abs() < 1e-9, "{ahead:?}");
    // Two in the same place cover the ground once.
    let twice = [crowd[0], crowd[0]];
    let cut = section(&twice, mean);
    assert!((sum_of_areas(&cut) - 2.0 * cut.covered()).abs() < 1e-7);
    // The tallest alone stands out.
    let tallest = bodies.iter().map(|body| body.torso_altitude() / TORSO_ALTITUDE).fold(0.0, f64::max);
    assert_eq!(section(&crowd, tallest - 1e-9).cut(), 1);
    assert_eq!(section(&crowd, tallest + 0.01).covered(), 0.0);
}

#[test]
fn stl_reads_back() {
    let body = mean_body(Sex::Male);
    let mut file = Vec::new();
    write_stl(&body.mesh(), &mut file).unwrap();
    let mut reader = std::io::Cursor::new(&file);
    let read = stl_io::read_stl(&mut reader).unwrap();
    let count: usize = body.mesh().iter().map(|part| part.triangles.len()).sum();
    assert_eq!((read.faces.len(), file.len()), (count, 84 + 50 * count));
    let vertices: Vec<[f64; 3]> =
        read.vertices.iter().map(|v| [f64::from(v[0]), f64::from(v[1]), f64::from(v[2])]).collect();
    let triangles: Vec<[usize; 3]> = read.faces.iter().map(|face| face.vertices).collect();
    assert!((signed_volume(&vertices, &triangles) / volume(&body.mesh()) - 1.0).abs() < 1e-4);
    for face in &read.faces {
        let [a, b, c] = face.vertices.map(|k| vertices[k]);
        let [u, v] = [b, c].map(|p| [p[0] - a[0], p[1] - a[1], p[2] - a[2]]);
        let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let ahead: f64 = (0..3).map(|k| n[k] * f64::from(face.normal[k])).sum();
        assert!(ahead >= -1e-12, "{face:?}");
    }
}

#[test]
fn obj_of_a_crowd_reads_back() {
    let bodies = Sex::ALL.map(mean_body);
    let pose = |x: f64, orientation: f64| Pose { position: vec2(x, 2.0), orientation };
    let crowd = [(&bodies[0], pose(0.0, 1.0)), (&bodies[1], pose(0.6, -2.0))];
    let mut file = Vec::new();
    let parts: Vec<MeshPart> = crowd.iter().flat_map(surfaces).collect();
    write_obj(parts.clone(), &mut file).unwrap();
    let (models, _) = tobj::load_obj_buf(&mut file.as_slice(), &tobj::LoadOptions::default(), |_| {
        Err(tobj::LoadError::OpenFileFailed)
    })
    .unwrap();
    let names: Vec<&str> = models.iter().map(|model| model.name.as_str()).collect();
    assert_eq!(names.len(), 10);
    assert_eq!((names[0], names[9]), ("agent_0_trunk", "agent_0_right_leg"));
    let mut volume = 0.0;
    for model in &models {
        let (places, corners) = (model.mesh.positions.as_chunks().0, model.mesh.indices.as_chunks().0);
        let vertices: Vec<[f64; 3]> = places.iter().map(|v: &[f32; 3]| v.map(f64::from)).collect();
        let triangles: Vec<[usize; 3]> = corners.iter().map(|t: &[u32; 3]| t.map(|k| k as usize)).collect();
        volume += signed_volume(&vertices, &triangles);
    }
    let wanted = bodies[0].volume() + bodies[1].volume();
    assert!((volume / wanted - 1.0).abs() < 0.01, "{volume} {wanted}");
}

#[test]
fn geojson_and_wkt_read_back() {
    let body = mean_body(Sex::Female);
    let placed = [(&body, Pose { position: vec2(3.0, 1.0), orientation: 0.4 })];
    let sections: Vec<CrowdSection> = body.layers(0.05).map(|altitude| section(&placed, altitude)).collect();
    let ring_area = |ring: &[[f64; 2]]| {
        assert_eq!(ring.first(), ring.last());
        0.5 * ring.windows(2).map(|p| p[0][0] * p[1][1] - p[1][0] * p[0][1]).sum::<f64>()
    };

    let mut file = Vec::new();
    write_geojson(&sections, &mut file).unwrap();
    let read: serde_json::Value = serde_json::from_slice(&file).unwrap();
    assert!(std::str::from_utf8(&file).unwrap().parse::<geojson::GeoJson>().is_ok());
    let polygons = sections.iter().flat_map(|s| s.bodies[0].iter().map(move |polygon| (s.altitude, polygon)));
    let polygons: Vec<(f64, &BodySlice)> = polygons.collect();
    let features = read["features"].as_array().unwrap();
    assert_eq!(features.len(), polygons.len());
    for (feature, (altitude, polygon)) in features.iter().zip(polygons) {
        let about = &feature["properties"];
        assert_eq!((&about["body"], &about["part"]), (&0.into(), &polygon.part.name().into()));
        assert!((about["altitude"].as_f64().unwrap() - altitude).abs() < 1e-6);
        let ring: Vec<[f64; 3]> =
            serde_json::from_value(feature["geometry"]["coordinates"][0].clone()).unwrap();
        assert!(ring.iter().all(|p| (p[2] - altitude).abs() < 1e-6));
        let ring: Vec<[f64; 2]> = ring.iter().map(|p| [p[0], p[1]]).collect();
        assert!((ring_area(&ring) - polygon.area()).abs() < 1e-6);
    }

    let mut file = Vec::new();
    write_wkt(&sections, &mut file).unwrap();
    let text = String::from_utf8(file).unwrap();
    assert_eq!(text.lines().count(), sections.len());
    for (line, section) in text.lines().zip(&sections) {
        let wkt::Wkt::MultiPolygon(read) = line.parse::<wkt::Wkt<f64>>().unwrap() else { panic!("{line}") };
        let area = |polygon: &wkt::types::Polygon<f64>| {
            let coords = polygon.rings()[0].coords();
            assert!(coords.iter().all(|c| (c.z.unwrap() - section.altitude).abs() < 1e-6));
            ring_area(&coords.iter().map(|c| [c.x, c.y]).collect::<Vec<_>>())
        };
        let sum: f64 = read.polygons().iter().map(area).sum();
        assert!((sum - sum_of_areas(section)).abs() < 1e-6, "{line}");
    }
}

/// Poses that no file can hold are refused, not written.
#[test]
fn poses_that_are_not_finite_are_refused() {
    let body = mean_body(Sex::Male);
    let lost = [(&body, Pose { position: vec2(f64::NAN, 0.0), orientation: 0.0 })];
    let cut = [section(&lost, 1.0)];
    assert!(cut[0].covered().is_nan());
    let mut file = Vec::new();
    let parts = surfaces(&lost[0]);
    assert!(write_obj(parts.clone(), &mut file).unwrap_err().to_string().contains("not finite"));
    assert!(write_stl(&parts, &mut file).is_err());
    assert!(write_geojson(&cut, &mut file).is_err() && write_wkt(&cut, &mut file).is_err());
}

/// Outlines of the mean bodies at landmarks, against the survey's girths and breadths \[m\].
#[test]
fn mean_bodies_have_the_surveys_girths() {
    // Buttocks, waist, lower thigh just above the knee, calf, ankle, head: altitude, girth.
    let men =
        [(0.888, 1.020), (1.056, 0.941), (0.548, 0.409), (0.343, 0.392), (0.108, 0.229), (1.662, 0.574)];
    let women =
        [(0.834, 1.021), (0.980, 0.861), (0.505, 0.401), (0.319, 0.373), (0.098, 0.216), (1.534, 0.561)];
    // Hip breadth, head breadth and length.
    let (man, woman) = ((0.346, 0.154, 0.200), (0.354, 0.148, 0.190));
    for (sex, table, (hip, head, length)) in [(Sex::Male, men, man), (Sex::Female, women, woman)] {
        let body = mean_body(sex);
        for (z, survey) in table {
            let slice = body.slice_at(z);
            let of = |polygon: &&BodySlice| matches!(polygon.part, BodyPart::LeftLeg | BodyPart::Trunk);
            let own = girth(slice.iter().find(of).unwrap());
            assert!((own / survey - 1.0).abs() < 0.06, "{sex:?} at {z}: {own}, survey {survey}");
        }
        let trunk = |z: f64| {
            let slice = body.slice_at(z).into_iter();
            slice.filter(|polygon| polygon.part == BodyPart::Trunk).collect::<Vec<_>>()
        };
        assert!((extent(&trunk(table[0].0), |p| p.y) / hip - 1.0).abs() < 0.06);
        assert!((extent(&trunk(table[5].0), |p| p.y) / head - 1.0).abs() < 0.01);
        assert!((extent(&trunk(table[5].0), |p| p.x) / length - 1.0).abs() < 0.01);
    }
}

/// A person has the same bits on every machine.
#[test]
fn bits_are_kept() {
    let body = mean_body(Sex::Male);
    let vertices = body.mesh().into_iter().flat_map(|part| part.vertices).flatten();
    let sum = vertices.fold(0u64, |sum, value| sum.rotate_left(5) ^ value.to_bits());
    assert_eq!(sum, 0x437a_a0d1_4284_d3f4, "{sum:#x}: a change of shape is told in CHANGELOG");
}

/// A population of one kind.
fn all_of(kinds: &Kinds, kind: &PersonKind) -> Population {
    let mix = kinds.mix(&[(kind.name.clone(), 1.0)].into()).unwrap();
    let adults = Population::new(PopulationSource::ansur().unwrap(), 0.5);
    adults.unwrap().mixed(mix)
}

/// Everything that a mix draws: closed, on the floor or above, within the outline that the mechanics has.
#[test]
fn people_of_all_kinds_and_their_things_are_closed_solids_in_their_outline() {
    let kinds = Kinds::built_in().unwrap();
    for kind in kinds.iter() {
        for agent in all_of(&kinds, kind).agents(7).take(3) {
            let member = agent.member().unwrap();
            let figure = Figure::of(&agent).unwrap();
            let (bodies, things) = (figure.bodies(false), figure.things());
            assert_eq!(bodies.len(), 5 * member.people.len(), "{}", kind.name);
            assert_eq!(things.is_empty(), kind.parts.is_empty() && !kind.bicycle, "{}", kind.name);
            for part in bodies.iter().chain(&things) {
                assert_closed(part.vertices.len(), &indices(part), &part.name);
                assert!(signed_volume(&part.vertices, &indices(part)) > 0.0, "{} {}", kind.name, part.name);
            }
            // Solids are drawn, disks act: they differ by a corner of a suitcase or a handle.
            for [x, y, z] in things.iter().flat_map(|part| &part.vertices) {
                let off = |disk: &BodyDisk| (vec2(*x, *y) - disk.disk.centre).norm() - disk.disk.radius;
                let off = member.disks.iter().map(off).fold(f64::MAX, f64::min);
                assert!(*z >= 0.0 && off < 0.1, "{}: {x} {y} {z} {off}", kind.name);
            }
            let places = || bodies.iter().flat_map(|part| &part.vertices);
            let (low, high) = places()
                .fold((f64::MAX, f64::MIN), |(low, high), place| (low.min(place[2]), high.max(place[2])));
            let stature = member.people[0].0.stature;
            if kind.seated {
                // The sitting height is 0.52 of the stature (ANSUR II: 0.918 m of 1.756 m).
                assert!((high - kind.seat - 0.52 * stature).abs() < 0.03 * stature, "{high} of {stature}");
                assert!((-0.48..-0.23).contains(&(low - kind.seat)), "{}: feet at {low}", kind.name);
                let feet = places().map(|place| place[0]).fold(f64::MIN, f64::max);
                assert!((0.4..0.95).contains(&(feet - member.people[0].1.x)), "{feet}");
            } else {
                assert!(low.abs() < 1e-9 && high >= stature - 1e-9, "{low} {high}");
            }
        }
    }
}

#[test]
fn a_small_child_has_a_body_of_its_measures() {
    let child = Person { sex: Sex::Female, breadth: 0.25, depth: 0.14, stature: 0.87, mass: 12.4 };
    assert!(Body3d::of(&child).is_err());
    let body = Body3d::similar(&child).unwrap();
    let torso = body.slice_at(body.torso_altitude());
    assert!((extent(&torso, |p| p.y) - 0.25).abs() < 1e-3 && (extent(&torso, |p| p.x) - 0.14).abs() < 1e-3);
    assert!((body.volume() / (12.4 / 985.0) - 1.0).abs() < 0.1, "{}", body.volume());
    let man = mean_person(Sex::Male);
    assert_eq!(Body3d::similar(&man).unwrap(), Body3d::of(&man).unwrap());
    let message = |person: Person| Body3d::similar(&person).unwrap_err().to_string();
    assert!(
        message(Person { stature: 0.1, ..child }).starts_with("stature = 0.1 m: must be from 1 to 2.5 m")
    );
    // Of a body of 1.35 m: 0.25 to 0.8 m and 20 to 250 kg, by (0.87 / 1.35) and its cube.
    let broad = message(Person { breadth: 0.6, ..child });
    assert_eq!(broad, "bideltoid breadth = 0.6 m: must be from 0.161 to 0.516 m for a body");
    let light = message(Person { mass: 5.0, ..child });
    assert_eq!(light, "mass = 5 kg: must be from 5.353 to 66.911 kg for a body");
}

/// Of an opened Trial the disks are known, the kind and the height: people and things are where they were.
#[test]
fn figures_that_fit_a_trial_are_those_of_its_kinds() {
    let kinds = Kinds::built_in().unwrap();
    for kind in kinds.iter() {
        let agents: Vec<CrowdMember> = all_of(&kinds, kind).agents(3).take(3).collect();
        let crowd: Vec<(CrowdMember, Pose)> =
            agents.iter().cloned().map(|agent| (agent, Pose::default())).collect();
        let trial = crowd_trial("t", &crowd, walls(&[], "concrete"), &TrialSettings::default()).unwrap();
        for (agent, read) in agents.iter().zip(&trial.agents) {
            let [known, fitting] = [Figure::of(agent).unwrap(), Figure::fitting(read).unwrap()];
            let things = [&known, &fitting].map(Figure::things);
            let bodies = [&known, &fitting].map(|figure| figure.bodies(false));
            assert_eq!((things[0].len(), bodies[0].len()), (things[1].len(), bodies[1].len()));
            for (one, other) in
                things[0].iter().zip(&things[1]).flat_map(|(a, b)| a.vertices.iter().zip(&b.vertices))
            {
                assert!((0..3).all(|k| (one[k] - other[k]).abs() < 1e-9), "{}: {one:?} {other:?}", kind.name);
            }
            let middle = |of: usize, part: usize| {
                let vertices: &Vec<[f64; 3]> = &bodies[of][part].vertices;
                [0, 1]
                    .map(|axis| vertices.iter().map(|place| place[axis]).sum::<f64>() / vertices.len() as f64)
            };
            for part in (0..bodies[0].len()).step_by(5) {
                let ([x, y], [other_x, other_y]) = (middle(0, part), middle(1, part));
                let off = (x - other_x).hypot(y - other_y);
                assert!(off < 0.01, "{} {part}: {off}", kind.name);
            }
        }
        // Of a body that is lighter than what goes along.
        let light = lemons_core::trial::Agent { mass: 5.0, ..trial.agents[0].clone() };
        let people = people_fitting(&light).map_or(Vec::new(), |(_, people)| people);
        assert!(!people.is_empty() || trial.agents[0].kind.is_none(), "{}", kind.name);
        assert!(people.iter().all(|(person, _)| person.mass >= 2.5), "{}: {people:?}", kind.name);
        let plain = lemons_core::trial::Agent { kind: Some("elephant".into()), ..trial.agents[0].clone() };
        assert!(Figure::fitting(&plain).unwrap().things().is_empty());
    }
}
