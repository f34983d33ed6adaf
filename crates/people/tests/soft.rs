//! People of the material `human_soft`, beside what follows from their springs and dampers.
//!
//! `cargo test --release -p lemons-people --test soft -- --nocapture` prints the numbers of docs/guide/squeeze.md.

use crowd_mechanics::engine::World;
use crowd_mechanics::setup::Setup;
use lemons_core::plane::{Pose, vec2};
use lemons_core::trial::{ContactCoefficients, Geometry, stiffness};
use lemons_people::{CrowdMember, Person, Sex, Shape, TrialSettings, crowd_trial, materials};
use std::f64::consts::PI;

/// The person of docs/guide/physics.md: 49 cm broad, 25 cm deep, 80 kg.
const PERSON: Person = Person { sex: Sex::Male, breadth: 0.49, depth: 0.25, stature: 1.75, mass: 80.0 };
/// People in the row.
const ROW: usize = 20;

/// People of a material at x \[m\] with a velocity \[m/s\] along x and an orientation \[rad\], without a floor.
fn world(material: &str, people: &[(f64, f64, f64)]) -> World {
    let pose = |&(x, _, orientation): &(f64, f64, f64)| Pose { position: vec2(x, 0.0), orientation };
    let crowd: Vec<_> = people.iter().map(|person| (CrowdMember::Pedestrian(PERSON), pose(person))).collect();
    let settings = TrialSettings { people: material.into(), ..TrialSettings::default() };
    let open = Geometry::default();
    let mut trial = crowd_trial("soft", &crowd, open, &settings).unwrap();
    for (agent, (dynamics, person)) in trial.agents.iter_mut().zip(trial.dynamics.iter_mut().zip(people)) {
        (agent.floor_damping, agent.angular_damping) = (0.0, 0.0);
        dynamics.velocity.x = person.1;
    }
    let mut world = Setup::of(&trial).world().unwrap();
    world.mechanical_step = 1e-5;
    world
}

/// docs/guide/squeeze.md has a row that ends so.
fn is_on_the_page(cells: &str) {
    let page = lemons_testing::repository().join("docs/guide/squeeze.md");
    assert!(std::fs::read_to_string(page).unwrap().contains(&format!("| {cells} |\n")), "{cells}");
}

/// \[N/m\] Normal stiffness of a contact of two people of a material, and \[kg/s\] its damping.
fn contact(material: &str) -> (f64, f64) {
    let all = materials();
    let own = all.intrinsic.iter().find(|one| one.id == material).unwrap();
    let with_itself = |contact: &&ContactCoefficients| contact.id1 == material && contact.id2 == material;
    (stiffness(own, own).0, all.binary.iter().find(with_itself).unwrap().gamma_normal)
}

/// \[m\] From the centre of mass to the front of the person; distance of two people in a row that touch just so.
fn lengths() -> (f64, f64) {
    let disks = Shape::of(&PERSON).unwrap().disks;
    let most = |of: &dyn Fn(usize) -> f64| (0..disks.len()).map(of).fold(0.0, f64::max);
    (most(&|k| disks[k].centre.x + disks[k].radius), most(&|k| 2.0 * disks[k].radius))
}

/// e = exp(−π ζ / √(1 − ζ²)) of two such people, ζ = γ / (2 √(k m\*)).
fn closed_form(material: &str) -> f64 {
    let (spring, damper) = contact(material);
    let ratio = damper / (2.0 * (spring * 0.5 * PERSON.mass).sqrt());
    (-PI * ratio / (1.0 - ratio * ratio).sqrt()).exp()
}

/// The speed at which two people part who met front to front, divided by that \[m/s\] at which they met.
fn restitution(material: &str, speed: f64) -> f64 {
    let front = lengths().0;
    let mut world = world(material, &[(-front, 0.5 * speed, 0.0), (front, -0.5 * speed, PI)]);
    world.advance(1.0).unwrap();
    let twists = &world.state().twists;
    (twists[1].velocity.x - twists[0].velocity.x) / speed
}

#[test]
fn a_head_on_collision_gives_back_three_tenths_of_the_speed() {
    for speed in [0.1, 0.5] {
        let found = restitution("human_soft", speed);
        assert!((found - closed_form("human_soft")).abs() < 1e-3, "{found} {}", closed_form("human_soft"));
        assert!((found - 0.3).abs() < 0.01, "{found}");
    }
    // More disks touch.
    let fast = restitution("human_soft", 1.0);
    println!("restitution up to 0.5 m/s {:.3}, at 1 m/s {fast:.3}", restitution("human_soft", 0.5));
    is_on_the_page(&format!("{:.3} ({fast:.3})", restitution("human_soft", 0.5)));
}

