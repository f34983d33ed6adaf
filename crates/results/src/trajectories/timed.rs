//! Rows of programs that write times and names of people, not numbers of frames and of people.

use super::{Found, FrameNumbers, LAST_FRAME, MOST_FRAMES, Rows, check_rate, gcd, rate_of};
use crate::error::RecordError;
use crate::shapes::FARTHEST;
use lemons_core::plane::{Vec2, vec2};
use std::collections::HashMap;
use std::path::Path;

/// Largest number of people.
const MOST_PEOPLE: usize = 1_000_000;
/// \[bytes\] Longest name of a person.
const LONGEST_NAME: usize = 256;
/// \[s\] Largest time.
const LAST_TIME: f64 = 1e9;
/// \[s\] Times of programs are sums of steps.
const ROUNDING: f64 = 1e-6;
/// Frames may begin between multiples of their step, after such a part of it.
const PARTS: i64 = 1000;

/// Takes rows with times, and finds their frames at the end.
pub(super) struct Timed<'a> {
    pub rows: Rows<'a>,
    names: Vec<String>,
    people: HashMap<String, usize>,
    /// Of each person, time \[s\] and line of the newest row.
    newest: Vec<(f64, u64)>,
    /// Different times \[s\], and the line of each. Until the end they are the frames of rows.
    times: Vec<(f64, u64)>,
    places: HashMap<u64, usize>,
    /// Decimals of the time that has most of them.
    decimals: usize,
    oriented: bool,
}

