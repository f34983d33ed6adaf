//! The rule: eq. 4 of the paper, and when a way-point is reached.
//!
//! It uses `libm` instead of the platform's arctangent, so that the result is the same bits on every machine.

use crate::queue::Lean;
use lemons_core::plane::{InPlane, Pose, Vec2};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// A way-point.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(deny_unknown_fields)]
pub struct Waypoint {
    /// \[m\] x.
    pub x: f64,
    /// \[m\] y.
    pub y: f64,
    /// \[m\] Radius, ≥ 0: the way-point is reached when the centre of mass is within it.
    #[serde(default = "usual_radius")]
    pub radius: f64,
    /// \[s\] Time for which a person stands there before it goes on.
    #[serde(default)]
    #[cfg_attr(feature = "typescript", ts(skip))]
    pub wait: f64,
}

/// \[m\] Radius of a way-point if it is not said.
pub const WAYPOINT_RADIUS: f64 = 0.3;

impl Waypoint {
    fn contains(&self, pose: Pose) -> bool {
        libm::hypot(self.x - pose.position.x, self.y - pose.position.y) <= self.radius
    }

    /// Whether somebody who has `waited` \[s\] waits longer. A rounding error is not a time.
    fn holds(&self, waited: f64) -> bool {
        self.wait - waited > 1e-9
    }
}

/// \[m\] Radius of a way-point that gives none.
fn usual_radius() -> f64 {
    WAYPOINT_RADIUS
}

/// \[m\] Stature of somebody of whom it is not known.
pub(crate) fn usual_stature() -> f64 {
    1.75
}

/// Propulsion force and torque of an agent.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Propulsion {
    /// \[N\] force along x and y.
    pub force: [f64; 2],
    /// \[N.m\] torque.
    pub torque: f64,
}

/// The data of an agent for the rule.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Walker {
    /// \[kg\] mass.
    pub mass: f64,
    /// \[kg.m2\] moment of inertia.
    pub moment_of_inertia: f64,
    /// \[1/s\] 1/t_transl, inverse relaxation time of the velocity.
    pub floor_damping: f64,
    /// \[1/s\] 1/t_rot, inverse relaxation time of the angular velocity.
    pub angular_damping: f64,
    /// \[m/s\] desired speed v₀.
    pub desired_speed: f64,
    /// \[s\] Time from which on it walks; it stands before.
    #[serde(default)]
    pub start: f64,
    /// \[s\] Time gap T to who is ahead.
    pub time_gap: f64,
    /// \[m\] Gap to who is ahead when standing.
    pub standstill_gap: f64,
    /// \[s\] Reaction time to gaps that change.
    pub reaction_time: f64,
    /// \[N\] Greatest force besides that which keeps the velocity; [`UNLIMITED`] or more is any.
    pub push: f64,
    /// \[m\] Stature.
    #[serde(default = "usual_stature")]
    pub stature: f64,
    /// Way-points, in order.
    pub waypoints: Vec<Waypoint>,
}

/// \[N\] From this push on there is no limit.
pub const UNLIMITED: f64 = 1e9;

/// \[m/s\] No factor makes anybody faster.
pub(crate) const FASTEST: f64 = 1e9;

/// Change of everybody's motivation during a run; what is not said stays as it is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Motivation {
    /// \[s\] Time from which on it holds.
    pub time: f64,
    /// \[m/s\] Desired speed v₀.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub desired_speed: Option<f64>,
    /// Factor of the desired speed that each person has then.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_factor: Option<f64>,
    /// \[s\] Time gap T to who is ahead.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_gap: Option<f64>,
    /// \[m\] Gap to who is ahead when standing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standstill_gap: Option<f64>,
    /// \[N\] Greatest push.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub push: Option<f64>,
}

