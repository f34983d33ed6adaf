//! When something is open: a wall that is a door, or an exit.

use crate::xml::{decimal, number};
use serde::{Deserialize, Serialize};

/// \[s\] No time may be later.
const LATEST: f64 = 1e9;
/// Largest number of pairs.
const MOST: usize = 1000;

/// Times \[s\] from and to which something is open: at least one pair, as [`OpeningTimes::RULE`] says. What has none is an
/// `Option` of them: `None` of an exit or of a gap in a wall is always open, `None` of a wall never is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<Vec<f64>>")]
pub struct OpeningTimes(Vec<[f64; 2]>);

/// Arrays of TOML that are too long would be cut.
impl TryFrom<Vec<Vec<f64>>> for OpeningTimes {
    type Error = String;

    fn try_from(pairs: Vec<Vec<f64>>) -> Result<OpeningTimes, String> {
        match pairs.iter().map(Vec::len).find(|count| *count != 2) {
            Some(count) => Err(format!("a time of being open has 2 numbers [from, to], not {count}")),
            None => OpeningTimes::of_numbers(&pairs.concat()),
        }
    }
}

impl OpeningTimes {
    /// Their rule, for messages.
    pub const RULE: &str =
        "at most 1000 pairs of from and to in s, from 0 to 1e9, each number above the one before";

    /// Makes them of the numbers of all pairs; without the last number, it does not close any more.
    ///
    /// # Errors
    /// They are not as [`OpeningTimes::RULE`] says.
    pub fn of_numbers(numbers: &[f64]) -> Result<OpeningTimes, String> {
        let (pairs, last) = numbers.as_chunks();
        let last = last.iter().map(|from| [*from, LATEST]);
        let pairs: Vec<[f64; 2]> = pairs.iter().copied().chain(last).collect();
        let (count, times) = (pairs.len(), pairs.as_flattened());
        if count > MOST {
            return Err(format!("open: {count} pairs; at most {MOST} are allowed"));
        }
        let known = count > 0 && times.iter().all(|time| (0.0..=LATEST).contains(time));
        if known && times.is_sorted_by(|before, time| before < time) {
            return Ok(OpeningTimes(pairs));
        }
        Err(format!("open = {pairs:?}: must be {}", OpeningTimes::RULE))
    }

    /// Returns times that are later than any run.
    pub fn never() -> OpeningTimes {
        OpeningTimes(vec![[LATEST - 1.0, LATEST]])
    }

    /// Returns numbers of which [`OpeningTimes::of_numbers`] makes the same.
    pub fn numbers(&self) -> impl Iterator<Item = f64> {
        self.0.as_flattened().iter().copied().filter(|time| *time != LATEST)
    }

    /// Returns the pairs of from and to.
    pub fn pairs(&self) -> &[[f64; 2]] {
        &self.0
    }

    /// Returns whether it is open at a time \[s\]: from each first time on, until before the second one. A rounding error
    /// is not a time.
    pub fn is_open(&self, time: f64) -> bool {
        let time = time + 1e-9;
        let begun = self.0.partition_point(|&[from, _]| from <= time);
        begun > 0 && time < self.0[begun - 1][1]
    }

    /// Returns the first pair that is shorter than a step \[s\], in which it may never be open, but for rounding errors.
    pub fn shorter_than(&self, step: f64) -> Option<[f64; 2]> {
        self.0.iter().copied().find(|[from, to]| to - from < step - 1e-9)
    }

    /// Returns them as a clock has them that begins at `start` \[s\], without what is over and what is shorter than a step
    /// \[s\].
    #[must_use]
    pub fn since(&self, start: f64, step: f64) -> OpeningTimes {
        let mut later: Vec<[f64; 2]> = Vec::new();
        for [from, to] in self.0.iter().map(|pair| pair.map(|time| (time - start).max(0.0))) {
            // Rounding errors do not make it shorter, or two of one.
            match later.last_mut() {
                Some(last) if from <= last[1] => last[1] = to,
                _ if to > from && to - from >= step - 1e-9 => later.push([from, to]),
                _ => {}
            }
        }
        if later.is_empty() {
            // It does not open any more: no run lasts so long.
            later.push([LATEST - step.max(1.0), LATEST]);
        }
        OpeningTimes(later)
    }

