//! The contacts of a Trial's agents where frames of a run have them.

use crowd_mechanics::engine::{BodyId, PairForce, State, World};
use crowd_mechanics::quantities::CrowdQuantity;
use crowd_mechanics::setup::{Setup, WorldError};
use lemons_core::plane::{InPlane, Pose};
use lemons_core::trial::Trial;
use lemons_results::columns::{self, Effect, Group, RecordedQuantity};
use lemons_results::{Effects, Frame};
use std::sync::LazyLock;

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
        let present = Setup::of(self.trial).walls_at(began, |_| false, &self.world);
        if present == self.world.present_walls() {
            return Ok(());
        }
        self.world.set_present_walls(&present).map_err(crowded)
    }

    /// Gives a frame what the contacts do to each agent at its time.
    pub fn record(&self, frame: &mut Frame) {
        record(&self.world, &mut frame.effects, |of| of.group == Group::Contacts);
    }

    /// Returns the normal forces: for each two that touch, their contacts together, from body to body; for each wall, from
    /// the body to where it touches. `poses` are where the bodies are drawn.
    pub fn forces(&self, poses: &[Pose]) -> Vec<PairForce> {
        self.world.pair_forces(poses)
    }
}

/// The effects in frames, with the outputs of the crowd that they are.
static OUTPUTS: LazyLock<Vec<(&RecordedQuantity, Effect, CrowdQuantity)>> = LazyLock::new(|| {
    let output = |of: &'static RecordedQuantity| {
        let row = crowd_mechanics::quantities::QUANTITIES.iter().find(|row| row.name == of.variable);
        Some((of, of.effect?.0, row.expect("an effect is an output of the crowd").quantity))
    };
    columns::QUANTITIES.iter().filter_map(output).collect()
});

/// Records the wanted effects of the contacts in a world.
pub(crate) fn record(world: &World, effects: &mut Effects, wanted: impl Fn(&RecordedQuantity) -> bool) {
    let mut numbers = vec![0.0; world.present().len()];
    for (_, effect, quantity) in OUTPUTS.iter().filter(|(of, ..)| wanted(of)) {
        quantity.read(world, 0, &mut numbers);
        effects.record(*effect, numbers.iter().copied());
    }
}
