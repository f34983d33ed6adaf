//! Who can touch nothing during a communication step (App. B), proved rather than guessed.
//!
//! Without contact a body follows the closed form of its [`Drive`], so a circle can be given that holds
//! it from beginning to end. Bodies whose circles stay clear of each other and of every wall are *free*.
//! The proof is kept up while time runs: a body that is not free moves by mechanical steps, and as soon
//! as it comes near a free body's circle, that body is taken into the mechanical steps too, at the
//! closed form's pose of that instant. So a push that travels through a row within one step is not missed.

use super::free_flight::Drive;
use super::neighbours::{Circle, SKIN, for_each_near_pair};
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
        let swept: Vec<Circle> = scene
            .bodies
            .iter()
            .enumerate()
            .map(|(b, body)| {
                let (pose, twist) = (state.poses[b], state.twists[b]);
                let flight = D::flight(body, duration);
                let (end, end_twist) = drives[b].fly(&flight, pose, twist);
                // Under a held drive the velocity stays on the segment between its first and last value. A
                // change of the drive adds a motion along one line, never backwards. So no path is longer
                // than this, and a path lies within half its length of the middle of its ends.
                let (velocity_by_change, path_by_change) = drives[b].added_by_change(&flight);
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
        let circles: Vec<Circle> = short.iter().map(|&b| swept[b]).collect();
        for_each_near_pair(&circles, SKIN, |a, b| {
            activity[short[a]] = Activity::Active;
            activity[short[b]] = Activity::Active;
        });
        for &b in &short {
            let nears_wall = || (0..scene.faces.len()).any(|face| swept[b].nears_face(scene, face, SKIN));
            if activity[b] == Activity::Free && nears_wall() {
                activity[b] = Activity::Active;
            }
        }
        Shortlist { activity, swept }
    }
}