impl Walker {
    /// Takes over a motivation.
    pub(crate) fn motivate(&mut self, by: &Motivation) {
        let speed = by.desired_speed.unwrap_or(self.desired_speed) * by.speed_factor.unwrap_or(1.0);
        self.desired_speed = speed.min(FASTEST);
        self.time_gap = by.time_gap.unwrap_or(self.time_gap);
        self.standstill_gap = by.standstill_gap.unwrap_or(self.standstill_gap);
        self.push = by.push.unwrap_or(self.push);
    }

    /// Returns the index of the next way-point at a pose, if it was `next` before, and the person has `waited` \[s\]
    /// there; the number of way-points after the last one.
    pub fn next(&self, mut next: usize, mut waited: f64, pose: Pose) -> usize {
        while let Some(waypoint) = self.waypoints.get(next) {
            // Who waits and is pushed away has been there.
            let reached = waited > 0.0 || waypoint.contains(pose);
            if !reached || waypoint.holds(waited) {
                break;
            }
            (next, waited) = (next + 1, 0.0);
        }
        next
    }

    /// Returns whether a person who has `waited` \[s\] at the way-point `next` stands there.
    pub fn waits(&self, next: usize, waited: f64, pose: Pose) -> bool {
        let stands =
            |waypoint: &Waypoint| waypoint.holds(waited) && (waited > 0.0 || waypoint.contains(pose));
        self.waypoints.get(next).is_some_and(stands)
    }

    /// Returns the propulsion of eq. 4 towards the way-point `next`; zero after the last one.
    pub fn drive(&self, next: usize, pose: Pose) -> Propulsion {
        let Some(waypoint) = self.waypoints.get(next) else { return Propulsion::default() };
        let (dx, dy) = (waypoint.x - pose.position.x, waypoint.y - pose.position.y);
        let distance = libm::hypot(dx, dy);
        if distance == 0.0 {
            return Propulsion::default();
        }
        let push = self.mass * self.desired_speed * self.floor_damping;
        let mismatch = wrapped(pose.orientation - libm::atan2(dy, dx));
        Propulsion {
            force: [push * (dx / distance), push * (dy / distance)],
            torque: -self.moment_of_inertia * mismatch * self.angular_damping * self.angular_damping,
        }
    }
}

impl Walker {
    /// Limits how hard somebody who has a velocity \[m/s\] pushes ahead: the force along the drive, without that which the
    /// floor takes. Braking and evading are not limited.
    pub fn limit(&self, drive: &mut Propulsion, velocity: Vec2) {
        let force = Vec2::from(drive.force);
        let Some(ahead) = force.unit(1e-9).filter(|_| self.push < UNLIMITED) else { return };
        let push = ahead.dot(&(force - velocity * (self.mass * self.floor_damping)));
        drive.force = (force - ahead * (push - self.push).max(0.0)).into();
    }

    /// Lets somebody who has a velocity \[m/s\] lean on who is in front. The push ahead, without what the floor takes, becomes
    /// the greater one of what it is and of the lean, for the part with which the person leans.
    pub(crate) fn lean(&self, drive: &mut Propulsion, velocity: Vec2, lean: &Lean) {
        let own = Vec2::from(drive.force);
        let push = lean.direction.dot(&(own - velocity * (self.mass * self.floor_damping)));
        drive.force = (own + lean.direction * (lean.part * (lean.force - push).max(0.0))).into();
    }

    /// Returns the propulsion whose force, with the floor's friction alone, leads to a velocity \[m/s\] (eq. 4), with a
    /// further force \[N\], and which turns the body to face a direction.
    pub fn towards(&self, pose: Pose, velocity: Vec2, force: Vec2, facing: Option<Vec2>) -> Propulsion {
        let force = velocity * (self.mass * self.floor_damping) + force;
        let mismatch =
            facing.map_or(0.0, |facing| wrapped(pose.orientation - libm::atan2(facing.y, facing.x)));
        let torque = -self.moment_of_inertia * mismatch * self.angular_damping * self.angular_damping;
        Propulsion { force: [force.x, force.y], torque }
    }
}

