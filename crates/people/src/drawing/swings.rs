//! Swings of doors: an arc, and a leaf from its centre to one of its ends.

use super::DrawnLine;
use super::pieces::Piece;
use lemons_core::plane::Vec2;
use std::collections::HashSet;

/// \[m\] Widths of leaves.
const LEAF: [f64; 2] = [0.4, 2.0];
/// \[rad\] How far a leaf is drawn open.
const TURNED: [f64; 2] = [0.25, 2.2];
/// Largest number of arcs that are looked at.
const MOST_ARCS: usize = 2000;

/// A leaf that opens.
#[derive(Debug, Clone, PartialEq)]
pub struct Swing {
    /// \[m\] Where the leaf hangs.
    pub hinge: Vec2,
    /// \[m\] Where its other end is when it is shut.
    pub shut: Vec2,
    /// Which lines of the drawing it is.
    pub lines: Vec<usize>,
}

/// Part of a circle.
struct Arc {
    centre: Vec2,
    radius: f64,
    ends: [Vec2; 2],
    line: usize,
}

/// Finds swings. Leaves may be lines or thin rectangles.
pub(super) fn swings_of(lines: &[DrawnLine], pieces: &[Piece]) -> Vec<Swing> {
    let arcs = lines.iter().enumerate().flat_map(|(k, line)| arcs_of(k, line)).take(MOST_ARCS);
    arcs.filter_map(|arc| swing(&arc, lines, pieces)).collect()
}

/// Finds a swing that is part of a closed wall: an arc, and a side from one of its ends to its centre.
pub(super) fn within(wall: &[Vec2]) -> Option<Swing> {
    // An arc may lie across the wall's first corner.
    let corners: Vec<Vec2> = wall.iter().chain(wall.iter().skip(1)).copied().collect();
    let (layer, entity) = (String::new(), String::new());
    let line = DrawnLine {
        layer,
        role: None,
        name: None,
        entity,
        corners,
        closed: false,
        hole: false,
        ground: false,
    };
    let sides = |at: Vec2| wall.windows(2).filter(move |side| side.contains(&at));
    arcs_of(0, &line).into_iter().take(MOST_ARCS).find_map(|arc| {
        let beside = arc.ends.into_iter().flat_map(sides);
        let beside: Vec<Piece> = beside.map(|side| Piece { a: side[0], b: side[1], line: 0 }).collect();
        // A sector of a circle has a side where a leaf would be shut.
        let is_shut = |found: &Swing| {
            sides(found.shut).flatten().any(|end| (end - found.hinge).norm() < 0.1 * arc.radius)
        };
        swing(&arc, std::slice::from_ref(&line), &beside).filter(|found| !is_shut(found))
    })
}

fn swing(arc: &Arc, lines: &[DrawnLine], pieces: &[Piece]) -> Option<Swing> {
    let near = |a: Vec2, b: Vec2| (a - b).norm() <= 0.06 + 0.03 * arc.radius;
    let leaf_to = |end: Vec2| {
        let leaf = |piece: &&Piece| {
            let long = piece.length() > 0.8 * arc.radius;
            long && (near(piece.a, arc.centre) && near(piece.b, end)
                || near(piece.b, arc.centre) && near(piece.a, end))
        };
        pieces.iter().filter(leaf).map(|piece| piece.line).collect::<HashSet<usize>>()
    };
    let leaves = arc.ends.map(leaf_to);
    // A line of a wall may end at the hinge, too: the leaf is on the layer of the arc.
    let own = |found: &HashSet<usize>| found.iter().any(|k| lines[*k].layer == lines[arc.line].layer);
    let open = match (own(&leaves[0]), own(&leaves[1])) {
        (true, false) => 0,
        (false, true) => 1,
        _ if leaves[1].is_empty() && !leaves[0].is_empty() => 0,
        _ if leaves[0].is_empty() && !leaves[1].is_empty() => 1,
        (true, true) => 0,
        _ => return None,
    };
    let mut all: Vec<usize> = leaves[open].iter().copied().chain([arc.line]).collect();
    all.sort_unstable();
    all.dedup();
    Some(Swing { hinge: arc.centre, shut: arc.ends[1 - open], lines: all })
}

/// Finds the parts of a line that are an arc of at least three pieces, as large as a leaf can sweep.
fn arcs_of(number: usize, line: &DrawnLine) -> Vec<Arc> {
    let corners = &line.corners;
    let mut arcs = Vec::new();
    let mut from = 0;
    while from + 3 < corners.len() {
        let Some((centre, radius)) = circle(corners[from], corners[from + 1], corners[from + 2]) else {
            from += 1;
            continue;
        };
        let on = |at: &Vec2| ((at - centre).norm() - radius).abs() <= 1e-3 + 1e-3 * radius;
        let count = 3 + corners[from + 3..].iter().take_while(|at| on(at)).count();
        if count < 4 {
            from += 1;
            continue;
        }
        let last = from + count - 1;
        let turned: f64 = corners[from..=last]
            .windows(2)
            .map(|side| {
                let (a, b) = (side[0] - centre, side[1] - centre);
                libm::atan2(a.perp(&b), a.dot(&b))
            })
            .sum();
        let fits = (LEAF[0]..=LEAF[1]).contains(&radius) && (TURNED[0]..=TURNED[1]).contains(&turned.abs());
        if fits && !(line.closed && count == corners.len()) {
            arcs.push(Arc { centre, radius, ends: [corners[from], corners[last]], line: number });
        }
        from = last;
    }
    arcs
}

/// The circle through three places; none through places on a line.
fn circle(a: Vec2, b: Vec2, c: Vec2) -> Option<(Vec2, f64)> {
    let (u, v) = (b - a, c - a);
    let turn = 2.0 * u.perp(&v);
    if turn.abs() <= 1e-3 * u.norm() * v.norm() {
        return None;
    }
    let (p, q) = (u.norm_squared(), v.norm_squared());
    let off = Vec2::new(v.y * p - u.y * q, u.x * q - v.x * p) / turn;
    Some((a + off, off.norm()))
}
