//! The crowd as arrays (FMI 3.0).

use super::{CrowdModel, ModelError, count};
use crate::arrays::{Block, SIZES, arrays, element, sizes};
use crate::engine::step_count;
use crate::variables::Quantity;
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
        if let Block::Agents(quantities) = block
            && self.world.is_some()
        {
            return self.read_agents(quantities, values);
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
        for (k, &value) in values.iter().enumerate() {
            if let Some(quantity) = element(&self.trial, block, k) {
                self.set_real(quantity, value, phase);
            }
        }
    }

    fn write_integers(&mut self, block: Block, values: &[i32]) {
        if let (Block::One(quantity), &[value]) = (block, values) {
            self.set_integer(quantity, value);
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
        part: f64,
        so_far: f64,
        at_end: Option<f64>,
    ) -> Result<(), StepError<ModelError>> {
        self.advance_by(part, so_far, at_end)
    }
}
