//! A linear inverted pendulum on feet.
//!
//! The ground's force on somebody acts at one place under the feet. With the centre of mass at x, at a height l, and
//! this place at p, the ground accelerates the body by ω₀² (x − p), where ω₀² = g/l. A person who stands moves p so that
//! the body comes to rest above the feet, but p stays within the support: so the ground takes only what ankles can.
//!
//! - A load that lasts is noticed, and ankles take a part of it: the person braces.
//! - The extrapolated centre of mass is x + v/ω₀ (Hof, *Hum. Mov. Sci.* 27 (2008) 112). If it leaves the support, the
//!   person loses balance: no place of p stops the body any more.
//! - After the time of a step the feet stand under it, or ahead of it, as far as a step reaches. If the extrapolated
//!   centre of mass is out of reach, the person has fallen.
//! - Who has stood still for a while walks back.

use super::{Legs, OwnMotion, STILL, at_most};
use crate::error::{PlanError, not_negative, number};
use lemons_core::plane::{InPlane, Vec2};
use lemons_core::trial::GRAVITY;
use serde::{Deserialize, Serialize};

/// \[s\] Time in which the last part of the way back is walked.
const ARRIVING: f64 = 0.5;
/// \[m\] Distance from walls at which a step ends: half the length of a foot.
const TOES: f64 = 0.13;
/// Friction of somebody who lies on the ground; clothes on concrete have 0.4 to 0.6.
const FRICTION: f64 = 0.5;

/// Constants of the pendulum.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Pendulum {
    /// Height of the centre of mass above the ground, as a part of the stature.
    pub height_part: f64,
    /// \[m\] Greatest distance of the ground's force from the middle of the feet.
    pub support: f64,
    /// \[1/s\] Rate with which ankles take the velocity of who keeps the balance.
    pub damping: f64,
    /// Part of a lasting load that ankles take.
    pub bracing: f64,
    /// \[s\] Time constant with which a load is noticed.
    pub bracing_time: f64,
    /// \[s\] Time from the loss of balance until the feet stand elsewhere.
    pub step_time: f64,
    /// \[m\] Longest step.
    pub step_length: f64,
    /// \[m\] Distance by which a step goes beyond the extrapolated centre of mass.
    pub step_margin: f64,
    /// \[m\] Least distance of the feet from those of others at the end of a step.
    pub feet_distance: f64,
    /// \[s\] Time after which who stands still walks back.
    pub return_after: f64,
    /// \[m/s\] Speed of walking back.
    pub return_speed: f64,
    /// Part of the way that is walked back.
    pub return_part: f64,
    /// Consequence of a fall.
    pub fall: Fall,
}

/// Consequence of a fall: no step can save the person.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fall {
    /// A count; the run goes on as if the step had been long enough.
    #[default]
    Counted,
    /// Lying on the ground from then on: slowed by it, and else without a drive.
    Lies,
}

impl Default for Pendulum {
    fn default() -> Pendulum {
        Pendulum {
            height_part: 0.56,
            support: 0.25,
            damping: 5.5,
            bracing: 0.8,
            bracing_time: 1.0,
            step_time: 0.09,
            step_length: 0.9,
            step_margin: 0.0,
            feet_distance: 0.0,
            return_after: 0.2,
            return_speed: 0.2,
            return_part: 1.0,
            fall: Fall::Counted,
        }
    }
}

impl Pendulum {
    pub(super) fn check(&self) -> Result<(), PlanError> {
        number(
            "pendulum",
            "height_part",
            self.height_part,
            |part| (0.1..=1.0).contains(&part),
            "from 0.1 to 1",
        )?;
        not_negative("pendulum", "support", self.support)?;
        let rate = |rate: f64| (0.0..=50.0).contains(&rate);
        number("pendulum", "damping", self.damping, rate, "from 0 to 50 /s")?;
        number("pendulum", "bracing", self.bracing, |part| (0.0..=0.95).contains(&part), "from 0 to 0.95")?;
        number(
            "pendulum",
            "bracing_time",
            self.bracing_time,
            |s| (0.1..=60.0).contains(&s),
            "from 0.1 to 60 s",
        )?;
        not_negative("pendulum", "step_time", self.step_time)?;
        not_negative("pendulum", "step_length", self.step_length)?;
        number("pendulum", "step_margin", self.step_margin, |m| (0.0..=1.0).contains(&m), "from 0 to 1 m")?;
        not_negative("pendulum", "feet_distance", self.feet_distance)?;
        not_negative("pendulum", "return_after", self.return_after)?;
        not_negative("pendulum", "return_speed", self.return_speed)?;
        number("pendulum", "return_part", self.return_part, |part| (0.0..=1.0).contains(&part), "from 0 to 1")
    }

