//! The closed-form solution of a motion without contact: linear relaxation under a drive that is constant or changes
//! linearly.

use super::circle::Circle;
use super::{Body, Pose, Scene, Twist, Wrench, rotation, vec2};

/// The solution of `dv/dt = a − λ v`, `dr/dt = v` over a duration, for constant `a` and `λ ≥ 0`:
/// `v = kept·v₀ + velocity_time·a` and `r = r₀ + velocity_time·v₀ + drive_time·a`.
///
/// With τ = 1/λ this is the solution of App. B, `v∞ = a τ`. It is valid at λ = 0 too. A drive that grows as `j t`
/// adds the time integral of what a constant `j` adds: `drive_time·j` to the velocity, and
/// [`FreeFlight::ramp_time`]`·j` to the position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreeFlight {
    /// \[1\] `e^{−λt}`
    pub kept: f64,
    /// \[s\] `(1 − e^{−λt})/λ`
    pub velocity_time: f64,
    /// \[s2\] `(t − velocity_time)/λ`
    pub drive_time: f64,
}

impl FreeFlight {
    /// Returns the solution over a duration \[s\] at a relaxation rate \[1/s\].
    pub fn over(rate: f64, duration: f64) -> FreeFlight {
        let x = rate * duration;
        let velocity_share = if x == 0.0 { 1.0 } else { -libm::expm1(-x) / x };
        // (1 − velocity_share)/x suffers from cancellation for small x; Σ (−x)^k/(k+2)! is exact up to rounding there.
        let drive_share = if x < 0.25 {
            (0..12).rev().fold(0.0, |sum, k| (1.0 - x * sum) / f64::from(k + 2))
        } else {
            (1.0 - velocity_share) / x
        };
        FreeFlight {
            kept: libm::exp(-x),
            velocity_time: duration * velocity_share,
            drive_time: duration * duration * drive_share,
        }
    }

    /// \[s3\] `(t²/2 − drive_time)/λ`, for the same rate and duration as this flight.
    pub fn ramp_time(&self, rate: f64, duration: f64) -> f64 {
        let x = rate * duration;
        if x < 1.0 {
            // The difference suffers from cancellation; Σ (−x)^k/(k+3)! is exact up to rounding, as above.
            let double = (0..16).rev().fold(0.0, |sum, k| (1.0 - x * sum) / f64::from(k + 3));
            duration * duration * duration * (0.5 * double)
        } else {
            (0.5 * duration * duration - self.drive_time) / rate
        }
    }
}

/// The free flights of a body's translation and rotation over one duration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyFlight {
    /// Flight of the centre of mass.
    pub translation: FreeFlight,
    /// Flight of the orientation.
    pub rotation: FreeFlight,
}

impl BodyFlight {
    /// Returns the flights over a duration \[s\], with the relaxation rate along the gaze in all directions.
    pub fn over(body: &Body, duration: f64) -> BodyFlight {
        BodyFlight {
            translation: FreeFlight::over(body.translation_rate, duration),
            rotation: FreeFlight::over(body.rotation_rate, duration),
        }
    }

    /// Returns pose and twist of the body at the end, under a drive divided by mass and moment of inertia.
    #[inline]
    pub fn fly(&self, pose: Pose, twist: Twist, acceleration: Wrench) -> (Pose, Twist) {
        let (t, r) = (&self.translation, &self.rotation);
        let end = Pose {
            position: pose.position + twist.velocity * t.velocity_time + acceleration.force * t.drive_time,
            orientation: pose.orientation
                + (twist.angular_velocity * r.velocity_time + acceleration.torque * r.drive_time),
        };
        let end_twist = Twist {
            velocity: twist.velocity * t.kept + acceleration.force * t.velocity_time,
            angular_velocity: twist.angular_velocity * r.kept + acceleration.torque * r.velocity_time,
        };
        (end, end_twist)
    }
}

