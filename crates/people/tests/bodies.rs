//! Bodies against what they are to follow: a person's measures, Euler's and Gauss's theorems, other tools' readers.

use lemons_core::plane::{Pose, Vec2, vec2};
use lemons_people::*;
use std::collections::BTreeMap;

/// Breadth, depth, stature \[m\], mass \[kg\]: means and SDs in the US Army ANSUR II survey (2012).
struct Four {
    sex: Sex,
    mean: [f64; 4],
    sd: [f64; 4],
}

const MEN: Four = Four {
    sex: Sex::Male,
    mean: [0.51042, 0.25385, 1.75621, 85.523],
    sd: [0.0325, 0.02625, 0.06856, 14.222],
};
const WOMEN: Four = Four {
    sex: Sex::Female,
    mean: [0.45032, 0.2474, 1.62847, 67.758],
    sd: [0.02869, 0.02734, 0.0642, 10.985],
};

/// A hundred men, a hundred women; each measure within 2.5 SDs.
fn people() -> Vec<Person> {
    let drawn = |four: &Four| {
        let men = if four.sex == Sex::Male { 1.0 } else { 0.0 };
        let usual = |person: &Person| {
            let mut all = person.measures().into_iter().zip(four.mean).zip(four.sd);
            all.all(|((value, mean), sd)| (value - mean).abs() <= 2.5 * sd)
        };
        let population = Population::new(Source::Ansur, Proportions { men, pedestrians: 1.0 }).unwrap();
        population.people(2012).filter(usual).take(100).collect::<Vec<_>>()
    };
    [MEN, WOMEN].iter().flat_map(drawn).collect()
}

fn mean_person(four: &Four) -> Person {
    let [breadth, depth, stature, mass] = four.mean;
    Person { sex: four.sex, breadth, depth, stature, mass }
}

fn extent(polygons: &[Polygon], along: fn(&Vec2) -> f64) -> f64 {
    let all = || polygons.iter().flat_map(|polygon| &polygon.points).map(along);
    all().fold(f64::MIN, f64::max) - all().fold(f64::MAX, f64::min)
}

/// \[m\] Altitudes of the torsos: the lowest, the mean, the highest.
fn torso_altitudes(bodies: &[Body3d]) -> [f64; 3] {
    let all = || bodies.iter().map(Body3d::torso_altitude);
    let mean = all().sum::<f64>() / bodies.len() as f64;
    [all().fold(f64::MAX, f64::min), mean, all().fold(0.0, f64::max)]
}

fn area(body: &Body3d, z: f64) -> f64 {
    body.slice_at(z).iter().map(Polygon::area).sum()
}

fn surfaces((body, pose): &(&Body3d, Pose)) -> Vec<MeshPart> {
    body.mesh().at(pose).parts
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
        let tops =
            body.mesh().parts.iter().flat_map(|part| &part.vertices).fold(f64::MIN, |z, v| z.max(v[2]));
        assert_eq!(tops, person.stature);
        worst_volume = worst_volume.max((body.volume() / (person.mass / 985.0) - 1.0).abs());
        assert!((GIRTH_FACTORS[0]..=GIRTH_FACTORS[1]).contains(&body.girth_factor()));
    }
    assert!(worst_volume < 0.1, "{worst_volume}");
}

#[test]
fn heavier_people_have_larger_waists() {
    for four in [MEN, WOMEN] {
        let mean = mean_person(&four);
        let waist = |person: &Person| {
            let body = Body3d::of(person).unwrap();
            let trunk = body.slice_at(0.6 * person.stature).remove(0);
            assert_eq!(trunk.part, Part::Trunk);
            let around = trunk.points.iter().zip(trunk.points.iter().cycle().skip(1));
            around.map(|(&a, &b)| (b - a).norm()).sum::<f64>()
        };
        let (lean, usual, heavy) = (
            waist(&Person { mass: mean.mass - 1.5 * four.sd[3], ..mean }),
            waist(&mean),
            waist(&Person { mass: mean.mass + 1.5 * four.sd[3], ..mean }),
        );
        // Waist girth at the navel: 0.941 m of men, 0.861 m of women.
        let survey = if four.sex == Sex::Male { 0.941 } else { 0.861 };
        assert!((usual / survey - 1.0).abs() < 0.06, "{usual} {survey}");
        assert!(heavy > usual + 0.05 && usual > lean + 0.05, "{lean} {usual} {heavy}");
    }
}