    /// \[1/s\] Returns ω₀.
    fn rate(&self, motion: &OwnMotion) -> f64 {
        self.stiffness(motion.stature).sqrt()
    }

    /// \[1/s²\] Returns ω₀² of somebody of this stature \[m\].
    pub(crate) fn stiffness(&self, stature: f64) -> f64 {
        GRAVITY / (self.height_part * stature)
    }

    /// \[m\] Returns the extrapolated centre of mass, from the feet.
    fn extrapolated(&self, legs: &Legs, motion: &OwnMotion) -> Vec2 {
        motion.at + motion.velocity * (1.0 / self.rate(motion)) - legs.at
    }

    pub(super) fn is_balanced(&self, legs: &Legs, motion: &OwnMotion) -> bool {
        !self.lies(legs) && legs.step.is_none() && self.extrapolated(legs, motion).norm() <= self.support
    }

    /// Returns whether ankles can stop somebody who is above the feet: the extrapolated centre of mass stays within the
    /// support, at the start and later, at t = 2/λ − 1/(ω₀ a).
    pub(super) fn stops(&self, motion: &OwnMotion) -> bool {
        let (rate, damping) = (self.rate(motion), self.damping);
        let a = 1.0 - 0.5 * damping / rate;
        let weak = || 0.5 * damping / a * libm::exp(1.0 - 0.5 * damping / (rate * a));
        motion.velocity.norm() <= self.support * if damping < rate { weak() } else { rate }
    }

    pub(super) fn lies(&self, legs: &Legs) -> bool {
        legs.fallen && self.fall == Fall::Lies
    }

    /// \[m/s²\] Returns by how much the ground accelerates somebody who stands. Ankles damp the velocity, bring the body above
    /// the feet, without overshooting, and take a part of the load.
    fn acceleration(&self, legs: &Legs, motion: &OwnMotion) -> Vec2 {
        if self.lies(legs) {
            return at_most(motion.velocity * -motion.damping, FRICTION * GRAVITY);
        }
        let (lean, stiffness) = (motion.at - legs.at, self.rate(motion) * self.rate(motion));
        let upright = lean * (0.25 * self.damping * self.damping);
        let wanted = (self.way_back(legs, motion.at) - motion.velocity) * self.damping
            - upright
            - legs.load * self.bracing
            + motion.lean;
        lean * stiffness + at_most(wanted - lean * stiffness, stiffness * self.support)
    }

    /// \[m/s²\] Returns the same, and gives back what the floor takes by eq. 1.
    pub(super) fn drive(&self, legs: &Legs, motion: &OwnMotion) -> Vec2 {
        self.acceleration(legs, motion) + motion.velocity * motion.damping
    }

    /// \[m/s\] Returns the velocity of walking back.
    fn way_back(&self, legs: &Legs, at: Vec2) -> Vec2 {
        let way = (legs.aim - at) * (1.0 / ARRIVING);
        if legs.calm > self.return_after { at_most(way, self.return_speed) } else { Vec2::zeros() }
    }

