//! A recorded run that is read frame by frame, as often as needed.

use crate::error::RecordError;
use crate::run::{Frame, Run, order_of, sorted};
use lemons_core::plane::{Motion, Vec2};
use lemons_core::trial::Trial;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// Called with each frame.
pub(crate) type Each<'a> = dyn FnMut(Frame) -> Result<(), RecordError> + 'a;
/// Reads all frames in the order of time and returns the Ids of the agents.
type Pass = dyn Fn(&mut Each<'_>) -> Result<Vec<String>, RecordError>;

/// Properties of trajectories besides their frames.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectories {
    /// \[1/s\] Frames per second.
    pub rate: f64,
    /// Number of frames before and after a frame between which velocities are differences: `frame_step` of PedPy's
    /// `compute_individual_speed`, there with `SpeedCalculation.BORDER_SINGLE_SIDED`.
    pub velocity_frames: usize,
    /// Whether the file says where people look.
    pub oriented: bool,
    /// Where people can be: well-known text, in m, of each geometry that the file holds.
    pub geometry: Vec<String>,
    /// Assumptions, and what was left out.
    pub notes: Vec<String>,
}

impl Trajectories {
    /// \[s\] Returns the time over which velocities are differences.
    pub fn velocity_over(&self) -> f64 {
        (2 * self.velocity_frames) as f64 / self.rate
    }
}

/// A recorded run. Its frames stay in the file: in memory are the times, 8 bytes for each frame, and one frame while
/// it is read.
#[derive(Clone)]
pub struct Record {
    source: PathBuf,
    pass: Rc<Pass>,
    ids: Vec<String>,
    /// \[s\] of all frames.
    times: Vec<f64>,
    first: Vec<Motion>,
    contacts: bool,
    /// Places of the agents in the source.
    order: Vec<usize>,
    /// Only every so many frames count.
    every: usize,
    /// If they are not of one of our runs.
    trajectories: Option<Rc<Trajectories>>,
}

/// \[s\] Names of files hold nine decimals.
const ROUNDING: f64 = 2e-9;

