//! Ends of lines that meet, joined; lines that are drawn twice, left out.

use super::DrawnLine;
use crate::error::{Result, require};
use lemons_core::plane::Vec2;
use std::collections::{HashMap, HashSet};

/// \[m\] Places nearer than this are one.
pub(super) const SAME: f64 = 1e-6;
/// \[m\] Ends of lines that are nearer than this are probably meant to meet.
pub const WIDEST_GAP: f64 = 0.1;
/// More pairs of ends that are near each other are a mistake.
const MOST_PAIRS: usize = 4_000_000;

/// Numbers of what was joined.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Joined {
    /// Number of gaps between ends that were closed.
    pub gaps: usize,
    /// \[m\] The largest of them.
    pub largest: f64,
    /// Number of gaps of at most [`WIDEST_GAP`] that are left.
    pub left: usize,
}

type Cell = (i64, i64);

fn cell(at: Vec2, size: f64) -> Cell {
    ((at.x / size).floor() as i64, (at.y / size).floor() as i64)
}

/// Places, found by where they are.
struct Near {
    size: f64,
    cells: HashMap<Cell, Vec<usize>>,
}

impl Near {
    fn of(places: impl Iterator<Item = (usize, Vec2)>, size: f64) -> Near {
        let mut cells: HashMap<Cell, Vec<usize>> = HashMap::new();
        places.for_each(|(k, at)| cells.entry(cell(at, size)).or_default().push(k));
        Near { size, cells }
    }

    fn around(&self, at: Vec2) -> impl Iterator<Item = usize> {
        let (x, y) = cell(at, self.size);
        let cells = (-1..=1).flat_map(move |dx| (-1..=1).map(move |dy| (x + dx, y + dy)));
        cells.filter_map(|cell| self.cells.get(&cell)).flatten().copied()
    }
}

/// Joins open lines whose ends are at one place, where no third one ends; then those that are at most `gap` \[m\] apart,
/// the nearest first. Both ends go to the middle of a gap.
pub(super) fn join(lines: Vec<DrawnLine>, gap: Option<f64>) -> Result<(Vec<DrawnLine>, Joined)> {
    // End 2 k is the first corner of line k, end 2 k + 1 its last one.
    let ends: Vec<Option<Vec2>> = lines.iter().flat_map(ends_of).collect();
    let at = |end: usize| ends[end].unwrap_or(Vec2::zeros());
    let there = || (0..ends.len()).filter_map(|end| Some((end, ends[end]?)));
    let mut links: Vec<Option<usize>> = vec![None; ends.len()];
    let mut crossing = vec![false; ends.len()];
    let near = Near::of(there(), SAME);
    for (end, place) in there() {
        // Of more, some may be missed: they are not joined.
        let mut others =
            near.around(place).take(64).filter(|other| *other != end && (at(*other) - place).norm() <= SAME);
        match (others.next(), others.next()) {
            (Some(other), None) if may_close(&lines, end, other) => links[end] = Some(other),
            (Some(_), Some(_)) => crossing[end] = true,
            _ => (),
        }
    }
    // Both must find each other alone.
    for end in 0..links.len() {
        links[end] = links[end].filter(|other| links[*other] == Some(end));
    }
    let mut joined = Joined::default();
    if let Some(gap) = gap {
        for (distance, a, b) in nearest_pairs(&lines, &ends, &links, &crossing, gap)? {
            (links[a], links[b]) = (Some(b), Some(a));
            joined.gaps += 1;
            joined.largest = joined.largest.max(distance);
        }
    }
    // A hint only: where there are too many, there is none.
    joined.left = nearest_pairs(&lines, &ends, &links, &crossing, WIDEST_GAP).map_or(0, |pairs| pairs.len());
    Ok((chains(lines, &links), joined))
}

type Pair = (f64, usize, usize);

/// Returns pairs of ends that are at most `gap` apart, the nearest first, each end in one of them at most.
fn nearest_pairs(
    lines: &[DrawnLine],
    ends: &[Option<Vec2>],
    links: &[Option<usize>],
    crossing: &[bool],
    gap: f64,
) -> Result<Vec<Pair>> {
    let open = |end: &usize| ends[*end].is_some() && links[*end].is_none() && !crossing[*end];
    let mut all = pairs(ends, (0..ends.len()).filter(open).collect(), gap)?;
    let mut taken = HashSet::new();
    all.retain(|(_, a, b)| {
        let free = !taken.contains(a) && !taken.contains(b) && may_close(lines, *a, *b);
        if free {
            taken.extend([*a, *b]);
        }
        free
    });
    Ok(all)
}

/// Returns the first and the last corner of an open line; none of others.
fn ends_of(line: &DrawnLine) -> [Option<Vec2>; 2] {
    match line.corners[..] {
        [first, .., last] if !line.closed => [Some(first), Some(last)],
        _ => [None, None],
    }
}

/// Returns whether two ends may be joined: a line is closed only if it gets an inside.
fn may_close(lines: &[DrawnLine], a: usize, b: usize) -> bool {
    a / 2 != b / 2 || lines[a / 2].corners.len() > 3
}

