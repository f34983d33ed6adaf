//! Quantities that pictures show of each agent at each time.

use super::trial_run::CrowdState;
use crate::error::Misused;
use anyhow::{Result, bail};
use clap::ValueEnum;
use lemons_core::plane::Motion;
use lemons_picture::ColourMap;
use lemons_results::columns::Effect;
use lemons_results::measure::{BalanceOverTime, MovingMeans, squeeze};
use lemons_results::{Frame, Run};

/// A quantity of each agent at each time.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DrawnQuantity {
    /// x of the centre of mass
    X,
    /// y of the centre of mass
    Y,
    /// Speed of the centre of mass
    Speed,
    /// Sum of |F_n| over the contacts: its mean over the communication step that ends at this time, or --over
    Squeeze,
    /// The greatest such mean until this time
    GreatestSqueeze,
    /// Largest value of this sum within that step
    PeakSqueeze,
    /// Its value at the time: of runs that do not say the others.
    #[value(skip)]
    SqueezeAtTheTime,
    /// Number of contacts with disks of other people and with walls
    Contacts,
    /// Where people have legs: distance of the centre of mass from the middle of the feet
    Lean,
    /// For how long people needed a step to keep the balance, until this time
    Unbalanced,
    /// How many steps they took to keep the balance
    Steps,
    /// 1 for who could not be saved by a step, at some time
    Fallen,
}

impl DrawnQuantity {
    /// Name and unit.
    pub fn label(self) -> (&'static str, &'static str) {
        match self {
            DrawnQuantity::X => ("x", "m"),
            DrawnQuantity::Y => ("y", "m"),
            DrawnQuantity::Speed => ("speed", "m/s"),
            DrawnQuantity::Squeeze => ("mean squeeze", "N"),
            DrawnQuantity::GreatestSqueeze => ("greatest mean squeeze", "N"),
            DrawnQuantity::PeakSqueeze => ("peak squeeze", "N"),
            DrawnQuantity::SqueezeAtTheTime => ("squeeze at the time", "N"),
            DrawnQuantity::Contacts => ("contacts", ""),
            DrawnQuantity::Lean => ("lean", "m"),
            DrawnQuantity::Unbalanced => ("time unbalanced so far", "s"),
            DrawnQuantity::Steps => ("steps so far", ""),
            DrawnQuantity::Fallen => ("fallen", ""),
        }
    }

    /// Returns whether it is a mean over a time.
    pub fn is_mean(self) -> bool {
        matches!(self, DrawnQuantity::Squeeze | DrawnQuantity::GreatestSqueeze)
    }

    /// Returns whether it is a sum of normal forces.
    pub fn is_squeeze(self) -> bool {
        self.label().1 == "N"
    }

    /// Returns whether it depends on all that was before.
    pub fn is_of_the_past(self) -> bool {
        matches!(self, DrawnQuantity::GreatestSqueeze | DrawnQuantity::Unbalanced)
    }

    /// Returns whether only people who have legs have it.
    fn is_of_legs(self) -> bool {
        matches!(
            self,
            DrawnQuantity::Lean | DrawnQuantity::Unbalanced | DrawnQuantity::Steps | DrawnQuantity::Fallen
        )
    }

    /// Returns whether contacts make it; else it is known of every run.
    pub fn is_of_contacts(self) -> bool {
        !(matches!(self, DrawnQuantity::X | DrawnQuantity::Y | DrawnQuantity::Speed) || self.is_of_legs())
    }

    /// Returns what can be shown of it: of a run that does not say what contacts did during its steps, the squeeze at
    /// the times, which is told.
    fn known_of(self, run: &Run) -> DrawnQuantity {
        let of_steps = self.is_mean() || self == DrawnQuantity::PeakSqueeze;
        if !of_steps || run.frames.iter().all(|frame| frame.effects.knows(Effect::MeanNormalForce)) {
            return self;
        }
        note!(
            "{}: it does not contain the {} over communication steps; the squeeze at this time is shown instead",
            run.source.display(),
            self.label().0
        );
        DrawnQuantity::SqueezeAtTheTime
    }
}

/// A quantity of everybody in each frame of a run.
pub struct DrawnValues {
    pub quantity: DrawnQuantity,
    /// \[s\] What means are over; `None`: one communication step.
    over: Option<f64>,
    /// \[N\] or \[s\] Of each frame, where frames before it count.
    values: Option<Vec<Vec<f64>>>,
}

