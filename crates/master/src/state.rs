//! FMU states: what an instance is, taken and as bytes (FMI 2.0, section 2.1.8).

use crate::calls::Held;
use crate::error::{Error, Result};
use crate::fmu::Fmu;
use crate::instance::Instance;
use crate::messages::{Messages, done};
use crate::ssp::Fmi;
use std::sync::Arc;

/// \[byte\] The largest state, and the largest sum of those of all components, which are held in memory: some ten times that of 100 000 agents in contact.
pub const LARGEST_STATE: usize = 1_000_000_000;

/// A state of an instance, which holds the memory; given back when it is dropped.
pub struct State {
    held: Held,
    messages: Arc<Messages>,
}

impl State {
    /// `fmi2SerializeFMUstate`
    ///
    /// # Errors
    /// The FMU's refusal, or a state too large for the memory.
    pub fn bytes(&self) -> Result<Vec<u8>> {
        let (answer, size) = self.held.size()?;
        let call = answer.call();
        done(&self.messages, answer)?;
        if size > LARGEST_STATE {
            let why = format!("{call} returned {size} bytes, more than {LARGEST_STATE}");
            return Err(Error::Unusable(why));
        }
        let mut bytes = Vec::new();
        bytes.try_reserve_exact(size).map_err(|source| Error::Memory { size, source })?;
        bytes.resize(size, 0);
        done(&self.messages, self.held.serialize(&mut bytes)?)?;
        Ok(bytes)
    }
}

impl Instance {
    fn empty_state(&self) -> State {
        State { held: Held::none(&self.calls), messages: self.messages.clone() }
    }

    /// `fmi2GetFMUstate`
    ///
    /// # Errors
    /// The FMU refuses the call.
    pub fn state(&self) -> Result<State> {
        let mut state = self.empty_state();
        done(&self.messages, state.held.take()?)?;
        Ok(state)
    }

    /// `fmi2DeSerializeFMUstate` and `fmi2SetFMUstate`
    ///
    /// # Errors
    /// Bytes that are none of such an FMU, or its refusal.
    pub fn restore(&self, bytes: &[u8]) -> Result<()> {
        let mut state = self.empty_state();
        done(&self.messages, state.held.deserialize(bytes)?)?;
        done(&self.messages, state.held.put()?)
    }
}

impl Fmu {
    /// Which of the flags `canGetAndSetFMUstate`, `canSerializeFMUstate` (FMI 3.0: `…State`) the FMU lacks to save its state.
    pub fn cannot_save(&self) -> Option<&'static str> {
        let [get_and_set, serialize] = match self.description.fmi {
            Fmi::V2 => ["canGetAndSetFMUstate", "canSerializeFMUstate"],
            Fmi::V3 => ["canGetAndSetFMUState", "canSerializeFMUState"],
        };
        match &self.description.co_simulation {
            Some(able) if !able.can_get_and_set_state => Some(get_and_set),
            Some(able) if !able.can_serialize_state => Some(serialize),
            Some(_) => None,
            None => Some("co-simulation"),
        }
    }
}
