//! The numbers of a measurement as text, 80 columns wide.

use super::summary::{
    BalanceSummary, BreathingSummary, LoadedPanel, LoadedWall, OfArea, OfLine, OfPart, OfPeople, RunSummary,
    SqueezeSummary,
};
use crate::print;
use anyhow::Result;
use lemons_core::message::message;
use lemons_report::sentences::{DESIGN_LOADS, NO_DESIGN, SINGLE};
use lemons_results::measure::{By, Crossings, Left, MeanMax, WallLoad};
use std::io::Write;

/// What a dose is not.
const BREATHING: &str = "Means over a breath of 5 s. The dose is of 14 healthy women who lay on their backs with weights \
    (Motomura et al. 2019): critical is what tires breathing, nobody's death. People who stand, differ and push were not \
    measured (docs/levels.md).";

/// Columns of a line.
const WIDTH: usize = 80;

/// Prints a summary.
pub fn print(summary: &RunSummary) -> Result<()> {
    let mut out = print::out();
    let RunSummary { from, until, frames, people, .. } = summary;
    writeln!(out, "{:<18} {from:.3} to {until:.3} s, {frames} frames, {people} people", "measured")?;
    if let Some(left) = &summary.left {
        let last = left.last.map_or(String::new(), |last| format!(" (the last at {last:.3} s)"));
        writeln!(out, "{:<18} {} of {people} people{last}", "left", left.people)?;
    }
    summary.lines.iter().try_for_each(|line| of_line(&mut out, line, summary.left))?;
    summary.areas.iter().try_for_each(|area| of_area(&mut out, area))?;
    summary.exposure.iter().try_for_each(|squeeze| of_squeeze(&mut out, squeeze))?;
    summary.notes.iter().try_for_each(|note| paragraph(&mut out, note))?;
    summary.breathing.iter().try_for_each(|breathing| of_breathing(&mut out, breathing, *people))?;
    if let (Some(walls), Some(panels)) = (&summary.walls, &summary.panels) {
        of_walls(&mut out, walls, panels)?;
    }
    summary.balance.iter().try_for_each(|balance| of_balance(&mut out, balance, *people))
}

/// Writes a row of numbers, dashes for those that are not known; then a unit in so many columns, and more.
fn row(
    out: &mut impl Write,
    label: &str,
    values: &[Option<f64>],
    (unit, width): (&str, usize),
    more: &str,
) -> Result<()> {
    let text = |value: &Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.3}"));
    let values: String = values.iter().map(|value| format!(" {:>10}", text(value))).collect();
    let line = format!("  {label:<18}{values} {unit:<width$} {more}");
    Ok(writeln!(out, "{}", line.trim_end())?)
}

/// Writes words in lines.
fn paragraph(out: &mut impl Write, text: &str) -> Result<()> {
    let mut line = String::from(" ");
    for word in text.split(' ') {
        if line.chars().count() + 1 + word.chars().count() > WIDTH {
            writeln!(out, "{line}")?;
            line = String::from(" ");
        }
        line.push(' ');
        line += word;
    }
    Ok(writeln!(out, "{line}")?)
}

/// Points the way on paper: the direction is seen along the line.
fn arrow(line: &OfLine, way: &Crossings) -> char {
    let [dx, dy] = [line.to[0] - line.from[0], line.to[1] - line.from[1]];
    let sign = if way.direction == "right" { 1.0 } else { -1.0 };
    let eighths = (sign * -dx).atan2(sign * dy) / std::f64::consts::FRAC_PI_4;
    ['→', '↗', '↑', '↖', '←', '↙', '↓', '↘'][(eighths.round() as i64).rem_euclid(8) as usize]
}

