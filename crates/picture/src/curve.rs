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
        let by = |best: fn(f64, f64) -> bool| {
            (0..chunk.len()).reduce(|a, b| if best(chunk[b].1, chunk[a].1) { b } else { a }).unwrap_or(0)
        };
        let wanted = BTreeSet::from([0, by(|a, b| a < b), by(|a, b| a > b), chunk.len() - 1]);
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

/// Moves sorted places until they are at least `step` apart, as little as possible, and keeps them within the limits if
/// there is room.
pub(crate) fn apart(mut y: Vec<f64>, step: f64, low: f64, high: f64) -> Vec<f64> {
    let n = y.len();
    if n == 0 {
        return y;
    }
    let step = if n > 1 { step.min((high - low).max(0.0) / (n - 1) as f64) } else { step };
    // Merge neighbours that are too near into a block about their mean, until none are.
    let mut blocks: Vec<(f64, usize)> = Vec::new();
    for v in y.drain(..) {
        let mut block = (v, 1);
        while let Some(&(middle, count)) = blocks.last() {
            let reach = 0.5 * step * (count + block.1) as f64;
            if block.0 - middle >= reach {
                break;
            }
            let all = (count + block.1) as f64;
            block = ((middle * count as f64 + block.0 * block.1 as f64) / all, count + block.1);
            blocks.pop();
        }
        let half = 0.5 * step * (block.1 - 1) as f64;
        block.0 = block.0.min(high - half).max(low + half);
        blocks.push(block);
    }
    let mut placed: Vec<f64> = blocks
        .iter()
        .flat_map(|(middle, count)| {
            (0..*count).map(move |k| middle + step * (k as f64 - 0.5 * (*count as f64 - 1.0)))
        })
        .collect();
    // A block at a limit may meet its neighbour.
    for k in (0..n.saturating_sub(1)).rev() {
        placed[k] = placed[k].min(placed[k + 1] - step);
    }
    placed[0] = placed[0].max(low);
    for k in 1..n {
        placed[k] = placed[k].max(placed[k - 1] + step);
    }
    placed
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
    let Some(first) = curves.first() else { return (Vec::new(), Vec::new()) };
    let same_x = |curve: &[(f64, f64)]| {
        curve.len() == first.len() && curve.iter().zip(*first).all(|(a, b)| a.0.to_bits() == b.0.to_bits())
    };
    let comparable: Vec<bool> = curves.iter().map(|curve| same_x(curve)).collect();
    let known = |p: (f64, f64)| p.0.is_finite() && p.1.is_finite();
    let equal = |a: usize, b: usize, at: usize| {
        // Others may be shorter.
        a == b
            || comparable[a] && comparable[b] && {
                let (p, q) = (curves[a][at], curves[b][at]);
                known(p) && known(q) && (p.1 - q.1).abs() <= near
            }
    };
    // The first curve that is equal from one point to the next; `None` after the end of a curve.
    let leader = |k: usize, from: usize| {
        let alike = |other: &usize| equal(k, *other, from) && equal(k, *other, from + 1);
        if from + 1 < curves[k].len() { (0..=k).find(alike) } else { None }
    };
    let mut pieces = vec![Vec::new(); curves.len()];
    // For each curve: the curves equal to it, and since when.
    let mut open: Vec<(Vec<usize>, usize)> = vec![Default::default(); curves.len()];
    let longest = curves.iter().map(|curve| curve.len()).max().unwrap_or(0);
    for from in 0..longest {
        let leaders: Vec<Option<usize>> = (0..curves.len()).map(|k| leader(k, from)).collect();
        for k in 0..curves.len() {
            let alike = |other: &usize| leaders[k].is_some() && leaders[*other] == leaders[k];
            if (0..curves.len()).filter(alike).eq(open[k].0.iter().copied()) {
                continue;
            }
            let mates = (0..curves.len()).filter(alike).collect();
            let (last, begun) = std::mem::replace(&mut open[k], (mates, from));
            if let Some(first) = last.first() {
                let turn = (last.iter().position(|mate| *mate == k).unwrap_or(0), last.len());
                pieces[k].push(Piece { points: curves[*first][begun..=from].to_vec(), turn });
            }
        }
    }
    let both_unknown = |a: usize, b: usize, at: usize| !known(curves[a][at]) && !known(curves[b][at]);
    let all_along = |a: usize, b: usize| {
        a == b
            || comparable[a]
                && comparable[b]
                && (0..first.len()).all(|at| equal(a, b, at) || both_unknown(a, b, at))
    };
    let mut together: Vec<Vec<usize>> = Vec::new();
    for k in 0..curves.len() {
        match together.iter_mut().find(|group| all_along(group[0], k)) {
            Some(group) => group.push(k),
            None => together.push(vec![k]),
        }
    }
    together.retain(|group| group.len() > 1);
    (pieces, together)
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
