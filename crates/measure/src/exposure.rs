//! How long and how hard people are squeezed.
//!
//! The mean squeeze of each communication step is its impulse over its length. So what is computed here, but for the
//! peak, does not depend on when a crowd is looked at within a step: within a step the squeeze counts as its mean.

use std::collections::VecDeque;

/// \[s\] The lengths of moving means.
pub const SPANS: [f64; 3] = [0.1, 1.0, 10.0];

/// What a person was exposed to.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Exposed {
    /// \[s\] How long the person was there.
    pub time: f64,
    /// \[s\] Time in communication steps whose mean squeeze is above each level.
    pub above: Vec<f64>,
    /// \[N\] Largest mean squeeze over each of [`SPANS`]; `None` if the record is shorter, or if a step is longer.
    pub largest_mean: [Option<f64>; SPANS.len()],
    /// \[N s\] Integral of the squeeze over time.
    pub impulse: f64,
    /// \[N\] Largest squeeze within any step.
    pub peak: f64,
}

/// Sums up the squeeze of each person. It is given all communication points in the order of time.
#[derive(Debug, Clone)]
pub struct Exposure {
    /// \[N\]
    levels: Vec<f64>,
    people: Vec<Exposed>,
    /// \[s\] Communication points, back to one that is as long ago as the longest span.
    times: VecDeque<f64>,
    /// \[N s\] Impulse of each person up to each of these points.
    impulses: VecDeque<Vec<f64>>,
    /// \[s\]
    longest_step: f64,
}

/// \[s\] Times are sums of steps.
const ROUNDING: f64 = 1e-9;

impl Exposure {
    /// Begins, with levels of squeeze \[N\].
    pub fn new(people: usize, levels: &[f64]) -> Exposure {
        Exposure {
            levels: levels.to_vec(),
            people: vec![Exposed { above: vec![0.0; levels.len()], ..Exposed::default() }; people],
            times: VecDeque::new(),
            impulses: VecDeque::new(),
            longest_step: 0.0,
        }
    }

    /// Adds the next communication point \[s\], with mean and peak squeeze \[N\] of each person over the step that ends
    /// there; `None` of those who are not there. Of the first point only the time counts: its step is before the record.
    pub fn add(&mut self, time: f64, squeeze: impl Iterator<Item = Option<(f64, f64)>>) {
        let (Some(&before), Some(last)) = (self.times.back(), self.impulses.back()) else {
            self.times.push_back(time);
            self.impulses.push_back(vec![0.0; self.people.len()]);
            return;
        };
        let (step, mut impulses) = (time - before, last.clone());
        for ((person, impulse), squeeze) in self.people.iter_mut().zip(&mut impulses).zip(squeeze) {
            let Some((mean, peak)) = squeeze else { continue };
            person.time += step;
            person.peak = person.peak.max(peak);
            *impulse += mean * step;
            person.impulse = *impulse;
            for (above, level) in person.above.iter_mut().zip(&self.levels) {
                *above += if mean > *level { step } else { 0.0 };
            }
        }
        self.longest_step = self.longest_step.max(step);
        self.times.push_back(time);
        self.impulses.push_back(impulses);
        for (k, span) in SPANS.into_iter().enumerate() {
            self.move_on(k, span, before, time);
        }
        let needed = time - SPANS.into_iter().fold(0.0, f64::max) - ROUNDING;
        while self.times.get(1).is_some_and(|next| *next <= needed) {
            self.times.pop_front();
            self.impulses.pop_front();
        }
    }

    /// The means over all spans of this length \[s\] that end in the newest step. The impulse is linear within each step,
    /// so the largest one begins or ends at a communication point.
    fn move_on(&mut self, k: usize, span: f64, before: f64, time: f64) {
        let first = self.times[0];
        let ends_here = (time - span >= first - ROUNDING).then_some(time);
        let from = self.times.partition_point(|begin| begin + span <= before);
        let begins = self.times.range(from..).map(|begin| begin + span);
        let ends: Vec<f64> = begins.take_while(|end| *end < time).chain(ends_here).collect();
        for end in ends {
            let (low, high) = (self.place(end - span), self.place(end));
            for (agent, person) in self.people.iter_mut().enumerate() {
                let at = |(place, part): (usize, f64)| {
                    let a = self.impulses[place][agent];
                    if part == 0.0 { a } else { a + (self.impulses[place + 1][agent] - a) * part }
                };
                let mean = (at(high) - at(low)) / span;
                person.largest_mean[k] = Some(person.largest_mean[k].map_or(mean, |known| known.max(mean)));
            }
        }
    }

    /// The communication point before a time \[s\], and which part of the step after it is over then.
    fn place(&self, time: f64) -> (usize, f64) {
        let after = self.times.partition_point(|point| *point <= time);
        let before = after.saturating_sub(1);
        match self.times.get(before + 1) {
            Some(next) => {
                let begin = self.times[before];
                (before, ((time - begin) / (next - begin)).clamp(0.0, 1.0))
            }
            None => (before, 0.0),
        }
    }

    /// Returns the length of the longest step \[s\]; 0 before the second point.
    pub fn longest_step(&self) -> f64 {
        self.longest_step
    }

