//! What a run records: trajectories of crowds, outputs of the others.

use crate::connect::plain_names;
use crate::crowd::{Crowd, agents_of};
use crate::outputs::Outputs;
use crate::recording::Recording;
use crate::results::{Extent, Place};
use anyhow::Result;
use crowd_mechanics::trial::Trial;
use lemons_master::{CrowdRecord, System};
use std::path::{Path, PathBuf};

/// What has been written of crowds and of the others.
pub type Records = (Vec<CrowdRecord>, Option<Extent>);

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
        trajectories: &Place,
        outputs: &Place,
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
            let mut to = trajectories.clone();
            if several {
                to.path = with_name(&to.path, &names[place]);
            }
            let name = several.then(|| system.components()[place].name.clone());
            crowds.push((name, Crowd::create(system, place, agents[place], trial, &to, &mut recording)?));
        }
        Ok(Watch { crowds, outputs: Outputs::create(system, others, outputs, &mut recording)? })
    }

    /// At a communication point, whose rows may be wanted or not.
    pub fn look(&mut self, system: &System, wanted: bool) -> Result<()> {
        for (_, crowd) in &mut self.crowds {
            crowd.look(system, wanted)?;
        }
        match &mut self.outputs {
            Some(outputs) if wanted => outputs.look(system),
            _ => Ok(()),
        }
    }

    /// Whether somebody of any crowd moved at the last look.
    pub fn moves(&self) -> bool {
        self.crowds.iter().any(|(_, crowd)| crowd.moves())
    }

    /// What a saved run keeps: of each crowd, and of the outputs of the others.
    pub fn records(&self, system: &System) -> Records {
        let crowds = self.crowds.iter().map(|(_, crowd)| {
            let name = &system.components()[crowd.place()].name;
            crowd.record(name)
        });
        (crowds.collect(), self.outputs.as_ref().map(Outputs::extent))
    }

    /// Puts all files in their places; answers lines of the summary.
    pub fn finish(self) -> Result<Vec<String>> {
        let mut lines = Vec::new();
        for (name, crowd) in self.crowds {
            lines.extend(name.map(|name| format!("crowd              {name}")));
            lines.extend(crowd.finish()?);
        }
        if let Some(outputs) = self.outputs {
            lines.push(outputs.finish()?);
        }
        Ok(lines)
    }
}

/// `dir/file.csv` -> `dir/file_name.csv`
fn with_name(path: &Path, name: &str) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let end = path.extension().map(|end| format!(".{}", end.to_string_lossy())).unwrap_or_default();
    path.with_file_name(format!("{stem}_{name}{end}"))
}
