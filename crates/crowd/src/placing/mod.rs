//! Placing shapes: on a [`grid()`], by the [`paper()`]'s algorithm, or [`dense()`]ly without overlap.

mod dense;
mod fire;
mod grid;
mod hull;
mod measure;
mod neighbours;
mod paper;
mod pile;
mod random;
mod region;

use crate::shape::Shape;
use crowd_mechanics::engine::{Pose, Rotation, Vec2};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

pub use dense::{Dense, dense};
pub use grid::{Grid, grid};
pub use measure::{Measure, measure};
pub use paper::{Paper, paper};
pub use region::{Region, RegionError};

/// \[m\] Shapes that overlap by no more are placed well: far less than clothes give.
pub const TOLERANCE: f64 = 1e-4;

/// \[m\] Largest size of a shape, larger than any person or bicycle.
const LARGEST: f64 = 100.0;

/// Which way the shapes face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Orientation {
    /// Any way.
    Free,
    /// \[rad\] Exactly this way.
    Fixed(f64),
    /// \[rad\] This way to begin with; free to turn as the others press.
    Towards(f64),
}

/// How far a placer is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// What it is at.
    pub stage: Stage,
    /// Iterations done.
    pub iteration: u64,
    /// It stops at this iteration at the latest.
    pub limit: u64,
    /// \[m\] by which disks overlap each other or the boundary, at their size of the moment; 0 when none does.
    pub overlap: f64,
    /// \[1/m²\] at which the shapes stand, their size of the moment counted.
    pub density: f64,
}

/// What a placer is at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Shapes grow to their size.
    Growing,
    /// Shapes of full size push each other apart.
    Spreading,
    /// Those that overlap are moved elsewhere.
    Shaking,
    /// A crowd in the open is pressed together.
    Pressing,
    /// Too many for the region: how many can stand is found by taking some away.
    Thinning,
}

/// Why a placer stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// All stand where they should.
    Done,
    /// Further attempts no longer helped.
    Stuck,
    /// At the limit of iterations.
    Exhausted,
    /// The caller broke off.
    Cancelled,
}

/// Where shapes were placed.
#[derive(Debug, Clone, PartialEq)]
pub struct Packing {
    /// In the order of the shapes.
    pub poses: Vec<Pose>,
    /// \[1/m²\] shapes per area of the region; in the open plane, per area of the convex hull of all disks.
    pub density: f64,
    /// \[1/m²\] the same of those that are left when the shapes with most overlap are taken away until none overlaps by
    /// more than [`TOLERANCE`].
    pub clear_density: f64,
    /// \[m\] largest overlap of disks of two shapes, or of a disk and the boundary; 0 when none overlaps.
    pub largest_overlap: f64,
    /// Whether no overlap exceeds [`TOLERANCE`] and the density asked for is reached.
    pub complete: bool,
    /// Why it stopped.
    pub ended: Ended,
    /// Iterations done.
    pub iterations: u64,
}

