//! Walls that are drawn as two lines: where they end, the gaps between their ends, and what they enclose.
//!
//! Pieces of walls are mended, gaps are closed, and what they cut the plane into is looked at: what is as thin as a wall
//! is one, what lies around everything is outside, the rest are rooms. Gaps between rooms join them.

use super::gap::{Gap, Leads};
use super::pieces::{Grid, Mended, Piece, SNAP};
use super::swings::Swing;
use crate::error::{Result, require};
use lemons_core::plane::overlay::{self, Contour, InsideRule};
use lemons_core::plane::{Bounds, InPlane, Ring, Vec2, vec2};

/// \[m\] Two parallel lines at such a distance are a wall.
pub const THICKNESS: [f64; 2] = [0.05, 0.4];
/// \[m\] Wider gaps are not looked for.
const FARTHEST_END: f64 = 8.0;
/// \[m\] Rounding of thicknesses.
const ROUNDED: f64 = 5e-3;
/// \[m\] How far shapes overlap that are to be united: rounding would leave a gap.
const OVERLAP: f64 = 1e-6;
/// \[m²\] What is smaller is not mentioned.
pub(super) const SMALL: f64 = 1e-4;
/// Largest number of ends of walls: gaps take the square of this.
const MOST_ENDS: usize = 10_000;
/// Largest number of gaps, times that of parts that they may lead to.
const MOST_LOOKS: usize = 100_000_000;
/// Among more gaps, none is looked at closely.
const MOST_JOINS: usize = 500;
/// \[m\] How far a swing may be from its gap.
const SWING_OFF: f64 = 0.45;

/// Ground that walls enclose.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Enclosed {
    /// The ground: its rim, then holes; none where nothing is enclosed.
    pub ground: Vec<Contour>,
    pub gaps: Vec<Gap>,
    /// Gaps that are too wide: they are not closed.
    pub wide: Vec<[Vec2; 2]>,
    /// \[m, m²\] A place in a room that no gap joins to the ground, and its area.
    pub others: Vec<(Vec2, f64)>,
}

/// Where a wall ends: two corners, or one place twice.
#[derive(Debug, Clone, Copy)]
struct End {
    /// Left and right, seen along `out`.
    sides: [Vec2; 2],
    /// From the wall outwards.
    out: Vec2,
}

impl End {
    fn middle(&self) -> Vec2 {
        (self.sides[0] + self.sides[1]) * 0.5
    }

    fn thickness(&self) -> f64 {
        (self.sides[1] - self.sides[0]).norm()
    }

    fn of(a: Vec2, b: Vec2, out: Vec2) -> End {
        let sides = if (b - a).dot(&out.left()) > 0.0 { [b, a] } else { [a, b] };
        End { sides, out }
    }
}

fn is_thickness(length: f64) -> bool {
    is_within(THICKNESS, length)
}

fn is_within([low, high]: [f64; 2], length: f64) -> bool {
    (low - ROUNDED..=high + ROUNDED).contains(&length)
}

/// Finds ends of walls. Two lines whose ends lie side by side get a piece between them.
fn ends_of(mended: &mut Mended, grid: &Grid) -> Vec<End> {
    let pieces = &mended.pieces;
    let mut ends = Vec::new();
    for (k, cap) in pieces.iter().enumerate().filter(|(_, piece)| is_thickness(piece.length())) {
        let Some(across) = cap.direction() else { continue };
        // The lines that go on at one end of it, on one side.
        let from = |at: Vec2, side: Vec2| {
            let away = |piece: &Piece| {
                let far = if (piece.a - at).norm() <= SNAP {
                    piece.b
                } else if (piece.b - at).norm() <= SNAP {
                    piece.a
                } else {
                    return None;
                };
                (far - at).unit(SNAP)
            };
            grid.around(at, SNAP)
                .filter(|other| *other != k)
                .filter_map(|other| away(&pieces[other]))
                .find(|away| away.dot(&side) > 0.8 && away.dot(&across).abs() < 0.6)
        };
        for side in [across.left(), -across.left()] {
            if let (Some(one), Some(other)) = (from(cap.a, side), from(cap.b, side))
                && one.dot(&other) > 0.97
            {
                ends.push(End::of(cap.a, cap.b, -(one + other) * 0.5));
            }
        }
    }
    let loose = std::mem::take(&mut mended.loose);
    let mut used = vec![false; loose.len()];
    for k in 0..loose.len() {
        let own = loose[k];
        let beside = |other: &usize| {
            let (off, other) = (loose[*other].at - own.at, &loose[*other]);
            is_thickness(off.norm())
                && own.out.dot(&other.out) > 0.97
                && off.dot(&own.out).abs() < 0.5 * off.norm()
        };
        let others = (0..loose.len()).filter(|other| *other != k && !used[*other] && !used[k]);
        let nearest = others.filter(beside).min_by(|a, b| {
            let far = |other: &usize| (loose[*other].at - own.at).norm();
            far(a).total_cmp(&far(b))
        });
        match nearest {
            Some(other) => {
                (used[k], used[other]) = (true, true);
                let (a, b) = (own.at, loose[other].at);
                mended.pieces.push(Piece { a, b, line: mended.pieces[own.piece].line });
                ends.push(End::of(a, b, own.out));
            }
            None if !used[k] => ends.push(End { sides: [own.at; 2], out: own.out }),
            None => (),
        }
    }
    ends
}

