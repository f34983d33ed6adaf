//! Finds bodies that cannot touch anything during a communication step (App. B), with a proof.
//!
//! Without contact a body follows the closed-form solution for its drive. So circles can be computed that contain
//! each of its disks from beginning to end. Bodies whose circles stay clear of each other and of every wall are *free*.
//! The proof is maintained during the step: bodies that are not free move by mechanical steps, and as soon as a disk of
//! one comes nearer than 20 mm (`AWAKE`) to a circle of a free body, the free body moves by mechanical steps too, from its
//! closed-form pose at that instant. So a push that travels through a row within one step is not missed.

use super::blocks::BLOCK;
use super::body_kinematics::BodyKinematics;
use super::broad_phase::{CellGrid, nears_a_face};
use super::circle::Circle;
use super::free_flight::Course;
use super::{FaceId, Pose, Scene, State, Threads};

/// A body whose half path is longer than this many times the largest body's radius is not free: its circle would make
/// the grid's cells too large.
const LONGEST_HALF_PATH: f64 = 4.0;

/// \[m\] What is nearer than this may touch. It only has to be larger than rounding errors.
const CLEAR: f64 = 1e-6;

/// How a body is moved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Activity {
    /// By the closed form, over the whole communication step.
    Free,
    /// By mechanical steps.
    Active,
    /// Not at all: it is not there.
    Absent,
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
    /// Circles that contain the bodies during the whole communication step as long as nothing touches them.
    pub swept: Vec<Circle>,
    /// The same for each disk.
    swept_disks: Vec<Circle>,
}

impl Shortlist {
    /// Decides which bodies are free over a duration \[s\], among those that may be: `activity` says who is known not to be,
    /// such as those who touch something.
    pub fn decide<D: Course>(
        scene: &Scene,
        state: &State,
        mut activity: Vec<Activity>,
        drives: &[D],
        duration: f64,
        threads: &Threads,
    ) -> Shortlist {
        if !activity.contains(&Activity::Free) {
            return Shortlist { activity, ..Shortlist::default() };
        }
        let mut shortlist = Shortlist::swept(scene, state, drives, duration);
        let (swept, largest) = (&shortlist.swept, scene.bodies.iter().map(|body| body.bounding_radius));
        let longest = LONGEST_HALF_PATH * largest.fold(0.0, f64::max);
        // A body whose path is not a number is not free. If the floor resists more across the gaze, there is no closed form
        // for one that turns.
        let is_short = |b: usize| {
            let (body, circle) = (&scene.bodies[b], &swept[b]);
            let is_short = circle.radius - body.bounding_radius <= longest;
            is_short
                && activity[b] != Activity::Absent
                && body.across_rate.is_none()
                && drives[b].is_even(circle)
        };
        let short: Vec<bool> = (0..swept.len()).map(is_short).collect();
        let grid = CellGrid::new(swept, (0..swept.len()).filter(|&b| short[b]), CLEAR);
        threads.each(activity.chunks_mut(BLOCK).enumerate(), |(k, activity)| {
            let (mut near, mut found) = (Vec::new(), Vec::new());
            let may_be_free = |(_, activity): &(usize, &mut Activity)| **activity == Activity::Free;
            for (b, activity) in (k * BLOCK..).zip(activity).filter(may_be_free) {
                near.clear();
                grid.for_each_near(&shortlist.swept[b], CLEAR, |other| near.push(other));
                let disks = &shortlist.swept_disks[scene.bodies[b].disks.clone()];
                let around = Circle::around(shortlist.swept[b].centre, disks);
                let meets =
                    |other: &usize| *other != b && shortlist.nears(scene, disks, &around, *other, CLEAR);
                if !short[b] || near.iter().any(meets) || shortlist.nears_a_face(scene, b, &mut found) {
                    *activity = Activity::Active;
                }
            }
        });
        shortlist.activity = activity;
        shortlist
    }

    /// Forgets the circles: nobody is free any more.
    pub fn forget_circles(&mut self) {
        (self.swept, self.swept_disks) = (Vec::new(), Vec::new());
    }

