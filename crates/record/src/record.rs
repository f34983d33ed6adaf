//! A recorded run that is read frame by frame, as often as needed.

use crate::error::RecordError;
use crate::run::{Frame, Names, Points, Run, names_of, order_of};
use lemons_plane::{Motion, Vec2, vec2};
use lemons_trial::Trial;
use std::cell::Cell;
use std::fs::File;
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
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
    /// As the source has them.
    own_ids: Vec<String>,
    /// \[s\] of all frames.
    times: Vec<f64>,
    /// In the first frame, in the order of the source.
    first: Vec<Motion>,
    contacts: bool,
    /// Places of the agents in the source, if they are wanted in another order.
    order: Option<Vec<usize>>,
    ids: Vec<String>,
    every: usize,
    points: Option<Points>,
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
        let source = source.to_owned();
        Ok(Record {
            source,
            pass: Rc::new(pass),
            own_ids: ids.clone(),
            times,
            first,
            contacts,
            order: None,
            ids,
            every: 1,
            points: None,
        })
    }

    /// The file or directory that it is read from.
    pub fn source(&self) -> &Path {
        &self.source
    }

    /// Ids of the agents, as in `Agents.xml`.
    pub fn ids(&self) -> &[String] {
        &self.ids
    }

    /// \[s\] Times of the frames; at least one.
    pub fn times(&self) -> impl ExactSizeIterator<Item = f64> + Clone {
        self.times.iter().copied().step_by(self.every)
    }

    /// Everybody in the first frame.
    pub fn first(&self) -> Vec<Motion> {
        match &self.order {
            Some(order) => order.iter().map(|&place| self.first[place]).collect(),
            None => self.first.clone(),
        }
    }

    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.times().len()
    }

    /// Whether all frames have contacts with their springs ([`Frame::interactions`]).
    pub fn contacts(&self) -> bool {
        self.contacts
    }

    /// Which communication points the frames are, if the metadata of the source says it.
    pub fn points(&self) -> Option<Points> {
        self.points.map(|points| Points { every: points.every.saturating_mul(self.every as u64), ..points })
    }

    pub(crate) fn with_points(self, points: Option<Points>) -> Record {
        Record { points, ..self }
    }

    /// Leaves only every `n`-th frame, beginning with the first.
    #[must_use]
    pub fn every(self, n: usize) -> Record {
        Record { every: self.every * n.max(1), ..self }
    }

    /// Puts the agents in the order of a Trial.
    ///
    /// # Errors
    /// The agents are not those of the Trial.
    pub fn of_trial(self, trial: &Trial) -> Result<Record, RecordError> {
        let order = order_of(&self.own_ids, trial, &self.source)?;
        let ids = order.iter().map(|&place| self.own_ids[place].clone()).collect();
        let order = (!order.iter().copied().eq(0..order.len())).then_some(order);
        Ok(Record { order, ids, ..self })
    }

    /// Numbers of the agents: the Ids if all are different whole numbers from 0 on, otherwise their places.
    pub fn names(&self) -> Names {
        names_of(&self.ids)
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
        Ok(Run { source: self.source.clone(), ids: self.ids.clone(), frames, points: self.points() })
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

    /// Positions of all agents at all times.
    ///
    /// # Errors
    /// As [`Record::each`], or there is no room for a temporary file of 16 bytes for each position.
    pub fn positions(&self) -> Result<Positions, RecordError> {
        let cannot = |error: io::Error| {
            RecordError::wrong(
                &self.source,
                format!("positions cannot be put into a temporary file: {error}"),
            )
        };
        let mut file = BufWriter::new(lemons_files::unnamed().map_err(cannot)?);
        self.each(|_, frame| {
            for (place, agent) in frame.agents.iter().enumerate() {
                // Who has left is nowhere.
                let position =
                    if frame.is_there(place) { agent.pose.position } else { vec2(f64::NAN, f64::NAN) };
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
        let Run { source, ids, frames, points } = run;
        Record {
            points,
            times: frames.iter().map(|frame| frame.time).collect(),
            first: frames.first().map(|frame| frame.agents.clone()).unwrap_or_default(),
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

/// Positions of all agents at all times, no numbers for those who have left, in a temporary file: for several passes, or for one agent after the other.
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
    /// \[m\] Positions of those who are there, in the order of time and of agents. If the temporary file cannot be read, they end early; see
    /// [`Positions::check`].
    pub fn iter(&self) -> impl Iterator<Item = Vec2> + Clone {
        let chunks = (0..self.count.div_ceil(CHUNK)).map(|chunk| chunk * CHUNK);
        let all = chunks.flat_map(|first| self.read(first, CHUNK.min(self.count - first)));
        all.filter(|position| position.is_finite())
    }

    /// \[m\] of some agents at each time; no numbers for those who have left.
    pub(crate) fn of(&self, agents: std::ops::Range<usize>) -> impl Iterator<Item = Vec<Vec2>> {
        let (first, count) = (agents.start as u64, agents.len() as u64);
        (0..self.count / self.agents as u64).map(move |k| self.read(k * self.agents as u64 + first, count))
    }

    /// Whether all positions could be read so far.
    ///
    /// # Errors
    /// The temporary file could not be read.
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
