//! Bodies in their own frame: facing +x, left shoulder towards +y, centre of mass at the origin.

use crate::text::{number, pair};
use lemons_core::plane::{Arc, Disk, Pose, Vec2, boundary, rotation, union, vec2};
use lemons_core::trial::Agent;
use std::f64::consts::{PI, TAU};

/// \[m\] Points further from the origin are not drawn, nor are points that are not finite. Decimals and the
/// rasterizer's single precision are not sufficient there.
const FARTHEST: f64 = 1e6;
/// \[rad\] Longest arc in one SVG command. Near a half turn the centre would depend on the last digit.
const LONGEST_ARC: f64 = 2.0;
/// \[rad\] Shorter gaps between covering disks are rounding errors.
const SHORTEST_ARC: f64 = 1e-9;
/// Number of decimals of a length in metres.
pub(crate) const TENTH_OF_MM: usize = 4;

/// Returns whether a point can be drawn.
pub(crate) fn near(p: Vec2) -> bool {
    p.x.abs() <= FARTHEST && p.y.abs() <= FARTHEST
}

/// Returns whether a body at this pose can be drawn.
pub(crate) fn drawable(pose: &Pose) -> bool {
    near(pose.position) && pose.orientation.is_finite()
}

/// The drawing of an agent, not yet placed at a pose.
#[derive(Debug, Clone)]
pub(crate) struct DrawnBody {
    /// The disks that can be drawn.
    pub disks: Vec<Disk>,
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
    /// Kind of person, if the Trial says it.
    pub kind: Option<String>,
}

impl DrawnBody {
    /// At a height \[m\], it is the disks that are there.
    pub fn new(agent: &Agent, height: Option<f64>) -> DrawnBody {
        let disks = agent.disks_facing_x().into_iter().zip(&agent.shapes);
        let disks = disks.filter(|(_, shape)| height.is_none_or(|height| shape.heights.hold(height)));
        let disks = disks.map(|((centre, radius), _)| Disk { radius, centre });
        let disks: Vec<Disk> =
            disks.filter(|d| near(d.centre) && near(vec2(d.radius, 0.0)) && d.radius > 0.0).collect();
        let inside = disks.iter().any(|d| d.centre.norm() < d.radius);
        let largest = disks.iter().copied().reduce(|a, b| if b.radius > a.radius { b } else { a });
        let middle = largest.filter(|_| !inside).map_or(Vec2::zeros(), |disk| disk.centre);
        let ahead = |d: &Disk| {
            let aside = middle.y - d.centre.y;
            let half = d.radius * d.radius - aside * aside;
            (aside.abs() < d.radius).then(|| d.centre.x - middle.x + half.sqrt())
        };
        DrawnBody {
            area: union(&disks).area,
            reach: disks.iter().map(|d| d.centre.norm() + d.radius).fold(0.0, f64::max),
            front: disks.iter().filter_map(ahead).fold(0.0, f64::max),
            outline: outline(&disks),
            kind: agent.kind.clone(),
            middle,
            disks,
        }
    }

    /// Returns the disks in the plane.
    pub fn disks_at(&self, pose: &Pose) -> impl Iterator<Item = Disk> {
        let (turn, at) = (rotation(pose.orientation), pose.position);
        self.disks.iter().map(move |d| Disk { centre: at + turn * d.centre, ..*d })
    }
}

/// Returns the boundary of the union as closed curves: each arc ends where another begins.
fn outline(disks: &[Disk]) -> String {
    let mut arcs: Vec<Arc> = Vec::new();
    for own in boundary(disks).chunk_by(|a, b| a.disk == b.disk) {
        match own {
            [circle] if circle.to - circle.from == TAU => arcs.push(Arc { from: -PI, to: PI, ..*circle }),
            // An arc across angle 0 comes in two parts.
            [first, middle @ .., last] if first.from == 0.0 && last.to == TAU => {
                arcs.extend(middle);
                arcs.push(Arc { to: TAU + first.to, ..*last });
            }
            _ => arcs.extend(own),
        }
    }
    arcs.retain(|arc| arc.to - arc.from > SHORTEST_ARC);
    let at = |arc: &Arc, angle: f64| {
        let Disk { centre, radius } = disks[arc.disk];
        centre + rotation(angle) * vec2(radius, 0.0)
    };
    let mut d = String::new();
    while let Some(mut arc) = arcs.pop() {
        let start = at(&arc, arc.from);
        d.push('M');
        point(&mut d, start);
        loop {
            let pieces = ((arc.to - arc.from) / LONGEST_ARC).ceil().max(1.0);
            for k in 1..=pieces as usize {
                d.push('A');
                pair(&mut d, (disks[arc.disk].radius, disks[arc.disk].radius), TENTH_OF_MM);
                d.push_str(" 0 01");
                point(&mut d, at(&arc, arc.from + (arc.to - arc.from) * (k as f64 / pieces)));
            }
            let end = at(&arc, arc.to);
            let gap = |p: Vec2| (p - end).norm_squared();
            let next = (0..arcs.len()).map(|k| (gap(at(&arcs[k], arcs[k].from)), k));
            match next.min_by(|a, b| a.0.total_cmp(&b.0)) {
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

/// Begins a group in the frame of a body at this pose; its `>` is left to the caller.
pub(crate) fn begin_at(out: &mut String, pose: &Pose) {
    *out += "<g transform=\"translate(";
    point(out, pose.position);
    *out += &format!(")rotate({})\"", number(pose.orientation.rem_euclid(TAU).to_degrees(), 2));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ring_of_disks_has_a_hole() {
        let centre = |k: u32| rotation(f64::from(k) * TAU / 12.0) * vec2(1.0, 0.0);
        let ring: Vec<Disk> = (0..12).map(|k| Disk { radius: 0.3, centre: centre(k) }).collect();
        assert_eq!(outline(&ring).matches('M').count(), 2);
    }
}
