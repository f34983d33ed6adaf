//! `lemons run --accuracy`: two runs, with a mechanical step for the accuracy and with half of it.

use super::{Ended, Job, Target, interrupted, simulate};
use crate::compared::{Difference, Poses, Seen};
use crate::error::Misused;
use crate::interrupt::Interrupt;
use anyhow::{Result, bail};
use lemons_master::Settings;
use lemons_results::Wanted;

/// The parameter that is chosen.
const STEP: &str = "TimeStepMechanical";

/// Mechanical steps \[s\] of a run, by the name of the parameter.
pub type Chosen = Vec<(String, f64)>;

/// Runs for an accuracy \[m\]: the results are those of the finer run.
pub fn run_for(accuracy: f64, job: Job, interrupt: &Interrupt) -> Result<Ended> {
    let named = |name: &str, what: &str| name == what || name.ends_with(&format!(".{what}"));
    if let Some((name, value)) = job.settings.parameters.iter().find(|(name, _)| named(name, STEP)) {
        bail!(Misused(format!("--set {name}={value}: --accuracy chooses the mechanical step")));
    }
    let mut parameters = job.settings.parameters.clone();
    // XML is written by the finer run only.
    parameters.retain(|(name, _)| !named(name, "OutputDirectory"));
    let settings = Settings { parameters, tolerance: Some(accuracy), saves: false, ..job.settings.clone() };
    let rows = Target::Memory(Wanted::Around(Vec::new()));
    let first = Job { settings, rows, outputs: None, state: None, poses: Poses::Keep, ends: job.ends };
    let coarse = simulate(first, interrupt)?;
    if let Some(time) = coarse.stopped {
        return Err(interrupted(format!(
            "stopped at t = {time:?} s of the first of two runs; nothing is written"
        )));
    }
    let Ended { poses, mechanical_steps: chosen, step, .. } = coarse;
    let kept = poses.into_iter().filter_map(|seen| match seen {
        Seen::Kept(kept) => Some(kept),
        Seen::Compared(_) => None,
    });
    let poses = Poses::Compare(kept.collect(), accuracy);
    let mut settings = Settings { tolerance: Some(accuracy), ..job.settings.clone() };
    let halves: Chosen = chosen.iter().map(|(name, longest)| (name.clone(), half(step, *longest))).collect();
    settings.parameters.extend(halves.iter().map(|(name, half)| (name.clone(), format!("{half:?}"))));
    let mut ended = simulate(Job { settings, poses, ..job }, interrupt)?;
    let differences: Vec<Difference> = std::mem::take(&mut ended.poses)
        .into_iter()
        .filter_map(|seen| match seen {
            Seen::Compared(difference) => Some(difference),
            Seen::Kept(_) => None,
        })
        .collect();
    ended.compared = report(accuracy, &chosen, &halves, &differences);
    Ok(ended)
}

/// \[s\] Half of a step. A communication step \[s\] has a whole number of them: where there are few, half of the step that
/// is really used.
fn half(communication: f64, longest: f64) -> f64 {
    let steps = (communication / longest - 1e-9).ceil().max(1.0);
    if steps > 10.0 { 0.5 * longest } else { 0.5 * communication / steps }
}

fn report(accuracy: f64, chosen: &Chosen, halves: &Chosen, differences: &[Difference]) -> Vec<String> {
    let mut lines = Vec::new();
    for ((name, step), (_, half)) in chosen.iter().zip(halves) {
        let step = format!("{step:e}");
        let of = name.strip_suffix(&format!(".{STEP}")).map(|name| format!(" of {name}")).unwrap_or_default();
        lines.push(format!(
            "mechanical steps   {step:>10} s and {half:e} s{of}: the results are of the second run"
        ));
    }
    let millimetres = |length: f64| format!("{:.3e} mm", 1e3 * length);
    let wished = millimetres(accuracy);
    for Difference { largest, at: (agent, time), first, with_shapes } in differences {
        let what = if *with_shapes { "a point" } else { "the position" };
        lines.push(if *largest > 0.0 {
            let largest = millimetres(*largest);
            format!("they differ by     {largest:>10}   at most ({what} of agent {agent}, t = {time:.3} s)")
        } else {
            "they differ by nothing at any communication point".to_owned()
        });
        lines.push(match first {
            None => format!("accuracy           {wished:>10}   is met"),
            Some((agent, time)) => {
                format!("accuracy           {wished:>10}   is not met: agent {agent} is further apart from t = {time:.3} s on")
            }
        });
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_is_half_of_the_step_that_is_used() {
        assert_eq!(half(0.05, 4.8e-5), 2.4e-5);
        // A communication step of 1e-4 s takes three steps of at most 4.8e-5 s, and then six.
        assert!((half(1e-4, 4.8e-5) - 1e-4 / 6.0).abs() < 1e-18);
        assert_eq!(half(1e-5, 4.8e-5), 5e-6);
    }
}
