//! `lemons run --accuracy`: two runs, with a mechanical step for the accuracy and with half of it.

use super::job::{EndedRun, RunJob, simulate};
use super::recorder::{Poses, RowTarget};
use crate::error::Misused;
use crate::interrupt::{Interrupt, Interrupted};
use anyhow::{Result, bail};
use lemons_master::RunSettings;
use lemons_results::KeptFrames;

/// The parameter that is chosen.
const STEP: &str = "TimeStepMechanical";

/// Mechanical steps \[s\] of a run, by the name of the parameter.
pub type Chosen = Vec<(String, f64)>;

/// Where two runs of a crowd differ.
#[derive(Debug, Clone, PartialEq)]
struct Difference {
    /// \[m\] The largest one: how far a point of a body is from where it is in the other run.
    largest: f64,
    /// Place of the agent, and time \[s\] of it.
    at: (usize, f64),
    /// Place of the first agent that is further apart than the limit, and the first time \[s\].
    first: Option<(usize, f64)>,
}

impl Difference {
    /// Compares the poses of two runs, with the limit \[m\] of the distance.
    fn of(run: &Poses, others: &Poses, limit: f64) -> Difference {
        let mut difference = Difference { largest: 0.0, at: (0, 0.0), first: None };
        for ((time, poses), (_, others)) in run.points.iter().zip(&others.points) {
            for (agent, (pose, other)) in poses.iter().zip(others).enumerate() {
                let apart = pose.apart(other, run.rims.as_ref().map_or(0.0, |rims| rims[agent]));
                if apart > difference.largest {
                    (difference.largest, difference.at) = (apart, (agent, *time));
                }
                if apart > limit {
                    difference.first.get_or_insert((agent, *time));
                }
            }
        }
        difference
    }
}

/// Runs for an accuracy \[m\]: the results are those of the finer run.
pub fn run_for(accuracy: f64, job: RunJob, interrupt: &Interrupt) -> Result<EndedRun> {
    let named = |name: &str, what: &str| name == what || name.ends_with(&format!(".{what}"));
    if let Some((name, value)) = job.settings.parameters.iter().find(|(name, _)| named(name, STEP)) {
        bail!(Misused(format!("--set {name}={value}: --accuracy chooses the mechanical step")));
    }
    let mut parameters = job.settings.parameters.clone();
    // XML is written by the finer run only.
    parameters.retain(|(name, _)| !named(name, "OutputDirectory"));
    let settings =
        RunSettings { parameters, tolerance: Some(accuracy), saves: false, ..job.settings.clone() };
    let rows = RowTarget::Memory(KeptFrames::Around(Vec::new()));
    let first = RunJob { settings, rows, outputs: None, either: false, state: None, until: job.until };
    let coarse = simulate(first, interrupt)?;
    if let Some(time) = coarse.stopped {
        let stopped = format!("stopped at t = {time:?} s of the first of two runs; nothing is written");
        return Err(Interrupted(stopped).into());
    }
    let EndedRun { poses, mechanical_steps: chosen, step, .. } = coarse;
    let mut settings = RunSettings { tolerance: Some(accuracy), ..job.settings.clone() };
    let halves: Chosen = chosen.iter().map(|(name, longest)| (name.clone(), half(step, *longest))).collect();
    settings.parameters.extend(halves.iter().map(|(name, half)| (name.clone(), format!("{half:?}"))));
    let mut fine = simulate(RunJob { settings, ..job }, interrupt)?;
    fine.summary.extend(report(accuracy, &chosen, &halves, &fine.poses, &poses));
    Ok(fine)
}

/// \[s\] Half of a step. A communication step \[s\] has a whole number of them: where there are few, half of the step that
/// is really used.
fn half(communication: f64, longest: f64) -> f64 {
    let steps = (communication / longest - 1e-9).ceil().max(1.0);
    if steps > 10.0 { 0.5 * longest } else { 0.5 * communication / steps }
}

fn report(accuracy: f64, chosen: &Chosen, halves: &Chosen, fine: &[Poses], coarse: &[Poses]) -> Vec<String> {
    let mut lines = Vec::new();
    for ((name, step), (_, half)) in chosen.iter().zip(halves) {
        let step = format!("{step:e}");
        let of = name.strip_suffix(&format!(".{STEP}")).map(|name| format!(" of {name}")).unwrap_or_default();
        lines.push(format!(
            "mechanical steps   {step:>10} s and {half:e} s{of}: the results are of the second run"
        ));
    }
    let millimetres = |length: f64| format!("{:.3e} mm", 1e3 * length);
    let limit = millimetres(accuracy);
    for (fine, coarse) in fine.iter().zip(coarse) {
        let Difference { largest, at: (agent, time), first } = Difference::of(fine, coarse, accuracy);
        let what = if fine.rims.is_some() { "a point" } else { "the position" };
        lines.push(if largest > 0.0 {
            let (largest, agent) = (millimetres(largest), &fine.ids[agent]);
            format!("they differ by     {largest:>10}   at most ({what} of agent {agent}, t = {time:.3} s)")
        } else {
            "they differ by nothing at any communication point".to_owned()
        });
        lines.push(match first {
            None => format!("accuracy           {limit:>10}   is met"),
            Some((agent, time)) => {
                let agent = &fine.ids[agent];
                format!("accuracy           {limit:>10}   is not met: agent {agent} is further apart from t = {time:.3} s on")
            }
        });
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use lemons_core::plane::{Pose, vec2};

    #[test]
    fn the_largest_difference_and_the_first_beyond_are_found() {
        let poses = |points: [[(f64, f64); 2]; 3]| {
            let pose = |(x, orientation)| Pose { position: vec2(x, 0.0), orientation };
            let points = points.iter().zip([0.0, 1.0, 2.0]);
            let points = points.map(|(poses, time)| (time, poses.map(pose).to_vec())).collect();
            Poses { points, ..Poses::default() }
        };
        let coarse = poses([[(0.0, 0.0), (5.0, 0.0)], [(1.0, 0.0), (5.0, 0.0)], [(2.0, 0.0), (5.0, 0.0)]]);
        let fine = poses([[(0.0, 0.0), (5.0, 3.0)], [(1.2, 0.0), (5.0, 0.0)], [(2.0, 0.0), (5.5, 0.0)]]);
        let expected = Difference { largest: 0.5, at: (1, 2.0), first: Some((0, 1.0)) };
        assert_eq!(Difference::of(&fine, &coarse, 0.1), expected);
        // A point of a body that has turned is apart, too.
        let fine = Poses { rims: Some(vec![0.25; 2]), ..fine };
        assert!(Difference::of(&fine, &coarse, 0.1).first == Some((1, 0.0)));
    }

    #[test]
    fn half_is_half_of_the_step_that_is_used() {
        assert_eq!(half(0.05, 4.8e-5), 2.4e-5);
        // A communication step of 1e-4 s takes three steps of at most 4.8e-5 s, and then six.
        assert!((half(1e-4, 4.8e-5) - 1e-4 / 6.0).abs() < 1e-18);
        assert_eq!(half(1e-5, 4.8e-5), 5e-6);
    }
}
