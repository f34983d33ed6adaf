//! The variables of an instance, read and set; their derivatives and dependencies.

use super::{Row, Slave};
use crate::Version;
use crate::answer::{Answer, discard, out_of_range, refuse};
use crate::lifecycle::{Function, Phase};
use crate::model::{Model, reference};
use crate::variables::{BaseType, Dependencies, Dimension, Known, Number, Role, Variable};

impl<M: Model> Slave<M> {
    #[inline]
    fn row(&self, reference: u32, of: BaseType) -> Answer<Row<M::Quantity>> {
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
        let Some(array) = self.array(reference) else { return Ok(1) };
        let mut length = usize::from(self.model.has(array.quantity));
        for dimension in array.dimensions {
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
    pub fn count(&self, references: &[u32], of: BaseType) -> Answer<usize> {
        let mut count = 0;
        for &reference in references {
            self.row(reference, of)?;
            count += self.length(reference)?;
        }
        Ok(count)
    }

    /// Checks types, and that the number of elements of all variables together is that of the
    /// values.
    fn check_count(&self, references: &[u32], of: BaseType, given: usize) -> Answer<()> {
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
    fn check_readable(&self, references: &[u32], of: BaseType) -> Answer<()> {
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
                None if N::TYPE == BaseType::Size => numbers[0] = self.sizes[reference as usize - 1] as f64,
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
        self.check_count(references, BaseType::String, count)?;
        self.check_readable(references, BaseType::String)?;
        let mut texts = Vec::with_capacity(count);
        for &reference in references {
            let Row { quantity: Some(quantity), element, .. } = self.row(reference, BaseType::String)? else {
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
            _ if row.of == BaseType::Size && self.phase == Phase::Configuration => return Ok(()),
            _ if row.of == BaseType::Size => "outside Configuration Mode",
            _ if self.phase == Phase::Configuration => "in Configuration Mode",
            Role::Input | Role::Tunable => return Ok(()),
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
                    let value = if matches!(of, BaseType::Integer | BaseType::Size) {
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
        self.check_count(references, BaseType::String, values.len())?;
        let mut texts = Vec::with_capacity(references.len());
        for (&reference, &value) in references.iter().zip(values) {
            let row = self.row(reference, BaseType::String)?;
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
        self.check_count(references, BaseType::Real, values.len())?;
        let mut found = Vec::with_capacity(values.len());
        for (&reference, &order) in references.iter().zip(orders) {
            let row = self.row(reference, BaseType::Real)?;
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
            let row = self.row(reference, BaseType::Real)?;
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
            let row = self.row(reference, BaseType::Real)?;
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
}

fn unknown_reference<T>(kind: &str, reference: u32) -> Answer<T> {
    refuse(format!("no variable of type {kind} has the value reference {reference}"))
}
