//! Whether a shared library is the one of its model.

use anyhow::{Context, Result, bail};
use crowd_mechanics::pack::{Binary, COMPONENT};
use crowd_mechanics::resources::TRIALS_FILE;
use lemons_core::files::input;
use lemons_decision::DECISION_FILE;
use lemons_master::FileType;
use lemons_summary::SUMMARY_FILE;

/// A shared library of this workspace.
pub struct Library {
    /// Of the crate.
    pub name: &'static str,
    /// A text that it holds. That of the summary, in which crowd and decision are, only the summary holds.
    mark: &'static str,
}

/// Of the crowd; the mark is the file of its resources.
pub const CROWD: Library = Library { name: "crowd_mechanics", mark: TRIALS_FILE };
/// Of the decision; so is its mark.
pub const DECISION: Library = Library { name: "lemons_decision_fmu", mark: DECISION_FILE };
/// Of the summary; so is its mark.
pub const SUMMARY: Library = Library { name: "lemons_summary_fmu", mark: SUMMARY_FILE };

impl Library {
    /// Checks that a file is this library, of any platform.
    ///
    /// # Errors
    /// It is not.
    pub fn check(&self, Binary { platform, path }: &Binary) -> Result<()> {
        let named = || format!("--binary {platform}={}", path.display());
        let (kind, wanted) = match &**platform {
            COMPONENT => (FileType::COMPONENT, "a WebAssembly component"),
            _ => (FileType::LIBRARY, "a shared library"),
        };
        FileType::expect(path, &[kind], wanted).with_context(named)?;
        let bytes = input::read(path, input::LARGEST_BINARY).context("cannot be read").with_context(named)?;
        let holds = |mark: &str| bytes.windows(mark.len()).any(|text| text == mark.as_bytes());
        if !holds(self.mark) || self.mark != SUMMARY.mark && holds(SUMMARY.mark) {
            bail!("{}: is not the library {}", named(), self.name);
        }
        Ok(())
    }
}
