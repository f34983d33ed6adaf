//! Balance of people who stand: a linear inverted pendulum on feet.
//!
//! The ground's force on somebody acts at one place under the feet. With the centre of mass at x, at a height l, and
//! this place at p, the ground accelerates the body by ω₀² (x − p), where ω₀² = g/l. A person who stands moves p so that
//! the ground takes the velocity as in eq. 1, but p stays within the support: so the ground takes only what ankles can.
//!
//! - The extrapolated centre of mass is x + v/ω₀ (Hof, *Hum. Mov. Sci.* 27 (2008) 112). If it leaves the support, the
//!   person loses balance: no place of p stops the body any more.
//! - After the time of a step the feet stand under it, as far as a step reaches. If it is further away, the person falls.
//! - Who has stood still for a while walks back.
//!
//! Who walks has the legs under the body, and walks as without legs.

use crate::error::{PlanError, not_negative, number};
use lemons_core::plane::Vec2;
use serde::{Deserialize, Serialize};

/// \[m/s²\] Acceleration of gravity.
const GRAVITY: f64 = 9.81;
/// \[m/s\] Who is slower stands still.
const STILL: f64 = 0.1;
/// \[s\] Time in which the last part of the way back is walked.
const ARRIVING: f64 = 0.5;

/// Constants of the pendulum.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Pendulum {
    /// \[m\] Height of the centre of mass above the ground.
    pub height: f64,
    /// \[m\] Greatest distance of the ground's force from the middle of the feet.
    pub support: f64,
    /// \[s\] Time from the loss of balance until the feet stand elsewhere.
    pub step_time: f64,
    /// \[m\] Longest step.
    pub step_length: f64,
    /// \[s\] Time after which who stands still walks back.
    pub return_after: f64,
    /// \[m/s\] Speed of walking back.
    pub return_speed: f64,
    /// Part of the way that is walked back.
    pub return_part: f64,
}

impl Default for Pendulum {
    fn default() -> Pendulum {
        Pendulum {
            height: 0.97,
            support: 0.12,
            step_time: 0.25,
            step_length: 0.9,
            return_after: 0.6,
            return_speed: 0.2,
            return_part: 1.0,
        }
    }
}

/// Somebody, as the own legs feel it.
#[derive(Debug, Clone, Copy)]
pub struct Standing {
    /// \[m\] centre of mass.
    pub at: Vec2,
    /// \[m\] centre of mass at the last communication point.
    pub from: Vec2,
    /// \[m/s\]
    pub velocity: Vec2,
    /// \[1/s\] rate with which the ground takes the velocity, as far as it can.
    pub damping: f64,
}

/// Legs of a person, during the simulation and in a saved state.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Legs {
    /// \[m\] Middle of the feet.
    pub at: Vec2,
    /// \[m\] Own place, and the place to which the person walks back.
    home: Vec2,
    aim: Vec2,
    /// \[s\] Time until the feet stand elsewhere, if a step has begun.
    step: Option<f64>,
    /// \[s\] For how long the person has stood still, or walked back.
    calm: f64,
    floor: Floor,
    /// Number of steps to keep the balance.
    pub steps: u32,
    /// Whether no step could save the person, at some time.
    pub fallen: bool,
}

/// Compensation of the floor's damping, which the mechanics takes from the velocity at each moment, also from what a
/// collision changes between communication points: what was not compensated then is afterwards.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
struct Floor {
    /// \[m/s\] Velocity that was taken and not yet given back.
    owed: Vec2,
    /// \[m/s²\] Compensation of the last step, and the part of it that is for earlier steps.
    given: Vec2,
    late: Vec2,
    /// \[s\] Length of the last step.
    step: f64,
}

/// Part of what is owed that is given back in a step. All of it would make drives that are a step late oscillate.
const GIVEN_BACK: f64 = 0.5;

impl Floor {
    fn pass(&mut self, standing: &Standing, step: f64) {
        if self.step > 0.0 {
            self.owed += (standing.at - standing.from) * standing.damping - self.given * self.step;
        }
        // A short step after a long one gives back no more than another long one.
        self.late = self.owed * (GIVEN_BACK / step.max(self.step));
        self.given = standing.velocity * standing.damping + self.late;
        self.step = step;
        if !self.given.is_finite() {
            *self = Floor::default();
        }
    }
}

impl Pendulum {
    pub(crate) fn check(&self) -> Result<(), PlanError> {
        number("pendulum", "height", self.height, |l| (0.1..=10.0).contains(&l), "from 0.1 to 10 m")?;
        not_negative("pendulum", "support", self.support)?;
        not_negative("pendulum", "step_time", self.step_time)?;
        not_negative("pendulum", "step_length", self.step_length)?;
        not_negative("pendulum", "return_after", self.return_after)?;
        not_negative("pendulum", "return_speed", self.return_speed)?;
        number("pendulum", "return_part", self.return_part, |part| (0.0..=1.0).contains(&part), "from 0 to 1")
    }

