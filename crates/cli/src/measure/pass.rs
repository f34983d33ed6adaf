//! One pass over the frames of a run.

use crate::interrupt::Interrupt;
use crate::pictures::moment::within;
use anyhow::{Result, bail};
use lemons_measure::{
    Density, Departures, Exposed, Exposure, Left, Line, MeasuringArea, Passages, Room, quantile, squeeze,
};
use lemons_record::{Frame, Record};
use std::collections::VecDeque;

/// What is looked at.
pub struct Pass<'a> {
    pub lines: Vec<Line>,
    pub areas: Vec<&'a MeasuringArea>,
    /// If there are areas.
    pub room: Option<&'a Room>,
    /// \[N\]
    pub above: &'a [f64],
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

/// Everybody's mean squeeze over the last [`OVER`], or since the first frame.
struct Running {
    /// \[s\], \[N s\] Duration of each step, and everybody's impulse in it.
    steps: VecDeque<(f64, Vec<f64>)>,
    /// \[s\]
    time: f64,
    /// \[N s\]
    impulses: Vec<f64>,
}

impl Running {
    fn of(people: usize) -> Running {
        Running { steps: VecDeque::new(), time: 0.0, impulses: vec![0.0; people] }
    }

    /// Adds a step \[s\] with everybody's mean squeeze \[N\], and returns their means over all steps that are kept.
    fn add(&mut self, step: f64, means: impl Iterator<Item = f64>) -> impl Iterator<Item = f64> {
        let impulses: Vec<f64> = means.map(|mean| mean * step).collect();
        self.impulses.iter_mut().zip(&impulses).for_each(|(sum, one)| *sum += one);
        self.time += step;
        self.steps.push_back((step, impulses));
        // Times are sums of steps.
        while self.steps.front().is_some_and(|(first, _)| self.time - first > (1.0 - 1e-9) * OVER) {
            let Some((first, impulses)) = self.steps.pop_front() else { break };
            self.time -= first;
            self.impulses.iter_mut().zip(&impulses).for_each(|(sum, one)| *sum -= one);
        }
        let time = self.time;
        self.impulses.iter().map(move |impulse| if time > 0.0 { (impulse / time).max(0.0) } else { 0.0 })
    }
}

impl Pass<'_> {
    pub fn over(&self, record: &Record, interrupt: &Interrupt) -> Result<Passed> {
        let people = record.ids().len();
        let mut exposure = Exposure::new(people, self.above);
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
        let mut running = Running::of(people);
        let mut departures = Departures::of(people);
        record.each(|_, frame| {
            if stopped.is_ok() {
                stopped = interrupt.check();
            }
            if stopped.is_err() || !within(frame.time, self.from, self.until) {
                return Ok(());
            }
            let step = if passed.frames == 0 { 0.0 } else { frame.time - passed.times.1 };
            passed.times = (if passed.frames == 0 { frame.time } else { passed.times.0 }, frame.time);
            passed.frames += 1;
            departures.add(&frame);
            passed.lines.iter_mut().for_each(|line| line.add(&frame));
            for ((area, seen), room) in self.areas.iter().zip(&mut passed.areas).zip(self.room.iter().cycle())
            {
                seen.push(area.measure(&frame, room));
            }
            squeezes &= says_squeeze(&frame);
            exposure.add(frame.time, (0..people).map(|agent| squeeze(&frame, agent)));
            if self.spread && squeezes {
                let of_step = |agent| squeeze(&frame, agent).map(|(mean, _)| mean);
                let over = running.add(step, (0..people).map(|agent| of_step(agent).unwrap_or(0.0)));
                let there = over.enumerate().filter(|(agent, _)| of_step(*agent).is_some());
                let mut means: Vec<f64> = there.map(|(_, mean)| mean).collect();
                means.sort_by(f64::total_cmp);
                let at = QUANTILES.map(|part| quantile(&means, part).unwrap_or(f64::NAN));
                passed.spread.push((frame.time, at));
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
