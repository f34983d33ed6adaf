//! One pass over the frames of a run.

use super::Arguments;
use super::options::Named;
use crate::interrupt::Interrupt;
use crate::run::Until;
use anyhow::{Result, bail};
use lemons_results::measure::{
    Density, Departures, Exposed, Exposure, Left, Line, MeasuringArea, MovingMeans, Passages, Room, quantile,
    squeeze, within,
};
use lemons_results::{Frame, Record};

/// What was seen.
pub struct Seen<'a> {
    /// \[s\] First and last frame.
    pub times: (f64, f64),
    pub frames: usize,
    /// At all exits; `None` if the frames do not say who is there.
    pub left: Option<Left>,
    pub lines: Vec<SeenLine<'a>>,
    pub areas: Vec<SeenArea<'a>>,
    /// Squeeze that each person was exposed to; or why it is not known.
    pub exposed: Result<Vec<Exposed>, &'static str>,
    /// \[s\] Between two frames.
    pub longest_step: f64,
    /// \[s\], \[N\] Of the mean squeezes of all people over the [`OVER`] that ends then: those of [`QUANTILES`].
    pub spread: Vec<(f64, [f64; QUANTILES.len()])>,
}

/// A line and the passages across it.
pub struct SeenLine<'a> {
    pub name: &'a str,
    /// \[m\] For the specific flow.
    pub width: f64,
    pub passages: Passages,
}

/// A crowd in an area over time.
pub struct SeenArea<'a> {
    pub name: &'a str,
    pub area: &'a MeasuringArea,
    pub over_time: Vec<Density>,
}

/// Quantiles of the people, by their squeeze.
pub const QUANTILES: [f64; 3] = [0.5, 0.9, 1.0];

fn says_squeeze(frame: &Frame) -> bool {
    let seen = frame.observed.as_deref();
    seen.is_some_and(|seen| seen.iter().all(|seen| seen.of_step.is_some()))
}

/// \[s\] Single steps show hard collisions of milliseconds, and no pressure.
pub const OVER: f64 = 1.0;

/// Measures what the arguments ask for; `room` is there if there are areas.
pub fn pass<'a>(
    arguments: &'a Arguments,
    record: &Record,
    room: Option<&Room>,
    interrupt: &Interrupt,
) -> Result<Seen<'a>> {
    let people = record.ids().len();
    let line = |Named { name, what }: &'a Named<Line>| SeenLine {
        name,
        width: arguments.width.unwrap_or(what.length()),
        passages: Passages::over(*what, people),
    };
    let area = |Named { name, what }: &'a Named<_>| SeenArea { name, area: what, over_time: Vec::new() };
    let mut seen = Seen {
        times: (f64::NAN, f64::NAN),
        frames: 0,
        left: None,
        lines: arguments.lines.iter().map(line).collect(),
        areas: arguments.areas.iter().map(area).collect(),
        exposed: Err("there is only one frame, so no communication step"),
        longest_step: 0.0,
        spread: Vec::new(),
    };
    let until = arguments.until.and_then(Until::time);
    let (mut stopped, mut squeezes) = (Ok(()), true);
    let mut exposure = Exposure::new(people, &arguments.above, arguments.over);
    let mut moving = MovingMeans::over(OVER);
    let mut departures = Departures::of(people);
    record.each(|_, frame| {
        if stopped.is_ok() {
            stopped = interrupt.check();
        }
        if stopped.is_err() || !within(frame.time, arguments.from, until) {
            return Ok(());
        }
        seen.times = (if seen.frames == 0 { frame.time } else { seen.times.0 }, frame.time);
        seen.frames += 1;
        departures.add(&frame);
        seen.lines.iter_mut().for_each(|line| line.passages.add(&frame));
        seen.areas.iter_mut().for_each(|own| own.over_time.push(own.area.measure(&frame, room)));
        squeezes &= says_squeeze(&frame);
        exposure.add(frame.time, (0..people).map(|agent| squeeze(&frame, agent)));
        if arguments.plot.is_some() && squeezes {
            let of_step = |agent| squeeze(&frame, agent).map(|(mean, _)| mean);
            if let Some(means) = moving.add(frame.time, (0..people).map(of_step)) {
                let there = means.into_iter().enumerate().filter(|(agent, _)| of_step(*agent).is_some());
                let mut means: Vec<f64> = there.map(|(_, mean)| mean).collect();
                means.sort_by(f64::total_cmp);
                let at = QUANTILES.map(|part| quantile(&means, part).unwrap_or(f64::NAN));
                seen.spread.push((frame.time, at));
            }
        }
        Ok(())
    })?;
    stopped?;
    if seen.frames == 0 {
        bail!("{}: no frame between --from and --until", record.source().display());
    }
    seen.left = departures.left();
    seen.longest_step = exposure.longest_step();
    if !squeezes {
        seen.exposed = Err("the results do not contain the mean squeeze over communication steps");
    } else if seen.longest_step > 0.0 {
        seen.exposed = Ok(exposure.finish());
    }
    Ok(seen)
}
