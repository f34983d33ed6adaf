//! Slopes.

use crowd_mechanics::engine::*;
use crowd_mechanics::scenes::*;
use lemons_core::plane::Ring;
use lemons_core::trial::{GRAVITY, Ground, Incline};

const ANGLE: f64 = 0.2;
const HELD: f64 = 0.3;

/// A slope from x = 1 to 3 m that falls in a direction \[rad\].
fn slope(downhill: f64, held: f64) -> Ground {
    let corners = [(1.0, -5.0), (3.0, -5.0), (3.0, 5.0), (1.0, 5.0)].map(|(x, y)| vec2(x, y));
    Ground {
        id: "0".into(),
        area: Ring::through(corners.to_vec()).unwrap(),
        downhill,
        incline: Incline::Slope { angle: ANGLE, held },
        speeds: [None; 2],
    }
}

fn on(world: World, grounds: &[Ground], mechanical_step: f64) -> World {
    let state = world.state().clone();
    World::new(world.scene().clone().with_grounds(grounds), state, mechanical_step).unwrap()
}

/// \[m/s²\]
fn pull() -> f64 {
    (1.0 - HELD) * GRAVITY * ANGLE.sin()
}

/// The outside: r = g' τ (t − τ (1 − exp(−t/τ))), v = g' τ (1 − exp(−t/τ)).
#[test]
fn who_slides_has_the_closed_form() {
    for shortlisting in [Shortlisting::On, Shortlisting::Off] {
        let people = [disk(80.0, 0.2).at(1.5, 0.0).relaxing(2.0, 2.0)];
        let mut world = on(world(&people, &[], BODIES, 1e-3), &[slope(0.4, HELD)], 1e-3);
        world.shortlisting = shortlisting;
        let (tau, direction) = (0.5, vec2(0.4f64.cos(), 0.4f64.sin()));
        for k in 1..=50 {
            world.advance(0.02).unwrap();
            let t = 0.02 * f64::from(k);
            let grown = -f64::exp_m1(-t / tau);
            let way = vec2(1.5, 0.0) + direction * (pull() * tau * (t - tau * grown));
            let velocity = direction * (pull() * tau * grown);
            let state = world.state();
            assert!((state.poses[0].position - way).norm() < 1e-13 && way.x < 2.7);
            assert!((state.twists[0].velocity - velocity).norm() < 1e-13);
        }
    }
}

/// The outside: v² = v₀² + 2 g' Δx on the slope; nothing pulls before and behind it.
#[test]
fn who_crosses_a_slope_has_its_energy_to_second_order() {
    let mut worst = Vec::new();
    for step in [4e-3, 2e-3, 1e-3] {
        let mut most = 0.0f64;
        for k in 0..40 {
            // Rims are crossed anywhere within a step, and within a communication step.
            let start = 0.4 + 0.0137 * f64::from(k);
            let people = [disk(80.0, 0.2).at(start, 0.0).moving(1.0, 0.1)];
            let mut world = on(world(&people, &[], BODIES, step), &[slope(0.0, HELD)], step);
            while world.state().poses[0].position.x < 3.5 {
                world.advance(0.1).unwrap();
            }
            let velocity = world.state().twists[0].velocity;
            let expected = (1.0 + 4.0 * pull()).sqrt();
            most = most.max((velocity.x - expected).abs());
            assert!((velocity.y - 0.1).abs() < 1e-14);
        }
        worst.push(most);
    }
    assert!(worst[2] < 2e-6 && worst[0] / worst[2] > 11.0, "{worst:?}");
}

/// The outside: two who lean on a wall press on it with (1 − held) m g sin α each.
#[test]
fn the_wall_below_holds_what_feet_do_not() {
    let people = [80.0, 60.0].map(|mass| disk(mass, 0.2).relaxing(2.0, 2.0));
    let [first, second] = people;
    let people = [first.at(2.799, 0.0), second.at(2.399, 0.0)];
    let wall: &[(f64, f64)] = &[(3.0, -2.0), (3.0, 2.0)];
    let mut world = on(world(&people, &[wall], BODIES, 1e-4), &[slope(0.0, HELD)], 1e-4);
    for _ in 0..100 {
        world.advance(0.05).unwrap();
    }
    let load = world.face_exposures()[0].mean_force;
    assert!((load / (140.0 * pull()) - 1.0).abs() < 1e-6, "{load}");
    assert!(world.acceleration(BodyId(1)).force.norm() < 1e-6);
}

/// The outside: the same scene without a ground. A slope far away lets the engine look for slopes.
#[test]
fn where_feet_hold_all_there_is_no_slope() {
    let crowd = || world(&on_lattice(8, [0.55, 0.33], 0.4), &[], BODIES, 1e-4);
    let far = Ring::through([(90.0, 0.0), (91.0, 0.0), (91.0, 1.0)].map(|(x, y)| vec2(x, y)).to_vec());
    let far = Ground { area: far.unwrap(), ..slope(0.0, 0.0) };
    let (mut with, mut without) = (on(crowd(), &[slope(0.0, 1.0), far], 1e-4), crowd());
    // Near a rim nobody is free.
    (with.shortlisting, without.shortlisting) = (Shortlisting::Off, Shortlisting::Off);
    for _ in 0..20 {
        with.advance(0.01).unwrap();
        without.advance(0.01).unwrap();
        assert_eq!(with.state(), without.state());
    }
}
