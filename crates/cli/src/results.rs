//! `trajectories.csv`.

use anyhow::{Context, Result};
use crowd_mechanics::files::Staged;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

const HEADER: &str = "t,id,x,y,vx,vy,theta,omega,agent_contacts,wall_contacts,contacting_agents,normal_force";

/// What the FMU says of one agent at one communication point.
pub struct Row<'a> {
    pub time: f64,
    pub id: &'a str,
    /// x, y, vx, vy, theta, omega
    pub motion: [f64; 6],
    /// disk–disk, disk–face, different agents
    pub contacts: [i32; 3],
    pub normal_force: f64,
}

/// A CSV that appears under its name only when it is complete.
pub struct Results {
    out: csv::Writer<BufWriter<Staged>>,
    path: PathBuf,
}

impl Results {
    pub fn create(path: &Path) -> Result<Results> {
        let cannot = || format!("cannot write {}", path.display());
        let mut file = BufWriter::new(Staged::beside(path).with_context(cannot)?);
        writeln!(file, "{HEADER}").with_context(cannot)?;
        Ok(Results {
            out: csv::WriterBuilder::new().has_headers(false).from_writer(file),
            path: path.to_owned(),
        })
    }

    pub fn write(&mut self, row: &Row) -> Result<()> {
        // `{:?}` reads back to the same double.
        let numbers = std::iter::once(format!("{:?}", row.time))
            .chain([row.id.to_owned()])
            .chain(row.motion.iter().map(|value| format!("{value:?}")))
            .chain(row.contacts.iter().map(ToString::to_string))
            .chain([format!("{:?}", row.normal_force)]);
        self.out.write_record(numbers).with_context(|| format!("cannot write {}", self.path.display()))
    }

    pub fn finish(self) -> Result<()> {
        let cannot = || format!("cannot write {}", self.path.display());
        let file = self.out.into_inner().map_err(|error| error.into_error()).with_context(cannot)?;
        let file = file.into_inner().map_err(|error| error.into_error()).with_context(cannot)?;
        file.persist().with_context(cannot)
    }
}
