//! What a run records: trajectories of crowds, outputs of the others.

use crate::connect::plain_names;
pub use crate::crowd_run::Recorded;
use crate::crowd_run::{Crowd, Point, Target, agents_of};
use crate::error::and_then;
use crate::files;
use crate::outputs::Outputs;
use crate::recording::Recording;
use crate::results::Place;
use anyhow::{Result, bail};
use lemons_master::{CrowdRecord, System};
use lemons_plane::Vec2;
use lemons_record::Wanted;
use lemons_trial::Trial;
use std::path::{Path, PathBuf};

/// Where the records of a run go.
pub enum Places {
    Files {
        /// Of crowds.
        trajectories: Place,
        /// Of the others.
        outputs: Place,
    },
    /// Frames of a crowd that are wanted.
    Memory(Wanted),
}

/// What is recorded of a run.
pub struct Watch {
    /// With the component's name if there are several.
    crowds: Vec<(Option<String>, Crowd)>,
    outputs: Option<Outputs>,
}

impl Watch {
    /// Of an initialized system, with the Trials that its components run.
    pub fn create(
        system: &System,
        trials: Vec<Option<Trial>>,
        places: Places,
        mut recording: Recording<'_>,
    ) -> Result<Watch> {
        let agents: Vec<usize> =
            system.components().iter().map(|component| agents_of(&component.fmu.description)).collect();
        let several = agents.iter().filter(|agents| **agents > 0).count() > 1;
        let mut crowds = Vec::new();
        let mut others = Vec::new();
        let names = plain_names(system.components().iter().map(|component| component.name.as_str()));
        for (place, trial) in trials.into_iter().enumerate() {
            if agents[place] == 0 {
                others.push(place);
                continue;
            }
            let to = match &places {
                Places::Files { trajectories, .. } if several => {
                    if files::is_standard_output(&trajectories.path) {
                        bail!("-o -: several crowds do not go to standard output together: -o FILE");
                    }
                    let path = with_name(&trajectories.path, &names[place]);
                    Target::Table(Place { path, ..trajectories.clone() })
                }
                Places::Files { trajectories, .. } => Target::Table(trajectories.clone()),
                Places::Memory(wanted) => Target::Memory(wanted.clone()),
            };
            let name = several.then(|| system.components()[place].name.clone());
            crowds.push((name, Crowd::create(system, place, agents[place], trial, to, &mut recording)?));
        }
        let outputs = match &places {
            Places::Files { outputs, .. } => Outputs::create(system, others, outputs, &mut recording)?,
            Places::Memory(_) => None,
        };
        Ok(Watch { crowds, outputs })
    }

    /// At a communication point.
    pub fn look(&mut self, system: &System, point: Point) -> Result<()> {
        let wanted = point != Point::Passed;
        for (_, crowd) in &mut self.crowds {
            crowd.look(system, point)?;
        }
        match &mut self.outputs {
            Some(outputs) if wanted => outputs.look(system),
            _ => Ok(()),
        }
    }

    /// Whether people may leave: another component says who is there.
    pub fn may_leave(&self) -> bool {
        self.crowds.iter().any(|(_, crowd)| crowd.may_leave())
    }

    /// How many there are in crowds that people may leave.
    pub fn people(&self) -> usize {
        self.crowds.iter().filter(|(_, crowd)| crowd.may_leave()).map(|(_, crowd)| crowd.people()).sum()
    }

    /// \[m\] Where everybody was at the last look; `None` of those who have left.
    pub fn standing(&self) -> Vec<Option<Vec2>> {
        self.crowds.iter().flat_map(|(_, crowd)| crowd.standing()).copied().collect()
    }

    /// Ids of everybody, in the same order.
    pub fn ids(&self) -> impl Iterator<Item = &str> {
        self.crowds.iter().flat_map(|(_, crowd)| crowd.ids())
    }

    /// Whether somebody of any crowd moved at the last look.
    pub fn moves(&self) -> bool {
        self.crowds.iter().any(|(_, crowd)| crowd.moves())
    }

    /// What a saved run keeps of each crowd.
    pub fn records(&self, system: &System) -> Vec<CrowdRecord> {
        let crowds = self.crowds.iter().map(|(_, crowd)| {
            let name = &system.components()[crowd.place()].name;
            crowd.record(name)
        });
        crowds.collect()
    }

    /// Puts each file in its place, also when that of another cannot be taken.
    pub fn finish(self) -> Recorded {
        let mut all = Recorded { lines: Vec::new(), run: None, poses: Vec::new(), placed: Ok(()) };
        for (name, crowd) in self.crowds {
            all.lines.extend(name.map(|name| format!("crowd              {name}")));
            let Recorded { lines, run, poses, placed } = crowd.finish();
            all.poses.extend(poses);
            all.lines.extend(lines);
            all.run = all.run.or(run);
            all.placed = and_then(all.placed, placed);
        }
        if let Some(outputs) = self.outputs {
            match outputs.finish() {
                Ok(line) => all.lines.push(line),
                Err(error) => all.placed = and_then(all.placed, Err(error)),
            }
        }
        all
    }
}

/// `dir/file.csv` -> `dir/file_name.csv`
fn with_name(path: &Path, name: &str) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let end = path.extension().map(|end| format!(".{}", end.to_string_lossy())).unwrap_or_default();
    path.with_file_name(format!("{stem}_{name}{end}"))
}
