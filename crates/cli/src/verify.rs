//! `lemons verify`: the mechanics against things it did not produce.

use crate::error::full_message;
use crate::print;
use anyhow::{Result, bail};
use lemons_verify::checks::Check;
use std::io::Write;

#[derive(clap::Args)]
pub struct Arguments {
    /// Compute only rows whose name contains this text
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
    /// Print the Markdown table of DESIGN.md
    #[arg(long)]
    markdown: bool,
}

pub fn verify(arguments: &Arguments) -> Result<()> {
    let mut out = print::out();
    let checks = lemons_verify::checks::all();
    let wanted = |check: &&Check| arguments.only.as_ref().is_none_or(|only| check.name.contains(only));
    let (mut passed, mut failed) = (0, 0);
    if arguments.markdown {
        writeln!(out, "| what | against | largest difference | limit |\n|---|---|---|---|")?;
    }
    for check in checks.iter().filter(wanted) {
        let measured = (check.measure)();
        let figure = *measured.as_ref().unwrap_or(&f64::NAN);
        let passes = check.passes(figure);
        *(if passes { &mut passed } else { &mut failed }) += 1;
        let verdict = if passes { "ok" } else { "FAIL" };
        let unit = if check.unit.is_empty() { String::new() } else { format!(" [{}]", check.unit) };
        if arguments.markdown {
            let name = check.name.replace('|', "\\|");
            let against = check.against.replace('|', "\\|");
            writeln!(out, "| {name}{unit} | {against} | {figure:.1e} | {:.0e} |", check.limit)?;
        } else {
            let (name, against) = (check.name, format!("against {}", check.against));
            writeln!(out, "{name}{unit}")?;
            let limit =
                if check.limit == 0.0 { "exact".into() } else { format!("within {:>5.0e}", check.limit) };
            writeln!(out, "    {against:46} {figure:>9.1e}  {limit:<12}  {verdict}")?;
        }
        if let Err(error) = &measured {
            writeln!(out, "    {}", full_message(error))?;
        }
        out.flush()?;
    }
    if arguments.only.is_none() && !arguments.markdown {
        writeln!(out, "{}", lemons_verify::checks::tables()?)?;
    }
    if !arguments.markdown {
        writeln!(out, "{passed} passed, {failed} failed")?;
    }
    if passed + failed == 0 {
        bail!("no row has {:?} in its name", arguments.only.as_deref().unwrap_or_default());
    }
    if failed > 0 {
        bail!("{failed} of {} rows failed", passed + failed);
    }
    Ok(())
}
