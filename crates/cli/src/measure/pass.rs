//! One pass over the frames of a run.

use super::Arguments;
use super::options::Named;
use crate::interrupt::Interrupt;
use anyhow::{Result, bail};
use lemons_results::measure::{
    Balance, By, Density, Departures, Exposed, Exposure, Kept, Left, Line, MeasuringArea, MovingMeans,
    Passages, Room, quantile, squeeze, squeeze_by, within,
};
use lemons_results::{Frame, Record};
use lemons_sim::Until;

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
    /// The parts of it by each of [`By::ALL`], without peaks; `None` if they are not known.
    pub exposed_by: Option<[Vec<Exposed>; 2]>,
    /// What each piece of a wall was exposed to, and \[N\] the greatest mean over a step; `None` if it was not asked for
    /// or is not known.
    pub walls: Option<Vec<(Exposed, f64)>>,
    /// How each person kept the balance; `None` if people have no legs.
    pub balance: Option<Vec<Kept>>,
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

fn says_by_what(frame: &Frame) -> bool {
    let steps = frame.observed.iter().flatten().map(|seen| seen.of_step);
    steps.into_iter().all(|step| step.is_some_and(|step| step.mean_wall_force.is_some()))
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
        exposed_by: None,
        walls: None,
        balance: None,
        longest_step: 0.0,
        spread: Vec::new(),
    };
    let until = arguments.until.and_then(Until::time);
    let (mut stopped, mut squeezes) = (Ok(()), true);
    let mut exposure = Exposure::new(people, &arguments.above, arguments.over);
    let mut moving = MovingMeans::over(OVER);
    let (mut exposures_by, mut splits) = (By::ALL.map(|by| (by, Exposure::new(people, &[], None))), true);
    let mut of_walls: Option<(Exposure, Vec<f64>)> = None;
    let departures = if record.trajectories().is_some() { Departures::of_appearing } else { Departures::of };
    let (mut departures, mut balance) = (departures(people), Balance::of(people));
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
        balance.add(&frame);
        seen.lines.iter_mut().for_each(|line| line.passages.add(&frame));
        seen.areas.iter_mut().for_each(|own| own.over_time.push(own.area.measure(&frame, room)));
        squeezes &= says_squeeze(&frame);
        exposure.add(frame.time, (0..people).map(|agent| squeeze(&frame, agent)));
        splits &= says_by_what(&frame);
        for (by, exposure) in exposures_by.iter_mut().filter(|_| splits) {
            exposure.add(frame.time, (0..people).map(|agent| squeeze_by(&frame, agent, *by)));
        }
        if let Some(walls) = frame.walls.as_ref().filter(|_| arguments.walls) {
            let begin = || (Exposure::new(walls.len(), &[], None), vec![0.0; walls.len()]);
            let first = of_walls.is_none();
            let (exposure, greatest) = of_walls.get_or_insert_with(begin);
            let means = walls.iter().map(|wall| (wall.mean_normal_force, wall.peak_normal_force));
            exposure.add(frame.time, means.map(Some));
            for (greatest, wall) in greatest.iter_mut().zip(walls).filter(|_| !first) {
                *greatest = greatest.max(wall.mean_normal_force);
            }
        }
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
    (seen.left, seen.balance) = (departures.left(), balance.finish());
    seen.longest_step = exposure.longest_step();
    if !squeezes {
        seen.exposed = Err("the results do not contain the mean squeeze over communication steps");
    } else if seen.longest_step > 0.0 {
        seen.exposed = Ok(exposure.finish());
        seen.exposed_by = splits.then(|| exposures_by.map(|(_, exposure)| exposure.finish()));
    }
    seen.walls = of_walls.map(|(exposure, greatest)| exposure.finish().into_iter().zip(greatest).collect());
    Ok(seen)
}