/// A gap before it is known what is beyond.
struct Opening {
    /// The corners at one end, then at the other: left, right, left, right, as one walks through along the wall.
    quad: [Vec2; 4],
    crossed: bool,
}

/// Finds gaps between ends of walls, and before the side of another wall.
fn openings(pieces: &[Piece], grid: &Grid, ends: &[End], panes: &[Piece]) -> Vec<Opening> {
    let facing = |k: usize, other: usize| {
        let (a, b) = (&ends[k], &ends[other]);
        let way = b.middle() - a.middle();
        let along = way.dot(&a.out);
        // In a round wall both ends turn to the same side.
        let off = (a.out - b.out).unit(0.0).map_or(0.0, |mean| way.perp(&mean).abs());
        let fits = k != other
            && a.out.dot(&b.out) < -0.8
            && along > SNAP
            && along <= FARTHEST_END
            && -way.dot(&b.out) > 0.0
            && off <= 0.5 * a.thickness().max(b.thickness()) + 0.1;
        fits.then_some(along)
    };
    let nearest = |k: usize| {
        let all = (0..ends.len()).filter_map(|other| Some((other, facing(k, other)?)));
        all.min_by(|a, b| a.1.total_cmp(&b.1))
    };
    let best: Vec<Option<(usize, f64)>> = (0..ends.len()).map(nearest).collect();
    let mut found = Vec::new();
    for (k, end) in ends.iter().enumerate() {
        let before = wall_before(pieces, grid, end);
        let quad = match (best[k], before) {
            (Some((other, along)), before) if before.is_none_or(|(far, _)| along <= far + SNAP) => {
                // Each finds the other.
                if best[other].is_none_or(|(back, _)| back != k) || other < k {
                    continue;
                }
                let [a, b] = [end.sides, ends[other].sides];
                [a[0], a[1], b[0], b[1]]
            }
            (_, Some((_, sides))) => [end.sides[0], end.sides[1], sides[1], sides[0]],
            _ => continue,
        };
        let crossed = is_crossed(&quad, end.out, panes);
        found.push(Opening { quad, crossed });
    }
    found
}

/// The side of a wall before an end: how far it is, and where both sides of the end meet it.
fn wall_before(pieces: &[Piece], grid: &Grid, end: &End) -> Option<(f64, [Vec2; 2])> {
    let ray = |from: Vec2| {
        let hits = grid.around(from + end.out * (0.5 * FARTHEST_END), 0.5 * FARTHEST_END).filter_map(|k| {
            pieces[k].met_by(from, end.out).filter(|far| *far > SNAP && *far <= FARTHEST_END)
        });
        hits.min_by(f64::total_cmp)
    };
    let sides = end.sides.map(|side| Some((ray(side)?, side)));
    let [Some(left), Some(right)] = sides else { return None };
    let middle = ray(end.middle())?;
    let at = |(far, side): (f64, Vec2)| side + end.out * far;
    Some((middle, [at(left), at(right)]))
}