fn of_line(out: &mut impl Write, line: &OfLine, left: Option<Left>) -> Result<()> {
    let [[x1, y1], [x2, y2]] = [line.from, line.to];
    writeln!(out, "\nline {}: ({x1}, {y1}) to ({x2}, {y2}) m", line.name)?;
    let crossed: Vec<&Crossings> = line.directions.iter().filter(|way| way.people > 0).collect();
    if crossed.is_empty() {
        writeln!(out, "  nobody crossed it")?;
        // Perhaps the line lies behind the exit.
        if let Some([[x0, y0], [x1, y1]]) = left.and_then(|left| left.last_seen) {
            let seen = format!("x from {x0:.2} to {x1:.2} m, y from {y0:.2} to {y1:.2} m");
            writeln!(out, "  (who has left was seen last at {seen})")?;
        }
    }
    for way in crossed {
        let Crossings { direction, people, crossings, across, not_across, .. } = way;
        let again = if crossings == people { String::new() } else { format!(", {crossings} times") };
        let noun = if *people == 1 { "person" } else { "people" };
        writeln!(out, "  to the {direction} {}: {people} {noun} crossed{again}", arrow(line, way))?;
        let gaps = way.gap_10.zip(way.gap_90);
        let gaps = gaps.map_or(String::new(), |(low, high)| format!("(10 %: {low:.3}, 90 %: {high:.3} s)"));
        let stay = match not_across {
            0 => String::new(),
            n => format!("({across} across at the end, {n} not)"),
        };
        for (label, value, unit, more) in [
            ("first", way.first, "s", String::new()),
            ("last", way.last, "s", String::new()),
            ("flow", way.flow, "1/s", String::new()),
            ("specific flow", way.specific_flow, "1/(m s)", format!("({:.3} m wide)", line.width)),
            ("time gap, median", way.gap_median, "s", gaps),
            ("all across", way.evacuation_time, "s", stay),
        ] {
            row(out, label, &[value], (value.map_or("", |_| unit), 8), &more)?;
        }
    }
    Ok(())
}

fn of_area(out: &mut impl Write, area: &OfArea) -> Result<()> {
    writeln!(out, "\narea {}: {:.3} m²\n{:>31} {:>10}", area.name, area.area, "mean", "greatest")?;
    for (label, value, unit) in [
        ("people", Some(area.people), ""),
        ("density, N/A", Some(area.density), "1/m²"),
        ("density, Voronoi", area.voronoi_density, "1/m²"),
        ("speed", area.speed, "m/s"),
    ] {
        let values = [value.map(|MeanMax { mean, .. }| mean), value.map(|MeanMax { max, .. }| max)];
        row(out, label, &values, (unit, 0), "")?;
    }
    Ok(())
}

/// Writes how a number is spread over people.
fn of_people(out: &mut impl Write, label: &str, of: Option<&OfPeople>, unit: &str, more: &str) -> Result<()> {
    let Some(OfPeople { median, quantile_90, max, max_id }) = of else {
        return row(out, label, &[None; 3], ("", 0), "");
    };
    let who = if *max > 0.0 { format!("(agent {max_id}{more})") } else { String::new() };
    row(out, label, &[*median, *quantile_90, *max].map(Some), (unit, 4), &who)
}

fn of_squeeze(out: &mut impl Write, squeeze: &SqueezeSummary) -> Result<()> {
    writeln!(out, "\nsqueeze of each person\n{:>31} {:>10} {:>10}", "median", "90 %", "greatest")?;
    let parts = By::ALL.map(By::name).into_iter().zip([&squeeze.by_people, &squeeze.by_walls]);
    let parts: Vec<(String, &OfPart)> =
        parts.filter_map(|(by, part)| Some((format!("  by {by}"), part.as_ref()?))).collect();
    for (k, span) in squeeze.largest_mean.iter().enumerate() {
        of_people(out, &format!("mean over {} s", span.over), span.mean.as_ref(), "N", "")?;
        for (by, part) in parts.iter().filter(|_| span.mean.is_some()) {
            of_people(out, by, part.largest_mean[k].mean.as_ref(), "N", "")?;
        }
    }
    of_people(out, "peak", Some(&squeeze.peak), "N", "")?;
    of_people(out, "impulse", Some(&squeeze.impulse), "N s", "")?;
    for (by, part) in &parts {
        of_people(out, by, Some(&part.impulse), "N s", "")?;
    }
    if !squeeze.time_above.is_empty() {
        let means = match squeeze.above_over {
            Some(over) => format!("means over {over} s"),
            None => format!("means over a communication step (longest: {:.6} s)", squeeze.longest_step),
        };
        writeln!(out, "\ntime above a level, of {means}")?;
    }
    for level in &squeeze.time_above {
        let people = level.people.map_or(String::new(), |people| format!("; {people} above"));
        of_people(out, &format!("{} N", level.above), level.time.as_ref(), "s", &people)?;
        if level.people > Some(0) {
            of_people(out, "  without a break", level.longest.as_ref(), "s", "")?;
        }
    }
    Ok(())
}

