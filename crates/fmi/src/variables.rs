//! What an FMU's variables are: name, type, causality, unit, domain.

/// Causality, variability and `initial` of a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Input; it can be set at any time. A Real is continuous, all others are discrete.
    Input,
    /// Output whose start value can be set until initialization ends (`initial="exact"`).
    Exact,
    /// Output that the FMU computes (`initial="calculated"`).
    Calculated,
    /// Fixed parameter; it can be set until initialization ends.
    Parameter,
    /// Fixed, and computed from parameters.
    CalculatedParameter,
}

/// An FMI type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// `fmi2Real`, with its unit.
    Real(Unit),
    /// `fmi2Integer`
    Integer,
    /// `fmi2Boolean`; models give and take it as 0 or 1.
    Boolean,
    /// `fmi2String`
    String,
}

impl Kind {
    /// The FMI name.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Real(_) => "Real",
            Kind::Integer => "Integer",
            Kind::Boolean => "Boolean",
            Kind::String => "String",
        }
    }
}

/// A unit, with the exponents of its base units.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unit {
    /// The name that importers show.
    pub name: &'static str,
    /// Exponents of kg, m, s and rad.
    pub base: [i32; 4],
}

/// The units of this repository's FMUs.
#[allow(missing_docs)] // their names say it
pub mod units {
    use super::Unit;

    const fn unit(name: &'static str, kg: i32, m: i32, s: i32, rad: i32) -> Unit {
        Unit { name, base: [kg, m, s, rad] }
    }

    pub const NEWTON: Unit = unit("N", 1, 1, -2, 0);
    pub const NEWTON_METRE: Unit = unit("N.m", 1, 2, -2, 0);
    pub const METRE: Unit = unit("m", 0, 1, 0, 0);
    pub const RADIAN: Unit = unit("rad", 0, 0, 0, 1);
    pub const METRE_PER_SECOND: Unit = unit("m/s", 0, 1, -1, 0);
    pub const RADIAN_PER_SECOND: Unit = unit("rad/s", 0, 0, -1, 1);
    pub const SECOND: Unit = unit("s", 0, 0, 1, 0);
    pub const NEWTON_PER_METRE: Unit = unit("N/m", 1, 0, -2, 0);
    pub const KILOGRAM_PER_SECOND: Unit = unit("kg/s", 1, 0, -1, 0);
    pub const KILOGRAM: Unit = unit("kg", 1, 0, 0, 0);
    pub const KILOGRAM_METRE_SQUARED: Unit = unit("kg.m2", 1, 2, 0, 0);
    pub const PER_SECOND: Unit = unit("1/s", 0, 0, -1, 0);
    pub const ONE: Unit = unit("1", 0, 0, 0, 0);
}

/// The domain of a quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Domain {
    /// Any finite number.
    Finite,
    /// Finite and ≥ 0.
    NonNegative,
    /// Finite and > 0.
    Positive,
}

impl Domain {
    /// Checks that the number is in the domain.
    ///
    /// # Errors
    /// It is not. The text completes the message "must be …".
    pub fn check(self, value: f64) -> Result<(), &'static str> {
        match self {
            _ if !value.is_finite() => Err("finite"),
            Domain::Positive if value <= 0.0 => Err("positive"),
            Domain::NonNegative if value < 0.0 => Err("at least 0"),
            _ => Ok(()),
        }
    }
}

/// A variable that is one number or text; `Q` identifies the quantity of the model.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable<Q> {
    /// Structured name.
    pub name: String,
    /// The quantity of the model.
    pub quantity: Q,
    /// FMI type.
    pub kind: Kind,
    /// Causality, variability and `initial` in one.
    pub role: Role,
    /// The values that it can have.
    pub domain: Domain,
    /// Description for users.
    pub description: String,
}
