//! An instance of an FMU.

use crate::calls::{Calls, Value};
use crate::error::{Cause, Error, Place, Result};
use crate::selection::{Part, Selection};
use crate::ssp::{Address, Interface, Type};
use lemons_fmi::Status;
use std::cell::{Cell, RefCell};
use std::str::FromStr;
use std::sync::Arc;

/// Reads a number that a user wrote.
pub(crate) fn number<T: FromStr<Err: Into<Cause>>>(text: &str) -> Result<T, Cause> {
    text.parse().map_err(Into::into)
}

/// Values that are set when an instance is in initialization.
type Later = Box<dyn FnOnce(&Instance) -> Result<()>>;

/// An instance of an FMU.
pub struct Instance {
    calls: Calls,
    description: Arc<Interface>,
    /// True once initialization has begun.
    initialized: Cell<bool>,
    /// Arrays: FMI 3.0 does not let their other elements be read before initialization.
    later: RefCell<Vec<Later>>,
}

impl Instance {
    /// Makes an instance of an FMU of this description.
    pub(crate) fn new(calls: Calls, description: Arc<Interface>) -> Instance {
        let (initialized, later) = (Cell::new(false), RefCell::default());
        Instance { calls, description, initialized, later }
    }

    /// Sets the structural parameters that were chosen, in Configuration Mode (FMI 3.0).
    pub(crate) fn configure(&self, references: &[u32], sizes: &[u64]) -> Result<()> {
        if references.is_empty() {
            return Ok(());
        }
        self.calls.plain(["", "fmi3EnterConfigurationMode"])?;
        self.calls.set("fmi3SetUInt64", references, sizes)?;
        self.calls.plain(["", "fmi3ExitConfigurationMode"]).map(drop)
    }

    /// Selects values by their names.
    ///
    /// # Errors
    /// There is no such value.
    pub fn select<S: AsRef<str>>(&self, names: impl IntoIterator<Item = S>) -> Result<Selection> {
        let addresses = names.into_iter().map(|name| self.address(name.as_ref()));
        self.select_at(&addresses.collect::<Result<Vec<_>>>()?)
    }

    /// Selects values by their addresses.
    ///
    /// # Errors
    /// There is no such value.
    pub fn select_at(&self, addresses: &[Address]) -> Result<Selection> {
        Selection::new(&self.description, addresses)
    }

    /// Returns where a value is.
    ///
    /// # Errors
    /// There is no such value.
    pub fn address(&self, name: &str) -> Result<Address> {
        Ok(self.description.known(name)?.address())
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
            of => {
                let of = of.name();
                return Err(Error::new(format!("{first}: variables of type {of} cannot be set here")));
            }
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

    /// `fmi2SetupExperiment` at a time \[s\] and `fmi2EnterInitializationMode`, or `fmi3EnterInitializationMode`; then
    /// elements of arrays are set that were set before. The tolerance is this one, else that of the FMU's own
    /// DefaultExperiment, if there is one.
    ///
    /// # Errors
    /// The FMU refuses the call.
    pub fn enter_initialization(&self, start: f64, tolerance: Option<f64>) -> Result<()> {
        let tolerance = tolerance.or(self.description.tolerance);
        self.calls.enter_initialization(start, tolerance)?;
        self.initialized.set(true);
        let later = std::mem::take(&mut *self.later.borrow_mut());
        later.into_iter().try_for_each(|set| set(self))
    }

    /// `fmi2ExitInitializationMode`, `fmi3ExitInitializationMode`
    ///
    /// # Errors
    /// The FMU refuses the call.
    pub fn exit_initialization(&self) -> Result<()> {
        self.calls.plain(["fmi2ExitInitializationMode", "fmi3ExitInitializationMode"]).map(drop)
    }

    /// Sets values. Arrays wait for initialization, so that the last value counts and sizes are those of the Trial that
    /// was chosen: an array can only be set whole, and cannot be read before.
    ///
    /// # Errors
    /// The FMU refuses the call, or a value is none of a variable's type.
    pub fn set<T: Value>(&self, selection: &Selection, values: &[T]) -> Result<()> {
        if selection.has_arrays() && !self.initialized.get() {
            let (selection, values) = (selection.clone(), values.to_vec());
            self.later.borrow_mut().push(Box::new(move |instance| instance.set(&selection, &values)));
            return Ok(());
        }
        let set = |part: &Part, values: &[T]| T::set(&self.calls, part.of, &part.references, values);
        selection.write(values, |part, values| self.get_part(part, values), set)
    }

    /// Reads values: numbers (integers as an `i32` has them: what is larger is refused; Booleans are 0 or 1) or texts.
    ///
    /// # Errors
    /// The FMU refuses the call, or a value is too large.
    pub fn get<T: Value>(&self, selection: &Selection, values: &mut [T]) -> Result<()> {
        selection.read(values, |part, values| self.get_part(part, values))
    }

    fn get_part<T: Value>(&self, part: &Part, values: &mut [T]) -> Result<()> {
        T::get(&self.calls, part.of, &part.references, values)
    }

    /// Reads values.
    ///
    /// # Errors
    /// As [`Instance::get`].
    pub fn values<T: Value>(&self, selection: &Selection) -> Result<Vec<T>> {
        let mut values = vec![T::default(); selection.len()];
        self.get(selection, &mut values)?;
        Ok(values)
    }

    /// Reads a single value.
    ///
    /// # Errors
    /// There is no such value, or the FMU refuses the call.
    pub fn value<T: Value>(&self, name: &str) -> Result<T> {
        let mut value = [T::default()];
        self.get(&self.select([name])?, &mut value)?;
        let [value] = value;
        Ok(value)
    }

    /// Makes a step from a time, both \[s\].
    ///
    /// # Errors
    /// The FMU refuses the step or fails; in FMI 3.0 also if it wants an event, or the end of the simulation.
    pub fn step(&self, time: f64, step: f64) -> Result<()> {
        if self.calls.do_step(time, step)? == Status::Warning {
            self.calls.messages.warned(time, self.description.fmi);
        }
        Ok(())
    }

    /// `fmi2Terminate`, `fmi3Terminate`
    ///
    /// # Errors
    /// The FMU refuses the call.
    pub fn terminate(&self) -> Result<()> {
        self.calls.plain(["fmi2Terminate", "fmi3Terminate"]).map(drop)
    }

    /// Returns the present state as bytes: `fmi2GetFMUstate`, `fmi2SerializeFMUstate`.
    ///
    /// # Errors
    /// The FMU refuses a call, or the state is too large for the memory.
    pub fn state(&self) -> Result<Vec<u8>> {
        self.calls.save()
    }

    /// Goes to a state: `fmi2DeSerializeFMUstate`, `fmi2SetFMUstate`.
    ///
    /// # Errors
    /// Bytes that are none of such an FMU, or its refusal.
    pub fn restore(&self, bytes: &[u8]) -> Result<()> {
        self.calls.restore(bytes)
    }

    /// Returns the warnings of the FMU since the last call: the first 1000, the number of further ones, and the time \[s\] of
    /// the first step that returned the status Warning.
    pub fn warnings(&self) -> Vec<String> {
        self.calls.messages.warnings()
    }
}
