//! Exact area, centroid and moment of inertia of the union of disks.
//!
//! The boundary consists of arcs of circles. By Green's theorem each integral over the union is an integral over these
//! arcs, which has a closed form. The paper (App. A.2) uses a polygon instead; the tests compare with its formula.

use crate::plane::Vec2;
use std::f64::consts::TAU;

/// A disk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disk {
    /// \[m\] radius, positive.
    pub radius: f64,
    /// \[m\] centre.
    pub centre: Vec2,
}

/// Integrals over a plane figure, per unit of density.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moments {
    /// \[m²\] area.
    pub area: f64,
    /// \[m\] centroid: the mean of its points.
    pub centroid: Vec2,
    /// \[m⁴\] second polar moment about the centroid: the moment of inertia is this × mass / area.
    pub polar: f64,
}

/// An uncovered piece of a disk's circle, counter-clockwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arc {
    /// Place of the disk.
    pub disk: usize,
    /// \[rad\] start.
    pub from: f64,
    /// \[rad\] end.
    pub to: f64,
}

/// Returns the boundary of the union, disk by disk, from angle 0 to 2π. Disks without a positive radius are left out.
pub fn boundary(disks: &[Disk]) -> Vec<Arc> {
    let mut inside: Vec<bool> = disks.iter().map(|disk| disk.radius.is_nan() || disk.radius <= 0.0).collect();
    // [rad] Covered pieces of each circle: start in 0…2π, and end.
    let mut covered: Vec<Vec<(f64, f64)>> = vec![Vec::new(); disks.len()];
    for second in 0..disks.len() {
        for first in 0..second {
            let (r, s) = (disks[first].radius, disks[second].radius);
            let offset = disks[second].centre - disks[first].centre;
            let distance = libm::hypot(offset.x, offset.y);
            if inside[first] || inside[second] || distance >= r + s {
                continue;
            }
            // Of two equal disks, the second counts as inside.
            if distance <= r - s {
                inside[second] = true;
                continue;
            }
            if distance <= s - r {
                inside[first] = true;
                continue;
            }
            // Both circles use the same pair of points. So the boundary is closed even where the circles nearly touch
            // and the points are ill-conditioned: along ± across from the first centre, at both radii up to rounding.
            let along = 0.5 * (distance + (r - s) * (r + s) / distance);
            let across = ((r - along) * (r + along)).max(0.0).sqrt();
            let towards = libm::atan2(offset.y, offset.x);
            let back = libm::atan2(-offset.y, -offset.x);
            for (disk, middle, half) in [
                (first, towards, libm::atan2(across, along)),
                (second, back, libm::atan2(across, distance - along)),
            ] {
                let mut start = middle - half;
                if start < 0.0 {
                    start += TAU;
                }
                covered[disk].push((start, start + 2.0 * half));
            }
        }
    }
    let mut arcs = Vec::new();
    for (disk, mut covered) in covered.into_iter().enumerate() {
        if inside[disk] {
            continue;
        }
        covered.sort_by(|a, b| a.0.total_cmp(&b.0));
        // A part beyond 2π covers the start of the circle.
        let mut reached = covered.iter().map(|&(_, end)| end - TAU).fold(0.0, f64::max);
        for (start, end) in covered {
            if start > reached {
                arcs.push(Arc { disk, from: reached, to: start });
            }
            reached = reached.max(end);
        }
        if reached < TAU {
            arcs.push(Arc { disk, from: reached, to: TAU });
        }
    }
    arcs
}

