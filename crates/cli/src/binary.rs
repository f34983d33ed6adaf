//! Whether a shared library is what an FMU needs: of its platform, and the one of its model.

use anyhow::{Context, Result, bail};
use crowd_mechanics::pack::Binary;
use lemons_decision::decision::PLAN_FILE;
use lemons_files::input;
use lemons_master::check_library;

/// A shared library of this workspace.
pub struct Library {
    /// Of the crate.
    pub name: &'static str,
    /// A text that only this one holds.
    mark: &'static str,
}

/// Of the crowd; the mark is the function that it exports beside FMI's.
pub const CROWD: Library = Library { name: "crowd_mechanics", mark: "CrowdMechanics" };
/// Of the decision; the mark is the file of its resources.
pub const DECISION: Library = Library { name: "lemons_decision_fmu", mark: PLAN_FILE };

impl Library {
    /// Whether a file is this library, whole and for its platform.
    ///
    /// # Errors
    /// It is not; a platform that FMI does not know is left to those who pack.
    pub fn check(&self, Binary { platform, path }: &Binary) -> Result<()> {
        let named = || format!("--binary {platform}={}", path.display());
        check_library(path, platform).with_context(named)?;
        let bytes = input::read(path, input::LARGEST_BINARY).context("cannot be read").with_context(named)?;
        if !bytes.windows(self.mark.len()).any(|text| text == self.mark.as_bytes()) {
            bail!("{}: is not the library {}", named(), self.name);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lemons_testing::pe;

    /// A header with nothing behind it: 64 bit, of this processor.
    fn elf(machine: u8) -> Vec<u8> {
        let mut bytes = vec![0; 64];
        bytes[..7].copy_from_slice(b"\x7fELF\x02\x01\x01");
        (bytes[16], bytes[18], bytes[20], bytes[52]) = (3, machine, 1, 64);
        bytes
    }

    fn mach(processor: u8) -> Vec<u8> {
        let mut bytes = vec![0; 32];
        bytes[..8].copy_from_slice(&[0xcf, 0xfa, 0xed, 0xfe, processor, 0, 0, 1]);
        bytes
    }

    /// One of several processors: a list of them, then the files.
    fn fat(files: &[(u8, Vec<u8>)]) -> Vec<u8> {
        let mut bytes = vec![0xca, 0xfe, 0xba, 0xbe, 0, 0, 0, files.len() as u8];
        for (k, (processor, file)) in files.iter().enumerate() {
            let offset = 256 * (k as u32 + 1);
            for word in [0x0100_0000 | u32::from(*processor), 0, offset, file.len() as u32, 0] {
                bytes.extend(word.to_be_bytes());
            }
        }
        for (_, file) in files {
            bytes.resize(bytes.len().next_multiple_of(256), 0);
            bytes.extend(file);
        }
        bytes
    }

    #[test]
    fn a_library_is_for_its_platform() {
        let directory = tempfile::TempDir::new().unwrap();
        let path = directory.path().join("library");
        let (x86, arm) = (7, 12);
        let platforms = [
            "linux64",
            "linux32",
            "aarch64-linux",
            "x86_64-linux",
            "win64",
            "win32",
            "darwin64",
            "aarch64-darwin",
            "x86_64-darwin",
        ];
        for (bytes, fits) in [
            (elf(62), &["linux64", "x86_64-linux"][..]),
            (elf(183), &["aarch64-linux"]),
            (pe(), &["win64"]),
            (mach(x86), &["darwin64", "x86_64-darwin"]),
            (mach(arm), &["darwin64", "aarch64-darwin"]),
            (fat(&[(x86, mach(x86)), (arm, mach(arm))]), &["darwin64", "aarch64-darwin", "x86_64-darwin"]),
            (b"decision.toml, a text".to_vec(), &[]),
            (b"MZ".to_vec(), &[]),
            (vec![], &[]),
        ] {
            for platform in platforms {
                let binary = Binary { platform: platform.into(), path: path.clone() };
                std::fs::write(&path, [&bytes[..], b"decision.toml"].concat()).unwrap();
                let done = DECISION.check(&binary).map_err(|error| format!("{error:#}"));
                assert_eq!(done.is_ok(), fits.contains(&platform), "{platform}: {done:?}");
                let Err(said) = CROWD.check(&binary).map_err(|error| format!("{error:#}")) else {
                    panic!("{platform}: no mark of the crowd's")
                };
                let why = if done.is_ok() {
                    "is not the library crowd_mechanics"
                } else {
                    "is not a shared library"
                };
                assert!(said.contains(why) && said.contains(&format!("--binary {platform}=")), "{said}");
            }
        }
    }
}