    /// Returns what each person was exposed to.
    pub fn finish(self) -> Vec<Exposed> {
        let resolved = |span: f64| self.longest_step <= span + ROUNDING;
        let mut people = self.people;
        for person in &mut people {
            for (mean, span) in person.largest_mean.iter_mut().zip(SPANS) {
                *mean = mean.filter(|_| resolved(span));
            }
        }
        people
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of one person whose squeeze has this integral \[N s\] from 0 to a time, in steps of this length \[s\].
    fn exposed(impulse: impl Fn(f64) -> f64, step: f64, until: f64, levels: &[f64]) -> Exposed {
        let mut exposure = Exposure::new(1, levels);
        for k in 0..=(until / step).round() as u64 {
            let (from, time) = ((k as f64 - 1.0) * step, k as f64 * step);
            let mean = (impulse(time) - impulse(from)) / step;
            exposure.add(time, [Some((mean, mean))].into_iter());
        }
        exposure.finish().remove(0)
    }

    #[track_caller]
    fn near(a: f64, b: f64) {
        assert!((a - b).abs() <= 1e-9 * b.abs().max(1.0), "{a} is not {b}");
    }

    /// 800 N from 2 to 2.5 s.
    #[test]
    fn a_rectangular_pulse() {
        let pulse = |t: f64| 800.0 * (t.clamp(2.0, 2.5) - 2.0);
        let one = exposed(pulse, 0.05, 12.0, &[500.0, 799.0, 801.0]);
        near(one.above[0], 0.5);
        near(one.above[1], 0.5);
        assert_eq!(one.above[2], 0.0);
        let [short, second, long] = one.largest_mean.map(Option::unwrap);
        near(short, 800.0);
        near(second, 400.0);
        near(long, 40.0);
        near(one.impulse, 400.0);
        near(one.time, 12.0);
        near(one.peak, 800.0);
    }

    /// s = 100 t N, until it ends.
    #[test]
    fn a_ramp() {
        let one = exposed(|t| 50.0 * t.max(0.0).powi(2), 0.01, 11.0, &[600.0]);
        // 100 t is above 600 N from 6 s on.
        near(one.above[0], 5.0);
        let [short, second, long] = one.largest_mean.map(Option::unwrap);
        // Of a ramp, the mean is the value in the middle.
        near(short, 100.0 * 10.95);
        near(second, 100.0 * 10.5);
        near(long, 100.0 * 6.0);
        near(one.impulse, 50.0 * 121.0);
    }

    #[test]
    fn spans_need_not_be_multiples_of_the_step() {
        // Two steps of 0.07 s with 700 N: 0.1 s fit into them, 1 s does not.
        let pulse = |t: f64| 700.0 * (t.clamp(0.7, 0.84) - 0.7);
        let one = exposed(pulse, 0.07, 2.1, &[]);
        near(one.largest_mean[0].unwrap(), 700.0);
        near(one.largest_mean[1].unwrap(), 98.0);
        assert_eq!(one.largest_mean[2], None, "the record is shorter");
        // A step is longer than the span: its mean says nothing of 0.1 s.
        assert_eq!(exposed(pulse, 0.21, 2.1, &[]).largest_mean[0], None);
    }

    /// The definition, computed otherwise: the largest of all means over a fine grid of beginnings.
    #[test]
    fn the_largest_mean_is_that_of_all_beginnings() {
        let mut seed = 1_u64;
        let mut squeeze = || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 40) as f64 / 1e4
        };
        let means: Vec<f64> = (0..60).map(|_| squeeze()).collect();
        // Steps of different lengths [ms].
        let lengths: Vec<usize> = (0..60).map(|k| [30, 70, 50][k % 3]).collect();
        let mut exposure = Exposure::new(1, &[]);
        let (mut fine, mut time) = (Vec::new(), 0.0);
        exposure.add(0.0, [Some((1e9, 1e9))].into_iter());
        for (mean, length) in means.iter().zip(&lengths) {
            time += *length as f64 * 1e-3;
            exposure.add(time, [Some((*mean, *mean))].into_iter());
            fine.extend(std::iter::repeat_n(*mean, *length));
        }
        let one = exposure.finish().remove(0);
        for (k, span) in [100, 1000].into_iter().enumerate() {
            let largest = fine.windows(span).map(|part| part.iter().sum::<f64>() / span as f64);
            near(one.largest_mean[k].unwrap(), largest.fold(0.0, f64::max));
        }
        near(one.impulse, fine.iter().sum::<f64>() * 1e-3);
    }

    #[test]
    fn who_leaves_is_exposed_no_more() {
        let mut exposure = Exposure::new(2, &[10.0]);
        for k in 0..=20 {
            let there = Some((100.0, 120.0));
            exposure.add(f64::from(k) * 0.1, [there, there.filter(|_| k <= 5)].into_iter());
        }
        let [stays, leaves] = <[Exposed; 2]>::try_from(exposure.finish()).unwrap();
        near(stays.impulse, 200.0);
        near(leaves.impulse, 50.0);
        near(leaves.time, 0.5);
        near(leaves.above[0], 0.5);
        near(leaves.largest_mean[1].unwrap(), 50.0);
    }
}