impl Record {
    /// Reads all frames once, to see that they are sound.
    pub(crate) fn new(
        source: &Path,
        pass: impl Fn(&mut Each<'_>) -> Result<Vec<String>, RecordError> + 'static,
    ) -> Result<Record, RecordError> {
        let (mut times, mut first, mut contacts) = (Vec::new(), Vec::new(), true);
        let ids = pass(&mut |frame| {
            if times.is_empty() {
                first.clone_from(&frame.agents);
            }
            times.push(frame.time);
            contacts &= frame.interactions.is_some();
            Ok(())
        })?;
        let (source, pass, order) = (source.to_owned(), Rc::new(pass), (0..ids.len()).collect());
        Ok(Record { source, pass, ids, times, first, contacts, order, every: 1, trajectories: None })
    }

    /// Says that they are not of one of our runs.
    pub(crate) fn of_trajectories(self, about: Trajectories) -> Record {
        Record { trajectories: Some(Rc::new(about)), ..self }
    }

    /// Returns what is known of trajectories that are not of one of our runs ([`Record::of_others`]).
    pub fn trajectories(&self) -> Option<&Trajectories> {
        self.trajectories.as_deref()
    }

    /// Returns the file or directory that it is read from.
    pub fn source(&self) -> &Path {
        &self.source
    }

    /// Returns the Ids of the agents, as in `Agents.xml`.
    pub fn ids(&self) -> &[String] {
        &self.ids
    }

    /// Returns the times of the frames \[s\]; at least one.
    pub fn times(&self) -> impl ExactSizeIterator<Item = f64> + Clone {
        self.times.iter().copied()
    }

    /// Returns everybody in the first frame.
    pub fn first(&self) -> &[Motion] {
        &self.first
    }

    /// Returns the number of frames.
    pub fn frames(&self) -> usize {
        self.times.len()
    }

    /// Returns whether all frames have contacts with their springs ([`Frame::interactions`]).
    pub fn contacts(&self) -> bool {
        self.contacts
    }

    /// Leaves only every `n`-th frame, beginning with the first.
    #[must_use]
    pub fn every(self, n: usize) -> Record {
        let n = n.max(1);
        let times = self.times.into_iter().step_by(n).collect();
        Record { times, every: self.every.saturating_mul(n), ..self }
    }

    /// Puts the agents in the order of a Trial.
    ///
    /// # Errors
    /// The agents are not those of the Trial.
    pub fn of_trial(self, trial: &Trial) -> Result<Record, RecordError> {
        let order = order_of(&self.ids, trial, &self.source)?;
        let (ids, first) = (sorted(&self.ids, &order), sorted(&self.first, &order));
        Ok(Record { ids, first, order: sorted(&self.order, &order), ..self })
    }

    /// Returns the agents' Ids as numbers; `None` unless all are different whole numbers from 0 on.
    pub fn numeric_ids(&self) -> Option<Vec<i64>> {
        let number = |id: &String| id.parse().ok().filter(|id| *id >= 0);
        let numbers: Vec<i64> = self.ids.iter().map(number).collect::<Option<_>>()?;
        let different: BTreeSet<_> = numbers.iter().collect();
        (different.len() == numbers.len()).then_some(numbers)
    }

    /// Returns the numbers of the agents: their Ids, or else their places, from 0.
    pub fn numbers(&self) -> Vec<i64> {
        self.numeric_ids().unwrap_or_else(|| (0..self.ids.len() as i64).collect())
    }

    /// Reads all frames in the order of time and calls `what` with the number of the frame, from 0, and the frame.
    ///
    /// # Errors
    /// The file was changed since it was opened, or `what` fails.
    pub fn each(
        &self,
        mut what: impl FnMut(usize, Frame) -> Result<(), RecordError>,
    ) -> Result<(), RecordError> {
        let changed = || RecordError::wrong(&self.source, "was changed while it was read");
        let (mut read, mut kept) = (0, 0);
        let ids = (self.pass)(&mut |frame| {
            read += 1;
            if (read - 1) % self.every != 0 {
                return Ok(());
            }
            if self.times.get(kept) != Some(&frame.time) || frame.agents.len() != self.ids.len() {
                return Err(changed());
            }
            kept += 1;
            what(kept - 1, frame.sorted(&self.order))
        })?;
        let same = ids.len() == self.ids.len() && sorted(&ids, &self.order) == self.ids;
        if same && kept == self.times.len() { Ok(()) } else { Err(changed()) }
    }

    /// An error of a frame.
    pub(crate) fn wrong_at(&self, place: usize, message: impl FnOnce(&str) -> String) -> RecordError {
        let mut found = String::new();
        let read = self.each(|k, frame| {
            if k == place {
                found = frame.place;
            }
            Ok(())
        });
        read.err().unwrap_or_else(|| RecordError::wrong(&self.source, message(&found)))
    }

    /// \[1/s\] Number of frames per second.
    ///
    /// # Errors
    /// There is only one frame, or the times between frames are not equal.
    pub fn frame_rate(&self) -> Result<f64, RecordError> {
        if let Some(trajectories) = &self.trajectories {
            return Ok(trajectories.rate / self.every as f64);
        }
        let (first, last) = (self.times[0], self.times[self.times.len() - 1]);
        let wrong = |message: String| Err(RecordError::wrong(&self.source, message));
        let Some(second) = self.times.get(1) else {
            return wrong(format!("has one frame only, at t = {first:?} s: no frame rate"));
        };
        let step = second - first;
        for (k, pair) in (1..).zip(self.times.windows(2)) {
            let (time, gap) = (pair[1], pair[1] - pair[0]);
            if (gap - step).abs() > 1e-6 * step + ROUNDING {
                return Err(self.wrong_at(k, |place| {
                    format!(
                        "{place}: column t: t = {time:?} s comes {gap:.6} s after the frame before, the others \
                         {step:.6} s: the format needs a constant frame rate (a run's last step is shortened if \
                         --until is no multiple of --step; --every N may leave it out)"
                    )
                }));
            }
        }
        // Sums of steps are rounded; the step that was meant has few decimals, or its rate has none.
        let mean = (last - first) / (self.frames() - 1) as f64;
        let (whole, decimal) = (mean.recip().round(), (mean * 1e9).round() / 1e9);
        let near = |value: f64, within: f64| (value - mean).abs() < within * mean;
        let rate = if near(whole.recip(), 1e-6) {
            whole
        } else if near(decimal, 1e-10) {
            decimal.recip()
        } else {
            mean.recip()
        };
        if rate > 0.0 && rate.is_finite() {
            return Ok(rate);
        }
        wrong(format!("the time between its frames is {step:?} s, which gives no usable frame rate"))
    }

    /// Returns the number of the first frame in files that number frames: 0 for a run of ours; for trajectories that of its
    /// time, if this is a whole number.
    pub(crate) fn first_number(&self) -> i64 {
        let number = self.first_place();
        if (number - number.round()).abs() < 1e-6 { number.round() as i64 } else { 0 }
    }

    /// \[s\] Returns the time of the first frame where files that number frames begin at 0 s all the same: its number would not
    /// be whole.
    pub fn lost_time(&self) -> Option<f64> {
        (self.first_number() == 0 && self.first_place() >= 1e-6).then(|| self.times[0])
    }

    fn first_place(&self) -> f64 {
        self.trajectories.as_ref().map_or(0.0, |all| self.times[0] * all.rate / self.every as f64)
    }

    /// \[m\] Positions of everybody who is there, in the order of time and of agents.
    ///
    /// # Errors
    /// As [`Record::each`].
    pub fn positions(&self) -> Result<Vec<Vec2>, RecordError> {
        let mut all = Vec::new();
        self.each(|_, frame| {
            all.extend(frame.present().map(|(_, agent)| agent.pose.position));
            Ok(())
        })?;
        Ok(all)
    }
}

/// A run in memory, too.
impl From<Run> for Record {
    fn from(run: Run) -> Record {
        let Run { source, ids, frames } = run;
        let pass = move |each: &mut Each<'_>| {
            frames.iter().try_for_each(|frame| each(frame.clone()))?;
            Ok(ids.clone())
        };
        Record::new(&source, pass).expect("frames in memory are read without an error")
    }
}
