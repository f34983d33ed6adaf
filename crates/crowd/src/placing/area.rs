//! The area that a union of disks covers.

use crate::shape::Shape;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::disk::Disk;

    fn area(disks: &[(f64, f64, f64)]) -> f64 {
        let disk = |&(x, y, radius): &(f64, f64, f64)| Disk { radius, centre: vec2(x, y) };
        union_area(&Shape { disks: disks.iter().map(disk).collect() })
    }

    #[test]
    fn closed_forms() {
        let close = |disks: &[(f64, f64, f64)], expected: f64| {
            assert!((area(disks) - expected).abs() < 1e-12, "{disks:?} {} {expected}", area(disks));
        };
        close(&[(1.0, 2.0, 0.5)], 0.25 * PI);
        close(&[(0.0, 0.0, 1.0), (5.0, 0.0, 2.0)], 5.0 * PI);
        close(&[(0.0, 0.0, 1.0), (0.0, 0.0, 1.0), (0.2, 0.1, 0.3)], PI);
        // Unit disks with their centres a radius apart: the lens is 2π/3 − √3/2.
        let lens = 2.0 * PI / 3.0 - 0.75f64.sqrt();
        close(&[(0.0, 0.0, 1.0), (1.0, 0.0, 1.0)], 2.0 * PI - lens);
        close(&[(0.0, 0.0, 1.0), (-1.0, 0.0, 1.0)], 2.0 * PI - lens);
    }

    /// The paper's template covers 1458.8 cm².
    #[test]
    fn template() {
        let template = [
            (-20.4246, -2.0143, 10.4346),
            (-8.9625, 0.6363, 14.3492),
            (0.0, 1.1674, 15.0),
            (8.9625, 0.6363, 14.3492),
            (20.4246, -2.0143, 10.4346),
        ];
        assert!((area(&template) - 1458.8).abs() < 0.1, "{}", area(&template));
    }
}