/// Whether lines run from end to end of a gap, and no further.
fn is_crossed(quad: &[Vec2; 4], out: Vec2, panes: &[Piece]) -> bool {
    let from = (quad[0] + quad[1]) * 0.5;
    let width = ((quad[2] + quad[3]) * 0.5 - from).dot(&out);
    let half = 0.5 * (quad[1] - quad[0]).norm() + 0.05;
    panes.iter().any(|pane| {
        let [a, b] = [pane.a, pane.b].map(|at| ((at - from).dot(&out), (at - from).perp(&out)));
        let (low, high) = (a.0.min(b.0), a.0.max(b.0));
        let within = a.1.abs() <= half && b.1.abs() <= half;
        within && (-0.3..=0.1 * width).contains(&low) && (0.9 * width..=width + 0.3).contains(&high)
    })
}

/// A part of the plane between lines.
struct Part {
    polygon: Vec<Contour>,
    rings: Vec<Ring>,
    bounds: Bounds,
    area: f64,
    /// Whether it is as thin as a wall.
    thin: bool,
}

impl Part {
    fn of(polygon: Vec<Contour>) -> Option<Part> {
        let rings: Vec<Ring> = polygon.iter().filter_map(overlay::ring).collect();
        let bounds = rings.first()?.bounds();
        let area = overlay::area(&polygon);
        let rim: f64 = rings.iter().flat_map(Ring::sides).map(|(a, b)| (b - a).norm()).sum();
        let thin = 2.0 * area <= (THICKNESS[1] + ROUNDED) * rim;
        Some(Part { polygon, rings, bounds, area, thin })
    }

    fn contains(&self, at: Vec2) -> bool {
        self.bounds.contains(at) && self.rings.iter().filter(|ring| ring.contains(at)).count() == 1
    }
}

fn line(piece: &Piece) -> Contour {
    vec![piece.a.into(), piece.b.into()]
}

/// The box around pieces, and a metre more.
fn around(pieces: &[Piece]) -> Contour {
    let bounds = Bounds::of(pieces.iter().flat_map(|piece| [piece.a, piece.b])).unwrap_or(Bounds::UNIT);
    overlay::contour(&Ring::around(bounds.grown(1.0)))
}

/// Returns the outlines of what lines enclose, each with all that is in it.
pub(super) fn blobs(mended: &Mended) -> Vec<Contour> {
    let lines: Vec<Contour> = mended.pieces.iter().map(line).collect();
    let around = around(&mended.pieces);
    let parts = overlay::cut(&around, &lines);
    let is_outside = |polygon: &&Vec<Contour>| polygon.first().is_some_and(|rim| is_rim(rim, &around));
    parts.iter().find(is_outside).map(|polygon| polygon[1..].to_vec()).unwrap_or_default()
}

fn is_rim(contour: &Contour, around: &Contour) -> bool {
    let low = |contour: &Contour| contour.iter().map(|[x, _]| *x).fold(f64::INFINITY, f64::min);
    (low(contour) - low(around)).abs() < 0.1
}

/// Returns the distances of parallel lines that are at least and at most so far apart, each with its length \[m\], the longest
/// first.
pub(super) fn thicknesses(pieces: &[Piece], limits: [f64; 2]) -> Vec<(f64, f64)> {
    let grid = Grid::of(pieces);
    let mut found: std::collections::BTreeMap<i64, f64> = std::collections::BTreeMap::new();
    for (k, piece) in pieces.iter().enumerate() {
        let Some(along) = piece.direction().filter(|_| piece.length() > 2.0 * THICKNESS[0]) else { continue };
        // How much of it has another beside it, by the nearest.
        let middle = (piece.a + piece.b) * 0.5;
        let mut near: Vec<usize> = grid.around(middle, 0.5 * piece.length() + limits[1]).collect();
        near.sort_unstable();
        near.dedup();
        let mut best: Option<(f64, f64)> = None;
        for other in near.into_iter().filter(|other| *other != k).map(|other| &pieces[other]) {
            if other.direction().is_none_or(|way| way.perp(&along).abs() > 0.02) {
                continue;
            }
            let [a, b] =
                [other.a, other.b].map(|at| ((at - piece.a).dot(&along), along.perp(&(at - piece.a))));
            let shared = a.0.max(b.0).min(piece.length()) - a.0.min(b.0).max(0.0);
            let apart = 0.5 * (a.1 + b.1).abs();
            let fits = is_within(limits, apart) && shared > apart;
            if fits && best.is_none_or(|(least, _)| apart < least - SNAP) {
                best = Some((apart, shared));
            } else if fits
                && let Some((least, sum)) = &mut best
                && (apart - *least).abs() <= SNAP
            {
                *sum += shared;
            }
        }
        if let Some((apart, shared)) = best {
            *found.entry((apart * 1000.0).round() as i64).or_default() += 0.5 * shared.min(piece.length());
        }
    }
    let mut all: Vec<(f64, f64)> =
        found.into_iter().map(|(apart, length)| (apart as f64 / 1000.0, length)).collect();
    all.sort_by(|a, b| b.1.total_cmp(&a.1));
    all
}