impl DrawnValues {
    /// Takes what can be shown of a quantity from a run.
    ///
    /// # Errors
    /// Means are over less than a communication step, people have no legs, or nothing is known of contacts.
    pub fn of(quantity: DrawnQuantity, run: &Run, over: Option<f64>) -> Result<DrawnValues> {
        if quantity.is_of_contacts()
            && !run.frames.iter().all(|frame| frame.effects.knows(Effect::NormalForce))
        {
            let (source, (label, _)) = (run.source.display(), quantity.label());
            bail!(
                "{source}: it does not contain the {label}: these are positions only, without bodies and forces"
            );
        }
        let quantity = quantity.known_of(run);
        let over = over.filter(|_| quantity.is_mean());
        if let Some(over) = over {
            let longest = longest_gap(run);
            if longest > over * (1.0 + 1e-9) {
                bail!(Misused(format!(
                    "--over {over:?}: shorter than the time between two frames, {longest:.6} s"
                )));
            }
        }
        if quantity.is_of_legs() && !run.frames.iter().all(|frame| frame.legs.is_some()) {
            let (source, (label, _)) = (run.source.display(), quantity.label());
            bail!(
                "{source}: it does not contain the {label}: people have no legs in it (balance in decision.toml gives \
                 them; a Trial is run until --at or --until)"
            );
        }
        let greatest = quantity == DrawnQuantity::GreatestSqueeze;
        let values = if quantity == DrawnQuantity::Unbalanced {
            Some(unbalanced(run))
        } else {
            (over.is_some() || greatest).then(|| means(run, over, greatest))
        };
        Ok(DrawnValues { quantity, over, values })
    }

    pub fn label(&self) -> String {
        let (label, _) = self.quantity.label();
        let over = self.over.map_or("a step".to_owned(), |over| format!("{over} s"));
        match self.quantity {
            DrawnQuantity::Squeeze => format!("{label} over {over}"),
            DrawnQuantity::GreatestSqueeze => format!("{label} over {over} so far"),
            _ => label.to_owned(),
        }
    }

    pub fn unit(&self) -> &'static str {
        self.quantity.label().1
    }

    pub fn map(&self) -> ColourMap {
        if self.quantity.is_squeeze() {
            ColourMap::FromGrey
        } else if self.quantity.is_of_contacts() || self.quantity.is_of_legs() {
            ColourMap::FromPaper
        } else {
            ColourMap::Viridis
        }
    }

    /// Returns the values of everybody; NaN where it is not known.
    pub fn of_all(&self, state: &CrowdState) -> Vec<f64> {
        let of = |(k, agent)| self.value(state.frame, state.nearest, k, agent);
        state.agents.iter().enumerate().map(of).collect()
    }

    /// Returns the value of an agent in a frame; NaN where it is not known.
    pub fn of_one(&self, run: &Run, frame: usize, agent: usize) -> f64 {
        self.value(&run.frames[frame], frame, agent, &run.frames[frame].agents[agent])
    }

    /// Returns the value of an agent, who moves so, in a frame at a place of the run; NaN where it is not known, or if
    /// the agent has left.
    fn value(&self, frame: &Frame, place: usize, agent: usize, motion: &Motion) -> f64 {
        if !frame.is_there(agent) {
            return f64::NAN;
        }
        if let Some(values) = &self.values {
            return values[place][agent];
        }
        let effect = |effect| frame.effects.get(effect, agent);
        let legs = frame.legs.as_ref().map(|all| &all[agent]);
        let known = match self.quantity {
            DrawnQuantity::X => Some(motion.pose.position.x),
            DrawnQuantity::Y => Some(motion.pose.position.y),
            DrawnQuantity::Speed => Some(motion.twist.velocity.norm()),
            DrawnQuantity::Squeeze | DrawnQuantity::GreatestSqueeze => effect(Effect::MeanNormalForce),
            DrawnQuantity::PeakSqueeze => effect(Effect::PeakNormalForce),
            DrawnQuantity::SqueezeAtTheTime => effect(Effect::NormalForce),
            DrawnQuantity::Contacts => effect(Effect::AgentContacts)
                .zip(effect(Effect::WallContacts))
                .map(|(some, more)| some + more),
            DrawnQuantity::Lean => legs.map(|legs| (frame.agents[agent].pose.position - legs.feet).norm()),
            DrawnQuantity::Steps => legs.map(|legs| legs.steps.into()),
            DrawnQuantity::Fallen => legs.map(|legs| legs.fallen.into()),
            // Of the frames until then.
            DrawnQuantity::Unbalanced => None,
        };
        known.unwrap_or(f64::NAN)
    }
}

