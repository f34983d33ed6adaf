//! Bodies in their own frame: facing +x, left shoulder towards +y, centre of mass at the origin.

use crate::plane::near;
use crate::text::{number, pair};
use lemons_core::plane::{Pose, Rotation, Vec2, vec2};
use lemons_core::trial::Agent;
use std::f64::consts::{PI, TAU};

/// \[rad\] Longest arc in one SVG command. Near a half turn the centre would depend on the last digit.
const LONGEST_ARC: f64 = 2.0;
/// \[rad\] Shorter gaps between covering disks are rounding errors.
const SHORTEST_ARC: f64 = 1e-9;
/// Number of decimals of a length in metres.
pub(crate) const TENTH_OF_MM: usize = 4;

/// Returns the area \[m²\] of the union of the agent's disks.
pub fn body_area(agent: &Agent) -> f64 {
    Body::new(agent).area
}

/// The drawing of an agent, not yet placed at a pose.
#[derive(Debug, Clone)]
pub(crate) struct Body {
    /// \[m\] Centre and radius of each disk that can be drawn.
    pub disks: Vec<(Vec2, f64)>,
    /// \[m²\] Area.
    pub area: f64,
    /// \[m\] Distance from the origin to the furthest point.
    pub reach: f64,
    /// \[m\] A point inside: the centre of mass, or the centre of the largest disk.
    pub middle: Vec2,
    /// \[m\] Distance from `middle` straight ahead to the outline.
    pub front: f64,
    /// SVG path of the outline of the union of the disks \[m\].
    pub outline: String,
}

/// An arc of the outline, counter-clockwise.
#[derive(Debug, Clone, Copy)]
struct Arc {
    centre: Vec2,
    radius: f64,
    from: f64,
    to: f64,
}

impl Body {
    pub fn new(agent: &Agent) -> Body {
        let drawable = |(c, r): &(Vec2, f64)| near(*c) && near(vec2(*r, 0.0)) && *r > 0.0;
        let disks: Vec<_> = agent.disks_facing_x().into_iter().filter(drawable).collect();

        let inside = disks.iter().any(|(c, r)| c.norm() < *r);
        let largest = disks.iter().copied().fold((Vec2::ZERO, 0.0), |a, b| if b.1 > a.1 { b } else { a });
        let middle = if inside { Vec2::ZERO } else { largest.0 };
        let ahead = |(c, r): &(Vec2, f64)| {
            let aside = middle.y - c.y;
            (aside.abs() < *r).then(|| c.x - middle.x + (r * r - aside * aside).sqrt())
        };
        let arcs = union_outline(&disks);
        Body {
            area: arcs.iter().map(Arc::area).sum(),
            reach: disks.iter().map(|(c, r)| c.norm() + r).fold(0.0, f64::max),
            front: disks.iter().filter_map(ahead).fold(0.0, f64::max),
            outline: path(arcs),
            middle,
            disks,
        }
    }

    /// \[m\] Centre and radius of each disk, in the world.
    pub fn disks_at(&self, pose: &Pose) -> impl Iterator<Item = (Vec2, f64)> {
        let (turn, at) = (Rotation::by(pose.orientation), pose.position);
        self.disks.iter().map(move |(c, r)| (at + c.rotated(turn), *r))
    }
}

impl Arc {
    fn at(&self, angle: f64) -> Vec2 {
        self.centre + vec2(self.radius, 0.0).rotated(Rotation::by(angle))
    }

    /// \[m²\] Its contribution to the enclosed area, ½ ∮ (x dy − y dx).
    fn area(&self) -> f64 {
        let chord = self.at(self.to) - self.at(self.from);
        0.5 * (self.radius * self.radius * (self.to - self.from) + self.centre.cross(chord))
    }
}

