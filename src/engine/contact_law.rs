//! One law for every contact; a wall is a body at rest.

use super::PairLaw;

/// Whether the slider holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Regime {
    /// |F*| ≤ μ |F_n|
    Sticking,
    /// The tangential force is μ |F_n|.
    Sliding,
}

/// The forces of the contact law: signed numbers along the normal and the tangent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reaction {
    /// \[N\] along the normal, on the receiver; negative where it pulls.
    pub normal: f64,
    /// \[N\] along the tangent, on the receiver.
    pub tangential: f64,
    /// \[m\] the spring after the slider has given way.
    pub elongation: f64,
    /// Whether the contact sticks or slides.
    pub regime: Regime,
}

/// \[N\] The normal force of a contact (paper, App. A).
///
/// `depth` \[m\]; `normal_speed` \[m/s\] of the receiver relative to the other at the contact point. Kelvin–Voigt, not
/// clamped: it may pull while disks separate fast.
#[inline]
pub fn normal_force(law: &PairLaw, depth: f64, normal_speed: f64) -> f64 {
    law.normal_stiffness * depth - law.normal_damping * normal_speed
}

/// The forces of a contact (paper, App. A; Cundall–Strack spring with Coulomb's slider).
///
/// `normal` \[N\] is the [`normal_force`]; `tangential_speed` \[m/s\] of the receiver relative to the other at the
/// contact point; `elongation` \[m\] of the tangential spring.
#[inline]
pub fn react(law: &PairLaw, normal: f64, tangential_speed: f64, elongation: f64) -> Reaction {
    let trial = -law.tangential_stiffness * elongation - law.tangential_damping * tangential_speed;
    let limit = law.friction * normal.abs();
    if trial.abs() <= limit {
        return Reaction { normal, tangential: trial, elongation, regime: Regime::Sticking };
    }
    let tangential = limit.copysign(trial);
    let elongation = -(tangential + law.tangential_damping * tangential_speed) / law.tangential_stiffness;
    Reaction { normal, tangential, elongation, regime: Regime::Sliding }
}

/// What a contact keeps from one instant to the next.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Grip {
    /// \[m\] elongation of the tangential spring.
    pub elongation: f64,
    /// \[m/s\] tangential speed.
    pub slip_speed: f64,
    /// \[N\] normal force.
    pub normal: f64,
}

impl Grip {
    /// That of a contact that begins.
    pub const NONE: Grip = Grip { elongation: 0.0, slip_speed: 0.0, normal: 0.0 };

    /// Returns the elongation \[m\] after a duration \[s\], before the slider may give way. `normal` \[N\] and
    /// `slip_speed` \[m/s\] are those at its end.
    ///
    /// The trapezoidal rule for ds/dt = v_t keeps the integrator's second order.
    #[inline]
    pub fn stretched(&self, law: &PairLaw, normal: f64, slip_speed: f64, duration: f64) -> f64 {
        if self.normal * normal < 0.0 {
            return self.released(law, normal, slip_speed, duration);
        }
        self.elongation + 0.5 * duration * (self.slip_speed + slip_speed)
    }

    /// The normal force changed its sign. As it was zero, so was the slider's limit μ |F_n|, and the slider let go of
    /// the spring: it is stretched only since then.
    #[cold]
    fn released(&self, law: &PairLaw, normal: f64, slip_speed: f64, duration: f64) -> f64 {
        let share = self.normal / (self.normal - normal);
        let slip_then = self.slip_speed + share * (slip_speed - self.slip_speed);
        let free = -law.tangential_damping * slip_then / law.tangential_stiffness;
        free + 0.5 * (1.0 - share) * duration * (slip_then + slip_speed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAW: PairLaw = PairLaw {
        normal_stiffness: 1e6,
        tangential_stiffness: 5e5,
        normal_damping: 700.0,
        tangential_damping: 300.0,
        friction: 0.4,
    };

    #[test]
    fn sticks_below_and_slides_above_the_limit() {
        let limit = 0.4 * 1e6 * 1e-3;
        let sticking = react(&LAW, 1e3, 0.0, 0.999 * limit / 5e5);
        assert_eq!(sticking.regime, Regime::Sticking);
        assert!((sticking.tangential + 0.999 * limit).abs() < 1e-9);
        let sliding = react(&LAW, 1e3, 0.2, 1.5 * limit / 5e5);
        assert_eq!(sliding.regime, Regime::Sliding);
        assert_eq!(sliding.tangential, -limit);
        // The force of a sliding spring is the sliding force itself.
        let again = react(&LAW, 1e3, 0.2, sliding.elongation);
        assert!((again.tangential + limit).abs() < 1e-9);
    }

    #[test]
    fn a_spring_is_released_where_the_normal_force_is_zero() {
        let held = Grip { elongation: 3e-4, slip_speed: 0.1, normal: 300.0 };
        // Zero after three quarters of 1 ms, at a slip speed of 0.25 m/s.
        let stretched = held.stretched(&LAW, -100.0, 0.3, 1e-3);
        let at_zero = -300.0 * 0.25 / 5e5;
        assert!((stretched - (at_zero + 0.25e-3 * 0.275)).abs() < 1e-18);
        // Where it pulls at both times, it holds.
        let pulls = Grip { normal: -300.0, ..held };
        assert_eq!(pulls.stretched(&LAW, -100.0, 0.3, 1e-3), 3e-4 + 1e-3 * 0.2);
    }

    #[test]
    fn may_pull_while_parting() {
        assert_eq!(normal_force(&LAW, 1e-4, 1.0), 100.0 - 700.0);
    }
}