/// Addition to a flight by another relaxation rate across the gaze: that of wheels. It is the flight across the gaze minus
/// the flight along it.
///
/// The whole is exact for a body that does not turn. If it turns, the gaze is that in the middle of the turn: the error
/// is of third order in the duration, and without a drive the speed does not grow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct AcrossFlight {
    /// The difference of the flights.
    added: FreeFlight,
    /// \[s3\] The difference of their [`FreeFlight::ramp_time`].
    ramp_time: f64,
}

impl AcrossFlight {
    /// Returns it over a duration \[s\]; `None` if the rates are the same.
    pub fn over(body: &Body, duration: f64) -> Option<AcrossFlight> {
        let rate = body.across_rate?;
        let [along, across] = [body.translation_rate, rate].map(|rate| FreeFlight::over(rate, duration));
        let ramp_time = across.ramp_time(rate, duration) - along.ramp_time(body.translation_rate, duration);
        let added = FreeFlight {
            kept: across.kept - along.kept,
            velocity_time: across.velocity_time - along.velocity_time,
            drive_time: across.drive_time - along.drive_time,
        };
        Some(AcrossFlight { added, ramp_time })
    }

    /// Returns it for each flight of a scene.
    pub fn all_over(scene: &Scene, duration: f64) -> Vec<Option<AcrossFlight>> {
        scene.flyers.iter().map(|body| AcrossFlight::over(&scene.bodies[body.index()], duration)).collect()
    }

    /// Adds it to pose and twist at the end of a flight, which began with a pose and a twist.
    pub fn add(&self, drive: Ramp, from: Pose, twist: Twist, end: &mut Pose, end_twist: &mut Twist) {
        let middle = rotation(0.5 * (from.orientation + end.orientation));
        let side = vec2(-middle.im, middle.re);
        let speed = side.dot(&twist.velocity);
        let (push, growth) = (side.dot(&drive.start.force), side.dot(&drive.rate.force));
        let FreeFlight { kept, velocity_time, drive_time } = self.added;
        end.position += side * (velocity_time * speed + drive_time * push + self.ramp_time * growth);
        end_twist.velocity += side * (kept * speed + velocity_time * push + drive_time * growth);
    }
}

/// The free flight of a body under a drive that changes linearly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RampFlight {
    /// Flight under the constant drive at the start.
    pub held: BodyFlight,
    /// \[s3\] [`FreeFlight::ramp_time`] of the translation.
    pub translation_ramp_time: f64,
    /// \[s3\] The same for the rotation.
    pub rotation_ramp_time: f64,
}

/// Accelerations by a drive that changes linearly (drive divided by mass and moment of inertia).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ramp {
    /// \[m/s2\], \[rad/s2\] accelerations at the start.
    pub start: Wrench,
    /// \[m/s3\], \[rad/s3\] their rates of change.
    pub rate: Wrench,
}

/// Lengths of the ways of a body during a flight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Paths {
    /// \[m\] of the centre of mass.
    pub position: f64,
    /// \[rad\] of the orientation.
    pub orientation: f64,
}

/// Accelerations by a drive: constant (a [`Wrench`]) or changing linearly (a [`Ramp`]).
///
/// They are two types, so that a constant drive needs no additional computations.
pub(super) trait Course: Copy + Send + Sync {
    /// The closed form of the motion under such a drive over a duration.
    type Flight: Send + Sync;

    /// The same where the place does not matter.
    type Plain: Course<Flight = Self::Flight>;

    /// Returns the flight of a body over a duration \[s\].
    fn flight(body: &Body, duration: f64) -> Self::Flight;

    /// Returns the flights over a duration \[s\]; that of a body is at the index [`Body::flyer`].
    fn flights(scene: &Scene, duration: f64) -> Vec<Self::Flight> {
        scene.flyers.iter().map(|body| Self::flight(&scene.bodies[body.index()], duration)).collect()
    }

    /// Returns the drive during a flight from a pose and a twist.
    fn plain(self, flight: &Self::Flight, pose: Pose, twist: Twist) -> Self::Plain;

    /// Returns whether it is the same in all of a circle.
    fn is_even(self, _: &Circle) -> bool {
        true
    }

