//! `lemons bench`: what a mechanical step costs.

use anyhow::Result;
use lemons_bench::{cases, measure};
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
    Ok(())
}
