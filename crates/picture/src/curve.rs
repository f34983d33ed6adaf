//! Axes and curves: ranges and ticks, which points are drawn, and where names are placed.

use crate::text::{round_above, short, text_of};
use std::collections::BTreeSet;

/// The range of values of an axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Range {
    pub low: f64,
    pub high: f64,
}

impl Range {
    /// The range of all values. If `reaches_zero`, it is extended to zero if that is near.
    pub fn around(values: impl Iterator<Item = f64>, reaches_zero: bool) -> Range {
        let (mut low, mut high) =
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        if reaches_zero && low > 0.0 && low < 0.6 * high {
            low = 0.0;
        }
        if high / 2.0 - low / 2.0 <= (1e-12 * high.abs().max(low.abs())).max(1e-250) {
            let grow = if high.abs() < 1e-250 { 1.0 } else { 0.1 * high.abs() };
            if low == 0.0 && reaches_zero {
                high = grow;
            } else {
                (low, high) = (low - grow, high + grow);
            }
        }
        Range { low: low.max(-1e307), high: high.min(1e307) }
    }

    /// Adds space beyond the curves, but not below zero.
    pub fn airy(self) -> Range {
        let air = 0.05 * (self.high - self.low);
        let low = if self.low == 0.0 { 0.0 } else { self.low - air };
        Range { low, high: self.high + air }
    }

    pub fn part(self, v: f64) -> f64 {
        ((v - self.low) / (self.high - self.low)).clamp(-0.1, 1.1)
    }

    /// Returns about `about` round numbers with their labels; integers only if `whole`.
    pub fn ticks(self, about: f64, whole: bool) -> Vec<(f64, String)> {
        let mut step = round_above((self.high - self.low) / about);
        if whole {
            step = step.max(1.0);
        }
        let first = (self.low / step).ceil();
        let decimals = (-step.log10().floor()).clamp(0.0, 12.0) as usize;
        let plain = (1e-4..1e6).contains(&step) && self.high.abs().max(self.low.abs()) < 1e6;
        (0..100)
            .map(|k| first + f64::from(k))
            .map(|k| k * step)
            .take_while(|v| *v <= self.high * (1.0 + 1e-12 * self.high.signum()))
            .map(|v| (v, if plain { text_of(v, decimals) } else { short(v) }))
            .collect()
    }
}

/// Returns, for each column of pixels, the first, lowest, highest and last point.
pub(crate) fn extremes(points: &[(f64, f64)], column: f64) -> Vec<(f64, f64)> {
    let mut kept = Vec::new();
    let place = |p: &(f64, f64)| (p.0 / column).floor();
    for chunk in points.chunk_by(|a, b| place(a) == place(b)) {
        if chunk.len() <= 4 {
            kept.extend_from_slice(chunk);
            continue;
        }
        let [low, high] = [1.0, -1.0].map(|sign| {
            let y = |k: &usize| sign * chunk[*k].1;
            (0..chunk.len()).min_by(|a, b| y(a).total_cmp(&y(b))).unwrap_or(0)
        });
        let wanted = BTreeSet::from([0, low, high, chunk.len() - 1]);
        kept.extend(wanted.into_iter().map(|k| chunk[k]));
    }
    kept
}

/// Removes points that change the line by less than the tolerance (Ramer, Douglas, Peucker).
pub(crate) fn thinned(points: &[(f64, f64)], tolerance: f64) -> Vec<(f64, f64)> {
    let mut keep = vec![false; points.len()];
    let [.., _] = points else { return Vec::new() };
    let last = points.len() - 1;
    (keep[0], keep[last]) = (true, true);
    let mut open = vec![(0, last)];
    while let Some((a, b)) = open.pop() {
        let (p, q) = (points[a], points[b]);
        let (dx, dy) = (q.0 - p.0, q.1 - p.1);
        let length = dx.hypot(dy);
        let off = |m: usize| {
            let (x, y) = (points[m].0 - p.0, points[m].1 - p.1);
            if length > 0.0 { (x * dy - y * dx).abs() / length } else { x.hypot(y) }
        };
        let far = (a + 1..b).map(|m| (off(m), m)).reduce(|s, t| if t.0 > s.0 { t } else { s });
        if let Some((distance, m)) = far
            && distance > tolerance
        {
            keep[m] = true;
            open.extend([(a, m), (m, b)]);
        }
    }
    points.iter().zip(keep).filter(|(_, keep)| *keep).map(|(p, _)| *p).collect()
}

