//! One FMU instance without the C interface, of either version of FMI: lifecycle, variables,
//! stepping, states.
//!
//! A call that is refused does not change the instance.

use crate::lifecycle::{Function, Phase, allowed};
use crate::model::{Model, Step, StepError, guid, instantiation_token, reference};
use crate::variables::{Dependencies, Dimension, Domain, Known, MOST, Number, Role, Scalar, Type, Variable};
use crate::{Status, Version};
use serde::{Deserialize, Serialize};
use uuid::Uuid;

/// Why a call was refused or failed, in words.
#[derive(Debug)]
pub struct Refusal {
    /// Status that the importer gets.
    pub status: Status,
    /// Message that is logged.
    pub message: String,
}

impl Refusal {
    /// Makes the refusal of a call.
    pub fn new(message: impl Into<String>) -> Refusal {
        Refusal { status: Status::Error, message: message.into() }
    }
}

impl std::fmt::Display for Refusal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.message)
    }
}

impl<E: std::error::Error> From<E> for Refusal {
    fn from(error: E) -> Refusal {
        Refusal::new(error.to_string())
    }
}

/// What both versions say of a value out of its range: nothing has changed, and other values may do.
fn out_of_range<T>(message: String) -> Answer<T> {
    Err(Refusal { status: Status::Discard, message })
}

/// What FMI 3.0 says of a call that a model refuses: nothing has changed, and other values may do.
fn discard<T>(version: Version, answer: Answer<T>) -> Answer<T> {
    answer.map_err(|refusal| match (version, refusal.status) {
        (Version::V3, Status::Error) => Refusal { status: Status::Discard, ..refusal },
        _ => refusal,
    })
}

/// The result of a call.
pub type Answer<T> = Result<T, Refusal>;

/// Refuses a call.
///
/// # Errors
/// Always.
pub fn refuse<T>(message: impl Into<String>) -> Answer<T> {
    Err(Refusal::new(message))
}

/// Start time and, if given, stop time of the simulation \[s\].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Experiment {
    start: f64,
    stop: Option<f64>,
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

/// A variable that a value reference leads to, without what only messages need: calls read
/// thousands of them.
#[derive(Clone, Copy)]
struct Row<Q> {
    /// `None` for the time and the structural parameters of FMI 3.0.
    quantity: Option<Q>,
    /// FMI 2.0: the element.
    element: u32,
    of: Type,
    role: Role,
    domain: Domain,
}

impl<Q: Copy> Row<Q> {
    fn new(variable: &Variable<Q>, element: usize) -> Row<Q> {
        Row {
            quantity: Some(variable.quantity),
            element: element as u32,
            of: variable.kind.into(),
            role: variable.role,
            domain: variable.domain,
        }
    }
}

/// One FMU instance.
pub struct Slave<M: Model> {
    pub(crate) model: M,
    version: Version,
    token: Uuid,
    /// The variables by value reference. In FMI 2.0 each is an element; in FMI 3.0 the time, the
    /// structural parameters, and whole variables.
    rows: Vec<Row<M::Quantity>>,
    /// FMI 2.0: the variables, for messages.
    scalars: Vec<Scalar<M::Quantity>>,
    /// FMI 3.0: the structural parameters as they were set.
    sizes: Vec<u64>,
    phase: Phase,
    time: f64,
    experiment: Option<Experiment>,
}

impl<M: Model> Slave<M> {
    /// Makes an instance of a model.
    ///
    /// # Errors
    /// The token is not that of the model.
    pub fn new(model: M, version: Version, given: &str) -> Answer<Slave<M>> {
        let mut scalars = Vec::new();
        let (rows, token, word) = match version {
            Version::V2 => {
                scalars = model.scalars();
                let row = |scalar: &Scalar<M::Quantity>| Row::new(scalar.variable, scalar.element);
                (scalars.iter().map(row).collect(), guid(&scalars), "GUID")
            }
            Version::V3 => (rows_of_arrays::<M>(), instantiation_token::<M>(), "instantiationToken"),
        };
        let bare = |text: &str| text.trim_matches(['{', '}']).to_ascii_lowercase();
        if bare(given) != token.to_string() {
            return refuse(format!(
                "the {word} {given:?} is not this FMU's {:?}: modelDescription.xml and resources do not belong \
                 together",
                token.braced().to_string()
            ));
        }
        let sizes = sizes(&model, version);
        let (phase, time, experiment) = (Phase::Instantiated, 0.0, None);
        Ok(Slave { model, version, token, rows, scalars, sizes, phase, time, experiment })
    }