    /// Returns pose and twist of a body at the end of a flight, without what wheels add ([`AcrossFlight`]).
    fn fly(self, flight: &Self::Flight, pose: Pose, twist: Twist) -> (Pose, Twist);

    /// Returns the drive after a time \[s\].
    fn after(self, time: f64) -> Self;

    /// Returns the accelerations at the start, and how they change.
    fn ramp(self) -> Ramp;

    /// Returns what its change adds to a flight: to the twist at its end, and to the lengths of the ways of position
    /// \[m\] and orientation \[rad\].
    fn added_by_change(self, flight: &Self::Flight) -> (Twist, Paths);
}

impl Course for Wrench {
    type Flight = BodyFlight;
    type Plain = Wrench;

    fn flight(body: &Body, duration: f64) -> BodyFlight {
        BodyFlight::over(body, duration)
    }

    #[inline]
    fn plain(self, _: &BodyFlight, _: Pose, _: Twist) -> Wrench {
        self
    }

    #[inline]
    fn fly(self, flight: &BodyFlight, pose: Pose, twist: Twist) -> (Pose, Twist) {
        flight.fly(pose, twist, self)
    }

    #[inline]
    fn after(self, _: f64) -> Wrench {
        self
    }

    fn ramp(self) -> Ramp {
        Ramp { start: self, rate: Wrench::default() }
    }

    fn added_by_change(self, _: &BodyFlight) -> (Twist, Paths) {
        (Twist::default(), Paths { position: 0.0, orientation: 0.0 })
    }
}

impl Course for Ramp {
    type Flight = RampFlight;
    type Plain = Ramp;

    fn flight(body: &Body, duration: f64) -> RampFlight {
        let held = BodyFlight::over(body, duration);
        RampFlight {
            translation_ramp_time: held.translation.ramp_time(body.translation_rate, duration),
            rotation_ramp_time: held.rotation.ramp_time(body.rotation_rate, duration),
            held,
        }
    }

    #[inline]
    fn plain(self, _: &RampFlight, _: Pose, _: Twist) -> Ramp {
        self
    }

    #[inline]
    fn fly(self, flight: &RampFlight, pose: Pose, twist: Twist) -> (Pose, Twist) {
        let (held, held_twist) = flight.held.fly(pose, twist, self.start);
        let (t, r) = (&flight.held.translation, &flight.held.rotation);
        let end = Pose {
            position: held.position + self.rate.force * flight.translation_ramp_time,
            orientation: held.orientation + self.rate.torque * flight.rotation_ramp_time,
        };
        let end_twist = Twist {
            velocity: held_twist.velocity + self.rate.force * t.drive_time,
            angular_velocity: held_twist.angular_velocity + self.rate.torque * r.drive_time,
        };
        (end, end_twist)
    }

    #[inline]
    fn after(self, time: f64) -> Ramp {
        let start = Wrench {
            force: self.start.force + self.rate.force * time,
            torque: self.start.torque + self.rate.torque * time,
        };
        Ramp { start, ..self }
    }

    fn ramp(self) -> Ramp {
        self
    }

