//! The convex hull of disks: what a crowd in the open covers.

use super::Circle;
use crowd_mechanics::engine::{Rotation, Vec2, vec2};
use std::f64::consts::{PI, TAU};

/// \[m²\] Area of the convex hull of disks, exact: its boundary is made of arcs and common tangents.
pub(super) fn hull_area(circles: &[Circle]) -> f64 {
    let circles = on_the_rim(circles);
    let Some(mut at) = (0..circles.len()).max_by(|&a, &b| {
        let right = |k: usize| circles[k].centre.x + circles[k].radius;
        right(a).total_cmp(&right(b)).then(circles[a].radius.total_cmp(&circles[b].radius))
    }) else {
        return 0.0;
    };
    // Once round, from the direction +x: which disk reaches furthest in the direction `angle`.
    let (mut angle, mut twice_area) = (0.0, 0.0);
    let normal = |angle: f64| vec2(1.0, 0.0).rotated(Rotation::by(angle));
    // Each disk gives at most as many arcs as there are others.
    for _ in 0..circles.len() * circles.len() + 1 {
        let circle = circles[at];
        let (turn, next) = overtaking(&circles, at, angle);
        let end = (angle + turn).min(TAU);
        let (n0, n1) = (normal(angle), normal(end));
        // Green: ½∮(x dy − y dx) over the arc.
        twice_area += circle.radius * (circle.radius * (end - angle) + circle.centre.cross(n1 - n0));
        angle = end;
        if angle >= TAU {
            break;
        }
        let n = normal(angle);
        let (from, to) = (circle.centre + n * circle.radius, circles[next].centre + n * circles[next].radius);
        twice_area += from.cross(to);
        at = next;
    }
    0.5 * twice_area
}

/// The next disk that reaches further than this one as the direction turns on from an angle, and after which turn.
fn overtaking(circles: &[Circle], at: usize, angle: f64) -> (f64, usize) {
    let mut first = (f64::INFINITY, at);
    for (k, other) in circles.iter().enumerate() {
        let to = other.centre - circles[at].centre;
        let (distance, thinner) = (to.norm(), circles[at].radius - other.radius);
        if k == at || distance <= thinner.abs() {
            continue;
        }
        // The common tangent's normal: distance · cos(direction − normal) = difference of the radii.
        let overtakes = libm::atan2(to.y, to.x) - libm::acos(thinner / distance);
        let mut turn = (overtakes - angle) % TAU;
        if turn < -1e-12 {
            turn += TAU;
        }
        if turn < first.0 {
            first = (turn.max(0.0), k);
        }
    }
    first
}

/// Without those that lie inside a polygon of points of others, which cannot reach the hull.
fn on_the_rim(circles: &[Circle]) -> Vec<Circle> {
    const DIRECTIONS: usize = 64;
    let mut corners: Vec<Vec2> = Vec::new();
    for k in 0..DIRECTIONS {
        let n = vec2(1.0, 0.0).rotated(Rotation::by(2.0 * PI * k as f64 / DIRECTIONS as f64));
        let reach = |c: &Circle| c.centre.dot(n) + c.radius;
        if let Some(furthest) = circles.iter().max_by(|a, b| reach(a).total_cmp(&reach(b))) {
            corners.push(furthest.centre + n * furthest.radius);
        }
    }
    corners.dedup();
    let inside = |circle: &Circle| {
        (0..corners.len()).all(|k| {
            let (from, to) = (corners[k], corners[(k + 1) % corners.len()]);
            let along = to - from;
            along.cross(circle.centre - from) > (circle.radius + 1e-9) * along.norm()
        })
    };
    circles.iter().filter(|c| !inside(c)).copied().collect()
}
