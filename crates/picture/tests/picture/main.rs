//! Pictures, charts and animations, as decoders and eyes find them.
//!
//! One program for all of them: linking takes longer than compiling.

mod animation;
mod charts;
mod common;
mod icons;
mod pdf;
mod picture;
mod scenes;
