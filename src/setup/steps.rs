//! Mechanical steps of a scene: up to which step its contacts are stable, and which step has which accuracy.
//!
//! A contact acts like a spring on an effective mass m\*: 1/m\* = Σ (1/m + R²/I) over the bodies in contact (walls do not
//! move), where R is the distance from the centre of mass to the rim. Its pace Ω is the root of k/m\* + (γ/m\*)², with the
//! stiffer spring and the stronger damper. The step is of second order, so errors grow with (Ω dt)².

use super::Setup;
use crate::engine::{BodyId, Levels, Scene};
use lemons_core::message::{Message, message};
use lemons_core::rule::sentences::*;
use std::f64::consts::TAU;
use std::sync::Arc;

/// A mechanical step longer than this fraction of the shortest contact period causes a warning. Up to it, without
/// damping, bodies separate at most 1 % faster than they met.
const LONGEST_SHARE: f64 = 1.0 / 20.0;

/// Assumed number of simultaneous contacts of a body in a dense crowd. All of them act on the same motion of it.
pub(super) const CONTACTS_AT_ONCE: f64 = 8.0;

/// \[1/s\] Largest allowed growth rate of the slip of a sticking contact with almost no damping.
const FASTEST_GROWTH: f64 = 0.5;

/// \[m\] Error of a pose about a second after collisions at about 1 m/s, divided by (Ω dt / 2π)². Nine of ten people
/// are about as accurate or more, but not where they are pressed together. It was measured by
/// `crates/verify/examples/steps.rs` (docs/step.md).
const ERROR: f64 = 5.0;

/// \[m\] Accuracy of the proposed step.
const PROPOSED_ACCURACY: f64 = 1e-3;

/// \[m\] Finest accuracy for which a step is chosen. Smaller differences from the independent integrator were not seen.
pub const FINEST_ACCURACY: f64 = 1e-9;

/// Effects of mechanical steps in a scene. See [`Setup::steps`].
#[derive(Debug, Clone)]
pub struct Steps {
    /// \[1/s\] Ω of the fastest contact.
    pace: f64,
    /// \[s\] The shortest [`Rates::stable`].
    stable: f64,
    /// \[s\] The shortest [`Rates::longest_to_stick`].
    to_stick: f64,
    /// The contact with the shortest allowed step.
    pub(super) least_allowed: Fastest,
}

impl Steps {
    /// \[s\] Returns the longest step up to which all contacts are stable, if a body has up to eight of them: the exact
    /// limit of the step's polynomial, with springs and dampers.
    pub fn stable(&self) -> f64 {
        self.stable
    }

    /// \[s\] Returns the longest step without a warning: stable, and short enough for the period of each contact.
    pub fn longest(&self) -> f64 {
        self.least_allowed.rates.longest_step()
    }

    /// \[m\] Returns the error of a pose that a step \[s\] has about a second after collisions at about 1 m/s. Where
    /// people are pressed together, errors grow from one collision to the next.
    pub fn error(&self, step: f64) -> f64 {
        let turn = step * self.pace / TAU;
        ERROR * turn * turn
    }

    /// \[s\] Returns the step for an accuracy \[m\] in the sense of [`Steps::error`], rounded down to two digits, and at most
    /// [`Steps::longest`]. `None` if the accuracy is not positive and finite, or if there is no such step.
    pub fn accurate_to(&self, accuracy: f64) -> Option<f64> {
        if !(accuracy > 0.0 && accuracy.is_finite()) {
            return None;
        }
        two_digits(self.within(accuracy).min(self.longest()))
    }

    /// \[s\]
    fn within(&self, accuracy: f64) -> f64 {
        TAU / self.pace * (accuracy / ERROR).sqrt()
    }

    /// \[s\] Returns the proposed step: for an accuracy of 1 mm, short enough that a sticking contact gains almost no
    /// energy, rounded down to 1, 2 or 5 times a power of ten. `None` if there is no such step.
    pub fn proposed(&self) -> Option<f64> {
        rounded_down(self.within(PROPOSED_ACCURACY).min(self.to_stick))
    }
}

