//! A run of a Trial at any time: between its frames everything is linear.

use anyhow::bail;
use crowd_mechanics::setup::WorldError;
use lemons_core::plane::{Motion, Pose, Vec2, vec2};
use lemons_core::trial::Trial;
use lemons_results::columns::Effect;
use lemons_results::{Frame, Run};
use lemons_sim::Replay;
use lemons_sim::stop::moves;

/// The crowd at one time.
pub struct CrowdState<'r> {
    /// \[s\]
    pub time: f64,
    pub agents: Vec<Motion>,
    /// The frame that is nearest in time: who is there, and what contacts do.
    pub frame: &'r Frame,
    /// Its place in the run.
    pub nearest: usize,
}

/// The pose of those who are not there: they are not drawn.
const NOWHERE: Pose = Pose { position: vec2(f64::NAN, f64::NAN), orientation: f64::NAN };

impl CrowdState<'_> {
    pub fn poses(&self) -> Vec<Pose> {
        let turned = |pose: Pose| {
            let known = pose.orientation.is_finite();
            Pose { orientation: if known { pose.orientation } else { 0.0 }, ..pose }
        };
        let pose = |(k, agent): (usize, &Motion)| {
            if self.frame.is_there(k) { turned(agent.pose) } else { NOWHERE }
        };
        self.agents.iter().enumerate().map(pose).collect()
    }

    /// \[m\] Returns the middle of everybody's feet, as far from the body as in the frame; empty if people have no legs.
    pub fn feet(&self) -> Vec<Vec2> {
        let places = self.frame.agents.iter().zip(&*self.agents);
        let feet = self.frame.legs.iter().flatten().zip(places);
        feet.map(|(legs, (then, now))| now.pose.position + legs.feet - then.pose.position).collect()
    }
}

/// \[s\] Times are sums of steps: rounding does not leave a frame out.
const ROUNDING: f64 = 1e-9;

/// Whose bodies are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bodies {
    /// Those of the Trial that was simulated.
    Known,
    /// Circles, for people of whom only positions are known, and perhaps where they look.
    Assumed { oriented: bool },
}

/// A run of a Trial. Its frames all say what contacts do to each agent, if bodies are known.
pub struct TrialRun {
    pub trial: Trial,
    pub run: Run,
    pub bodies: Bodies,
}

impl TrialRun {
    /// A run of the Trial's agents, in their order.
    pub fn new(trial: Trial, mut run: Run, bodies: Bodies) -> Result<TrialRun, WorldError> {
        if bodies != Bodies::Known {
            return Ok(TrialRun { trial, run, bodies });
        }
        let mut replay = Replay::new(&trial)?;
        for frame in run.frames.iter_mut().filter(|frame| !frame.effects.knows(Effect::NormalForce)) {
            replay.put(frame)?;
            replay.record(frame);
        }
        Ok(TrialRun { trial, run, bodies })
    }

    /// Checks that a time \[s\] is one of the run's.
    pub fn check(&self, time: f64) -> anyhow::Result<()> {
        let (first, last) = self.run.times();
        if time < first - ROUNDING || time > last + ROUNDING {
            let source = self.run.source.display();
            bail!("{source}: t = {time:?} s is not in it: it goes from {first:?} to {last:?} s");
        }
        Ok(())
    }

    /// Returns the time \[s\] of the first frame from which on nobody moves; `None` if somebody does in the last.
    pub fn still_from(&self) -> Option<f64> {
        let frames = &self.run.frames;
        let still = frames.iter().rposition(moves).map_or(0, |last| last + 1);
        frames.get(still).map(|frame| frame.time)
    }

    /// Returns the crowd at a time \[s\] of the run; at its ends for times beyond them.
    pub fn at(&self, time: f64) -> CrowdState<'_> {
        let (first, last) = self.run.times();
        let (nearest, time) = (self.nearest(time), time.clamp(first, last));
        CrowdState { time, agents: agents_at(&self.run, time), frame: &self.run.frames[nearest], nearest }
    }

    /// Returns the place of the frame that is nearest to a time \[s\].
    pub fn nearest(&self, time: f64) -> usize {
        let frames = &self.run.frames;
        let after = frames.partition_point(|frame| frame.time <= time).min(frames.len() - 1);
        let before = after.saturating_sub(1);
        if time - frames[before].time < frames[after].time - time { before } else { after }
    }
}

/// Returns everybody at a time \[s\] of a run; at its ends for times beyond them.
pub fn agents_at(run: &Run, time: f64) -> Vec<Motion> {
    let after = run.frames.partition_point(|frame| frame.time <= time);
    let (Some(before), Some(b)) = (after.checked_sub(1), run.frames.get(after)) else {
        return run.frames[after.min(run.frames.len() - 1)].agents.clone();
    };
    let a = &run.frames[before];
    let part = (time - a.time) / (b.time - a.time);
    a.agents.iter().zip(&b.agents).map(|(a, b)| a.towards(b, part)).collect()
}

/// Says that none of the frames is between two times \[s\].
pub fn nothing_between(run: &Run, from: Option<f64>, until: Option<f64>) -> String {
    let (first, last) = run.times();
    let (from, until) = (from.unwrap_or(first), until.unwrap_or(last));
    let source = run.source.display();
    format!("{source}: no frame from {from:?} to {until:?} s: it goes from {first:?} to {last:?} s")
}
