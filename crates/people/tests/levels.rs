//! People in levels, beside sections of their bodies, the plan, and the mechanics.

use crowd_mechanics::setup::{Setup, read};
use lemons_core::plane::{Bounds, Disk, Pose, Ring, Vec2, convex_hull, union, vec2};
use lemons_core::trial::{Agent, Geometry, Trial};
use lemons_people::{
    Body3d, CrowdMember, Kinds, Person, Population, PopulationSource, Sex, Shape, Slabs, TrialSettings,
    ansur, chest_height, crowd_trial, write_trial,
};
use std::path::PathBuf;

fn mean(sex: Sex) -> Person {
    Person::from_measures(sex, ansur(sex).measures.each_ref().map(|measure| measure.mean))
}

fn crowd(mix: &[(&str, f64)], count: usize) -> Vec<CrowdMember> {
    let population = Population::new(PopulationSource::ansur().unwrap(), 0.5).unwrap();
    let shares = mix.iter().map(|(name, share)| ((*name).to_owned(), *share)).collect();
    population.mixed(Kinds::built_in().unwrap().mix(&shares).unwrap()).agents(1).take(count).collect()
}

/// Everybody at a place, turned by an angle.
fn trial(placed: &[(CrowdMember, Vec2, f64)], slabs: Option<Slabs>) -> Trial {
    let pose = |position, orientation| Pose { position, orientation };
    let crowd: Vec<_> = placed.iter().map(|(who, at, angle)| (who.clone(), pose(*at, *angle))).collect();
    let settings = TrialSettings { slabs, ..TrialSettings::default() };
    crowd_trial("T", &crowd, Geometry::default(), &settings).unwrap()
}

fn alone(who: CrowdMember, slabs: Slabs) -> Agent {
    trial(&[(who, Vec2::zeros(), 0.0)], Some(slabs)).agents.remove(0)
}

fn disks(agent: &Agent, height: f64) -> Vec<Disk> {
    let there = agent.shapes.iter().filter(|of| (of.heights.bottom..of.heights.top).contains(&height));
    there.map(|of| Disk { radius: of.radius, centre: of.position }).collect()
}

/// The outside: the hulls of the sections, on a grid.
#[test]
fn disks_cover_the_sections_of_the_body() {
    for sex in Sex::ALL {
        let person = mean(sex);
        let body = Body3d::of(&person).unwrap();
        for count in [2, 3, 5] {
            let agent = alone(CrowdMember::Pedestrian(person), Slabs::equal(count).unwrap());
            let (mut all, mut covered, mut missed, mut beyond) = (0.0, 0.0, 0.0, 0.0);
            for k in 0..count {
                let (bottom, height) = (0.5 + 1.2 * k as f64 / count as f64, 1.2 / count as f64);
                let top = (bottom + height).min(person.stature);
                // The fullest of nine.
                let outlines = (0..9).filter_map(|k| {
                    let at = bottom + (top - bottom) * (f64::from(k) + 0.5) / 9.0;
                    Ring::through(convex_hull(body.slice_at(at).into_iter().flat_map(|slice| slice.points)))
                });
                let outline = outlines.max_by(|a, b| a.area().total_cmp(&b.area())).unwrap();
                let own = disks(&agent, bottom + 0.01);
                assert_eq!(own.len(), 5);
                (all, covered) = (all + outline.area(), covered + union(&own).area);
                let Bounds { low, high } = outline.bounds().grown(0.05);
                let cell = (high - low) * (1.0 / 150.0);
                for (i, j) in (0..150).flat_map(|i| (0..150).map(move |j| (i, j))) {
                    let at = low + vec2(cell.x * (f64::from(i) + 0.5), cell.y * (f64::from(j) + 0.5));
                    let is_covered = own.iter().any(|disk| (disk.centre - at).norm() < disk.radius);
                    match (outline.contains(at), is_covered) {
                        (true, false) => missed += cell.x * cell.y,
                        (false, true) => beyond += cell.x * cell.y,
                        _ => {}
                    }
                }
            }
            println!("{sex:?}, {count}: {all:.4} m², {:.2} %", 100.0 * missed / all);
            assert!((covered / all - 1.0).abs() < 0.03, "{sex:?} {count}: {covered} of {all} m²");
            assert!(
                missed < 0.04 * all && beyond < 0.04 * all,
                "{sex:?} {count}: {missed} {beyond} of {all}"
            );
        }
    }
}