    /// Computes the circles, without deciding. Those of bodies with wheels are not used.
    fn swept<D: Course>(scene: &Scene, state: &State, drives: &[D], duration: f64) -> Shortlist {
        let flights = D::flights(scene, duration);
        let mut swept = Vec::with_capacity(scene.bodies.len());
        let mut swept_disks = Vec::with_capacity(scene.disks.len());
        for (b, body) in scene.bodies.iter().enumerate() {
            let (pose, twist) = (state.poses[b], state.twists[b]);
            let flight = &flights[body.flyer as usize];
            let (end, end_twist) = drives[b].fly(flight, pose, twist);
            // Under a constant drive the velocity stays on the segment between its first and last value. A change of
            // the drive adds a motion along one line, never backwards. So no path is longer than this, and it stays
            // within half its length of the midpoint of its ends. The same holds for the orientation.
            let (by_change, paths_by_change) = drives[b].added_by_change(flight);
            let held = end_twist.velocity - by_change.velocity;
            let held_rate = end_twist.angular_velocity - by_change.angular_velocity;
            let path = duration * twist.velocity.norm().max(held.norm()) + paths_by_change.position;
            let turn =
                duration * twist.angular_velocity.abs().max(held_rate.abs()) + paths_by_change.orientation;
            let middle = Pose {
                position: (pose.position + end.position) * 0.5,
                orientation: 0.5 * (pose.orientation + end.orientation),
            };
            swept.push(Circle { centre: middle.position, radius: body.bounding_radius + 0.5 * path });
            let spread = 0.5 * (path + body.reach * turn);
            swept_disks.extend(
                disks_of(scene, b, &BodyKinematics::at(middle, twist))
                    .map(|disk| Circle { radius: disk.radius + spread, ..disk }),
            );
        }
        Shortlist { activity: Vec::new(), swept, swept_disks }
    }

    /// Returns whether one of some disks, all of them in the circle `around`, is nearer than a margin \[m\] to what a body sweeps
    /// while it is free.
    pub fn nears(&self, scene: &Scene, disks: &[Circle], around: &Circle, body: usize, margin: f64) -> bool {
        let clear = |disk: &Circle, swept: &Circle| {
            let reach = disk.radius + swept.radius + margin;
            (disk.centre - swept.centre).norm_squared() > reach * reach
        };
        let swept = self.swept_disks[scene.bodies[body].disks.clone()].iter();
        let mut beside = swept.filter(|swept| !clear(around, swept));
        !beside.all(|swept| disks.iter().all(|disk| clear(disk, swept)))
    }

    /// Returns whether what a body sweeps while it is free may touch a face.
    fn nears_a_face(&self, scene: &Scene, body: usize, found: &mut Vec<FaceId>) -> bool {
        nears_a_face(scene, &self.swept[body], CLEAR, found)
            && self.swept_disks[scene.bodies[body].disks.clone()]
                .iter()
                .any(|disk| nears_a_face(scene, disk, CLEAR, found))
    }
}

/// Returns the disks of a body.
pub(super) fn disks_of(
    scene: &Scene,
    body: usize,
    kinematics: &BodyKinematics,
) -> impl Iterator<Item = Circle> {
    let disks = scene.disks[scene.bodies[body].disks.clone()].iter();
    disks.map(|disk| Circle { centre: kinematics.centre(disk.offset), radius: disk.radius })
}

#[cfg(test)]
mod tests {
    use super::super::free_flight::Ramp;
    use super::super::round_bodies::RoundBody;
    use super::super::{Twist, Vec2, Wrench, vec2};
    use super::*;
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    /// A round body of 1 kg with a radius of 1 mm.
    fn speck(relaxation: f64) -> Scene {
        RoundBody { mass: 1.0, radius: 0.001, relaxation, stiffness: 1.0 }.scene(1)
    }

    /// By how much \[m\] the body leaves its swept circle.
    fn outside<D: Course>(scene: &Scene, velocity: Vec2, drive: D, duration: f64) -> f64 {
        let (pose, twist) = (Pose::default(), Twist { velocity, angular_velocity: 0.0 });
        let state = State::new(vec![pose], vec![twist]);
        let circle =
            Shortlist::decide(scene, &state, vec![Activity::Free], &[drive], duration, &Threads::default())
                .swept[0];
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
        assert!(outside(&speck(0.0), Vec2::zeros(), ramp, 0.5) < 1e-12);
    }
}
