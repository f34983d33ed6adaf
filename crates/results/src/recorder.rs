//! Keeps frames of a run in memory while the run is made or read.

use crate::error::RecordError;
use crate::record::Record;
use crate::run::{Frame, Run};
use std::path::Path;

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
    kept: Vec<Frame>,
    /// The newest two that are not kept yet: the last ones may be wanted.
    newest: Vec<Frame>,
}

impl Recorder {
    /// A recorder without frames.
    pub fn new(wanted: KeptFrames) -> Recorder {
        Recorder { wanted, kept: Vec::new(), newest: Vec::new() }
    }

    /// Adds the next frame.
    pub fn add(&mut self, frame: Frame) {
        let KeptFrames::Around(asked) = &self.wanted else { return self.kept.push(frame) };
        if self.kept.is_empty() && self.newest.is_empty() {
            return self.kept.push(frame);
        }
        // The frame before was the last one up to one of the times, this one is the first after it.
        let before = self.newest.last().or(self.kept.last()).map_or(f64::NEG_INFINITY, |last| last.time);
        if asked.iter().any(|asked| before <= *asked && *asked < frame.time) {
            // Of the two, only the newer stands right before it.
            self.kept.extend(self.newest.pop());
            self.newest.clear();
            self.kept.push(frame);
            return;
        }
        if self.newest.len() == 2 {
            self.newest.remove(0);
        }
        self.newest.push(frame);
    }

    /// Returns the frames that were kept, as a run of the agents with these Ids.
    ///
    /// # Errors
    /// No frame was added; the message names `source`.
    pub fn finish(self, source: &Path, ids: Vec<String>) -> Result<Run, RecordError> {
        let Recorder { wanted, kept: mut frames, mut newest } = self;
        // After the last frame there is none: a time beyond it is between the last two.
        if let (KeptFrames::Around(asked), Some(last)) = (&wanted, newest.last()) {
            let beyond = asked.iter().any(|asked| *asked >= last.time);
            if !beyond && newest.len() == 2 {
                newest.remove(0);
            }
        }
        frames.extend(newest);
        if frames.is_empty() {
            return Err(RecordError::wrong(source, "the run is empty: there is no frame"));
        }
        Ok(Run { source: source.to_owned(), ids, frames })
    }
}

impl Record {
    /// Reads the wanted frames into memory.
    ///
    /// # Errors
    /// As [`Record::each`].
    pub fn read_wanted(&self, wanted: KeptFrames) -> Result<Run, RecordError> {
        let mut recorder = Recorder::new(wanted);
        self.each(|_, frame| {
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
        for asked in [
            vec![],
            vec![0.0],
            vec![3.5],
            vec![3.0],
            vec![3.5, 4.5],
            vec![9.0],
            vec![8.5],
            vec![20.0],
            vec![-1.0],
            vec![0.5, 7.2, 8.9],
        ] {
            assert_eq!(kept(KeptFrames::Around(asked.clone())), expected(&asked), "{asked:?}");
        }
    }

    #[test]
    fn an_empty_run_is_an_error() {
        let error = Recorder::new(KeptFrames::All).finish(Path::new("run"), Vec::new()).unwrap_err();
        assert!(error.to_string().contains("there is no frame"), "{error}");
    }
}
