//! A run at any time: between its frames everything is linear.

use anyhow::bail;
use crowd_mechanics::engine::{BodyId, Crowded, PairForce, State, World};
use crowd_mechanics::setup::{Setup, WorldError};
use lemons_core::plane::{Motion, Pose, vec2};
use lemons_core::trial::Trial;
use lemons_picture::Force;
use lemons_results::{Frame, Observed, Run};
use lemons_sim::stop::moves;

/// The crowd at one time.
pub struct Moment {
    /// \[s\]
    pub time: f64,
    pub agents: Vec<Motion>,
    /// Whether each is there, at the frame that is nearest in time.
    pub there: Vec<bool>,
    /// At that frame.
    pub observed: Vec<Observed>,
    /// Of that frame.
    pub nearest: usize,
}

/// Who has no pose is not drawn.
const NOWHERE: Pose = Pose { position: vec2(f64::NAN, f64::NAN), orientation: f64::NAN };

impl Moment {
    pub fn poses(&self) -> Vec<Pose> {
        let pose = |(agent, there): (&Motion, &bool)| if *there { agent.pose } else { NOWHERE };
        self.agents.iter().zip(&self.there).map(pose).collect()
    }
}

/// \[1\], \[N\] Recorded and computed squeezes agree to this, or the run had other parameters.
const AGREEMENT: (f64, f64) = (1e-3, 1.0);

/// \[s\] Times are sums of steps: rounding does not leave a frame out.
const ROUNDING: f64 = 1e-9;

/// A run of a Trial, whose frames all say what contacts do to each agent.
pub struct Footage {
    pub trial: Trial,
    pub run: Run,
}

/// The Trial's bodies, put where a run had them.
pub struct Shadow(World);

impl Footage {
    /// A run of the Trial's agents, in their order.
    pub fn new(trial: Trial, mut run: Run) -> Result<Footage, WorldError> {
        let mut shadow = Shadow::new(&trial)?;
        for frame in run.frames.iter_mut().filter(|frame| frame.observed.is_none()) {
            shadow.put(frame).map_err(|crowded| Setup::of(&trial).too_crowded(crowded))?;
            let bodies = shadow.0.contacts().bodies.iter();
            let seen = bodies.map(|body| Observed {
                agent_contacts: body.agent_contacts,
                wall_contacts: body.wall_contacts,
                contacting_agents: body.touching_bodies,
                normal_force: body.squeeze,
                of_step: None,
            });
            frame.observed = Some(seen.collect());
        }
        Ok(Footage { trial, run })
    }

    pub fn first(&self) -> f64 {
        self.run.times().0
    }

    pub fn last(&self) -> f64 {
        self.run.times().1
    }

    /// That a time \[s\] is one of the run's.
    pub fn check(&self, time: f64) -> anyhow::Result<()> {
        let (first, last) = (self.first(), self.last());
        if time < first - ROUNDING || time > last + ROUNDING {
            let source = self.run.source.display();
            bail!("{source}: t = {time:?} s is not in it: it goes from {first:?} to {last:?} s");
        }
        Ok(())
    }

    /// That none of its frames is between two times \[s\].
    pub fn nothing_between(&self, from: Option<f64>, until: Option<f64>) -> String {
        let (first, last) = (self.first(), self.last());
        let (from, until) = (from.unwrap_or(first), until.unwrap_or(last));
        let source = self.run.source.display();
        format!("{source}: no frame from {from:?} to {until:?} s: it goes from {first:?} to {last:?} s")
    }

    /// \[s\] The first frame from which on nobody moves; `None` if somebody does in the last.
    pub fn still_from(&self) -> Option<f64> {
        let frames = &self.run.frames;
        let moving = |frame: &Frame| moves(frame);
        let still = frames.iter().rposition(moving).map_or(0, |last| last + 1);
        frames.get(still).map(|frame| frame.time)
    }

