//! How long and how hard people are squeezed.
//!
//! The mean squeeze of each communication step is its impulse over its length. So what is computed here, but for the
//! peak, does not depend on when a crowd is looked at within a step: within a step the squeeze counts as its mean.

use crate::Frame;
use crate::columns::Effect;
use crate::measure::impulses::MovingMeans;
use crate::measure::{By, ROUNDING, squeeze};

/// \[s\] The lengths of moving means.
pub const SPANS: [f64; 3] = [0.1, 1.0, 10.0];

/// Exposure of a person to squeeze.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Exposed {
    /// \[s\] How long the person was there.
    pub time: f64,
    /// When the person was above each level: in communication steps with a greater mean squeeze, or, with `over`, at
    /// the end of spans with a greater one; `None` if the record is shorter than a span, or a step is longer.
    pub above: Vec<Option<Above>>,
    /// \[N\] Largest mean squeeze over each of [`SPANS`]; `None` if the record is shorter, or if a step is longer.
    pub largest_mean: [Option<f64>; SPANS.len()],
    /// \[s\] When the spans of these end, the first if there are several; 0 where there is none.
    pub largest_mean_at: [f64; SPANS.len()],
    /// \[N s\] Integral of the squeeze over time.
    pub impulse: f64,
    /// \[N\] Largest squeeze within any step.
    pub peak: f64,
    /// \[s\] When the step ends in which it was so at first; 0 without a squeeze.
    pub peak_at: f64,
    /// \[N\] Largest mean squeeze over a communication step.
    pub largest_step: f64,
}

/// How long a person was above a level, and from when.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Above {
    /// \[s\] In all.
    pub time: f64,
    /// \[s\] The longest time without a break.
    pub longest: f64,
    /// \[s\] When it was so at first; `None`: never.
    pub first: Option<f64>,
    /// \[s\] Without a break until now.
    now: f64,
}

impl Above {
    /// Adds the time from `begin` to `end` \[s\], in which a mean goes in a line from `a` to `b`.
    fn add(&mut self, [begin, end]: [f64; 2], (a, b): (f64, f64), level: f64) {
        let above = (end - begin) * part_above((a, b), level);
        if a <= level {
            self.now = 0.0;
        }
        if above > 0.0 {
            self.time += above;
            self.now += above;
            self.longest = self.longest.max(self.now);
            self.first.get_or_insert(if a > level { begin } else { end - above });
        }
        if b <= level {
            self.now = 0.0;
        }
    }
}

/// Sums up the squeeze of each person. It is given all communication points in the order of time.
#[derive(Debug, Clone)]
pub struct SqueezeOverTime {
    /// \[N\]
    levels: Vec<f64>,
    /// \[s\] Of the means that are compared with them; `None`: each communication step.
    over: Option<f64>,
    /// Whether a span of this length was over.
    spanned: bool,
    /// Whether all frames say how people are squeezed.
    complete: bool,
    /// Places of those who are seen in frames.
    agents: Vec<usize>,
    people: Vec<Exposed>,
    impulses: MovingMeans,
    /// \[s\]
    longest_step: f64,
}

impl SqueezeOverTime {
    /// Begins, with levels of squeeze \[N\]; compared with them are means over spans of the length `over` \[s\], or, without,
    /// those over communication steps.
    pub fn new(people: usize, levels: &[f64], over: Option<f64>) -> SqueezeOverTime {
        SqueezeOverTime::of((0..people).collect(), levels, over)
    }

    /// Begins in the same way, for the agents at these places of a frame.
    pub fn of(agents: Vec<usize>, levels: &[f64], over: Option<f64>) -> SqueezeOverTime {
        let above = vec![Some(Above::default()); levels.len()];
        SqueezeOverTime {
            levels: levels.to_vec(),
            over,
            spanned: false,
            complete: true,
            people: vec![Exposed { above, ..Exposed::default() }; agents.len()],
            agents,
            impulses: MovingMeans::over(SPANS.into_iter().chain(over).fold(0.0, f64::max)),
            longest_step: 0.0,
        }
    }

