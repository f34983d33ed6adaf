//! A recorded run that is read frame by frame, as often as needed.

use crate::error::RecordError;
use crate::run::{Frame, Run, numeric, order_of, sorted};
use lemons_core::plane::{Motion, Vec2};
use lemons_core::trial::Trial;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// What is done with each frame.
pub(crate) type Each<'a> = dyn FnMut(Frame) -> Result<(), RecordError> + 'a;
/// Reads all frames in the order of time and returns the Ids of the agents.
type Pass = dyn Fn(&mut Each<'_>) -> Result<Vec<String>, RecordError>;

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
        Ok(Record { source: source.to_owned(), pass: Rc::new(pass), ids, times, first, contacts })
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
        let (pass, n) = (self.pass, n.max(1));
        let times = self.times.into_iter().step_by(n).collect();
        let pass = move |each: &mut Each<'_>| {
            let mut places = 0_usize..;
            pass(&mut |frame| {
                if places.next().is_some_and(|place| place % n == 0) { each(frame) } else { Ok(()) }
            })
        };
        Record { pass: Rc::new(pass), times, ..self }
    }

    /// Puts the agents in the order of a Trial.
    ///
    /// # Errors
    /// The agents are not those of the Trial.
    pub fn of_trial(self, trial: &Trial) -> Result<Record, RecordError> {
        let order = order_of(&self.ids, trial, &self.source)?;
        if order.iter().copied().eq(0..self.ids.len()) {
            return Ok(self);
        }
        let (pass, count) = (self.pass, self.ids.len());
        let first = order.iter().map(|&place| self.first[place]).collect();
        let ids = sorted(&self.ids, &order);
        let source = self.source.clone();
        let pass = move |each: &mut Each<'_>| {
            let mut checked = |frame: Frame| match frame.agents.len() == count {
                true => each(frame.sorted(&order)),
                false => Err(changed(&source)),
            };
            let ids = pass(&mut checked)?;
            if ids.len() == count { Ok(sorted(&ids, &order)) } else { Err(changed(&source)) }
        };
        Ok(Record { pass: Rc::new(pass), ids, first, ..self })
    }

    /// Returns the agents' Ids as numbers; `None` unless all are different whole numbers from 0 on.
    pub fn numeric_ids(&self) -> Option<Vec<i64>> {
        numeric(&self.ids)
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
        let mut read = 0;
        let ids = (self.pass)(&mut |frame| {
            read += 1;
            if self.times.get(read - 1) != Some(&frame.time) || frame.agents.len() != self.ids.len() {
                return Err(changed(&self.source));
            }
            what(read - 1, frame)
        })?;
        if read == self.times.len() && ids == self.ids { Ok(()) } else { Err(changed(&self.source)) }
    }

    /// Reads the frames with the wanted numbers into memory.
    ///
    /// # Errors
    /// As [`Record::each`].
    pub fn read(&self, wanted: impl Fn(usize) -> bool) -> Result<Run, RecordError> {
        let mut frames = Vec::new();
        self.each(|k, frame| {
            frames.extend(wanted(k).then_some(frame));
            Ok(())
        })?;
        Ok(Run { source: self.source.clone(), ids: self.ids.clone(), frames })
    }

    /// An error of a frame.
    pub(crate) fn wrong_at(&self, place: usize, message: impl FnOnce(&str) -> String) -> RecordError {
        match self.read(|k| k == place) {
            Ok(run) => {
                let place = run.frames.first().map_or("", |frame| frame.place.as_str());
                RecordError::wrong(&self.source, message(place))
            }
            Err(error) => error,
        }
    }

    /// \[1/s\] Number of frames per second.
    ///
    /// # Errors
    /// There is only one frame, or the times between frames are not equal.
    pub fn frame_rate(&self) -> Result<f64, RecordError> {
        let times = self.times();
        let first = self.times[0];
        let Some(second) = times.clone().nth(1) else {
            let message = format!("has one frame only, at t = {first:?} s: no frame rate");
            return Err(RecordError::wrong(&self.source, message));
        };
        let step = second - first;
        let mut last = first;
        for (k, time) in times.enumerate().skip(1) {
            let gap = time - last;
            if (gap - step).abs() > 1e-6 * step + ROUNDING {
                return Err(self.wrong_at(k, |place| {
                    format!(
                        "{place}: column t: t = {time:?} s comes {gap:.6} s after the frame before, the others \
                         {step:.6} s: the format needs a constant frame rate (a run's last step is shortened if \
                         --until is no multiple of --step; --every N may leave it out)"
                    )
                }));
            }
            last = time;
        }
        // Sums of steps are rounded; the step that was meant has few decimals, or its rate has none.
        let mean = (last - first) / (self.frames() - 1) as f64;
        let (rate, decimal) = (mean.recip().round(), (mean * 1e9).round() / 1e9);
        let near = |value: f64, within: f64| (value - mean).abs() < within * mean;
        let rate = if near(rate.recip(), 1e-6) {
            rate
        } else if near(decimal, 1e-10) {
            decimal.recip()
        } else {
            mean.recip()
        };
        if !(rate > 0.0 && rate.is_finite()) {
            let message =
                format!("the time between its frames is {step:?} s, which gives no usable frame rate");
            return Err(RecordError::wrong(&self.source, message));
        }
        Ok(rate)
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

fn changed(source: &Path) -> RecordError {
    RecordError::wrong(source, "was changed while it was read")
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
