//! How much may be unpacked.

use crate::error::{Place, Result};
use std::io::{self, Read, Write};

/// How much archives may still unpack to: a small one can hold a lot of zeros, and the sizes that it declares
/// need not be true.
#[derive(Debug)]
pub struct Allowance {
    left: u64,
    limit: u64,
    entries: usize,
}

impl Allowance {
    /// \[byte\] Of the structure and the parameter files of an archive, which are held in memory: twice
    /// what two FMUs of 10 000 agents take.
    pub const STRUCTURE: u64 = 64_000_000;
    /// \[byte\] Of all FMUs of a run, which are unpacked on disk.
    pub const FMUS: u64 = 4_000_000_000;

    /// Number of the entries of all archives: each becomes a file or a directory. An FMU that contains Python has some
    /// thousands.
    pub const ENTRIES: usize = 20_000;

    /// So many bytes, and [`Allowance::ENTRIES`].
    pub fn new(limit: u64) -> Allowance {
        Allowance { left: limit, limit, entries: Allowance::ENTRIES }
    }

    /// Takes the entries of an archive.
    ///
    /// # Errors
    /// There are more than are left.
    pub fn entries(&mut self, count: usize) -> Result<()> {
        let most = Allowance::ENTRIES;
        let many = || format!("it has too many entries: at most {most} are unpacked in all");
        self.entries = self.entries.checked_sub(count).ok_or_else(many)?;
        Ok(())
    }

    /// Copies an entry until nothing is left of the allowance.
    ///
    /// # Errors
    /// The entry is broken, its copy cannot be written, or it is too large.
    pub fn copy(&mut self, name: &str, entry: impl Read, to: &mut impl Write) -> Result<()> {
        // One byte more tells too large from just fitting.
        let mut entry = entry.take(self.left.saturating_add(1));
        let copied = io::copy(&mut entry, to).place(|| name.to_owned())?;
        let most = self.limit as f64 / 1e6;
        let large = || format!("{name}: is refused: more than {most} MB to unpack in all");
        self.left = self.left.checked_sub(copied).ok_or_else(large)?;
        Ok(())
    }
}
