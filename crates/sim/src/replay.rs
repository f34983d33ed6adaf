//! The contacts of a Trial's agents where frames of a run have them.

use crowd_mechanics::engine::{BodyId, ContactReport, PairForce, State, World};
use crowd_mechanics::setup::{Setup, WorldError};
use lemons_core::plane::{InPlane, Pose};
use lemons_core::trial::Trial;
use lemons_results::{Frame, Observed};

/// A Trial's bodies, put where frames of a run have them. Tangential springs are not known; they do not change normal
/// forces.
pub struct Replay<'t> {
    trial: &'t Trial,
    world: World,
}

impl<'t> Replay<'t> {
    /// Builds the bodies.
    ///
    /// # Errors
    /// Those of [`Setup::world`].
    pub fn new(trial: &'t Trial) -> Result<Replay<'t>, WorldError> {
        Ok(Replay { trial, world: Setup::of(trial).world()? })
    }

    /// Puts everybody where a frame of the same agents has them, among the walls that were there in the step that ended then,
    /// of the Trial's TimeStep. Who has left may be at no finite place. Whether a wall that closes waits for somebody is
    /// not known: it does if somebody is deep in it.
    ///
    /// # Errors
    /// Too many are at one place.
    pub fn put(&mut self, frame: &Frame) -> Result<(), WorldError> {
        for place in 0..frame.agents.len() {
            self.world.set_present(BodyId::from(place), frame.is_there(place));
        }
        let finite = |pose: Pose| if pose.position.is_finite() { pose } else { Pose::default() };
        let (poses, twists) = frame.agents.iter().map(|agent| (finite(agent.pose), agent.twist)).unzip();
        let crowded = |crowded| Setup::of(self.trial).too_crowded(crowded);
        self.world.restore(State::new(poses, twists)).map_err(crowded)?;
        let began = (frame.time - self.trial.parameters.time_step).max(0.0);
        let present = Setup::of(self.trial).walls_at(began, &self.world);
        if present == self.world.present_walls() {
            return Ok(());
        }
        self.world.set_present_walls(&present).map_err(crowded)
    }

    /// Returns what the contacts do to each agent.
    pub fn observed(&self) -> Vec<Observed> {
        observed(self.world.contacts())
    }

    /// Returns the normal forces: for each two that touch, their contacts together, from body to body; for each wall, from
    /// the body to where it touches. `poses` are where the bodies are drawn.
    pub fn forces(&self, poses: &[Pose]) -> Vec<PairForce> {
        self.world.pair_forces(poses)
    }
}

/// Returns what contacts do to each agent at their time.
pub(crate) fn observed(contacts: &ContactReport) -> Vec<Observed> {
    let of = contacts.bodies.iter().map(|body| Observed {
        agent_contacts: body.agent_contacts,
        wall_contacts: body.wall_contacts,
        contacting_agents: body.touching_bodies,
        normal_force: body.squeeze,
        of_step: None,
    });
    of.collect()
}
