//! The table of the variables of an FMI 3.0 FMU.
//!
//! Value references: 0 is the independent variable `time`, then come the structural parameters, then the arrays.

use crate::model::{Model, token as of_lines};
use crate::variables::{Domain, Kind, Role};
use crate::{Phase, StepError};
use uuid::Uuid;

/// The value reference of `time`.
pub const TIME: u32 = 0;

/// A structural parameter: a number of things of which arrays have one element each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size {
    /// Name of the variable.
    pub name: &'static str,
    /// Description for users.
    pub description: &'static str,
}

/// A dimension of an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dimension {
    /// As many elements as a structural parameter says: its place among them.
    Size(usize),
    /// A constant number of elements.
    Fixed(u64),
}

/// A variable; `B` identifies it for the model.
#[derive(Debug, Clone, PartialEq)]
pub struct Array<B> {
    /// Structured name.
    pub name: &'static str,
    /// What the model knows it by.
    pub block: B,
    /// FMI type: Float64, Int32 or String.
    pub kind: Kind,
    /// Causality, variability and `initial` in one.
    pub role: Role,
    /// The values that each element can have.
    pub domain: Domain,
    /// From the outermost; none for a single value. Elements are in row-major order.
    pub dimensions: &'static [Dimension],
    /// Description for users.
    pub description: &'static str,
}

/// That an element depends on another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dependency<B> {
    /// Index of the dependent element, from 0.
    pub dependent: usize,
    /// The variable on which it depends.
    pub on: B,
    /// Index of the element on which it depends, from 0.
    pub element: usize,
}

/// The variables that count as known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Known {
    /// During the simulation.
    Inputs,
    /// Until initialization ends.
    InputsAndParameters,
}

/// A model whose variables can also be read and set as arrays. The slave checks lifecycle, value references, types,
/// lengths and domains.
pub trait ArrayModel: Model {
    /// Identifies an array.
    type Block: Copy + PartialEq + Send + Sync + 'static;

    /// The structural parameters.
    const SIZES: &'static [Size];

    /// Returns the arrays. They are the same for every content.
    fn arrays() -> Vec<Array<Self::Block>>;

    /// Returns the values of the structural parameters for what is loaded, in the order of [`ArrayModel::SIZES`].
    fn sizes(&self) -> Vec<u64>;

    /// Reads an array of Reals.
    ///
    /// # Errors
    /// The values that were set do not fit together, so that the Reals cannot be computed.
    fn read_reals(&mut self, block: Self::Block, values: &mut [f64]) -> Result<(), Self::Error>;

    /// Reads an array of Integers, or of Booleans as 0 and 1.
    ///
    /// # Errors
    /// Those of [`ArrayModel::read_reals`].
    fn read_integers(&mut self, block: Self::Block, values: &mut [i32]) -> Result<(), Self::Error>;

    /// Returns an array of texts.
    fn texts(&self, block: Self::Block) -> Vec<&str>;

    /// Checks that Reals of the array's domain fit together.
    ///
    /// # Errors
    /// They do not.
    fn check_reals(&self, _block: Self::Block, _values: &[f64]) -> Result<(), Self::Error> {
        Ok(())
    }

    /// Sets an array of Reals that can be set in the present phase.
    fn write_reals(&mut self, block: Self::Block, values: &[f64], phase: Phase);

    /// Sets an array of Integers, or of Booleans to 0 and 1.
    fn write_integers(&mut self, block: Self::Block, values: &[i32], phase: Phase);

    /// Sets texts, all or none.
    ///
    /// # Errors
    /// A text is not a value of its variable.
    fn write_texts(&mut self, values: &[(Self::Block, &str)]) -> Result<(), Self::Error>;

    /// Reads the derivatives of an array with respect to time \[1/s\]. Returns whether they are known.
    fn read_derivatives(&self, _block: Self::Block, _values: &mut [f64]) -> bool {
        false
    }

    /// Returns the inputs on which the elements of an output depend at a communication point; before initialization has
    /// ended, also the parameters that are listed. `None` if they are too many to be listed: each element depends on all.
    fn dependencies(&self, _block: Self::Block, _known: Known) -> Option<Vec<Dependency<Self::Block>>> {
        Some(Vec::new())
    }

    /// Returns the lengths \[s\] of the parts of a communication step \[s\] after which values are wanted; one part if
    /// none are wanted.
    fn parts(&self, step: f64) -> Vec<f64> {
        vec![step]
    }

    /// Advances by a part of a communication step that begins at `from`: `so_far` of it are over; `at_end` is the
    /// communication point at its end if this is the last part. All are in \[s\].
    ///
    /// # Errors
    /// Those of [`Model::advance`].
    fn advance_part(
        &mut self,
        from: f64,
        part: f64,
        so_far: f64,
        at_end: Option<f64>,
    ) -> Result<(), StepError<Self::Error>>;
}

/// Returns the value reference of the structural parameter at a place.
pub fn size_reference(place: usize) -> u32 {
    TIME + 1 + place as u32
}

/// Returns the value reference of the array at a place of the table.
pub fn array_reference<M: ArrayModel>(place: usize) -> u32 {
    size_reference(M::SIZES.len() + place)
}

/// Returns the instantiation token. It depends on names, types, dimensions, value references and causalities only.
pub fn token<M: ArrayModel>() -> Uuid {
    let sizes = M::SIZES.iter().map(|size| format!("{}\n", size.name));
    let arrays = M::arrays().into_iter().map(|array| {
        format!("{} {} {:?} {:?}\n", array.name, array.kind.name(), array.dimensions, array.role)
    });
    of_lines(["FMI 3.0\n".to_owned()].into_iter().chain(sizes).chain(arrays))
}
