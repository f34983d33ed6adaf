//! Units in model descriptions.

use crate::variables::{Kind, Unit};
use lemons_core::xml::Out;

/// Returns the units of variables, in the order of their first use.
pub(crate) fn units_of(kinds: impl IntoIterator<Item = Kind>) -> Vec<Unit> {
    let mut units = Vec::new();
    for kind in kinds {
        if let Kind::Real(unit) = kind
            && !units.contains(&unit)
        {
            units.push(unit);
        }
    }
    units
}

pub(crate) fn write_unit(out: &mut Out, unit: &Unit) {
    let base = ["kg", "m", "s", "rad"].iter().zip(unit.base).filter(|&(_, exponent)| exponent != 0);
    let base: Vec<(&str, String)> = base.map(|(name, exponent)| (*name, exponent.to_string())).collect();
    let base: Vec<(&str, &str)> = base.iter().map(|(name, exponent)| (*name, exponent.as_str())).collect();
    out.element("Unit", &[("name", unit.name)], |out| out.empty("BaseUnit", &base));
}