    /// Moves the legs of somebody who stands by a step of time \[s\].
    pub(super) fn pass(&self, legs: &mut Legs, motion: &OwnMotion, around: Around, step: f64) {
        if self.lies(legs) {
            return;
        }
        if motion.lean == Vec2::zeros() {
            self.notice_load(legs, motion, step);
        } else {
            // Who leans passes on what presses from behind, and has the place where it stands now.
            (legs.load, legs.home, legs.calm) = (Vec2::zeros(), motion.at, 0.0);
        }
        // At the nearest communication point.
        if legs.step.is_some_and(|left| left <= 0.5 * step) {
            legs.step = None;
            self.land(legs, motion, around);
        }
        if legs.step.is_none() && !self.is_balanced(legs, motion) {
            legs.step = Some(self.step_time);
        }
        let back = if legs.step.is_none() { self.way_back(legs, motion.at) } else { Vec2::zeros() };
        if back != Vec2::zeros() {
            // The feet come under the body.
            legs.at += back * step + (motion.at - legs.at) * (step / ARRIVING).min(1.0);
        }
        // Who walks back is not faster by much.
        let slow = STILL + if back == Vec2::zeros() { 0.0 } else { self.return_speed };
        if let Some(left) = &mut legs.step {
            *left = (*left - step).max(0.0);
            legs.calm = 0.0;
        } else if motion.velocity.norm() > slow {
            legs.calm = 0.0;
        } else if motion.lean == Vec2::zeros() {
            if legs.calm <= self.return_after {
                legs.aim = motion.at + (legs.home - motion.at) * self.return_part;
            }
            legs.calm += step;
        }
        // What the ground does in this step, by the legs as they are now.
        // Who leans expects that the one in front stands against it.
        legs.velocity = motion.velocity + (self.acceleration(legs, motion) - motion.lean) * step;
    }

    /// Notices the load: what the ground does not explain of the velocity, with a low pass (a disturbance observer).
    fn notice_load(&self, legs: &mut Legs, motion: &OwnMotion, step: f64) {
        let change = (motion.velocity - legs.velocity) * (1.0 / self.bracing_time);
        // Implicit: also of a long step, the estimate of a steady load is this load.
        let kept = self.bracing_time / (self.bracing_time + step);
        // Ankles cannot take more.
        let most = self.rate(motion) * self.rate(motion) * self.support;
        legs.load = at_most((legs.load + change) * kept, most);
    }

    fn land(&self, legs: &mut Legs, motion: &OwnMotion, around: Around) {
        let to = self.extrapolated(legs, motion);
        let ahead = to.unit(1e-9).unwrap_or(Vec2::zeros()) * self.step_margin;
        let reach = if motion.steps { self.step_length } else { 0.0 };
        let falls = to.norm() > reach + self.support;
        // A body that nothing holds would be faster and faster.
        let step = if falls { to } else { at_most(to + ahead, self.step_length) };
        legs.at += step * around.room(legs.at, step, self.feet_distance);
        legs.fallen |= falls;
        legs.steps = legs.steps.saturating_add(1);
    }
}

/// Obstacles before which a step ends.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Around<'a> {
    /// Faces of walls \[m\].
    pub(super) faces: &'a [[Vec2; 2]],
    /// \[m\] Everybody's feet, the own ones too.
    pub(super) feet: &'a [Vec2],
}

