//! The convex hull of disks: the area of a crowd in the open plane.

use lemons_core::plane::{Disk, Vec2, rotation, vec2};
use std::f64::consts::{PI, TAU};

/// \[m²\] Exact area of the convex hull of disks: its boundary consists of arcs and common tangents.
pub(super) fn hull_area(circles: &[Disk]) -> f64 {
    let circles = on_the_rim(circles);
    let Some(mut at) = (0..circles.len()).max_by(|&a, &b| {
        let right = |k: usize| circles[k].centre.x + circles[k].radius;
        right(a).total_cmp(&right(b)).then(circles[a].radius.total_cmp(&circles[b].radius))
    }) else {
        return 0.0;
    };
    let begin = circles[at].centre + vec2(circles[at].radius, 0.0);
    // Go round once, from the direction +x: which disk reaches furthest in the direction `angle`?
    let (mut angle, mut twice_area) = (0.0, 0.0);
    let normal = |angle: f64| rotation(angle) * vec2(1.0, 0.0);
    // Each disk has at most as many arcs as there are other disks.
    for _ in 0..circles.len() * circles.len() + 1 {
        let circle = circles[at];
        let (turn, next) = overtaking(&circles, at, angle);
        let end = (angle + turn).min(TAU);
        let (n0, n1) = (normal(angle), normal(end));
        // Green's theorem: ½∮(x dy − y dx) over the arc.
        twice_area += circle.radius * (circle.radius * (end - angle) + circle.centre.perp(&(n1 - n0)));
        angle = end;
        if angle >= TAU {
            // If several disks reach equally far along +x, this may be another one than at the beginning.
            twice_area += (circle.centre + vec2(circle.radius, 0.0)).perp(&begin);
            break;
        }
        let n = normal(angle);
        let (from, to) = (circle.centre + n * circle.radius, circles[next].centre + n * circles[next].radius);
        twice_area += from.perp(&to);
        at = next;
    }
    0.5 * twice_area
}

/// The next disk that reaches further than this one when the direction turns on from an angle, and that turn.
fn overtaking(circles: &[Disk], at: usize, angle: f64) -> (f64, usize) {
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

/// Removes disks inside a polygon of points of other disks: they cannot reach the hull.
fn on_the_rim(circles: &[Disk]) -> Vec<Disk> {
    const DIRECTIONS: usize = 64;
    let mut corners: Vec<Vec2> = Vec::new();
    for k in 0..DIRECTIONS {
        let n = rotation(2.0 * PI * k as f64 / DIRECTIONS as f64) * vec2(1.0, 0.0);
        let reach = |c: &Disk| c.centre.dot(&n) + c.radius;
        if let Some(furthest) = circles.iter().max_by(|a, b| reach(a).total_cmp(&reach(b))) {
            corners.push(furthest.centre + n * furthest.radius);
        }
    }
    corners.dedup();
    let inside = |circle: &Disk| {
        (0..corners.len()).all(|k| {
            let (from, to) = (corners[k], corners[(k + 1) % corners.len()]);
            let along = to - from;
            along.perp(&(circle.centre - from)) > (circle.radius + 1e-9) * along.norm()
        })
    };
    circles.iter().filter(|c| !inside(c)).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circle(x: f64, y: f64, radius: f64) -> Disk {
        Disk { centre: vec2(x, y), radius }
    }

    #[test]
    fn closed_forms() {
        let close = |circles: &[Disk], area: f64| {
            let found = hull_area(circles);
            assert!((found - area).abs() < 1e-12 * area.max(1.0), "{found} {area}");
        };
        close(&[], 0.0);
        close(&[circle(3.0, -2.0, 0.5)], 0.25 * PI);
        // A stadium, one disk within another, four equal ones at the corners of a square.
        close(&[circle(0.0, 0.0, 0.5), circle(2.0, 0.0, 0.5), circle(1.0, 0.0, 0.5)], 2.0 + 0.25 * PI);
        close(&[circle(0.0, 0.0, 1.0), circle(0.5, 0.0, 0.5), circle(0.1, 0.1, 0.2)], PI);
        let square = [(0.0, 0.0), (0.0, 3.0), (3.0, 0.0), (3.0, 3.0)].map(|(x, y)| circle(x, y, 1.0));
        close(&square, 9.0 + 12.0 + PI);
        // Two unequal ones: two sectors and two trapezoids, between which stands the common tangent.
        let (r, s, d) = (1.0, 0.4, 3.0);
        let half = libm::acos((r - s) / d);
        let tangent = (d * d - (r - s) * (r - s)).sqrt();
        close(
            &[circle(1.0, 1.0, r), circle(1.0, 1.0 + d, s)],
            (PI - half) * r * r + half * s * s + (r + s) * tangent,
        );
    }
}
