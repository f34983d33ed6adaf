//! Time series of each agent.

use super::look::{Look, Quantity};
use super::measured::Measured;
use super::plot::within;
use super::source::Opened;
use anyhow::{Result, bail};
use lemons_export::{Frame, Run};
use lemons_picture::{Axis, Chart, ChartPanel, Line};

/// What is shown of a run.
pub struct Selection<'a> {
    pub quantities: &'a [Quantity],
    /// By Id; all if empty.
    pub agents: &'a [String],
    /// \[s\]
    pub from: Option<f64>,
    /// \[s\]
    pub until: Option<f64>,
}

/// One panel for each quantity, one line for each agent; measured positions beside simulated ones.
pub fn chart(opened: Opened, look: &Look, selection: &Selection) -> Result<Chart> {
    let Opened { trial, run } = opened;
    // What contacts do is recorded, or computed from the Trial's bodies.
    let run = match trial {
        Some(trial) => super::moment::Footage::new(trial, run)?.run,
        None => run,
    };
    let contacts = |quantity: &&Quantity| matches!(quantity, Quantity::Squeeze | Quantity::Contacts);
    let recorded = run.frames.iter().all(|frame| frame.observed.is_some());
    if let Some(quantity) = selection.quantities.iter().find(contacts).filter(|_| !recorded) {
        let (name, _) = quantity.label();
        bail!("{}: does not say the {name}: give the Trial or FMU that ran: --trial", run.source.display());
    }
    let places = places(&run, selection.agents)?;
    let within = |time: f64| within(time, selection.from, selection.until);
    if !run.frames.iter().any(|frame| within(frame.time)) {
        bail!("{}: no frame between --from and --until", run.source.display());
    }
    let measured = look.measured(&run)?;
    let panels = selection.quantities.iter().map(|&quantity| {
        let (label, unit) = quantity.label();
        let simulated = places.iter().map(|&place| {
            let frames = run.frames.iter().filter(|frame| within(frame.time));
            let points = frames.map(|frame| (frame.time, value(quantity, frame, place))).collect();
            Line { name: run.ids[place].clone(), points, group: place, dashed: false }
        });
        let seen = places.iter().filter_map(|&place| {
            let points = seen(quantity, measured.as_ref()?, &run.ids[place])?;
            let points = points.into_iter().filter(|point| within(point.0)).collect();
            Some(Line { name: run.ids[place].clone(), points, group: place, dashed: true })
        });
        ChartPanel {
            y: Axis { label: label.to_owned(), unit: unit.to_owned() },
            lines: simulated.chain(seen).collect(),
            steps: quantity == Quantity::Contacts,
        }
    });
    Ok(Chart { x: Axis { label: "time".to_owned(), unit: "s".to_owned() }, panels: panels.collect() })
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

fn value(quantity: Quantity, frame: &Frame, place: usize) -> f64 {
    let agent = &frame.agents[place];
    let observed = frame.observed.as_ref().map(|all| all[place]);
    match quantity {
        Quantity::X => agent.position.x,
        Quantity::Y => agent.position.y,
        Quantity::Speed => agent.velocity.norm(),
        Quantity::Squeeze => observed.map_or(f64::NAN, |seen| seen.normal_force),
        Quantity::Contacts => {
            observed.map_or(f64::NAN, |seen| f64::from(seen.agent_contacts) + f64::from(seen.wall_contacts))
        }
    }
}

/// Of what was measured: where somebody was.
fn seen(quantity: Quantity, measured: &Measured, id: &str) -> Option<Vec<(f64, f64)>> {
    let rows = measured.of(id).iter();
    match quantity {
        Quantity::X => Some(rows.map(|(t, place)| (*t, place.x)).collect()),
        Quantity::Y => Some(rows.map(|(t, place)| (*t, place.y)).collect()),
        _ => None,
    }
}
