//! The values of an instance, by their names. Single values are read or set together.
//!
//! An FMU 2.0 has a value for each type and reference. An FMU 3.0 has arrays, which are read and set whole, by one call for all of
//! one type: which of their elements are meant is found out once, not at each communication point.

use crate::calls::{FmiValue, FmuInstance};
use crate::error::{Cause, ErrorPlace, MasterError, Result};
use crate::ssp::{FmiType, Single};
use std::collections::{HashMap, HashSet};
use std::str::FromStr;

/// Reads a number that a user wrote.
pub(crate) fn number<T: FromStr<Err: Into<Cause>>>(text: &str) -> Result<T, Cause> {
    text.parse().map_err(Into::into)
}

/// Single values of an instance that are read or set together, in an order.
#[derive(Debug, Clone, Default)]
pub struct ValueSelection {
    /// One for each type.
    parts: Vec<Part>,
    /// The part of each value, and its place among the values of the part's call.
    places: Vec<(usize, usize)>,
    /// True if the values are those of one call, in its order.
    is_one_call: bool,
}

/// The values that one call reads or sets.
#[derive(Debug, Clone, Default)]
struct Part {
    of: FmiType,
    references: Vec<u32>,
    /// The number of values of the call.
    length: usize,
    /// True if each value of the call is a selected one.
    whole: bool,
    /// True if an array is among the variables.
    arrays: bool,
}

impl ValueSelection {
    pub(crate) fn new<'a>(values: impl IntoIterator<Item = Single<'a>>) -> ValueSelection {
        let (mut parts, mut places) = (Vec::<Part>::new(), Vec::new());
        // The part in which the values of a variable are, and where they begin.
        let mut begins: HashMap<(FmiType, u32), (usize, usize)> = HashMap::new();
        for Single { variable, element } in values {
            let of = variable.of;
            let (at, begin) = *begins.entry((of, variable.reference)).or_insert_with(|| {
                let at = parts.iter().position(|part| part.of == of).unwrap_or_else(|| {
                    parts.push(Part { of, ..Part::default() });
                    parts.len() - 1
                });
                let part = &mut parts[at];
                let begin = part.length;
                part.references.push(variable.reference);
                part.length += variable.count();
                part.arrays |= variable.is_array();
                (at, begin)
            });
            places.push((at, begin + element));
        }
        let selected: HashSet<&(usize, usize)> = places.iter().collect();
        for (at, part) in parts.iter_mut().enumerate() {
            part.whole = (0..part.length).all(|place| selected.contains(&(at, place)));
        }
        let in_order = places.iter().enumerate().all(|(k, place)| *place == (0, k));
        let is_one_call = in_order && parts.first().is_some_and(|part| part.length == places.len());
        ValueSelection { parts, places, is_one_call }
    }

    /// Returns the number of values.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Returns whether there are none.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Returns whether an array is among the variables.
    fn has_arrays(&self) -> bool {
        self.parts.iter().any(|part| part.arrays)
    }
}

impl FmuInstance {
    /// Selects values by their names.
    ///
    /// # Errors
    /// There is no such value.
    pub fn select<S: AsRef<str>>(&self, names: impl IntoIterator<Item = S>) -> Result<ValueSelection> {
        let values = names.into_iter().map(|name| self.description.known(name.as_ref()));
        Ok(ValueSelection::new(values.collect::<Result<Vec<_>>>()?))
    }

    /// Sets values of one type from a text, all to the same.
    ///
    /// # Errors
    /// There is no such value, the text is no value of the type, or the FMU's refusal.
    pub fn set_text<S: AsRef<str>>(&self, names: &[S], text: &str) -> Result<()> {
        let Some(first) = names.first().map(AsRef::as_ref) else { return Ok(()) };
        let of = self.description.known(first)?.variable.of;
        let selection = self.select(names)?;
        let wrong = |why: &str| format!("{first}={text}: {why}");
        let value = match of.class() {
            FmiType::Real => number(text).place(|| wrong("not a number"))?,
            FmiType::Integer => f64::from(number::<i32>(text).place(|| wrong("not a number"))?),
            FmiType::Boolean => match text {
                "true" | "1" => 1.0,
                "false" | "0" => 0.0,
                _ => return Err(MasterError::new(wrong("neither true nor false"))),
            },
            FmiType::String => return self.set(&selection, &vec![text.to_owned(); selection.len()]),
            _ => return Err(MasterError::new(format!("{first}: variables of type {of} cannot be set here"))),
        };
        self.set(&selection, &vec![value; selection.len()])
    }

    /// Initializes from the beginning to the end, at time 0.
    ///
    /// # Errors
    /// The FMU refuses the call.
    pub fn initialize(&self) -> Result<()> {
        self.enter_initialization(0.0, None)?;
        self.exit_initialization()
    }

    /// Sets values: of arrays of which only some elements are selected, the others stay. Arrays wait for initialization, so
    /// that the last value counts and sizes are those of the Trial that was chosen: an array can only be set whole, and
    /// cannot be read before.
    ///
    /// # Errors
    /// The FMU refuses the call, or a value is none of a variable's type.
    pub fn set<T: FmiValue>(&self, selection: &ValueSelection, values: &[T]) -> Result<()> {
        assert_eq!(selection.len(), values.len(), "a value for each that is selected");
        if selection.has_arrays() && !self.initialized.get() {
            let (selection, values) = (selection.clone(), values.to_vec());
            self.later.borrow_mut().push(Box::new(move |instance| instance.set(&selection, &values)));
            return Ok(());
        }
        let set = |part: &Part, values: &[T]| T::set(self, part.of, &part.references, values);
        if selection.is_one_call {
            return set(&selection.parts[0], values);
        }
        let before = |part: &Part| {
            if part.whole { Ok(vec![T::default(); part.length]) } else { self.get_part(part) }
        };
        let mut all = selection.parts.iter().map(before).collect::<Result<Vec<Vec<T>>>>()?;
        for (value, &(part, place)) in values.iter().zip(&selection.places) {
            all[part][place].clone_from(value);
        }
        selection.parts.iter().zip(&all).try_for_each(|(part, values)| set(part, values))
    }

    fn get_part<T: FmiValue>(&self, part: &Part) -> Result<Vec<T>> {
        T::get(self, part.of, &part.references, part.length)
    }

    /// Reads values: numbers (integers as an `i32` has them: what is larger is refused; Booleans are 0 or 1) or texts.
    ///
    /// # Errors
    /// The FMU refuses the call, or a value is too large.
    pub fn values<T: FmiValue>(&self, selection: &ValueSelection) -> Result<Vec<T>> {
        if selection.is_one_call {
            return self.get_part(&selection.parts[0]);
        }
        let all = selection.parts.iter().map(|part| self.get_part(part)).collect::<Result<Vec<Vec<T>>>>()?;
        Ok(selection.places.iter().map(|&(part, place)| all[part][place].clone()).collect())
    }

    /// Reads a single value.
    ///
    /// # Errors
    /// There is no such value, or the FMU refuses the call.
    pub fn value<T: FmiValue>(&self, name: &str) -> Result<T> {
        let mut value = self.values(&self.select([name])?)?;
        Ok(value.swap_remove(0))
    }
}