/// The outside: the plan, in which Trials have been made so far.
#[test]
fn everybody_looks_ahead_and_is_otherwise_as_in_the_plan() {
    let kinds: Vec<String> = Kinds::built_in().unwrap().iter().map(|kind| kind.name.clone()).collect();
    let mix: Vec<(&str, f64)> = kinds.iter().map(|name| (&**name, 1.0)).collect();
    let place = |(k, who): (usize, CrowdMember)| (who, vec2(3.0 * (k % 8) as f64, 3.0 * (k / 8) as f64), 0.3);
    let placed: Vec<_> = crowd(&mix, 40).into_iter().enumerate().map(place).collect();
    let plan = trial(&placed, None);
    let directory = tempfile::TempDir::new().unwrap();
    let levels = [Slabs::equal(2), Slabs::equal(3), Slabs::equal(5), Slabs::about(&[0.6, 0.8, 1.5])];
    for slabs in levels.map(Result::unwrap) {
        let made = trial(&placed, Some(slabs.clone()));
        assert_eq!(made, trial(&placed, Some(slabs.clone())), "the same bytes");
        for ((agent, old), (who, ..)) in made.agents.iter().zip(&plan.agents).zip(&placed) {
            let turned = agent.disks_facing_x().into_iter().zip(&agent.shapes);
            assert!(turned.clone().all(|((at, _), of)| at == of.position), "{:?}", agent.kind);
            assert!(!agent.shapes.iter().any(|of| of.heights.is_all()) && agent.shapes.len() > 4);
            // The disks of a person are there, not those of a chair alone.
            let of_person = agent.shapes.iter().filter(|of| of.material_id == "human_naked");
            let holds = |at: f64| of_person.clone().any(|of| of.heights.hold(at));
            assert!(agent.chest_height.is_none_or(holds));
            assert_eq!(agent.chest_height, chest_height(who, &slabs.disks(who).unwrap()));
            let without = |agent: &Agent| Agent { shapes: Vec::new(), chest_height: None, ..agent.clone() };
            assert_eq!(without(agent), without(old));
        }
        assert_eq!(Some(made.materials.load_length), slabs.load_length());
        let path = directory.path().join("T");
        write_trial(&made, &[], &path, true).unwrap();
        let (mut again, warnings) = read(&path).unwrap();
        assert!(warnings.is_empty(), "{warnings}");
        again.directory = PathBuf::new();
        assert_eq!(again, made);
    }
    // One level is the plan, with chests.
    let mut one = trial(&placed, Some(Slabs::equal(1).unwrap()));
    let has_chest = |agent: &&Agent| agent.chest_height.is_some_and(|at| (0.5..1.7).contains(&at));
    assert!(one.agents.iter().filter(has_chest).count() > 30);
    one.agents.iter_mut().for_each(|agent| agent.chest_height = None);
    assert_eq!(one, plan);
}

#[test]
fn nobody_is_above_the_stature_and_no_chair_above_its_back() {
    let child = Person { sex: Sex::Female, breadth: 0.28, depth: 0.16, stature: 1.1, mass: 19.0 };
    let small = alone(CrowdMember::Pedestrian(child), Slabs::equal(5).unwrap());
    let tops: Vec<f64> = small.shapes.iter().map(|of| of.heights.top).collect();
    assert!(tops.iter().copied().fold(0.0, f64::max) == 1.1 && small.shapes.len() == 15, "{tops:?}");
    // Over its head, an adult touches nothing of it.
    let slabs = Slabs::about(&[1.0, 1.4]).unwrap();
    let own = [child, mean(Sex::Male)].map(|who| alone(CrowdMember::Pedestrian(who), slabs.clone()));
    let above = own[1].shapes.iter().filter(|of| of.heights.bottom > 1.1);
    assert!(above.clone().count() == 5 && own[0].shapes.len() > 4);
    assert!(
        above.flat_map(|of| own[0].shapes.iter().map(|it| it.heights.common(&of.heights))).all(|h| h < 0.0)
    );
    // data/kinds.toml: the grips of a wheelchair are at 0.92 m, 3 cm thick.
    for who in crowd(&[("wheelchair", 1.0)], 10) {
        let agent = alone(who, Slabs::equal(3).unwrap());
        let (chair, person): (Vec<_>, Vec<_>) = agent.shapes.iter().partition(|of| of.material_id == "frame");
        assert!(chair.iter().all(|of| of.heights.top < 0.94) && chair.len() == 10);
        assert!(person.iter().all(|of| of.heights.bottom > 0.92 && of.heights.top < 1.6) && person.len() > 4);
        // Somebody's chest is between the seat and the top of the head, if the chair does not hide it.
        let top = person.iter().map(|of| of.heights.top).fold(0.0, f64::max);
        assert!(agent.chest_height.is_none_or(|at| at > 0.92 && at < top - 0.3), "{agent:?}");
    }
    // Who has only a head in the levels.
    let tall = Slabs::about(&[1.6, 1.7]).unwrap();
    let head = alone(CrowdMember::Pedestrian(mean(Sex::Male)), tall.clone());
    let [first, .., last] = &head.shapes[..] else { panic!("{head:?}") };
    assert!(first.position == last.position && first.heights.top == last.heights.bottom);
    let below = tall.disks(&CrowdMember::Pedestrian(child)).unwrap_err().to_string();
    assert_eq!(below, "a person of 1.10 m does not reach the lowest level, which begins at 1.55 m");
}

/// At the distance of their projections nobody touches anybody, and nearer somebody does.
#[test]
fn projections_keep_people_apart() {
    let slabs = Slabs::equal(3).unwrap();
    let man = CrowdMember::Pedestrian(mean(Sex::Male));
    let reach = |disk: &Disk| disk.centre.y.abs() + disk.radius;
    let Shape { disks } = slabs.shape(&man).unwrap();
    let side = disks.iter().map(reach).fold(0.0, f64::max);
    assert!(side > 0.5 * mean(Sex::Male).breadth && side < 0.6 * mean(Sex::Male).breadth, "{side}");
    for (distance, touching) in [(2.0 * side + 1e-9, false), (2.0 * side - 1e-4, true)] {
        let placed = [(man.clone(), Vec2::zeros(), 0.0), (man.clone(), vec2(0.0, distance), 0.0)];
        let made = trial(&placed, Some(slabs.clone()));
        let world = Setup::of(&made).world().unwrap();
        assert_eq!(!world.contacts().contacts.is_empty(), touching, "{distance}");
    }
}
