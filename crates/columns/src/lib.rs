//! Flat tables in Parquet: rows of numbers and texts, as other programs read and write them.
//!
//! A [`Writer`] takes rows of [`Cell`]s, a [`Reader`] gives them back. What is said of a column – its unit, say –
//! stands in the file's metadata under the key `columns`, as JSON: `{"x": {"unit": "m"}}`. The same rows give the
//! same bytes.

mod page;
mod read;
mod write;

pub use read::{Batch, Batches, Found, Reader};
pub use write::Writer;

/// The key in the metadata of a file that says something of its columns.
const COLUMNS: &str = "columns";

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Doubles.
    Real,
    /// Of 32 bits.
    Integer,
    /// Of 64 bits.
    Long,
    /// True or false.
    Boolean,
    /// UTF-8.
    Text,
}

/// A value in a table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cell<'a> {
    /// Of a column of [`Kind::Real`].
    Real(f64),
    /// Of a column of [`Kind::Integer`].
    Integer(i32),
    /// Of a column of [`Kind::Long`].
    Long(i64),
    /// Of a column of [`Kind::Boolean`].
    Boolean(bool),
    /// Of a column of [`Kind::Text`].
    Text(&'a str),
    /// Of a column in which values may be missing.
    Missing,
}

/// A column to be written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// No two of a table have the same.
    pub name: String,
    /// Of all its values.
    pub kind: Kind,
    /// Whether values may be missing.
    pub optional: bool,
    /// Whether values come again and again, so that a dictionary of them is worth while.
    pub repeats: bool,
    /// What is said of it: `("unit", "m")`.
    pub about: Vec<(&'static str, String)>,
}

/// Why a table cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// It is damaged.
    #[error("{}is no sound Parquet: {why}", after(*rows))]
    Unsound {
        /// That many were sound.
        rows: u64,
        /// What is wrong.
        why: String,
    },
    /// It is written in a way that is not known here.
    #[error("is Parquet of a kind that is not read here: {0}")]
    Unknown(String),
    /// Two columns have one name.
    #[error("there are two columns {0:?}")]
    Twice(String),
    /// A row is not of the table.
    #[error("column {column}: {cell} is not of its type")]
    Cell {
        /// Its name.
        column: String,
        /// What was to be written.
        cell: String,
    },
    /// A row has fewer cells than there are columns.
    #[error("a row has no cell for column {0}")]
    Short(String),
    /// The system does not let it be read or written.
    #[error("{0}")]
    System(String),
}

fn after(rows: u64) -> String {
    if rows == 0 { String::new() } else { format!("after row {rows}: ") }
}
