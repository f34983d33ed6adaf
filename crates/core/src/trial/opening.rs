//! When something is open: a wall that is a door, or an exit.

use crate::xml::{decimal, number};

/// \[s\] No time may be later.
pub const LATEST: f64 = 1e9;

/// Largest number of times from and to which something is open.
pub const MOST_TIMES: usize = 1000;

/// What times must be, for messages.
pub const TIMES: &str =
    "at most 1000 pairs of from and to in s, from 0 to 1e9, each number above the one before";

/// Returns whether these are at most [`MOST_TIMES`] times \[s\] as [`TIMES`] says.
pub fn are_times(open: &[[f64; 2]]) -> bool {
    let times = open.as_flattened();
    let known = times.iter().all(|time| (0.0..=LATEST).contains(time));
    known && times.windows(2).all(|pair| pair[0] < pair[1]) && open.len() <= MOST_TIMES
}

/// Returns whether something is open at a time \[s\]: from each first time on, until before the second one. A rounding
/// error is not a time.
pub fn is_open(open: &[[f64; 2]], time: f64) -> bool {
    let time = time + 1e-9;
    let begun = open.partition_point(|&[from, _]| from <= time);
    begun > 0 && time < open[begun - 1][1]
}

/// \[s\] The times of what does not open any more: without any, a wall never opens, and an exit is always open.
const NEVER: [f64; 2] = [LATEST - 1.0, LATEST];

/// Returns times as a clock has them that begins at `start` \[s\], without what is over and what is shorter than a step
/// \[s\].
pub fn times_from(open: &[[f64; 2]], start: f64, step: f64) -> Vec<[f64; 2]> {
    let later = open.iter().map(|pair| pair.map(|time| (time - start).max(0.0)));
    let later: Vec<_> = later.filter(|[from, to]| to - from >= step).collect();
    if later.is_empty() { vec![NEVER] } else { later }
}

/// Reads `from,to from,to`.
pub(crate) fn parse(text: &str) -> Option<Vec<[f64; 2]>> {
    let pair = |text: &str| {
        let (from, to) = text.split_once(',')?;
        Some([decimal(from)?, decimal(to)?])
    };
    let open: Vec<[f64; 2]> = text.split_whitespace().map(pair).collect::<Option<_>>()?;
    (are_times(&open) && !open.is_empty()).then_some(open)
}

/// Returns the text that [`parse`] reads as the same doubles.
pub(crate) fn text(open: &[[f64; 2]]) -> String {
    let pairs = open.iter().map(|&[from, to]| format!("{},{}", number(from), number(to)));
    pairs.collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_read_and_come_back() {
        let open = parse(" 0,5.5  20,1e9 ").unwrap();
        assert_eq!(open, [[0.0, 5.5], [20.0, 1e9]]);
        assert_eq!(parse(&text(&open)).unwrap(), open);
        let seen: Vec<f64> =
            [0.0, 5.4, 5.5, 19.9, 20.0 - 1e-12, 1e8].into_iter().filter(|&t| is_open(&open, t)).collect();
        assert_eq!(seen, [0.0, 5.4, 20.0 - 1e-12, 1e8]);
        assert_eq!(times_from(&open, 2.0, 0.1), [[0.0, 3.5], [18.0, 1e9 - 2.0]]);
        assert_eq!(times_from(&open, 5.45, 0.1), [[14.55, 1e9 - 5.45]]);
        assert_eq!(times_from(&open, 1e9, 0.1), [NEVER]);
        let many = |count: u32| (0..count).map(|k| format!("{},{} ", 2 * k, 2 * k + 1)).collect::<String>();
        assert!(parse(&many(1000)).is_some() && parse(&many(1001)).is_none());
        for wrong in ["", "5", "5,4", "5,5", "-1,4", "0,2e9", "0,4 3,5", "0,4 4,5", "0,nan", "0,1,2", "0, 1"]
        {
            assert_eq!(parse(wrong), None, "{wrong:?}");
        }
    }
}
