//! Everybody's impulse of the squeeze over time, and its means over spans of time.

use crate::measure::ROUNDING;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Everybody's mean squeeze over spans of time, from the impulse of each person up to each communication point. Between
/// two points it is linear: within a step the squeeze counts as its mean.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MovingMeans {
    /// \[s\] Communication points, back to one that is as long ago as what is kept; \[N s\] of each person, up to there.
    points: VecDeque<(f64, Vec<f64>)>,
    /// \[s\]
    longest: f64,
}

impl MovingMeans {
    /// Begins; no span is longer than `longest` \[s\].
    pub fn over(longest: f64) -> MovingMeans {
        MovingMeans { points: VecDeque::new(), longest }
    }

    /// Returns whether they can be of so many people, with this longest span \[s\].
    pub fn fits(&self, people: usize, longest: f64) -> bool {
        let finite = |(time, sums): &(f64, Vec<f64>)| {
            time.is_finite() && sums.len() == people && sums.iter().all(|sum| sum.is_finite())
        };
        let rising = self.points.iter().zip(self.points.iter().skip(1)).all(|(a, b)| a.0 < b.0);
        self.longest == longest && self.points.iter().all(finite) && rising
    }

    /// Adds the next communication point \[s\], with the mean squeeze \[N\] of each person over the step that ends there;
    /// `None` of those who are not there. Returns their means \[N\] over the longest span, which ends at this point; `None`
    /// as long as the first of these spans is not over.
    pub fn add(&mut self, time: f64, means: impl Iterator<Item = Option<f64>>) -> Option<Vec<f64>> {
        self.step(time, means);
        self.covers(self.longest, time).then(|| self.means(self.longest, time).collect())
    }

    /// Adds the next communication point \[s\] in the same way. Returns the point before; of the first point only the time
    /// counts.
    pub(crate) fn step(&mut self, time: f64, means: impl Iterator<Item = Option<f64>>) -> Option<f64> {
        let Some((before, last)) = self.points.back() else {
            self.points.push_back((time, means.map(|_| 0.0).collect()));
            return None;
        };
        let (before, step) = (*before, time - before);
        let sums = last.iter().zip(means).map(|(sum, mean)| sum + mean.unwrap_or(0.0) * step).collect();
        self.points.push_back((time, sums));
        let needed = before - self.longest - ROUNDING;
        while self.points.get(1).is_some_and(|(next, _)| *next <= needed) {
            self.points.pop_front();
        }
        Some(before)
    }

    /// \[N s\] Of each person, since the first point.
    pub(crate) fn now(&self) -> &[f64] {
        self.points.back().map_or(&[], |(_, sums)| sums)
    }

    /// Returns whether a span \[s\] that ends then \[s\] has begun at the first point or later.
    pub(crate) fn covers(&self, span: f64, end: f64) -> bool {
        self.points.front().is_some_and(|(first, _)| end - span >= first - ROUNDING)
    }

    /// \[s\] In the step from `before` to `time`, the newest: the ends of all spans of this length that begin or end at a
    /// communication point. Between two of them, means over such spans change linearly.
    pub(crate) fn ends(&self, span: f64, before: f64, time: f64) -> Vec<f64> {
        let from = self.points.partition_point(|(begin, _)| begin + span <= before);
        let begins = self.points.range(from..).map(|(begin, _)| begin + span);
        begins.take_while(|end| *end < time).chain(self.covers(span, time).then_some(time)).collect()
    }

    /// \[N\] Mean of each person over the span \[s\] that ends then \[s\].
    pub(crate) fn means(&self, span: f64, end: f64) -> impl Iterator<Item = f64> {
        let (low, high) = (self.place(end - span), self.place(end));
        let at = |(place, part): (usize, f64), agent: usize| {
            let a = self.points[place].1[agent];
            if part == 0.0 { a } else { a + (self.points[place + 1].1[agent] - a) * part }
        };
        (0..self.now().len()).map(move |agent| (at(high, agent) - at(low, agent)) / span)
    }

    /// The communication point before a time \[s\], and which part of the step after it is over then.
    fn place(&self, time: f64) -> (usize, f64) {
        let before = self.points.partition_point(|(point, _)| *point <= time).saturating_sub(1);
        let part = self.points.get(before + 1).map_or(0.0, |(next, _)| {
            let begin = self.points[before].0;
            ((time - begin) / (next - begin)).clamp(0.0, 1.0)
        });
        (before, part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_span_need_not_be_a_multiple_of_the_step() {
        let mut moving = MovingMeans::over(0.25);
        let seen: Vec<_> = [0.0, 100.0, 0.0, 40.0]
            .into_iter()
            .enumerate()
            .map(|(k, mean)| moving.add(0.1 * k as f64, [Some(mean)].into_iter()).map(|seen| seen[0]))
            .collect();
        assert_eq!(seen[..3], [None; 3]);
        // From 0.05 to 0.3 s: half of a step with 100 N, one with 0 N, one with 40 N.
        assert!((seen[3].unwrap() - (5.0 + 4.0) / 0.25).abs() < 1e-9);
    }
}
