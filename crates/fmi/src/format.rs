//! The version of FMI that is written.

use crate::archive::Version;
use crate::v2::description::Naming;

/// The version of FMI, and what can be chosen in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// FMI 2.0: a variable for each number.
    Fmi2(Naming),
    /// FMI 3.0: arrays.
    Fmi3,
}

impl Default for Format {
    fn default() -> Format {
        Format::Fmi2(Naming::default())
    }
}

impl Format {
    /// Returns the version.
    pub fn version(self) -> Version {
        match self {
            Format::Fmi2(_) => Version::V2,
            Format::Fmi3 => Version::V3,
        }
    }
}