impl Around<'_> {
    /// Returns the part of a step from a place \[m\] that walls leave, and feet of others with a distance \[m\] from them.
    fn room(&self, from: Vec2, step: Vec2, distance: f64) -> f64 {
        let length = step.norm().max(1e-9);
        let before_wall = |&[a, b]: &[Vec2; 2]| {
            let (wall, to) = (b - a, a - from);
            let cross = step.perp(&wall);
            let (part, place) = (to.perp(&wall) / cross, to.perp(&step) / cross);
            (part >= 0.0 && (0.0..=1.0).contains(&place)).then_some(part - TOES / length)
        };
        let before_feet = |&feet: &Vec2| {
            let ahead = (feet - from).dot(&step) / length;
            let aside = (feet - from).perp(&step) / length;
            let half = (distance * distance - aside * aside).sqrt();
            (ahead > 0.0 && half > 0.0).then_some((ahead - half) / length)
        };
        let walls = self.faces.iter().filter_map(before_wall);
        walls.chain(self.feet.iter().filter_map(before_feet)).fold(1.0, f64::min).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lemons_core::plane::vec2;

    const STEP: f64 = 1e-3;
    /// \[1/s\] Of the floor: what it takes, legs give back.
    const FLOOR: f64 = 4.5;
    const STATURE: f64 = 1.73;

    /// Returns who is hit, and does not feel it as a load.
    fn hit(velocity: f64) -> (Legs, OwnMotion) {
        let motion = OwnMotion {
            at: Vec2::zeros(),
            velocity: vec2(velocity, 0.0),
            damping: FLOOR,
            stature: STATURE,
            lean: Vec2::zeros(),
            steps: true,
        };
        (Legs::default().under(&motion, true), motion)
    }

    /// Moves legs and body for some time \[s\]; Heun's method.
    fn pass(model: &Pendulum, (mut legs, mut motion): (Legs, OwnMotion), time: f64) -> (Legs, OwnMotion) {
        for _ in 0..(time / STEP).round() as u32 {
            let a = model.acceleration(&legs, &motion);
            let velocity = motion.velocity + a * STEP;
            let next = OwnMotion { at: motion.at + motion.velocity * STEP, velocity, ..motion };
            let b = model.acceleration(&legs, &next);
            model.pass(&mut legs, &motion, Around::default(), STEP);
            motion.at += (motion.velocity + velocity) * (0.5 * STEP);
            motion.velocity += (a + b) * (0.5 * STEP);
        }
        (legs, motion)
    }

    fn pushed(velocity: f64, time: f64) -> (Legs, OwnMotion) {
        pass(&Pendulum { bracing: 0.0, return_after: 100.0, ..Pendulum::default() }, hit(velocity), time)
    }

    fn rate() -> f64 {
        (GRAVITY / (Pendulum::default().height_part * STATURE)).sqrt()
    }

    #[test]
    fn ankles_hold_what_the_extrapolated_centre_of_mass_says() {
        let model = Pendulum::default();
        let most = rate() * model.support;
        let (legs, motion) = pushed(0.98 * most, 0.5);
        assert!(legs.steps == 0 && legs.step.is_none() && model.is_balanced(&legs, &motion));
        assert_eq!(pushed(1.02 * most, 0.5).0.steps, 1);
        // Critically damped, like a body on a spring: v t exp(-λt/2).
        let (v, time) = (0.2 * most, 0.5);
        let (_, gentle) = pushed(v, time);
        let way = v * time * libm::exp(-0.5 * model.damping * time);
        assert!((gentle.at.x - way).abs() < 1e-6, "{} {way}", gentle.at.x);
    }

    /// An unstable pendulum about the edge of the support, where the ground's force is until the step.
    #[test]
    fn who_has_lost_balance_falls_like_a_pendulum_and_steps_under_the_extrapolated_centre_of_mass() {
        let model = Pendulum::default();
        let (edge, velocity, time) = (model.support, 1.0, model.step_time);
        let (legs, motion) = pushed(velocity, time);
        let x = edge - edge * libm::cosh(rate() * time) + velocity / rate() * libm::sinh(rate() * time);
        let v = -edge * rate() * libm::sinh(rate() * time) + velocity * libm::cosh(rate() * time);
        let found = (motion.at.x, motion.velocity.x);
        assert!((found.0 - x).abs() < 1e-6 && (found.1 - v).abs() < 1e-6, "{found:?} {x} {v}");
        assert!(!model.is_balanced(&legs, &motion) && legs.at == Vec2::zeros());
        for margin in [0.0, 0.1] {
            let ahead = Pendulum { step_margin: margin, ..model };
            let (after, _) = pass(&ahead, hit(velocity), time + STEP);
            assert!((after.at.x - (x + v / rate() + margin)).abs() < 1e-6, "{} {x} {v}", after.at.x);
            assert_eq!((after.steps, after.fallen), (1, false));
        }
        assert!(pushed(velocity, 1.5).1.velocity.norm() < 0.1);
    }

    /// (x + v/ω₀ − edge) grows by exp(ω₀ t) until the step, which must reach it to within the support.
    #[test]
    fn a_longer_way_than_a_step_is_a_fall() {
        let model = Pendulum::default();
        let grown = libm::exp(rate() * model.step_time);
        let most = rate() * (model.support + model.step_length / grown);
        for (part, fallen) in [(0.995, false), (1.005, true)] {
            assert_eq!(pushed(part * most, model.step_time + STEP).0.fallen, fallen, "{part}");
        }
        // Who lies is stopped by friction.
        let lying = Pendulum { fall: Fall::Lies, ..model };
        let (legs, motion) = pass(&lying, hit(1.1 * most), model.step_time + STEP);
        assert!(legs.fallen && !lying.is_balanced(&legs, &motion));
        let (legs, later) = pass(&lying, (legs, motion), 0.1);
        assert!((motion.velocity.x - later.velocity.x - 0.1 * FRICTION * GRAVITY).abs() < 1e-9);
        assert_eq!(legs.steps, 1);
    }

    /// On stairs nobody steps: the support is all there is.
    #[test]
    fn who_loses_balance_on_stairs_falls() {
        let model = Pendulum { bracing: 0.0, return_after: 100.0, ..Pendulum::default() };
        let most = rate() * model.support;
        for (part, falls) in [(0.98, false), (1.02, true)] {
            let (legs, motion) = hit(part * most);
            let on_stairs = OwnMotion { steps: false, ..motion };
            assert_eq!(pass(&model, (legs, on_stairs), 0.5).0.fallen, falls);
            assert!(!pass(&model, (legs, motion), 0.5).0.fallen);
        }
    }

    #[test]
    fn who_is_counted_as_fallen_comes_to_rest() {
        for velocity in [3.0, 10.0] {
            let (legs, motion) = pushed(velocity, 8.0);
            assert!(
                legs.fallen && motion.velocity.norm() < 0.3 && motion.at.x < 1.5 * velocity,
                "{motion:?}"
            );
        }
    }

    #[test]
    fn a_step_ends_before_walls_and_feet_of_others() {
        let wall = |x: f64| [vec2(x, -1.0), vec2(x, 1.0)];
        let step = vec2(0.5, 0.0);
        let room =
            |from: Vec2, step: Vec2, faces: &[[Vec2; 2]]| Around { faces, feet: &[] }.room(from, step, 0.1);
        for (x, part) in [(0.8, 1.0), (0.43, 0.6), (0.1, 0.0), (-0.1, 1.0)] {
            assert!((room(Vec2::zeros(), step, &[wall(2.0), wall(x)]) - part).abs() < 1e-12, "{x}");
        }
        // Beside its end, and along it.
        assert_eq!(room(vec2(0.0, 1.1), step, &[wall(0.2)]), 1.0);
        assert_eq!(room(vec2(0.2, -0.5), vec2(0.0, 0.3), &[wall(0.2)]), 1.0);
        // Too far, ahead, aside, beside, too near already (ahead, behind).
        let places = [
            (0.7, 0.0, 1.0),
            (0.4, 0.0, 0.6),
            (0.38, 0.06, 0.6),
            (0.4, 0.11, 1.0),
            (0.05, 0.0, 0.0),
            (-0.05, 0.0, 1.0),
        ];
        for (x, y, part) in places {
            let around = Around { faces: &[], feet: &[Vec2::zeros(), vec2(x, y)] };
            assert!((around.room(Vec2::zeros(), step, 0.1) - part).abs() < 1e-12, "{x} {y}");
        }
    }

    #[test]
    fn weak_ankles_stop_less() {
        for damping in [1.0, 2.0, 3.0] {
            let model = Pendulum { return_after: 100.0, damping, ..Pendulum::default() };
            let (legs, mut motion) = hit(0.0);
            while model.stops(&motion) {
                motion.velocity.x += 1e-4;
            }
            for part in [0.98, 1.02] {
                let hit = OwnMotion { velocity: motion.velocity * part, ..motion };
                let steps = pass(&model, (legs.under(&hit, true), hit), 3.0).0.steps;
                assert_eq!(steps > 0, part > 1.0, "{damping} {part}");
            }
        }
    }

    /// The equilibrium of ankles under a force of m ω₀² s λ²/(λ² + 4ω₀²(1 − bracing)) is at the edge of the feet.
    #[test]
    fn a_steady_push_is_held_up_to_a_limit() {
        for (bracing, part) in [(0.0, 0.98), (0.0, 1.02), (0.8, 0.97), (0.8, 1.02)] {
            let model = Pendulum { bracing, ..Pendulum::default() };
            let soft = 4.0 * (1.0 - bracing) * (rate() / model.damping).powi(2);
            let most = rate() * rate() * model.support / (1.0 + soft);
            let (mut legs, mut motion) = hit(0.0);
            for k in 0..100_000 {
                // The load comes slowly.
                let load = part * most * (f64::from(k) * 1.25e-5).min(1.0);
                motion.velocity.x += (model.acceleration(&legs, &motion).x + load) * STEP;
                motion.at.x += motion.velocity.x * STEP;
                model.pass(&mut legs, &motion, Around::default(), STEP);
                // No way back.
                legs.calm = 0.0;
            }
            assert_eq!(legs.steps > 0, part > 1.0, "{part}");
        }
    }

    /// The greatest lean from which one step of 15, 25 or 35 % of the stature saves somebody who is released grows by 36 and
    /// 23 % (young women; Hsiao-Wecksler, Robinovitch, Clin. Biomech. 22 (2007) 574). Of feet and reactions of the literature;
    /// the defaults, of people who are pushed, have 29 and 23 %.
    #[test]
    fn longer_steps_save_from_leans_that_are_larger_by_as_much_as_was_measured() {
        let most = |(support, step_time), part: f64| {
            let model = Pendulum { support, step_time, step_length: part * STATURE, ..Pendulum::default() };
            let saved = |lean: f64| {
                let (legs, mut motion) = hit(0.0);
                motion.at.x = lean;
                !pass(&model, (legs, motion), model.step_time + 2.0 * STEP).0.fallen
            };
            let (mut low, mut high) = (0.0, 2.0);
            while high - low > 1e-4 {
                let middle = 0.5 * (low + high);
                *(if saved(middle) { &mut low } else { &mut high }) = middle;
            }
            low
        };
        let of = Pendulum::default();
        for (feet, far) in [((0.12, 0.25), 0.06), ((of.support, of.step_time), 0.08)] {
            let [a, b, c] = [0.15, 0.25, 0.35].map(|part| most(feet, part));
            assert!((b / a - 1.36).abs() < far && (c / b - 1.23).abs() < 0.06, "{} {}", b / a, c / b);
        }
    }

    /// A second hit interrupts the way back, which begins again after the same time.
    #[test]
    fn people_walk_back_by_a_part_of_the_way() {
        for part in [1.0, 0.5, 0.0] {
            let model = Pendulum { return_part: part, return_after: 0.6, ..Pendulum::default() };
            let (mut legs, mut motion) = pass(&model, hit(1.0), 1.7);
            assert!(legs.calm > 0.0 && legs.steps == 1);
            let mut away = motion.at.x;
            if part < 1.0 {
                motion.velocity = vec2(0.8, 0.0);
                (legs, motion) = pass(&model, (legs, motion), 0.1);
                assert_eq!(legs.calm, 0.0);
                while motion.velocity.norm() > STILL || legs.step.is_some() {
                    (legs, motion) = pass(&model, (legs, motion), STEP);
                }
                let before = motion.at.x;
                (legs, motion) = pass(&model, (legs, motion), 0.9 * model.return_after);
                assert!((motion.at.x - before).abs() < 0.1 && before > away);
                away = motion.at.x;
            }
            (legs, motion) = pass(&model, (legs, motion), 12.0);
            let error = (motion.at.x - (1.0 - part) * away).abs();
            assert!(error < if part == 1.0 { 0.01 } else { 0.1 }, "{part}: {} of {away}", motion.at.x);
            assert!((legs.at - motion.at).norm() < 0.01, "{part}");
        }
    }
}