    /// \[1/s\] Returns ω₀.
    fn rate(&self) -> f64 {
        (GRAVITY / self.height).sqrt()
    }

    fn is_within(&self, legs: &Legs, standing: &Standing) -> bool {
        self.extrapolated(legs, standing).norm() <= self.support
    }

    /// \[m\] Returns the extrapolated centre of mass, from the feet.
    fn extrapolated(&self, legs: &Legs, standing: &Standing) -> Vec2 {
        standing.at + standing.velocity * (1.0 / self.rate()) - legs.at
    }
}

impl Legs {
    /// Makes legs of somebody who stands here \[m\].
    pub fn new(at: Vec2) -> Legs {
        Legs {
            at,
            home: at,
            aim: at,
            step: None,
            calm: 0.0,
            floor: Floor::default(),
            steps: 0,
            fallen: false,
        }
    }

    /// Returns whether the ankles can keep the balance.
    pub fn is_balanced(&self, model: &Pendulum, standing: &Standing) -> bool {
        self.step.is_none() && model.is_within(self, standing)
    }

    /// \[m/s²\] Returns by how much the ground accelerates somebody who stands.
    pub fn acceleration(&self, model: &Pendulum, standing: &Standing) -> Vec2 {
        let stiffness = model.rate() * model.rate();
        let middle = (standing.at - self.at) * stiffness;
        let wanted = (self.way_back(model, standing.at) - standing.velocity) * standing.damping;
        middle + at_most(wanted - middle, stiffness * model.support)
    }

    /// \[m/s²\] Returns the same, and what compensates the floor's damping in the mechanics.
    pub fn drive(&self, model: &Pendulum, standing: &Standing) -> Vec2 {
        self.acceleration(model, standing) + standing.velocity * standing.damping + self.floor.late
    }

    /// \[m/s\] Returns the velocity of walking back.
    fn way_back(&self, model: &Pendulum, at: Vec2) -> Vec2 {
        let way = self.aim - at;
        let is_time = self.calm > model.return_after;
        if is_time { at_most(way * (1.0 / ARRIVING), model.return_speed) } else { Vec2::ZERO }
    }

    /// A step of time \[s\] passes for somebody who stands.
    pub fn stand(&mut self, model: &Pendulum, standing: &Standing, step: f64) {
        if self.floor.step == 0.0 {
            // The person has walked until now, whose drive the mechanics did not take.
            self.walk(standing.at);
        }
        self.floor.pass(standing, step);
        let back = self.way_back(model, standing.at);
        if self.calm > model.return_after {
            // The feet come under the body.
            self.at += back * step + (standing.at - self.at) * (step / ARRIVING).min(1.0);
        }
        let is_within = model.is_within(self, standing);
        if self.step.is_none() && !is_within {
            self.step = Some(model.step_time);
        }
        if self.step.is_some_and(|left| left <= 1e-9) {
            self.step = None;
            self.land(model, standing);
        }
        if let Some(left) = &mut self.step {
            *left -= step;
            self.calm = 0.0;
        } else if standing.velocity.norm() < STILL || back != Vec2::ZERO {
            if self.calm <= model.return_after {
                self.aim = standing.at + (self.home - standing.at) * model.return_part;
            }
            self.calm += step;
        } else {
            self.calm = 0.0;
        }
    }

    fn land(&mut self, model: &Pendulum, standing: &Standing) {
        let to = model.extrapolated(self, standing);
        self.fallen |= to.norm() > model.step_length + model.support;
        self.at += at_most(to, model.step_length);
        self.steps = self.steps.saturating_add(1);
    }

    /// The person walks, and is here \[m\].
    pub fn walk(&mut self, at: Vec2) {
        *self = Legs { steps: self.steps, fallen: self.fallen, ..Legs::new(at) };
    }

    /// Returns whether the numbers are possible.
    pub fn is_sound(&self) -> bool {
        let Floor { owed, given, late, step } = self.floor;
        let places = [self.at, self.home, self.aim, owed, given, late].iter().all(|place| place.is_finite());
        places && step.is_finite() && self.calm.is_finite() && self.step.is_none_or(f64::is_finite)
    }
}

