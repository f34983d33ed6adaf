//! The variables as rows of a table in `documentation/index.html`.

use super::arrays::{ArrayModel, Dimension};
use crate::variables::{Kind, Role};
use lemons_core::xml::escaped;

/// Returns a row of HTML for each array: name with sizes, causality, unit, description.
pub fn rows<M: ArrayModel>() -> String {
    let row = |array: &super::Array<M::Block>| {
        let sizes = array.dimensions.iter().map(|dimension| match *dimension {
            Dimension::Size(place) => format!("[{}]", M::SIZES[place].name),
            Dimension::Fixed(size) => format!("[{size}]"),
        });
        let kind = match array.role {
            Role::Input => "input",
            Role::Exact => "output; start settable",
            Role::Calculated => "output",
            Role::Parameter => "parameter",
            Role::CalculatedParameter => "calculated parameter",
        };
        let unit = if let Kind::Real(unit) = array.kind { unit.name } else { "" };
        let (name, sizes, description) = (array.name, sizes.collect::<String>(), escaped(array.description));
        format!(
            "<tr><td><code>{name}</code> {sizes}</td><td>{kind}</td><td>{unit}</td><td>{description}</td></tr>\n"
        )
    };
    M::arrays().iter().map(row).collect()
}
