//! `lemons bench`: what a mechanical step costs, and what the FMU adds.

use anyhow::Result;
use lemons_bench::{cases, fmu, measure};
use std::io::{self, Write};

#[derive(clap::Args)]
pub struct Arguments {
    /// Only crowds whose name contains this
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
    /// Runs of each; the median counts
    #[arg(long, default_value_t = 7, value_parser = clap::value_parser!(u16).range(1..))]
    runs: u16,
}

pub fn bench(arguments: &Arguments) -> Result<()> {
    let mut out = io::stdout().lock();
    writeln!(out, "Processor time per agent and mechanical step; one thread, median of {}.", arguments.runs)?;
    writeln!(out, "pairs, contacts: per agent and step; lists: neighbour lists in 1000 steps.")?;
    writeln!(out, "Others: measured once on a machine of this kind, not here.\n")?;
    writeln!(
        out,
        "{:<18}{:>7}{:>9}{:>7}{:>9}{:>7} {:>22}",
        "crowd", "agents", "ns", "pairs", "contacts", "lists", "LEMONS C++, LAMMPS"
    )?;
    let cases = cases();
    let wanted = |name: &str| arguments.only.as_ref().is_none_or(|only| name.contains(only));
    for case in cases.iter().filter(|case| wanted(case.name)) {
        let figures = measure(case, arguments.runs.into())?;
        let others = case.others.map_or(String::new(), |others| {
            let factor = |other: f64| format!("{:.0}x", other / figures.nanoseconds);
            let lammps = others.lammps.map_or("–".to_owned(), factor);
            format!("{}/{}, {lammps}", factor(others.published), factor(others.published_best))
        });
        writeln!(
            out,
            "{:<18}{:>7}{:>9.1}{:>7.2}{:>9.2}{:>7.1} {others:>22}",
            case.name, case.agents, figures.nanoseconds, figures.pairs, figures.contacts, figures.rebuilds
        )?;
        out.flush()?;
    }
    writeln!(out, "\nLEMONS C++: as shipped / with the best compiler flags.")?;
    if wanted(THROUGH_FMU) {
        through_fmu(&mut out, arguments.runs.into())?;
    }
    Ok(())
}

const THROUGH_FMU: &str = "through the FMU";

/// The second table: what lies around the mechanics.
fn through_fmu(out: &mut impl Write, runs: usize) -> Result<()> {
    writeln!(out, "\n{:<50}{:>10}", THROUGH_FMU, "")?;
    let mut row = |what: &str, value: f64, unit: &str| -> Result<()> {
        writeln!(out, "{what:<50}{value:>10.3} {unit}")?;
        Ok(out.flush()?)
    };
    let overhead = fmu::overhead(1_000, runs)?;
    row("1000 agents: set 3 inputs of each", overhead.set, "µs")?;
    row("1000 agents: get 10 outputs of each", overhead.get, "µs")?;
    let loading = fmu::loading(10_000, runs)?;
    row("10 000 agents: read and check the Trial", loading.read, "s")?;
    row("10 000 agents: read, check and pack it", loading.pack, "s")?;
    row("10 000 agents: instantiate the FMU", loading.instantiate, "s")?;
    row("10 000 agents: initialize it", loading.initialize, "s")?;
    let push = fmu::push(runs)?;
    row("push, 5 s at 2e-6 s: wall time", push.wall, "s")?;
    row("push, 5 s at 2e-6 s: processor time", push.processor, "s")
}
