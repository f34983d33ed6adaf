//! A Trial, moving.

use crate::upload::Driven;
use crate::{Refused, Reply};
use crowd_mechanics::engine::{World, Wrench, vec2};
use crowd_mechanics::setup::Setup;
use serde_json::json;

/// Most communication steps of a request: a page wants to be heard between them.
pub const MOST_STEPS: u32 = 1000;

/// \[byte\] Largest answer to a request for steps.
pub const MOST_BYTES: usize = 100_000_000;

/// Most mechanical steps of a person in a communication step, for all people together: about a quarter of a minute.
pub const MOST_WORK: f64 = 5e8;

/// Numbers of an agent in a frame: x \[m\], y \[m\], orientation \[rad\], speed \[m/s\], mean squeeze of the last
/// communication step \[N\], number of contacts.
pub const COLUMNS: usize = 6;

/// A Trial and its world.
#[derive(Debug)]
pub struct Run {
    driven: Driven,
    world: World,
    /// Communication steps so far.
    steps: u64,
    /// \[m\] Deepest overlap so far.
    overlap: f64,
}

impl Run {
    /// At the Trial's beginning.
    ///
    /// # Errors
    /// Materials that can touch have no usable contact, or too many people are at one place.
    pub fn begin(driven: Driven) -> Result<Run, Refused> {
        let world = Setup::of(&driven.trial).world().map_err(Refused::of)?;
        Ok(Run { driven, world, steps: 0, overlap: 0.0 })
    }

    /// What runs.
    pub fn driven(&self) -> &Driven {
        &self.driven
    }

    /// The drive at a communication point \[s\]. Agents that the file does not name keep that of the Trial.
    fn push(&mut self, time: f64) {
        for (agent, drive) in self.driven.trial.agents.iter().zip(&mut self.world.drive) {
            if let Some([x, y, torque]) = self.driven.drive.at(&agent.id, time) {
                *drive = Wrench { force: vec2(x, y), torque };
            }
        }
    }

    /// Advances by communication steps. Returns time, deepest overlap since the beginning, work, and all frames, one after the other.
    ///
    /// # Errors
    /// Too many steps, or the engine refuses one; the run is then where it was before that one.
    pub fn advance(&mut self, steps: u32) -> Result<Reply, Refused> {
        if steps > MOST_STEPS {
            return Err(Refused(format!("{steps} steps at once: at most {MOST_STEPS}")));
        }
        let people = self.driven.trial.agents.len();
        if 8 * COLUMNS * people * steps as usize > MOST_BYTES {
            return Err(Refused(format!("{steps} steps of {people} people at once have more than 100 MB")));
        }
        let parameters = &self.driven.trial.parameters;
        let mechanical = parameters.time_step / parameters.time_step_mechanical;
        if mechanical * people as f64 > MOST_WORK {
            return Err(Refused(format!(
                "a TimeStep of {} s has {mechanical:.3e} mechanical steps: too many for a page with {people} people",
                parameters.time_step
            )));
        }
        let mut bytes = Vec::new();
        for _ in 0..steps {
            // Communication points are multiples, as those of `lemons run`; steps are their differences.
            let time = self.time_at(self.steps);
            let duration = self.time_at(self.steps + 1) - time;
            self.push(time);
            self.world
                .advance(duration)
                .map_err(|error| Refused(Setup::of(&self.driven.trial).name_body(&error)))?;
            self.steps += 1;
            self.overlap = self.overlap.max(self.world.largest_overlap());
            bytes.extend(self.frame());
        }
        let work = self.world.work();
        let value = json!({
            "time": self.time_at(self.steps), "overlap": self.overlap,
            "mechanical_steps": work.steps, "pairs": work.pairs, "contacts": work.contacts,
        });
        Ok(Reply { value, bytes })
    }

    /// \[s\]
    fn time_at(&self, steps: u64) -> f64 {
        steps as f64 * self.driven.trial.parameters.time_step
    }

    /// [`COLUMNS`] doubles for each agent, little-endian.
    pub fn frame(&self) -> Vec<u8> {
        let (state, contacts) = (self.world.state(), &self.world.contacts().bodies);
        let exposures = self.world.exposures();
        let mut bytes = Vec::with_capacity(8 * COLUMNS * state.poses.len());
        for (k, (pose, twist)) in state.poses.iter().zip(&state.twists).enumerate() {
            let touched = contacts[k].agent_contacts + contacts[k].wall_contacts;
            let numbers = [
                pose.position.x,
                pose.position.y,
                pose.orientation,
                twist.velocity.norm(),
                exposures[k].mean_force,
                f64::from(touched),
            ];
            bytes.extend(numbers.into_iter().flat_map(f64::to_le_bytes));
        }
        bytes
    }
}
