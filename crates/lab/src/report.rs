//! The report of a run, which is made again from its beginning.

use crate::run::LabRun;
use crate::{Refused, Reply, require};
use lemons_core::trial::Problem;
use lemons_people::placing::{PlacingProgress, Stage, Watch};
use lemons_report::{Report, RunSeen, Settings, Told};
use lemons_sim::Until;
use lemons_sim::lint::{self, Files};
use std::path::Path;

/// \[s\] Longest run.
const LONGEST: f64 = 1e6;

/// Makes the report up to a time \[s\], with a limit of the squeeze \[N\] of means over a time \[s\].
///
/// # Errors
/// The run cannot be made, or `watch` stopped it.
pub fn report(run: &LabRun, until: f64, limit: [f64; 2], watch: &mut Watch) -> Result<Reply, Refused> {
    run.check_work()?;
    crate::within("time of the report [s]", until, [0.0, LONGEST])?;
    crate::within("limit of the squeeze [N]", limit[0], [0.0, 1e9])?;
    crate::within("time of means [s]", limit[1], [1e-3, 1e4])?;
    let (documents, files) = (run.loaded.documents(), Files::within(Path::new("")));
    let step = documents.trial.parameters.time_step;
    let mut found = lint::of_documents(&documents, &files);
    found.extend(lint::of_step(&documents, step, &files));
    let told = Told {
        title: documents.trial.name.clone(),
        program: format!("LEMONS {}", env!("CARGO_PKG_VERSION")),
        warnings: found.iter().map(Problem::told).collect(),
        ..Told::default()
    };
    // Before it is played there is only its beginning; a step is the shortest run.
    let settings = Settings { until: Until::Time(until.max(step)), limit: (limit[0], limit[1]) };
    let mut watch = |time: f64| {
        let (iteration, limit) = ((time / step) as u64, (until / step) as u64);
        // Without a stage of its own: the page knows it by the overlap.
        let (stage, overlap, density) = (Stage::Growing, f64::NAN, 0.0);
        watch(&PlacingProgress { stage, iteration, limit, overlap, density })
    };
    let seen = RunSeen::run(documents, None, settings, &mut watch)?;
    require(seen.is_some(), || "the report was stopped".to_owned())?;
    Reply::of(Report::of(&told, seen.as_slice()))
}
