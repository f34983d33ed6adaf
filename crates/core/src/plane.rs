//! Geometry of the plane for all other crates: vectors, poses, polygons, hulls, unions of disks.
//!
//! SI units; angles in radians, counter-clockwise positive. This module reads no files and knows nothing about crowds.

mod bounds;
mod ground;
mod hull;
pub mod overlay;
mod polygon;
mod pose;
mod ring;
mod rotation;
mod segment;
mod simple;
mod union;
mod vec2;
mod wkt;

pub use bounds::Bounds;
pub use ground::{ground, parts};
pub use hull::{body_meets, convex_hull, has_room, hull_meets};
pub use polygon::Polygon;
pub use pose::{Motion, Pose, Twist, shown_orientation};
pub use ring::{Foot, Ring, is_closed, nearest_on_line};
pub use rotation::{Rotation, SMALL_TURN, rotation, turned_by};
pub use segment::{nearest_on_segment, ray_crosses, segments_cross, segments_touch, turn};
pub use simple::sides_that_meet;
pub use union::{Arc, Disk, Moments, boundary, union};
pub use vec2::{InPlane, Vec2, vec2};
pub use wkt::{WktGeometry, polygon_from_wkt, shapes_from_wkt};