/// Returns the area, its first moments and its second polar moment about the point `about`.
fn integrals(disks: &[Disk], arcs: &[Arc], about: Vec2) -> (f64, Vec2, f64) {
    let (mut area, mut first, mut polar) = (0.0, Vec2::zeros(), 0.0);
    for arc in arcs {
        let r = disks[arc.disk].radius;
        let c = disks[arc.disk].centre - about;
        let turn = arc.to - arc.from;
        let ((s0, c0), (s1, c1)) = (libm::sincos(arc.from), libm::sincos(arc.to));
        // Integrals over the arc of cos t, sin t, cos² t, sin² t, sin t cos t.
        let (cos, sin) = (s1 - s0, c0 - c1);
        let swing = 0.5 * (s1 * c1 - s0 * c0);
        let (cos2, sin2) = (0.5 * turn + swing, 0.5 * turn - swing);
        let sincos = 0.5 * (s1 - s0) * (s1 + s0);
        // On the arc x dy − y dx = (r² + r p) dt with p = c·(cos t, sin t).
        let p = c.x * cos + c.y * sin;
        let p2 = c.x * c.x * cos2 + 2.0 * c.x * c.y * sincos + c.y * c.y * sin2;
        let sector = r * r * turn + r * p;
        // ½∮ (x dy − y dx), ⅓∮ x (x dy − y dx), ¼∮ (x² + y²)(x dy − y dx)
        area += 0.5 * sector;
        first.x += (c.x * sector + r * r * (r * cos + c.x * cos2 + c.y * sincos)) / 3.0;
        first.y += (c.y * sector + r * r * (r * sin + c.x * sincos + c.y * sin2)) / 3.0;
        polar += 0.25 * ((c.norm_squared() + r * r) * sector + 2.0 * r * r * (r * p + p2));
    }
    (area, first, polar)
}

