//! The variables of an FMU: name, type, causality, unit, domain, sizes. A model has one table of
//! them.

use crate::Version;
use std::borrow::Cow;

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
    /// Tunable parameter; it can also be set between steps.
    Tunable,
    /// Fixed, and computed from parameters.
    CalculatedParameter,
}

/// An FMI type.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum VariableType {
    /// Real or Float64, with what it measures.
    Real(RealType),
    /// Integer or Int32; models give and take whole numbers.
    Integer,
    /// Boolean; models give and take 0 or 1.
    Boolean,
    /// String
    String,
}

impl Role {
    /// Returns whether it is a parameter that can be set.
    pub fn is_parameter(self) -> bool {
        matches!(self, Role::Parameter | Role::Tunable)
    }

    /// Returns what tokens of interfaces hold of it: the causality, and what can be set at the start.
    pub(crate) fn in_tokens(self) -> Role {
        if self == Role::Tunable { Role::Parameter } else { self }
    }
}

impl VariableType {
    /// Returns the type's name in FMI 2.0.
    pub fn name(self) -> &'static str {
        BaseType::from(self).name(Version::V2)
    }
}

/// A [`VariableType`] without what it measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // FMI's own names
pub enum BaseType {
    Real,
    Integer,
    Boolean,
    String,
    /// A structural parameter of FMI 3.0.
    Size,
}

impl BaseType {
    /// Returns the name in a version of FMI.
    pub fn name(self, version: Version) -> &'static str {
        let [of_2, of_3] = match self {
            BaseType::Real => ["Real", "Float64"],
            BaseType::Integer => ["Integer", "Int32"],
            BaseType::Boolean => ["Boolean", "Boolean"],
            BaseType::String => ["String", "String"],
            BaseType::Size => ["", "UInt64"],
        };
        if version == Version::V2 { of_2 } else { of_3 }
    }
}

impl From<VariableType> for BaseType {
    fn from(kind: VariableType) -> BaseType {
        match kind {
            VariableType::Real(_) => BaseType::Real,
            VariableType::Integer => BaseType::Integer,
            VariableType::Boolean => BaseType::Boolean,
            VariableType::String => BaseType::String,
        }
    }
}

/// A type of C for numbers of an FMI type.
pub trait Number: Copy {
    /// The FMI type.
    const TYPE: BaseType;

    /// Converts a number of a model.
    fn of(number: f64) -> Self;

    /// Converts numbers for a model.
    fn numbers(values: &[Self]) -> Cow<'_, [f64]>;
}

impl Number for f64 {
    const TYPE: BaseType = BaseType::Real;

    fn of(number: f64) -> f64 {
        number
    }

    fn numbers(values: &[f64]) -> Cow<'_, [f64]> {
        Cow::Borrowed(values)
    }
}

impl Number for i32 {
    const TYPE: BaseType = BaseType::Integer;

    fn of(number: f64) -> i32 {
        number as i32
    }

    fn numbers(values: &[i32]) -> Cow<'_, [f64]> {
        values.iter().map(|value| f64::from(*value)).collect()
    }
}

impl Number for u64 {
    const TYPE: BaseType = BaseType::Size;

    fn of(number: f64) -> u64 {
        number as u64
    }

    fn numbers(values: &[u64]) -> Cow<'_, [f64]> {
        values.iter().map(|value| *value as f64).collect()
    }
}

impl Number for bool {
    const TYPE: BaseType = BaseType::Boolean;

    fn of(number: f64) -> bool {
        number != 0.0
    }

    fn numbers(values: &[bool]) -> Cow<'_, [f64]> {
        values.iter().map(|value| f64::from(*value)).collect()
    }
}

/// A Boolean as importers write it: 0, or anything else for true.
#[derive(Clone, Copy)]
#[repr(transparent)]
pub struct Flag<T>(T);

impl<T: Copy + Default + From<bool> + PartialEq> Number for Flag<T> {
    const TYPE: BaseType = BaseType::Boolean;

    fn of(number: f64) -> Flag<T> {
        Flag((number != 0.0).into())
    }

    fn numbers(values: &[Flag<T>]) -> Cow<'_, [f64]> {
        values.iter().map(|value| f64::from(value.0 != T::default())).collect()
    }
}

/// A unit, with the exponents of its base units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// The name that importers show.
    pub name: &'static str,
    /// Exponents of kg, m, s and rad.
    pub base: [i32; 4],
    /// A unit that people prefer to read, and how many of it one unit has.
    pub display: Option<(&'static str, f64)>,
}

