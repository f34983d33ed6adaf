//! The model behind an FMU, and what identifies its interface.

use crate::answer::{Answer, Refusal};
use crate::lifecycle::Phase;
use crate::location::Location;
use crate::variables::{Dependencies, Known, Scalar, Size, Variable};
use serde::{Serialize, de::DeserializeOwned};
use std::borrow::Cow;
use std::fmt::Debug;
use uuid::Uuid;

/// Returns a hash of a content. A saved state contains it, to check that it is restored into the
/// same model.
pub fn fingerprint(content: &[u8]) -> u128 {
    Uuid::new_v5(&Uuid::NAMESPACE_OID, content).as_u128()
}

fn token(lines: impl Iterator<Item = String>) -> Uuid {
    /// Makes interfaces of other programs with the same words another token.
    const NAMESPACE: Uuid = Uuid::from_u128(0x6c65_6d6f_6e73_4d75_8f63_726f_7764_3031);
    Uuid::new_v5(&NAMESPACE, lines.collect::<String>().as_bytes())
}

/// Returns the GUID of an FMI 2.0 interface. It depends on names, types, value references and
/// causalities only.
pub fn guid<Q>(scalars: &[Scalar<Q>]) -> Uuid {
    token(scalars.iter().enumerate().map(|(reference, Scalar { name, variable, .. })| {
        format!("{reference} {name} {} {:?}\n", variable.kind.name(), variable.role.in_tokens())
    }))
}

/// Returns the instantiation token of FMI 3.0. It depends on names, types, dimensions, value
/// references and causalities only.
pub fn instantiation_token<M: Model>() -> Uuid {
    let sizes = M::SIZES.iter().map(|size| format!("{}\n", size.name));
    let variables = M::VARIABLES.iter().map(|Variable { name, kind, dimensions, role, .. }| {
        format!("{name} {} {dimensions:?} {:?}\n", kind.name(), role.in_tokens())
    });
    token(["FMI 3.0\n".to_owned()].into_iter().chain(sizes).chain(variables))
}

/// Returns the value reference of a quantity in FMI 3.0, after those of `time` (0) and of the
/// structural parameters.
pub fn reference<M: Model>(quantity: M::Quantity) -> Option<u32> {
    let place = M::VARIABLES.iter().position(|variable| variable.quantity == quantity)?;
    Some((1 + M::SIZES.len() + place) as u32)
}

/// Why a model did not advance.
#[derive(Debug)]
pub enum StepError {
    /// The model is unchanged; another step may be tried.
    Refused(Refusal),
    /// The model may be in any condition; only a saved state or a reset helps.
    Failed(Refusal),
}

/// A communication step, all \[s\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Where it begins.
    pub from: f64,
    /// How long it is; positive.
    pub length: f64,
    /// Where it ends: the sum, but for rounding.
    pub to: f64,
}

impl Step {
    /// Returns a communication step as importers say it.
    pub fn of(from: f64, length: f64) -> Step {
        Step { from, length, to: from + length }
    }
}

/// The model behind an FMU, called by [`Slave`](crate::Slave). The slave checks lifecycle, value
/// references, types, lengths, domains and times. The model gets only calls that are allowed and
/// well-formed. After an error it is unchanged, if not stated otherwise.
///
/// Values are elements of the variables of [`Model::VARIABLES`], numbers of any type are `f64`.
pub trait Model: Sized + Send {
    /// Identifies a variable.
    type Quantity: Copy + Debug + PartialEq + Send + Sync + 'static;
    /// Everything on which the model's future depends: its part of the FMU state.
    type Saved: Clone + Debug + PartialEq + Send + Serialize + DeserializeOwned + Sync + 'static;

    /// `modelName`
    const NAME: &'static str;
    /// `modelIdentifier`: the stem of the binaries' names.
    const IDENTIFIER: &'static str;
    /// Description for users.
    const DESCRIPTION: &'static str;
    /// \[s\] `DefaultExperiment.stopTime`; the start time is 0.
    const STOP_TIME: f64;
    /// Whether inputs can vary linearly within a step (FMI 2.0).
    const INTERPOLATES_INPUTS: bool = false;
    /// Whether derivatives of outputs are known.
    const KNOWS_DERIVATIVES: bool = false;
    /// Whether values can be shown within a step (FMI 3.0).
    const SHOWS_INTERMEDIATE_VALUES: bool = false;
    /// Version of the format; increased whenever [`Model::Saved`] changes.
    const STATE_VERSION: u32;
    /// The structural parameters.
    const SIZES: &'static [Size];
    /// The variables, which are the same for every content.
    const VARIABLES: &'static [Variable<Self::Quantity>];

