//! What the cells of a table hold.

/// The type of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Doubles.
    Real,
    /// 32-bit integers.
    Integer,
    /// Booleans.
    Boolean,
    /// UTF-8 texts.
    Text,
}

/// A value in a table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cell<'a> {
    /// A value of a [`Kind::Real`] column.
    Real(f64),
    /// A value of a [`Kind::Integer`] column.
    Integer(i32),
    /// A value of a [`Kind::Boolean`] column.
    Boolean(bool),
    /// A value of a [`Kind::Text`] column.
    Text(&'a str),
}
