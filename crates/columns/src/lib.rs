//! Flat tables in Parquet: rows of numbers and texts, as other programs read and write them.
//!
//! A `Writer` takes rows of [`Cell`]s, a `Reader` returns them. Attributes of a column, such as its unit, are in
//! the metadata of the file under the key `columns`, as JSON: `{"x": {"unit": "m"}}`. The same rows give the same
//! bytes.
//!
//! Both need the feature `parquet`, which is on by default. Without it there are only the types of cells and columns,
//! and nothing of C is built.

#[cfg(feature = "parquet")]
mod header;
#[cfg(feature = "parquet")]
mod page;
#[cfg(feature = "parquet")]
mod read;
#[cfg(feature = "parquet")]
mod write;

#[cfg(feature = "parquet")]
pub use read::{Batch, Batches, Found, Reader};
#[cfg(feature = "parquet")]
pub use write::Writer;

/// The key in the metadata of a file for attributes of columns.
#[cfg(feature = "parquet")]
const COLUMNS: &str = "columns";

/// The type of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Doubles.
    Real,
    /// 32-bit integers.
    Integer,
    /// 64-bit integers.
    Long,
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
    /// A value of a [`Kind::Long`] column.
    Long(i64),
    /// A value of a [`Kind::Boolean`] column.
    Boolean(bool),
    /// A value of a [`Kind::Text`] column.
    Text(&'a str),
    /// A missing value of an optional column.
    Missing,
}

/// A column to be written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Name, unique in the table.
    pub name: String,
    /// Type of all its values.
    pub kind: Kind,
    /// Whether values may be missing.
    pub optional: bool,
    /// Whether the same values occur many times, so that a dictionary saves space.
    pub repeats: bool,
    /// Its attributes, such as `("unit", "m")`.
    pub about: Vec<(&'static str, String)>,
}

/// Why a table cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// The file is damaged.
    #[error("{}is not valid Parquet: {why}", after(*rows))]
    Unsound {
        /// Number of rows that were read before.
        rows: u64,
        /// What is wrong.
        why: String,
    },
    /// The file uses a feature that is not supported.
    #[error("is Parquet with a feature that is not supported: {0}")]
    Unknown(String),
    /// Two columns have the same name.
    #[error("there are two columns {0:?}")]
    Twice(String),
    /// A value does not have the type of its column.
    #[error("column {column}: the value {cell} has the wrong type")]
    Cell {
        /// Name of the column.
        column: String,
        /// The value.
        cell: String,
    },
    /// A row has fewer values than there are columns.
    #[error("a row has no value for column {0}")]
    Short(String),
    /// The file cannot be read or written.
    #[error("{0}")]
    System(String),
}

fn after(rows: u64) -> String {
    if rows == 0 { String::new() } else { format!("after row {rows}: ") }
}