impl Setup<'_> {
    /// \[s\] Returns [`Steps::proposed`]; `None` also if nothing can touch.
    pub fn proposed_step(&self) -> Option<f64> {
        self.steps()?.proposed()
    }

    /// Returns what mechanical steps do with every contact that these agents and walls can have. `None` if nothing can
    /// touch, or if materials that can touch have no contact.
    pub fn steps(&self) -> Option<Steps> {
        self.steps_in(&self.scene().ok()?)
    }

    /// Returns `None` if nothing can touch.
    pub(super) fn steps_in(&self, scene: &Scene) -> Option<Steps> {
        let materials = self.used_materials().len();
        // The two lightest agents of each material, because a contact may be between two agents of the same material.
        let mut lightest: Vec<[Option<(f64, usize)>; 2]> = vec![[None; 2]; materials];
        for (b, body) in scene.bodies.iter().enumerate() {
            // Acceleration of a point at the body's rim per unit of force there.
            let lightness = 1.0 / body.mass + body.bounding_radius * body.bounding_radius / body.inertia;
            // Pressed over all its height, a body in levels may be stiffer than in the plan.
            let of_levels = |levels: &Arc<Levels>| levels.greatest_share(BodyId::from(b)).max(1.0);
            let lightness = lightness * scene.levels.as_ref().map_or(1.0, of_levels);
            let mut carried: Vec<usize> = body.disks.clone().map(|disk| scene.disks[disk].material).collect();
            carried.sort_unstable();
            carried.dedup();
            for material in carried {
                let [first, second] = &mut lightest[material];
                if first.is_none_or(|(other, _)| lightness > other) {
                    *second = first.replace((lightness, b));
                } else if second.is_none_or(|(other, _)| lightness > other) {
                    *second = Some((lightness, b));
                }
            }
        }
        // One wall for each material.
        let mut walls: Vec<Option<usize>> = vec![None; materials];
        for (wall, faces) in scene.wall_faces.iter().enumerate() {
            walls[scene.faces[faces.start].material].get_or_insert(wall);
        }
        let rates = |first: usize, second: usize, lightness: f64| {
            let law = scene.law(first, second);
            Rates {
                stiffness: law.normal_stiffness.max(law.tangential_stiffness) * lightness,
                damping: law.normal_damping.max(law.tangential_damping) * lightness,
                tangential_stiffness: law.tangential_stiffness * lightness,
                tangential_damping: law.tangential_damping * lightness,
            }
        };
        // With the materials, an agent, and another one or a wall.
        let mut contacts: Vec<(Rates, (usize, usize), usize, Other)> = Vec::new();
        for first in 0..materials {
            let Some((lightness, a)) = lightest[first][0] else { continue };
            for (second, others) in lightest.iter().enumerate().skip(first) {
                let pairs = lightest[first].iter().flatten().flat_map(|one| {
                    others.iter().flatten().filter(|other| other.1 != one.1).map(move |other| (one, other))
                });
                let sum = |pair: &(&(f64, usize), &(f64, usize))| pair.0.0 + pair.1.0;
                if let Some(pair) = pairs.max_by(|a, b| sum(a).total_cmp(&sum(b))) {
                    let rates = rates(first, second, sum(&pair));
                    contacts.push((rates, (first, second), pair.0.1, Other::Agent(pair.1.1)));
                }
            }
            for (second, wall) in walls.iter().enumerate() {
                let with = |wall| (rates(first, second, lightness), (first, second), a, Other::Wall(wall));
                contacts.extend(wall.map(with));
            }
        }
        let step = |contact: &&(Rates, _, _, _)| contact.0.longest_step();
        let &(least, materials, agent, other) = contacts.iter().min_by(|a, b| step(a).total_cmp(&step(b)))?;
        let id = |b: usize| &self.agents[b].id;
        let pair = match other {
            Other::Agent(other) => message!(TWO_AGENTS, one = id(agent), other = id(other)),
            Other::Wall(wall) => {
                message!(AGENT_AND_WALL, agent = id(agent), wall = &self.geometry.walls[wall].id)
            }
        };
        let all = || contacts.iter().map(|(rates, ..)| rates);
        Some(Steps {
            pace: all().map(Rates::pace).fold(0.0, f64::max),
            stable: all().map(Rates::stable).fold(f64::INFINITY, f64::min),
            to_stick: all().map(Rates::longest_to_stick).fold(f64::INFINITY, f64::min),
            least_allowed: Fastest { pair, rates: least, materials },
        })
    }
}

