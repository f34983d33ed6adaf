//! The CSV files of a run.

use anyhow::{Context, Result};
use crowd_mechanics::files::Staged;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// A CSV that appears under its name only when it is complete.
pub struct Table {
    out: csv::Writer<BufWriter<Staged>>,
    path: PathBuf,
}

impl Table {
    pub fn create(path: &Path, header: impl IntoIterator<Item = impl AsRef<[u8]>>) -> Result<Table> {
        let file = Staged::beside(path).with_context(|| format!("cannot write {}", path.display()))?;
        let out = csv::WriterBuilder::new().from_writer(BufWriter::new(file));
        let mut table = Table { out, path: path.to_owned() };
        table.write(header)?;
        Ok(table)
    }

    pub fn write(&mut self, row: impl IntoIterator<Item = impl AsRef<[u8]>>) -> Result<()> {
        self.out.write_record(row).with_context(|| format!("cannot write {}", self.path.display()))
    }

    pub fn finish(self) -> Result<()> {
        let cannot = || format!("cannot write {}", self.path.display());
        let file = self.out.into_inner().map_err(|error| error.into_error()).with_context(cannot)?;
        let file = file.into_inner().map_err(|error| error.into_error()).with_context(cannot)?;
        file.persist().with_context(cannot)
    }
}
