//! One FMI 2.0 instance: a variable for each number.

use super::lifecycle;
use super::table::guid;
use crate::lifecycle::{Function, Phase};
use crate::model::Model;
use crate::slave::{self, Answer, BareKind, Interface, Row, SlaveError, not_settable};
use crate::variables::{Role, Variable};
use uuid::Uuid;

/// One FMI 2.0 instance.
pub type Slave<M> = slave::Slave<M, Table<M>>;

/// The variables of an instance. A value reference is a place in this table.
pub struct Table<M: Model> {
    variables: Vec<Variable<M::Quantity>>,
    /// The rows of `variables`.
    rows: Vec<Row<M::Quantity>>,
}

impl<M: Model> Interface<M> for Table<M> {
    const TOKEN: &'static str = "GUID";
    const LONGER_STATES: bool = true;

    fn of(model: &M) -> Table<M> {
        let variables = model.table();
        let row = |variable: &Variable<M::Quantity>| Row {
            quantity: variable.quantity,
            kind: variable.kind.into(),
            role: variable.role,
            domain: variable.domain,
        };
        let rows = variables.iter().map(row).collect();
        Table { variables, rows }
    }

    fn token(&self) -> Uuid {
        guid(&self.variables)
    }

    fn allowed(function: Function) -> &'static [Phase] {
        lifecycle::allowed(function)
    }
}

fn name_of(kind: BareKind) -> &'static str {
    match kind {
        BareKind::Real => "Real",
        BareKind::Integer => "Integer",
        BareKind::Boolean => "Boolean",
        BareKind::String => "String",
    }
}

impl<M: Model> Slave<M> {
    #[inline]
    fn row(&self, reference: u32, kind: BareKind) -> Answer<M, Row<M::Quantity>> {
        match self.interface.rows.get(reference as usize) {
            Some(row) if row.kind == kind => Ok(*row),
            _ => Err(SlaveError::UnknownReference { kind: name_of(kind), reference }),
        }
    }

    /// For messages about a variable of the table.
    #[cold]
    fn name(&self, reference: u32) -> String {
        self.interface.variables[reference as usize].name.clone()
    }

    /// `fmi2GetReal`
    ///
    /// # Errors
    /// Wrong phase or unknown references; in initialization, values that do not fit together.
    pub fn get_real(&mut self, references: &[u32], values: &mut [f64]) -> Answer<M, ()> {
        self.check(Function::Get)?;
        for (&reference, value) in references.iter().zip(values) {
            let quantity = self.row(reference, BareKind::Real)?.quantity;
            *value = self.model.real(quantity)?;
        }
        Ok(())
    }

    /// `fmi2GetInteger`
    ///
    /// # Errors
    /// Those of [`Slave::get_real`].
    pub fn get_integer(&mut self, references: &[u32], values: &mut [i32]) -> Answer<M, ()> {
        self.get_whole(references, BareKind::Integer, values)
    }

    /// `fmi2GetBoolean`: 0 or 1.
    ///
    /// # Errors
    /// Those of [`Slave::get_real`].
    pub fn get_boolean(&mut self, references: &[u32], values: &mut [i32]) -> Answer<M, ()> {
        self.get_whole(references, BareKind::Boolean, values)
    }

    fn get_whole(&mut self, references: &[u32], kind: BareKind, values: &mut [i32]) -> Answer<M, ()> {
        self.check(Function::Get)?;
        for (&reference, value) in references.iter().zip(values) {
            let quantity = self.row(reference, kind)?.quantity;
            *value = self.model.integer(quantity)?;
        }
        Ok(())
    }

    /// `fmi2GetString`
    ///
    /// # Errors
    /// Wrong phase, unknown references.
    pub fn get_string(&self, references: &[u32]) -> Answer<M, Vec<&str>> {
        self.check(Function::Get)?;
        let texts = references.iter().map(|&reference| {
            let quantity = self.row(reference, BareKind::String)?.quantity;
            Ok(self.model.string(quantity))
        });
        texts.collect()
    }

    /// Refuses to set variables that cannot be set in this phase.
    #[inline]
    fn check_settable(&self, reference: u32, role: Role) -> Answer<M, ()> {
        match not_settable(role, self.phase) {
            None => Ok(()),
            Some(when) => Err(SlaveError::NotSettable { name: self.name(reference), when }),
        }
    }

    #[inline]
    fn check_number(&self, reference: u32, kind: BareKind, value: f64) -> Answer<M, ()> {
        let row = self.row(reference, kind)?;
        self.check_settable(reference, row.role)?;
        row.domain.check(value).map_err(|must| SlaveError::Value {
            name: self.name(reference),
            value: if kind == BareKind::Integer { format!("{value:.0}") } else { format!("{value:?}") },
            must,
        })
    }

