//! Pulses: forces that rise and fall, on those who stand in a circle.

use crate::plane::Vec2;
use crate::trial::documents::Trial;
use crate::trial::drive::DriveTable;
use std::f64::consts::PI;
use std::fmt::Write as _;

/// \[s\] A drive that goes on has a row at this time.
const EVER: f64 = 1e6;
/// Straight pieces of a pulse. Its impulse is that of the half sine but for 0.3 %.
const PIECES: u32 = 16;
const HEAD: &str = "t,agent,Fp.x,Fp.y,Mp\n";

/// A half sine of force, on each agent whose centre lies in a circle at the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pulse {
    /// \[m\] Middle of the circle.
    pub at: Vec2,
    /// \[m\]
    pub radius: f64,
    /// \[N\] The greatest force on each of them.
    pub force: Vec2,
    /// \[s\]
    pub start: f64,
    /// \[s\]
    pub duration: f64,
}

impl Pulse {
    fn reaches(&self, place: Vec2) -> bool {
        (place - self.at).norm() <= self.radius
    }

    /// \[N\]
    fn at_time(&self, time: f64) -> Vec2 {
        let share = (time - self.start) / self.duration;
        if (0.0..=1.0).contains(&share) { self.force * libm::sin(PI * share) } else { Vec2::zeros() }
    }

    /// \[s\] Where its straight pieces begin and end.
    fn times(&self) -> impl Iterator<Item = f64> {
        let Pulse { start, duration, .. } = *self;
        (0..=PIECES).map(move |k| start + duration * f64::from(k) / f64::from(PIECES))
    }
}

/// Returns the drive of pulses: they act besides what AgentDynamics.xml says, which goes on before and after them.
///
/// # Errors
/// The place of a pulse that reaches nobody.
pub fn drive_of_pulses(trial: &Trial, pulses: &[Pulse]) -> Result<DriveTable, usize> {
    let mut drive = DriveTable::default();
    let reached = |pulse: &Pulse| trial.dynamics.iter().any(|here| pulse.reaches(here.position));
    if let Some(lost) = pulses.iter().position(|pulse| !reached(pulse)) {
        return Err(lost);
    }
    for (agent, here) in trial.agents.iter().zip(&trial.dynamics) {
        let own: Vec<&Pulse> = pulses.iter().filter(|pulse| pulse.reaches(here.position)).collect();
        if own.is_empty() {
            continue;
        }
        let mut times: Vec<f64> = own.iter().flat_map(|pulse| pulse.times()).chain([0.0, EVER]).collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        let row = |time: f64| {
            let sum = own.iter().fold(here.fp, |sum, pulse| sum + pulse.at_time(time));
            (time, [sum.x, sum.y, here.mp])
        };
        drive.add(&agent.id, times.into_iter().map(row).collect());
    }
    Ok(drive)
}

impl DriveTable {
    /// Returns the drive file of those agents whom the Trial has; empty if it names none of them. Numbers are read back as
    /// the same doubles.
    pub fn text_for(&self, trial: &Trial) -> String {
        let mut text = String::new();
        for agent in &trial.agents {
            // With quotes, an Id may have any characters.
            let id = agent.id.replace('"', "\"\"");
            for (time, [x, y, torque]) in self.rows(&agent.id).unwrap_or_default() {
                // Writing to a text cannot fail.
                let _ = writeln!(text, "{time:?},\"{id}\",{x:?},{y:?},{torque:?}");
            }
        }
        if text.is_empty() { text } else { HEAD.to_owned() + &text }
    }
}