/// The units of this repository's FMUs.
#[allow(missing_docs)] // their names say it
pub mod units {
    use super::Unit;

    const fn unit(name: &'static str, kg: i32, m: i32, s: i32, rad: i32) -> Unit {
        Unit { name, base: [kg, m, s, rad], display: None }
    }

    impl Unit {
        const fn shown_in(self, name: &'static str, factor: f64) -> Unit {
            Unit { display: Some((name, factor)), ..self }
        }
    }

    pub const NEWTON: Unit = unit("N", 1, 1, -2, 0).shown_in("kN", 1e-3);
    pub const NEWTON_METRE: Unit = unit("N.m", 1, 2, -2, 0);
    pub const METRE: Unit = unit("m", 0, 1, 0, 0).shown_in("mm", 1e3);
    pub const RADIAN: Unit = unit("rad", 0, 0, 0, 1).shown_in("deg", DEGREES);
    pub const METRE_PER_SECOND: Unit = unit("m/s", 0, 1, -1, 0);
    pub const RADIAN_PER_SECOND: Unit = unit("rad/s", 0, 0, -1, 1).shown_in("deg/s", DEGREES);
    pub const SECOND: Unit = unit("s", 0, 0, 1, 0);
    pub const NEWTON_PER_METRE: Unit = unit("N/m", 1, 0, -2, 0);
    pub const KILOGRAM_PER_SECOND: Unit = unit("kg/s", 1, 0, -1, 0);
    pub const KILOGRAM: Unit = unit("kg", 1, 0, 0, 0);
    pub const KILOGRAM_METRE_SQUARED: Unit = unit("kg.m2", 1, 2, 0, 0);
    pub const PER_SQUARE_METRE: Unit = unit("1/m2", 0, -2, 0, 0);
    pub const PER_SECOND: Unit = unit("1/s", 0, 0, -1, 0);
    pub const ONE: Unit = unit("1", 0, 0, 0, 0);

    const DEGREES: f64 = 180.0 / std::f64::consts::PI;
}

/// Quantity that a Real measures: a type definition, to which variables refer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RealType {
    /// The name. It begins with a small letter, so it is not a variable's, as FMI wants.
    pub name: &'static str,
    /// The physical quantity, by its name in the Modelica library.
    pub quantity: &'static str,
    /// The unit.
    pub unit: Unit,
    /// Whether importers shall show it in the unit that people prefer.
    pub is_displayed: bool,
    /// Where all values of all variables are; a variable's own domain may be narrower.
    pub domain: Domain,
    /// A usual magnitude, to which tolerances of importers relate.
    pub nominal: f64,
}

/// The types of this repository's FMUs.
#[allow(missing_docs)] // their names say it
pub mod types {
    use super::Domain::{self, Finite, NonNegative, Positive};
    use super::{RealType, Unit, units::*};

    const fn of(
        name: &'static str,
        quantity: &'static str,
        unit: Unit,
        domain: Domain,
        nominal: f64,
    ) -> RealType {
        RealType { name, quantity, unit, is_displayed: false, domain, nominal }
    }

    impl RealType {
        const fn displayed(self) -> RealType {
            RealType { is_displayed: true, ..self }
        }
    }

