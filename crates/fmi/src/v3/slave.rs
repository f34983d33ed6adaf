//! One FMI 3.0 instance: variables are arrays.

use super::arrays::{Array, ArrayModel, Dimension, Known, TIME, array_reference, size_reference, token};
use super::lifecycle;
use crate::lifecycle::{Function, Phase};
use crate::model::StepError;
use crate::slave::{self, Answer, BareKind, Interface, SlaveError, not_settable};
use crate::variables::Domain;
use uuid::Uuid;

/// One FMI 3.0 instance.
pub type Slave<M> = slave::Slave<M, Table<M>>;

/// Largest value of a structural parameter.
const MOST: u64 = 100_000_000;

/// The variables of an instance.
pub struct Table<M: ArrayModel> {
    arrays: Vec<Array<M::Block>>,
    /// The structural parameters as they were set.
    sizes: Vec<u64>,
}

impl<M: ArrayModel> Interface<M> for Table<M> {
    const TOKEN: &'static str = "instantiationToken";
    const LONGER_STATES: bool = false;

    fn of(model: &M) -> Table<M> {
        Table { arrays: M::arrays(), sizes: model.sizes() }
    }

    fn token(&self) -> Uuid {
        token::<M>()
    }

    fn allowed(function: Function) -> &'static [Phase] {
        lifecycle::allowed(function)
    }

    fn sizes(&self) -> &[u64] {
        &self.sizes
    }

    fn set_sizes(&mut self, sizes: &[u64]) -> bool {
        let possible = sizes.len() == self.sizes.len() && sizes.iter().all(|size| (1..=MOST).contains(size));
        if possible {
            self.sizes = sizes.to_vec();
        }
        possible
    }
}

fn name_of(kind: BareKind) -> &'static str {
    match kind {
        BareKind::Real => "Float64",
        BareKind::Integer => "Int32",
        BareKind::Boolean => "Boolean",
        BareKind::String => "String",
    }
}

/// What a value reference of type Float64 leads to.
enum Found<'a, B> {
    Time,
    Array(&'a Array<B>),
}

/// A part of a communication step that remains to be done.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Part {
    from: f64,
    length: f64,
    so_far: f64,
    at_end: Option<f64>,
    /// \[s\] the time when it is over.
    pub time: f64,
}

impl<M: ArrayModel> Slave<M> {
    /// `fmi3EnterConfigurationMode`
    ///
    /// # Errors
    /// Wrong phase.
    pub fn enter_configuration(&mut self) -> Answer<M, ()> {
        self.check(Function::EnterConfigurationMode)?;
        self.phase = Phase::Configuration;
        Ok(())
    }

    /// `fmi3ExitConfigurationMode`
    ///
    /// # Errors
    /// Wrong phase.
    pub fn exit_configuration(&mut self) -> Answer<M, ()> {
        self.check(Function::ExitConfigurationMode)?;
        self.phase = Phase::Instantiated;
        Ok(())
    }

    /// `fmi3EnterInitializationMode`: start time and, if given, stop time of the simulation \[s\], and tolerance.
    ///
    /// # Errors
    /// Wrong phase; times that are not finite or are in the wrong order; a tolerance that is not positive and finite.
    pub fn begin(&mut self, start: f64, stop: Option<f64>, tolerance: Option<f64>) -> Answer<M, ()> {
        self.check(Function::EnterInitializationMode)?;
        self.set_experiment(start, stop, tolerance)?;
        self.enter_initialization()
    }

    /// `fmi3ExitInitializationMode`
    ///
    /// # Errors
    /// Wrong phase; structural parameters that are not the sizes of what is loaded; values that do not fit together.
    pub fn end_initialization(&mut self) -> Answer<M, ()> {
        self.check(Function::ExitInitializationMode)?;
        (0..M::SIZES.len()).try_for_each(|size| self.check_size(size))?;
        self.exit_initialization()
    }