/// Returns what walls enclose: the largest rooms that gaps join. Gaps up to `widest` \[m\] are closed where they lead
/// elsewhere.
///
/// # Errors
/// There are too many ends of walls, or gaps.
pub(super) fn enclose(
    mut mended: Mended,
    swings: &[Swing],
    panes: &[Piece],
    widest: f64,
) -> Result<Enclosed> {
    let grid = Grid::of(&mended.pieces);
    let ends = ends_of(&mut mended, &grid);
    require(ends.len() <= MOST_ENDS, || {
        format!("walls end at more than {MOST_ENDS} places: too many to look for gaps: choose layers")
    })?;
    let grid = Grid::of(&mended.pieces);
    let openings = openings(&mended.pieces, &grid, &ends, panes);
    let width = |quad: &[Vec2; 4]| ((quad[2] + quad[3] - quad[0] - quad[1]) * 0.5).norm();
    let (narrow, wide): (Vec<Opening>, Vec<Opening>) =
        openings.into_iter().partition(|opening| width(&opening.quad) <= widest + SNAP);
    // A little into what they meet, but exactly through its corners.
    let longer = |a: Vec2, b: Vec2| {
        let beyond = b + (b - a).unit(0.0).unwrap_or(vec2(0.0, 0.0)) * OVERLAP;
        [a, b, beyond].map(Into::into).to_vec()
    };
    let closers =
        narrow.iter().flat_map(|Opening { quad: [a, b, c, d], .. }| [longer(*a, *d), longer(*b, *c)]);
    let lines: Vec<Contour> = mended.pieces.iter().map(line).chain(closers).collect();
    let around = around(&mended.pieces);
    let mut parts: Vec<Part> = overlay::cut(&around, &lines)
        .into_iter()
        .filter_map(Part::of)
        .filter(|part| part.area > SMALL)
        .collect();
    require(narrow.len() * parts.len() <= MOST_LOOKS, || {
        let (gaps, parts) = (narrow.len(), parts.len());
        format!("walls have {gaps} gaps and cut the plane into {parts} parts: too many: choose layers")
    })?;
    let outside = parts.iter().position(|part| is_rim(&part.polygon[0], &around));
    let on = |at: Vec2| parts.iter().position(|part| part.contains(at));
    // What is beyond a wall on one side: the first part that is no wall.
    let beyond = |from: Vec2, way: Vec2| {
        let steps = (0..12).map(|k| from + way * (0.02 + 0.05 * f64::from(k)));
        steps.filter_map(on).find(|part| Some(*part) == outside || !parts[*part].thin)
    };
    let mut room: Vec<usize> = (0..parts.len()).collect();
    let mut sides = Vec::new();
    let drawn = narrow.iter().map(|Opening { quad, crossed }| (*quad, *crossed, true));
    let shut: Vec<([Vec2; 4], bool, bool)> =
        on_walls(&mended.pieces, &grid, swings, &narrow).map(|quad| (quad, false, false)).collect();
    for (quad, crossed, open) in drawn.chain(shut) {
        let [a, b, c, d] = quad;
        let along = ((c + d) - (a + b)).unit(0.0).unwrap_or(vec2(1.0, 0.0));
        let (left, right) = ((a + d) * 0.5, (b + c) * 0.5);
        let leaves = swings.iter().filter(|swing| is_of(swing, &quad)).count();
        let found = [beyond(left, along.left()), beyond(right, -along.left())];
        sides.push((quad, crossed, open, leaves, found));
        if let [Some(one), Some(other)] = found
            && Some(one) != outside
            && Some(other) != outside
            && (!crossed || leaves > 0)
        {
            let (one, other) = (root(&mut room, one), root(&mut room, other));
            room[one] = other;
        }
    }
    let mut areas = vec![0.0; parts.len()];
    let is_room = |part: usize| Some(part) != outside && !parts[part].thin;
    for part in (0..parts.len()).filter(|part| is_room(*part)) {
        areas[root(&mut room, part)] += parts[part].area;
    }
    let largest = (0..parts.len()).max_by(|a, b| areas[*a].total_cmp(&areas[*b]));
    let Some(largest) = largest.filter(|part| areas[*part] > 0.0) else {
        return Ok(Enclosed {
            ground: Vec::new(),
            gaps: Vec::new(),
            wide: ends_wide(&wide),
            others: Vec::new(),
        });
    };
    let own: Vec<bool> =
        (0..parts.len()).map(|part| is_room(part) && root(&mut room, part) == largest).collect();
    let others: Vec<(Vec2, f64)> = (0..parts.len())
        .filter(|part| is_room(*part) && !own[*part])
        .map(|part| (inner(&parts[part]), parts[part].area))
        .collect();
    let joins: Vec<Option<[usize; 2]>> = sides
        .iter()
        .map(|&(_, crossed, _, leaves, found)| match found {
            [Some(one), Some(other)] if own[one] && own[other] && (!crossed || leaves > 0) => {
                Some([one, other])
            }
            _ => None,
        })
        .collect();
    let mut gaps = Vec::new();
    let mut ground: Vec<Contour> = Vec::new();
    for (k, (quad, crossed, open, leaves, found)) in sides.into_iter().enumerate() {
        let [left, right] = found.map(|part| part.is_some_and(|part| own[part]));
        let to_outside = found.iter().any(|part| part.is_none() || *part == outside);
        let leads = match (left, right) {
            (true, true) => Leads::Inside,
            (false, false) => continue,
            _ if to_outside => Leads::Outside,
            _ => Leads::Elsewhere,
        };
        let [a, b, c, d] = quad;
        // What has no leaf and leads where others lead, too, is the room around a column.
        let same = || found[0] == found[1] || joins.len() <= MOST_JOINS && is_spare(&joins, k, parts.len());
        if leads == Leads::Inside && (!crossed || leaves > 0) {
            ground.extend(grown(&quad));
        }
        if !(leads == Leads::Inside && leaves == 0 && same()) {
            let ends = if left { [a, d] } else { [b, c] };
            gaps.push(Gap { ends, leads, leaves, crossed, open, quad });
        }
    }
    // Sides of rooms that were joined may lie on each other within rounding.
    for (part, _) in parts.iter_mut().zip(&own).filter(|(_, own)| **own) {
        ground.append(&mut part.polygon);
    }
    let united = overlay::union(&ground);
    let mut all: Vec<Vec<Contour>> = united.iter().map(|polygon| tidied(polygon)).collect();
    all.sort_by(|a, b| overlay::area(b).total_cmp(&overlay::area(a)));
    Ok(Enclosed { ground: all.into_iter().next().unwrap_or_default(), gaps, wide: ends_wide(&wide), others })
}