    fn added_by_change(self, flight: &RampFlight) -> (Twist, Paths) {
        let Wrench { force, torque } = self.rate;
        let twist = Twist {
            velocity: force * flight.held.translation.drive_time,
            angular_velocity: torque * flight.held.rotation.drive_time,
        };
        let paths = Paths {
            position: force.norm() * flight.translation_ramp_time,
            orientation: torque.abs() * flight.rotation_ramp_time,
        };
        (twist, paths)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_agree_on_both_sides_of_the_series() {
        for rate in [0.0, 1e-12, 1e-6, 1e-3, 0.2, 0.249_999, 0.25, 0.3, 5.0, 80.0] {
            let one = FreeFlight::over(rate, 1.0);
            // Two half flights are one flight.
            let half = FreeFlight::over(rate, 0.5);
            let (v0, a) = (1.3, -0.7);
            let v1 = half.kept * v0 + half.velocity_time * a;
            let r1 = half.velocity_time * v0 + half.drive_time * a;
            let v2 = half.kept * v1 + half.velocity_time * a;
            let r2 = r1 + half.velocity_time * v1 + half.drive_time * a;
            assert!((one.kept * v0 + one.velocity_time * a - v2).abs() < 1e-15, "rate {rate}");
            assert!((one.velocity_time * v0 + one.drive_time * a - r2).abs() < 1e-15, "rate {rate}");
        }
    }

    #[test]
    fn no_relaxation_is_newtons_parabola() {
        let flight = FreeFlight::over(0.0, 0.3);
        assert_eq!((flight.kept, flight.velocity_time), (1.0, 0.3));
        assert!((flight.drive_time - 0.045).abs() < 1e-17);
    }
    fn body(translation_rate: f64, rotation_rate: f64) -> Body {
        Body {
            mass: 1.0,
            inertia: 1.0,
            inverse_mass: 1.0,
            inverse_inertia: 1.0,
            translation_rate,
            across_rate: None,
            rotation_rate,
            flyer: 0,
            disks: 0..1,
            bounding_radius: 0.2,
            reach: 0.0,
            extent: vec2(0.4, 0.4),
        }
    }

    const START: Pose = Pose { position: vec2(0.3, -0.1), orientation: 0.2 };
    const MOVING: Twist = Twist { velocity: vec2(1.3, -0.4), angular_velocity: 0.6 };
    const RAMP: Ramp = Ramp {
        start: Wrench { force: vec2(-0.7, 0.2), torque: 0.5 },
        rate: Wrench { force: vec2(0.9, -1.1), torque: -0.8 },
    };

    fn farthest((pose, twist): (Pose, Twist), (other, other_twist): (Pose, Twist)) -> f64 {
        [
            (pose.position - other.position).norm(),
            (pose.orientation - other.orientation).abs(),
            (twist.velocity - other_twist.velocity).norm(),
            (twist.angular_velocity - other_twist.angular_velocity).abs(),
        ]
        .into_iter()
        .fold(0.0, f64::max)
    }

    #[test]
    fn two_halves_of_a_ramp_are_one_ramp() {
        // On both sides of the limits of both series, and across them.
        for rate in [0.0, 1e-12, 1e-6, 1e-3, 0.2, 0.249_999, 0.25, 0.4, 0.999_999, 1.0, 1.5, 2.0, 5.0, 80.0] {
            let body = body(rate, 0.7 * rate);
            let one = RAMP.fly(&Ramp::flight(&body, 1.0), START, MOVING);
            let half = Ramp::flight(&body, 0.5);
            let (pose, twist) = RAMP.fly(&half, START, MOVING);
            let two = RAMP.after(0.5).fly(&half, pose, twist);
            assert!(farthest(one, two) < 2e-15, "rate {rate}: {:e}", farthest(one, two));
        }
    }

    #[test]
    fn a_ramp_without_relaxation_is_newtons_cubic() {
        for rate in [0.0, 1e-17] {
            let t: f64 = 0.3;
            let flight = Ramp::flight(&body(rate, rate), t);
            assert!((flight.translation_ramp_time / (t * t * t / 6.0) - 1.0).abs() < 4e-16);
            assert!((flight.held.translation.drive_time / (t * t / 2.0) - 1.0).abs() < 4e-16);
        }
    }

    #[test]
    fn ramp_time_is_continuous_where_the_series_ends() {
        let at = |rate: f64| FreeFlight::over(rate, 1.0).ramp_time(rate, 1.0);
        // Σ (−1)^k/(k+3)! = 1/2 − 1/e
        assert!((at(1.0) - (0.5 - (-1.0f64).exp())).abs() < 1e-15);
        assert!((at(1.0f64.next_down()) - at(1.0)).abs() < 1e-15);
    }

    #[test]
    fn a_ramp_that_does_not_change_is_a_held_drive() {
        let body = body(0.8, 3.0);
        let ramp = Ramp { rate: Wrench::default(), ..RAMP };
        let held = RAMP.start.fly(&Wrench::flight(&body, 0.6), START, MOVING);
        assert_eq!(ramp.fly(&Ramp::flight(&body, 0.6), START, MOVING), held);
    }
}