/// Returns all pairs that are at most `gap` apart, the nearest first.
fn pairs(ends: &[Option<Vec2>], open: Vec<usize>, gap: f64) -> Result<Vec<Pair>> {
    let at = |end: usize| ends[end].unwrap_or(Vec2::zeros());
    let near = Near::of(open.iter().map(|end| (*end, at(*end))), gap);
    let (mut pairs, mut looked_at) = (Vec::new(), 0);
    for &end in &open {
        for other in near.around(at(end)) {
            looked_at += 1;
            require(looked_at <= 2 * MOST_PAIRS, || {
                format!(
                    "too many ends of lines are within {gap} m of each other to join them: use a smaller distance"
                )
            })?;
            let distance = (at(other) - at(end)).norm();
            if other > end && distance <= gap {
                pairs.push((distance, end, other));
            }
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    Ok(pairs)
}

/// Puts linked lines together, each where its first part was.
fn chains(lines: Vec<DrawnLine>, links: &[Option<usize>]) -> Vec<DrawnLine> {
    let mut used = vec![false; lines.len()];
    let mut all = Vec::new();
    // Open chains begin at an end that is free, the others anywhere.
    let free = (0..links.len()).filter(|end| links[*end].is_none());
    let mut begins: Vec<Option<usize>> = vec![None; lines.len()];
    for end in free {
        begins[end / 2].get_or_insert(end);
    }
    for pass in [false, true] {
        for k in 0..lines.len() {
            let begin = if pass { Some(2 * k) } else { begins[k] };
            if let Some(begin) = begin.filter(|_| !used[k]) {
                all.push(chain(&lines, links, begin, &mut used));
            }
        }
    }
    all.sort_by_key(|(place, _)| *place);
    all.into_iter().map(|(_, line)| line).collect()
}

fn chain(
    lines: &[DrawnLine],
    links: &[Option<usize>],
    begin: usize,
    used: &mut [bool],
) -> (usize, DrawnLine) {
    let first = begin / 2;
    let mut line = DrawnLine { corners: Vec::new(), ..lines[first].clone() };
    let (mut end, mut place) = (begin, first);
    loop {
        let k = end / 2;
        used[k] = true;
        place = place.min(k);
        let own = &lines[k].corners;
        let ordered: Vec<Vec2> = if end % 2 == 0 { own.clone() } else { own.iter().rev().copied().collect() };
        append(&mut line.corners, ordered);
        // The other end of this one, and what goes on there.
        match links[end ^ 1] {
            Some(next) if next == begin => {
                line.closed = true;
                close(&mut line.corners);
                break;
            }
            Some(next) if !used[next / 2] => end = next,
            _ => break,
        }
    }
    // Where a third line ends, it may go round all the same.
    if let [first, _, _, .., last] = line.corners[..]
        && !line.closed
        && (last - first).norm() <= SAME
    {
        line.closed = true;
        line.corners.pop();
    }
    (place, line)
}

fn append(to: &mut Vec<Vec2>, mut corners: Vec<Vec2>) {
    if let (Some(last), Some(first)) = (to.last_mut(), corners.first_mut()) {
        // Exactly there, where it is the same.
        let middle = if (*last - *first).norm() <= SAME { *last } else { (*last + *first) * 0.5 };
        *last = middle;
        corners.remove(0);
    }
    to.extend(corners);
}

fn close(corners: &mut Vec<Vec2>) {
    if let Some(last) = corners.pop()
        && let Some(first) = corners.first_mut()
        && (last - *first).norm() > SAME
    {
        *first = (last + *first) * 0.5;
    }
}

type Piece = [Cell; 2];

/// Returns the lines without those that lie on others, corner by corner; how many these are; and how many pieces of those
/// that are left lie on each other. With `areas`, closed lines are left out only where the same one is there: an area between
/// others has all its sides on theirs, and counts all the same.
pub(super) fn without_doubles(lines: Vec<DrawnLine>, areas: bool) -> (Vec<DrawnLine>, usize, usize) {
    let pieces: Vec<Vec<Piece>> = lines.iter().map(pieces_of).collect();
    let is_area = |line: &DrawnLine| areas && goes_round(line);
    // A line may be a piece of another, which is longer.
    let mut order: Vec<usize> = (0..lines.len()).filter(|&k| !is_area(&lines[k])).collect();
    order.sort_by_key(|&k| (std::cmp::Reverse(pieces[k].len()), k));
    let mut known: HashSet<Piece> = HashSet::new();
    let mut keep = vec![true; lines.len()];
    let mut on_others = 0;
    let mut same = HashSet::new();
    for (k, line) in lines.iter().enumerate().filter(|(_, line)| is_area(line)) {
        let mut sides = pieces[k].clone();
        sides.sort_unstable();
        // Polygons with the same rim may have other holes.
        let has_holes = line.hole || lines.get(k + 1).is_some_and(|next| next.hole);
        keep[k] = has_holes || same.insert((line.role.as_ref().map(|(role, _)| *role), line.hole, sides));
    }
    for k in order {
        let there = pieces[k].iter().filter(|piece| known.contains(*piece)).count();
        if there == pieces[k].len() {
            keep[k] = false;
        } else {
            on_others += there;
            known.extend(&pieces[k]);
        }
    }
    let doubles = keep.iter().filter(|keep| !**keep).count();
    let kept = lines.into_iter().zip(&keep).filter(|(_, keep)| **keep).map(|(line, _)| line).collect();
    (kept, doubles, on_others)
}

/// Returns whether a line is closed, or ends where it begins.
fn goes_round(line: &DrawnLine) -> bool {
    let [first, _, _, .., last] = line.corners[..] else { return line.closed };
    line.closed || (last - first).norm() <= SAME
}

fn pieces_of(line: &DrawnLine) -> Vec<Piece> {
    let cells: Vec<Cell> =
        line.corners.iter().map(|corner| cell(*corner + Vec2::from([0.5 * SAME; 2]), SAME)).collect();
    let ends = cells.iter().skip(1).chain(line.closed.then(|| &cells[0]));
    let pieces = cells.iter().zip(ends).filter(|(a, b)| a != b);
    pieces.map(|(a, b)| if a < b { [*a, *b] } else { [*b, *a] }).collect()
}