/// The number of the parts that are joined to a part.
fn root(room: &mut [usize], mut part: usize) -> usize {
    while room[part] != part {
        room[part] = room[room[part]];
        part = room[part];
    }
    part
}

/// Whether both sides of a gap are joined without it.
fn is_spare(joins: &[Option<[usize; 2]>], gap: usize, parts: usize) -> bool {
    let Some(sides) = joins[gap] else { return false };
    let mut room: Vec<usize> = (0..parts).collect();
    for [one, other] in joins.iter().enumerate().filter(|(k, _)| *k != gap).filter_map(|(_, join)| *join) {
        let (one, other) = (root(&mut room, one), root(&mut room, other));
        room[one] = other;
    }
    let [one, other] = sides.map(|side| root(&mut room, side));
    one == other
}

fn ends_wide(wide: &[Opening]) -> Vec<[Vec2; 2]> {
    wide.iter().map(|Opening { quad: [a, b, c, d], .. }| [(a + b) * 0.5, (c + d) * 0.5]).collect()
}

/// A place inside.
fn inner(part: &Part) -> Vec2 {
    super::NamedPlace { name: String::new(), corners: part.rings[0].corners().to_vec() }.middle().0
}

/// Whether a swing shuts a gap.
fn is_of(swing: &Swing, quad: &[Vec2; 4]) -> bool {
    let [from, to] = [(quad[0] + quad[1]) * 0.5, (quad[2] + quad[3]) * 0.5];
    let half = 0.5 * (quad[1] - quad[0]).norm();
    let near = |at: Vec2| {
        (lemons_core::plane::nearest_on_segment(from, to, at) - at).norm() <= half + 0.5 * SWING_OFF
    };
    let at_end = [from, to].iter().any(|end| (swing.hinge - *end).norm() <= half + SWING_OFF);
    at_end && near(swing.hinge) && near(swing.shut)
}