    /// Returns the current communication point \[s\].
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Returns the warnings since the last call.
    pub fn take_warnings(&mut self) -> Vec<String> {
        self.model.take_warnings()
    }

    /// Checks that a function is allowed in the current phase.
    ///
    /// # Errors
    /// It is not allowed.
    pub fn check(&self, function: Function) -> Answer<()> {
        if allowed(function, self.version, self.phase) {
            Ok(())
        } else {
            refuse(format!("not allowed in the state {:?}", self.phase))
        }
    }

    /// Sets start time and, if given, stop time of the simulation \[s\], and tolerance:
    /// `fmi2SetupExperiment`, or the first part of `fmi3EnterInitializationMode`.
    ///
    /// # Errors
    /// Wrong phase; times that are not finite or are in the wrong order; a tolerance that is negative
    /// or not finite.
    pub fn setup_experiment(&mut self, start: f64, stop: Option<f64>, tolerance: Option<f64>) -> Answer<()> {
        self.check(Function::SetupExperiment)?;
        // OMSimulator defines one of 0 where its structure names none.
        let tolerance = tolerance.filter(|tolerance| *tolerance != 0.0);
        if let Some(tolerance) = tolerance.filter(|tolerance| !(*tolerance > 0.0 && tolerance.is_finite())) {
            return refuse(format!(
                "a tolerance of {tolerance:?}: must be positive and finite, or 0 or not defined for none"
            ));
        }
        if !start.is_finite() {
            return refuse(format!("start time {start:?}: must be finite"));
        }
        if let Some(stop) = stop.filter(|stop| !(stop.is_finite() && *stop >= start)) {
            return refuse(format!(
                "stop time {stop:?} s: must be finite and not before the start time {start:?} s"
            ));
        }
        (self.experiment, self.time) = (Some(Experiment { start, stop }), start);
        self.model.set_tolerance(tolerance);
        Ok(())
    }

    /// Enters Initialization Mode.
    ///
    /// # Errors
    /// Wrong phase, or no start time.
    pub fn enter_initialization(&mut self) -> Answer<()> {
        self.check(Function::EnterInitializationMode)?;
        if self.experiment.is_none() {
            return refuse("fmi2SetupExperiment has not been called");
        }
        self.phase = Phase::Initialization;
        Ok(())
    }

    /// Leaves Initialization Mode.
    ///
    /// # Errors
    /// Wrong phase; structural parameters that are not the sizes of what is loaded; values that do
    /// not fit together.
    pub fn exit_initialization(&mut self) -> Answer<()> {
        self.check(Function::ExitInitializationMode)?;
        (0..self.sizes.len()).try_for_each(|place| self.check_size(place))?;
        discard(self.version, self.model.initialize(self.time))?;
        self.phase = Phase::StepComplete;
        Ok(())
    }

    /// Calls a function that does nothing but lead to a phase.
    ///
    /// # Errors
    /// Wrong phase.
    pub fn change_phase(&mut self, function: Function, to: Phase) -> Answer<()> {
        self.check(function)?;
        self.phase = to;
        Ok(())
    }

    /// Goes back to the state after instantiation.
    ///
    /// # Errors
    /// Wrong phase, or resources that can no longer be read.
    pub fn reset(&mut self) -> Answer<()> {
        self.check(Function::Reset)?;
        self.model.reset()?;
        self.sizes = sizes(&self.model, self.version);
        (self.phase, self.time, self.experiment) = (Phase::Instantiated, 0.0, None);
        Ok(())
    }

    /// Refuses a structural parameter that is not the size of what is loaded.
    fn check_size(&self, place: usize) -> Answer<()> {
        let (declared, loaded) = (self.sizes[place], self.model.size(place));
        if declared == loaded {
            return Ok(());
        }
        let name = M::SIZES[place].name;
        refuse(format!(
            "{name} is {declared}, but what is loaded has {loaded}: choose what to load, or set {name} in \
             Configuration Mode"
        ))
    }

    #[inline]
    fn row(&self, reference: u32, of: Type) -> Answer<Row<M::Quantity>> {
        match self.rows.get(reference as usize) {
            Some(row) if row.of == of => Ok(*row),
            _ => unknown_reference(of.name(self.version), reference),
        }
    }

