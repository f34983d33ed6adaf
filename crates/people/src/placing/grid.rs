//! Shapes on a grid, in rows across a direction.

use super::region::Edge;
use super::{Ended, Orientation, Packing, PlacingSettings, Region, reach, wrapped};
use crate::error::{FEW_PLACES, Result, require};
use crate::random::Random;
use crate::shape::{Shape, bounds};
use lemons_core::message::message;
use lemons_core::plane::{Bounds, Pose, Ring, Rotation, Vec2, rotation, segments_touch, vec2};
use std::f64::consts::PI;

/// Number of offsets of the grid along each axis that are tried in a region. The one with most places is used.
const LAYS: usize = 8;
/// Largest number of places that are tried.
const MOST_PLACES: usize = 10_000_000;
/// \[m\] Neighbours at the computed spacing touch; this distance keeps rounding from making them overlap.
const SLACK: f64 = 1e-9;
/// \[m\] A shape may reach this far through the boundary, so that a region of exactly the right size holds its rows.
const EXACT: f64 = 1e-7;

/// Places shapes on a grid, row by row; the first shapes are in front (in the direction they face). The columns are along
/// this direction; with [`Orientation::Free`] they are along +x, and each shape faces a random direction.
///
/// # Errors
/// The region has too few places in which the shapes are inside.
pub fn grid(shapes: &[Shape], region: &Region, settings: &PlacingSettings) -> Result<Packing> {
    let extents: Vec<Bounds> = shapes.iter().map(|s| extent(s, settings.orientation)).collect();
    // The largest bounding box of a shape or, where shapes face any direction, the largest bounding circle.
    let wider = |a: Vec2, b: Vec2| vec2(a.x.max(b.x + SLACK), a.y.max(b.y + SLACK));
    let spacing = extents.iter().map(Bounds::size).fold(Vec2::zeros(), wider);
    let (direction, mut random) = (settings.orientation.start().unwrap_or(0.0), Random::new(settings.seed));
    let turn = rotation(direction);
    let places = match region.bounds() {
        None => in_the_open(shapes.len(), spacing),
        Some(_) => in_region(region, spacing, turn, &extents, shapes.len()),
    };
    let [along, across] = spacing.into();
    require(places.len() >= shapes.len(), || {
        message!(FEW_PLACES, along, across, places = places.len(), shapes = shapes.len())
    })?;
    let poses: Vec<Pose> = extents
        .iter()
        .zip(&places)
        .map(|(e, &place)| Pose {
            position: turn * (place - (e.low + e.high) * 0.5),
            orientation: match settings.orientation {
                Orientation::Free => random.within(PI),
                _ => wrapped(direction),
            },
        })
        .collect();
    Ok(Packing::of(shapes, region, poses, Ended::Done, 0))
}

/// The bounding box of a shape that faces +x, or any direction.
fn extent(shape: &Shape, orientation: Orientation) -> Bounds {
    if orientation == Orientation::Free {
        let reach = reach(shape);
        return Bounds { low: vec2(-reach, -reach), high: vec2(reach, reach) };
    }
    bounds(shape.disks.iter().copied())
}

/// Places as nearly in a square as possible about the origin, in the frame of the direction; the front row first.
fn in_the_open(count: usize, spacing: Vec2) -> Vec<Vec2> {
    let wide = libm::ceil((count as f64 * spacing.x / spacing.y).sqrt()).max(1.0) as usize;
    let (columns, rows) = (wide.min(count).max(1), count.div_ceil(wide.min(count).max(1)));
    let middle = vec2((rows as f64 - 1.0) * 0.5, (columns as f64 - 1.0) * 0.5);
    (0..count)
        .map(|k| {
            let (row, column) = ((k / columns) as f64, (k % columns) as f64);
            vec2((middle.x - row) * spacing.x, (middle.y - column) * spacing.y)
        })
        .collect()
}

/// Places, in the frame of the direction, at which every shape is inside the region; the front row first. Of several
/// offsets of the grid it uses the one with most places, and as few rows as the shapes need.
fn in_region(region: &Region, spacing: Vec2, turn: Rotation, extents: &[Bounds], wanted: usize) -> Vec<Vec2> {
    let back = turn.inverse();
    let corners = region.rings().iter().flat_map(|ring| ring.corners()).map(|c| back * c);
    let Some(Bounds { low, high }) = Bounds::of(corners) else { return Vec::new() };
    // The smallest box that contains every shape, each box centred at the origin.
    let half = extents.iter().fold(Vec2::zeros(), |half, e| {
        let own = (e.high - e.low) * 0.5;
        vec2(half.x.max(own.x), half.y.max(own.y))
    });
    let fits = |place: Vec2| {
        let box_corners = [vec2(-1.0, -1.0), vec2(1.0, -1.0), vec2(1.0, 1.0), vec2(-1.0, 1.0)];
        let at = |s: Vec2| place + vec2(s.x * half.x, s.y * half.y);
        box_inside(region, &box_corners.map(|s| turn * at(s)))
    };
    let room = vec2(high.x - low.x, high.y - low.y) - half * 2.0;
    if room.x < -EXACT || room.y < -EXACT {
        return Vec::new();
    }
    let steps = |room: f64, spacing: f64| libm::floor((room + EXACT).max(0.0) / spacing);
    let (rows, columns) = (steps(room.x, spacing.x), steps(room.y, spacing.y));
    let spare = vec2((room.x - rows * spacing.x).max(0.0), (room.y - columns * spacing.y).max(0.0));
    let mut best: Vec<Vec2> = Vec::new();
    let mut looked_at = 0;
    for lay in 0..LAYS * LAYS {
        // Try first: flush with the front, and centred.
        let part = |k: usize| k as f64 / (LAYS - 1) as f64;
        let shift = vec2(spare.x * part(lay / LAYS), spare.y * ((0.5 + part(lay % LAYS)) % 1.0));
        let first = vec2(high.x - half.x - shift.x, low.y + half.y + shift.y);
        let all = (0..=rows as u64).flat_map(|row| (0..=columns as u64).map(move |column| (row, column)));
        let place =
            |(row, column): (u64, u64)| first + vec2(-(row as f64) * spacing.x, column as f64 * spacing.y);
        let all = all.map(place).take(MOST_PLACES - looked_at).inspect(|_| looked_at += 1);
        let places: Vec<Vec2> = all.filter(|place| fits(*place)).take(wanted).collect();
        if places.len() > best.len() {
            best = places;
        }
        if best.len() >= wanted || looked_at >= MOST_PLACES {
            break;
        }
    }
    best
}

/// Returns whether a box, given by its corners, lies inside a region, except for rounding.
fn box_inside(region: &Region, corners: &[Vec2; 4]) -> bool {
    let middle = (corners[0] + corners[2]) * 0.5;
    let shrunk = corners.map(|c| {
        let way = middle - c;
        c + way * (2.0 * EXACT / way.norm().max(2.0 * EXACT))
    });
    // No edge of the region may cross the box, made slightly smaller, or lie in it.
    let clear = |rim: Ring| {
        let crosses = |e: &Edge| rim.sides().any(|(a, b)| segments_touch(e.start, e.end, a, b));
        !region.edges().iter().any(|e| crosses(e) || rim.contains(e.start))
    };
    region.contains(middle) && Ring::through(shrunk.to_vec()).is_some_and(clear)
}
