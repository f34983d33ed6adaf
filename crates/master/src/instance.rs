//! The values of an instance, by their names.

use crate::calls::{Instance, Value};
use crate::error::{Cause, Error, Place, Result};
use crate::selection::{Part, Selection};
use crate::ssp::Type;
use std::str::FromStr;

/// Reads a number that a user wrote.
pub(crate) fn number<T: FromStr<Err: Into<Cause>>>(text: &str) -> Result<T, Cause> {
    text.parse().map_err(Into::into)
}

impl Instance {
    /// Selects values by their names.
    ///
    /// # Errors
    /// There is no such value.
    pub fn select<S: AsRef<str>>(&self, names: impl IntoIterator<Item = S>) -> Result<Selection> {
        let values = names.into_iter().map(|name| self.description.known(name.as_ref()));
        Ok(Selection::new(values.collect::<Result<Vec<_>>>()?))
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
            Type::Real => number(text).place(|| wrong("not a number"))?,
            Type::Integer => f64::from(number::<i32>(text).place(|| wrong("not a number"))?),
            Type::Boolean => match text {
                "true" | "1" => 1.0,
                "false" | "0" => 0.0,
                _ => return Err(Error::new(wrong("neither true nor false"))),
            },
            Type::String => return self.set(&selection, &vec![text.to_owned(); selection.len()]),
            _ => return Err(Error::new(format!("{first}: variables of type {of} cannot be set here"))),
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
    pub fn set<T: Value>(&self, selection: &Selection, values: &[T]) -> Result<()> {
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

    fn get_part<T: Value>(&self, part: &Part) -> Result<Vec<T>> {
        T::get(self, part.of, &part.references, part.length)
    }

    /// Reads values: numbers (integers as an `i32` has them: what is larger is refused; Booleans are 0 or 1) or texts.
    ///
    /// # Errors
    /// The FMU refuses the call, or a value is too large.
    pub fn values<T: Value>(&self, selection: &Selection) -> Result<Vec<T>> {
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
    pub fn value<T: Value>(&self, name: &str) -> Result<T> {
        let mut value = self.values(&self.select([name])?)?;
        Ok(value.swap_remove(0))
    }
}
