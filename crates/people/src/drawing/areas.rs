//! Walls around what people can walk on: areas that meet, united, without obstacles.

use super::DrawnLine;
use super::join::SAME;
use super::role::LayerRole;
use crate::error::{PeopleError, Result, require};
use lemons_core::plane::overlay::{self, Contour, InsideRule, contour, difference};
use lemons_core::plane::{Polygon, Ring, Vec2, ground, parts, sides_that_meet};

/// Largest number of corners of areas that may meet, and of walls of which the area is calculated: some of it takes the
/// square of this. People are placed among no more.
pub(super) const MOST_CORNERS: usize = 10_000;
/// \[m\] Areas that are no further apart along their sides are one. Corners that are rounded to a centimetre are up to
/// 1.4 cm away from a side that they are on.
pub(super) const TOUCH: f64 = 0.015;

#[derive(Default)]
pub(super) struct Areas {
    pub walls: Vec<Vec<Vec2>>,
    /// \[m²\] Where areas and obstacles meet: what is left.
    pub ground: Option<f64>,
    /// Areas that lie within others, where the format has no obstacles but holes.
    pub within: Vec<String>,
}

/// Largest number of places where sides of areas cross, of corners on sides, and of slits between them.
pub(super) const MOST_MADE: usize = 2 * MOST_CORNERS;

/// A polygon, and what it is.
struct Drawn {
    polygon: Polygon,
    /// An area, or else an obstacle.
    is_area: bool,
    entity: String,
    ground: bool,
}

/// Returns walls around what people can walk on: areas without obstacles. Where none of them meet, they stay as they are.
pub(super) fn areas(lines: Vec<DrawnLine>) -> Result<Areas> {
    let is_ring = |line: &DrawnLine| line.closed && line.corners.len() > 2;
    let (closed, open): (Vec<DrawnLine>, Vec<DrawnLine>) =
        lines.into_iter().partition(|line| is_ring(line) && (line.ground || line.role.is_some()));
    let number: usize = closed.iter().map(|line| line.corners.len()).sum();
    require(number <= MOST_CORNERS, || {
        format!(
            "walkable areas and obstacles have {number} corners; at most {MOST_CORNERS} are allowed (a larger deviation of \
             curves gives fewer)"
        )
    })?;
    let rings: Vec<Ring> = closed.iter().filter_map(|line| Ring::through(cleaned(&line.corners))).collect();
    let simple = rings.iter().all(Ring::is_simple);
    let mut walls: Vec<Vec<Vec2>> = Vec::new();
    let mut found = Areas::default();
    if simple && are_apart(&closed, &rings) {
        walls.extend(rings.iter().map(|ring| ring.closed().to_vec()));
    } else {
        let drawn = polygons(&closed, &rings)?;
        let of = |areas: bool| -> Vec<Polygon> {
            let these = drawn.iter().filter(|drawn| drawn.is_area == areas);
            these.map(|drawn| drawn.polygon.clone()).collect()
        };
        let left = ground(&of(true), &of(false), TOUCH, MOST_MADE);
        let left = left.ok_or_else(|| {
            PeopleError::new("walkable areas and obstacles lie on each other at too many places".to_owned())
        })?;
        let rings = || left.iter().flat_map(Polygon::rings);
        found.within = within(&drawn);
        found.ground = Some(left.iter().map(Polygon::area).sum());
        walls.extend(rings().map(|ring| ring.closed().to_vec()));
    }
    walls.extend(open.into_iter().map(corners));
    require(!walls.is_empty(), || "obstacles cover the walkable area".to_owned())?;
    Ok(Areas { walls, ..found })
}

/// Without corners that repeat the one before: they are no spike.
fn cleaned(corners: &[Vec2]) -> Vec<Vec2> {
    let mut all = corners.to_vec();
    all.dedup_by(|next, before| (*next - *before).norm() <= SAME);
    while all.len() > 3 && (all[0] - all[all.len() - 1]).norm() <= SAME {
        all.pop();
    }
    all
}

fn is_area(line: &DrawnLine) -> bool {
    line.ground || line.has(LayerRole::WalkableArea)
}

/// Whether one area at most is there, and its holes and all obstacles lie side by side in it.
fn are_apart(closed: &[DrawnLine], rings: &[Ring]) -> bool {
    let outlines: Vec<usize> =
        (0..closed.len()).filter(|k| is_area(&closed[*k]) && !closed[*k].hole).collect();
    let rest = || (0..closed.len()).filter(|k| !outlines.contains(k));
    match outlines[..] {
        [] => true,
        [outline] => {
            let within = |k: usize| {
                let corner = rings[k].corners()[0];
                rings[outline].contains(corner)
                    && !rest().any(|other| other != k && rings[other].contains(corner))
            };
            sides_that_meet(rings).is_none() && rest().all(within)
        }
        _ => false,
    }
}

/// Puts holes into the polygons before them. Polygons that touch themselves fall into parts.
fn polygons(closed: &[DrawnLine], rings: &[Ring]) -> Result<Vec<Drawn>> {
    let mut drawn: Vec<Drawn> = Vec::new();
    let mut is_whole = false;
    for (line, ring) in closed.iter().zip(rings) {
        let whole = ring.is_simple();
        let parts = if whole { None } else { parts(ring, MOST_MADE) };
        require(whole || parts.is_some(), || {
            format!("{}: its sides cross or touch each other", line.label())
        })?;
        let polygons = parts.unwrap_or_else(|| vec![Polygon { outer: ring.clone(), holes: Vec::new() }]);
        if line.hole {
            require(is_whole, || format!("{}: it is a hole of a polygon that touches itself", line.label()))?;
            let holes = polygons.into_iter().map(|polygon| polygon.outer);
            drawn.last_mut().into_iter().for_each(|drawn| drawn.polygon.holes.extend(holes.clone()));
        } else {
            let new = |polygon| Drawn {
                polygon,
                is_area: is_area(line),
                entity: line.entity.clone(),
                ground: line.ground,
            };
            is_whole = whole;
            drawn.extend(polygons.into_iter().map(new));
        }
    }
    Ok(drawn)
}

/// Names the polygons of well-known text that lie within another one, but for the width of a line. They may be meant as
/// obstacles. Rims that cross are few where the ground of all was found.
fn within(drawn: &[Drawn]) -> Vec<String> {
    let is_within = |own: &Drawn| {
        let ring = &own.polygon.outer;
        let (bounds, area) = (ring.bounds(), ring.area());
        let is_around = |around: &&Drawn| {
            let outer = &around.polygon.outer;
            let of = outer.bounds().grown(TOUCH);
            around.ground && outer.area() > area && of.contains(bounds.low) && of.contains(bounds.high)
        };
        let on_or_in =
            |outer: &Ring, corner: &Vec2| outer.contains(*corner) || outer.nearest(*corner).distance <= TOUCH;
        drawn.iter().filter(is_around).any(|Drawn { polygon: around, .. }| {
            let beyond = || {
                let rings: Vec<Contour> = around.rings().map(contour).collect();
                difference(&[contour(ring)], &rings, InsideRule::EvenOdd)
            };
            ring.corners().iter().all(|corner| on_or_in(&around.outer, corner))
                && beyond().iter().map(|left| overlay::area(left)).sum::<f64>() <= TOUCH * bounds.size().sum()
        })
    };
    drawn.iter().filter(|own| own.ground && is_within(own)).map(|own| own.entity.clone()).collect()
}

pub(super) fn corners(line: DrawnLine) -> Vec<Vec2> {
    let mut corners = line.corners;
    if line.closed && corners.len() > 2 {
        corners.push(corners[0]);
    }
    corners
}
