//! Straight pieces of lines, found by where they are, and their ends mended.

use super::DrawnLine;
use crate::error::{Result, require};
use lemons_core::plane::{Bounds, InPlane, Vec2, nearest_on_segment, segments_cross};
use std::collections::HashMap;

/// \[m\] Ends that are nearer to something than this meet it: drawings are rounded.
pub(super) const SNAP: f64 = 1e-3;
/// \[m\] How far a mended end goes beyond what it meets, so that both have a common point after rounding.
const BEYOND: f64 = 1e-6;
/// Largest number of pieces that are looked at: some of it takes the square of this.
pub(super) const MOST_PIECES: usize = 20_000;

/// Largest number of pairs of pieces that are near each other.
const MOST_PAIRS: usize = 20_000_000;
/// Largest number of places where pieces cross: each makes more of what they cut the plane into.
const MOST_CROSSINGS: usize = 200_000;

/// A straight piece of a line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    pub a: Vec2,
    pub b: Vec2,
    /// Of which line.
    pub line: usize,
}

impl Piece {
    pub fn length(&self) -> f64 {
        (self.b - self.a).norm()
    }

    /// Returns its direction; none without a length.
    pub fn direction(&self) -> Option<Vec2> {
        (self.b - self.a).unit(0.0)
    }

    pub fn nearest(&self, p: Vec2) -> Vec2 {
        nearest_on_segment(self.a, self.b, p)
    }

    /// Returns where a ray meets it: how far along the ray \[m\]; `None` if it does not, or both are parallel.
    pub fn met_by(&self, from: Vec2, along: Vec2) -> Option<f64> {
        let side = self.b - self.a;
        let turn = along.perp(&side);
        if turn.abs() <= 1e-9 * side.norm() {
            return None;
        }
        let off = self.a - from;
        let (t, s) = (off.perp(&side) / turn, off.perp(&along) / turn);
        (0.0..=1.0).contains(&s).then_some(t)
    }
}

/// Returns the pieces of lines, each once.
///
/// # Errors
/// There are too many.
pub(super) fn pieces_of<'a>(lines: impl Iterator<Item = (usize, &'a DrawnLine)>) -> Result<Vec<Piece>> {
    let mut pieces = Vec::new();
    let mut known = std::collections::HashSet::new();
    let cell = |at: Vec2| ((at.x / 1e-6).round() as i64, (at.y / 1e-6).round() as i64);
    for (k, line) in lines {
        let ends = line.corners.iter().skip(1).chain(line.closed.then(|| &line.corners[0]));
        for (a, b) in line.corners.iter().zip(ends) {
            let (from, to) = (cell(*a), cell(*b));
            if from != to && known.insert(if from < to { [from, to] } else { [to, from] }) {
                pieces.push(Piece { a: *a, b: *b, line: k });
            }
        }
        require(pieces.len() <= MOST_PIECES, || {
            format!(
                "lines have more than {MOST_PIECES} straight pieces: too many to look for walls: choose layers"
            )
        })?;
    }
    Grid::of(&pieces).check(&pieces)?;
    Ok(pieces)
}

/// Pieces, found by where they are.
pub(super) struct Grid {
    size: f64,
    cells: HashMap<(i64, i64), Vec<u32>>,
}

impl Grid {
    pub fn of(pieces: &[Piece]) -> Grid {
        let bounds = Bounds::of(pieces.iter().flat_map(|piece| [piece.a, piece.b])).unwrap_or(Bounds::UNIT);
        let size = (bounds.size().max() / 200.0).max(0.5);
        let mut cells: HashMap<(i64, i64), Vec<u32>> = HashMap::new();
        for (k, piece) in pieces.iter().enumerate() {
            let steps = (piece.length() / (0.5 * size)).ceil().max(1.0) as usize;
            for step in 0..=steps {
                let at = piece.a + (piece.b - piece.a) * (step as f64 / steps as f64);
                let cell = cells.entry(Grid::cell(at, size)).or_default();
                if cell.last() != Some(&(k as u32)) {
                    cell.push(k as u32);
                }
            }
        }
        Grid { size, cells }
    }

