//! FMU states: what an instance is, taken and as bytes (FMI 2.0, section 2.1.8).

use crate::fmu::{Fmu, Instance, Messages, done};
use anyhow::{Context, Result, bail};
use fmi_rs::fmi2::types::fmi2FMUstate;
use fmi_rs::fmi2::{CS, FMU2};
use std::ptr::null_mut;
use std::sync::Arc;

/// \[byte\] The largest state, which is held in memory: some ten times that of 100 000 agents in contact.
pub const LARGEST_STATE: usize = 1_000_000_000;

/// A state of an instance, which holds the memory; given back when it is dropped.
///
/// All calls go through `fmi-rs`, whose functions hand the pointer on and never look behind it. It comes from
/// the FMU, is private, and belongs to one instance, which lives as long.
pub struct State {
    fmu: Arc<FMU2<CS>>,
    messages: Arc<Messages>,
    pointer: fmi2FMUstate,
}

impl Drop for State {
    fn drop(&mut self) {
        if !self.pointer.is_null() {
            // There is nobody to tell of a refusal, and nothing else to do about it.
            let _ = self.fmu.freeFMUstate(&raw mut self.pointer);
        }
    }
}

impl State {
    /// Takes the present state of its instance instead.
    ///
    /// # Errors
    /// The FMU's refusal.
    pub fn renew(&mut self) -> Result<()> {
        done(&self.messages, self.fmu.getFMUstate(&raw mut self.pointer), "fmi2GetFMUstate")
    }

    /// `fmi2SerializeFMUstate`
    ///
    /// # Errors
    /// The FMU's refusal, or a state too large for the memory.
    pub fn bytes(&self) -> Result<Vec<u8>> {
        let mut size = 0;
        let status = self.fmu.serializedFMUstateSize(self.pointer, &mut size);
        done(&self.messages, status, "fmi2SerializedFMUstateSize")?;
        if size > LARGEST_STATE {
            bail!("fmi2SerializedFMUstateSize answered {size} bytes: more than {LARGEST_STATE}");
        }
        let mut bytes = Vec::new();
        bytes.try_reserve_exact(size).with_context(|| format!("a state of {size} bytes"))?;
        bytes.resize(size, 0);
        let status = self.fmu.serializeFMUstate(self.pointer, &mut bytes);
        done(&self.messages, status, "fmi2SerializeFMUstate")?;
        Ok(bytes)
    }
}

impl Instance {
    fn empty_state(&self) -> State {
        State { fmu: self.fmu.clone(), messages: self.messages.clone(), pointer: null_mut() }
    }

    /// `fmi2GetFMUstate`
    ///
    /// # Errors
    /// The FMU's refusal.
    pub fn state(&self) -> Result<State> {
        let mut state = self.empty_state();
        state.renew()?;
        Ok(state)
    }

    /// `fmi2DeSerializeFMUstate` and `fmi2SetFMUstate`
    ///
    /// # Errors
    /// Bytes that are none of such an FMU, or its refusal.
    pub fn restore(&self, bytes: &[u8]) -> Result<()> {
        let mut state = self.empty_state();
        let status = self.fmu.deSerializeFMUstate(bytes, &raw mut state.pointer);
        done(&self.messages, status, "fmi2DeSerializeFMUstate")?;
        done(&self.messages, self.fmu.setFMUstate(state.pointer), "fmi2SetFMUstate")
    }
}

impl Fmu {
    /// Which of the flags `canGetAndSetFMUstate`, `canSerializeFMUstate` the FMU lacks to save its state.
    pub fn cannot_save(&self) -> Option<&'static str> {
        match &self.description.coSimulation {
            Some(able) if !able.canGetAndSetFMUstate => Some("canGetAndSetFMUstate"),
            Some(able) if !able.canSerializeFMUstate => Some("canSerializeFMUstate"),
            Some(_) => None,
            None => Some("co-simulation"),
        }
    }
}
