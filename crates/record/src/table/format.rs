//! Formats of tables.

use std::path::Path;

/// Format of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// Text with a header. Numbers are written so that they read back to the same doubles.
    Csv,
    /// Compressed columns; units, variables and descriptions are in the metadata.
    #[cfg(feature = "parquet")]
    Parquet,
}

impl Format {
    /// All formats of this build.
    pub const ALL: &[Format] = &[
        Format::Csv,
        #[cfg(feature = "parquet")]
        Format::Parquet,
    ];

    /// The format that the extension of a file means; capitals do not matter.
    pub fn of(path: &Path) -> Option<Format> {
        let end = path.extension()?;
        Format::ALL.iter().copied().find(|format| end.eq_ignore_ascii_case(format.extension()))
    }

    /// Extension of its files, without a dot.
    pub const fn extension(self) -> &'static str {
        match self {
            Format::Csv => "csv",
            #[cfg(feature = "parquet")]
            Format::Parquet => "parquet",
        }
    }
}
