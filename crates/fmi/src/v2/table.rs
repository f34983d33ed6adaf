//! The table of the variables of an FMI 2.0 FMU. A variable's value reference is its place in the table.

use crate::token;
use crate::variables::Variable;
use uuid::Uuid;

/// Returns the GUID of the interface. It depends on names, types, value references and causalities only.
pub fn guid<Q>(table: &[Variable<Q>]) -> Uuid {
    let rows = table.iter().enumerate();
    token(rows.map(|(reference, variable)| {
        format!("{reference} {} {} {:?}\n", variable.name, variable.kind.name(), variable.role)
    }))
}