#[test]
fn meshes_are_closed_and_face_outwards() {
    for person in people().iter().step_by(10) {
        let body = Body3d::of(person).unwrap();
        let mesh = body.mesh();
        assert_eq!(mesh.parts.len(), 5);
        let mut sum = 0.0;
        for part in &mesh.parts {
            let triangles = indices(part);
            assert_closed(part.vertices.len(), &triangles, &part.name);
            let volume = signed_volume(&part.vertices, &triangles);
            assert!(volume > 0.0, "{}", part.name);
            sum += volume;
        }
        assert!((sum / body.volume() - 1.0).abs() < 0.01, "{sum} {}", body.volume());
        assert!((mesh.volume() / sum - 1.0).abs() < 1e-9);
        let coarse = body.coarse_mesh();
        for part in &coarse.parts {
            assert_closed(part.vertices.len(), &indices(part), &part.name);
        }
        assert!((coarse.volume() / body.volume() - 1.0).abs() < 0.05, "{}", coarse.volume());
        let triangles = |mesh: &Mesh| mesh.parts.iter().map(|part| part.triangles.len()).sum::<usize>();
        assert!(10 * triangles(&coarse) < triangles(&mesh));
        // The area integrated apart from Simpson's exact slabs.
        let stack = body.stack(0.002);
        let mean: f64 =
            stack.iter().flat_map(|(_, slice)| slice).map(Polygon::area).sum::<f64>() / stack.len() as f64;
        assert!((mean * person.stature / body.volume() - 1.0).abs() < 2e-3);
    }
}

