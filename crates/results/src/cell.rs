//! Cells of a table.

/// The type of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CellType {
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
    /// A value of a [`CellType::Real`] column.
    Real(f64),
    /// A value of a [`CellType::Integer`] column.
    Integer(i32),
    /// A value of a [`CellType::Boolean`] column.
    Boolean(bool),
    /// A value of a [`CellType::Text`] column.
    Text(&'a str),
}