    /// Loads the model from the resource location, exactly as the importer gives it.
    ///
    /// # Errors
    /// The resources are missing or damaged.
    fn load(location: Location<'_>) -> Answer<Self>;

    /// Returns the value of the structural parameter at a place of [`Model::SIZES`] for what is
    /// loaded. Where it is 0, there are no arrays of this size, and the description has none.
    fn size(&self, place: usize) -> u64;

    /// Returns whether what is loaded has a variable without sizes. The description has no other ones, and as of arrays of
    /// size 0, there are no elements to get or set.
    fn has(&self, _quantity: Self::Quantity) -> bool {
        true
    }

    /// Returns what users read of a variable of what is loaded (FMI 3.0).
    fn about(&self, variable: &Variable<Self::Quantity>) -> Cow<'static, str> {
        Cow::Borrowed(variable.description)
    }

    /// Returns the variables of FMI 2.0 for what is loaded. An instance has those of what is loaded first.
    fn scalars(&self) -> Vec<Scalar<Self::Quantity>>;

    /// Returns the usual communication step \[s\].
    fn step_size(&self) -> f64;

    /// Returns the warnings since the last call.
    fn take_warnings(&mut self) -> Vec<String> {
        Vec::new()
    }

    /// Returns a number.
    ///
    /// # Errors
    /// The values that were set do not fit together, so that the number cannot be computed.
    fn number(&mut self, quantity: Self::Quantity, element: usize) -> Answer<f64>;

    /// Returns all elements of an array of numbers.
    ///
    /// # Errors
    /// Those of [`Model::number`].
    fn numbers(&mut self, quantity: Self::Quantity, values: &mut [f64]) -> Answer<()> {
        for (element, value) in values.iter_mut().enumerate() {
            *value = self.number(quantity, element)?;
        }
        Ok(())
    }

    /// Returns a text.
    fn text(&self, quantity: Self::Quantity, element: usize) -> &str;

    /// Checks that all elements of an array fit together, before they are set.
    ///
    /// # Errors
    /// They do not.
    fn check(&self, _quantity: Self::Quantity, _values: &[f64]) -> Answer<()> {
        Ok(())
    }

    /// Sets a number that can be set in the present phase to a value of its domain.
    fn set(&mut self, quantity: Self::Quantity, element: usize, value: f64, phase: Phase);

    /// Sets texts, all or none.
    ///
    /// # Errors
    /// A text is not a value of its variable.
    fn set_texts(&mut self, _values: &[(Self::Quantity, &str)]) -> Answer<()> {
        Ok(())
    }

    /// Returns the derivative of a Real with respect to time \[1/s\]; `None` if it is not known.
    fn derivative(&self, _quantity: Self::Quantity, _element: usize) -> Option<f64> {
        None
    }

    /// Lets an input vary linearly over the next step, at a rate per second. Called only if
    /// [`Model::INTERPOLATES_INPUTS`].
    fn set_rate(&mut self, _input: Self::Quantity, _element: usize, _rate: f64) {}

    /// Returns the known elements on which the elements of what is computed depend: at a communication point, or until
    /// initialization ends.
    fn dependencies(&self, computed: Self::Quantity, known: Known) -> Dependencies<Self::Quantity>;

    /// Takes the tolerance of the experiment, a positive and finite number, or none if the importer
    /// defines none. Called before initialization begins. A model that has no use for it ignores
    /// it.
    fn set_tolerance(&mut self, _tolerance: Option<f64>) {}

    /// Ends initialization: the model is built from the values that were set. The simulation begins
    /// at `start` \[s\].
    ///
    /// # Errors
    /// The values that were set do not fit together.
    fn initialize(&mut self, start: f64) -> Answer<()>;

    /// Returns how long \[s\] after the beginning of a communication step \[s\] values shall be seen, before its end.
    fn points(&self, _step: f64) -> Vec<f64> {
        Vec::new()
    }

    /// Shows the values within a communication step that has not been made: from `so_far` to `point` \[s\] after its
    /// beginning. [`Model::advance`] makes it from its beginning on, as if nobody had looked.
    ///
    /// # Errors
    /// There are no such values.
    fn look_ahead(&mut self, _from: f64, _so_far: f64, _point: f64) -> Answer<()> {
        Ok(())
    }

    /// Makes a communication step, to a time that is finite.
    ///
    /// # Errors
    /// [`StepError`] says whether anything has changed.
    fn advance(&mut self, step: Step) -> Result<(), StepError>;

    /// Returns to the state after [`Model::load`].
    ///
    /// # Errors
    /// The resources can no longer be read.
    fn reset(&mut self) -> Answer<()>;

    /// Returns the state; see [`Model::Saved`].
    fn save(&self) -> Self::Saved;

    /// Restores a state that was saved by this instance, or by another one with the same interface.
    ///
    /// # Errors
    /// The state cannot have been saved by an instance of this model.
    fn restore(&mut self, saved: &Self::Saved) -> Answer<()>;
}