    /// Adds the next frame; with `by`, the squeeze by people or by walls alone.
    pub fn see(&mut self, frame: &Frame, by: Option<By>) {
        let effects = &frame.effects;
        self.complete &=
            effects.knows(Effect::MeanNormalForce) && (by.is_none() || effects.knows(Effect::MeanWallForce));
        if self.complete {
            let squeezes: Vec<_> = self.agents.iter().map(|agent| squeeze(frame, *agent, by)).collect();
            self.add(frame.time, squeezes.into_iter());
        }
    }

    /// Adds the next communication point \[s\], with mean and peak squeeze \[N\] of each person over the step that ends
    /// there; `None` of those who are not there. Of the first point only the time counts: its step is before the record.
    pub fn add(&mut self, time: f64, squeeze: impl Iterator<Item = Option<(f64, f64)>>) {
        let squeeze: Vec<Option<(f64, f64)>> = squeeze.collect();
        let means = squeeze.iter().map(|squeeze| squeeze.map(|(mean, _)| mean));
        let Some(before) = self.impulses.step(time, means) else { return };
        let step = time - before;
        for ((person, squeeze), impulse) in self.people.iter_mut().zip(&squeeze).zip(self.impulses.now()) {
            let Some((mean, peak)) = *squeeze else {
                person.above.iter_mut().flatten().for_each(|above| above.now = 0.0);
                continue;
            };
            person.time += step;
            if peak > person.peak {
                (person.peak, person.peak_at) = (peak, time);
            }
            person.largest_step = person.largest_step.max(mean);
            person.impulse = *impulse;
            if self.over.is_none() {
                for (above, level) in person.above.iter_mut().flatten().zip(&self.levels) {
                    above.add([before, time], (mean, mean), *level);
                }
            }
        }
        self.longest_step = self.longest_step.max(step);
        // Of all spans that end in the newest step: the largest mean begins or ends at a communication point.
        for (k, span) in SPANS.into_iter().enumerate() {
            for end in self.impulses.ends(span, before, time) {
                for (person, mean) in self.people.iter_mut().zip(self.impulses.means(span, end)) {
                    if person.largest_mean[k].is_none_or(|known| mean > known) {
                        (person.largest_mean[k], person.largest_mean_at[k]) = (Some(mean), end);
                    }
                }
            }
        }
        if let Some(span) = self.over {
            self.add_above(span, before, time, &squeeze);
        }
    }

    /// The part of the newest step in which the mean over the span \[s\] that ends then is above each level.
    fn add_above(&mut self, span: f64, before: f64, time: f64, there: &[Option<(f64, f64)>]) {
        let begin = self.impulses.covers(span, before).then_some(before);
        let ends: Vec<f64> = begin.into_iter().chain(self.impulses.ends(span, before, time)).collect();
        self.spanned |= !ends.is_empty();
        for pair in ends.windows(2) {
            let [begin, end] = [pair[0], pair[1]];
            let means = self.impulses.means(span, begin).zip(self.impulses.means(span, end));
            for ((person, means), there) in self.people.iter_mut().zip(means).zip(there) {
                if there.is_none() {
                    continue;
                }
                for (above, level) in person.above.iter_mut().flatten().zip(&self.levels) {
                    above.add([begin, end], means, *level);
                }
            }
        }
    }

    /// Returns the length of the longest step \[s\]; 0 before the second point.
    pub fn longest_step(&self) -> f64 {
        self.longest_step
    }

    /// Returns what each person was exposed to.
    ///
    /// # Errors
    /// Why it is not known.
    pub fn finish(&self) -> Result<Vec<Exposed>, &'static str> {
        if !self.complete {
            return Err("the results do not contain the mean squeeze over communication steps");
        }
        if self.longest_step <= 0.0 {
            return Err("there is only one frame, so no communication step");
        }
        Ok(self.so_far())
    }

    /// Returns what each person was exposed to up to now.
    pub fn so_far(&self) -> Vec<Exposed> {
        let resolved = |span: f64| self.longest_step <= span + ROUNDING;
        let known = self.over.is_none_or(|over| self.spanned && resolved(over));
        let mut people = self.people.clone();
        for person in &mut people {
            for above in person.above.iter_mut().filter(|_| !known) {
                *above = None;
            }
            for (mean, span) in person.largest_mean.iter_mut().zip(SPANS) {
                *mean = mean.filter(|_| resolved(span));
            }
        }
        people
    }
}

