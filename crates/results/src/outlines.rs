//! Outlines that walls enclose: closed walls, walls whose ends meet, walls whose ends straight lines join.

use lemons_core::plane::{Ring, Vec2, segments_touch};
use lemons_core::trial::Wall;
use std::collections::BTreeMap;

/// If more ends of open walls than these are free, only the two ends of each row of walls are joined.
const MOST_FREE: usize = 400;

/// A closed wall, or walls whose ends meet or are joined.
pub(crate) struct Outline {
    pub ring: Ring,
    /// For messages.
    pub name: String,
    /// \[m\] The straight lines that close its openings.
    pub bridges: Vec<(Vec2, Vec2)>,
}

impl Outline {
    /// Makes one without openings.
    pub fn new(name: impl Into<String>, ring: Ring) -> Outline {
        Outline { ring, name: name.into(), bridges: Vec::new() }
    }

    /// Returns its name, with its openings.
    pub fn described(&self) -> String {
        if self.bridges.is_empty() {
            return self.name.clone();
        }
        let widths: Vec<String> =
            self.bridges.iter().map(|(a, b)| format!("{:.3}", (*b - *a).norm())).collect();
        let widths: Vec<&str> =
            widths.iter().map(|text| text.trim_end_matches('0').trim_end_matches('.')).collect();
        let (noun, lines) =
            if widths.len() == 1 { ("opening", "a straight line") } else { ("openings", "straight lines") };
        format!("{}, its {noun} of {} m closed by {lines}", self.name, widths.join(", "))
    }
}

/// Equal for equal points: the sum turns −0 into 0.
fn bits(point: Vec2) -> [u64; 2] {
    [(point.x + 0.0).to_bits(), (point.y + 0.0).to_bits()]
}

/// Returns what walls enclose: closed walls, those that open walls make where just two ends meet, and those that other
/// open walls make when straight lines join their ends, the nearest first, where no wall is in between; and the sides
/// \[m\] of walls that enclose nothing without such lines. Walls that open at times do not count.
pub(crate) fn outlines(walls: &[Wall]) -> (Vec<Outline>, Vec<(Vec2, Vec2)>) {
    let walls: Vec<&Wall> =
        walls.iter().filter(|wall| wall.corners.len() > 1 && wall.open.is_none()).collect();
    // The two ends of a wall have successive places, of which the first is even.
    let ends: Vec<Vec2> =
        walls.iter().flat_map(|wall| [wall.corners[0], wall.corners[wall.corners.len() - 1]]).collect();
    let mut partner: Vec<Option<usize>> = vec![None; ends.len()];
    let mut meeting: BTreeMap<[u64; 2], Vec<usize>> = BTreeMap::new();
    for k in (0..ends.len()).step_by(2) {
        if bits(ends[k]) == bits(ends[k + 1]) {
            (partner[k], partner[k + 1]) = (Some(k + 1), Some(k));
        } else {
            [k, k + 1].into_iter().for_each(|end| meeting.entry(bits(ends[end])).or_default().push(end));
        }
    }
    for ends in meeting.into_values() {
        if let [a, b] = ends[..] {
            (partner[a], partner[b]) = (Some(b), Some(a));
        }
    }
    let meets: Vec<bool> = partner.iter().map(Option::is_some).collect();
    for (a, b) in free_pairs(&walls, &ends, &partner) {
        let (from, to) = (ends[a], ends[b]);
        let at = |p: Vec2| bits(p) == bits(from) || bits(p) == bits(to);
        let blocks = |&(p, q): &(Vec2, Vec2)| !at(p) && !at(q) && segments_touch(from, to, p, q);
        if partner[a].or(partner[b]).is_none()
            && !walls.iter().flat_map(|wall| sides(wall)).any(|side| blocks(&side))
        {
            (partner[a], partner[b]) = (Some(b), Some(a));
        }
    }
    let (mut outlines, mut encloses) = (Vec::new(), vec![false; walls.len()]);
    for mut way in loops(&partner) {
        // A bridge, if there is one, is at the end.
        let bridge = way.iter().rposition(|at| !meets[at ^ 1]);
        way.rotate_left(bridge.map_or(0, |last| last + 1));
        way.iter().for_each(|at| encloses[at / 2] = bridge.is_none());
        let corners = way.iter().flat_map(|at| {
            let mut corners = walls[at / 2].corners.clone();
            if at % 2 == 1 {
                corners.reverse();
            }
            corners
        });
        let mut corners: Vec<Vec2> = corners.collect();
        corners.dedup();
        let outs = way.iter().map(|at| at ^ 1).filter(|out| !meets[*out]);
        let bridges = outs.filter_map(|out| Some((ends[out], ends[partner[out]?]))).collect();
        let ids: Vec<String> = way.iter().map(|at| format!("{:?}", walls[at / 2].id)).collect();
        let name = format!("{} {}", if ids.len() == 1 { "wall" } else { "walls" }, ids.join(", "));
        outlines.extend(Ring::through(corners).map(|ring| Outline { ring, name, bridges }));
    }
    let open = walls.iter().zip(encloses).filter(|(_, encloses)| !encloses);
    (outlines, open.flat_map(|(wall, _)| sides(wall)).collect())
}

fn sides(wall: &Wall) -> impl Iterator<Item = (Vec2, Vec2)> {
    wall.corners.windows(2).map(|side| (side[0], side[1]))
}

/// Returns the pairs of ends without a partner that may be joined, the nearest first.
fn free_pairs(walls: &[&Wall], ends: &[Vec2], partner: &[Option<usize>]) -> Vec<(usize, usize)> {
    let free: Vec<usize> = (0..ends.len()).filter(|end| partner[*end].is_none()).collect();
    let other_end = |&end: &usize| {
        let mut at = end ^ 1;
        while let Some(next) = partner[at] {
            at = next ^ 1;
        }
        (end, at)
    };
    let mut pairs: Vec<(usize, usize)> = if free.len() <= MOST_FREE {
        (0..free.len())
            .flat_map(|b| free[..b].iter().map(move |a| (*a, b)))
            .map(|(a, b)| (a, free[b]))
            .collect()
    } else {
        free.iter().map(other_end).filter(|(a, b)| a < b).collect()
    };
    // Of a straight wall there is nothing inside.
    pairs.retain(|&(a, b)| a / 2 != b / 2 || walls[a / 2].corners.len() > 2);
    let length = |&(a, b): &(usize, usize)| (ends[a] - ends[b]).norm_squared();
    pairs.sort_by(|a, b| length(a).total_cmp(&length(b)));
    pairs
}

/// Follows walls from end to partner, and returns the ways that come back: the ends at which they enter walls.
fn loops(partner: &[Option<usize>]) -> Vec<Vec<usize>> {
    let mut used = vec![false; partner.len() / 2];
    let from = |start: usize| {
        let (mut way, mut at) = (Vec::new(), 2 * start);
        while !used[at / 2] {
            used[at / 2] = true;
            way.push(at);
            at = partner[at ^ 1]?;
        }
        (!way.is_empty() && at == 2 * start).then_some(way)
    };
    (0..partner.len() / 2).filter_map(from).collect()
}
