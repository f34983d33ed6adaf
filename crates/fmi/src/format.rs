//! The versions of FMI.

/// A version of FMI.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Version {
    /// FMI 2.0: a variable for each number.
    #[default]
    V2,
    /// FMI 3.0: variables are arrays. Their sizes are structural parameters.
    V3,
}

/// The version of FMI that is written, and what can be chosen in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FmuFormat {
    /// FMI 2.0
    Fmi2(Naming),
    /// FMI 3.0
    Fmi3,
}

/// `variableNamingConvention` of FMI 2.0. The names are the same in both cases. Tools that check
/// structured names are slow if there are thousands of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Naming {
    /// "structured"
    #[default]
    Structured,
    /// "flat"
    Flat,
}

impl Default for FmuFormat {
    fn default() -> FmuFormat {
        FmuFormat::Fmi2(Naming::default())
    }
}

impl FmuFormat {
    /// Returns the version.
    pub fn version(self) -> Version {
        match self {
            FmuFormat::Fmi2(_) => Version::V2,
            FmuFormat::Fmi3 => Version::V3,
        }
    }
}
