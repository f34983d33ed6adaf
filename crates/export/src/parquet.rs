//! The table that `lemons run --format parquet` writes.

use crate::record::Each;
use crate::rows::{Builder, COLUMNS, OBSERVED, OF_STEP, Stop, check_unit};
use crate::run::{Observed, OfStep};
use crowd_mechanics::engine::{Vec2, vec2};
use crowd_mechanics::trial::AgentDynamics;
use lemons_columns::{Batch, Cell, Kind, Reader};
use std::fs::File;

type Wanted = (&'static str, Option<&'static str>);

/// Answers the Ids.
pub(crate) fn read(file: File, each: &mut Each<'_>) -> Result<Vec<String>, Stop> {
    let reader = Reader::open(file).map_err(|error| error.to_string())?;
    let has = |name: &str| reader.columns().iter().any(|column| column.name == name);
    let mut wanted: Vec<Wanted> = COLUMNS.to_vec();
    let observed = OBSERVED.iter().all(|(name, _)| has(name));
    if observed {
        wanted.extend(OBSERVED);
    }
    let of_step = observed && OF_STEP.iter().all(|(name, _)| has(name));
    if of_step {
        wanted.extend(OF_STEP);
    }
    let places =
        wanted.iter().map(|column| place(&reader, *column)).collect::<Result<Vec<usize>, String>>()?;
    let mut builder = Builder::new("row");
    let mut before = 0;
    for batch in reader.batches(&places) {
        let batch = batch.map_err(|error| error.to_string())?;
        for row in 0..batch.rows() {
            let n = before + 1 + row as u64;
            let row = Row { batch: &batch, row, n, wanted: &wanted };
            let real = |k: usize| row.real(k);
            let agent = AgentDynamics {
                position: vec2(real(2)?, real(3)?),
                velocity: vec2(real(4)?, real(5)?),
                theta: real(6)?,
                omega: real(7)?,
                fp: Vec2::ZERO,
                mp: 0.0,
            };
            let seen = if observed { Some(row.observed(of_step)?) } else { None };
            if let Some(frame) = builder.add(n, real(0)?, &row.id()?, (agent, seen))? {
                each(frame)?;
            }
        }
        before += batch.rows() as u64;
    }
    let (last, ids) = builder.finish()?;
    each(last)?;
    Ok(ids)
}

/// Where a column is.
fn place(reader: &Reader, (name, unit): Wanted) -> Result<usize, String> {
    let mut found = reader.columns().iter().enumerate().filter(|(_, column)| column.name == name);
    let (place, column) = match (found.next(), found.next()) {
        (Some(column), None) => column,
        (Some(_), Some(_)) => return Err(format!("there are two columns {name:?}")),
        (None, _) => {
            let names = COLUMNS.map(|(name, _)| name).join(", ");
            return Err(format!("there is no column {name:?} (lemons run writes {names})"));
        }
    };
    check_unit(name, column.about("unit"), unit)?;
    let (good, holds): (&[Kind], _) = match name {
        // Other tools make numbers of ids that look like some.
        "id" => (&[Kind::Text, Kind::Integer, Kind::Long], "neither texts nor whole numbers"),
        _ if OBSERVED[..3].iter().any(|(count, _)| *count == name) => {
            (&[Kind::Integer, Kind::Long], "no whole numbers")
        }
        _ => (&[Kind::Real, Kind::Integer], "no numbers"),
    };
    if !column.kind.is_some_and(|kind| good.contains(&kind)) {
        return Err(format!("column {name}: holds {holds}"));
    }
    Ok(place)
}

/// The n-th row of the file.
struct Row<'a> {
    batch: &'a Batch,
    /// In the batch.
    row: usize,
    n: u64,
    wanted: &'a [Wanted],
}

impl Row<'_> {
    fn wrong<T>(&self, k: usize, what: impl std::fmt::Display) -> Result<T, String> {
        Err(format!("row {}: column {}: {what}", self.n, self.wanted[k].0))
    }

    fn cell(&self, k: usize) -> Result<Cell<'_>, String> {
        match self.batch.cell(k, self.row) {
            Cell::Missing => self.wrong(k, "there is no value"),
            cell => Ok(cell),
        }
    }

    fn id(&self) -> Result<String, String> {
        match self.cell(1)? {
            Cell::Text(id) => Ok(id.to_owned()),
            Cell::Integer(id) => Ok(id.to_string()),
            Cell::Long(id) => Ok(id.to_string()),
            _ => self.wrong(1, "is no id"),
        }
    }

    fn real(&self, k: usize) -> Result<f64, String> {
        match self.cell(k)? {
            Cell::Real(value) if value.is_finite() => Ok(value),
            Cell::Integer(value) => Ok(value.into()),
            Cell::Real(value) => self.wrong(k, format!("{value:?} is no finite number")),
            _ => self.wrong(k, "is no number"),
        }
    }

    fn count(&self, k: usize) -> Result<u32, String> {
        let value = match self.cell(k)? {
            Cell::Integer(value) => value.into(),
            Cell::Long(value) => value,
            _ => return self.wrong(k, "is no whole number"),
        };
        u32::try_from(value).or_else(|_| self.wrong(k, format!("{value} is no number of contacts")))
    }

    /// A number that is not negative.
    fn size(&self, k: usize, what: &str) -> Result<f64, String> {
        let value = self.real(k)?;
        if value < 0.0 { self.wrong(k, format!("{value:?} is no {what}")) } else { Ok(value) }
    }

    fn observed(&self, of_step: bool) -> Result<Observed, String> {
        let step = || -> Result<OfStep, String> {
            Ok(OfStep {
                mean_normal_force: self.size(12, "squeeze in newtons")?,
                peak_normal_force: self.size(13, "squeeze in newtons")?,
                peak_overlap: self.size(14, "overlap in metres")?,
            })
        };
        Ok(Observed {
            agent_contacts: self.count(8)?,
            wall_contacts: self.count(9)?,
            contacting_agents: self.count(10)?,
            normal_force: self.size(11, "squeeze in newtons")?,
            of_step: of_step.then(step).transpose()?,
        })
    }
}
