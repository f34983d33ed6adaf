//! A run at any time: between its frames everything is linear.

use crate::crowd_run::moves;
use anyhow::bail;
use crowd_mechanics::engine::{Crowded, Pair, State, World};
use crowd_mechanics::setup::{Setup, WorldError};
use lemons_picture::Force;
use lemons_plane::{Motion, Pose, Rotation, Vec2};
use lemons_record::{Frame, Observed, Run};
use lemons_trial::Trial;
use std::collections::BTreeMap;

/// The crowd at one time.
pub struct Moment {
    /// \[s\]
    pub time: f64,
    pub agents: Vec<Motion>,
    /// At the frame that is nearest in time.
    pub observed: Vec<Observed>,
    /// Of that frame.
    pub nearest: usize,
}

impl Moment {
    pub fn poses(&self) -> Vec<Pose> {
        self.agents.iter().map(|agent| agent.pose).collect()
    }
}

/// \[1\], \[N\] Recorded and computed squeezes agree to this, or the run had other parameters.
const AGREEMENT: (f64, f64) = (1e-3, 1.0);

/// \[s\] Times are sums of steps: rounding does not leave a frame out.
const ROUNDING: f64 = 1e-9;

/// Whether a time lies between two, where they are given; all \[s\].
pub fn within(time: f64, from: Option<f64>, until: Option<f64>) -> bool {
    from.is_none_or(|from| time >= from - ROUNDING) && until.is_none_or(|until| time <= until + ROUNDING)
}

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
            shadow.put(&frame.agents).map_err(|crowded| Setup::of(&trial).too_crowded(crowded))?;
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
        let moving = |frame: &Frame| {
            frame.agents.iter().any(|agent| moves(agent.twist.velocity.norm(), agent.twist.angular_velocity))
        };
        let still = frames.iter().rposition(moving).map_or(0, |last| last + 1);
        frames.get(still).map(|frame| frame.time)
    }

    /// At a time \[s\] of the run; its ends for times beyond them.
    pub fn at(&self, time: f64) -> Moment {
        let nearest = self.nearest(time);
        let time = time.clamp(self.first(), self.last());
        let observed = observed(&self.run.frames[nearest]).to_vec();
        Moment { time, agents: agents_at(&self.run, time), observed, nearest }
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
            observed: observed(frame).to_vec(),
            nearest: place,
        }
    }
}

impl Shadow {
    pub fn new(trial: &Trial) -> Result<Shadow, WorldError> {
        Ok(Shadow(Setup::of(trial).world()?))
    }

    fn put(&mut self, agents: &[Motion]) -> Result<(), Crowded> {
        let (poses, twists) = agents.iter().map(|agent| (agent.pose, agent.twist)).unzip();
        self.0.restore(State::new(poses, twists))
    }

    /// The normal forces at the nearest frame: for each two that touch, their contacts together, from body to
    /// body; for each wall, from the body to where it touches.
    ///
    /// Also whether they are those that the run recorded; a run with other parameters had others.
    pub fn forces(&mut self, footage: &Footage, moment: &Moment) -> (Vec<Force>, bool) {
        let frame = &footage.run.frames[moment.nearest];
        if self.put(&frame.agents).is_err() {
            // No run of this Trial has so many in one place.
            return (Vec::new(), false);
        }
        let (scene, report) = (self.0.scene(), self.0.contacts());
        let here = |body: usize| moment.agents[body].pose.position;
        let mut pairs: BTreeMap<(usize, usize), f64> = BTreeMap::new();
        // The strongest contact says where a body leans on a wall.
        let mut walls: BTreeMap<(usize, usize), (f64, f64, Vec2)> = BTreeMap::new();
        for contact in &report.contacts {
            let force = contact.normal_force.abs();
            match contact.pair {
                Pair::Disks { first, second } => {
                    let [first, second] = [first, second].map(|disk| scene.body_of(disk).index());
                    *pairs.entry((first, second)).or_default() += force;
                }
                Pair::Face { disk, face, .. } => {
                    let (body, disk) = (scene.body_of(disk).index(), &scene.disks[disk.index()]);
                    let centre = disk.offset.rotated(Rotation::by(moment.agents[body].pose.orientation));
                    let point = here(body) + centre - contact.normal * (disk.radius - 0.5 * contact.depth);
                    let wall = scene.faces[face.index()].wall.index();
                    let sum = walls.entry((body, wall)).or_insert((0.0, -1.0, point));
                    sum.0 += force;
                    if force > sum.1 {
                        (sum.1, sum.2) = (force, point);
                    }
                }
            }
        }
        let between = pairs.into_iter().map(|((first, second), normal_force)| Force {
            from: here(first),
            to: here(second),
            normal_force,
        });
        let leaning = walls.into_iter().map(|((body, _), (normal_force, _, to))| Force {
            from: here(body),
            to,
            normal_force,
        });
        let (relative, absolute) = AGREEMENT;
        let agree = report.bodies.iter().zip(observed(frame)).all(|(computed, recorded)| {
            (computed.squeeze - recorded.normal_force).abs()
                <= absolute + relative * recorded.normal_force.max(computed.squeeze)
        });
        (between.chain(leaning).collect(), agree)
    }
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