/// Moves ascending places until they are at least `step` apart, as little as possible, and keeps them within the limits
/// if there is room.
pub(crate) fn apart(places: &[f64], step: f64, low: f64, high: f64) -> Vec<f64> {
    let gaps = places.len().saturating_sub(1) as f64;
    let step = step.min((high - low).max(0.0) / gaps);
    // Without the steps they need only ascend: neighbours that do not are replaced by their mean (isotonic regression).
    let mut blocks: Vec<(f64, usize)> = Vec::new();
    for (k, place) in places.iter().enumerate() {
        let mut block = (place - step * k as f64, 1);
        while let Some((mean, count)) = blocks.pop_if(|last| last.0 > block.0) {
            let all = count + block.1;
            block = ((mean * count as f64 + block.0 * block.1 as f64) / all as f64, all);
        }
        blocks.push(block);
    }
    let means = blocks.into_iter().flat_map(|(mean, count)| std::iter::repeat_n(mean, count));
    let within = means.map(|mean| mean.min(high - step * gaps).max(low));
    within.enumerate().map(|(k, place)| place + step * k as f64).collect()
}

/// A piece of a curve.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Piece {
    pub points: Vec<(f64, f64)>,
    /// Index among the curves that are equal here, and their number.
    pub turn: (usize, usize),
}

/// Divides curves into pieces that are equal to others (within `near`) or not, and finds curves that are equal
/// everywhere. Only curves with the same x as the first can be equal. Equal pieces use the points of one curve, so that
/// the dashes of one exactly fill the gaps of the other.
pub(crate) fn shared(curves: &[&[(f64, f64)]], near: f64) -> (Vec<Vec<Piece>>, Vec<Vec<usize>>) {
    let x = |curve: &[(f64, f64)]| curve.iter().map(|p| p.0.to_bits()).collect::<Vec<u64>>();
    let comparable: Vec<bool> = curves.iter().map(|curve| x(curve) == x(curves[0])).collect();
    let close = |p: f64, q: f64| (p - q).abs() <= near || !p.is_finite() && !q.is_finite();
    let equal = |a: usize, b: usize, at: usize| {
        // Those that are compared have as many points as the first.
        a == b || comparable[a] && comparable[b] && close(curves[a][at].1, curves[b][at].1)
    };
    // The first curve that is equal from one point to the next; `None` after the end of a curve.
    let leader = |k: usize, from: usize| {
        let alike = |other: &usize| equal(k, *other, from) && equal(k, *other, from + 1);
        if from + 1 < curves[k].len() { (0..=k).find(alike) } else { None }
    };
    // For each curve: the curves equal to it, and since when.
    let mut runs: Vec<Vec<(usize, Vec<usize>)>> = vec![Vec::new(); curves.len()];
    for from in 0..curves.iter().map(|curve| curve.len()).max().unwrap_or(0) {
        let leaders: Vec<Option<usize>> = (0..curves.len()).map(|k| leader(k, from)).collect();
        for (own, runs) in leaders.iter().zip(&mut runs) {
            let mates = (0..curves.len()).filter(|other| own.is_some() && leaders[*other] == *own);
            if runs.last().is_none_or(|(_, last)| !mates.clone().eq(last.iter().copied())) {
                runs.push((from, mates.collect()));
            }
        }
    }
    let pieces = runs.iter().enumerate().map(|(k, runs)| {
        let piece = |pair: &[(usize, Vec<usize>)]| {
            let (begin, mates, end) = (pair[0].0, &pair[0].1, pair[1].0);
            let points = curves[*mates.first()?][begin..=end].to_vec();
            Some(Piece { points, turn: (mates.iter().position(|mate| *mate == k)?, mates.len()) })
        };
        runs.windows(2).filter_map(piece).collect()
    });
    let together = runs.iter().enumerate().filter_map(|(k, runs)| {
        let (_, parts) = runs.split_last().filter(|(_, parts)| !parts.is_empty())?;
        let everywhere = |other: &usize| parts.iter().all(|(_, mates)| mates.contains(other));
        let all: Vec<usize> = (0..curves.len()).filter(everywhere).collect();
        (all.len() > 1 && all[0] == k).then_some(all)
    });
    (pieces.collect(), together.collect())
}

/// Lists names; successive whole numbers become a range.
pub(crate) fn listed(names: &[&str]) -> String {
    let follows = |a: &str, b: &str| matches!((a.parse::<u64>(), b.parse::<u64>()), (Ok(a), Ok(b)) if a.checked_add(1) == Some(b));
    let runs = names.chunk_by(|a, b| follows(a, b)).flat_map(|run| match run {
        [first, .., last] if run.len() > 2 => vec![format!("{first}–{last}")],
        few => few.iter().map(|name| (*name).to_owned()).collect(),
    });
    runs.collect::<Vec<_>>().join(", ")
}
