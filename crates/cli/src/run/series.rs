//! The files that crowds write themselves, at each communication point, into their OutputDirectory.

use crate::files;
use anyhow::{Context, Result};
use lemons_master::{Clock, Progress, System};
use lemons_trial::{Trial, output_names};
use std::path::{Path, PathBuf};

const DIRECTORY: &str = "OutputDirectory";

/// Whether a run writes a file of this name, with this time \[s\].
pub fn writes(clock: &Clock, name: &str, time: f64) -> bool {
    let step = ((time - clock.start) / clock.step).round();
    let end = clock.end((step as u64).saturating_sub(1));
    [end, clock.until].iter().any(|&end| output_names(end).iter().any(|own| own == name))
}

/// Claims the directories of an initialized system. Returns files of the same command's earlier run: they are of times
/// to which this run comes.
pub fn claim(system: &System, trials: &[Option<Trial>], progress: &Progress) -> Result<Vec<PathBuf>> {
    let (clock, now) = (&progress.clock, system.time());
    let goes_on = progress.index > 0;
    let mut left = Vec::new();
    for (component, _) in system.components().iter().zip(trials).filter(|(_, trial)| trial.is_some()) {
        if component.fmu.kind(DIRECTORY).is_none() {
            continue;
        }
        let name = component.instance.text(DIRECTORY)?;
        if name.is_empty() {
            continue;
        }
        let before = |time: f64| goes_on && time <= now + 1e-9;
        let is_own = |name: &str, time: Option<f64>| {
            time.is_some_and(|time| before(time) || writes(clock, name, time))
        };
        let later = |name: &str| !lemons_record::series_time(name).is_some_and(before);
        left.extend(files::claim_series(Path::new(&name), is_own, later).context(DIRECTORY)?);
    }
    Ok(left)
}

/// Removes what an earlier run left: a run that is stopped must not leave it among its own files.
pub fn remove(left: &[PathBuf]) -> Result<()> {
    let cannot = |path: &Path| format!("{DIRECTORY}: cannot remove {}", path.display());
    left.iter().try_for_each(|path| std::fs::remove_file(path).with_context(|| cannot(path)))
}