fn of_balance(out: &mut impl Write, balance: &BalanceSummary, people: usize) -> Result<()> {
    let BalanceSummary { fallen, steps, time_unbalanced, lean, .. } = balance;
    let noun = if *steps == 1 { "step" } else { "steps" };
    writeln!(
        out,
        "\nbalance: {fallen} of {people} people fell (who walks cannot fall); {steps} {noun} in all"
    )?;
    writeln!(out, "{:>31} {:>10} {:>10}", "median", "90 %", "greatest")?;
    of_people(out, "time unbalanced", Some(time_unbalanced), "s", "")?;
    of_people(out, "largest lean", Some(lean), "m", "")
}

fn of_breathing(out: &mut impl Write, breathing: &BreathingSummary, people: usize) -> Result<()> {
    let BreathingSummary { critical, expected, first, dose, front, side, least, above, .. } = breathing;
    let when = first.map_or(String::new(), |first| format!(", the first at {first:.1} s"));
    writeln!(
        out,
        "\nbreathing: for {critical} of {people} people the dose is critical{when}; {expected:.1} expected"
    )?;
    writeln!(out, "{:>31} {:>10} {:>10}", "median", "90 %", "greatest")?;
    of_people(out, "dose (1: critical)", Some(dose), "", "")?;
    for (label, of) in [("chest front–back", front), ("chest side–side", side), ("from all sides", least)]
    {
        of_people(out, label, Some(of), "N", "")?;
    }
    for (level, time) in above.iter().filter(|(_, time)| time.max > 0.0) {
        of_people(out, &format!("above {level} N"), Some(time), "s", "")?;
    }
    paragraph(out, BREATHING)
}

/// Panels that are listed.
const MOST_PANELS: usize = 10;

/// Writes the walls and the most loaded panels that somebody touched.
fn of_walls(out: &mut impl Write, walls: &[LoadedWall], panels: &[LoadedPanel]) -> Result<()> {
    let touched = |load: &WallLoad| load.impulse > 0.0;
    let mut loaded: Vec<&LoadedPanel> = panels.iter().filter(|panel| touched(&panel.load)).collect();
    // Records that are shorter than a second have no mean over it. Equal loads stay in the order of the walls.
    let key = |load: &WallLoad| load.load_1.unwrap_or(load.load_step);
    loaded.sort_by(|one, other| key(&other.load).total_cmp(&key(&one.load)));
    writeln!(out, "\nloads on walls in kN/m: the greatest means and peak, and when they ended")?;
    if loaded.is_empty() {
        writeln!(out, "  nobody touched a wall")?;
        return Ok(());
    }
    writeln!(out, "{:>44}{:>18}{:>18}", "over 1 s", "over 10 s", "peak")?;
    for LoadedWall { wall, load } in walls.iter().filter(|wall| touched(&wall.load)) {
        of_load(out, &format!("wall {wall}, {:.2} m", load.length), load)?;
    }
    let count = match loaded.len() {
        more if more > MOST_PANELS => format!("the {MOST_PANELS} most loaded of {more}"),
        _ => "all".to_owned(),
    };
    writeln!(out, "  panels that somebody touched ({count}): their middle and length")?;
    for LoadedPanel { place, load } in loaded.into_iter().take(MOST_PANELS) {
        let [start, end] = place.ends();
        let middle = (start + end) * 0.5;
        let label = format!("{}: ({:.2}, {:.2}), {:.2} m", place.wall, middle.x, middle.y, load.length);
        of_load(out, &label, load)?;
    }
    let runs = message!(SINGLE);
    paragraph(out, &format!("{} {}", message!(DESIGN_LOADS), message!(NO_DESIGN, runs)))
}

/// Writes the numbers of a load in kN/m, each with the time \[s\] when it was.
fn of_load(out: &mut impl Write, label: &str, load: &WallLoad) -> Result<()> {
    let of = |value: Option<f64>, at: Option<f64>| match (value, at) {
        (Some(value), Some(at)) => format!("{:>7.3} at {at:>5.2} s", value / 1e3),
        _ => "-".to_owned(),
    };
    // A record of less than a second, or with longer steps, has only means over steps.
    let first = of(load.load_1, load.load_1_at);
    let step = format!("{:.3} over a step", load.load_step / 1e3);
    let numbers = [
        if load.load_1.is_none() { step } else { first },
        of(load.load_10, load.load_10_at),
        of(load.load_peak, load.load_peak_at),
    ];
    let numbers: String = numbers.iter().map(|number| format!("{number:>18}")).collect();
    // A long Id moves its numbers.
    Ok(writeln!(out, "  {label:<24}{numbers}")?)
}
