//! The crowd as arrays (FMI 3.0).

use super::{CrowdModel, ModelError, count};
use crate::arrays::{Block, SIZES, arrays, element, sizes};
use crate::engine::{World, step_count};
use crate::variables::{AgentQuantity, Quantity};
use lemons_fmi::v3::{Array, ArrayModel, Size};
use lemons_fmi::{Model, Phase, StepError};

impl ArrayModel for CrowdModel {
    type Block = Block;

    const SIZES: &'static [Size] = &SIZES;

    fn arrays() -> Vec<Array<Block>> {
        arrays()
    }

    fn sizes(&self) -> Vec<u64> {
        sizes(&self.trial)
    }

    fn read_reals(&mut self, block: Block, values: &mut [f64]) -> Result<(), ModelError> {
        if let (Block::Agents(quantities), Some(world)) = (block, &self.world)
            && read_agents(world, quantities, values)
        {
            return Ok(());
        }
        for (k, value) in values.iter_mut().enumerate() {
            // A pair of materials that never touch has no law.
            *value = match element(&self.trial, block, k) {
                Some(quantity) => self.real(quantity)?,
                None => 0.0,
            };
        }
        Ok(())
    }

    fn read_integers(&mut self, block: Block, values: &mut [i32]) -> Result<(), ModelError> {
        let Block::Agents(&[of]) = block else {
            if let (Block::One(quantity), [value]) = (block, values) {
                *value = self.integer(quantity)?;
            }
            return Ok(());
        };
        let world = self.make_world()?;
        for (i, value) in (0..).zip(values) {
            *value = count(world, Quantity::Agent(i, of)).unwrap_or(0);
        }
        Ok(())
    }

    fn texts(&self, block: Block) -> Vec<&str> {
        match block {
            Block::AgentIds => self.trial.agents.iter().map(|agent| &agent.id[..]).collect(),
            Block::MaterialIds => {
                self.trial.materials.intrinsic.iter().map(|material| &material.id[..]).collect()
            }
            Block::One(quantity) => vec![self.string(quantity)],
            _ => Vec::new(),
        }
    }

    fn check_reals(&self, block: Block, values: &[f64]) -> Result<(), ModelError> {
        let Block::Contacts(_) = block else { return Ok(()) };
        let materials = &self.trial.materials.intrinsic;
        let n = materials.len();
        for (k, &value) in values.iter().enumerate() {
            let (one, other) = (k / n, k % n);
            let (id1, id2) = (&materials[one].id, &materials[other].id);
            if value != values[other * n + one] {
                return Err(ModelError::Asymmetric(id1.clone(), id2.clone()));
            }
            if value != 0.0 && element(&self.trial, block, k).is_none() {
                return Err(ModelError::NoContact(id1.clone(), id2.clone()));
            }
        }
        Ok(())
    }

    fn write_reals(&mut self, block: Block, values: &[f64], phase: Phase) {
        if let (Block::Agents([of, ..]), false) = (block, self.played.is_empty()) {
            (0..self.trial.agents.len()).for_each(|i| self.take_over(Quantity::Agent(i as u32, *of)));
        }
        if let (Block::Agents(quantities), Some(world), Phase::StepComplete) = (block, &mut self.world, phase)
            && write_drive(world, quantities, values)
        {
            return;
        }
        for (k, &value) in values.iter().enumerate() {
            if let Some(quantity) = element(&self.trial, block, k) {
                self.set_real(quantity, value, phase);
            }
        }
    }

    fn write_integers(&mut self, block: Block, values: &[i32], phase: Phase) {
        for (k, &value) in values.iter().enumerate() {
            if let Some(quantity) = element(&self.trial, block, k) {
                self.set_integer(quantity, value, phase);
            }
        }
    }