    pub const POSITION: RealType = of("position", "Length", METRE, Finite, 1.0);
    pub const DISTANCE: RealType = of("distance", "Length", METRE, NonNegative, 1.0);
    /// A millimetre is what some hundred newtons press in.
    pub const OVERLAP: RealType = of("overlap", "Length", METRE, NonNegative, 1e-3).displayed();
    pub const ANGLE: RealType = of("angle", "Angle", RADIAN, Finite, 1.0).displayed();
    pub const VELOCITY: RealType = of("velocity", "Velocity", METRE_PER_SECOND, Finite, 1.0);
    pub const ANGULAR_VELOCITY: RealType =
        of("angularVelocity", "AngularVelocity", RADIAN_PER_SECOND, Finite, 1.0).displayed();
    pub const FORCE: RealType = of("force", "Force", NEWTON, Finite, 1e3);
    /// A magnitude of normal forces.
    pub const NORMAL_FORCE: RealType = of("normalForce", "Force", NEWTON, NonNegative, 1e3).displayed();
    /// A force over the length of a wall.
    pub const LINE_LOAD: RealType = of("lineLoad", "ForcePerLength", NEWTON_PER_METRE, Finite, 1e3);
    pub const TORQUE: RealType = of("torque", "Torque", NEWTON_METRE, Finite, 100.0);
    pub const MASS: RealType = of("mass", "Mass", KILOGRAM, Positive, 100.0);
    pub const INERTIA: RealType = of("inertia", "MomentOfInertia", KILOGRAM_METRE_SQUARED, Positive, 1.0);
    /// A relaxation rate.
    pub const RATE: RealType = of("rate", "DampingCoefficient", PER_SECOND, NonNegative, 1.0);
    /// Of two dimensions.
    pub const MODULUS: RealType = of("modulus", "Stress2D", NEWTON_PER_METRE, Positive, 1e6);
    pub const DAMPING: RealType =
        of("damping", "TranslationalDampingConstant", KILOGRAM_PER_SECOND, NonNegative, 1e3);
    pub const FRICTION: RealType = of("friction", "CoefficientOfFriction", ONE, NonNegative, 1.0);
    pub const DURATION: RealType = of("duration", "Time", SECOND, NonNegative, 1.0);
    /// People over time.
    pub const FLOW: RealType = of("flow", "Frequency", PER_SECOND, NonNegative, 1.0);
    /// People over an area.
    pub const DENSITY: RealType = of("density", "NumberPerArea", PER_SQUARE_METRE, NonNegative, 1.0);
    pub const FACTOR: RealType = of("factor", "Factor", ONE, NonNegative, 1.0);
    /// A force of a person who pushes: some ten newtons to some hundred.
    pub const PUSH: RealType = of("push", "Force", NEWTON, NonNegative, 100.0);
    pub const COUNT: RealType = of("count", "Count", ONE, Positive, 1.0);
}

/// The domain of a quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Domain {
    /// Any finite number.
    Finite,
    /// Finite and ≥ 0.
    NonNegative,
    /// From 0 to this.
    UpTo(u32),
    /// Finite and > 0; of a Real, not less than the least number of full precision.
    Positive,
    /// The number of elements along a dimension.
    Size,
}

/// Largest value of a structural parameter.
pub(crate) const MOST: u64 = 100_000_000;

impl Domain {
    /// Returns the least and the greatest value that a description declares, where the type has further ones.
    pub fn bounds(self, of: BaseType) -> [Option<f64>; 2] {
        match self {
            Domain::Finite => [None, None],
            Domain::NonNegative => [Some(0.0), None],
            Domain::UpTo(most) => [Some(0.0), Some(most.into())],
            Domain::Positive if of == BaseType::Real => [Some(f64::MIN_POSITIVE), None],
            Domain::Positive => [Some(1.0), None],
            Domain::Size => [Some(1.0), Some(MOST as f64)],
        }
    }

    /// Checks that the number is in the domain.
    ///
    /// # Errors
    /// It is not. The text completes the message "must be …".
    pub fn check(self, value: f64) -> Result<(), Cow<'static, str>> {
        Err(match self {
            Domain::UpTo(most) if !(0.0..=most.into()).contains(&value) => format!("from 0 to {most}").into(),
            _ if !value.is_finite() => "finite".into(),
            Domain::Positive if value <= 0.0 => "positive".into(),
            Domain::Positive if value < f64::MIN_POSITIVE => "at least 2.2250738585072014e-308".into(),
            Domain::NonNegative if value < 0.0 => "at least 0".into(),
            Domain::Size if !(1.0..=MOST as f64).contains(&value) => {
                "at least 1 and at most 100000000".into()
            }
            _ => return Ok(()),
        })
    }
}

/// A structural parameter: a number of things of which arrays have one element each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size {
    /// Name of the variable.
    pub name: &'static str,
    /// Description for users.
    pub description: &'static str,
    /// Whether it may be 0: then there are no arrays of this size.
    pub optional: bool,
}

impl Size {
    /// Makes a size of at least 1.
    pub const fn new(name: &'static str, description: &'static str) -> Size {
        Size { name, description, optional: false }
    }
}

/// A dimension of an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dimension {
    /// As many elements as a structural parameter says: its place among them.
    Size(usize),
    /// A constant number of elements.
    Fixed(u64),
}

/// A row of a model's table: a variable of FMI 3.0. The variables of FMI 2.0 are its elements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Variable<Q: 'static> {
    /// Key by which the model knows it.
    pub quantity: Q,
    /// Structured name.
    pub name: &'static str,
    /// Type, with the unit.
    pub kind: VariableType,
    /// Causality, variability and `initial` in one.
    pub role: Role,
    /// The values that each element can have.
    pub domain: Domain,
    /// From the outermost; none for a single value. Elements are in row-major order.
    pub dimensions: &'static [Dimension],
    /// Of what is computed: on what each element depends until initialization ends, and all elements of it.
    pub initially_on: &'static [Q],
    /// Description for users.
    pub description: &'static str,
}

