//! Units and the conversion between them.

/// A change of a value on its way: `factor * value + offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Affine {
    /// In the unit after per unit before.
    pub factor: f64,
    /// In the unit after.
    pub offset: f64,
}

impl Affine {
    /// Leaves every value as it is, to the last bit.
    pub const IDENTITY: Affine = Affine { factor: 1.0, offset: 0.0 };

    /// Returns the value afterwards.
    pub fn apply(self, value: f64) -> f64 {
        // −0 + 0 is +0: the identity must not touch it.
        if self == Affine::IDENTITY { value } else { self.factor * value + self.offset }
    }

    /// Returns this one first, then the other.
    pub fn then(self, next: Affine) -> Affine {
        Affine { factor: next.factor * self.factor, offset: next.factor * self.offset + next.offset }
    }
}

/// A unit by the powers of its base units; a value in them is `factor * value + offset`.
#[derive(Debug, Clone, PartialEq)]
pub struct SspUnit {
    /// As connectors name it.
    pub name: String,
    /// Exponents in the order of [`SspUnit::BASE`].
    pub exponents: [i32; 8],
    /// Base units per unit.
    pub factor: f64,
    /// In base units.
    pub offset: f64,
}

impl SspUnit {
    /// The base units, as FMI 2.0 and SSP 1.0 call them.
    pub const BASE: [&str; 8] = ["kg", "m", "s", "A", "K", "mol", "cd", "rad"];

    /// Returns whether both are the same, whatever their names.
    pub fn is_same(&self, other: &SspUnit) -> bool {
        self.exponents == other.exponents && self.factor == other.factor && self.offset == other.offset
    }

    /// Returns the conversion from this unit to another; `None` if it measures another quantity.
    pub fn to(&self, other: &SspUnit) -> Option<Affine> {
        if self.is_same(other) {
            return Some(Affine::IDENTITY);
        }
        (self.exponents == other.exponents).then(|| Affine {
            factor: self.factor / other.factor,
            offset: (self.offset - other.offset) / other.factor,
        })
    }
}

/// A unit by name and by definition, as far as there is one.
pub type UnitOf<'a> = (Option<&'a str>, Option<&'a SspUnit>);

/// Returns the conversion from one unit to another, by name and by definition as far as there is one. A value without a unit passes
/// unchanged, as between equal names.
///
/// # Errors
/// Why there is none.
pub fn conversion(from: UnitOf, to: UnitOf) -> Result<Affine, String> {
    let (Some(from_name), Some(to_name)) = (from.0, to.0) else { return Ok(Affine::IDENTITY) };
    let why = match (from.1, to.1) {
        (Some(from), Some(to)) => match from.to(to) {
            Some(map) => return Ok(map),
            None => "another quantity".to_owned(),
        },
        _ if from_name == to_name => return Ok(Affine::IDENTITY),
        (None, _) => format!("{from_name:?} is not defined"),
        _ => format!("{to_name:?} is not defined"),
    };
    Err(format!("{from_name:?} cannot be converted to {to_name:?}: {why}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(name: &str, exponents: [i32; 8], factor: f64, offset: f64) -> SspUnit {
        SspUnit { name: name.into(), exponents, factor, offset }
    }

    #[test]
    fn units_convert_through_their_base_units() {
        let kelvin = [0, 0, 0, 0, 1, 0, 0, 0];
        let celsius = unit("degC", kelvin, 1.0, 273.15);
        let fahrenheit = unit("degF", kelvin, 5.0 / 9.0, 459.67 * 5.0 / 9.0);
        let map = celsius.to(&fahrenheit).unwrap();
        for (c, f) in [(0.0, 32.0), (100.0, 212.0), (-40.0, -40.0)] {
            assert!((map.apply(c) - f).abs() < 1e-10, "{c} degC = {} degF", map.apply(c));
        }
        let back = map.then(fahrenheit.to(&celsius).unwrap());
        assert!((back.apply(37.0) - 37.0).abs() < 1e-10);
        let metre = unit("m", [0, 1, 0, 0, 0, 0, 0, 0], 1.0, 0.0);
        assert!(conversion((Some("m"), Some(&metre)), (Some("degC"), Some(&celsius))).is_err());
        assert!(conversion((Some("m"), None), (Some("degC"), Some(&celsius))).is_err());
        assert_eq!(conversion((Some("m"), None), (Some("m"), None)), Ok(Affine::IDENTITY));
        assert_eq!(conversion((Some("m"), Some(&metre)), (None, None)), Ok(Affine::IDENTITY));
    }

    #[test]
    fn the_identity_keeps_every_bit() {
        for value in [-0.0, 0.1, f64::MIN_POSITIVE / 4.0, f64::INFINITY] {
            assert_eq!(Affine::IDENTITY.apply(value).to_bits(), f64::to_bits(value));
        }
    }
}