impl<'a> Timed<'a> {
    pub fn new(path: &'a Path) -> Timed<'a> {
        Timed {
            rows: Rows::new(path, "line"),
            names: Vec::new(),
            people: HashMap::new(),
            newest: Vec::new(),
            times: Vec::new(),
            places: HashMap::new(),
            decimals: 0,
            oriented: true,
        }
    }

    /// Returns the number of a person.
    pub fn person(&mut self, n: u64, column: &str, name: &str) -> Result<usize, RecordError> {
        if let Some(person) = self.people.get(name) {
            return Ok(*person);
        }
        let wrong = if name.is_empty() {
            "is empty".into()
        } else if name.len() > LONGEST_NAME {
            format!("{} has {} bytes: at most {LONGEST_NAME}", excerpt(name), name.len())
        } else if self.names.len() == MOST_PEOPLE {
            format!("there are more than {MOST_PEOPLE} people: too many")
        } else {
            self.people.insert(name.into(), self.names.len());
            self.names.push(name.into());
            self.newest.push((f64::NEG_INFINITY, 0));
            return Ok(self.names.len() - 1);
        };
        Err(self.rows.wrong(n, format!("column {column}: {wrong}")))
    }

    pub fn number(&self, n: u64, column: &str, text: &str) -> Result<f64, RecordError> {
        let number = text.parse().ok().filter(|value: &f64| value.is_finite());
        number.ok_or_else(|| {
            self.rows.wrong(n, format!("column {column}: {} is not a finite number", excerpt(text)))
        })
    }

    /// \[m\] Returns a position.
    pub fn position(&self, n: u64, columns: [&str; 2], texts: [&str; 2]) -> Result<Vec2, RecordError> {
        let mut p = [0.0; 2];
        for ((own, column), text) in p.iter_mut().zip(columns).zip(texts) {
            *own = self.number(n, column, text)?;
            if own.abs() > FARTHEST {
                let message = format!("column {column}: {} m is further than {FARTHEST:e} m", excerpt(text));
                return Err(self.rows.wrong(n, message + " from the origin"));
            }
        }
        Ok(vec2(p[0], p[1]))
    }

    /// \[s\] Returns a time.
    pub fn time(&mut self, n: u64, column: &str, text: &str) -> Result<f64, RecordError> {
        let time = self.number(n, column, text)?;
        if !(0.0..=LAST_TIME).contains(&time) {
            let message = format!("column {column}: {} s is not from 0 to {LAST_TIME:e} s", excerpt(text));
            return Err(self.rows.wrong(n, message));
        }
        let decimals = text.split_once('.').map_or(0, |(_, decimals)| decimals.len());
        self.decimals = self.decimals.max(if text.contains(['e', 'E']) { 17 } else { decimals });
        // -0
        Ok(time + 0.0)
    }

    /// Says that there is a frame at this time, and returns its place.
    pub fn frame(&mut self, n: u64, time: f64) -> Result<usize, RecordError> {
        if let Some((newest, _)) = self.times.last()
            && *newest == time
        {
            return Ok(self.times.len() - 1);
        }
        let place = *self.places.entry(time.to_bits()).or_insert(self.times.len());
        if place == self.times.len() {
            if self.times.len() as u64 == MOST_FRAMES {
                return Err(self
                    .rows
                    .wrong(n, format!("there are more than {MOST_FRAMES:e} times: too many")));
            }
            self.times.push((time, n));
        }
        Ok(place)
    }

    /// Adds a row: line, person, time \[s\], position, orientation \[rad\].
    pub fn add(
        &mut self,
        n: u64,
        person: usize,
        time: f64,
        p: Vec2,
        orientation: f64,
    ) -> Result<(), RecordError> {
        let (before, line) = self.newest[person];
        if time <= before {
            let (name, stands) =
                (excerpt(&self.names[person]), if time == before { "stands twice" } else { "goes back" });
            let message = format!("id {name} {stands}: at {time:?} s, and at {before:?} s in line {line}");
            return Err(self.rows.wrong(n, message));
        }
        self.newest[person] = (time, n);
        self.oriented &= orientation.is_finite();
        let frame = self.frame(n, time)?;
        self.rows.add(n, person as i64, frame as i64, p, orientation)
    }

    /// Returns what was found. A last time may lie between two frames if `ends_between`: then it is left out.
    pub fn finish(mut self, told: Option<f64>, ends_between: bool) -> Result<Found, RecordError> {
        let path = self.rows.path;
        let rounding = 0.5 * 0.1_f64.powi(self.decimals.min(17) as i32);
        let mut order: Vec<usize> = (0..self.times.len()).collect();
        order.sort_unstable_by(|a, b| self.times[*a].0.total_cmp(&self.times[*b].0));
        let sorted: Vec<f64> = order.iter().map(|place| self.times[*place].0).collect();
        let mut notes = Vec::new();
        let grid = match Grid::of(&sorted, told, rounding) {
            Err(_) if ends_between && sorted.len() > 3 => {
                let last = sorted.len() - 1;
                notes.push(format!(
                    "the last frame, at {:?} s, is between two others: left out",
                    sorted[last]
                ));
                let left = order.pop();
                self.rows.rows.retain(|row| Some(row.frame as usize) != left);
                Grid::of(&sorted[..last], told, rounding)
            }
            grid => grid,
        };
        let grid = match grid {
            Ok(Some(grid)) => grid,
            Ok(None) => {
                let message = "has one time only, and no frame rate: tell it (--fps)";
                return Err(RecordError::wrong(path, message));
            }
            Err(place) => {
                let (time, line) = self.times[order[place]];
                let step = told.map_or("one step".into(), |rate| format!("1/{rate:?} s (--fps)"));
                let message =
                    format!("time {time:?} s is no multiple of {step}: times must be equally far apart");
                return Err(self.rows.wrong(line, message));
            }
        };
        let rate = rate_of(path, Some(grid.rate), None)?;
        let mut frames = vec![0; self.times.len()];
        for place in order {
            let (time, line) = self.times[place];
            frames[place] = grid.frame(time);
            if frames[place] > LAST_FRAME {
                let message = format!("time {time:?} s is frame {}: above {LAST_FRAME:e}", frames[place]);
                return Err(self.rows.wrong(line, message));
            }
        }
        for row in &mut self.rows.rows {
            row.frame = frames[row.frame as usize];
        }
        // Frames without anybody count, too.
        let all = sorted.iter().map(|time| grid.frame(*time));
        let first = all.clone().next().unwrap_or(0);
        let last = if notes.is_empty() { sorted.len() } else { sorted.len() - 1 };
        let named = all.take(last).fold(FrameNumbers { first, last: first, step: 0 }, |named, frame| {
            FrameNumbers { last: frame, step: gcd(named.step, frame - first), ..named }
        });
        self.found(rate, Some(named), notes)
    }

    /// Returns rows that have their frames. People are in the order of their numbers, if all names are numbers.
    pub fn found(
        mut self,
        rate: f64,
        frames: Option<FrameNumbers>,
        notes: Vec<String>,
    ) -> Result<Found, RecordError> {
        let numbers: Option<Vec<i64>> = self.names.iter().map(|name| name.parse().ok()).collect();
        if let Some(numbers) = numbers {
            let mut order: Vec<usize> = (0..numbers.len()).collect();
            order.sort_by_key(|person| numbers[*person]);
            let mut rank = vec![0; numbers.len()];
            for (new, person) in order.iter().enumerate() {
                rank[*person] = new as i64;
            }
            for row in &mut self.rows.rows {
                row.id = rank[row.id as usize];
            }
            self.names = order.iter().map(|person| std::mem::take(&mut self.names[*person])).collect();
        }
        let oriented = self.oriented && !self.rows.rows.is_empty();
        let (what, rows, names) = (self.rows.what, self.rows.rows, Some(self.names));
        Ok(Found { what, rows, rate, frames, oriented, geometry: Vec::new(), names, notes })
    }
}

/// Frames that are equally far apart: each is `before` and a multiple of `parts`, at `rate` per second.
struct Grid {
    /// \[1/s\]
    rate: f64,
    /// \[s\]
    first: f64,
    before: i64,
    parts: i64,
}

impl Grid {
    /// Returns the frames of rising times \[s\], which are rounded by as much as `rounding`; `None` if one time says no rate.
    ///
    /// # Errors
    /// The place of a time that is none of their frames.
    fn of(times: &[f64], told: Option<f64>, rounding: f64) -> Result<Option<Grid>, usize> {
        let Some((&first, later)) = times.split_first() else { return Ok(None) };
        let mut gaps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let own = gaps.clone();
        gaps.sort_unstable_by(f64::total_cmp);
        let Some(&smallest) = gaps.first() else {
            return Ok(told.map(|rate| Grid {
                rate,
                first,
                before: (first * rate).round() as i64,
                parts: 1,
            }));
        };
        // The more steps, the less does rounding do.
        let (mut sum, mut count, mut step) = (0.0, 0.0, smallest);
        for gap in &gaps {
            (sum, count) = (sum + gap, count + (gap / step).round());
            step = sum / count;
        }
        let decimal = ((step * 1e3).round() / 1e3).recip();
        let rates = match told {
            Some(rate) => vec![rate],
            None => vec![step.recip().round(), decimal, step.recip()],
        };
        let within =
            |time: f64, rate: f64, rounding: f64| (rounding + ROUNDING + 1e-9 * time).min(0.25 / rate);
        let fits = |rate: f64, rounding: f64| {
            let (mut early, mut late) = (0.0_f64, 0.0_f64);
            check_rate(rate).is_ok()
                && later.iter().all(|time| {
                    let frames = ((time - first) * rate).round();
                    let off = time - first - frames / rate;
                    (early, late) = (early.min(off), late.max(off));
                    // The first time is rounded, too.
                    frames > 0.0 && late - early <= within(*time, rate, 2.0 * rounding)
                })
        };
        let fitting = |rounding| rates.iter().copied().find(|rate| fits(*rate, rounding));
        let Some(rate) = fitting(0.0).or_else(|| fitting(rounding)) else {
            let usual = gaps[gaps.len() / 2];
            let odd = |gap: &f64| (gap / usual - (gap / usual).round().max(1.0)).abs() > 0.01;
            return Err(own.iter().position(odd).map_or(times.len() - 1, |place| place + 1));
        };
        let begins = |parts: i64, rounding: f64| {
            let rate = rate * parts as f64;
            let before = (first * rate).round();
            ((first - before / rate).abs() <= within(first, rate, rounding)).then_some((before as i64, parts))
        };
        let begin = (1..=PARTS).find_map(|parts| begins(parts, 0.0)).or_else(|| begins(1, rounding));
        let (before, parts) = begin.ok_or(0_usize)?;
        Ok(Some(Grid { rate: rate * parts as f64, first, before, parts }))
    }

