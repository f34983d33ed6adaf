//! `lemons replay`: an FMU against the reference in it.

use crate::values::number;
use anyhow::{Result, bail};
use lemons_master::{Difference, ReplayedExperiment};
use std::path::PathBuf;

#[derive(clap::Args)]
pub struct Arguments {
    /// An FMU with a reference: of lemons pack --reference, or of another tool with experiments by FMI-LS-REF
    #[arg(value_name = "FILE.fmu")]
    fmu: PathBuf,
    /// Let values differ by this number, times the value of the reference where that is larger than 1. Default: all bits must be the
    /// same
    #[arg(long, value_name = "NUMBER", value_parser = number(|value| value >= 0.0 && value.is_finite(), "a number, at least 0"))]
    tolerance: Option<f64>,
}

pub fn replay(arguments: &Arguments) -> Result<()> {
    let mut differ = 0;
    for replay in lemons_master::replay(&arguments.fmu, arguments.tolerance)? {
        let ReplayedExperiment { name, clock, rows, width, different, first, largest, warnings } = replay;
        warnings.iter().for_each(|warning| note!("{warning}"));
        let (start, until, step) = (clock.start, clock.until, clock.step);
        say!("experiment {name:?}: from {start:?} to {until:?} s, communication step {step:?} s")?;
        say!("compared   {width} values in each of {rows} rows")?;
        for (what, found) in [("first", first), ("largest", largest)] {
            if let Some(Difference { time, name, value, reference }) = found {
                let by = (value - reference).abs();
                say!(
                    "{what:<10} t = {time:?} s, {name} = {value:?}, reference {reference:?}, difference {by:.1e}"
                )?;
            }
        }
        say!(
            "result     {}",
            match (different, arguments.tolerance) {
                (0, None) => "the same bits".to_owned(),
                (0, Some(tolerance)) => format!("the same within {tolerance:?}"),
                _ => format!("{different} of {} values differ", rows * width),
            }
        )?;
        differ += usize::from(different > 0);
    }
    if differ > 0 {
        bail!("{}: the results are not those of its reference", arguments.fmu.display());
    }
    Ok(())
}