    /// `fmi2SetReal`
    ///
    /// # Errors
    /// Wrong phase, unknown references, or values outside their domain. Then none of them is set.
    pub fn set_real(&mut self, references: &[u32], values: &[f64]) -> Answer<M, ()> {
        self.check(Function::Set)?;
        for (&reference, &value) in references.iter().zip(values) {
            self.check_number(reference, BareKind::Real, value)?;
        }
        for (&reference, &value) in references.iter().zip(values) {
            let quantity = self.interface.rows[reference as usize].quantity;
            self.model.set_real(quantity, value, self.phase);
        }
        Ok(())
    }

    /// `fmi2SetInteger`
    ///
    /// # Errors
    /// Those of [`Slave::set_real`].
    pub fn set_integer(&mut self, references: &[u32], values: &[i32]) -> Answer<M, ()> {
        self.check(Function::Set)?;
        for (&reference, &value) in references.iter().zip(values) {
            self.check_number(reference, BareKind::Integer, value.into())?;
        }
        for (&reference, &value) in references.iter().zip(values) {
            let quantity = self.interface.rows[reference as usize].quantity;
            self.model.set_integer(quantity, value, self.phase);
        }
        Ok(())
    }

    /// `fmi2SetBoolean`: everything but 0 is true.
    ///
    /// # Errors
    /// Those of [`Slave::set_real`].
    pub fn set_boolean(&mut self, references: &[u32], values: &[i32]) -> Answer<M, ()> {
        self.check(Function::Set)?;
        for &reference in references {
            let role = self.row(reference, BareKind::Boolean)?.role;
            self.check_settable(reference, role)?;
        }
        for (&reference, &value) in references.iter().zip(values) {
            let quantity = self.interface.rows[reference as usize].quantity;
            self.model.set_integer(quantity, (value != 0).into(), self.phase);
        }
        Ok(())
    }

    /// `fmi2SetString`
    ///
    /// # Errors
    /// Those of [`Slave::set_real`]; a text is not a value of its variable.
    pub fn set_string(&mut self, references: &[u32], values: &[&str]) -> Answer<M, ()> {
        self.check(Function::Set)?;
        let mut texts = Vec::with_capacity(references.len());
        for (&reference, &value) in references.iter().zip(values) {
            let row = self.row(reference, BareKind::String)?;
            self.check_settable(reference, row.role)?;
            texts.push((row.quantity, value));
        }
        Ok(self.model.set_strings(&texts)?)
    }

    /// `fmi2GetRealOutputDerivatives`: derivatives with respect to time, of order 1.
    ///
    /// # Errors
    /// Wrong phase, unknown references, other orders, or variables whose derivative is not known. Then the values are
    /// unchanged.
    pub fn get_output_derivatives(
        &self,
        references: &[u32],
        orders: &[i32],
        values: &mut [f64],
    ) -> Answer<M, ()> {
        self.check(Function::GetOutputDerivatives)?;
        let derivative = |(&reference, &order): (&u32, &i32)| {
            let row = self.row(reference, BareKind::Real)?;
            if order != 1 {
                return Err(SlaveError::OutputOrder { name: self.name(reference), order });
            }
            let found = self.model.derivative(row.quantity);
            found.ok_or_else(|| SlaveError::NoDerivative { name: self.name(reference) })
        };
        let found = references.iter().zip(orders).map(derivative).collect::<Answer<M, Vec<f64>>>()?;
        values.copy_from_slice(&found);
        Ok(())
    }

    /// `fmi2SetRealInputDerivatives`: over the next step the inputs vary linearly, at these rates per
    /// second, from their values at its start. A rate is used for one step.
    ///
    /// # Errors
    /// Wrong phase, unknown references, variables that are not inputs, orders other than 1, rates that are not finite,
    /// or a model that does not interpolate inputs. Then nothing is set.
    pub fn set_input_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &[f64],
    ) -> Answer<M, ()> {
        self.check(Function::SetInputDerivatives)?;
        if !M::INTERPOLATES_INPUTS {
            let why = "canInterpolateInputs is false: inputs are held over a step";
            return Err(SlaveError::Unsupported(why));
        }
        for ((&reference, &order), &value) in references.iter().zip(orders).zip(values) {
            let row = self.row(reference, BareKind::Real)?;
            if row.role != Role::Input {
                return Err(SlaveError::NoInput { name: self.name(reference) });
            }
            if order != 1 {
                return Err(SlaveError::Order { name: self.name(reference), order });
            }
            if !value.is_finite() {
                let name = format!("the derivative of {}", self.name(reference));
                return Err(SlaveError::Value { name, value: format!("{value:?}"), must: "finite" });
            }
        }
        for (&reference, &value) in references.iter().zip(values) {
            self.model.set_rate(self.interface.rows[reference as usize].quantity, value);
        }
        Ok(())
    }
}
