//! What an FMU simulates.

use crate::Phase;
use crate::location::Location;
use crate::variables::Variable;
use serde::{Serialize, de::DeserializeOwned};
use std::error::Error;
use std::fmt::Debug;
use uuid::Uuid;

/// Returns a hash of a content. A saved state contains it, to check that it is restored into the same model.
pub fn fingerprint(content: &[u8]) -> u128 {
    Uuid::new_v5(&Uuid::NAMESPACE_OID, content).as_u128()
}

/// Returns what identifies an interface, of a line for each variable.
pub(crate) fn token(lines: impl Iterator<Item = String>) -> Uuid {
    /// Makes interfaces of other programs with the same words another token.
    const NAMESPACE: Uuid = Uuid::from_u128(0x6c65_6d6f_6e73_4d75_8f63_726f_7764_3031);
    Uuid::new_v5(&NAMESPACE, lines.collect::<String>().as_bytes())
}

/// Why a model did not advance.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StepError<E> {
    /// The model is unchanged; another step may be tried.
    Refused(E),
    /// The model may be in any condition; only a saved state or a reset helps.
    Failed(E),
}

/// The model behind an FMU, called by [`Slave`](crate::slave::Slave). The slave checks lifecycle, value references, types,
/// domains and times. The model gets only calls that are allowed and well-formed.
pub trait Model: Sized + Send {
    /// Identifies the quantity behind a variable.
    type Quantity: Copy + Debug + Send + Sync;
    /// Everything on which the model's future depends: its part of the FMU state.
    type Saved: Clone + Debug + PartialEq + Send + Serialize + DeserializeOwned + Sync + 'static;
    /// Why a call is refused. The model is then unchanged, if not stated otherwise.
    type Error: Error + Send + Sync + 'static;

    /// `canInterpolateInputs`
    const INTERPOLATES_INPUTS: bool;
    /// Version of the format; increased whenever [`Model::Saved`] changes.
    const STATE_VERSION: u32;

    /// Loads the model from the resource location, exactly as the importer gives it.
    ///
    /// # Errors
    /// The resources are missing or damaged.
    fn load(location: Location<'_>) -> Result<Self, Self::Error>;

    /// Returns the variables of FMI 2.0. They never change during the life of the model.
    fn table(&self) -> Vec<Variable<Self::Quantity>>;

    /// Returns the warnings since the last call.
    fn take_warnings(&mut self) -> Vec<String>;

    /// Returns the value of a Real.
    ///
    /// # Errors
    /// The values that were set do not fit together, so that the Real cannot be computed.
    fn real(&mut self, quantity: Self::Quantity) -> Result<f64, Self::Error>;

    /// Returns the value of an Integer, or of a Boolean: 0 or 1.
    ///
    /// # Errors
    /// Those of [`Model::real`].
    fn integer(&mut self, quantity: Self::Quantity) -> Result<i32, Self::Error>;

    /// Returns the value of a String.
    fn string(&self, quantity: Self::Quantity) -> &str;

    /// Sets a Real that can be set in the present phase to a value of its domain.
    fn set_real(&mut self, quantity: Self::Quantity, value: f64, phase: Phase);

    /// Sets an Integer, or a Boolean to 0 or 1, as [`Model::set_real`].
    fn set_integer(&mut self, quantity: Self::Quantity, value: i32, phase: Phase);

    /// Sets Strings, all or none.
    ///
    /// # Errors
    /// A text is not a value of its variable.
    fn set_strings(&mut self, values: &[(Self::Quantity, &str)]) -> Result<(), Self::Error>;

    /// Returns the derivative of a Real with respect to time \[1/s\]; `None` if it is not known.
    fn derivative(&self, _quantity: Self::Quantity) -> Option<f64> {
        None
    }

    /// Lets an input vary linearly over the next step, at a rate per second. Called only if
    /// [`Model::INTERPOLATES_INPUTS`].
    fn set_rate(&mut self, _input: Self::Quantity, _rate: f64) {}

    /// Takes the tolerance of the experiment, a positive and finite number, or none if the importer defines none. Called
    /// before initialization begins. A model that has no use for it ignores it.
    fn set_tolerance(&mut self, _tolerance: Option<f64>) {}

    /// Ends initialization: the model is built from the values that were set. The simulation begins at `start` \[s\].
    ///
    /// # Errors
    /// The values that were set do not fit together.
    fn initialize(&mut self, start: f64) -> Result<(), Self::Error>;

    /// Advances from a communication point by a step, which is positive, to `from + step`, which is finite, all \[s\].
    ///
    /// # Errors
    /// [`StepError`] says whether anything has changed.
    fn advance(&mut self, from: f64, step: f64) -> Result<(), StepError<Self::Error>>;

    /// Returns to the state after [`Model::load`].
    ///
    /// # Errors
    /// The resources can no longer be read.
    fn reset(&mut self) -> Result<(), Self::Error>;

    /// Returns the state; see [`Model::Saved`].
    fn save(&self) -> Self::Saved;

    /// Restores a state that was saved by this instance, or by another one with the same interface.
    ///
    /// # Errors
    /// The state cannot have been saved by an instance of this model.
    fn restore(&mut self, saved: &Self::Saved) -> Result<(), Self::Error>;
}