    fn write_texts(&mut self, values: &[(Block, &str)]) -> Result<(), ModelError> {
        let quantity = |block| if let Block::One(quantity) = block { Some(quantity) } else { None };
        let texts: Vec<(Quantity, &str)> =
            values.iter().filter_map(|&(block, value)| Some((quantity(block)?, value))).collect();
        self.set_strings(&texts)
    }

    fn read_derivatives(&self, block: Block, values: &mut [f64]) -> bool {
        for (k, value) in values.iter_mut().enumerate() {
            let Some(found) = element(&self.trial, block, k).and_then(|quantity| self.derivative(quantity))
            else {
                return false;
            };
            *value = found;
        }
        true
    }

    fn parts(&self, step: f64) -> Vec<f64> {
        let every = u64::try_from(self.intermediate_steps).unwrap_or(0);
        let mechanical_step = self.world.as_ref().map(|world| world.mechanical_step);
        let steps = mechanical_step.and_then(|longest| step_count(step, longest).ok()).unwrap_or(1);
        // What is refused is refused as a whole.
        if every == 0 || steps <= every || steps as f64 > self.most_steps {
            return vec![step];
        }
        let dt = step / steps as f64;
        let part = |first: u64| dt * (steps - first).min(every) as f64;
        (0..steps).step_by(every as usize).map(part).collect()
    }

    fn advance_part(
        &mut self,
        from: f64,
        part: f64,
        so_far: f64,
        at_end: Option<f64>,
    ) -> Result<(), StepError<ModelError>> {
        self.advance_by(from, part, so_far, at_end)
    }
}

/// Reads a quantity of all agents from a running world. Returns whether the world has it.
///
/// The same values as [`Model::real`] gives one by one, without deciding for each of thousands what it is.
fn read_agents(world: &World, quantities: &[AgentQuantity], values: &mut [f64]) -> bool {
    use AgentQuantity::*;
    fn one<T>(values: &mut [f64], of: &[T], read: impl Fn(&T) -> f64) {
        values.iter_mut().zip(of).for_each(|(value, of)| *value = read(of));
    }
    fn two<T>(values: &mut [f64], of: &[T], read: impl Fn(&T) -> lemons_core::plane::Vec2) {
        for (value, of) in values.as_chunks_mut().0.iter_mut().zip(of) {
            let vector = read(of);
            *value = [vector.x, vector.y];
        }
    }
    let (state, contacts, exposures) = (world.state(), &world.contacts().bodies, world.exposures());
    match quantities {
        [FpX, FpY] => two(values, &world.drive, |drive| drive.force),
        [Mp] => one(values, &world.drive, |drive| drive.torque),
        [PositionX, PositionY] => two(values, &state.poses, |pose| pose.position),
        [Theta] => one(values, &state.poses, |pose| pose.orientation),
        [VelocityX, VelocityY] => two(values, &state.twists, |twist| twist.velocity),
        [Omega] => one(values, &state.twists, |twist| twist.angular_velocity),
        [NormalForce] => one(values, contacts, |body| body.squeeze),
        [MeanNormalForce] => one(values, exposures, |exposure| exposure.mean_force),
        [PeakNormalForce] => one(values, exposures, |exposure| exposure.peak_force),
        [PeakOverlap] => one(values, exposures, |exposure| exposure.peak_overlap),
        _ => return false,
    }
    true
}

/// Sets forces or torques of all agents in a running world. Returns whether they are that.
fn write_drive(world: &mut World, quantities: &[AgentQuantity], values: &[f64]) -> bool {
    use AgentQuantity::{FpX, FpY, Mp};
    match quantities {
        [FpX, FpY] => {
            let forces = values.as_chunks::<2>().0;
            for (drive, &[x, y]) in world.drive.iter_mut().zip(forces) {
                drive.force = lemons_core::plane::vec2(x, y);
            }
        }
        [Mp] => {
            world.drive.iter_mut().zip(values).for_each(|(drive, &torque)| drive.torque = torque);
        }
        _ => return false,
    }
    true
}
