//! The closed form of a motion without contact: constant drive, linear relaxation.

use super::{Body, Pose, Twist, Wrench};

/// The solution of `dv/dt = a − λ v`, `dr/dt = v` over a duration, for constant `a` and `λ ≥ 0`:
/// `v = kept·v₀ + velocity_time·a` and `r = r₀ + velocity_time·v₀ + drive_time·a`.
///
/// With τ = 1/λ this is the closed form of App. B, `v∞ = a τ`; it holds at λ = 0 too.
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
    /// Over a duration \[s\] at a relaxation rate \[1/s\].
    pub fn over(rate: f64, duration: f64) -> FreeFlight {
        let x = rate * duration;
        let velocity_share = if x == 0.0 { 1.0 } else { -libm::expm1(-x) / x };
        // (1 − velocity_share)/x cancels for small x; there Σ (−x)^k/(k+2)! is exact to rounding.
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
}

/// The free flights of a body's translation and rotation over one duration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyFlight {
    /// Of the centre of mass.
    pub translation: FreeFlight,
    /// Of the orientation.
    pub rotation: FreeFlight,
}

impl BodyFlight {
    /// Over a duration \[s\].
    pub fn over(body: &Body, duration: f64) -> BodyFlight {
        BodyFlight {
            translation: FreeFlight::over(body.translation_rate, duration),
            rotation: FreeFlight::over(body.rotation_rate, duration),
        }
    }

    /// Where the body is and how it moves at the end, under a drive per mass and inertia.
    #[inline]
    pub fn fly(&self, pose: Pose, twist: Twist, acceleration: Wrench) -> (Pose, Twist) {
        let (t, r) = (&self.translation, &self.rotation);
        let pose = Pose {
            position: pose.position + twist.velocity * t.velocity_time + acceleration.force * t.drive_time,
            orientation: pose.orientation
                + (twist.angular_velocity * r.velocity_time + acceleration.torque * r.drive_time),
        };
        let twist = Twist {
            velocity: twist.velocity * t.kept + acceleration.force * t.velocity_time,
            angular_velocity: twist.angular_velocity * r.kept + acceleration.torque * r.velocity_time,
        };
        (pose, twist)
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
}