    /// Returns the same, but it closes so much later \[s\], if it is not open again by then.
    #[must_use]
    pub fn lengthened(&self, by: f64) -> OpeningTimes {
        let mut pairs: Vec<[f64; 2]> = Vec::new();
        for &[from, to] in &self.0 {
            let to = (to + by).min(LATEST);
            match pairs.last_mut() {
                Some(last) if from <= last[1] => last[1] = to,
                _ => pairs.push([from, to]),
            }
        }
        OpeningTimes(pairs)
    }

    /// Reads `from,to from,to`.
    pub(crate) fn parse(text: &str) -> Option<OpeningTimes> {
        let pair = |text: &str| {
            let (from, to) = text.split_once(',')?;
            Some([decimal(from)?, decimal(to)?])
        };
        let pairs: Vec<[f64; 2]> = text.split_whitespace().map(pair).collect::<Option<_>>()?;
        OpeningTimes::of_numbers(pairs.as_flattened()).ok()
    }

    /// Returns the text that [`OpeningTimes::parse`] reads as the same doubles.
    pub(crate) fn text(&self) -> String {
        let pairs = self.0.iter().map(|&[from, to]| format!("{},{}", number(from), number(to)));
        pairs.collect::<Vec<_>>().join(" ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_read_and_come_back() {
        let parse = OpeningTimes::parse;
        let open = parse(" 0,5.5  20,1e9 ").unwrap();
        assert_eq!(open.pairs(), [[0.0, 5.5], [20.0, 1e9]]);
        assert_eq!(parse(&open.text()).unwrap(), open);
        assert_eq!(open.numbers().collect::<Vec<_>>(), [0.0, 5.5, 20.0]);
        assert_eq!(OpeningTimes::of_numbers(&[0.0, 5.5, 20.0]).unwrap(), open);
        let seen: Vec<f64> =
            [0.0, 5.4, 5.5, 19.9, 20.0 - 1e-12, 1e8].into_iter().filter(|&t| open.is_open(t)).collect();
        assert_eq!(seen, [0.0, 5.4, 20.0 - 1e-12, 1e8]);
        assert_eq!(open.since(2.0, 0.1).pairs(), [[0.0, 3.5], [18.0, 1e9 - 2.0]]);
        assert_eq!(open.since(5.45, 0.1).pairs(), [[14.55, 1e9 - 5.45]]);
        assert_eq!(open.since(1e9, 0.1).pairs(), [[1e9 - 1.0, 1e9]]);
        assert!(open.since(1e9, 2.0).shorter_than(2.0).is_none());
        // 0.3 - 0.2 is less than 0.1.
        let short = OpeningTimes::of_numbers(&[0.2, 0.3]).unwrap().since(0.1, 0.1);
        assert!(short.is_open(0.15) && !short.is_open(0.25), "{short:?}");
        let longer = |by: f64| open.lengthened(by).0;
        assert_eq!((longer(14.0), longer(14.5)), (vec![[0.0, 19.5], [20.0, 1e9]], vec![[0.0, 1e9]]));
        let many = |count: u32| (0..count).map(|k| format!("{},{} ", 2 * k, 2 * k + 1)).collect::<String>();
        assert!(parse(&many(1000)).is_some() && parse(&many(1001)).is_none());
        for wrong in ["", "5", "5,4", "5,5", "-1,4", "0,2e9", "0,4 3,5", "0,4 4,5", "0,nan", "0,1,2", "0, 1"]
        {
            assert_eq!(parse(wrong), None, "{wrong:?}");
        }
        let message = OpeningTimes::of_numbers(&[60.0, 20.0]).unwrap_err();
        assert!(message.starts_with("open = [[60.0, 20.0]]: must be at most"), "{message}");
        let message = OpeningTimes::try_from(vec![vec![1.0, 2.0, 3.0]]).unwrap_err();
        assert!(message.ends_with("has 2 numbers [from, to], not 3"), "{message}");
    }
}