    /// FMI 3.0: the array of a value reference.
    fn array(&self, reference: u32) -> Option<&'static Variable<M::Quantity>> {
        M::VARIABLES.get((reference as usize).checked_sub(1 + M::SIZES.len())?)
    }

    /// Returns the number of elements of a variable, whose sizes must be those of what is loaded.
    #[inline]
    fn length(&self, reference: u32) -> Answer<usize> {
        if self.version == Version::V2 {
            return Ok(1);
        }
        let mut length = 1;
        for dimension in self.array(reference).map_or(&[][..], |array| array.dimensions) {
            length *= match *dimension {
                Dimension::Fixed(size) => size as usize,
                Dimension::Size(place) => {
                    self.check_size(place)?;
                    self.sizes[place] as usize
                }
            };
        }
        Ok(length)
    }

    /// Returns the number of elements of all variables together.
    ///
    /// # Errors
    /// Unknown references, or sizes that are not those of what is loaded.
    pub fn count(&self, references: &[u32], of: Type) -> Answer<usize> {
        let mut count = 0;
        for &reference in references {
            self.row(reference, of)?;
            count += self.length(reference)?;
        }
        Ok(count)
    }

    /// Checks types, and that the number of elements of all variables together is that of the
    /// values.
    fn check_count(&self, references: &[u32], of: Type, given: usize) -> Answer<()> {
        if self.version == Version::V2 {
            return Ok(());
        }
        let wanted = self.count(references, of)?;
        if wanted == given {
            return Ok(());
        }
        refuse(format!("{given} values for variables of {wanted} elements together"))
    }

    /// Returns the name of a variable, or of an element of an array, for messages.
    #[cold]
    fn name(&self, reference: u32, element: Option<usize>) -> String {
        let reference = reference as usize;
        if self.version == Version::V2 {
            return self.scalars[reference].name.clone();
        }
        match (self.array(reference as u32), element) {
            (Some(array), Some(element)) if !array.dimensions.is_empty() => {
                format!("{}[{element}]", array.name)
            }
            (Some(array), _) => array.name.to_owned(),
            (None, _) => reference.checked_sub(1).map_or("time", |place| M::SIZES[place].name).to_owned(),
        }
    }

    /// Refuses to read what has no start value before initialization begins (FMI 3.0, section 2.3.2).
    fn check_readable(&self, references: &[u32], of: Type) -> Answer<()> {
        if self.phase != Phase::Instantiated {
            return Ok(());
        }
        for &reference in references {
            if matches!(self.row(reference, of)?.role, Role::Calculated | Role::CalculatedParameter) {
                let name = self.name(reference, None);
                return refuse(format!("{name} has no start value: it can be read from initialization on"));
            }
        }
        Ok(())
    }

    /// Reads or sets a type that no variable has: right only without variables.
    ///
    /// # Errors
    /// Wrong phase, or a reference.
    pub fn no_variables(&self, function: Function, kind: &str, references: &[u32]) -> Answer<()> {
        self.check(function)?;
        references.first().map_or(Ok(()), |&reference| unknown_reference(kind, reference))
    }

    /// Refuses a function of events, clocks and other kinds of FMUs.
    ///
    /// # Errors
    /// Always.
    pub fn not_offered<T>(&self) -> Answer<T> {
        self.check(Function::Unsupported)?;
        refuse("this FMU is for co-simulation without events and clocks")
    }

    /// Refuses directional derivatives.
    ///
    /// # Errors
    /// Always.
    pub fn no_directional_derivative<T>(&self) -> Answer<T> {
        self.check(Function::GetDirectionalDerivative)?;
        refuse(match self.version {
            Version::V2 => "providesDirectionalDerivative is false",
            Version::V3 => "providesDirectionalDerivatives and providesAdjointDerivatives are false",
        })
    }

    /// Reads numbers.
    ///
    /// # Errors
    /// Wrong phase, unknown references, a wrong number of values; in initialization, values that do
    /// not fit together.
    pub fn get<N: Number>(&mut self, references: &[u32], values: &mut [N]) -> Answer<()> {
        self.check(Function::Get)?;
        if self.version == Version::V2 {
            for (&reference, value) in references.iter().zip(values) {
                if let Row { quantity: Some(quantity), element, .. } = self.row(reference, N::TYPE)? {
                    *value = N::of(self.model.number(quantity, element as usize)?);
                }
            }
            return Ok(());
        }
        self.check_count(references, N::TYPE, values.len())?;
        self.check_readable(references, N::TYPE)?;
        let (mut rest, mut numbers) = (values, Vec::new());
        for &reference in references {
            let (these, others) = rest.split_at_mut(self.length(reference)?);
            numbers.clear();
            numbers.resize(these.len(), self.time);
            match self.row(reference, N::TYPE)?.quantity {
                Some(quantity) => discard(self.version, self.model.numbers(quantity, &mut numbers))?,
                None if N::TYPE == Type::Size => numbers[0] = self.sizes[reference as usize - 1] as f64,
                None => {}
            }
            these.iter_mut().zip(&numbers).for_each(|(value, number)| *value = N::of(*number));
            rest = others;
        }
        Ok(())
    }

    /// Reads texts.
    ///
    /// # Errors
    /// Wrong phase, unknown references, a wrong number of values.
    pub fn get_strings(&self, references: &[u32], count: usize) -> Answer<Vec<String>> {
        self.check(Function::Get)?;
        self.check_count(references, Type::String, count)?;
        self.check_readable(references, Type::String)?;
        let mut texts = Vec::with_capacity(count);
        for &reference in references {
            let Row { quantity: Some(quantity), element, .. } = self.row(reference, Type::String)? else {
                continue;
            };
            let elements = (element as usize..).take(self.length(reference)?);
            texts.extend(elements.map(|element| self.model.text(quantity, element).to_owned()));
        }
        Ok(texts)
    }

    /// Refuses a variable that cannot be set in this phase.
    #[inline]
    fn check_settable(&self, reference: u32, row: Row<M::Quantity>) -> Answer<()> {
        let before = matches!(self.phase, Phase::Instantiated | Phase::Initialization);
        let when = match row.role {
            _ if row.of == Type::Size && self.phase == Phase::Configuration => return Ok(()),
            _ if row.of == Type::Size => "outside Configuration Mode",
            _ if self.phase == Phase::Configuration => "in Configuration Mode",
            Role::Input => return Ok(()),
            Role::Parameter | Role::Exact if before => return Ok(()),
            Role::Parameter | Role::Exact => "after initialization",
            Role::Calculated | Role::CalculatedParameter => "at all: it is computed",
        };
        refuse(format!("{} cannot be set {when}", self.name(reference, None)))
    }

    /// Sets numbers.
    ///
    /// # Errors
    /// Wrong phase, unknown references, a wrong number of values, or values outside their domain.
    /// Then none of them is set.
    pub fn set<N: Number>(&mut self, references: &[u32], values: &[N]) -> Answer<()> {
        let (of, values) = (N::TYPE, &*N::numbers(values));
        self.check(Function::Set)?;
        self.check_count(references, of, values.len())?;
        let mut rest = values;
        for &reference in references {
            let row = self.row(reference, of)?;
            self.check_settable(reference, row)?;
            let (these, others) = rest.split_at(self.length(reference)?);
            for (element, &value) in these.iter().enumerate() {
                if let Err(must) = row.domain.check(value) {
                    let value = if matches!(of, Type::Integer | Type::Size) {
                        format!("{value:.0}")
                    } else {
                        format!("{value:?}")
                    };
                    let name = self.name(reference, Some(element));
                    return out_of_range(format!("{name} = {value}: must be {must}"));
                }
            }
            if let (Version::V3, Some(quantity)) = (self.version, row.quantity) {
                discard(self.version, self.model.check(quantity, these))?;
            }
            rest = others;
        }
        let mut rest = values;
        for &reference in references {
            let row = self.row(reference, of)?;
            let (these, others) = rest.split_at(self.length(reference)?);
            for (element, &value) in (row.element as usize..).zip(these) {
                match row.quantity {
                    Some(quantity) => self.model.set(quantity, element, value, self.phase),
                    None => self.sizes[reference as usize - 1] = value as u64,
                }
            }
            rest = others;
        }
        Ok(())
    }

    /// Sets texts.
    ///
    /// # Errors
    /// The same as of [`Slave::set`]; a text is not a value of its variable.
    pub fn set_strings(&mut self, references: &[u32], values: &[&str]) -> Answer<()> {
        self.check(Function::Set)?;
        self.check_count(references, Type::String, values.len())?;
        let mut texts = Vec::with_capacity(references.len());
        for (&reference, &value) in references.iter().zip(values) {
            let row = self.row(reference, Type::String)?;
            self.check_settable(reference, row)?;
            texts.extend(row.quantity.map(|quantity| (quantity, value)));
        }
        discard(self.version, self.model.set_texts(&texts))
    }

    /// Reads derivatives with respect to time, of order 1.
    ///
    /// # Errors
    /// Wrong phase, unknown references, a wrong number of values, other orders, or variables whose
    /// derivative is not known. Then the values are unchanged.
    pub fn get_output_derivatives(
        &self,
        references: &[u32],
        orders: &[i32],
        values: &mut [f64],
    ) -> Answer<()> {
        self.check(Function::GetOutputDerivatives)?;
        self.check_count(references, Type::Real, values.len())?;
        let mut found = Vec::with_capacity(values.len());
        for (&reference, &order) in references.iter().zip(orders) {
            let row = self.row(reference, Type::Real)?;
            if order != 1 {
                let name = self.name(reference, None);
                return refuse(format!("the derivative of order {order} of {name}: only order 1 is known"));
            }
            for element in (row.element as usize..).take(self.length(reference)?) {
                let derivative = row.quantity.and_then(|quantity| self.model.derivative(quantity, element));
                let Some(derivative) = derivative else {
                    let name = self.name(reference, None);
                    return refuse(format!(
                        "{name}: its derivative is not known, only those of continuous motion are"
                    ));
                };
                found.push(derivative);
            }
        }
        values.copy_from_slice(&found);
        Ok(())
    }

    /// `fmi2SetRealInputDerivatives`: over the next step the inputs vary linearly, at these rates
    /// per second, from their values at its start. A rate is used for one step.
    ///
    /// # Errors
    /// Wrong phase, unknown references, variables that are not inputs, orders other than 1, rates
    /// that are not finite, or a model that does not interpolate inputs. Then nothing is set.
    pub fn set_input_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &[f64],
    ) -> Answer<()> {
        self.check(Function::SetInputDerivatives)?;
        if !M::INTERPOLATES_INPUTS {
            return refuse("canInterpolateInputs is false: inputs are held over a step");
        }
        for ((&reference, &order), &value) in references.iter().zip(orders).zip(values) {
            let row = self.row(reference, Type::Real)?;
            let name = || self.name(reference, None);
            if row.role != Role::Input {
                return refuse(format!("{} is not an input, so its derivative cannot be set", name()));
            }
            if order != 1 {
                let name = name();
                return refuse(format!(
                    "the derivative of order {order} of {name}: inputs are interpolated with order 1"
                ));
            }
            if !value.is_finite() {
                return refuse(format!("the derivative of {} = {value:?}: must be finite", name()));
            }
        }
        for (&reference, &value) in references.iter().zip(values) {
            let row = self.row(reference, Type::Real)?;
            if let Some(quantity) = row.quantity {
                self.model.set_rate(quantity, row.element as usize, value);
            }
        }
        Ok(())
    }

    /// `fmi3GetVariableDependencies`: of the elements of an output, as FMI counts them (from 1; 0 is all
    /// of them), the value reference of the variable on which each depends, and the index of its
    /// element. Until initialization ends, the initial dependencies (FMI 3.0, section 2.2.9).
    ///
    /// # Errors
    /// Wrong phase or an unknown reference.
    pub fn dependencies(&self, of: u32) -> Answer<Vec<(usize, u32, usize)>> {
        self.check(Function::GetVariableDependencies)?;
        let Some(array) = self.array(of) else {
            let known = (of as usize) < self.rows.len();
            return if known { Ok(Vec::new()) } else { unknown_reference("any", of) };
        };
        let known = match self.phase {
            Phase::Instantiated | Phase::Configuration | Phase::Initialization => Known::Starts,
            _ => Known::Inputs,
        };
        Ok(match self.model.dependencies(array.quantity, known) {
            Dependencies::All(on) => {
                on.into_iter().filter_map(|on| Some((0, reference::<M>(on)?, 0))).collect()
            }
            Dependencies::Elements(own) => own
                .into_iter()
                .filter_map(|of| Some((of.dependent + 1, reference::<M>(of.on)?, of.element + 1)))
                .collect(),
        })
    }

    /// Returns how long \[s\] after the beginning of a communication step values are seen within it.
    ///
    /// # Errors
    /// Wrong phase, a communication point that is not the slave's time, or a step that is not
    /// positive, or goes beyond the stop time.
    pub(crate) fn points(&self, from: f64, step: f64, seen: bool) -> Answer<Vec<f64>> {
        self.check_step(from, step)?;
        Ok(if seen { self.model.points(step) } else { Vec::new() })
    }

    /// Begins the importer's callback within a step, if there are values to be seen: see [`Model::look_ahead`].
    pub(crate) fn look_ahead(&mut self, from: f64, so_far: f64, point: f64) -> bool {
        let seen = self.model.look_ahead(from, so_far, point).is_ok();
        if seen {
            (self.phase, self.time) = (Phase::Intermediate, from + point);
        }
        seen
    }

    /// Makes a communication step within which nobody looks. Returns the time \[s\] that was reached.
    ///
    /// # Errors
    /// It is not allowed, or the model refuses it, and nothing has changed; or it fails, and the
    /// slave is in the error state, in FMI 3.0 terminated.
    pub fn step(&mut self, from: f64, length: f64) -> Answer<f64> {
        self.check_step(from, length)?;
        self.do_step(Step::of(from, length), self.time)?;
        Ok(self.time)
    }

    /// Makes a communication step that was checked when the slave was at this time \[s\].
    ///
    /// # Errors
    /// The model refuses it, and nothing has changed; or it fails, and the slave is in the error state, in FMI 3.0
    /// terminated.
    pub(crate) fn do_step(&mut self, step: Step, time: f64) -> Answer<()> {
        (self.phase, self.time) = (Phase::StepComplete, time);
        match self.model.advance(step) {
            Ok(()) => {
                self.time = step.to;
                Ok(())
            }
            Err(StepError::Refused(error)) => discard(self.version, Err(error)),
            Err(StepError::Failed(error)) => {
                self.phase = if self.version == Version::V2 { Phase::Error } else { Phase::Terminated };
                Err(error)
            }
        }
    }

    /// Checks a communication step, before anything is changed.
    fn check_step(&self, from: f64, step: f64) -> Answer<()> {
        self.check(Function::DoStep)?;
        let step_size = || {
            refuse(format!(
                "a communication step of {step:?} s: must be positive and finite, and end at a finite time"
            ))
        };
        if !(step > 0.0 && step.is_finite()) {
            return step_size();
        }
        // Masters add up their own times. A difference of half a step is another communication
        // point.
        let tolerance = (1e-5 * from.abs().max(step)).min(0.5 * step);
        if (from - self.time).abs() > tolerance || from.is_nan() {
            return refuse(format!(
                "the communication point {from:?} s is not the slave's time {:?} s",
                self.time
            ));
        }
        if !(from + step).is_finite() {
            return step_size();
        }
        let stop = self.experiment.and_then(|experiment| experiment.stop);
        if let Some(stop) = stop.filter(|stop| from + step > stop + tolerance) {
            return refuse(format!(
                "a step from {from:?} s of {step:?} s goes beyond the stop time {stop:?} s"
            ));
        }
        Ok(())
    }

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
        if sizes.len() != self.sizes.len() || !sizes.iter().all(|size| (1..=MOST).contains(size)) {
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

fn unknown_reference<T>(kind: &str, reference: u32) -> Answer<T> {
    refuse(format!("no variable of type {kind} has the value reference {reference}"))
}

/// Refuses a saved state.
///
/// # Errors
/// Always.
pub fn damaged<T>(why: &str) -> Answer<T> {
    refuse(format!("the state is damaged or is not a state of this FMU: {why}"))
}

/// Returns the variables of FMI 3.0, by value reference.
fn rows_of_arrays<M: Model>() -> Vec<Row<M::Quantity>> {
    let other = |of, role| Row { quantity: None, element: 0, of, role, domain: Domain::Size };
    let sizes = M::SIZES.iter().map(|_| other(Type::Size, Role::Parameter));
    let arrays = M::VARIABLES.iter().map(|variable| Row::new(variable, 0));
    [other(Type::Real, Role::Calculated)].into_iter().chain(sizes).chain(arrays).collect()
}

/// Returns the structural parameters of FMI 3.0 for what is loaded.
fn sizes<M: Model>(model: &M, version: Version) -> Vec<u64> {
    let count = if version == Version::V3 { M::SIZES.len() } else { 0 };
    (0..count).map(|place| model.size(place)).collect()
}

/// Returns the versions of the format of states and of the model, in one number.
fn state_version<M: Model>() -> u32 {
    FORMAT << 16 | M::STATE_VERSION
}

const MAGIC: &[u8; 8] = b"LEMONSst";
/// Increased whenever [`Snapshot`] changes.
const FORMAT: u32 = 3;
/// Magic, version, token, length.
const HEADER: usize = 8 + 4 + 16 + 8;