/// \[N\] Force between two people who stand behind each other, this much \[m\] too near.
fn pressed(nearer: f64) -> f64 {
    let mut world = world("human_soft", &[(0.0, 0.0, 0.0), (lengths().1 - nearer, 0.0, 0.0)]);
    world.advance(1e-9).unwrap();
    let state = world.state();
    // Momentum of the first one: the sum of the forces along x.
    -state.twists[0].velocity.x * PERSON.mass / 1e-9
}

#[test]
fn two_people_are_as_soft_as_chests() {
    let (spring, _) = contact("human_soft");
    assert!((1e4..5e4).contains(&spring), "{spring}");
    println!("one pair of disks {:.1} kN/m", 1e-3 * spring);
    for millimetres in [5.0, 10.0, 15.0, 20.0, 30.0, 40.0] {
        let force = pressed(1e-3 * millimetres);
        println!("{millimetres} mm nearer: {force:.0} N, {:.1} kN/m", force / millimetres);
        assert!(millimetres > 20.0 || (10.0..50.0).contains(&(force / millimetres)), "{force}");
    }
    // One pair of disks touches.
    assert!((pressed(0.005) / (0.005 * spring) - 1.0).abs() < 1e-3);
}

/// \[s\] When the speed of each person of a row passes half of that behind the front, F / √(k m).
struct Arrivals {
    engine: Vec<f64>,
    /// Of a chain of masses with springs and dampers.
    chain: Vec<f64>,
}

/// The first person of the row is pushed with a constant force \[N\].
fn row(material: &str, force: f64) -> Arrivals {
    let (spring, damper) = contact(material);
    let half = 0.5 * force / (spring * PERSON.mass).sqrt();
    // 300 instants while the front passes a person, until it has passed ten more than there are.
    let (dt, instants) = ((PERSON.mass / spring).sqrt() / 300.0, 300 * (ROW + 10));
    let apart = lengths().1 - 1e-12;
    let mut world = world(material, &(0..ROW).map(|k| (k as f64 * apart, 0.0, 0.0)).collect::<Vec<_>>());
    world.drive[0].force.x = force;
    let (mut place, mut speed) = ([0.0; ROW], [0.0; ROW]);
    let mut arrivals = Arrivals { engine: vec![f64::NAN; ROW], chain: vec![f64::NAN; ROW] };
    for instant in 1..=instants {
        let time = dt * instant as f64;
        world.advance(dt).unwrap();
        let mut forces = [0.0; ROW];
        forces[0] = force;
        for k in 0..ROW - 1 {
            let between = spring * (place[k] - place[k + 1]) + damper * (speed[k] - speed[k + 1]);
            (forces[k], forces[k + 1]) = (forces[k] - between, forces[k + 1] + between);
        }
        for k in 0..ROW {
            speed[k] += dt * forces[k] / PERSON.mass;
            place[k] += dt * speed[k];
            let engine = world.state().twists[k].velocity.x;
            for (now, first) in [(engine, &mut arrivals.engine[k]), (speed[k], &mut arrivals.chain[k])] {
                if now > half && first.is_nan() {
                    *first = time;
                }
            }
        }
    }
    arrivals
}

/// \[m/s\] From the sixth person to the last but two: neither the push nor the free end is near.
fn speed(arrivals: &[f64]) -> f64 {
    let (first, last) = (5, ROW - 3);
    (last - first) as f64 * lengths().1 / (arrivals[last] - arrivals[first])
}

#[test]
fn a_push_runs_through_a_row_like_a_wave_through_a_chain() {
    let mut speeds = Vec::new();
    for (material, within) in [("human_naked", 0.02), ("human_soft", 0.1)] {
        let theory = lengths().1 * (contact(material).0 / PERSON.mass).sqrt();
        let weak = row(material, 100.0);
        let (engine, chain) = (speed(&weak.engine), speed(&weak.chain));
        let strong = speed(&row(material, 500.0).engine);
        println!(
            "{material}: d √(k/m) {theory:.2} m/s, chain {chain:.2}, 100 N {engine:.2}, 500 N {strong:.2}"
        );
        assert!((engine / chain - 1.0).abs() < 0.01, "{material}: {engine} {chain}");
        assert!((engine / theory - 1.0).abs() < within, "{material}: {engine} {theory}");
        speeds.push([theory, engine, strong]);
    }
    for (stiff, soft) in speeds[0].iter().zip(&speeds[1]) {
        is_on_the_page(&format!("{stiff:.1} | {soft:.2}"));
    }
}