    /// Returns the number of the frame at one of the times \[s\].
    fn frame(&self, time: f64) -> i64 {
        self.before + self.parts * ((time - self.first) * self.rate / self.parts as f64).round() as i64
    }
}

/// Returns the beginning of a text, as messages show it.
pub(super) fn excerpt(text: &str) -> String {
    let begin: String = text.chars().take(40).collect();
    if begin.len() < text.len() { format!("{begin:?}…") } else { format!("{begin:?}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frames(times: &[f64], decimals: i32) -> Result<(f64, Vec<i64>), usize> {
        let grid = Grid::of(times, None, 0.5 * 0.1_f64.powi(decimals))?.unwrap();
        Ok((grid.rate, times.iter().map(|time| grid.frame(*time)).collect()))
    }

    #[test]
    fn times_that_are_rounded_or_missing_have_a_rate() {
        assert_eq!(frames(&[0.0, 0.5, 1.0, 2.0], 2), Ok((2.0, vec![0, 1, 2, 4])));
        // Steps of 1/30 s, 0.125 s and 0.07 s with two decimals; the second begins late, and has a long gap.
        let film: Vec<f64> = (0..100).map(|k| (f64::from(k) / 0.3).round() / 100.0).collect();
        assert_eq!(frames(&film, 2), Ok((30.0, (0..100).collect())));
        let late = [1.0, 1.12, 1.25, 1.38, 1.5, 41.62];
        assert_eq!(frames(&late, 2), Ok((8.0, vec![8, 9, 10, 11, 12, 333])));
        let (rate, all) = frames(&[0.07, 0.14, 0.21], 2).unwrap();
        assert!((rate - 1.0 / 0.07).abs() < 1e-9 && all == [1, 2, 3]);
        // The first time is no multiple of the step.
        assert_eq!(frames(&[3.0, 8.0, 13.0], 2), Ok((1.0, vec![3, 8, 13])));
    }

    #[test]
    fn a_time_between_two_frames_is_found() {
        assert_eq!(frames(&[0.0, 1.0, 2.0, 2.775, 4.0], 3), Err(3));
        assert_eq!(frames(&[0.0, 0.5, 1.0, 1.7, 2.2], 2), Err(3));
    }
}
