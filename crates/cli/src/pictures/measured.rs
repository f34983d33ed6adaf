//! Measured trajectories, to be drawn beside simulated ones.

use super::trial_run::agents_at;
use anyhow::{Context, Result, bail};
use lemons_core::files::input;
use lemons_core::plane::{Vec2, vec2};
use lemons_results::Run;
use std::collections::BTreeMap;
use std::path::Path;

/// Where people were seen, by the Id of the agent that stands for each.
pub struct MeasuredPaths {
    people: BTreeMap<String, Vec<(f64, Vec2)>>,
}

/// Meaning of x and y of the file.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum CoordinateOrigin {
    /// Positions in the Trial's plane
    Plane,
    /// Displacements of each from where it was at the file's first time
    Start,
}

impl MeasuredPaths {
    /// Reads a CSV with the columns t, id, x, y, in s and m; rows of one person by time.
    pub fn read(path: &Path) -> Result<MeasuredPaths> {
        Self::parse(path).with_context(|| format!("measured trajectories {}", path.display()))
    }

    fn parse(path: &Path) -> Result<MeasuredPaths> {
        let file = input::open_bounded(path, input::LARGEST_DRIVE)?;
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(file);
        let header = reader.headers()?.clone();
        let column = |name: &str| {
            // A column may have its unit: `x [m]`.
            let plain = |column: &str| column.split('[').next().map(str::trim_end) == Some(name);
            let place = header.iter().position(|column| plain(column.trim_start_matches('\u{feff}')));
            place.with_context(|| format!("there is no column {name:?} (expected t,id,x,y)"))
        };
        let (id, numbers) = (column("id")?, [column("t")?, column("x")?, column("y")?]);
        let mut people: BTreeMap<String, Vec<(f64, Vec2)>> = BTreeMap::new();
        for record in reader.records() {
            let record = record?;
            let line = record.position().map_or(0, csv::Position::line);
            let number = |place: usize| {
                let text = &record[place];
                match text.parse::<f64>() {
                    Ok(value) if value.is_finite() => Ok(value),
                    _ => bail!("line {line}: {}={text:?}: not a finite number", &header[place]),
                }
            };
            let [t, x, y] = [number(numbers[0])?, number(numbers[1])?, number(numbers[2])?];
            let rows = people.entry(record[id].to_owned()).or_default();
            if let Some(last) = rows.last().filter(|last| last.0 >= t) {
                bail!("line {line}: t={t} does not come after t={} of the same person", last.0);
            }
            rows.push((t, vec2(x, y)));
        }
        if people.is_empty() {
            bail!("holds no row");
        }
        Ok(MeasuredPaths { people })
    }

    /// Moved to where each agent of a run was at the file's first time, if the file has displacements from there.
    ///
    /// # Errors
    /// An Id is not that of an agent, or the position of an agent at this time is not known.
    pub fn placed(mut self, origin: CoordinateOrigin, run: &Run) -> Result<MeasuredPaths> {
        let start = self.people.values().map(|rows| rows[0].0).fold(f64::INFINITY, f64::min);
        let agents = agents_at(run, start);
        for (id, rows) in &mut self.people {
            let place = run.ids.iter().position(|known| known == id);
            let place = place.with_context(|| format!("measured trajectories: there is no agent {id:?}"))?;
            if origin == CoordinateOrigin::Plane {
                continue;
            }
            let (first, (begin, end)) = (rows[0].0, run.times());
            if first != start || start < begin || start > end {
                bail!(
                    "measured trajectories: agent {id:?} is seen from t = {first:?} s on, the file begins at {start:?} s, the \
                     run goes from {begin:?} to {end:?} s: its displacement from the start is not known (--measured-from plane)"
                );
            }
            let shift = agents[place].pose.position - rows[0].1;
            rows.iter_mut().for_each(|row| row.1 += shift);
        }
        Ok(self)
    }

    /// The rows of an agent \[s, m\]; none if nobody measured it.
    pub fn of(&self, id: &str) -> &[(f64, Vec2)] {
        self.people.get(id).map_or(&[], Vec::as_slice)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lemons_core::plane::{Motion, Pose};
    use lemons_results::Frame;

    fn read(text: &str) -> Result<MeasuredPaths> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        MeasuredPaths::read(file.path())
    }

    #[test]
    fn displacements_begin_where_agents_start() {
        let rows = "t [s],id,x [m],y [m]\n0,a,0.5,0\n0,b,0,0\n0.1,a,0.75,-1\n";
        let pose = |x: f64, y: f64| Pose { position: vec2(x, y), ..Pose::default() };
        let at = |x: f64, y: f64| Motion { pose: pose(x, y), ..Motion::default() };
        let run = |ids: &[&str], time: f64| Run {
            source: "run.csv".into(),
            ids: ids.iter().map(|id| (*id).to_owned()).collect(),
            frames: vec![Frame { time, agents: vec![at(10.0, 20.0), at(0.0, 1.0)], ..Frame::default() }],
        };
        let both = run(&["a", "b"], 0.0);
        let placed = read(rows).unwrap().placed(CoordinateOrigin::Start, &both).unwrap();
        assert_eq!(placed.of("a"), [(0.0, vec2(10.0, 20.0)), (0.1, vec2(10.25, 19.0))]);
        assert_eq!(placed.of("c"), []);
        let plane = read(rows).unwrap().placed(CoordinateOrigin::Plane, &both).unwrap();
        assert_eq!(plane.of("a")[1], (0.1, vec2(0.75, -1.0)));
        let message = |rows: &str, run: &Run| {
            read(rows).unwrap().placed(CoordinateOrigin::Start, run).err().unwrap().to_string()
        };
        assert!(message(rows, &run(&["a"], 0.0)).contains("no agent \"b\""));
        assert!(message(rows, &run(&["a", "b"], 2.0)).contains("the run goes from 2.0"));
        assert!(message("t,id,x,y\n0,a,0,0\n1,b,0,0\n", &both).contains("\"b\" is seen from t = 1.0"));
    }

    #[test]
    fn says_line_and_value() {
        let message = |text: &str| format!("{:#}", read(text).err().unwrap());
        assert!(message("t,id,x\n").contains("no column \"y\""));
        assert!(message("t,id,x,y\n").contains("holds no row"));
        assert!(message("t,id,x,y\n0,a,nan,0\n").contains("line 2: x=\"nan\""));
        assert!(message("t,id,x,y\n1,a,0,0\n1,a,0,0\n").contains("line 3: t=1"));
    }
}
