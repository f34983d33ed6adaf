//! The states of an instance, also as bytes.

use super::{Experiment, Slave};
use crate::Version;
use crate::answer::{Answer, damaged, refuse};
use crate::lifecycle::{Function, Phase, allowed};
use crate::model::Model;
use crate::variables::{MOST, Size};
use serde::{Deserialize, Serialize};

const MAGIC: &[u8; 8] = b"LEMONSst";
/// Increased whenever [`Snapshot`] changes.
const FORMAT: u32 = 3;
/// Magic, version, token, length.
const HEADER: usize = 8 + 4 + 16 + 8;

/// Returns the versions of the format of states and of the model, in one number.
fn state_version<M: Model>() -> u32 {
    FORMAT << 16 | M::STATE_VERSION
}

/// The complete state of an instance without the location of its resources: FMI's "FMU state".
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Snapshot<S> {
    phase: Phase,
    time: f64,
    experiment: Option<Experiment>,
    /// FMI 3.0: the structural parameters.
    sizes: Vec<u64>,
    model: S,
}

impl<M: Model> Slave<M> {
    /// Saves the state.
    ///
    /// # Errors
    /// Wrong phase.
    pub fn snapshot(&self) -> Answer<Snapshot<M::Saved>> {
        self.check(Function::State)?;
        let (phase, time, experiment) = (self.phase, self.time, self.experiment);
        Ok(Snapshot { phase, time, experiment, sizes: self.sizes.clone(), model: self.model.save() })
    }

    /// Restores a state.
    ///
    /// # Errors
    /// Wrong phase, a snapshot of another model, or one with impossible times. Then nothing has
    /// changed.
    pub fn restore(&mut self, snapshot: &Snapshot<M::Saved>) -> Answer<()> {
        self.check(Function::State)?;
        let possible = snapshot.experiment.is_none_or(|Experiment { start, stop }| {
            start.is_finite() && stop.is_none_or(|stop| stop.is_finite() && stop >= start)
        });
        if !(possible && snapshot.time.is_finite()) {
            return damaged("a time that is not possible");
        }
        if !allowed(Function::State, self.version, snapshot.phase) {
            return damaged("a phase that is not possible");
        }
        let sizes = &snapshot.sizes;
        let possible = |(size, of): (&u64, &Size)| *size <= MOST && (*size > 0 || of.optional);
        if sizes.len() != self.sizes.len() || !sizes.iter().zip(M::SIZES).all(possible) {
            return damaged("sizes that are not possible");
        }
        self.model.restore(&snapshot.model)?;
        self.sizes.clone_from(sizes);
        (self.phase, self.time, self.experiment) = (snapshot.phase, snapshot.time, snapshot.experiment);
        Ok(())
    }

    /// Returns a snapshot as bytes: magic number, version, token, length, content, checksum.
    ///
    /// # Errors
    /// The snapshot cannot be serialised.
    pub fn serialize(&self, snapshot: &Snapshot<M::Saved>) -> Answer<Vec<u8>> {
        let content = postcard::to_stdvec(snapshot)?;
        let mut bytes = Vec::with_capacity(HEADER + content.len() + 4);
        bytes.extend_from_slice(MAGIC);
        bytes.extend_from_slice(&state_version::<M>().to_le_bytes());
        bytes.extend_from_slice(self.token.as_bytes());
        bytes.extend_from_slice(&(content.len() as u64).to_le_bytes());
        bytes.extend_from_slice(&content);
        let checksum = crc32fast::hash(&bytes);
        bytes.extend_from_slice(&checksum.to_le_bytes());
        Ok(bytes)
    }

    /// Reads a snapshot from bytes.
    ///
    /// # Errors
    /// The bytes are damaged, or belong to another version or another model.
    pub fn deserialize(&self, bytes: &[u8]) -> Answer<Snapshot<M::Saved>> {
        self.check(Function::State)?;
        const CUT_OFF: &str = "it is cut off";
        let Some((header, rest)) = bytes.split_first_chunk::<HEADER>() else { return damaged(CUT_OFF) };
        if header[..8] != *MAGIC {
            return damaged("it does not begin like a state");
        }
        if header[8..12] != state_version::<M>().to_le_bytes() {
            return damaged("another version of the format");
        }
        if header[12..28] != *self.token.as_bytes() {
            return refuse("the state belongs to another model: it was saved by an FMU with another GUID");
        }
        let length = header[28..].try_into().map(u64::from_le_bytes).unwrap_or(u64::MAX);
        let length = usize::try_from(length).unwrap_or(usize::MAX);
        let Some((content, rest)) = rest.split_at_checked(length) else { return damaged(CUT_OFF) };
        let Some((checksum, more)) = rest.split_first_chunk::<4>() else { return damaged(CUT_OFF) };
        if *checksum != crc32fast::hash(&bytes[..HEADER + length]).to_le_bytes() {
            return damaged("its checksum is wrong");
        }
        // Importers of FMI 2.0 pass buffers that are longer.
        if !more.is_empty() && self.version == Version::V3 {
            return damaged("bytes follow it");
        }
        match postcard::take_from_bytes(content) {
            Ok((snapshot, [])) => Ok(snapshot),
            _ => damaged("its content is malformed"),
        }
    }
}