    /// Refuses pieces of which too many are beside each other, or cross.
    fn check(&self, pieces: &[Piece]) -> Result<()> {
        let pairs: usize = self.cells.values().map(|cell| cell.len() * cell.len()).sum();
        require(pairs <= MOST_PAIRS, || {
            "too many lines are near each other to look for walls: choose layers".to_owned()
        })?;
        let crosses = |one: u32, other: u32| {
            let (one, other) = (&pieces[one as usize], &pieces[other as usize]);
            segments_cross(one.a, one.b, other.a, other.b)
        };
        let count = |cell: &Vec<u32>| {
            let pairs = cell
                .iter()
                .enumerate()
                .flat_map(|(k, one)| cell[..k].iter().map(move |other| (*one, *other)));
            pairs.filter(|(one, other)| crosses(*one, *other)).count()
        };
        let crossings: usize = self.cells.values().map(count).sum();
        Ok(require(crossings <= MOST_CROSSINGS, || {
            format!(
                "lines cross each other at more than {MOST_CROSSINGS} places: too many to look for walls: choose layers"
            )
        })?)
    }

    fn cell(at: Vec2, size: f64) -> (i64, i64) {
        ((at.x / size).floor() as i64, (at.y / size).floor() as i64)
    }

    /// Returns the pieces that may be nearer to a place than this \[m\], some of them several times.
    pub fn around(&self, at: Vec2, reach: f64) -> impl Iterator<Item = usize> + '_ {
        let (x, y) = Grid::cell(at, self.size);
        let cells = (reach / self.size).ceil() as i64 + 1;
        let there = (x - cells..=x + cells).flat_map(move |x| (y - cells..=y + cells).map(move |y| (x, y)));
        there.filter_map(|cell| self.cells.get(&cell)).flatten().map(|k| *k as usize)
    }
}

/// An end of a piece that meets nothing.
#[derive(Debug, Clone, Copy)]
pub(super) struct Loose {
    pub piece: usize,
    pub at: Vec2,
    /// From the piece outwards.
    pub out: Vec2,
}

/// Ends that were mended.
pub(super) struct Mended {
    /// Those that were there, and short ones that join them.
    pub pieces: Vec<Piece>,
    /// \[m\] Of each gap that is larger than [`SNAP`].
    pub closed: Vec<f64>,
    /// Ends that are left.
    pub loose: Vec<Loose>,
}

/// Joins ends of pieces that are at most `close` \[m\] from each other, or before another piece.
pub(super) fn mended(mut pieces: Vec<Piece>, close: f64) -> Mended {
    let grid = Grid::of(&pieces);
    let mut loose = Vec::new();
    let mut joints: Vec<Piece> = Vec::new();
    for (k, piece) in pieces.iter().enumerate() {
        let Some(direction) = piece.direction() else { continue };
        for (at, out) in [(piece.a, -direction), (piece.b, direction)] {
            match met(&pieces, &grid, k, at) {
                Some((there, true)) if there == at => (),
                Some((there, _)) => joints.push(Piece { a: at, b: there + out * BEYOND, line: piece.line }),
                None => loose.push(Loose { piece: k, at, out }),
            }
        }
    }
    let mut closed = Vec::new();
    if close > SNAP {
        let mut used = vec![false; loose.len()];
        for (from, to, distance) in joins(&pieces, &grid, &loose, close) {
            let free = !used[from] && to.is_none_or(|(other, _)| !used[other]);
            if !free {
                continue;
            }
            used[from] = true;
            let Loose { at, out, piece } = loose[from];
            let mut join = |a: Vec2, b: Vec2| joints.push(Piece { a, b, line: pieces[piece].line });
            match to {
                Some((other, corner)) => {
                    used[other] = true;
                    join(at, corner);
                    join(corner, loose[other].at);
                }
                None => join(at, at + out * (distance + BEYOND)),
            }
            closed.push(distance);
        }
        let mut used = used.into_iter();
        loose.retain(|_| !used.next().unwrap_or(false));
    }
    // What goes a little too far meets something all the same.
    let far = |end: &Loose| {
        let length = pieces[end.piece].length();
        let meets = |k: usize| {
            let behind = pieces[k].met_by(end.at, -end.out);
            k != end.piece && behind.is_some_and(|t| t > 0.0 && t <= close.max(0.02).min(length))
        };
        grid.around(end.at, close).any(meets)
    };
    let far: Vec<bool> = loose.iter().map(far).collect();
    let mut far = far.into_iter();
    loose.retain(|_| !far.next().unwrap_or(false));
    pieces.extend(joints);
    Mended { pieces, closed, loose }
}