/// Returns a vector, made shorter if it is longer than this.
fn at_most(vector: Vec2, length: f64) -> Vec2 {
    vector * (length / vector.norm().max(1e-12)).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lemons_core::plane::vec2;

    const STEP: f64 = 1e-3;
    /// \[1/s\] More than ω₀, so that ankles that can stop a body do.
    const DAMPING: f64 = 4.5;

    /// Returns legs and motion after some time \[s\], of somebody who is hit at the start and leaves with a velocity along x
    /// \[m/s\]. Heun's method.
    fn pushed(velocity: f64, time: f64) -> (Legs, Standing) {
        let model = Pendulum::default();
        let mut legs = Legs::new(Vec2::ZERO);
        let mut standing =
            Standing { at: Vec2::ZERO, from: Vec2::ZERO, velocity: vec2(velocity, 0.0), damping: DAMPING };
        for _ in 0..(time / STEP).round() as u32 {
            let a = legs.acceleration(&model, &standing);
            let velocity = standing.velocity + a * STEP;
            let next = Standing { at: standing.at + standing.velocity * STEP, velocity, ..standing };
            let b = legs.acceleration(&model, &next);
            legs.stand(&model, &standing, STEP);
            standing.at += (standing.velocity + velocity) * (0.5 * STEP);
            standing.velocity += (a + b) * (0.5 * STEP);
        }
        (legs, standing)
    }

    #[test]
    fn ankles_hold_what_the_extrapolated_centre_of_mass_says() {
        let model = Pendulum::default();
        let most = model.rate() * model.support;
        let (legs, standing) = pushed(0.98 * most, 0.5);
        assert!(legs.steps == 0 && legs.step.is_none() && legs.is_balanced(&model, &standing));
        // What ankles can hold is taken as by the floor of eq. 1.
        let (_, gentle) = pushed(0.2 * most, 0.5);
        let way = 0.2 * most / DAMPING * -libm::expm1(-DAMPING * 0.5);
        assert!((gentle.at.x - way).abs() < 1e-6, "{} {way}", gentle.at.x);
        assert_eq!(pushed(1.02 * most, 0.5).0.steps, 1);
    }

    /// Until the step, the ground's force is at the edge of the support: an unstable pendulum about it.
    #[test]
    fn who_has_lost_balance_falls_like_a_pendulum_and_steps_under_the_extrapolated_centre_of_mass() {
        let model = Pendulum::default();
        let (rate, edge, velocity) = (model.rate(), model.support, 1.0);
        let time = model.step_time;
        let (legs, standing) = pushed(velocity, time);
        let x = edge - edge * libm::cosh(rate * time) + velocity / rate * libm::sinh(rate * time);
        let v = -edge * rate * libm::sinh(rate * time) + velocity * libm::cosh(rate * time);
        let found = (standing.at.x, standing.velocity.x);
        assert!((found.0 - x).abs() < 1e-6 && (found.1 - v).abs() < 1e-6, "{found:?} {x} {v}");
        assert!(!legs.is_balanced(&model, &standing) && legs.at == Vec2::ZERO);
        let (after, _) = pushed(velocity, time + STEP);
        assert!((after.at.x - (x + v / rate)).abs() < 1e-6, "{} {x} {v}", after.at.x);
        assert_eq!((after.steps, after.fallen), (1, false));
        assert!(pushed(velocity, 1.0).1.velocity.norm() < 0.1);
    }

    /// (x + v/ω₀ − edge) grows by exp(ω₀ t) until the step, which must reach it to within the support.
    #[test]
    fn a_longer_way_than_a_step_is_a_fall() {
        let model = Pendulum::default();
        let grown = libm::exp(model.rate() * model.step_time);
        let most = model.rate() * (model.support + model.step_length / grown);
        for (part, fallen) in [(0.995, false), (1.005, true)] {
            assert_eq!(pushed(part * most, model.step_time + STEP).0.fallen, fallen, "{part}");
        }
    }

    /// The mechanics takes the velocity at each moment; drives are constant over steps, of which one is short.
    #[test]
    fn what_the_floor_takes_within_steps_of_any_length_is_given_back() {
        let model = Pendulum { return_after: 100.0, ..Pendulum::default() };
        let way = |lengths: &[f64]| {
            let mut legs = Legs::new(Vec2::ZERO);
            let mut standing =
                Standing { at: Vec2::ZERO, from: Vec2::ZERO, velocity: vec2(0.3, 0.0), damping: DAMPING };
            for &length in lengths {
                legs.stand(&model, &standing, length);
                let limit = legs.drive(&model, &standing) * (1.0 / DAMPING);
                let left = standing.velocity - limit;
                standing.from = standing.at;
                standing.at += limit * length + left * (-libm::expm1(-DAMPING * length) / DAMPING);
                standing.velocity = limit + left * libm::exp(-DAMPING * length);
            }
            standing.at.x
        };
        let fine = way(&[1e-3; 2000]);
        assert!((fine - 0.3 / DAMPING).abs() < 1e-3, "{fine}");
        let mut steps = [0.05; 40];
        for short in [1e-6, 1e-3, 0.05] {
            steps[1] = short;
            assert!((way(&steps) - fine).abs() < 0.02, "{short}: {} {fine}", way(&steps));
        }
    }

    #[test]
    fn people_walk_back_by_a_part_of_the_way() {
        for part in [1.0, 0.5, 0.0] {
            let model = Pendulum { return_part: part, ..Pendulum::default() };
            let (mut legs, standing) = pushed(1.0, 1.0);
            let mut at = standing.at;
            let away = at.x;
            for _ in 0..8000 {
                at += legs.way_back(&model, at) * STEP;
                legs.stand(&model, &Standing { at, velocity: Vec2::ZERO, ..standing }, STEP);
            }
            assert!((at.x - (1.0 - part) * away).abs() < 1e-3 && (legs.at - at).norm() < 1e-3, "{part}");
        }
    }
}