/// Whatever the custom statistics of the paper can draw, and beyond: closed, rising, breadth and depth.
#[test]
fn nobody_is_too_odd() {
    for sex in [Sex::Male, Sex::Female] {
        for breadth in [0.3, 0.65] {
            for depth in [0.15, 0.3, 0.45] {
                for stature in [1.4, 2.4] {
                    for mass in [30.0, 160.0] {
                        let person = Person { sex, breadth, depth, stature, mass };
                        let body = match Body3d::of(&person) {
                            Err(error) => {
                                assert!(depth > breadth, "{error}");
                                continue;
                            }
                            Ok(body) => body,
                        };
                        let torso = body.slice_at(body.torso_altitude());
                        assert!((extent(&torso, |p| p.y) - breadth).abs() < 1e-3, "{person:?}");
                        assert!((extent(&torso, |p| p.x) - depth).abs() < 1e-3, "{person:?}");
                        for part in body.mesh().parts {
                            assert_closed(part.vertices.len(), &indices(&part), &part.name);
                            assert!(part.volume() > 0.0);
                            assert!(
                                part.vertices.windows(2).all(|pair| pair[1][2] >= pair[0][2]),
                                "{person:?}"
                            );
                        }
                        for (z, slice) in body.stack(0.05) {
                            assert!(slice.iter().all(|polygon| polygon.area() > 0.0), "{person:?} at {z}");
                            let placed = [(&body, Pose::default())];
                            let (union, sum) = (section(&placed, z).covered(), area(&body, z));
                            assert!((union - sum).abs() < 1e-8, "{person:?} at {z}: {union} of {sum}");
                            // Left and right mirror each other.
                            let side: f64 =
                                slice.iter().map(|polygon| polygon.area() * polygon.centroid().y).sum();
                            assert!(side.abs() < 1e-12, "{person:?} at {z}");
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn nobodies_are_refused_by_name() {
    let man = mean_person(&MEN);
    let said = |person: Person| Body3d::of(&person).unwrap_err().to_string();
    assert!(said(Person { breadth: f64::NAN, ..man }).contains("bideltoid breadth = NaN m"));
    assert!(said(Person { stature: 0.0, ..man }).contains("stature = 0 m"));
    assert!(said(Person { mass: f64::INFINITY, ..man }).contains("mass = inf kg"));
    assert!(
        said(Person { depth: 0.5, breadth: 0.4, ..man }).contains("must not exceed the bideltoid breadth")
    );
}

#[test]
fn sections_of_a_crowd() {
    let bodies: Vec<Body3d> = people().iter().step_by(20).map(|person| Body3d::of(person).unwrap()).collect();
    let apart = |k: usize| Pose { position: vec2(k as f64, -0.5 * k as f64), orientation: 0.7 * k as f64 };
    let crowd: Vec<(&Body3d, Pose)> = bodies.iter().enumerate().map(|(k, body)| (body, apart(k))).collect();
    let [least, mean, most] = torso_altitudes(&bodies);
    assert!(least < mean && mean < most);
    for z in [least, mean, most] {
        let cut = section(&crowd, z);
        let own: f64 = bodies.iter().map(|body| area(body, z)).sum();
        // Neither turning nor moving changes areas; apart, nothing is counted twice.
        assert!((cut.area() - own).abs() < 1e-12 && (cut.covered() - own).abs() < 1e-7, "{z}");
        assert_eq!(cut.cut(), crowd.len());
    }
    // The gaze of the second: its toes lie that way from the axis.
    let feet = section(&crowd[1..2], 0.01);
    let sum = feet.bodies[0].iter().fold(Vec2::ZERO, |sum, foot| sum + foot.centroid());
    let ahead = sum * 0.5 - vec2(1.0, -0.5);
    assert!((libm::atan2(ahead.y, ahead.x) - 0.7).abs() < 1e-9, "{ahead:?}");
    // Two in the same place cover the ground once.
    let twice = [crowd[0], crowd[0]];
    let cut = section(&twice, mean);
    assert!((cut.area() - 2.0 * cut.covered()).abs() < 1e-7);
    // The tallest alone stands out.
    let tallest = bodies.iter().map(|body| body.person().stature).fold(0.0, f64::max);
    assert_eq!(section(&crowd, tallest).cut(), 1);
    assert_eq!(section(&crowd, tallest + 0.01).covered(), 0.0);
}

#[test]
fn stl_reads_back() {
    let body = Body3d::of(&mean_person(&MEN)).unwrap();
    let mut file = Vec::new();
    write_stl(&body.mesh().parts, &mut file).unwrap();
    let mut reader = std::io::Cursor::new(&file);
    let read = stl_io::read_stl(&mut reader).unwrap();
    let count: usize = body.mesh().parts.iter().map(|part| part.triangles.len()).sum();
    assert_eq!((read.faces.len(), file.len()), (count, 84 + 50 * count));
    let vertices: Vec<[f64; 3]> =
        read.vertices.iter().map(|v| [f64::from(v[0]), f64::from(v[1]), f64::from(v[2])]).collect();
    let triangles: Vec<[usize; 3]> = read.faces.iter().map(|face| face.vertices).collect();
    assert!((signed_volume(&vertices, &triangles) / body.mesh().volume() - 1.0).abs() < 1e-4);
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
    let bodies = [MEN, WOMEN].map(|four| Body3d::of(&mean_person(&four)).unwrap());
    let pose = |x: f64, orientation: f64| Pose { position: vec2(x, 2.0), orientation };
    let crowd = [(&bodies[0], pose(0.0, 1.0)), (&bodies[1], pose(0.6, -2.0))];
    let mut file = Vec::new();
    let parts: Vec<MeshPart> = crowd.iter().flat_map(surfaces).collect();
    write_obj(&parts, &mut file).unwrap();
    let (models, _) = tobj::load_obj_buf(&mut file.as_slice(), &tobj::LoadOptions::default(), |_| {
        Err(tobj::LoadError::OpenFileFailed)
    })
    .unwrap();
    let names: Vec<&str> = models.iter().map(|model| model.name.as_str()).collect();
    assert_eq!(names.len(), 10);
    assert_eq!((names[0], names[9]), ("trunk", "right_leg"));
    let mut volume = 0.0;
    for model in &models {
        let numbers: Vec<f64> = model.mesh.positions.iter().map(|&x| f64::from(x)).collect();
        let vertices: Vec<[f64; 3]> = numbers.chunks_exact(3).map(|v| [v[0], v[1], v[2]]).collect();
        let faces: Vec<usize> = model.mesh.indices.iter().map(|&k| k as usize).collect();
        let triangles: Vec<[usize; 3]> = faces.chunks_exact(3).map(|f| [f[0], f[1], f[2]]).collect();
        assert_closed(vertices.len(), &triangles, &model.name);
        volume += signed_volume(&vertices, &triangles);
    }
    let wanted = bodies[0].volume() + bodies[1].volume();
    assert!((volume / wanted - 1.0).abs() < 0.01, "{volume} {wanted}");
}

#[test]
fn geojson_and_wkt_read_back() {
    let body = Body3d::of(&mean_person(&WOMEN)).unwrap();
    let placed = [(&body, Pose { position: vec2(3.0, 1.0), orientation: 0.4 })];
    let sections: Vec<CrowdSection> =
        body.stack(0.05).iter().map(|(altitude, _)| section(&placed, *altitude)).collect();
    let mut area = BTreeMap::new();
    for section in &sections {
        for polygon in section.bodies.iter().flatten() {
            *area.entry(polygon.part.name().to_owned()).or_insert(0.0) += polygon.area();
        }
    }
    let ring_area = |ring: &[[f64; 2]]| {
        assert_eq!(ring.first(), ring.last());
        0.5 * ring.windows(2).map(|p| p[0][0] * p[1][1] - p[1][0] * p[0][1]).sum::<f64>()
    };

    let mut file = Vec::new();
    write_geojson(&sections, &mut file).unwrap();
    let read: geojson::GeoJson = std::str::from_utf8(&file).unwrap().parse().unwrap();
    let geojson::GeoJson::FeatureCollection(read) = read else { panic!("not a collection") };
    let mut read_area = BTreeMap::new();
    for feature in &read.features {
        let altitude = feature.property("altitude").unwrap().as_f64().unwrap();
        let part = feature.property("part").unwrap().as_str().unwrap().to_owned();
        assert_eq!(feature.property("body").unwrap().as_u64(), Some(0));
        let geojson::GeometryValue::Polygon { coordinates } = &feature.geometry.as_ref().unwrap().value
        else {
            panic!("not a polygon")
        };
        assert_eq!(coordinates.len(), 1);
        assert!(coordinates[0].iter().all(|p| p[2] == altitude));
        let ring: Vec<[f64; 2]> = coordinates[0].iter().map(|p| [p[0], p[1]]).collect();
        *read_area.entry(part).or_insert(0.0) += ring_area(&ring);
    }
    assert_eq!(area.len(), 5);
    for (part, value) in &area {
        assert!((read_area[part] / value - 1.0).abs() < 1e-4, "{part}");
    }

    let mut file = Vec::new();
    write_wkt(&sections, &mut file).unwrap();
    let text = String::from_utf8(file).unwrap();
    assert_eq!(text.lines().count(), sections.len());
    for (line, section) in text.lines().zip(&sections) {
        let wkt::Wkt::MultiPolygon(read) = line.parse::<wkt::Wkt<f64>>().unwrap() else { panic!("{line}") };
        let sum: f64 = read
            .polygons()
            .iter()
            .map(|polygon| {
                let coords = polygon.rings()[0].coords();
                assert!(coords.iter().all(|c| (c.z.unwrap() - section.altitude).abs() < 1e-6));
                ring_area(&coords.iter().map(|c| [c.x, c.y]).collect::<Vec<_>>())
            })
            .sum();
        assert!((sum - section.area()).abs() < 1e-6, "{line}");
    }
}

/// What no file can hold is refused, not written.
#[test]
fn poses_that_are_not_finite_are_refused() {
    let body = Body3d::of(&mean_person(&MEN)).unwrap();
    let lost = [(&body, Pose { position: vec2(f64::NAN, 0.0), orientation: 0.0 })];
    let cut = [section(&lost, 1.0)];
    assert!(cut[0].covered().is_nan());
    let mut file = Vec::new();
    let parts = surfaces(&lost[0]);
    assert!(write_obj(&parts, &mut file).unwrap_err().to_string().contains("not finite"));
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
    for (four, table) in [(MEN, men), (WOMEN, women)] {
        let body = Body3d::of(&mean_person(&four)).unwrap();
        for (z, girth) in table {
            let slice = body.slice_at(z);
            let leg =
                slice.iter().find(|polygon| matches!(polygon.part, Part::LeftLeg | Part::Trunk)).unwrap();
            let around = leg.points.iter().zip(leg.points.iter().cycle().skip(1));
            let own: f64 = around.map(|(&a, &b)| (b - a).norm()).sum();
            assert!((own / girth - 1.0).abs() < 0.06, "{:?} at {z}: {own}, survey {girth}", four.sex);
        }
        // Hip breadth, head breadth and length.
        let (hip, head, length) =
            if four.sex == Sex::Male { (0.346, 0.154, 0.200) } else { (0.354, 0.148, 0.190) };
        let trunk = |z: f64| {
            body.slice_at(z).into_iter().filter(|polygon| polygon.part == Part::Trunk).collect::<Vec<_>>()
        };
        assert!((extent(&trunk(table[0].0), |p| p.y) / hip - 1.0).abs() < 0.06);
        assert!((extent(&trunk(table[5].0), |p| p.y) / head - 1.0).abs() < 0.01);
        assert!((extent(&trunk(table[5].0), |p| p.x) / length - 1.0).abs() < 0.01);
    }
}

/// A person has the same bits on every machine.
#[test]
fn bits_are_kept() {
    let body = Body3d::of(&mean_person(&MEN)).unwrap();
    let vertices = body.mesh().parts.into_iter().flat_map(|part| part.vertices).flatten();
    let sum = vertices.fold(0u64, |sum, value| sum.rotate_left(5) ^ value.to_bits());
    assert_eq!(sum, 0x437a_a0d1_4284_d3f4, "{sum:#x}: a change of shape is told in CHANGELOG");
}
