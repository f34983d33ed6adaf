//! Texts as `PeTrack` and the data archive of Jülich have them, and as `PedPy` reads them: comments after `#`, among them
//! the frame rate and the unit; then lines `id frame x y z`.

use super::{Found, Rows, Told, rate_of};
use crate::error::RecordError;
use lemons_core::files::input::Bounded;
use lemons_core::plane::vec2;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

/// \[bytes\] The largest text.
pub(super) const LARGEST: u64 = 4_000_000_000;
/// \[bytes\] The longest line.
const LONGEST_LINE: u64 = 65_536;

/// Information in comments.
#[derive(Default)]
struct Stated {
    /// Units in a metre.
    per_metre: Option<f64>,
    /// \[1/s\]
    rate: Option<f64>,
}

impl Stated {
    /// Takes what a comment says of the frame rate and of the unit.
    fn take(&mut self, comment: &str) -> Result<(), String> {
        let comment = comment.to_ascii_lowercase();
        if let Some((_, rest)) = comment.split_once("framerate") {
            let rest = rest.trim_start_matches(|c: char| c == ':' || c == '=' || c.is_whitespace());
            let end =
                rest.find(|c: char| !matches!(c, '0'..='9' | '.' | 'e' | '-' | '+')).unwrap_or(rest.len());
            // A decimal comma or a fraction would end it too early.
            let goes_on = rest[end..]
                .strip_prefix([',', '/'])
                .is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()));
            let number = rest[..end].parse().ok().filter(|_| !goes_on);
            let rate = number
                .ok_or_else(|| format!("framerate: {:?} begins with no plain number", rest.trim_end()))?;
            same(&mut self.rate, rate, "frame rates")?;
        }
        let words: Vec<&str> =
            comment.split_whitespace().map(|word| word.trim_matches(['(', ')', ',', ';', '.'])).collect();
        for (k, word) in words.iter().enumerate() {
            let after = if k > 0 && words[k - 1] == "in" { Some(*word) } else { None };
            let bracket = word.strip_prefix("x[").and_then(|word| word.strip_suffix(']'));
            match word.strip_prefix("x/").or(bracket).or(after) {
                Some("cm") => same(&mut self.per_metre, 100.0, "units")?,
                Some("m" | "meters" | "metres") => same(&mut self.per_metre, 1.0, "units")?,
                _ => {}
            }
        }
        Ok(())
    }
}

fn same(own: &mut Option<f64>, new: f64, what: &str) -> Result<(), String> {
    if own.is_some_and(|own| own != new) {
        return Err(format!("there are two {what}"));
    }
    *own = Some(new);
    Ok(())
}

/// The lines of a text.
pub(super) struct Lines<'a> {
    path: &'a Path,
    file: BufReader<Bounded<File>>,
    bytes: Vec<u8>,
    n: u64,
}

impl<'a> Lines<'a> {
    pub fn new(path: &'a Path, file: File) -> Lines<'a> {
        Lines { path, file: BufReader::new(Bounded::new(file, LARGEST)), bytes: Vec::new(), n: 0 }
    }

    /// Returns the number of the next line, and the line with its end; `None` after the last one.
    pub fn next(&mut self) -> Result<Option<(u64, &str)>, RecordError> {
        let cannot = |error| RecordError::Read { path: self.path.to_owned(), error };
        self.bytes.clear();
        self.n += 1;
        let n = self.n;
        if self.file.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut self.bytes).map_err(cannot)? == 0 {
            return Ok(None);
        }
        let wrong = |message| RecordError::wrong(self.path, format!("line {n}: {message}"));
        if self.bytes.len() as u64 == LONGEST_LINE {
            return Err(wrong(format!("is longer than {LONGEST_LINE} bytes")));
        }
        let line = std::str::from_utf8(&self.bytes).map_err(|_| wrong("is not UTF-8 text".into()))?;
        Ok(Some((n, if n == 1 { line.trim_start_matches('\u{feff}') } else { line })))
    }
}

pub(super) fn read(path: &Path, file: File, told: &Told) -> Result<Found, RecordError> {
    let mut lines = Lines::new(path, file);
    let (mut rows, mut stated, mut head) = (Rows::new(path, "line"), Stated::default(), None);
    while let Some((n, line)) = lines.next()? {
        let (line, comment) = line.split_once('#').map_or((line, None), |(line, after)| (line, Some(after)));
        if let (Some(comment), None) = (comment, head) {
            stated.take(comment).map_err(|wrong| rows.wrong(n, wrong))?;
        }
        let mut cells = line.split_whitespace();
        let Some(first) = cells.next() else { continue };
        let [id, frame, x, y] = match (cells.next(), cells.next(), cells.next()) {
            (Some(frame), Some(x), Some(y)) => [first, frame, x, y],
            _ => {
                let count = line.split_whitespace().count();
                return Err(rows.wrong(n, format!("has {count} columns: it must have id, frame, x, y")));
            }
        };
        let per_metre = match head {
            Some(per_metre) => per_metre,
            None => *head.insert(
                per_metre_of(&stated, told).map_err(|wrong| rows.wrong(n, format!("x = {x}: {wrong}")))?,
            ),
        };
        let whole = |name, text: &str| {
            // Some programs write all numbers as real ones.
            let real = || text.parse::<f64>().ok().filter(|value| value.fract() == 0.0 && value.abs() < 2e15);
            let whole = text.parse().ok().or_else(|| Some(real()? as i64));
            whole.ok_or_else(|| rows.wrong(n, format!("column {name}: {text:?} is not a whole number")))
        };
        let number = |name, text: &str| {
            let number = text.parse().ok().filter(|value: &f64| value.is_finite());
            number.ok_or_else(|| rows.wrong(n, format!("column {name}: {text:?} is not a finite number")))
        };
        let (id, frame) = (whole("id", id)?, whole("frame", frame)?);
        let position = vec2(number("x", x)? / per_metre, number("y", y)? / per_metre);
        rows.add(n, id, frame, position, f64::NAN)?;
    }
    let rate = rate_of(path, stated.rate, told.rate)?;
    let (what, rows) = (rows.what, rows.rows);
    Ok(Found {
        what,
        rows,
        rate,
        frames: None,
        oriented: false,
        geometry: Vec::new(),
        names: None,
        notes: Vec::new(),
    })
}

/// Returns how many units are a metre.
fn per_metre_of(stated: &Stated, told: &Told) -> Result<f64, String> {
    match (stated.per_metre, told.per_metre) {
        (Some(own), Some(told)) if own != told => {
            Err("the file says another unit than is told (--unit)".into())
        }
        (Some(unit), _) | (None, Some(unit)) => Ok(unit),
        (None, None) => {
            Err("no comment before it says the unit of lengths (x/m or x/cm): tell it (--unit m or cm)"
                .into())
        }
    }
}