/// Returns the part of a line from `a` to `b` that is above a level.
fn part_above((a, b): (f64, f64), level: f64) -> f64 {
    match (a > level, b > level) {
        (true, true) => 1.0,
        (false, false) => 0.0,
        _ => (a.max(b) - level) / (a - b).abs(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lemons_core::plane::Motion;

    /// Returns the exposure of a person whose squeeze has this integral \[N s\] from 0 to a time, in steps of this length \[s\].
    fn exposed(
        impulse: impl Fn(f64) -> f64,
        step: f64,
        until: f64,
        mut exposure: SqueezeOverTime,
    ) -> Exposed {
        for k in 0..=(until / step).round() as u64 {
            let (from, time) = ((k as f64 - 1.0) * step, k as f64 * step);
            let mean = (impulse(time) - impulse(from)) / step;
            exposure.add(time, [Some((mean, mean))].into_iter());
        }
        exposure.so_far().remove(0)
    }

    fn times(above: &[Option<Above>]) -> Vec<Option<f64>> {
        above.iter().map(|above| above.map(|above| above.time)).collect()
    }

    #[track_caller]
    fn near(a: f64, b: f64) {
        assert!((a - b).abs() <= 1e-9 * b.abs().max(1.0), "{a} is not {b}");
    }

    /// 800 N from 2 to 2.5 s.
    fn pulse(t: f64) -> f64 {
        800.0 * (t.clamp(2.0, 2.5) - 2.0)
    }

    #[test]
    fn a_rectangular_pulse() {
        let one = exposed(pulse, 0.05, 12.0, SqueezeOverTime::new(1, &[500.0, 799.0, 801.0], None));
        let seen = times(&one.above).into_iter().chain(one.largest_mean).map(|known| known.unwrap());
        let seen = seen.chain([one.impulse, one.time, one.peak]);
        let expected = [0.5, 0.5, 0.0, 800.0, 400.0, 40.0, 400.0, 12.0, 800.0];
        seen.zip(expected).for_each(|(seen, expected)| near(seen, expected));
    }

    /// The mean over a second of 800 N from 2 to 2.5 s rises for half a second, stays at 400 N, and falls.
    #[test]
    fn time_above_a_level_of_means_over_a_second() {
        let above = |levels: &[f64], step: f64, until: f64, span: f64| {
            times(&exposed(pulse, step, until, SqueezeOverTime::new(1, levels, Some(span))).above)
        };
        for step in [0.05, 0.01, 0.25] {
            let times = above(&[0.0, 100.0, 300.0, 401.0], step, 12.0, 1.0);
            let expected = [1.5, 1.25, 0.75, 0.0];
            times.iter().zip(expected).for_each(|(seen, expected)| near(seen.unwrap(), expected));
        }
        assert_eq!(above(&[100.0], 0.05, 0.9, 1.0), [None], "the record is shorter");
        assert_eq!(above(&[100.0], 0.05, 12.0, 0.04), [None], "a step is longer");
        // A span of a step: the means of the steps change linearly, so half of a step is added at each end, and lost.
        near(above(&[400.0], 0.05, 12.0, 0.05)[0].unwrap(), 0.5);
    }

    /// 800 N from 2 to 2.5 s, and from 4 to 5 s. Means over a second are above 300 N from 2.375 to 3.125 s and from 4.375
    /// to 5.625 s; steps are above it as long as the pulses.
    #[test]
    fn the_longest_time_above_a_level_has_no_break() {
        let two = |t: f64| pulse(t) + 800.0 * (t.clamp(4.0, 5.0) - 4.0);
        for (over, step, expected) in [
            (Some(1.0), 0.05, [2.0, 1.25, 2.375]),
            (Some(1.0), 0.25, [2.0, 1.25, 2.375]),
            (None, 0.25, [1.5, 1.0, 2.0]),
        ] {
            let seen = exposed(two, step, 12.0, SqueezeOverTime::new(1, &[300.0, 900.0], over)).above;
            let Above { time, longest, first, .. } = seen[0].unwrap();
            [time, longest, first.unwrap()]
                .into_iter()
                .zip(expected)
                .for_each(|(seen, expected)| near(seen, expected));
            assert_eq!(seen[1], Some(Above::default()), "never");
        }
        // Somebody who is not there for a step has a break.
        let mut exposure = SqueezeOverTime::new(1, &[10.0], None);
        for k in 0..=10 {
            exposure.add(f64::from(k) * 0.1, [(k != 4).then_some((100.0, 100.0))].into_iter());
        }
        let seen = exposure.so_far()[0].above[0].unwrap();
        [seen.time, seen.longest]
            .into_iter()
            .zip([0.9, 0.6])
            .for_each(|(seen, expected)| near(seen, expected));
    }

    #[test]
    fn spans_need_not_be_multiples_of_the_step() {
        // Two steps of 0.07 s with 700 N: 0.1 s fit into them, 1 s does not.
        let pulse = |t: f64| 700.0 * (t.clamp(0.7, 0.84) - 0.7);
        let one = exposed(pulse, 0.07, 2.1, SqueezeOverTime::new(1, &[], None));
        near(one.largest_mean[0].unwrap(), 700.0);
        near(one.largest_mean[1].unwrap(), 98.0);
        assert_eq!(one.largest_mean[2], None, "the record is shorter");
        // A step is longer than the span: its mean says nothing of 0.1 s.
        assert_eq!(exposed(pulse, 0.21, 2.1, SqueezeOverTime::new(1, &[], None)).largest_mean[0], None);
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
        let mut exposure = SqueezeOverTime::new(1, &[], None);
        let (mut fine, mut time) = (Vec::new(), 0.0);
        exposure.add(0.0, [Some((1e9, 1e9))].into_iter());
        for (mean, length) in means.iter().zip(&lengths) {
            time += *length as f64 * 1e-3;
            exposure.add(time, [Some((*mean, *mean))].into_iter());
            fine.extend(std::iter::repeat_n(*mean, *length));
        }
        let one = exposure.so_far().remove(0);
        for (k, span) in [100, 1000].into_iter().enumerate() {
            let largest = fine.windows(span).map(|part| part.iter().sum::<f64>() / span as f64);
            near(one.largest_mean[k].unwrap(), largest.fold(0.0, f64::max));
        }
        near(one.impulse, fine.iter().sum::<f64>() * 1e-3);
    }

    #[test]
    fn who_leaves_is_exposed_no_more() {
        let mut exposure = SqueezeOverTime::new(2, &[10.0], None);
        for k in 0..=20 {
            let there = Some((100.0, 120.0));
            exposure.add(f64::from(k) * 0.1, [there, there.filter(|_| k <= 5)].into_iter());
        }
        let [stays, leaves] = <[Exposed; 2]>::try_from(exposure.so_far()).unwrap();
        near(stays.impulse, 200.0);
        near(leaves.impulse, 50.0);
        near(leaves.time, 0.5);
        near(times(&leaves.above)[0].unwrap(), 0.5);
        near(leaves.largest_mean[1].unwrap(), 50.0);
    }

    /// Two people for a second: by 300 N, of which 100 N are by walls, in frames that say all, one of these, or nothing.
    #[test]
    fn what_frames_do_not_say_is_not_known() {
        let seen = |step: &[(Effect, f64)], frames: u32, by: Option<By>| {
            let mut exposure = SqueezeOverTime::new(2, &[], None);
            for k in 0..frames {
                let (time, agents) = (f64::from(k), vec![Motion::default(); 2]);
                let mut frame = Frame { time, agents, ..Frame::default() };
                frame.effects.record(Effect::NormalForce, [0.0; 2].into_iter());
                step.iter().for_each(|(effect, of)| frame.effects.record(*effect, [*of; 2].into_iter()));
                exposure.see(&frame, by);
            }
            exposure.finish().map(|each| [each[1].impulse, each[1].largest_step])
        };
        let parts = [(Effect::MeanNormalForce, 300.0), (Effect::PeakNormalForce, 0.0)];
        let whole = [&parts[..], &[(Effect::MeanWallForce, 100.0)]].concat();
        for (by, expected) in [(None, 300.0), (Some(By::People), 200.0), (Some(By::Walls), 100.0)] {
            assert_eq!(seen(&whole, 2, by), Ok([expected; 2]));
        }
        assert_eq!(seen(&parts, 2, None), Ok([300.0; 2]));
        assert!(seen(&parts, 2, Some(By::Walls)).unwrap_err().contains("do not contain the mean squeeze"));
        assert!(seen(&[], 2, None).unwrap_err().contains("do not contain the mean squeeze"));
        assert!(seen(&parts, 1, None).unwrap_err().contains("only one frame"));
    }
}