/// \[N\] Of each frame the mean squeeze of everybody over a time \[s\], or over the step that ends there; or the greatest
/// until then. NaN where it is not known yet.
fn means(run: &Run, over: Option<f64>, greatest: bool) -> Vec<Vec<f64>> {
    let people = run.ids.len();
    let mut moving = over.map(MovingMeans::over);
    let mut most = vec![f64::NAN; people];
    let of_frame = |(k, frame)| {
        let of_step: Vec<Option<f64>> =
            (0..people).map(|agent| squeeze(frame, agent, None).map(|(mean, _)| mean)).collect();
        let means = match &mut moving {
            Some(moving) => moving.add(frame.time, of_step.into_iter()),
            // At the start there was no step.
            None => (k > 0).then(|| of_step.into_iter().map(|mean| mean.unwrap_or(f64::NAN)).collect()),
        };
        let means = means.unwrap_or_else(|| vec![f64::NAN; people]);
        // The greater one; what is known, if the other is not.
        most.iter_mut().zip(&means).for_each(|(most, mean)| *most = most.max(*mean));
        if greatest { most.clone() } else { means }
    };
    run.frames.iter().enumerate().map(of_frame).collect()
}

/// \[s\] Of each frame for how long everybody was unbalanced until then.
fn unbalanced(run: &Run) -> Vec<Vec<f64>> {
    let mut balance = BalanceOverTime::of(run.ids.len());
    let until = |frame: &Frame| {
        balance.add(frame);
        balance.seen().iter().map(|one| one.time_unbalanced).collect()
    };
    run.frames.iter().map(until).collect()
}

/// \[s\] Returns the longest time between two frames.
pub fn longest_gap(run: &Run) -> f64 {
    run.frames.windows(2).map(|pair| pair[1].time - pair[0].time).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lemons_results::columns::{ALL, AgentRow};
    use lemons_results::measure::SqueezeOverTime;
    use std::path::PathBuf;

    /// Two people for three seconds, in steps of 0.1 s. The second one leaves after two.
    fn run() -> Run {
        let row = |mean: f64, there: bool| {
            let mut row = AgentRow::default();
            (row[10], row[11], row[14]) = (mean, mean, there.into());
            row
        };
        let frame = |k: u32| {
            let means = [f64::from(k * 37 % 11) * 30.0, f64::from(k * 13 % 7) * 50.0];
            ALL.frame_of_rows(0.1 * f64::from(k), &[row(means[0], true), row(means[1], k < 20)])
        };
        Run {
            source: PathBuf::new(),
            ids: vec!["a".into(), "b".into()],
            frames: (0..=30).map(frame).collect(),
        }
    }

    #[test]
    fn the_greatest_mean_so_far_is_that_of_an_exposure() {
        let run = run();
        let shown = DrawnValues::of(DrawnQuantity::GreatestSqueeze, &run, Some(1.0)).unwrap();
        for end in 0..run.frames.len() {
            let mut exposure = SqueezeOverTime::new(2, &[], None);
            for frame in &run.frames[..=end] {
                exposure.see(frame, None);
            }
            for (agent, seen) in exposure.so_far().iter().enumerate() {
                let value = shown.of_one(&run, end, agent);
                match seen.largest_mean[1].filter(|_| run.frames[end].is_there(agent)) {
                    Some(expected) => assert!((value - expected).abs() < 1e-9, "{end}: {value}, {expected}"),
                    None => assert!(value.is_nan(), "{end}: {value}"),
                }
            }
        }
        assert_eq!(shown.label(), "greatest mean squeeze over 1 s so far");
        assert!(DrawnValues::of(DrawnQuantity::Squeeze, &run, Some(0.05)).is_err(), "shorter than a step");
    }
}
