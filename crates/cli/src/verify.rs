//! `lemons verify`: the mechanics against things it did not produce.

use anyhow::{Result, bail};
use std::io::{self, Write};

#[derive(clap::Args)]
pub struct Arguments {
    /// Only rows whose name contains this
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
}

pub fn verify(arguments: &Arguments) -> Result<()> {
    let mut out = io::stdout().lock();
    let checks = lemons_verify::checks();
    let wanted =
        checks.iter().filter(|check| arguments.only.as_ref().is_none_or(|only| check.name.contains(only)));
    let (mut passed, mut failed) = (0, 0);
    writeln!(out, "{:58} {:>9}  {:>7}  ", "largest difference of … from …", "found", "limit")?;
    for check in wanted {
        let (figure, trouble) = match (check.measure)() {
            Ok(figure) => (figure, None),
            Err(error) => (f64::NAN, Some(error)),
        };
        let verdict = if check.passes(figure) { "ok" } else { "FAIL" };
        *(if check.passes(figure) { &mut passed } else { &mut failed }) += 1;
        let unit = if check.unit.is_empty() { String::new() } else { format!(" [{}]", check.unit) };
        writeln!(
            out,
            "{:58} {figure:>9.1e}  {:>7.0e}  {verdict}",
            format!("{}{unit}", check.name),
            check.limit
        )?;
        writeln!(out, "    against {}", check.against)?;
        if let Some(error) = trouble {
            writeln!(out, "    {error:#}")?;
        }
        out.flush()?;
    }
    writeln!(out, "{passed} passed, {failed} failed")?;
    if failed > 0 {
        bail!("{failed} of {} rows failed", passed + failed);
    }
    Ok(())
}
