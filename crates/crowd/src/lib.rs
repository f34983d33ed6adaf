//! People and crowds from anthropometric data: the other half of the paper (sections 2.1, 3.3, 4.4, 4.5; App. A.2, D).
//!
//! A [`Person`] is drawn from statistics; five disks are fitted to it, its [`Shape`]; crowds of shapes are placed
//! without overlap and written as a Trial. SI units; angles in radians, counter-clockwise positive.

mod body3d;
mod person;
mod shape;

pub use body3d::{
    BODY_DENSITY, Body3d, BodyError, CrowdSection, GIRTH_FACTORS, Mesh, MeshPart, Part, Placed, Polygon,
    TORSO_ALTITUDE, crowd_parts, section, torso_altitudes, write_geojson, write_obj, write_stl, write_wkt,
};
pub use person::{Person, Sex};
pub use shape::{Disk, Shape};
