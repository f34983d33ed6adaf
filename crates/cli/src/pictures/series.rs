//! Time series of each agent.

use super::measured::Measured;
use super::plot::Arguments;
use super::quantity::{Quantity, Shown};
use super::source::KeptFrames;
use super::trial_run::{TrialRun, nothing_between};
use crate::interrupt::Interrupt;
use anyhow::{Result, bail};
use lemons_picture::{Chart, ChartPanel, ChartStyle, Line, chart_svg, titled};
use lemons_results::Run;
use lemons_results::measure::within;

/// Draws one panel for each quantity, one line for each agent; measured positions beside simulated ones.
pub fn series(arguments: &Arguments, interrupt: &Interrupt) -> Result<String> {
    let Arguments { source, style, .. } = arguments;
    let (trial, run) = source.open(source.end(arguments.until)?, KeptFrames::All, interrupt)?;
    // What contacts do is recorded, or computed from the Trial's bodies.
    let run = match trial {
        Some(trial) => TrialRun::new(trial, run)?.run,
        None => run,
    };
    let recorded = run.frames.iter().all(|frame| frame.observed.is_some());
    let mut of_contacts = arguments.series.iter().filter(|quantity| quantity.is_of_contacts());
    if let Some(quantity) = of_contacts.next().filter(|_| !recorded) {
        let (name, _) = quantity.label();
        bail!(
            "{}: it does not contain the {name}: give the Trial or FMU of the run with --trial",
            run.source.display()
        );
    }
    let places = places(&run, &arguments.agents)?;
    let (from, until) = arguments.times();
    let within = |time: f64| within(time, from, until);
    if !run.frames.iter().any(|frame| within(frame.time)) {
        bail!(nothing_between(&run, from, until));
    }
    let measured = style.measured(&run)?;
    let mut quantities: Vec<Shown> = Vec::new();
    for quantity in &arguments.series {
        let shown = Shown::of(*quantity, &run, style.over)?;
        // Mean and peak may have become the same.
        if !quantities.iter().any(|known| known.quantity == shown.quantity) {
            quantities.push(shown);
        }
    }
    let panels = quantities.into_iter().map(|shown| {
        let quantity = shown.quantity;
        let simulated = places.iter().map(|&place| {
            let frames = run.frames.iter().enumerate().filter(|(_, frame)| within(frame.time));
            let points = frames.map(|(k, frame)| (frame.time, shown.of_one(&run, k, place))).collect();
            Line { name: run.ids[place].clone(), points, group: place, dashed: false }
        });
        let seen = places.iter().filter_map(|&place| {
            let points = seen(quantity, measured.as_ref()?, &run.ids[place])?;
            let points = points.into_iter().filter(|point| within(point.0)).collect();
            Some(Line { name: run.ids[place].clone(), points, group: place, dashed: true })
        });
        ChartPanel {
            y: titled(&shown.label(), shown.unit()),
            lines: simulated.chain(seen).collect(),
            steps: quantity == Quantity::Contacts,
        }
    });
    let chart = Chart { x: "time (s)".to_owned(), panels: panels.collect(), noun: "agent".to_owned() };
    let (width, theme) = (f64::from(style.width), style.theme());
    Ok(chart_svg(&chart, &ChartStyle { width, theme, ..ChartStyle::default() }))
}

fn places(run: &Run, agents: &[String]) -> Result<Vec<usize>> {
    if agents.is_empty() {
        return Ok((0..run.ids.len()).collect());
    }
    let place = |id: &String| match run.ids.iter().position(|known| known == id) {
        Some(place) => Ok(place),
        None => bail!("{}: there is no agent {id:?}", run.source.display()),
    };
    agents.iter().map(place).collect()
}

/// Returns where somebody was measured.
fn seen(quantity: Quantity, measured: &Measured, id: &str) -> Option<Vec<(f64, f64)>> {
    let rows = measured.of(id).iter();
    match quantity {
        Quantity::X => Some(rows.map(|(t, place)| (*t, place.x)).collect()),
        Quantity::Y => Some(rows.map(|(t, place)| (*t, place.y)).collect()),
        _ => None,
    }
}
