//! The flow of those who crossed a line.

use crate::measure::passages::Passage;
use crate::measure::quantile::quantile;

/// The flow over a line in one direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Flow {
    /// \[1/s\] (N − 1) / (t_N − t_1): from the first to the last passage. `None` for fewer than two, or all at one time.
    pub rate: Option<f64>,
    /// \[s\] Between successive passages, in the order of time.
    pub gaps: Vec<f64>,
}

impl Flow {
    /// Makes the flow of passages in the order of time.
    pub fn of(passages: &[Passage]) -> Flow {
        let gaps: Vec<f64> = passages.windows(2).map(|pair| pair[1].time - pair[0].time).collect();
        let seconds =
            passages.last().zip(passages.first()).map_or(0.0, |(last, first)| last.time - first.time);
        Flow { rate: (seconds > 0.0).then(|| gaps.len() as f64 / seconds), gaps }
    }

    /// Returns a quantile of the time gaps \[s\], `part` from 0 to 1; `None` without any gap.
    pub fn gap(&self, part: f64) -> Option<f64> {
        let mut ascending = self.gaps.clone();
        ascending.sort_by(f64::total_cmp);
        quantile(&ascending, part)
    }
}

/// A part of the time in which people are counted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// \[s\]
    pub from: f64,
    /// \[s\]
    pub until: f64,
    /// People who passed from the beginning on, and before the end. The last window has its end, too.
    pub count: usize,
}

impl Window {
    /// Returns the flow \[1/s\]: the number over the length of the window.
    pub fn flow(&self) -> f64 {
        self.count as f64 / (self.until - self.from)
    }
}

/// Returns windows of this length \[s\] from a time to another \[s\], with those of the passages (in the order of time)
/// that are in each. The last one is shorter if the length does not divide the time. None if there is no time between.
pub fn windows(passages: &[Passage], from: f64, until: f64, length: f64) -> Vec<Window> {
    // The rounding of sums of steps makes no window.
    let count = ((until - from) / length - 1e-6).ceil().max(0.0) as usize;
    let begin = |k: usize| from + k as f64 * length;
    let mut rest = passages;
    let windows = (0..count).map(|k| {
        let last = k + 1 == count;
        let end = if last { until } else { begin(k + 1) };
        let inside = rest.partition_point(|passage| last || passage.time < end);
        rest = &rest[inside..];
        Window { from: begin(k), until: end, count: inside }
    });
    windows.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn passages(times: &[f64]) -> Vec<Passage> {
        times.iter().enumerate().map(|(agent, &time)| Passage { time, agent }).collect()
    }

    #[test]
    fn the_flow_is_between_the_first_and_the_last() {
        let flow = Flow::of(&passages(&[1.0, 1.5, 3.5, 5.0]));
        assert_eq!((flow.rate, flow.gap(0.5)), (Some(0.75), Some(1.5)));
        assert_eq!(flow.gaps, [0.5, 2.0, 1.5]);
        assert_eq!((flow.gap(0.0), flow.gap(1.0), flow.gap(0.25)), (Some(0.5), Some(2.0), Some(1.0)));
        for few in [&[][..], &[2.0], &[2.0, 2.0]] {
            assert_eq!(Flow::of(&passages(few)).rate, None);
        }
        assert_eq!(Flow::of(&passages(&[2.0])).gap(0.5), None);
    }

    #[test]
    fn each_passage_is_in_one_window() {
        let all = passages(&[0.0, 0.5, 1.0, 1.0, 2.4, 2.5]);
        let windows = windows(&all, 0.0, 2.5, 1.0);
        let seen: Vec<_> = windows.iter().map(|w| (w.from, w.until, w.count, w.flow())).collect();
        assert_eq!(seen, [(0.0, 1.0, 2, 2.0), (1.0, 2.0, 2, 2.0), (2.0, 2.5, 2, 4.0)]);
        // 0.1 + 0.2 is more than 0.3: it makes no fourth window.
        assert_eq!(super::windows(&all, 0.0, 0.1 + 0.2, 0.1).len(), 3);
        assert!(super::windows(&all, 1.0, 1.0, 0.1).is_empty());
    }
}
