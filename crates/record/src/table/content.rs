//! What a table holds, and whether a table is that one.

use crate::columns::Column;

/// What a table holds besides its rows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Content {
    /// The first one is the time ([`Column::time`]).
    pub columns: Vec<Column>,
    /// Keys and values about the whole table. Parquet has them in its metadata, CSV has no place for them.
    pub about: Vec<(&'static str, String)>,
}

/// How much was written of a table.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Extent {
    /// Number of rows.
    pub rows: u64,
    /// \[s\] Time of the last row; `None` if there is no row.
    pub last: Option<f64>,
    /// Digest of what was written: of the bytes (CSV), or of the cells (Parquet). 0 if there is no row.
    pub digest: u128,
}

/// Whether a table is what was written before: number of rows, time of the last row \[s\].
pub(super) fn check_kept(kept: Extent, there: Extent) -> Result<(), String> {
    let Extent { rows, last, digest } = there;
    if rows != kept.rows {
        return Err(format!("it has {rows} rows, not the {} that were written before", kept.rows));
    }
    if last.map(f64::to_bits) != kept.last.map(f64::to_bits) {
        let said = |time: Option<f64>| time.map_or("no number".into(), |time| format!("{time:?} s"));
        return Err(format!("its last row is of t = {}, not of t = {}", said(last), said(kept.last)));
    }
    if digest != kept.digest {
        return Err("it is the table of another run, or it was changed since".into());
    }
    Ok(())
}

/// Whether a table has the columns that are expected.
pub(super) fn check_headings(
    there: impl Iterator<Item = String>,
    here: impl Iterator<Item = String>,
) -> Result<(), String> {
    let (there, here): (Vec<String>, Vec<String>) = (there.collect(), here.collect());
    if let Some(k) = (0..there.len().max(here.len())).find(|&k| there.get(k) != here.get(k)) {
        let said = |list: &[String]| list.get(k).map_or("missing".into(), |name| format!("{name:?}"));
        return Err(format!("column {} is {}, not {}", k + 1, said(&there), said(&here)));
    }
    Ok(())
}
