//! Pure mechanics: no files, no FMI, no unsafe code.

mod vec2;

pub use vec2::{Rotation, Vec2, vec2};