/// A thing that an agent touches.
#[derive(Clone, Copy)]
enum Other {
    Agent(usize),
    Wall(usize),
}

/// The stiffness and damping of a contact, divided by the effective mass of the touching points.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rates {
    /// \[1/s²\] k/m\*
    pub stiffness: f64,
    /// \[1/s\] γ/m\*
    pub damping: f64,
    /// \[1/s²\]
    tangential_stiffness: f64,
    /// \[1/s\]
    tangential_damping: f64,
}

impl Rates {
    /// \[s\] Period of the contact.
    pub fn period(&self) -> f64 {
        TAU / self.stiffness.sqrt()
    }

    /// \[1/s\] Critical γ/m\*, above which nothing bounces back: 2 √(k/m\*).
    pub fn critical_damping(&self) -> f64 {
        2.0 * self.stiffness.sqrt()
    }

    /// \[s\] Step from which the integration gains energy if a body has this many such contacts.
    ///
    /// Velocity Verlet with the force from x and the predicted velocity at the same instant has the characteristic
    /// polynomial z³ + (κ + 3g/2 − 2) z² + (1 − 2g) z + g/2 for κ = (k/m\*) dt², g = (γ/m\*) dt. All its roots are
    /// inside the unit circle exactly if κ/4 + g < 1. With n contacts of a body, κ and g are up to n times as large.
    pub fn unstable_from(&self, contacts: f64) -> f64 {
        let (damping, stiffness) = (contacts * self.damping, contacts * self.stiffness);
        2.0 / (damping + (damping * damping + stiffness).sqrt())
    }

    /// \[s\] Longest step at which the slip of a sticking contact grows no faster than allowed.
    ///
    /// A tangential spring is integrated by the trapezoidal rule for the predicted slip:
    /// 4z (z − 1)² + (3z − 1) (κ (z + 1) + 2g (z − 1)) = 0. For small κ and g its complex roots grow by κ²/8 − g/2 in
    /// a step.
    fn longest_to_stick(&self) -> f64 {
        let squared = self.tangential_stiffness * self.tangential_stiffness;
        (8.0 * (FASTEST_GROWTH + 0.5 * self.tangential_damping) / squared).cbrt()
    }

    /// \[s\] Longest stable step of a body with many such contacts.
    fn stable(&self) -> f64 {
        self.unstable_from(CONTACTS_AT_ONCE)
    }

    /// \[s\] Longest step without a warning.
    fn longest_step(&self) -> f64 {
        self.stable().min(self.longest_to_stick()).min(LONGEST_SHARE * self.period())
    }

    /// \[1/s\] Ω: as fast as the contact acts on the bodies, by spring and damper.
    fn pace(&self) -> f64 {
        (self.stiffness + self.damping * self.damping).sqrt()
    }
}

/// A contact and its owners.
#[derive(Debug, Clone)]
pub(super) struct Fastest {
    pub pair: Message,
    pub rates: Rates,
    /// Indices of both materials in the table of laws.
    pub materials: (usize, usize),
}

/// Rounds down to 1, 2 or 5 times a power of ten; `None` if the result is not a normal number.
pub(super) fn rounded_down(value: f64) -> Option<f64> {
    let power = value.log10().floor();
    // Parsed from text, so that it is the double nearest to the decimal number.
    let rounded = [5, 2, 1].map(|lead| format!("{lead}e{power}").parse().unwrap_or(f64::NAN));
    rounded.into_iter().find(|rounded| *rounded <= value).filter(|rounded| rounded.is_normal())
}

