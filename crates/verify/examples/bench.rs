//! Costs of a mechanical step, and what the FMU adds:
//!
//! `cargo run --release -p lemons-verify --features bench --example bench -- [--only TEXT] [--runs N] [--threads N]`

use anyhow::{Result, bail};
use clap::Parser;
use lemons_core::files::input;
use lemons_verify::bench::{Figures, cases, fmu, measure};
use std::io::Write;

/// Measure the time that a mechanical step takes, and what the FMU adds
#[derive(Parser)]
struct Arguments {
    /// Measure only crowds whose name contains this text
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
    /// Number of runs of each crowd; the median is printed
    #[arg(long, value_name = "N", default_value_t = 7, value_parser = clap::value_parser!(u16).range(1..))]
    runs: u16,
    /// Number of threads to compare with one thread
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u16).range(1..))]
    threads: u16,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let mut out = std::io::stdout();
    let cases = cases();
    let wanted = |name: &str| arguments.only.as_ref().is_none_or(|only| name.contains(only));
    if !wanted(THROUGH_FMU) && !cases.iter().any(|case| wanted(case.name)) {
        bail!("no crowd has {:?} in its name", arguments.only.as_deref().unwrap_or_default());
    }
    let Arguments { runs, threads, .. } = &arguments;
    writeln!(
        out,
        "{}\n\
         ns: processor time per agent and mechanical step, one thread, median of {runs}.\n\
         pairs, contacts: per agent and step; lists: times that an agent's candidates\n\
         were listed in 1000 steps; near: lists of near pairs in 1000 steps.\n\
         x{threads}: times as fast with {threads} threads, by the clock on the wall.\n\
         Others: measured once on a machine of this kind, not here.\n\n\
         crowd               agents     ns pairs contacts lists near{:>5} LEMONS C++, LAMMPS",
        machine(),
        format!("x{threads}")
    )?;
    for case in cases.iter().filter(|case| wanted(case.name)) {
        let Figures { nanoseconds, pairs, contacts, listed, refreshes, speed_up } =
            measure(case, (*runs).into(), (*threads).into())?;
        let others = case.others.map_or(String::new(), |others| {
            let factor = |other: f64| format!("{:.0}", other / nanoseconds);
            let lammps = others.lammps.map_or("–".to_owned(), factor);
            format!("{}/{}, {lammps}", factor(others.published), factor(others.published_best))
        });
        let speed_up = speed_up.map_or("–".to_owned(), |factor| format!("{factor:.1}"));
        let line = format!(
            "{:<19}{:>7}{nanoseconds:>7.1}{pairs:>6.2}{contacts:>9.2}{listed:>6.1}{refreshes:>5.0}{speed_up:>5} {others}",
            case.name, case.agents,
        );
        writeln!(out, "{}", line.trim_end())?;
        out.flush()?;
    }
    writeln!(out, "\nLEMONS C++: times as fast as shipped / with the best compiler flags.")?;
    if wanted(THROUGH_FMU) {
        through_fmu(&mut out, arguments.runs.into())?;
    }
    Ok(())
}

const THROUGH_FMU: &str = "through the FMU";

/// The second table: what lies around the mechanics.
fn through_fmu(out: &mut impl Write, runs: usize) -> Result<()> {
    writeln!(out, "\n{:<50}{:>10}", THROUGH_FMU, "")?;
    fmu::measure(runs, |what, value, unit| {
        writeln!(out, "{what:<50}{value:>10.3} {unit}")?;
        Ok(out.flush()?)
    })
}

/// Returns what the figures were measured on.
fn machine() -> String {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let known = input::read_text("/proc/cpuinfo".as_ref(), input::LARGEST_SETTINGS).unwrap_or_default();
    let model = known.lines().find_map(|line| line.strip_prefix("model name")?.split(':').nth(1));
    let (model, s) = (model.map_or(std::env::consts::ARCH, str::trim), if cores == 1 { "" } else { "s" });
    format!("On {model}, {cores} core{s}.")
}
