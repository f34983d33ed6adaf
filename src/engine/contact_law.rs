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

/// The forces of a contact (paper, App. A; Cundall–Strack spring with Coulomb's slider).
///
/// `depth` \[m\]; `normal_speed`, `tangential_speed` \[m/s\] of the receiver relative to the other at
/// the contact point; `elongation` \[m\] of the tangential spring.
#[inline]
pub fn react(
    law: &PairLaw,
    depth: f64,
    normal_speed: f64,
    tangential_speed: f64,
    elongation: f64,
) -> Reaction {
    // Kelvin–Voigt, not clamped: it may pull while disks separate fast.
    let normal = law.normal_stiffness * depth - law.normal_damping * normal_speed;
    let trial = -law.tangential_stiffness * elongation - law.tangential_damping * tangential_speed;
    let limit = law.friction * normal.abs();
    if trial.abs() <= limit {
        return Reaction { normal, tangential: trial, elongation, regime: Regime::Sticking };
    }
    let tangential = limit.copysign(trial);
    let elongation = -(tangential + law.tangential_damping * tangential_speed) / law.tangential_stiffness;
    Reaction { normal, tangential, elongation, regime: Regime::Sliding }
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
        let sticking = react(&LAW, 1e-3, 0.0, 0.0, 0.999 * limit / 5e5);
        assert_eq!(sticking.regime, Regime::Sticking);
        assert!((sticking.tangential + 0.999 * limit).abs() < 1e-9);
        let sliding = react(&LAW, 1e-3, 0.0, 0.2, 1.5 * limit / 5e5);
        assert_eq!(sliding.regime, Regime::Sliding);
        assert_eq!(sliding.tangential, -limit);
        // The force of a sliding spring is the sliding force itself.
        let again = react(&LAW, 1e-3, 0.0, 0.2, sliding.elongation);
        assert!((again.tangential + limit).abs() < 1e-9);
    }

    #[test]
    fn may_pull_while_parting() {
        assert_eq!(react(&LAW, 1e-4, 1.0, 0.0, 0.0).normal, 100.0 - 700.0);
    }
}
