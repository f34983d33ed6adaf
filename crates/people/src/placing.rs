//! Places shapes: on a [`grid()`], by the [`paper()`]'s algorithm, or [`dense()`]ly without overlap.

mod among;
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
mod region_error;

use crate::shape::Shape;
use lemons_core::plane::{Disk, Pose, Rotation};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

pub use among::Part;
pub use dense::{Dense, dense};
pub use grid::{Grid, grid};
pub use measure::{Measure, measure};
pub use paper::{Paper, paper};
pub use region::Region;
pub use region_error::RegionError;

/// \[m\] Overlaps up to this count as none: clothes yield far more.
pub const TOLERANCE: f64 = 1e-4;

/// \[m\] Largest size of a shape, larger than any person or bicycle.
const LARGEST: f64 = 100.0;

/// The direction that the shapes face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Orientation {
    /// Any direction.
    Free,
    /// \[rad\] Exactly this direction.
    Fixed(f64),
    /// \[rad\] This direction at the beginning. Shapes turn when others press on them.
    Towards(f64),
}

/// The progress of a placing algorithm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Its present stage.
    pub stage: Stage,
    /// Iterations done.
    pub iteration: u64,
    /// Largest number of iterations.
    pub limit: u64,
    /// \[m\] Largest overlap of disks with each other or with the boundary, at their present size; 0 if there is none.
    pub overlap: f64,
    /// \[1/m²\] Density of the shapes at their present size.
    pub density: f64,
}

/// A stage of a placing algorithm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Shapes grow to their full size.
    Growing,
    /// Shapes of full size push each other apart.
    Spreading,
    /// Shapes that overlap are moved elsewhere.
    Shaking,
    /// A crowd in the open plane is compressed.
    Pressing,
    /// Too many shapes for the region: some are removed, to find how many fit.
    Thinning,
}

/// Why a placing algorithm stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// All shapes are placed as asked for.
    Done,
    /// Further attempts did not help.
    Stuck,
    /// The limit of iterations was reached.
    Exhausted,
    /// The caller stopped it.
    Cancelled,
}

/// The result of placing shapes.
#[derive(Debug, Clone, PartialEq)]
pub struct Packing {
    /// Poses, in the order of the shapes.
    pub poses: Vec<Pose>,
    /// \[1/m²\] Number of shapes per area of the region; in the open plane, per area of the convex hull of all disks.
    pub density: f64,
    /// \[1/m²\] Density of the shapes that remain if those with the largest overlap are removed until no overlap
    /// exceeds [`TOLERANCE`].
    pub clear_density: f64,
    /// \[m\] Largest overlap of disks of two shapes, or of a disk and the boundary; 0 if there is none.
    pub largest_overlap: f64,
    /// Whether no overlap exceeds [`TOLERANCE`] and the wanted density is reached.
    pub complete: bool,
    /// Why it stopped.
    pub ended: Ended,
    /// Number of iterations.
    pub iterations: u64,
}

