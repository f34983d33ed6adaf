//! Slopes: what pulls bodies downhill.
//!
//! A body is where its centre of mass is. The pull is constant on a slope and jumps at its rim. A step in which a body
//! crosses a rim has the mean of both pulls over the time: the velocity is exact to first order in the rest of the
//! motion, the position to second order in the step. A body that may cross a rim in a communication step moves by
//! mechanical steps.

use super::Vec2;
use super::circle::Circle;
use super::free_flight::{Course, Paths, Ramp, RampFlight};
use super::{Body, Pose, Twist};
use lemons_core::plane::Bounds;
use lemons_core::trial::Ground;

/// Halvings with which a rim is found within a step.
const HALVINGS: usize = 30;

/// A ground with its pull.
#[derive(Debug, Clone, PartialEq)]
struct Slope {
    ground: Ground,
    bounds: Bounds,
    /// \[m/s2\]
    pull: Vec2,
}

/// All grounds of a scene.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Slopes(Vec<Slope>);

impl Slopes {
    pub fn new(grounds: &[Ground]) -> Slopes {
        let slope = |ground: &Ground| Slope {
            bounds: ground.area.bounds(),
            pull: ground.pull(),
            ground: ground.clone(),
        };
        let level = grounds.iter().all(|ground| ground.pull() == Vec2::zeros());
        Slopes(if level { Vec::new() } else { grounds.iter().map(slope).collect() })
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// \[m/s2\] Returns the pull at a place.
    pub fn pull(&self, place: Vec2) -> Vec2 {
        let here =
            self.0.iter().find(|slope| slope.bounds.contains(place) && slope.ground.area.contains(place));
        here.map_or(Vec2::zeros(), |slope| slope.pull)
    }

    /// Returns whether no rim is in a circle.
    fn are_even(&self, circle: &Circle) -> bool {
        let clear = |slope: &Slope| {
            !slope.bounds.grown(circle.radius).contains(circle.centre)
                || slope.ground.area.nearest(circle.centre).distance > circle.radius
        };
        self.0.iter().all(clear)
    }
}

/// A drive on slopes.
#[derive(Clone, Copy)]
pub(super) struct OnSlopes<'a> {
    pub drive: Ramp,
    pub slopes: &'a Slopes,
}

impl OnSlopes<'_> {
    fn pulled(self, by: Vec2) -> Ramp {
        let mut drive = self.drive;
        drive.start.force += by;
        drive
    }
}

impl Course for OnSlopes<'_> {
    type Flight = RampFlight;
    type Plain = Ramp;

    fn flight(body: &Body, duration: f64) -> RampFlight {
        Ramp::flight(body, duration)
    }

    fn plain(self, flight: &RampFlight, pose: Pose, twist: Twist) -> Ramp {
        let first = self.slopes.pull(pose.position);
        let drive = self.pulled(first);
        let end = drive.fly(flight, pose, twist).0.position;
        let last = self.slopes.pull(end);
        if first == last {
            return drive;
        }
        let way = end - pose.position;
        let (mut before, mut after) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (before + after);
            let here = self.slopes.pull(pose.position + way * middle);
            *(if here == first { &mut before } else { &mut after }) = middle;
        }
        self.pulled(first * before + last * (1.0 - before))
    }

    fn fly(self, flight: &RampFlight, pose: Pose, twist: Twist) -> (Pose, Twist) {
        self.plain(flight, pose, twist).fly(flight, pose, twist)
    }

    fn after(self, time: f64) -> Self {
        OnSlopes { drive: self.drive.after(time), ..self }
    }

    fn ramp(self) -> Ramp {
        self.drive
    }

    fn added_by_change(self, flight: &RampFlight) -> (Twist, Paths) {
        self.drive.added_by_change(flight)
    }

    fn is_even(self, swept: &Circle) -> bool {
        self.slopes.are_even(swept)
    }
}
