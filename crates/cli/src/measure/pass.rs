//! One pass over the frames of a run.

use super::Arguments;
use super::summary::{
    BalanceSummary, BreathingSummary, OfArea, OfLine, OfTrajectories, QUANTILES, RunSummary, SqueezeSummary,
    of_walls,
};
use crate::interrupt::Interrupt;
use anyhow::{Result, bail};
use lemons_core::trial::Trial;
use lemons_results::Record;
use lemons_results::measure::{
    BalanceOverTime, BreathingOverTime, By, Density, Departures, LoadsOverTime, MovingMeans, Passages,
    SqueezeOverTime, VoronoiRoom, quantile, squeeze, within,
};
use lemons_sim::Until;

/// \[s\] Single steps show hard collisions of milliseconds, and no pressure.
pub const OVER: f64 = 1.0;

/// Measures what the arguments ask for; `room` is there if there are areas.
pub fn pass(
    arguments: &Arguments,
    record: &Record,
    room: Option<&VoronoiRoom>,
    trial: Option<&Trial>,
    interrupt: &Interrupt,
) -> Result<RunSummary> {
    let Arguments { lines, areas, above, over, width, from, .. } = arguments;
    let (ids, until) = (record.ids(), arguments.until.and_then(Until::time));
    let people = ids.len();
    let links = trial.map_or(&[][..], |trial| &trial.geometry.links);
    let begun = lines.iter().map(|line| Passages::over(line.what, people).with_links(links));
    let mut passages: Vec<_> = begun.collect();
    let mut densities: Vec<Vec<Density>> = vec![Vec::new(); areas.len()];
    let mut exposure = SqueezeOverTime::new(people, above, *over);
    let mut parts = [(); 2].map(|()| SqueezeOverTime::new(people, &[], None));
    let walls = trial.filter(|_| arguments.walls);
    let mut loads = walls.map(|trial| LoadsOverTime::of(&trial.geometry));
    let begun = trial.filter(|_| arguments.breathing);
    if arguments.breathing && begun.is_none() {
        bail!("--breathing: {}: no Trial says where chests are", record.source().display());
    }
    let mut breathing = begun.map(BreathingOverTime::of);
    let (mut moving, mut spread) = (MovingMeans::over(OVER), Vec::new());
    let departures = if record.trajectories().is_some() { Departures::of_appearing } else { Departures::of };
    let (mut departures, mut balance) = (departures(people), BalanceOverTime::of(people));
    let (mut stopped, mut first, mut last, mut frames) = (Ok(()), None, f64::NAN, 0);
    record.each(|_, frame| {
        if stopped.is_ok() {
            stopped = interrupt.check();
        }
        if stopped.is_err() || !within(frame.time, *from, until) {
            return Ok(());
        }
        (first, last, frames) = (first.or(Some(frame.time)), frame.time, frames + 1);
        let frame = match trial {
            Some(trial) => frame.with_outside(trial),
            None => frame,
        };
        departures.add(&frame);
        balance.add(&frame);
        breathing.iter_mut().for_each(|breathing| breathing.add(&frame));
        passages.iter_mut().for_each(|line| line.add(&frame));
        for (area, seen) in areas.iter().zip(&mut densities) {
            seen.push(area.what.measure(&frame, room));
        }
        exposure.see(&frame, None);
        parts.iter_mut().zip(By::ALL).for_each(|(part, by)| part.see(&frame, Some(by)));
        loads.iter_mut().for_each(|loads| loads.add(&frame));
        if arguments.plot.is_some() {
            let of_step = |agent| squeeze(&frame, agent, None).map(|(mean, _)| mean);
            if let Some(means) = moving.add(frame.time, (0..people).map(of_step)) {
                let there = means.into_iter().enumerate().filter(|(agent, _)| of_step(*agent).is_some());
                let mut means: Vec<f64> = there.map(|(_, mean)| mean).collect();
                means.sort_by(f64::total_cmp);
                let at = QUANTILES.map(|part| quantile(&means, part).unwrap_or(f64::NAN));
                spread.push((frame.time, at));
            }
        }
        Ok(())
    })?;
    stopped?;
    let Some(first) = first else {
        bail!("{}: no frame between --from and --until", record.source().display());
    };
    let (walls, panels) = loads.and_then(LoadsOverTime::finish).map(of_walls).unzip();
    let breathing = match breathing.map(BreathingOverTime::finish) {
        Some(Err(why)) => bail!("--breathing: {}: {why}", record.source().display()),
        Some(Ok(each)) => BreathingSummary::of(each, ids),
        None => None,
    };
    let squeezed = SqueezeSummary::of(&exposure, &parts, (above, *over), ids);
    Ok(RunSummary {
        source: arguments.source.path.display().to_string(),
        from: first,
        until: last,
        frames,
        people,
        trajectories: record.trajectories().map(OfTrajectories::of),
        left: departures.left(),
        lines: lines
            .iter()
            .zip(passages)
            .map(|(line, seen)| OfLine::of(line, *width, seen, people))
            .collect(),
        areas: areas.iter().zip(densities).map(|(area, seen)| OfArea::of(area, seen)).collect(),
        exposure_left_out: squeezed.as_ref().err().copied(),
        spread: if squeezed.is_ok() { spread } else { Vec::new() },
        exposure: squeezed.ok().flatten(),
        walls,
        panels,
        balance: balance.finish().and_then(|kept| BalanceSummary::of(kept, ids)),
        breathing,
        notes: Vec::new(),
    })
}
