//! A dose of compression: how long trunks are pressed so hard that breathing tires.
//!
//! Motomura, Matsumoto, Yokota, Suzuki, Nishimoto, Ujihashi, J. Nippon Med. Sch. 86 (2019) 310: 14 healthy women lay on
//! their backs with weights on chest and abdomen. An index of breathing (BITI) became critical (0.15: such breathing fails
//! after about 45 min) after 14 min with 20 kg and 10 kg, after 2 min with 20 kg and 20 kg; not with less. A power law goes
//! through both: t(F) = 120 s (F₄₀/F)ⁿ with n = ln 7 / ln (4/3). The dose is ∫ dt/t(F); at 1 the index is critical. More
//! than 40 kg was not measured, and counts as 40 kg.
//!
//! Assumptions: F is the front–back compression of the trunk as a mean over a breath; people bear F times a factor of
//! their own, which is log-normal. What women who lie and rest bear says little about people who stand in a crowd.

use crate::Frame;
use crate::columns::Effect;
use crate::measure::{MovingMeans, present};
use lemons_core::trial::{Agent, GRAVITY, Trial};
use serde::Serialize;

/// \[N\], \[s\] Load and time to the critical index.
const MEASURED: [(f64, f64); 2] = [(30.0 * GRAVITY, 840.0), (40.0 * GRAVITY, 120.0)];
/// \[s\] A breath: 12 in a minute.
const BREATH: f64 = 5.0;
/// Standard deviation of the logarithm of what people bear: an assumption.
const SPREAD: f64 = 0.25;
/// What 5 %, 15 % … 95 % of people bear at most, in standard deviations.
const QUANTILES: [f64; 10] = [
    -1.644_854, -1.036_433, -0.674_490, -0.385_320, -0.125_661, 0.125_661, 0.385_320, 0.674_490, 1.036_433,
    1.644_854,
];
/// \[N\] Loads of others, whose times are counted: a bar of 0.1 m that men bore (Evans, Hayden 1971); that killed after 4 to
/// 6 min and after 15 s (Hopkins et al. 1993); all after Lee, Hughes, Accid. Anal. Prev. 38 (2006) 712.
pub const LOADS: [f64; 3] = [623.0, 1112.0, 6227.0];

/// The load on the trunk of a person over time. The names of the fields are those of the numbers in files.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Breathing {
    /// \[N\] Greatest mean over a breath of the front–back compression of the chest.
    pub front: f64,
    /// \[N\] The same side–side.
    pub side: f64,
    /// \[N\] The same of the smaller principal part.
    pub least: f64,
    /// Dose of somebody who bears as much as the median; 1: critical.
    pub dose: f64,
    /// \[s\] When it became 1.
    pub critical_at: Option<f64>,
    /// \[m\] Where the person was then.
    pub critical_x: Option<f64>,
    /// \[m\]
    pub critical_y: Option<f64>,
    /// Part of people who would have become critical in this place.
    pub critical_part: f64,
    /// \[s\] How long means over a breath of the trunk's load were above each of [`LOADS`].
    pub above_623: f64,
    /// \[s\]
    pub above_1112: f64,
    /// \[s\]
    pub above_6227: f64,
}

/// Sums up how trunks are pressed. It is given all communication points in the order of time.
#[derive(Debug, Clone)]
pub struct BreathingOverTime {
    people: Vec<Breathing>,
    doses: Vec<[f64; QUANTILES.len()]>,
    /// Of front, side, least.
    means: [MovingMeans; 3],
    /// For each person the trunk's load over that of the disks of the chest.
    trunks: Vec<f64>,
    before: Option<f64>,
    known: bool,
}

/// \[s\] Time to the critical index under a load \[N\].
fn time_to_critical(load: f64) -> f64 {
    let [(low, long), (high, short)] = MEASURED;
    let exponent = libm::log(long / short) / libm::log(high / low);
    short * libm::pow(high / load.min(high), exponent)
}

/// Returns the load on somebody's trunk over that on the disks of the chest: 1 if these are of all heights, as in a plan; else 2:
/// the abdomen is assumed to bear as much.
fn trunk(agent: &Agent) -> f64 {
    let chest = agent.chest_height.unwrap_or_default();
    let mut of_chest = agent.shapes.iter().filter(|shape| shape.heights.hold(chest));
    if of_chest.all(|shape| shape.heights.is_all()) { 1.0 } else { 2.0 }
}

impl BreathingOverTime {
    /// Begins, with the people of a Trial.
    pub fn of(trial: &Trial) -> BreathingOverTime {
        let people = trial.agents.len();
        BreathingOverTime {
            people: vec![Breathing::default(); people],
            doses: vec![[0.0; QUANTILES.len()]; people],
            means: std::array::from_fn(|_| MovingMeans::over(BREATH)),
            trunks: trial.agents.iter().map(trunk).collect(),
            before: None,
            known: true,
        }
    }

