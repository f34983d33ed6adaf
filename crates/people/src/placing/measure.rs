//! The quality of a placing: overlaps and density, computed again from the poses.

use super::hull::hull_area;
use super::neighbours::CellGrid;
use super::{Ended, Packing, Region, TOLERANCE, reach};
use crate::shape::Shape;
use lemons_core::plane::{Disk, Pose, Vec2};

impl Packing {
    /// Measures shapes at poses, a finite one for each. The placing is complete if nothing overlaps.
    pub fn of(shapes: &[Shape], region: &Region, poses: Vec<Pose>, ended: Ended, iterations: u64) -> Packing {
        let disks: Vec<Vec<Disk>> = shapes.iter().zip(&poses).map(|(s, p)| s.placed(p).collect()).collect();
        let overlaps = Overlaps::of(shapes, region, &poses, &disks);
        let largest_overlap = overlaps.largest();
        let Overlaps { boundary: mut sum, pairs } = overlaps;

        // For each shape: the sum of its overlaps, and the shapes that it overlaps.
        let mut partners = vec![Vec::new(); disks.len()];
        for &(a, b, overlap) in pairs.iter().filter(|p| p.2 > TOLERANCE) {
            for (one, other) in [(a, b), (b, a)] {
                sum[one] += overlap;
                partners[one].push((other, overlap));
            }
        }
        let mut left = vec![true; disks.len()];
        let worst = |sum: &[f64], left: &[bool]| {
            let overlaps = (0..sum.len()).filter(|&k| left[k] && sum[k] > TOLERANCE);
            overlaps.max_by(|&a, &b| sum[a].total_cmp(&sum[b]))
        };
        while let Some(worst) = worst(&sum, &left) {
            left[worst] = false;
            partners[worst].iter().for_each(|&(other, overlap): &(usize, f64)| sum[other] -= overlap);
        }
        let clear: Vec<Vec<Disk>> =
            disks.iter().zip(&left).filter(|(_, l)| **l).map(|(d, _)| d.clone()).collect();
        Packing {
            poses,
            density: density(region, &disks),
            clear_density: density(region, &clear),
            largest_overlap,
            complete: largest_overlap <= TOLERANCE,
            ended,
            iterations,
        }
    }
}

/// \[m\] Largest distance by which a disk reaches through the boundary.
pub(super) fn through_boundary(region: &Region, disks: &[Disk]) -> f64 {
    if region.is_plane() {
        return 0.0;
    }
    disks.iter().map(|d| d.radius - region.depth(d.centre)).fold(0.0, f64::max)
}

/// \[m\] Largest overlap of a disk of one shape with a disk of another; negative if the shapes are apart.
pub(super) fn overlap(a: &[Disk], b: &[Disk]) -> f64 {
    let of = |p: &Disk, q: &Disk| p.radius + q.radius - (p.centre - q.centre).norm();
    a.iter().flat_map(|p| b.iter().map(move |q| of(p, q))).fold(f64::NEG_INFINITY, f64::max)
}

/// The overlaps \[m\] of shapes.
pub(super) struct Overlaps {
    /// Of each shape with the boundary.
    boundary: Vec<f64>,
    /// Two shapes that overlap, the lower place first, and by how much.
    pairs: Vec<(usize, usize, f64)>,
}

impl Overlaps {
    pub(super) fn of(shapes: &[Shape], region: &Region, poses: &[Pose], disks: &[Vec<Disk>]) -> Overlaps {
        let boundary = disks.iter().map(|d| through_boundary(region, d)).collect();
        let centres: Vec<Vec2> = poses.iter().map(|p| p.position).collect();
        let reaches: Vec<f64> = shapes.iter().map(reach).collect();
        let grid = CellGrid::new(&centres, 2.0 * reaches.iter().copied().fold(0.0, f64::max));
        let mut pairs = Vec::new();
        for a in 0..disks.len() {
            grid.for_each_near(centres[a], |b| {
                let reach = reaches[a] + reaches[b];
                if b > a && (centres[a] - centres[b]).norm_squared() < reach * reach {
                    let overlap = overlap(&disks[a], &disks[b]);
                    pairs.extend((overlap > 0.0).then_some((a, b, overlap)));
                }
            });
        }
        Overlaps { boundary, pairs }
    }

    /// \[m\] 0 if there are none.
    pub(super) fn largest(&self) -> f64 {
        self.pairs.iter().map(|pair| pair.2).chain(self.boundary.iter().copied()).fold(0.0, f64::max)
    }
}

/// \[1/m²\] Number of shapes per area of the region, or of their convex hull in the open plane.
pub(super) fn density(region: &Region, disks: &[Vec<Disk>]) -> f64 {
    if disks.is_empty() {
        return 0.0;
    }
    let area = if region.is_plane() { hull_area(&disks.concat()) } else { region.area() };
    disks.len() as f64 / area
}
