//! A recorded run that is read frame by frame, as often as wanted.

use crate::error::ExportError;
use crate::run::{Frame, Names, Run, names_of, order_of};
use crowd_mechanics::engine::{Vec2, vec2};
use crowd_mechanics::trial::Trial;
use std::cell::Cell;
use std::fs::File;
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// What is done with each frame.
pub(crate) type Each<'a> = dyn FnMut(Frame) -> Result<(), ExportError> + 'a;
/// All frames by time, one after the other; answers the Ids of the agents.
type Pass = dyn Fn(&mut Each<'_>) -> Result<Vec<String>, ExportError>;

/// A recorded run. In memory are its times, 8 bytes for each frame, and one frame while it is read.
#[derive(Clone)]
pub struct Record {
    source: PathBuf,
    pass: Rc<Pass>,
    /// As the source has them.
    own_ids: Vec<String>,
    /// \[s\] of all frames.
    times: Vec<f64>,
    contacts: bool,
    /// Places of the agents in the source, if they are wanted in another order.
    order: Option<Vec<usize>>,
    ids: Vec<String>,
    every: usize,
}

/// \[s\] Names of files hold nine decimals.
const ROUNDING: f64 = 2e-9;

impl Record {
    /// Reads all frames once, to see that they are sound.
    pub(crate) fn new(
        source: &Path,
        pass: impl Fn(&mut Each<'_>) -> Result<Vec<String>, ExportError> + 'static,
    ) -> Result<Record, ExportError> {
        let (mut times, mut contacts) = (Vec::new(), true);
        let ids = pass(&mut |frame| {
            times.push(frame.time);
            contacts &= frame.interactions.is_some();
            Ok(())
        })?;
        let source = source.to_owned();
        Ok(Record {
            source,
            pass: Rc::new(pass),
            own_ids: ids.clone(),
            times,
            contacts,
            order: None,
            ids,
            every: 1,
        })
    }

    /// Of the agents, as in `Agents.xml`.
    pub fn ids(&self) -> &[String] {
        &self.ids
    }

    /// \[s\] at least one
    pub fn times(&self) -> impl ExactSizeIterator<Item = f64> + Clone {
        self.times.iter().copied().step_by(self.every)
    }

    /// How many frames there are.
    pub fn frames(&self) -> usize {
        self.times().len()
    }

    /// Whether contacts are recorded in all frames.
    pub fn contacts(&self) -> bool {
        self.contacts
    }

    /// Each `n`-th frame, the first one included.
    #[must_use]
    pub fn every(self, n: usize) -> Record {
        Record { every: self.every * n.max(1), ..self }
    }

    /// In the order of a Trial's agents.
    ///
    /// # Errors
    /// These are not the agents of the Trial.
    pub fn of_trial(self, trial: &Trial) -> Result<Record, ExportError> {
        let order = order_of(&self.own_ids, trial, &self.source)?;
        let ids = order.iter().map(|&place| self.own_ids[place].clone()).collect();
        let order = (!order.iter().copied().eq(0..order.len())).then_some(order);
        Ok(Record { order, ids, ..self })
    }

    /// The Ids, if all are different whole numbers, else places.
    pub fn names(&self) -> Names {
        names_of(&self.ids)
    }

    /// Each frame with its place, by time.
    ///
    /// # Errors
    /// The source is no more what it was, or what is done with a frame fails.
    pub fn each(
        &self,
        mut what: impl FnMut(usize, Frame) -> Result<(), ExportError>,
    ) -> Result<(), ExportError> {
        let changed = || ExportError::wrong(&self.source, "was changed while it was read");
        let mut read = 0;
        let ids = (self.pass)(&mut |frame| {
            let k = read;
            read += 1;
            if self.times.get(k) != Some(&frame.time) || frame.agents.len() != self.own_ids.len() {
                return Err(changed());
            }
            if k % self.every != 0 {
                return Ok(());
            }
            let frame = match &self.order {
                Some(order) => frame.sorted(order),
                None => frame,
            };
            what(k / self.every, frame)
        })?;
        if read == self.times.len() && ids == self.own_ids { Ok(()) } else { Err(changed()) }
    }

    /// Some of the frames, in memory.
    ///
    /// # Errors
    /// As [`Record::each`].
    pub fn read(&self, wanted: impl Fn(usize) -> bool) -> Result<Run, ExportError> {
        let mut frames = Vec::new();
        self.each(|k, frame| {
            frames.extend(wanted(k).then_some(frame));
            Ok(())
        })?;
        Ok(Run { source: self.source.clone(), ids: self.ids.clone(), frames })
    }

    /// An error of a frame.
    pub(crate) fn wrong_at(&self, place: usize, message: impl FnOnce(&str) -> String) -> ExportError {
        match self.read(|k| k == place) {
            Ok(run) => {
                let place = run.frames.first().map_or("", |frame| frame.place.as_str());
                ExportError::wrong(&self.source, message(place))
            }
            Err(error) => error,
        }
    }

    /// Frames per second.
    ///
    /// # Errors
    /// There is one frame only, or they do not follow each other at equal times.
    pub fn frame_rate(&self) -> Result<f64, ExportError> {
        let times = self.times();
        let first = self.times[0];
        let Some(second) = times.clone().nth(1) else {
            let message = format!("has one frame only, at t = {first:?} s: no frame rate");
            return Err(ExportError::wrong(&self.source, message));
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
        Ok(if near(rate.recip(), 1e-6) {
            rate
        } else if near(decimal, 1e-10) {
            decimal.recip()
        } else {
            mean.recip()
        })
    }

    /// Where everybody was at all times.
    ///
    /// # Errors
    /// As [`Record::each`], or there is no place for a temporary file of 16 bytes for each position.
    pub fn positions(&self) -> Result<Positions, ExportError> {
        let cannot = |error: io::Error| {
            ExportError::wrong(
                &self.source,
                format!("positions cannot be put into a temporary file: {error}"),
            )
        };
        let mut file = BufWriter::new(tempfile::tempfile().map_err(cannot)?);
        self.each(|_, frame| {
            for position in frame.agents.iter().map(|agent| agent.position) {
                let written = file.write_all(&position.x.to_le_bytes());
                written.and_then(|()| file.write_all(&position.y.to_le_bytes())).map_err(cannot)?;
            }
            Ok(())
        })?;
        let file = file.into_inner().map_err(|error| cannot(error.into_error()))?;
        let count = self.frames() as u64 * self.ids.len() as u64;
        Ok(Positions { file, agents: self.ids.len(), count, failed: Cell::new(None) })
    }
}

/// A run in memory, too.
impl From<Run> for Record {
    fn from(run: Run) -> Record {
        let Run { source, ids, frames } = run;
        Record {
            times: frames.iter().map(|frame| frame.time).collect(),
            contacts: frames.iter().all(|frame| frame.interactions.is_some()),
            own_ids: ids.clone(),
            ids: ids.clone(),
            order: None,
            every: 1,
            source,
            pass: Rc::new(move |each| {
                frames.iter().try_for_each(|frame| each(frame.clone()))?;
                Ok(ids.clone())
            }),
        }
    }
}

/// Where everybody was at all times: for those who look at it more than once, or at one agent after the other.
pub struct Positions {
    file: File,
    agents: usize,
    /// Of all agents at all times.
    count: u64,
    failed: Cell<Option<io::ErrorKind>>,
}

/// \[byte\]
const POSITION: u64 = 16;
/// Positions that are read together.
const CHUNK: u64 = 4096;

impl Positions {
    /// \[m\] by time; ends early where the temporary file cannot be read, see [`Positions::check`].
    pub fn iter(&self) -> impl Iterator<Item = Vec2> + Clone {
        let chunks = (0..self.count.div_ceil(CHUNK)).map(|chunk| chunk * CHUNK);
        chunks.flat_map(|first| self.read(first, CHUNK.min(self.count - first)))
    }

    /// \[m\] of some agents at each time.
    pub(crate) fn of(&self, agents: std::ops::Range<usize>) -> impl Iterator<Item = Vec<Vec2>> {
        let (first, count) = (agents.start as u64, agents.len() as u64);
        (0..self.count / self.agents as u64).map(move |k| self.read(k * self.agents as u64 + first, count))
    }

    /// That all could be read.
    ///
    /// # Errors
    /// They could not.
    pub fn check(&self) -> io::Result<()> {
        self.failed.get().map_or(Ok(()), |kind| Err(kind.into()))
    }

    fn read(&self, first: u64, count: u64) -> Vec<Vec2> {
        let mut bytes = vec![0; (count * POSITION) as usize];
        let mut file = &self.file;
        let sought = file.seek(SeekFrom::Start(first * POSITION));
        if let Err(error) = sought.and_then(|_| file.read_exact(&mut bytes)) {
            self.failed.set(Some(error.kind()));
            return Vec::new();
        }
        let (numbers, _) = bytes.as_chunks::<8>();
        let (pairs, _) = numbers.as_chunks::<2>();
        pairs.iter().map(|[x, y]| vec2(f64::from_le_bytes(*x), f64::from_le_bytes(*y))).collect()
    }
}
