//! One pass over the frames of a run.

use crate::interrupt::Interrupt;
use anyhow::{Result, bail};
use lemons_results::measure::{
    Density, Departures, Exposed, Exposure, Left, Line, MeasuringArea, MovingMeans, Passages, Room, quantile,
    squeeze, within,
};
use lemons_results::{Frame, Record};

/// What is looked at.
pub struct Pass<'a> {
    pub lines: Vec<Line>,
    pub areas: Vec<&'a MeasuringArea>,
    /// If there are areas.
    pub room: Option<&'a Room>,
    /// \[N\]
    pub above: &'a [f64],
    /// \[s\] Of the means that are compared with these levels; else each communication step.
    pub over: Option<f64>,
    /// \[s\]
    pub from: Option<f64>,
    /// \[s\]
    pub until: Option<f64>,
    /// Whether the squeeze of the crowd over time is wanted.
    pub spread: bool,
}

/// What was seen.
pub struct Passed {
    /// \[s\] First and last frame.
    pub times: (f64, f64),
    pub frames: usize,
    /// At all exits; `None` if the frames do not say who is there.
    pub left: Option<Left>,
    pub lines: Vec<Passages>,
    /// Of each area, over time.
    pub areas: Vec<Vec<Density>>,
    /// Of each person; `None` if a frame does not say what the squeeze was over its step.
    pub exposed: Option<Vec<Exposed>>,
    /// \[s\] Between two frames.
    pub longest_step: f64,
    /// \[s\], \[N\] Of the mean squeezes of all people over the [`OVER`] that ends then: those of [`QUANTILES`].
    pub spread: Vec<(f64, [f64; QUANTILES.len()])>,
}

/// Of the people, by their squeeze.
pub const QUANTILES: [f64; 3] = [0.5, 0.9, 1.0];

fn says_squeeze(frame: &Frame) -> bool {
    let seen = frame.observed.as_deref();
    seen.is_some_and(|seen| seen.iter().all(|seen| seen.of_step.is_some()))
}

/// \[s\] Single steps show hard collisions of milliseconds, and no pressure.
pub const OVER: f64 = 1.0;

impl Pass<'_> {
    pub fn over(&self, record: &Record, interrupt: &Interrupt) -> Result<Passed> {
        let people = record.ids().len();
        let exposure = Exposure::new(people, self.above);
        let mut exposure = self.over.into_iter().fold(exposure, Exposure::over);
        let mut passed = Passed {
            times: (f64::NAN, f64::NAN),
            frames: 0,
            left: None,
            lines: self.lines.iter().map(|line| Passages::over(*line, people)).collect(),
            areas: vec![Vec::new(); self.areas.len()],
            exposed: None,
            longest_step: 0.0,
            spread: Vec::new(),
        };
        let (mut stopped, mut squeezes) = (Ok(()), true);
        let mut moving = MovingMeans::over(OVER);
        let mut departures = Departures::of(people);
        record.each(|_, frame| {
            if stopped.is_ok() {
                stopped = interrupt.check();
            }
            if stopped.is_err() || !within(frame.time, self.from, self.until) {
                return Ok(());
            }
            passed.times = (if passed.frames == 0 { frame.time } else { passed.times.0 }, frame.time);
            passed.frames += 1;
            departures.add(&frame);
            passed.lines.iter_mut().for_each(|line| line.add(&frame));
            for (area, seen) in self.areas.iter().zip(&mut passed.areas) {
                seen.push(area.measure(&frame, self.room));
            }
            squeezes &= says_squeeze(&frame);
            exposure.add(frame.time, (0..people).map(|agent| squeeze(&frame, agent)));
            if self.spread && squeezes {
                let of_step = |agent| squeeze(&frame, agent).map(|(mean, _)| mean);
                if let Some(means) = moving.add(frame.time, (0..people).map(of_step)) {
                    let there = means.into_iter().enumerate().filter(|(agent, _)| of_step(*agent).is_some());
                    let mut means: Vec<f64> = there.map(|(_, mean)| mean).collect();
                    means.sort_by(f64::total_cmp);
                    let at = QUANTILES.map(|part| quantile(&means, part).unwrap_or(f64::NAN));
                    passed.spread.push((frame.time, at));
                }
            }
            Ok(())
        })?;
        stopped?;
        if passed.frames == 0 {
            bail!("{}: no frame between --from and --until", record.source().display());
        }
        passed.left = departures.left();
        passed.longest_step = exposure.longest_step();
        passed.exposed = squeezes.then(|| exposure.finish());
        Ok(passed)
    }
}