/// Returns the same angle \[rad\] in (−π, π].
fn wrapped(angle: f64) -> f64 {
    let turned = angle.rem_euclid(2.0 * PI);
    if turned > PI { turned - 2.0 * PI } else { turned }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lemons_core::plane::vec2;

    fn walker(waypoints: &[(f64, f64, f64)]) -> Walker {
        Walker {
            mass: 80.0,
            moment_of_inertia: 1.5,
            floor_damping: 2.0,
            angular_damping: 4.0,
            desired_speed: 1.3,
            start: 0.0,
            time_gap: 1.0,
            standstill_gap: 0.0,
            reaction_time: 0.0,
            push: UNLIMITED,
            stature: usual_stature(),
            waypoints: waypoints.iter().map(|&(x, y, radius)| Waypoint { x, y, radius, wait: 0.0 }).collect(),
        }
    }

    #[test]
    fn the_force_balances_the_floor_at_the_desired_speed() {
        let walker = walker(&[(3.0, 4.0, 0.1)]);
        let drive = walker.drive(0, Pose::default());
        let [x, y] = drive.force;
        // The floor takes m v/t_transl.
        assert!((x.hypot(y) - 80.0 * 1.3 * 2.0).abs() < 1e-12);
        assert!((y / x - 4.0 / 3.0).abs() < 1e-15);
    }

    #[test]
    fn a_push_is_limited_and_braking_is_not() {
        let walker = Walker { push: 100.0, ..walker(&[(3.0, 0.0, 0.1)]) };
        // Driven by m v₀/t_transl = 208 N; the floor takes 160 N at 1 m/s.
        for (x, y, ahead) in
            [(0.0, 0.0, 100.0), (0.0, 0.5, 100.0), (-0.2, 0.0, 68.0), (1.0, 0.0, 208.0), (2.0, 0.0, 208.0)]
        {
            let mut drive = walker.drive(0, Pose::default());
            walker.limit(&mut drive, vec2(x, y));
            assert!((drive.force[0] - ahead).abs() < 1e-12 && drive.force[1] == 0.0, "{x} {y}: {drive:?}");
        }
    }

    #[test]
    fn the_torque_turns_the_short_way() {
        let walker = walker(&[(-5.0, 0.0, 0.1)]);
        for (theta, mismatch) in
            [(3.0, 3.0 - PI), (-3.0, PI - 3.0), (PI, 0.0), (0.5, 0.5 - PI), (2.0 * PI + 3.0, 3.0 - PI)]
        {
            let torque = walker.drive(0, Pose::new(0.0, 0.0, theta)).torque;
            assert!((torque + 1.5 * 16.0 * mismatch).abs() < 1e-11, "{theta}: {torque}");
        }
    }

    #[test]
    fn waypoints_are_reached_one_after_the_other_and_some_at_once() {
        let walker = walker(&[(1.0, 0.0, 0.2), (1.1, 0.0, 0.3), (5.0, 0.0, 0.5)]);
        let at = |x| Pose::new(x, 0.0, 0.0);
        assert_eq!(walker.next(0, 0.0, at(0.0)), 0);
        assert_eq!(walker.next(0, 0.0, at(0.85)), 2, "the second is near as well");
        assert_eq!(walker.next(2, 0.0, at(0.0)), 2, "what was reached stays so");
        assert_eq!(walker.next(2, 0.0, at(4.6)), 3);
        assert_eq!(walker.drive(3, at(4.6)), Propulsion::default());
        assert_eq!(walker.next(0, 0.0, at(f64::NAN)), 0);
    }

    #[test]
    fn on_the_waypoint_there_is_no_direction() {
        let walker = walker(&[(1.0, 2.0, 0.0)]);
        let there = Pose::new(1.0, 2.0, 0.3);
        assert_eq!(walker.drive(0, there), Propulsion::default());
        assert_eq!(walker.next(0, 0.0, there), 1);
    }
}
