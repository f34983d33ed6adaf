//! Who can touch nothing during a communication step (App. B), proved rather than guessed.
//!
//! Without contact a body follows the closed form of its [`Drive`], so a circle can be given that holds
//! it from beginning to end. Bodies whose circles stay clear of each other and of every wall are *free*.
//! The proof is kept up while time runs: a body that is not free moves by mechanical steps, and as soon
//! as it comes near a free body's circle, that body is taken into the mechanical steps too, at the
//! closed form's pose of that instant. So a push that travels through a row within one step is not missed.

use super::free_flight::Drive;
use super::neighbours::{CellGrid, Circle, SKIN, nears_a_face};
use super::{Scene, State};

/// A body whose path is longer than this many times the largest body's radius is not shortlisted: its
/// circle would make the cells of the grid large for everybody.
const LONGEST_HALF_PATH: f64 = 4.0;

/// How a body is moved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Activity {
    /// By the closed form, over the whole communication step.
    Free,
    /// By mechanical steps.
    Active,
}

/// Whether bodies may be shortlisted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Shortlisting {
    /// Bodies that can touch nothing are moved by the closed form.
    #[default]
    On,
    /// Every body is moved by mechanical steps: for comparison.
    Off,
}

#[derive(Debug, Clone, Default)]
pub(super) struct Shortlist {
    pub activity: Vec<Activity>,
    /// Holds the body during the whole communication step as long as nothing touches it.
    pub swept: Vec<Circle>,
}

impl Shortlist {
    /// Decides who is free over a duration \[s\].
    pub fn decide<D: Drive>(
        scene: &Scene,
        state: &State,
        drives: &[D],
        duration: f64,
        shortlisting: Shortlisting,
    ) -> Shortlist {
        let flights = D::flights(scene, duration);
        let swept: Vec<Circle> = scene
            .bodies
            .iter()
            .enumerate()
            .map(|(b, body)| {
                let (pose, twist) = (state.poses[b], state.twists[b]);
                let flight = &flights[body.flyer as usize];
                let (end, end_twist) = drives[b].fly(flight, pose, twist);
                // Under a held drive the velocity stays on the segment between its first and last value. A
                // change of the drive adds a motion along one line, never backwards. So no path is longer
                // than this, and a path lies within half its length of the middle of its ends.
                let (velocity_by_change, path_by_change) = drives[b].added_by_change(flight);
                let held = end_twist.velocity - velocity_by_change;
                let path = duration * twist.velocity.norm().max(held.norm()) + path_by_change;
                Circle {
                    centre: (pose.position + end.position) * 0.5,
                    radius: body.bounding_radius + 0.5 * path,
                }
            })
            .collect();
        if shortlisting == Shortlisting::Off {
            return Shortlist { activity: vec![Activity::Active; swept.len()], swept };
        }
        let largest = scene.bodies.iter().map(|body| body.bounding_radius).fold(0.0, f64::max);
        let mut activity: Vec<Activity> = swept
            .iter()
            .zip(&scene.bodies)
            .map(|(circle, body)| {
                // A path that is not a number is not free.
                if circle.radius - body.bounding_radius <= LONGEST_HALF_PATH * largest {
                    Activity::Free
                } else {
                    Activity::Active
                }
            })
            .collect();
        let short: Vec<usize> = (0..swept.len()).filter(|&b| activity[b] == Activity::Free).collect();
        let grid = CellGrid::new(&swept, short.iter().copied(), SKIN);
        let mut found = Vec::new();
        for b in short {
            let circle = &swept[b];
            let mut near = 0;
            // It is near itself.
            grid.for_each_near(circle, SKIN, |_| near += 1);
            if near > 1 || nears_a_face(scene, circle, &mut found) {
                activity[b] = Activity::Active;
            }
        }
        Shortlist { activity, swept }
    }
}

#[cfg(test)]
mod tests {
    use super::super::free_flight::Ramp;
    use super::super::{BodySpec, DiskSpec, LawTable, PairLaw, Pose, Twist, Vec2, Wrench, vec2};
    use super::*;
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    /// A round body of 1 kg with a radius of 1 mm.
    fn speck(translation_rate: f64) -> Scene {
        let mut laws = LawTable::new(1);
        let law = PairLaw {
            normal_stiffness: 1.0,
            tangential_stiffness: 1.0,
            normal_damping: 0.0,
            tangential_damping: 0.0,
            friction: 0.0,
        };
        laws.set(0, 0, law);
        let disks = vec![DiskSpec { radius: 0.001, position: Vec2::ZERO, material: 0 }];
        let body = BodySpec { mass: 1.0, inertia: 1.0, translation_rate, rotation_rate: 0.0, disks };
        Scene::new(&[body], &[], &laws).expect("the pair has the law")
    }

    /// By how much \[m\] the body leaves its swept circle.
    fn outside<D: Drive>(scene: &Scene, velocity: Vec2, drive: D, duration: f64) -> f64 {
        let (pose, twist) = (Pose::default(), Twist { velocity, angular_velocity: 0.0 });
        let state = State::new(vec![pose], vec![twist]);
        let circle = Shortlist::decide(scene, &state, &[drive], duration, Shortlisting::On).swept[0];
        let body = &scene.bodies[0];
        (0..=200)
            .map(|k| {
                let flight = D::flight(body, duration * f64::from(k) / 200.0);
                let (now, _) = drive.fly(&flight, pose, twist);
                (now.position - circle.centre).norm() + body.bounding_radius - circle.radius
            })
            .fold(f64::NEG_INFINITY, f64::max)
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, rng_seed: RngSeed::Fixed(7), ..ProptestConfig::default() })]

        /// Drives strong enough to turn round on the way, fast and slow relaxation.
        #[test]
        fn the_circle_holds_the_body(
            relaxation in prop::sample::select(vec![0.0, 0.1, 4.5, 300.0]),
            duration in 0.01..1.0f64,
            (vx, vy) in (-3.0..3.0f64, -3.0..3.0f64),
            (ax, ay) in (-20.0..20.0f64, -20.0..20.0f64),
            (jx, jy) in (-40.0..40.0f64, -40.0..40.0f64),
        ) {
            let (scene, velocity) = (speck(relaxation), vec2(vx, vy));
            let start = Wrench { force: vec2(ax, ay) * (1.0 / duration), torque: 0.0 };
            let rate = Wrench { force: vec2(jx, jy) * (1.0 / (duration * duration)), torque: 0.0 };
            let ramp = Ramp { start, rate };
            prop_assert!(outside(&scene, velocity, start, duration) < 1e-12);
            prop_assert!(outside(&scene, velocity, ramp, duration) < 1e-12);
        }
    }

    /// Its velocity is zero at both ends: a bound by the velocities at the ends would not see it move.
    #[test]
    fn the_circle_holds_who_starts_and_ends_at_rest() {
        let ramp = Ramp {
            start: Wrench { force: vec2(20.0, 0.0), torque: 0.0 },
            rate: Wrench { force: vec2(-80.0, 0.0), torque: 0.0 },
        };
        assert!(outside(&speck(0.0), Vec2::ZERO, ramp, 0.5) < 1e-12);
    }
}
