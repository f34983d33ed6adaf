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
    /// \[m\] elongation of the tangential spring.
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

/// The forces of a contact at one instant (paper, App. A: a spring with its damper, in series with Coulomb's slider).
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
    Reaction { normal, tangential: limit.copysign(trial), elongation, regime: Regime::Sliding }
}

/// How far a spring with a damper relaxes within a duration, while the force on both is given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Relaxation {
    /// \[1\] e^(−x) for x = k_t t/γ_t: the share of the deviation that remains. Zero without damping.
    remains: f64,
    /// \[1\] (1 − e^(−x))/x: the mean of that share over the duration.
    mean: f64,
}

impl Relaxation {
    /// Of the tangential spring of a law, over a duration \[s\].
    pub fn over(law: &PairLaw, duration: f64) -> Relaxation {
        let x = law.tangential_stiffness * duration / law.tangential_damping;
        if x > 0.0 {
            Relaxation { remains: libm::exp(-x), mean: -libm::expm1(-x) / x }
        } else if law.tangential_damping > 0.0 {
            Relaxation { remains: 1.0, mean: 1.0 }
        } else {
            Relaxation { remains: 0.0, mean: 0.0 }
        }
    }
}

/// State that a contact keeps from one instant to the next.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SpringHistory {
    /// \[m\] elongation of the tangential spring.
    pub elongation: f64,
    /// \[m/s\] rate of the elongation: the tangential speed; while the contact slides, that at which the spring and its
    /// damper follow the slider. Without a damper the tangential speed, too.
    pub rate: f64,
    /// \[N\] normal force.
    pub normal: f64,
}

impl SpringHistory {
    /// History of a contact that begins.
    pub const NONE: SpringHistory = SpringHistory { elongation: 0.0, rate: 0.0, normal: 0.0 };

    /// Returns the history of a contact with these forces, at a tangential speed \[m/s\].
    #[inline]
    pub fn after(law: &PairLaw, reaction: &Reaction, slip_speed: f64) -> SpringHistory {
        let Reaction { normal, tangential, elongation, regime } = *reaction;
        let follows = regime == Regime::Sliding && law.tangential_damping > 0.0;
        let force = -tangential - law.tangential_stiffness * elongation;
        let rate = if follows { force / law.tangential_damping } else { slip_speed };
        SpringHistory { elongation, rate, normal }
    }

    /// \[N\] The tangential force: that of the spring and its damper.
    #[inline]
    pub fn tangential(&self, law: &PairLaw) -> f64 {
        -law.tangential_stiffness * self.elongation - law.tangential_damping * self.rate
    }

    /// Returns the forces and the spring after a duration \[s\]. `normal` \[N\] and `slip_speed` \[m/s\] are those at
    /// its end, `relaxation` is that of the duration.
    ///
    /// Sticking: the trapezoidal rule for ds/dt = v_t keeps the integrator's second order. Sliding:
    /// γ_t ds/dt = −F_t − k_t s.
    #[inline]
    pub fn advanced(
        &self,
        law: &PairLaw,
        normal: f64,
        slip_speed: f64,
        duration: f64,
        relaxation: &Relaxation,
    ) -> Reaction {
        if self.normal * normal < 0.0 {
            return self.past_zero(law, normal, slip_speed, duration);
        }
        let stretched = self.elongation + 0.5 * duration * (self.rate + slip_speed);
        let mut reaction = react(law, normal, slip_speed, stretched);
        if reaction.regime == Regime::Sliding {
            reaction.elongation = self.following(law, reaction.tangential, relaxation);
        }
        reaction
    }

    /// Returns the elongation \[m\] after a duration at whose end the contact slides with the force `tangential` \[N\].
    ///
    /// The spring and its damper carry the force F_t of the slider: γ_t ds/dt = −F_t − k_t s. So the spring follows
    /// −F_t/k_t. This is the exact solution for a force that changes linearly. The equation also holds while the contact
    /// sticks, so it does not matter when within the duration it began to slide.
    #[inline]
    fn following(&self, law: &PairLaw, tangential: f64, relaxation: &Relaxation) -> f64 {
        let stiffness = law.tangential_stiffness;
        let (first, last) = (-self.tangential(law) / stiffness, -tangential / stiffness);
        last + (self.elongation - first) * relaxation.remains - (last - first) * relaxation.mean
    }