/// The arcs of the disks' circles that no other disk covers.
fn union_outline(disks: &[(Vec2, f64)]) -> Vec<Arc> {
    let mut arcs = Vec::new();
    'disk: for (i, &(centre, radius)) in disks.iter().enumerate() {
        // Covered arcs: start and length of each.
        let mut covered: Vec<(f64, f64)> = Vec::new();
        for (j, &(other, other_radius)) in disks.iter().enumerate() {
            let between = other - centre;
            let d = between.norm();
            let same = d == 0.0 && other_radius == radius;
            if i == j || (same && i < j) || d >= radius + other_radius || d < radius - other_radius {
                continue;
            }
            if d <= other_radius - radius {
                continue 'disk;
            }
            let cos = (d * d + radius * radius - other_radius * other_radius) / (2.0 * d * radius);
            let half = libm::acos(cos.clamp(-1.0, 1.0));
            covered.push((libm::atan2(between.y, between.x) - half, 2.0 * half));
        }
        let Some(&(begin, length)) = covered.first() else {
            arcs.push(Arc { centre, radius, from: -PI, to: PI });
            continue;
        };
        // Measure angles from the end of the first covered arc, so that no uncovered arc is split.
        let origin = begin + length;
        let turn = |(begin, length): &(f64, f64)| ((begin - origin).rem_euclid(TAU), *length);
        let mut pieces: Vec<_> = covered.iter().skip(1).map(turn).collect();
        pieces.push((TAU - length, length));
        pieces.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut reached = pieces.iter().map(|(b, l)| b + l - TAU).fold(0.0, f64::max);
        for (begin, length) in pieces {
            if begin - reached > SHORTEST_ARC {
                arcs.push(Arc { centre, radius, from: origin + reached, to: origin + begin });
            }
            reached = reached.max(begin + length);
        }
    }
    arcs
}

/// Connects the arcs to closed curves: each ends where another begins.
fn path(mut arcs: Vec<Arc>) -> String {
    let mut d = String::new();
    while let Some(first) = arcs.pop() {
        let start = first.at(first.from);
        d.push('M');
        point(&mut d, start);
        let mut arc = first;
        loop {
            let pieces = ((arc.to - arc.from) / LONGEST_ARC).ceil().max(1.0);
            for k in 1..=pieces as usize {
                d.push('A');
                number(&mut d, arc.radius, TENTH_OF_MM);
                d.push(' ');
                number(&mut d, arc.radius, TENTH_OF_MM);
                d.push_str(" 0 01");
                point(&mut d, arc.at(arc.from + (arc.to - arc.from) * (k as f64 / pieces)));
            }
            let end = arc.at(arc.to);
            let gap = |p: Vec2| (p - end).norm_squared();
            let next = (0..arcs.len())
                .map(|k| (gap(arcs[k].at(arcs[k].from)), k))
                .min_by(|a, b| a.0.total_cmp(&b.0));
            match next {
                Some((distance, k)) if distance < gap(start) => arc = arcs.swap_remove(k),
                _ => break,
            }
        }
        d.push('Z');
    }
    d
}

/// Writes a line through points \[m\].
pub(crate) fn polyline(d: &mut String, points: &[Vec2]) {
    for (k, p) in points.iter().enumerate() {
        d.push(if k == 0 { 'M' } else { 'L' });
        point(d, *p);
    }
}

/// Writes a point \[m\].
pub(crate) fn point(d: &mut String, p: Vec2) {
    pair(d, (p.x, p.y), TENTH_OF_MM);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(disks: &[(Vec2, f64)]) -> f64 {
        union_outline(disks).iter().map(Arc::area).sum()
    }

    #[test]
    fn areas_of_unions() {
        let at = |x: f64| (vec2(x, 0.3), 1.0);
        let lens = 2.0 * PI / 3.0 - 3f64.sqrt() / 2.0;
        for (disks, expected) in [
            (vec![at(0.0)], PI),
            (vec![at(0.0), at(0.0), at(0.0)], PI),
            (vec![at(0.0), at(5.0)], TAU),
            (vec![at(0.0), (vec2(0.1, 0.3), 0.2)], PI),
            (vec![at(0.0), at(2.0)], TAU),
            (vec![at(0.0), at(1.0)], TAU - lens),
            (vec![], 0.0),
        ] {
            assert!((area(&disks) - expected).abs() < 1e-12, "{disks:?}");
        }
    }

    #[test]
    fn a_ring_of_disks_has_a_hole() {
        let ring: Vec<_> =
            (0..12).map(|k| (vec2(1.0, 0.0).rotated(Rotation::by(f64::from(k) * TAU / 12.0)), 0.3)).collect();
        assert_eq!(path(union_outline(&ring)).matches('M').count(), 2);
    }
}