/// Rounds down to two decimal digits; `None` if the result is not a normal number.
fn two_digits(value: f64) -> Option<f64> {
    let near: f64 = format!("{value:.1e}").parse().ok()?;
    let power = value.log10().floor();
    let unit: f64 = format!("1e{}", power - 1.0).parse().ok()?;
    let rounded = if near <= value { near } else { format!("{:.1e}", near - unit).parse().ok()? };
    Some(rounded).filter(|rounded: &f64| rounded.is_normal() && *rounded > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lemons_core::trial::Trial;

    fn push() -> Trial {
        Trial::read(&lemons_testing::trial_push()).expect("the default Trial is in order").0
    }

    #[test]
    fn the_proposed_step_resolves_springs_and_dampers() {
        let mut trial = push();
        // The shortest period is 10.9 ms: 1/71 of it is 1.6e-4 s.
        assert_eq!(Setup::of(&trial).proposed_step(), Some(1e-4));
        // 1/m* of agent 1 and a wall is 0.0644/kg: with 1e6 kg/s a time of 15.5 µs.
        trial.materials.binary[2].gamma_tangential = 1e6;
        assert_eq!(Setup::of(&trial).proposed_step(), Some(1e-6));
        trial.geometry.walls.clear();
        trial.agents.truncate(1);
        assert_eq!(Setup::of(&trial).proposed_step(), None);
    }

    #[test]
    fn the_error_grows_with_the_square_of_the_step() {
        let steps = Setup::of(&push()).steps().unwrap();
        assert!((steps.error(2e-5) / steps.error(1e-5) - 4.0).abs() < 1e-12);
        for accuracy in [1e-3, 1e-4, 1e-6] {
            let step = steps.accurate_to(accuracy).unwrap();
            // Rounded down to two digits.
            assert!((0.8..=1.0).contains(&(steps.error(step) / accuracy)), "{step} {accuracy}");
        }
        assert_eq!(steps.accurate_to(10.0), two_digits(steps.longest()));
        assert!(steps.longest() < steps.stable());
        assert_eq!(
            [0.0, -1.0, f64::NAN, f64::INFINITY].map(|accuracy| steps.accurate_to(accuracy)),
            [None; 4]
        );
    }

    #[test]
    fn damping_shortens_the_stable_step_and_the_accurate_one() {
        let mut trial = push();
        let before = Setup::of(&trial).steps().unwrap();
        trial.materials.binary[2].gamma_normal = 2e6;
        let damped = Setup::of(&trial).steps().unwrap();
        // γ/m* = 2e6 kg/s × 0.0644/kg; eight contacts: unstable from κ/4 + g = 1 on.
        let limit = 1.0 / (8.0 * 2e6 * 0.0644);
        assert!((damped.stable() / limit - 1.0).abs() < 1e-2, "{} {limit}", damped.stable());
        assert!(damped.accurate_to(1e-4) < before.accurate_to(1e-4));
        // A light body is as bad.
        let mut trial = push();
        (trial.agents[2].mass, trial.agents[2].moment_of_inertia) = (0.001, 0.001);
        let light = Setup::of(&trial).steps().unwrap();
        assert!(light.stable() < 0.01 * before.stable());
    }

    #[test]
    fn rounding_goes_down() {
        assert_eq!(rounded_down(0.000_73), Some(0.000_5));
        assert_eq!(rounded_down(0.3), Some(0.2));
        assert_eq!(rounded_down(1.9), Some(1.0));
        assert_eq!([0.0, 1e-320, f64::NAN, f64::INFINITY].map(rounded_down), [None; 4]);
        assert_eq!(two_digits(0.000_739), Some(0.000_73));
        assert_eq!(two_digits(0.3), Some(0.3));
        assert_eq!(two_digits(9.99e-5), Some(9.9e-5));
        assert_eq!(two_digits(1.0e-5), Some(1.0e-5));
        assert_eq!([0.0, 1e-320, f64::NAN, f64::INFINITY].map(two_digits), [None; 4]);
    }
}