    /// The normal force changed its sign. Where it was zero, so was the slider's limit μ |F_n|: until then the spring
    /// relaxes under a force that falls to zero.
    #[cold]
    #[inline(never)]
    fn past_zero(&self, law: &PairLaw, normal: f64, slip_speed: f64, duration: f64) -> Reaction {
        let share = self.normal / (self.normal - normal);
        let (before, after) = (share * duration, (1.0 - share) * duration);
        let slip_then = self.rate + share * (slip_speed - self.rate);
        let elongation = self.following(law, 0.0, &Relaxation::over(law, before));
        let then = Reaction { normal: 0.0, tangential: 0.0, elongation, regime: Regime::Sliding };
        let zero = SpringHistory::after(law, &then, slip_then);
        zero.advanced(law, normal, slip_speed, after, &Relaxation::over(law, after))
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
    }

    fn advanced(
        law: &PairLaw,
        history: SpringHistory,
        normal: f64,
        slip_speed: f64,
        duration: f64,
    ) -> Reaction {
        history.advanced(law, normal, slip_speed, duration, &Relaxation::over(law, duration))
    }

    /// γ_t ds/dt = −F_t − k_t s, against many small steps of Euler's rule.
    #[test]
    fn a_sliding_spring_relaxes_under_the_sliders_force() {
        // Slides to the left under limits of 400 N to 480 N.
        let held = SpringHistory { elongation: 1e-4, rate: (400.0 - 50.0) / 300.0, normal: 1000.0 };
        let steps = 1_000_000;
        let dt = 1e-3 / f64::from(steps);
        let mut elongation = 1e-4;
        for k in 0..steps {
            let force = -(400.0 + 80.0 * (f64::from(k) + 0.5) / f64::from(steps));
            elongation += dt * (-force - 5e5 * elongation) / 300.0;
        }
        let reaction = advanced(&LAW, held, 1200.0, 3.0, 1e-3);
        assert_eq!((reaction.regime, reaction.tangential), (Regime::Sliding, -480.0));
        assert!((reaction.elongation - elongation).abs() < 1e-9, "{reaction:?} {elongation}");
        // Without damping it follows at once.
        let undamped = PairLaw { tangential_damping: 0.0, ..LAW };
        assert_eq!(advanced(&undamped, held, 1200.0, 3.0, 1e-3).elongation, 480.0 / 5e5);
        // The work of the force on the slider is never less than what the spring gains: it is passive.
        assert!(reaction.elongation < 480.0 / 5e5);
    }

    #[test]
    fn a_spring_relaxes_where_the_normal_force_is_zero() {
        let held = SpringHistory { elongation: 3e-4, rate: 0.1, normal: 300.0 };
        // Zero after three quarters of 1 ms, at a slip speed of 0.25 m/s. Undamped, the spring is then relaxed.
        let undamped = PairLaw { tangential_damping: 0.0, friction: 10.0, ..LAW };
        let reaction = advanced(&undamped, held, -100.0, 0.3, 1e-3);
        assert!((reaction.elongation - 0.25e-3 * 0.275).abs() < 1e-18, "{reaction:?}");
        // With damping it relaxes by e^(−k_t t/γ_t), here under a force of 120 N that falls to zero.
        let slides = SpringHistory { rate: (120.0 - 150.0) / 300.0, ..held };
        let reaction = advanced(&LAW, slides, -1e-12, 0.3, 1e-3);
        let x: f64 = 5e5 * 1e-3 / 300.0;
        let expected = (3e-4 - 120.0 / 5e5) * (-x).exp() + 120.0 / 5e5 * (1.0 - (-x).exp()) / x;
        assert!((reaction.elongation - expected).abs() < 1e-12, "{reaction:?} {expected}");
        // Where it pulls at both times, it holds.
        let pulls = SpringHistory { normal: -300.0, elongation: 0.0, ..held };
        let strong = PairLaw { friction: 10.0, ..LAW };
        assert_eq!(advanced(&strong, pulls, -100.0, 0.3, 1e-3).elongation, 1e-3 * 0.2);
    }

    #[test]
    fn may_pull_while_parting() {
        assert_eq!(normal_force(&LAW, 1e-4, 1.0), 100.0 - 700.0);
    }
}
