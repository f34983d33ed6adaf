//! The CSV files of a run.

use anyhow::{Context, Result, bail};
use crowd_mechanics::files::Staged;
use std::collections::HashMap;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

/// The files of a run: no two tables go into one file, none into a file that the run reads.
pub struct Tables {
    /// Why files cannot be written, by the one path of each.
    taken: HashMap<PathBuf, &'static str>,
}

/// A CSV that appears under its name only when it is complete.
pub struct Table {
    out: csv::Writer<BufWriter<Staged>>,
    path: PathBuf,
}

impl Tables {
    /// Of a run that reads these files.
    pub fn beside<'a>(inputs: impl IntoIterator<Item = &'a Path>) -> Tables {
        let inputs = inputs.into_iter().filter_map(|path| path.canonicalize().ok());
        Tables { taken: inputs.map(|path| (path, "the run reads it")).collect() }
    }

    pub fn create(
        &mut self,
        path: &Path,
        header: impl IntoIterator<Item = impl AsRef<[u8]>>,
    ) -> Result<Table> {
        let cannot = || format!("cannot write {}", path.display());
        if let Some(why) = self.taken.insert(only_path(path).with_context(cannot)?, "other results go there")
        {
            bail!("{}: {why}", cannot());
        }
        let file = Staged::beside(path).with_context(cannot)?;
        let out = csv::WriterBuilder::new().from_writer(BufWriter::new(file));
        let mut table = Table { out, path: path.to_owned() };
        table.write(header)?;
        Ok(table)
    }
}

/// The one path of a file, which need not be there: absolute and without links.
fn only_path(path: &Path) -> io::Result<PathBuf> {
    if let Ok(there) = path.canonicalize() {
        return Ok(there);
    }
    let name = path.file_name().ok_or(io::ErrorKind::InvalidFilename)?;
    let directory = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    Ok(directory.canonicalize()?.join(name))
}

impl Table {
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
