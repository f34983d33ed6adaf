//! What an FMU simulates.

use crate::lifecycle::Phase;
use crate::variables::Variable;
use serde::{Serialize, de::DeserializeOwned};
use std::error::Error;
use std::fmt::Debug;
use uuid::Uuid;

/// A number that tells contents apart: by it a saved state knows what it was saved of.
pub fn fingerprint(content: &[u8]) -> u128 {
    Uuid::new_v5(&Uuid::NAMESPACE_OID, content).as_u128()
}

/// Why a model did not advance.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StepError<E> {
    /// Nothing has changed; another step may be tried.
    Refused(E),
    /// The model may be in any condition; a saved state or a reset leads back.
    Failed(E),
}

/// The model behind an FMU, as [`Slave`](crate::Slave) drives it: the slave sees to lifecycle, value
/// references, types, domains and times; a model is asked only for what is allowed and well-formed.
pub trait Model: Sized + Send {
    /// Which number of the model a variable is.
    type Quantity: Copy + Debug + Send + Sync;
    /// All that the model's future depends on: its part of FMI's "FMU state".
    type Saved: Clone + Debug + PartialEq + Serialize + DeserializeOwned;
    /// Its refusals; nothing has changed then, if not said otherwise.
    type Error: Error + Send + Sync + 'static;

    /// `canInterpolateInputs`
    const INTERPOLATES_INPUTS: bool;
    /// Raised whenever [`Model::Saved`] changes.
    const STATE_VERSION: u32;

    /// From the resource location that an importer gives, as it is.
    ///
    /// # Errors
    /// Resources that are missing or broken.
    fn load(location: &str) -> Result<Self, Self::Error>;

    /// Its variables; the same as long as it lives.
    fn table(&self) -> Vec<Variable<Self::Quantity>>;

    /// Warnings since they were last taken.
    fn take_warnings(&mut self) -> Vec<String>;

    /// The value of a Real.
    ///
    /// # Errors
    /// Values that together make no model to compute it from.
    fn real(&mut self, quantity: Self::Quantity) -> Result<f64, Self::Error>;

    /// The value of an Integer.
    ///
    /// # Errors
    /// As [`Model::real`].
    fn integer(&mut self, quantity: Self::Quantity) -> Result<i32, Self::Error>;

    /// The value of a String.
    fn string(&self, quantity: Self::Quantity) -> &str;

    /// Sets a Real that can be set in the present phase to a value of its domain.
    fn set_real(&mut self, reference: u32, quantity: Self::Quantity, value: f64, phase: Phase);

    /// Sets an Integer, as [`Model::set_real`].
    fn set_integer(&mut self, quantity: Self::Quantity, value: i32);

    /// Sets Strings, all or none.
    ///
    /// # Errors
    /// A text that is no value of its variable.
    fn set_strings(&mut self, values: &[(Self::Quantity, &str)]) -> Result<(), Self::Error>;

    /// Lets an input vary linearly over the next step, at a rate per second. Called only if
    /// [`Model::INTERPOLATES_INPUTS`].
    fn set_rate(&mut self, _input: Self::Quantity, _rate: f64) {}

    /// What was set becomes what is simulated.
    ///
    /// # Errors
    /// Values that together make no model.
    fn initialize(&mut self) -> Result<(), Self::Error>;

    /// Advances over a step \[s\], positive and finite, to a communication point \[s\].
    ///
    /// # Errors
    /// [`StepError`] says whether anything has changed.
    fn advance(&mut self, step: f64, to: f64) -> Result<(), StepError<Self::Error>>;

    /// Back to where [`Model::load`] left it.
    ///
    /// # Errors
    /// Resources that have become unreadable.
    fn reset(&mut self) -> Result<(), Self::Error>;

    /// See [`Model::Saved`].
    fn save(&self) -> Self::Saved;

    /// Goes back to what was saved, here or in another instance of the same interface.
    ///
    /// # Errors
    /// Something that no instance of this model can have saved.
    fn restore(&mut self, saved: &Self::Saved) -> Result<(), Self::Error>;
}
