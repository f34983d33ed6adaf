//! The quality of a placing: overlaps and density, computed again from the poses.

use super::hull::hull_area;
use super::neighbours::CellGrid;
use super::{Region, TOLERANCE, reach};
use crate::shape::Shape;
use lemons_core::plane::{Disk, Pose, Vec2};

/// The quality of a placing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measure {
    /// \[m\] Largest overlap of disks of two shapes, or of a disk and the boundary; 0 if there is none.
    pub largest_overlap: f64,
    /// \[1/m²\] Number of shapes per area of the region; in the open plane, per area of the convex hull of all disks.
    pub density: f64,
    /// \[1/m²\] Density of the shapes that remain if, one after the other, the shape with the largest overlap is
    /// removed until no overlap exceeds [`TOLERANCE`].
    pub clear_density: f64,
}

/// Measures shapes at poses: one finite pose for each shape.
pub fn measure(shapes: &[Shape], region: &Region, poses: &[Pose]) -> Measure {
    let disks: Vec<Vec<Disk>> = shapes.iter().zip(poses).map(|(s, p)| s.placed(p).collect()).collect();
    let overlaps = Overlaps::of(shapes, region, poses, &disks);
    let largest = overlaps.largest();
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
    Measure {
        largest_overlap: largest,
        density: density(region, &disks),
        clear_density: density(region, &clear),
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
        Overlaps { boundary, pairs: overlapping_pairs(shapes, poses, disks) }
    }

    /// \[m\] 0 if there are none.
    pub(super) fn largest(&self) -> f64 {
        self.pairs.iter().map(|pair| pair.2).chain(self.boundary.iter().copied()).fold(0.0, f64::max)
    }
}

fn overlapping_pairs(shapes: &[Shape], poses: &[Pose], disks: &[Vec<Disk>]) -> Vec<(usize, usize, f64)> {
    let centres: Vec<Vec2> = poses.iter().map(|p| p.position).collect();
    let reaches: Vec<f64> = shapes.iter().map(reach).collect();
    let grid = CellGrid::new(&centres, 2.0 * reaches.iter().copied().fold(0.0, f64::max));
    let mut found = Vec::new();
    for a in 0..disks.len() {
        grid.for_each_near(centres[a], |b| {
            let reach = reaches[a] + reaches[b];
            if b > a && (centres[a] - centres[b]).norm_squared() < reach * reach {
                let overlap = overlap(&disks[a], &disks[b]);
                if overlap > 0.0 {
                    found.push((a, b, overlap));
                }
            }
        });
    }
    found
}

fn density(region: &Region, disks: &[Vec<Disk>]) -> f64 {
    if disks.is_empty() {
        return 0.0;
    }
    let area = if region.is_plane() { hull_area(&disks.concat()) } else { region.area() };
    disks.len() as f64 / area
}