/// A variable of FMI 2.0: an element of a [`Variable`].
#[derive(Debug, Clone, PartialEq)]
pub struct Scalar<Q: 'static> {
    /// Structured name.
    pub name: String,
    /// Description for users.
    pub description: String,
    /// The variable whose element it is.
    pub variable: &'static Variable<Q>,
    /// Index of the element, from 0.
    pub element: usize,
}

/// Begins a row of a table: a method of [`Variable`] says the role, and what users read.
pub const fn row<Q: 'static>(
    quantity: Q,
    name: &'static str,
    dimensions: &'static [Dimension],
    kind: VariableType,
) -> Variable<Q> {
    let (role, domain) = (Role::Calculated, Domain::Finite);
    Variable { quantity, name, kind, role, domain, dimensions, initially_on: &[], description: "" }
}

impl<Q: Copy> Variable<Q> {
    /// Gives it another name than that of the quantity: of a part of something.
    pub const fn named(self, name: &'static str) -> Variable<Q> {
        Variable { name, ..self }
    }

    /// Makes it an input.
    pub const fn input(self, description: &'static str) -> Variable<Q> {
        Variable { role: Role::Input, description, ..self }
    }

    /// Makes it an output whose start value can be set.
    pub const fn exact(self, description: &'static str) -> Variable<Q> {
        Variable { role: Role::Exact, description, ..self }
    }

    /// Makes it an output that is computed.
    pub const fn calculated(self, description: &'static str) -> Variable<Q> {
        Variable { role: Role::Calculated, description, ..self }
    }

    /// Says on what each element depends until initialization ends.
    pub const fn initially_on(self, initially_on: &'static [Q]) -> Variable<Q> {
        Variable { initially_on, ..self }
    }

    /// Makes it a parameter with values in a domain.
    pub const fn parameter(self, domain: Domain, description: &'static str) -> Variable<Q> {
        Variable { role: Role::Parameter, domain, description, ..self }
    }

    /// Lets a parameter be set between steps, too.
    pub const fn tunable(self) -> Variable<Q> {
        Variable { role: Role::Tunable, ..self }
    }

    /// Makes it a parameter that is computed.
    pub const fn calculated_parameter(self, description: &'static str) -> Variable<Q> {
        Variable { role: Role::CalculatedParameter, description, ..self }
    }
}

impl<Q> Variable<Q> {
    /// Returns whether the elements are x and y of vectors.
    pub fn is_vector(&self) -> bool {
        self.dimensions.last() == Some(&Dimension::Fixed(2))
    }

    /// Returns the variables of FMI 2.0 at an index of the dimensions before that of x and y: one,
    /// or one for each of x and y. Their names begin with `prefix`, their descriptions with
    /// `about`.
    pub fn scalars(
        &'static self,
        index: usize,
        prefix: &str,
        about: &str,
    ) -> impl Iterator<Item = Scalar<Q>> {
        let axes: &[&str] = if self.is_vector() { &["x", "y"] } else { &[""] };
        axes.iter().enumerate().map(move |(k, axis)| {
            let point = if axis.is_empty() { "" } else { "." };
            Scalar {
                name: format!("{prefix}{}{point}{axis}", self.name),
                description: format!("{about}{}", self.description.replacen("x and y", axis, axes.len() - 1)),
                variable: self,
                element: index * axes.len() + k,
            }
        })
    }
}

/// An element that depends on another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dependency<Q> {
    /// Index of the dependent element, from 0.
    pub dependent: usize,
    /// The variable on which it depends.
    pub on: Q,
    /// Index of the element on which it depends, from 0.
    pub element: usize,
}

/// On what the elements of an output depend.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Dependencies<Q> {
    /// Each element depends on all elements of these variables.
    All(Vec<Q>),
    /// Single elements depend on single elements.
    Elements(Vec<Dependency<Q>>),
}

impl<Q: Copy> Dependencies<Q> {
    /// Returns the variables on which it depends; some more than once.
    pub fn variables(&self) -> Vec<Q> {
        match self {
            Dependencies::All(on) => on.clone(),
            Dependencies::Elements(elements) => elements.iter().map(|dependency| dependency.on).collect(),
        }
    }
}

/// The variables that count as known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Known {
    /// During the simulation.
    Inputs,
    /// Until initialization ends: all that have start values.
    Starts,
}

impl Known {
    /// Returns whether variables of a role count.
    pub fn includes(self, role: Role) -> bool {
        role == Role::Input || self == Known::Starts && (role.is_parameter() || role == Role::Exact)
    }
}
