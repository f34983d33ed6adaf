//! The area that a union of disks covers.

use crate::Shape;
use crowd_mechanics::engine::{Rotation, vec2};
use std::f64::consts::PI;

/// \[m²\] Area of the union of a shape's disks, exact: the arcs of its boundary by Green's theorem.
pub fn union_area(shape: &Shape) -> f64 {
    let mut twice_area = 0.0;
    for (k, disk) in shape.disks.iter().enumerate() {
        // The angles at which the disk's circle runs inside another disk.
        let mut hidden: Vec<(f64, f64)> = Vec::new();
        let mut swallowed = false;
        for (j, other) in shape.disks.iter().enumerate().filter(|(j, _)| *j != k) {
            let to = other.centre - disk.centre;
            let distance = to.norm();
            if distance + disk.radius <= other.radius {
                // Of two that are the same, the later one counts.
                swallowed |= distance + other.radius > disk.radius || j > k;
            } else if distance < disk.radius + other.radius && distance + other.radius > disk.radius {
                let (r, s) = (disk.radius, other.radius);
                let cosine = (distance * distance + r * r - s * s) / (2.0 * distance * r);
                let (middle, half) = (libm::atan2(to.y, to.x), libm::acos(cosine.clamp(-1.0, 1.0)));
                let (from, to) = (middle - half, middle + half);
                // Cut at the ends of (−π, π].
                if from < -PI {
                    hidden.extend([(-PI, to), (from + 2.0 * PI, PI)]);
                } else if to > PI {
                    hidden.extend([(from, PI), (-PI, to - 2.0 * PI)]);
                } else {
                    hidden.push((from, to));
                }
            }
        }
        if swallowed {
            continue;
        }
        hidden.push((PI, PI));
        hidden.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut angle = -PI;
        for (from, to) in hidden {
            if from > angle {
                let point = |angle: f64| vec2(1.0, 0.0).rotated(Rotation::by(angle));
                let chord = point(from) - point(angle);
                twice_area += disk.radius * (disk.radius * (from - angle) + disk.centre.cross(chord));
            }
            angle = angle.max(to);
        }
    }
    0.5 * twice_area
}