    /// Refuses a structural parameter that is not the size of what is loaded.
    fn check_size(&self, size: usize) -> Answer<M, ()> {
        let (declared, loaded) = (self.interface.sizes[size], self.model.sizes()[size]);
        if declared == loaded {
            return Ok(());
        }
        Err(SlaveError::Size { name: M::SIZES[size].name, declared, loaded })
    }

    fn found(&self, reference: u32, kind: BareKind) -> Answer<M, Found<'_, M::Block>> {
        let unknown = || SlaveError::UnknownReference { kind: name_of(kind), reference };
        if reference == TIME && kind == BareKind::Real {
            return Ok(Found::Time);
        }
        let place = reference.checked_sub(array_reference::<M>(0)).ok_or_else(unknown)?;
        let array = self.interface.arrays.get(place as usize);
        let array = array.filter(|array| BareKind::from(array.kind) == kind);
        Ok(Found::Array(array.ok_or_else(unknown)?))
    }

    fn array(&self, reference: u32, kind: BareKind) -> Answer<M, Array<M::Block>> {
        match self.found(reference, kind)? {
            Found::Array(array) => Ok(array.clone()),
            Found::Time => Err(SlaveError::NotSettable { name: "time".into(), when: "at all" }),
        }
    }

    /// The number of elements of an array, whose sizes must be those of what is loaded.
    fn length(&self, array: &Array<M::Block>) -> Answer<M, usize> {
        let mut length = 1;
        for dimension in array.dimensions {
            length *= match *dimension {
                Dimension::Fixed(size) => size as usize,
                Dimension::Size(place) => {
                    self.check_size(place)?;
                    self.interface.sizes[place] as usize
                }
            };
        }
        Ok(length)
    }

    /// The number of elements of all variables together must be that of the values.
    fn check_count(&self, references: &[u32], kind: BareKind, given: usize) -> Answer<M, ()> {
        let mut wanted = 0;
        for &reference in references {
            wanted += match self.found(reference, kind)? {
                Found::Time => 1,
                Found::Array(array) => self.length(array)?,
            };
        }
        if wanted == given { Ok(()) } else { Err(SlaveError::ValueCount { given, wanted: wanted as u64 }) }
    }

    /// `fmi3GetFloat64`
    ///
    /// # Errors
    /// Wrong phase, unknown references, a wrong number of values; in initialization, values that do not fit together.
    pub fn get_float64(&mut self, references: &[u32], values: &mut [f64]) -> Answer<M, ()> {
        self.check(Function::Get)?;
        self.check_count(references, BareKind::Real, values.len())?;
        let mut rest = values;
        for &reference in references {
            let (length, block) = match self.found(reference, BareKind::Real)? {
                Found::Time => (1, None),
                Found::Array(array) => (self.length(array)?, Some(array.block)),
            };
            let (these, others) = rest.split_at_mut(length);
            match block {
                None => these[0] = self.time(),
                Some(block) => self.model.read_reals(block, these)?,
            }
            rest = others;
        }
        Ok(())
    }

    /// `fmi3GetInt32`
    ///
    /// # Errors
    /// Those of [`Slave::get_float64`].
    pub fn get_int32(&mut self, references: &[u32], values: &mut [i32]) -> Answer<M, ()> {
        self.get_whole(references, BareKind::Integer, values)
    }

    /// `fmi3GetBoolean`: 0 or 1.
    ///
    /// # Errors
    /// Those of [`Slave::get_float64`].
    pub fn get_boolean(&mut self, references: &[u32], values: &mut [u8]) -> Answer<M, ()> {
        let mut whole = vec![0; values.len()];
        self.get_whole(references, BareKind::Boolean, &mut whole)?;
        values.iter_mut().zip(whole).for_each(|(value, whole)| *value = (whole != 0).into());
        Ok(())
    }

    fn get_whole(&mut self, references: &[u32], kind: BareKind, values: &mut [i32]) -> Answer<M, ()> {
        self.check(Function::Get)?;
        self.check_count(references, kind, values.len())?;
        let mut rest = values;
        for &reference in references {
            let array = self.array(reference, kind)?;
            let (these, others) = rest.split_at_mut(self.length(&array)?);
            self.model.read_integers(array.block, these)?;
            rest = others;
        }
        Ok(())
    }

    /// `fmi3GetString`
    ///
    /// # Errors
    /// Wrong phase, unknown references, a wrong number of values.
    pub fn get_string(&self, references: &[u32], count: usize) -> Answer<M, Vec<String>> {
        self.check(Function::Get)?;
        self.check_count(references, BareKind::String, count)?;
        let mut texts = Vec::with_capacity(count);
        for &reference in references {
            let array = self.array(reference, BareKind::String)?;
            texts.extend(self.model.texts(array.block).into_iter().map(str::to_owned));
        }
        Ok(texts)
    }

    /// `fmi3GetUInt64`: structural parameters.
    ///
    /// # Errors
    /// Those of [`Slave::get_string`].
    pub fn get_uint64(&self, references: &[u32], values: &mut [u64]) -> Answer<M, ()> {
        self.check(Function::Get)?;
        let places = self.size_places(references, values.len())?;
        for (value, place) in values.iter_mut().zip(places) {
            *value = self.interface.sizes[place];
        }
        Ok(())
    }

    /// `fmi3SetUInt64`: structural parameters, in Configuration Mode.
    ///
    /// # Errors
    /// Wrong phase, unknown references, a wrong number of values, or a value that is 0 or far too large. Then none of
    /// them is set.
    pub fn set_uint64(&mut self, references: &[u32], values: &[u64]) -> Answer<M, ()> {
        self.check(Function::Set)?;
        let places = self.size_places(references, values.len())?;
        for (&place, &value) in places.iter().zip(values) {
            let name = M::SIZES[place].name;
            if self.phase != Phase::Configuration {
                return Err(SlaveError::NotSettable {
                    name: name.into(),
                    when: "outside Configuration Mode",
                });
            }
            if !(1..=MOST).contains(&value) {
                return Err(SlaveError::SizeValue { name, value, most: MOST });
            }
        }
        for (&place, &value) in places.iter().zip(values) {
            self.interface.sizes[place] = value;
        }
        Ok(())
    }

    fn size_places(&self, references: &[u32], given: usize) -> Answer<M, Vec<usize>> {
        let place = |&reference: &u32| {
            let place = reference.checked_sub(size_reference(0)).map(|place| place as usize);
            let unknown = SlaveError::UnknownReference { kind: "UInt64", reference };
            place.filter(|place| *place < M::SIZES.len()).ok_or(unknown)
        };
        let places = references.iter().map(place).collect::<Answer<M, Vec<usize>>>()?;
        if places.len() != given {
            return Err(SlaveError::ValueCount { given, wanted: places.len() as u64 });
        }
        Ok(places)
    }

    /// Refuses variables that cannot be set in this phase.
    fn check_settable(&self, array: &Array<M::Block>) -> Answer<M, ()> {
        let configuring = self.phase == Phase::Configuration;
        let when =
            if configuring { Some("in Configuration Mode") } else { not_settable(array.role, self.phase) };
        when.map_or(Ok(()), |when| Err(SlaveError::NotSettable { name: array.name.into(), when }))
    }

    /// `fmi3SetFloat64`
    ///
    /// # Errors
    /// Wrong phase, unknown references, a wrong number of values, or values outside their domain. Then none of them is
    /// set.
    pub fn set_float64(&mut self, references: &[u32], values: &[f64]) -> Answer<M, ()> {
        self.check(Function::Set)?;
        self.check_count(references, BareKind::Real, values.len())?;
        let mut arrays = Vec::with_capacity(references.len());
        let mut rest = values;
        for &reference in references {
            let array = self.array(reference, BareKind::Real)?;
            self.check_settable(&array)?;
            let (these, others) = rest.split_at(self.length(&array)?);
            check_domain(&array, these)?;
            self.model.check_reals(array.block, these)?;
            arrays.push((array.block, these));
            rest = others;
        }
        for (block, these) in arrays {
            self.model.write_reals(block, these, self.phase);
        }
        Ok(())
    }

    /// `fmi3SetInt32`
    ///
    /// # Errors
    /// Those of [`Slave::set_float64`].
    pub fn set_int32(&mut self, references: &[u32], values: &[i32]) -> Answer<M, ()> {
        self.set_whole(references, BareKind::Integer, values)
    }

    /// `fmi3SetBoolean`: everything but 0 is true.
    ///
    /// # Errors
    /// Those of [`Slave::set_float64`].
    pub fn set_boolean(&mut self, references: &[u32], values: &[u8]) -> Answer<M, ()> {
        let whole: Vec<i32> = values.iter().map(|value| (*value != 0).into()).collect();
        self.set_whole(references, BareKind::Boolean, &whole)
    }

    fn set_whole(&mut self, references: &[u32], kind: BareKind, values: &[i32]) -> Answer<M, ()> {
        self.check(Function::Set)?;
        self.check_count(references, kind, values.len())?;
        let mut arrays = Vec::with_capacity(references.len());
        let mut rest = values;
        for &reference in references {
            let array = self.array(reference, kind)?;
            self.check_settable(&array)?;
            let (these, others) = rest.split_at(self.length(&array)?);
            for (element, &value) in these.iter().enumerate() {
                array.domain.check(value.into()).map_err(|must| SlaveError::Value {
                    name: element_name(&array, element),
                    value: value.to_string(),
                    must,
                })?;
            }
            arrays.push((array.block, these));
            rest = others;
        }
        for (block, these) in arrays {
            self.model.write_integers(block, these, self.phase);
        }
        Ok(())
    }

    /// `fmi3SetString`
    ///
    /// # Errors
    /// Those of [`Slave::set_float64`]; a text is not a value of its variable.
    pub fn set_string(&mut self, references: &[u32], values: &[&str]) -> Answer<M, ()> {
        self.check(Function::Set)?;
        self.check_count(references, BareKind::String, values.len())?;
        let mut texts = Vec::with_capacity(references.len());
        for (&reference, &value) in references.iter().zip(values) {
            let array = self.array(reference, BareKind::String)?;
            self.check_settable(&array)?;
            texts.push((array.block, value));
        }
        Ok(self.model.write_texts(&texts)?)
    }

    /// `fmi3GetOutputDerivatives`: derivatives with respect to time, of order 1.
    ///
    /// # Errors
    /// Wrong phase, unknown references, a wrong number of values, other orders, or variables whose derivative is not
    /// known.
    pub fn get_output_derivatives(
        &self,
        references: &[u32],
        orders: &[i32],
        values: &mut [f64],
    ) -> Answer<M, ()> {
        self.check(Function::GetOutputDerivatives)?;
        self.check_count(references, BareKind::Real, values.len())?;
        let mut found = vec![0.0; values.len()];
        let mut rest = &mut found[..];
        for (&reference, &order) in references.iter().zip(orders) {
            let array = self.array(reference, BareKind::Real)?;
            if order != 1 {
                return Err(SlaveError::OutputOrder { name: array.name.into(), order });
            }
            let (these, others) = rest.split_at_mut(self.length(&array)?);
            if !self.model.read_derivatives(array.block, these) {
                return Err(SlaveError::NoDerivative { name: array.name.into() });
            }
            rest = others;
        }
        values.copy_from_slice(&found);
        Ok(())
    }

    /// `fmi3GetVariableDependencies`: of the elements of an output, as indices from 0, the value reference of the
    /// variable on which each depends, and the index of its element. Until initialization ends, the initial dependencies
    /// (FMI 3.0, section 2.2.9).
    ///
    /// # Errors
    /// Wrong phase or an unknown reference.
    pub fn dependencies(&self, reference: u32) -> Answer<M, Vec<(usize, u32, usize)>> {
        self.check(Function::GetVariableDependencies)?;
        let place = reference.checked_sub(array_reference::<M>(0)).map(|place| place as usize);
        let Some(array) = place.and_then(|place| self.interface.arrays.get(place)) else {
            let known = reference < array_reference::<M>(0);
            let unknown = SlaveError::UnknownReference { kind: "any", reference };
            return if known { Ok(Vec::new()) } else { Err(unknown) };
        };
        let reference_of = |block: M::Block| {
            let place = self.interface.arrays.iter().position(|array| array.block == block);
            place.map(array_reference::<M>)
        };
        let known = match self.phase {
            Phase::Instantiated | Phase::Configuration | Phase::Initialization => Known::InputsAndParameters,
            _ => Known::Inputs,
        };
        let many = "each element depends on those of all agents, which are too many to be listed";
        let dependencies =
            self.model.dependencies(array.block, known).ok_or(SlaveError::Unsupported(many))?;
        let dependencies = dependencies.into_iter();
        Ok(dependencies.filter_map(|on| Some((on.dependent, reference_of(on.on)?, on.element))).collect())
    }

    /// The parts of a communication step from `from` of a length `step`, both \[s\].
    ///
    /// # Errors
    /// Those of [`slave::Slave::do_step`], before anything is changed.
    pub(crate) fn parts(&self, from: f64, step: f64, wanted: bool) -> Answer<M, Vec<Part>> {
        self.check(Function::DoStep)?;
        self.check_step(from, step)?;
        let lengths = if wanted { self.model.parts(step) } else { vec![step] };
        let (mut so_far, last) = (0.0, lengths.len() - 1);
        let part = |(k, length): (usize, f64)| {
            let at_end = (k == last).then_some(from + step);
            let part = Part { from, length, so_far, at_end, time: at_end.unwrap_or(from + so_far + length) };
            so_far += length;
            part
        };
        Ok(lengths.into_iter().enumerate().map(part).collect())
    }

    /// Does a part of a communication step.
    ///
    /// # Errors
    /// The model refuses the first part, and nothing has changed; or it fails, and the slave is in the error state.
    pub(crate) fn do_part(&mut self, part: &Part) -> Answer<M, ()> {
        match self.model.advance_part(part.from, part.length, part.so_far, part.at_end) {
            Ok(()) => {
                self.set_time(part.time);
                Ok(())
            }
            Err(StepError::Refused(error)) if part.so_far == 0.0 => Err(error.into()),
            Err(StepError::Refused(error) | StepError::Failed(error)) => {
                self.phase = Phase::Error;
                Err(error.into())
            }
        }
    }

    /// Whether the importer's callback runs.
    pub(crate) fn set_intermediate(&mut self, intermediate: bool) {
        self.phase = if intermediate { Phase::Intermediate } else { Phase::StepComplete };
    }
}

fn element_name<B>(array: &Array<B>, element: usize) -> String {
    if array.dimensions.is_empty() { array.name.to_owned() } else { format!("{}[{element}]", array.name) }
}

fn check_domain<B, E>(array: &Array<B>, values: &[f64]) -> Result<(), SlaveError<E>> {
    // Most arrays are large and may have any finite number.
    if array.domain == Domain::Finite && values.iter().all(|value| value.is_finite()) {
        return Ok(());
    }
    for (element, &value) in values.iter().enumerate() {
        array.domain.check(value).map_err(|must| SlaveError::Value {
            name: element_name(array, element),
            value: format!("{value:?}"),
            must,
        })?;
    }
    Ok(())
}
