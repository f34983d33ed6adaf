//! Keeps frames of a run in memory while the run is made or read.

use crate::error::RecordError;
use crate::record::Record;
use crate::run::{Frame, Run};
use lemons_core::plane::Motion;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// \[bytes\] Largest memory for the frames of trajectories that are not of our runs: their frames may have places for many
/// who are in few of them, and a short file may name many frames.
const MOST_MEMORY: usize = 2_000_000_000;
/// \[bytes\] Memory of a frame besides what it is made of: its place, and what allocations need.
const BESIDES: usize = 100;

/// Which frames of a run are kept.
#[derive(Debug, Clone, PartialEq)]
pub enum KeptFrames {
    /// All frames.
    All,
    /// The first frame, the last one, and for each of these times \[s\] the frame before it and the one after it.
    Around(Vec<f64>),
}

/// Keeps the wanted frames of a run in memory. They are added in the order of time.
#[derive(Debug)]
pub struct Recorder {
    wanted: KeptFrames,
    /// The frames, and whether they are surely wanted; the newest two may still be.
    frames: Vec<(Frame, bool)>,
}

impl Recorder {
    /// Makes a recorder without frames.
    pub fn new(wanted: KeptFrames) -> Recorder {
        Recorder { wanted, frames: Vec::new() }
    }

    /// Adds the next frame.
    pub fn add(&mut self, frame: Frame) {
        let Some((before, wanted)) = self.frames.last_mut() else {
            return self.frames.push((frame, true));
        };
        let between = match &self.wanted {
            KeptFrames::All => true,
            KeptFrames::Around(asked) => {
                asked.iter().any(|asked| before.time <= *asked && *asked < frame.time)
            }
        };
        *wanted |= between;
        self.frames.push((frame, between));
        if let Some(place) = self.frames.len().checked_sub(3)
            && !self.frames[place].1
        {
            self.frames.remove(place);
        }
    }

    /// Returns the frames that were kept, as a run of the agents with these Ids.
    ///
    /// # Errors
    /// No frame was added; the message names `source`.
    pub fn finish(mut self, source: &Path, ids: Vec<String>) -> Result<Run, RecordError> {
        let Some((last, _)) = self.frames.pop() else {
            return Err(RecordError::wrong(source, "the run is empty: there is no frame"));
        };
        // After the last frame there is none: a time beyond it is between the last two.
        let beyond = |asked: &Vec<f64>| asked.iter().any(|asked| *asked >= last.time);
        let beyond = matches!(&self.wanted, KeptFrames::Around(asked) if beyond(asked));
        self.frames.pop_if(|(_, wanted)| !(*wanted || beyond));
        let frames = self.frames.into_iter().map(|(frame, _)| frame).chain([last]).collect();
        Ok(Run { source: source.to_owned(), ids, frames })
    }
}

impl Record {
    /// Reads the wanted frames into memory.
    ///
    /// # Errors
    /// As [`Record::each`]; or too many frames are wanted of trajectories that are not of one of our runs.
    pub fn read_wanted(&self, wanted: KeptFrames) -> Result<Run, RecordError> {
        self.read_unless(&AtomicBool::new(false), wanted)
    }

    /// Reads the wanted frames into memory, unless a flag is set meanwhile.
    ///
    /// # Errors
    /// As [`Record::read_wanted`]; or the flag was set ([`RecordError::Stopped`]).
    pub fn read_unless(&self, stop: &AtomicBool, wanted: KeptFrames) -> Result<Run, RecordError> {
        let (people, frames) = (self.ids().len(), self.frames());
        let each = size_of::<(Frame, bool)>() + BESIDES + people * (size_of::<Motion>() + size_of::<bool>());
        let kept = self.trajectories().is_some() && wanted == KeptFrames::All;
        if kept && each.saturating_mul(frames) > MOST_MEMORY {
            let message = format!(
                "{frames} frames with places for {people} people would take more than {} GB of memory: \
                 lemons export --to pedpy --every N leaves fewer frames",
                MOST_MEMORY / 1_000_000_000
            );
            return Err(RecordError::wrong(self.source(), message));
        }
        let mut recorder = Recorder::new(wanted);
        self.each(|_, frame| {
            if stop.load(Ordering::Relaxed) {
                return Err(RecordError::Stopped { path: self.source().to_owned() });
            }
            recorder.add(frame);
            Ok(())
        })?;
        recorder.finish(self.source(), self.ids().to_vec())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(time: f64) -> Frame {
        Frame { time, ..Frame::default() }
    }

    /// The times \[s\] of the frames that are kept of those at 0, 1, … 9 s.
    fn kept(wanted: KeptFrames) -> Vec<f64> {
        let mut recorder = Recorder::new(wanted);
        (0..10).for_each(|k| recorder.add(frame(f64::from(k))));
        let run = recorder.finish(Path::new("run"), Vec::new()).unwrap();
        run.frames.iter().map(|frame| frame.time).collect()
    }

    /// The first, the last, and of each time the frames before and after: by the definition, with all in memory.
    fn expected(asked: &[f64]) -> Vec<f64> {
        let mut places = vec![0, 9];
        for asked in asked {
            let after = (0..10).filter(|k| f64::from(*k) <= *asked).count().min(9);
            places.extend([after.saturating_sub(1), after]);
        }
        places.sort_unstable();
        places.dedup();
        places.into_iter().map(|k| k as f64).collect()
    }

    #[test]
    fn frames_around_times_are_kept() {
        assert_eq!(kept(KeptFrames::All).len(), 10);
        for asked in
            [&[][..], &[0.0], &[3.5], &[3.0], &[3.5, 4.5], &[9.0], &[8.5], &[20.0], &[-1.0], &[0.5, 7.2, 8.9]]
        {
            assert_eq!(kept(KeptFrames::Around(asked.to_vec())), expected(asked), "{asked:?}");
        }
        let error = Recorder::new(KeptFrames::All).finish(Path::new("run"), Vec::new()).unwrap_err();
        assert!(error.to_string().contains("there is no frame"), "{error}");
    }
}