    /// Adds the next frame.
    pub fn add(&mut self, frame: &Frame) {
        self.known &= frame.effects.knows(Effect::ChestFront);
        let effects = [Effect::ChestFront, Effect::ChestSide, Effect::ChestLeast];
        let people = self.people.len();
        let mut over_breath = |k: usize| {
            let of = |agent| present(frame, agent).and_then(|_| frame.effects.get(effects[k], agent));
            self.means[k].add(frame.time, (0..people).map(of))
        };
        let [front, side, least] = [over_breath(0), over_breath(1), over_breath(2)];
        let step = self.before.replace(frame.time).map_or(0.0, |before| frame.time - before);
        let (Some(front), Some(side), Some(least)) = (front, side, least) else { return };
        for agent in (0..people).filter(|agent| present(frame, *agent).is_some()) {
            let (one, doses) = (&mut self.people[agent], &mut self.doses[agent]);
            one.front = one.front.max(front[agent]);
            one.side = one.side.max(side[agent]);
            one.least = one.least.max(least[agent]);
            let load = front[agent].max(0.0) * self.trunks[agent];
            let above = [&mut one.above_623, &mut one.above_1112, &mut one.above_6227];
            above
                .into_iter()
                .zip(LOADS)
                .filter(|(_, level)| load > *level)
                .for_each(|(time, _)| *time += step);
            if load == 0.0 {
                continue;
            }
            for (dose, quantile) in doses.iter_mut().zip(QUANTILES) {
                *dose += step / time_to_critical(load / libm::exp(SPREAD * quantile));
            }
            one.critical_part = doses.iter().filter(|dose| **dose >= 1.0).count() as f64 / doses.len() as f64;
            one.dose += step / time_to_critical(load);
            if one.dose >= 1.0 && one.critical_at.is_none() {
                let at = frame.agents[agent].pose.position;
                (one.critical_at, one.critical_x, one.critical_y) =
                    (Some(frame.time), Some(at.x), Some(at.y));
            }
        }
    }

    /// Returns how each person's trunk was pressed until now.
    pub fn seen(&self) -> &[Breathing] {
        &self.people
    }

    /// Returns the same.
    ///
    /// # Errors
    /// Why it is not known.
    pub fn finish(self) -> Result<Vec<Breathing>, &'static str> {
        if self.known && self.before.is_some() {
            return Ok(self.people);
        }
        Err(
            "the load on chests is not found: ChestHeight in Agents.xml asks for it (a crowd with levels has it)",
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lemons_core::plane::Motion;

    /// The dose of somebody under a load over time, in steps of 0.1 s.
    fn pressed(load: impl Fn(f64) -> f64, until: f64) -> Breathing {
        let agent = Agent { chest_height: Some(1.3), ..Agent::new("0", 80.0, 1.0, [1.0; 2]) };
        let trial = Trial { agents: vec![agent.with_disks(&[[0.0, 0.0, 0.2]])], ..Trial::default() };
        let mut seen = BreathingOverTime::of(&trial);
        for k in 0..=(until / 0.1).round() as u64 {
            let time = 0.1 * k as f64;
            let mut frame = Frame { time, agents: vec![Motion::default()], ..Frame::default() };
            frame.effects.record(Effect::ChestFront, [load(time)].into_iter());
            frame.effects.record(Effect::ChestSide, [0.5 * load(time)].into_iter());
            frame.effects.record(Effect::ChestLeast, [0.0].into_iter());
            seen.add(&frame);
        }
        seen.finish().unwrap()[0]
    }

    #[test]
    fn the_dose_is_critical_when_it_was_measured() {
        for (kilograms, expected) in [(40.0, 120.0), (30.0, 840.0), (120.0, 120.0)] {
            let one = pressed(|_| kilograms * GRAVITY, 900.0);
            // The mean over the first breath is known when it is over.
            let at = one.critical_at.unwrap();
            assert!((at - expected - BREATH).abs() < 0.2, "{kilograms} kg: {at} s");
            assert!((one.front / (kilograms * GRAVITY) - 1.0).abs() < 1e-9 && one.side < one.front);
        }
        // 20 kg: t = 840 s (3/2)^n, more than three hours; half of those who bear least are not yet critical.
        let light = pressed(|_| 20.0 * GRAVITY, 900.0);
        assert!(light.dose < 0.08 && light.critical_at.is_none() && light.critical_part <= 0.2);
        assert!((pressed(|_| 700.0, 65.0).above_623 - 60.0).abs() < 0.2);
    }

    /// Between two loads as long as they are borne, the dose is the sum of both parts (Palmgren, Miner).
    #[test]
    fn doses_add_up() {
        let one = pressed(|t| if t < 425.0 { 30.0 } else { 40.0 } * GRAVITY, 600.0);
        assert!((one.critical_at.unwrap() - (425.0 + 60.0)).abs() < 3.0, "{one:?}");
        // Most people bear more or less than the median.
        let half = pressed(|_| 40.0 * GRAVITY, 126.0);
        assert!((0.5..=1.0).contains(&half.critical_part), "{half:?}");
    }
}