/// Returns the integrals over the union of disks. They may be apart, touch, contain each other, be equal, or enclose
/// holes. Disks without a positive radius are left out. If there is no area, all results are zero.
pub fn union(disks: &[Disk]) -> Moments {
    let arcs = boundary(disks);
    // Relative to a point near the centroid, so that no digits are lost far from the origin.
    let near = arcs.first().map_or(Vec2::zeros(), |arc| disks[arc.disk].centre);
    let (area, first, _) = integrals(disks, &arcs, near);
    if area <= 0.0 {
        return Moments { area: 0.0, centroid: Vec2::zeros(), polar: 0.0 };
    }
    let centroid = near + first * (1.0 / area);
    let (area, rest, polar) = integrals(disks, &arcs, centroid);
    // The centroid is known up to rounding; this removes the rest.
    let rest = rest * (1.0 / area);
    Moments { area, centroid: centroid + rest, polar: polar - area * rest.norm_squared() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::vec2;
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;
    use std::f64::consts::PI;

    fn disk(x: f64, y: f64, radius: f64) -> Disk {
        Disk { radius, centre: vec2(x, y) }
    }

    /// Sums over strips along y, each the union of the disks' intervals: shares nothing with the arcs.
    fn strips(disks: &[Disk], count: u32) -> Moments {
        let low = disks.iter().map(|disk| disk.centre.y - disk.radius).fold(f64::INFINITY, f64::min);
        let high = disks.iter().map(|disk| disk.centre.y + disk.radius).fold(f64::NEG_INFINITY, f64::max);
        let height = (high - low) / f64::from(count);
        let (mut area, mut first, mut second) = (0.0, Vec2::zeros(), 0.0);
        for strip in 0..count {
            let y = low + (f64::from(strip) + 0.5) * height;
            let mut pieces: Vec<(f64, f64)> = Vec::new();
            for disk in disks {
                let square = disk.radius.powi(2) - (y - disk.centre.y).powi(2);
                if square > 0.0 {
                    pieces.push((disk.centre.x - square.sqrt(), disk.centre.x + square.sqrt()));
                }
            }
            pieces.sort_by(|a, b| a.0.total_cmp(&b.0));
            let mut end = f64::NEG_INFINITY;
            for (from, to) in pieces {
                let from = from.max(end);
                if to > from {
                    area += (to - from) * height;
                    first.x += 0.5 * (to * to - from * from) * height;
                    first.y += y * (to - from) * height;
                    second += ((to.powi(3) - from.powi(3)) / 3.0 + y * y * (to - from)) * height;
                    end = to;
                }
            }
        }
        let centroid = first * (1.0 / area);
        Moments { area, centroid, polar: second - area * centroid.norm_squared() }
    }

    /// Relative to the size of the whole.
    fn difference(a: Moments, b: Moments) -> f64 {
        let gyration = (b.polar / b.area).sqrt();
        let centroid = (a.centroid - b.centroid).norm() / gyration;
        (a.area / b.area - 1.0).abs().max((a.polar / b.polar - 1.0).abs()).max(centroid)
    }

    #[test]
    fn a_disk_and_a_lens_have_closed_forms() {
        let (x, y, r) = (3.0, -4.0, 0.25);
        let one = union(&[disk(x, y, r)]);
        let closed = Moments { area: PI * r * r, centroid: vec2(x, y), polar: 0.5 * PI * r.powi(4) };
        assert!(difference(one, closed) < 1e-14, "{one:?}");
        // Two equal disks at ±d: twice a disk less the lens of half angle a, cos a = d/r.
        for d in [0.001, 0.1, 0.2, 0.249_999_999] {
            let a = (d / r).acos();
            let area = 2.0 * r * r * (PI - a + a.sin() * a.cos());
            let (s, c) = (0.7f64).sin_cos();
            let two = union(&[disk(x - d * c, y - d * s, r), disk(x + d * c, y + d * s, r)]);
            assert!((two.area / area - 1.0).abs() < 1e-13, "{d}: {two:?} {area}");
            assert!((two.centroid - vec2(x, y)).norm() < 1e-13, "{d}: {two:?}");
        }
    }

    #[test]
    fn unions_of_all_kinds_are_those_of_fine_strips() {
        let ring: Vec<Disk> = (0..12)
            .map(|k| (f64::from(k) * TAU / 12.0).sin_cos())
            .map(|(s, c)| disk(2.0 + c, 1.0 + s, 0.3))
            .collect();
        let mut island = ring.clone();
        island.extend([disk(2.0, 1.0, 0.2), disk(2.1, 1.0, 0.2), disk(2.05, 1.05, 0.05)]);
        let of = |disks: &[(f64, f64, f64)]| disks.iter().map(|&(x, y, r)| disk(x, y, r)).collect::<Vec<_>>();
        let cases = [
            ("ring with a hole", ring),
            ("island in a hole", island),
            ("inside", of(&[(0.0, 0.0, 1.0), (0.2, 0.1, 0.5), (0.9, 0.0, 0.3)])),
            ("inside, touching", of(&[(0.5, 0.0, 0.5), (0.0, 0.0, 1.0)])),
            ("touching", of(&[(0.0, 0.0, 1.0), (1.5, 0.0, 0.5), (0.0, 2.0, 1.0)])),
            ("the same", of(&[(0.1, 0.2, 0.7); 5])),
            ("apart", of(&[(-5.0, 0.0, 0.5), (6.0, 3.0, 1.0)])),
            ("nearly the same", of(&[(0.0, 0.0, 1.0), (1e-15, 0.0, 1.0), (0.0, 1e-9, 1.0)])),
            ("nearly inside", of(&[(0.0, 0.0, 1.0), (0.5, 0.0, 0.5 + 1e-12)])),
            ("nearly touching", of(&[(0.0, 0.0, 1.0), (2.0 - 1e-12, 0.0, 1.0)])),
            (
                "through one point",
                (0..5).map(|k| f64::from(k).sin_cos()).map(|(s, c)| disk(c, s, 1.0)).collect(),
            ),
        ];
        for (name, disks) in cases {
            let (ours, theirs) = (union(&disks), strips(&disks, 400_000));
            assert!(difference(ours, theirs) < 1e-6, "{name}: {ours:?} {theirs:?}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 60, rng_seed: RngSeed::Fixed(7), ..ProptestConfig::default() })]

        /// In any order, and with disks that others cover.
        #[test]
        fn random_unions_are_those_of_fine_strips(
            disks in prop::collection::vec((9.0..11.0, -1.0..1.0, 0.02..0.6), 1..13),
        ) {
            let disks: Vec<Disk> = disks.iter().map(|&(x, y, radius)| disk(x, y, radius)).collect();
            let whole = union(&disks);
            prop_assert!(difference(whole, strips(&disks, 200_000)) < 1e-6);
            let mut more: Vec<Disk> = disks.iter().rev().copied().collect();
            more.extend(disks.iter().map(|disk| Disk { radius: 0.9 * disk.radius, ..*disk }));
            more.extend([disks[0], disk(50.0, 0.0, -1.0)]);
            prop_assert!(difference(union(&more), whole) < 1e-12);
        }
    }
}
