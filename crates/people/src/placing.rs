//! Places shapes: on a [`grid()`], by the [`paper()`]'s algorithm, or [`dense()`]ly without overlap.

mod dense;
mod fire;
mod free_space;
mod grid;
mod hull;
mod measure;
mod neighbours;
mod paper;
mod region;
mod soft_disks;

use crate::error::Result;
use crate::shape::Shape;
use lemons_core::plane::{Disk, Pose};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

pub use dense::dense;
pub use free_space::FreeSpace;
pub use grid::grid;
pub use paper::paper;
pub(crate) use region::FARTHEST;
pub use region::Region;

/// \[m\] Overlaps up to this count as none: clothes yield far more.
pub const TOLERANCE: f64 = 1e-4;

/// Part of the ground that shapes never cover without overlap.
const FULL: f64 = 0.97;

/// Returns as many of the first shapes as the ground has area for, at least one: placing them says how many of too many
/// people do fit.
pub fn within_area<'a>(shapes: &'a [Shape], region: &Region) -> &'a [Shape] {
    let mut covered = 0.0;
    let fit = shapes.iter().take_while(|shape| {
        covered += shape.moments().area;
        covered <= FULL * region.area()
    });
    &shapes[..fit.count().max(1).min(shapes.len())]
}

/// The direction that the shapes face.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Orientation {
    /// Any direction.
    #[default]
    Free,
    /// \[rad\] Exactly this direction.
    Fixed(f64),
    /// \[rad\] This direction at the beginning. Shapes turn when others press on them.
    Towards(f64),
}

impl Orientation {
    /// \[rad\] The direction at the beginning; `None`: any.
    fn start(self) -> Option<f64> {
        match self {
            Orientation::Free => None,
            Orientation::Fixed(angle) | Orientation::Towards(angle) => Some(angle),
        }
    }

    /// Returns whether shapes may turn.
    fn turns(self) -> bool {
        !matches!(self, Orientation::Fixed(_))
    }
}

/// How shapes are placed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PlacingSettings {
    /// The direction that the shapes face.
    pub orientation: Orientation,
    /// The same seed gives the same placing.
    pub seed: u64,
    /// \[1/m²\] The least density of a [`dense()`] crowd in the open plane; `None`: as dense as possible within the
    /// iterations. In a region it has no meaning.
    pub density: Option<f64>,
    /// Largest number of iterations; `None`: that of the algorithm.
    pub limit: Option<u64>,
}

/// An algorithm that places shapes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// [`dense()`]
    #[default]
    Dense,
    /// [`paper()`]
    Paper,
    /// [`grid()`]
    Grid,
}

impl Method {
    /// All of them.
    pub const ALL: [Method; 3] = [Method::Dense, Method::Paper, Method::Grid];

    /// Returns "dense", "paper" or "grid".
    pub fn name(self) -> &'static str {
        match self {
            Method::Dense => "dense",
            Method::Paper => "paper",
            Method::Grid => "grid",
        }
    }

    /// Places the shapes of people who were drawn with the same seed.
    ///
    /// # Errors
    /// There is no room.
    pub fn place(
        self,
        shapes: &[Shape],
        region: &Region,
        settings: &PlacingSettings,
        watch: &mut Watch,
    ) -> Result<Packing> {
        // Another stream of random numbers than that of the people.
        let settings =
            PlacingSettings { seed: settings.seed.wrapping_add(0x9e37_79b9_7f4a_7c15), ..*settings };
        let packing = match self {
            Method::Dense => dense(&wider(shapes), region, &settings, watch)?,
            Method::Paper => paper(&wider(shapes), region, &settings, watch),
            Method::Grid => grid(shapes, region, &settings)?,
        };
        let Packing { poses, clear_density, complete, ended, iterations, .. } = packing;
        let own = Packing::of(shapes, region, poses, ended, iterations);
        Ok(Packing { clear_density: own.clear_density.max(clear_density), complete, ..own })
    }
}

/// The progress of a placing algorithm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacingProgress {
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
    Growing = 0,
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
    /// \[1/m²\] Density of the shapes that remain if, one after the other, the shape with the largest overlap is
    /// removed until no overlap exceeds [`TOLERANCE`].
    pub clear_density: f64,
    /// \[m\] Largest overlap of disks of two shapes, or of a disk and the boundary; 0 if there is none.
    pub largest_overlap: f64,
    /// True if no overlap exceeds [`TOLERANCE`] and the wanted density is reached.
    pub complete: bool,
    /// Why it stopped.
    pub ended: Ended,
    /// Number of iterations.
    pub iterations: u64,
}

/// Callback for progress. If it returns `Break`, the algorithm stops and returns what it has.
pub type Watch<'a> = dyn FnMut(&PlacingProgress) -> ControlFlow<()> + 'a;

/// The same shapes with disks that are larger by [`TOLERANCE`]: where these are placed, the shapes themselves overlap by
/// nothing.
fn wider(shapes: &[Shape]) -> Vec<Shape> {
    let wider = |disk: &Disk| Disk { radius: disk.radius + TOLERANCE, ..*disk };
    shapes.iter().map(|shape| Shape { disks: shape.disks.iter().map(wider).collect() }).collect()
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

/// \[m\] Radius of the smallest circle about the origin that contains the shape.
fn reach(shape: &Shape) -> f64 {
    shape.disks.iter().map(|d| d.centre.norm() + d.radius).fold(0.0, f64::max)
}
