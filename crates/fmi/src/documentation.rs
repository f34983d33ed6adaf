//! The table of a model as HTML.

use crate::Version;
use crate::description::present;
use crate::model::{Model, guid, instantiation_token};
use crate::variables::{Dimension, Role, Variable, VariableType};
use lemons_core::xml::escaped;

/// Returns `documentation/index.html`: a text about the version, filled in, and the table of
/// variables.
pub fn documentation<M: Model>(model: &M, version: Version, text: &str, agents: usize) -> String {
    let token = match version {
        Version::V2 => guid(&model.scalars()),
        Version::V3 => instantiation_token::<M>(),
    };
    include_str!("page.html")
        .replace("{text}", text)
        .replace("{name}", M::NAME)
        .replace("{version}", env!("CARGO_PKG_VERSION"))
        .replace("{agents}", &agents.to_string())
        .replace("{last}", &agents.saturating_sub(1).to_string())
        .replace("{token}", &token.braced().to_string())
        .replace("{variables}", &rows_html(model, version))
}

/// Returns a row of HTML for each variable: name, causality, unit, description. In FMI 3.0 names
/// have sizes; in FMI 2.0 those of the first element stand for all.
fn rows_html<M: Model>(model: &M, version: Version) -> String {
    let scalars = if version == Version::V2 { model.scalars() } else { Vec::new() };
    let row = |variable: &Variable<M::Quantity>| {
        let sizes = variable.dimensions.iter().map(|dimension| match *dimension {
            Dimension::Size(place) => format!("[{}]", M::SIZES[place].name),
            Dimension::Fixed(size) => format!("[{size}]"),
        });
        let name = match version {
            Version::V2 => {
                let first = scalars.iter().find(|scalar| scalar.variable.quantity == variable.quantity)?;
                let name = escaped(&first.name);
                let other = if variable.is_vector() { ", <code>.y</code>" } else { "" };
                format!("<code>{name}</code>{other}")
            }
            Version::V3 => format!("<code>{}</code> {}", variable.name, sizes.collect::<String>()),
        };
        let kind = match variable.role {
            Role::Input => "input",
            Role::Exact => "output; start settable",
            Role::Calculated => "output",
            Role::Parameter => "parameter",
            Role::Tunable => "tunable parameter",
            Role::CalculatedParameter => "calculated parameter",
        };
        let unit = if let VariableType::Real(of) = variable.kind { of.unit.name } else { "" };
        let about = model.about(variable);
        let description = escaped(&about);
        Some(format!("<tr><td>{name}</td><td>{kind}</td><td>{unit}</td><td>{description}</td></tr>\n"))
    };
    present(model).filter_map(row).collect()
}