/// Why shapes cannot be placed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlacingError {
    /// A shape without disks.
    #[error("shape {shape} has no disks")]
    NoDisks {
        /// Index of the shape.
        shape: usize,
    },
    /// A disk that is not finite, not positive or too large.
    #[error(
        "shape {shape}, disk {disk}: radius {radius} m at ({x}, {y}) m; the radius must be positive and the size at most {LARGEST} m"
    )]
    Disk {
        /// Index of the shape.
        shape: usize,
        /// Index of the disk in the shape.
        disk: usize,
        /// \[m\] radius.
        radius: f64,
        /// \[m\] centre, x.
        x: f64,
        /// \[m\] centre, y.
        y: f64,
    },
    /// A setting out of range.
    #[error("{name} = {value}: must be {wanted}")]
    Setting {
        /// Name of the setting.
        name: &'static str,
        /// The given value.
        value: f64,
        /// The allowed values.
        wanted: &'static str,
    },
    /// The shapes have a larger area than the region.
    #[error(
        "{shapes} shapes cover {covered:.3} m², but the region has {area:.3} m²: it cannot hold them without overlap"
    )]
    NoRoom {
        /// Number of shapes.
        shapes: usize,
        /// \[m²\] Sum of their areas.
        covered: f64,
        /// \[m²\] Area of the region.
        area: f64,
    },
    /// Too few shapes for a density.
    #[error("a density of {density} /m² on {area:.3} m² needs {needed} shapes; {given} are given")]
    TooFewShapes {
        /// \[1/m²\] The wanted density.
        density: f64,
        /// \[m²\] Area of the region.
        area: f64,
        /// Number of shapes for that density.
        needed: u64,
        /// Number of given shapes.
        given: usize,
    },
    /// A grid that has fewer places than there are shapes.
    #[error(
        "the grid of {along:.3} m × {across:.3} m has {places} places in the region; {shapes} shapes are given"
    )]
    NoPlaces {
        /// Number of places inside the region.
        places: usize,
        /// \[m\] Spacing along the direction.
        along: f64,
        /// \[m\] Spacing across the direction.
        across: f64,
        /// Number of given shapes.
        shapes: usize,
    },
    /// A grid that is too narrow for the shapes.
    #[error("a grid of {along:.3} m × {across:.3} m is too narrow: shapes on it overlap by {overlap:.4} m")]
    TooNarrow {
        /// \[m\] Spacing along the direction.
        along: f64,
        /// \[m\] Spacing across the direction.
        across: f64,
        /// \[m\] Largest overlap.
        overlap: f64,
    },
}

impl Packing {
    /// Shapes at poses: complete if nothing overlaps.
    fn of(poses: Vec<Pose>, measured: &Measure, ended: Ended, iterations: u64) -> Packing {
        let Measure { density, clear_density, largest_overlap, .. } = *measured;
        let complete = largest_overlap <= TOLERANCE;
        Packing { poses, density, clear_density, largest_overlap, complete, ended, iterations }
    }
}

/// Callback for progress. If it returns `Break`, the algorithm stops and returns what it has.
pub type Watch<'a> = dyn FnMut(&Progress) -> ControlFlow<()> + 'a;

/// The seed of a placing, from the one that its people are drawn from: another stream of random numbers.
pub fn placing_seed(people: u64) -> u64 {
    people.wrapping_add(0x9e37_79b9_7f4a_7c15)
}

/// The same shapes with disks that are larger by [`TOLERANCE`]: where these are placed, the shapes themselves overlap by
/// nothing.
pub fn wider(shapes: &[Shape]) -> Vec<Shape> {
    let wider = |disk: &Disk| Disk { radius: disk.radius + TOLERANCE, ..*disk };
    shapes.iter().map(|shape| Shape { disks: shape.disks.iter().map(wider).collect() }).collect()
}

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

/// Checks that a setting is finite and in its range.
fn check(name: &'static str, value: f64, ok: bool, wanted: &'static str) -> Result<(), PlacingError> {
    if ok && value.is_finite() { Ok(()) } else { Err(PlacingError::Setting { name, value, wanted }) }
}

fn check_orientation(orientation: Orientation) -> Result<(), PlacingError> {
    match orientation {
        Orientation::Free => Ok(()),
        Orientation::Fixed(angle) | Orientation::Towards(angle) => {
            check("the direction", angle, true, "a finite angle in radians")
        }
    }
}

/// Returns the same angle within half a turn of zero.
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
fn disks_at(shape: &Shape, pose: Pose) -> impl Iterator<Item = Disk> + '_ {
    let turn = Rotation::by(pose.orientation);
    shape.disks.iter().map(move |d| Disk { centre: pose.position + d.centre.rotated(turn), ..*d })
}

/// \[m\] Radius of the smallest circle about the origin that contains the shape.
fn reach(shape: &Shape) -> f64 {
    shape.disks.iter().map(|d| d.centre.norm() + d.radius).fold(0.0, f64::max)
}