/// Shapes that cannot be placed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlacingError {
    /// A shape without disks.
    #[error("shape {shape} has no disks")]
    NoDisks {
        /// Its place among the shapes.
        shape: usize,
    },
    /// NaN, infinite, not positive or too large.
    #[error(
        "shape {shape}, disk {disk}: radius {radius} m at ({x}, {y}) m; a positive radius and a size up to {LARGEST} m are needed"
    )]
    Disk {
        /// Its place among the shapes.
        shape: usize,
        /// Its place among the disks of the shape.
        disk: usize,
        /// \[m\]
        radius: f64,
        /// \[m\]
        x: f64,
        /// \[m\]
        y: f64,
    },
    /// A setting out of its range.
    #[error("{name} is {value}; {wanted}")]
    Setting {
        /// Of the setting.
        name: &'static str,
        /// As given.
        value: f64,
        /// What it may be.
        wanted: &'static str,
    },
    /// The shapes cover more than the whole region.
    #[error(
        "{shapes} shapes cover {covered:.3} m², the region has {area:.3} m²: it cannot hold them without overlap"
    )]
    NoRoom {
        /// How many.
        shapes: usize,
        /// \[m²\] sum of their areas.
        covered: f64,
        /// \[m²\] of the region.
        area: f64,
    },
    /// Not enough shapes for a density.
    #[error("a density of {density} /m² on {area:.3} m² needs {needed} shapes; {given} are given")]
    TooFewShapes {
        /// \[1/m²\] as asked for.
        density: f64,
        /// \[m²\] of the region.
        area: f64,
        /// For that density.
        needed: u64,
        /// As given.
        given: usize,
    },
    /// A grid with fewer places than shapes.
    #[error(
        "the grid has {places} places {along:.3} m × {across:.3} m in the region; {shapes} shapes are given"
    )]
    NoPlaces {
        /// That lie inside the region.
        places: usize,
        /// \[m\] spacing along the direction.
        along: f64,
        /// \[m\] spacing across the direction.
        across: f64,
        /// As given.
        shapes: usize,
    },
    /// A grid narrower than what stands on it.
    #[error("a grid of {along:.3} m × {across:.3} m is too narrow: shapes on it overlap by {overlap:.4} m")]
    TooNarrow {
        /// \[m\] spacing along the direction.
        along: f64,
        /// \[m\] spacing across the direction.
        across: f64,
        /// \[m\] largest overlap.
        overlap: f64,
    },
}

/// A circle somewhere.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Circle {
    /// \[m\]
    centre: Vec2,
    /// \[m\]
    radius: f64,
}

/// What is called as a placer goes on; `Break` makes it stop with what it has.
pub type Watch<'a> = dyn FnMut(&Progress) -> ControlFlow<()> + 'a;

fn check_shapes(shapes: &[Shape]) -> Result<(), PlacingError> {
    for (shape, s) in shapes.iter().enumerate() {
        if s.disks.is_empty() {
            return Err(PlacingError::NoDisks { shape });
        }
        for (disk, d) in s.disks.iter().enumerate() {
            let size = d.centre.norm() + d.radius;
            // Also false for NaN.
            if !(d.radius > 0.0 && size <= LARGEST) {
                let (radius, x, y) = (d.radius, d.centre.x, d.centre.y);
                return Err(PlacingError::Disk { shape, disk, radius, x, y });
            }
        }
    }
    Ok(())
}

/// A setting that must be finite and in a range.
fn check(name: &'static str, value: f64, ok: bool, wanted: &'static str) -> Result<(), PlacingError> {
    if ok && value.is_finite() { Ok(()) } else { Err(PlacingError::Setting { name, value, wanted }) }
}

fn check_orientation(orientation: Orientation) -> Result<(), PlacingError> {
    match orientation {
        Orientation::Free => Ok(()),
        Orientation::Fixed(angle) | Orientation::Towards(angle) => {
            check("the direction", angle, true, "an angle in radians is needed")
        }
    }
}

/// The angle of at most half a turn.
fn wrapped(angle: f64) -> f64 {
    let angle = angle % TAU;
    if angle > 0.5 * TAU {
        angle - TAU
    } else if angle <= -0.5 * TAU {
        angle + TAU
    } else {
        angle
    }
}

/// The disks of a shape at a pose.
fn disks_at(shape: &Shape, pose: Pose) -> impl Iterator<Item = Circle> + '_ {
    let turn = Rotation::by(pose.orientation);
    shape
        .disks
        .iter()
        .map(move |d| Circle { centre: pose.position + d.centre.rotated(turn), radius: d.radius })
}

/// \[m\] of the smallest circle about the origin that holds the shape.
fn reach(shape: &Shape) -> f64 {
    shape.disks.iter().map(|d| d.centre.norm() + d.radius).fold(0.0, f64::max)
}