    /// \[s\] The first frame without the last who has left, and how many are there; `None` if nobody has left.
    pub fn left_from(&self) -> Option<(f64, usize)> {
        let frames = &self.run.frames;
        let there = |frame: &Frame| frame.present().count();
        let stay = frames.last().map(there)?;
        let before = frames.iter().rposition(|frame| there(frame) != stay)?;
        frames.get(before + 1).map(|frame| (frame.time, stay))
    }

    /// At a time \[s\] of the run; its ends for times beyond them.
    pub fn at(&self, time: f64) -> Moment {
        let nearest = self.nearest(time);
        let time = time.clamp(self.first(), self.last());
        let observed = observed(&self.run.frames[nearest]).to_vec();
        let there = there(&self.run.frames[nearest]);
        Moment { time, agents: agents_at(&self.run, time), there, observed, nearest }
    }

    /// The place of the frame that is nearest to a time \[s\].
    pub fn nearest(&self, time: f64) -> usize {
        let frames = &self.run.frames;
        let after = frames.partition_point(|frame| frame.time <= time).min(frames.len() - 1);
        let before = after.saturating_sub(1);
        if time - frames[before].time < frames[after].time - time { before } else { after }
    }

    /// One of the frames as it is.
    pub fn frame(&self, place: usize) -> Moment {
        let frame = &self.run.frames[place];
        Moment {
            time: frame.time,
            agents: frame.agents.clone(),
            there: there(frame),
            observed: observed(frame).to_vec(),
            nearest: place,
        }
    }
}

impl Shadow {
    pub fn new(trial: &Trial) -> Result<Shadow, WorldError> {
        Ok(Shadow(Setup::of(trial).world()?))
    }

    fn put(&mut self, frame: &Frame) -> Result<(), Crowded> {
        for place in 0..frame.agents.len() {
            self.0.set_present(BodyId::from(place), frame.is_there(place));
        }
        let (poses, twists) = frame.agents.iter().map(|agent| (agent.pose, agent.twist)).unzip();
        self.0.restore(State::new(poses, twists))
    }

    /// The normal forces at the nearest frame: for each two that touch, their contacts together, from body to
    /// body; for each wall, from the body to where it touches.
    ///
    /// Also whether they are those that the run recorded; a run with other parameters had others.
    pub fn forces(&mut self, footage: &Footage, moment: &Moment) -> (Vec<Force>, bool) {
        let frame = &footage.run.frames[moment.nearest];
        if self.put(frame).is_err() {
            // No run of this Trial has so many in one place.
            return (Vec::new(), false);
        }
        let chain = |PairForce { from, to, normal_force }| Force { from, to, normal_force };
        let forces = self.0.pair_forces(&moment.poses()).into_iter().map(chain).collect();
        let (relative, absolute) = AGREEMENT;
        let agree = self.0.contacts().bodies.iter().zip(observed(frame)).all(|(computed, recorded)| {
            (computed.squeeze - recorded.normal_force).abs()
                <= absolute + relative * recorded.normal_force.max(computed.squeeze)
        });
        (forces, agree)
    }
}

fn there(frame: &Frame) -> Vec<bool> {
    (0..frame.agents.len()).map(|place| frame.is_there(place)).collect()
}

fn observed(frame: &Frame) -> &[Observed] {
    frame.observed.as_deref().unwrap_or_default()
}

/// Everybody at a time \[s\] of a run; its ends for times beyond them.
pub fn agents_at(run: &Run, time: f64) -> Vec<Motion> {
    let after = run.frames.partition_point(|frame| frame.time <= time);
    let (Some(before), Some(b)) = (after.checked_sub(1), run.frames.get(after)) else {
        return run.frames[after.min(run.frames.len() - 1)].agents.clone();
    };
    let a = &run.frames[before];
    let part = (time - a.time) / (b.time - a.time);
    a.agents.iter().zip(&b.agents).map(|(a, b)| a.towards(b, part)).collect()
}
