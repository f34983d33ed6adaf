//! Geometry of the plane for all other crates: vectors, poses, polygons, hulls, unions of disks.
//!
//! The feature `nalgebra` (off by default) adds `From` between [`Vec2`] and `nalgebra::Vector2`, [`Rotation`] and
//! `nalgebra::UnitComplex`, [`Pose`] and `nalgebra::Isometry2`.
//!
//! SI units; angles in radians, counter-clockwise positive. This crate reads no files and knows nothing about crowds.

mod bounds;
mod hull;
#[cfg(any(test, feature = "nalgebra"))]
mod nalgebra;
mod pose;
mod ring;
mod segment;
mod simple;
mod union;
mod vec2;
mod wkt;

pub use bounds::Bounds;
pub use hull::ConvexHull;
pub use pose::{Motion, Pose, Twist, shown_orientation};
pub use ring::{Foot, Ring};
pub use segment::{nearest_on_segment, ray_crosses, segments_cross, segments_touch, turn};
pub use union::{Disk, Moments, union};
pub use vec2::{Rotation, SMALL_TURN, Vec2, vec2};
pub use wkt::{polygon_from_wkt, polygon_to_wkt};