/// Where an end meets another piece, and whether that is an end of it.
fn met(pieces: &[Piece], grid: &Grid, own: usize, at: Vec2) -> Option<(Vec2, bool)> {
    let mut best: Option<(f64, Vec2, bool)> = None;
    for k in grid.around(at, SNAP).filter(|k| *k != own) {
        let other = &pieces[k];
        let ends = [other.a, other.b].map(|end| ((end - at).norm(), end, true));
        let foot = other.nearest(at);
        // Ends are better than what is as near.
        let places = ends.into_iter().chain([((foot - at).norm() + 1e-9, foot, false)]);
        for place in places.filter(|(distance, ..)| *distance <= SNAP) {
            if best.is_none_or(|(least, ..)| place.0 < least) {
                best = Some(place);
            }
        }
    }
    best.map(|(_, place, is_end)| (place, is_end))
}

/// An end, what it can be joined to (another end, over a corner), and how far that is \[m\].
type Join = (usize, Option<(usize, Vec2)>, f64);

/// Returns how loose ends can be joined, the nearest first.
fn joins(pieces: &[Piece], grid: &Grid, loose: &[Loose], close: f64) -> Vec<Join> {
    let mut of_piece: HashMap<usize, Vec<usize>> = HashMap::new();
    for (k, end) in loose.iter().enumerate() {
        of_piece.entry(end.piece).or_default().push(k);
    }
    let mut joins: Vec<Join> = Vec::new();
    for (k, end) in loose.iter().enumerate() {
        let mut near: Vec<usize> = grid.around(end.at, close).filter(|other| *other != end.piece).collect();
        near.sort_unstable();
        near.dedup();
        for other in near {
            for &to in of_piece.get(&other).into_iter().flatten() {
                joins.extend(corner(end, &loose[to], close).map(|(at, far)| (k, Some((to, at)), far)));
            }
            let before = pieces[other].met_by(end.at, end.out).filter(|far| *far > 0.0 && *far <= close);
            joins.extend(before.map(|far| (k, None, far)));
        }
    }
    // Of two that are as far, an end is better.
    joins.sort_by(|a, b| a.2.total_cmp(&b.2).then(b.1.is_some().cmp(&a.1.is_some())));
    joins
}

/// The corner between two ends, and how far they are from each other; `None` if they do not go on in each other.
fn corner(one: &Loose, other: &Loose, close: f64) -> Option<(Vec2, f64)> {
    let between = other.at - one.at;
    let distance = between.norm();
    if distance > close {
        return None;
    }
    let way = between.unit(0.0)?;
    let (ahead, back) = (one.out.dot(&way), -other.out.dot(&way));
    // The two lines of a wall end side by side.
    if ahead < -0.1 || back < -0.1 || ahead.max(back) < 0.5 {
        return None;
    }
    let turn = one.out.perp(&other.out);
    if turn.abs() < 0.2 {
        return Some((other.at, distance));
    }
    let along = between.perp(&other.out) / turn;
    let corner = one.at + one.out * along;
    let fits = along >= 0.0 && along <= 1.5 * close && (corner - other.at).dot(&other.out) >= 0.0;
    Some(if fits { (corner, distance) } else { (other.at, distance) })
}