/// Returns a gap for each swing before a wall that has none there.
fn on_walls<'a>(
    pieces: &'a [Piece],
    grid: &'a Grid,
    swings: &'a [Swing],
    drawn: &'a [Opening],
) -> impl Iterator<Item = [Vec2; 4]> + 'a {
    let free = |swing: &&Swing| !drawn.iter().any(|opening| is_of(swing, &opening.quad));
    swings.iter().filter(free).filter_map(|swing| {
        let along = (swing.shut - swing.hinge).unit(SNAP)?;
        let middle = (swing.hinge + swing.shut) * 0.5;
        // The two lines of the wall, beside the middle of the leaf.
        let mut levels: Vec<f64> = grid
            .around(middle, SWING_OFF)
            .filter(|k| pieces[*k].direction().is_some_and(|way| way.perp(&along).abs() < 0.1))
            .flat_map(|k| [along.left(), -along.left()].map(|way| (k, way)))
            .filter_map(|(k, way)| {
                let far = pieces[k].met_by(middle - way * OVERLAP, way)?;
                (0.0..=SWING_OFF).contains(&far).then(|| far * way.dot(&along.left()))
            })
            .collect();
        levels.sort_by(f64::total_cmp);
        let (low, high) = (*levels.first()?, *levels.last()?);
        let side = along.left();
        let [a, b] = [swing.hinge, swing.shut];
        Some([a + side * high, a + side * low, b + side * low, b + side * high])
    })
}

/// The ground of a gap, a little into both rooms.
fn grown(&[a, b, c, d]: &[Vec2; 4]) -> Option<Contour> {
    let along = ((c + d) - (a + b)).unit(0.0)?;
    let off = along.left() * OVERLAP;
    let ring = Ring::through(vec![a + off, b - off, c - off, d + off])?;
    let ring = if ring.signed_area() > 0.0 { ring } else { ring.reversed() };
    Some(overlay::contour(&ring))
}

/// Returns a polygon without corners that rounding made: too near to the next, or on a straight side.
pub(super) fn tidied(polygon: &[Contour]) -> Vec<Contour> {
    let tidy = |contour: &Contour| {
        let mut corners: Vec<Vec2> = contour.iter().map(|corner| Vec2::from(*corner)).collect();
        loop {
            let before = corners.len();
            let mut k = 0;
            while k < corners.len() && corners.len() > 3 {
                let n = corners.len();
                let (last, next) = (corners[(k + n - 1) % n], corners[(k + 1) % n]);
                let at = corners[k];
                let foot = lemons_core::plane::nearest_on_segment(last, next, at);
                if (at - next).norm() <= 3.0 * OVERLAP || (foot - at).norm() <= 1e-7 {
                    corners.remove(k);
                } else {
                    k += 1;
                }
            }
            if corners.len() == before {
                break;
            }
        }
        corners.iter().map(|corner| <[f64; 2]>::from(*corner)).collect::<Contour>()
    };
    let tidy_all = polygon.iter().map(tidy);
    let has_inside = |contour: &Contour| overlay::ring(contour).is_some_and(|ring| ring.area() > SMALL);
    tidy_all.filter(has_inside).collect()
}

/// Returns the ground without obstacles, and the parts that they cut off.
pub(super) fn without(ground: &[Contour], obstacles: &[Contour]) -> (Vec<Contour>, Vec<Vec<Contour>>) {
    if obstacles.is_empty() {
        return (ground.to_vec(), Vec::new());
    }
    let left = overlay::difference(ground, &overlay::union(obstacles).concat(), InsideRule::NonZero);
    let mut all: Vec<Vec<Contour>> =
        left.iter().map(|polygon| tidied(polygon)).filter(|polygon| overlay::area(polygon) > SMALL).collect();
    all.sort_by(|a, b| overlay::area(b).total_cmp(&overlay::area(a)));
    let mut all = all.into_iter();
    (all.next().unwrap_or_default(), all.collect())
}
