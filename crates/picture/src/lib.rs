//! Pictures of a scene: SVG, and PNG or PDF made from that SVG.
//!
//! ```
//! # use lemons_core::trial::Trial;
//! # use lemons_picture::{PictureError, PictureScene, Style};
//! # fn picture(trial: &Trial) -> Result<Vec<u8>, PictureError> {
//! let svg = lemons_picture::svg(&PictureScene::at_start(trial), &Style::default());
//! lemons_picture::png(&svg, 800)
//! # }
//! ```
//!
//! [`svg`] draws one scene, [`sheet`] several times of a run on one page, [`chart_svg`] curves over time; [`pixels`]
//! and [`Animation`] make movies.
//!
//! The same input gives the same bytes on every machine, because text is drawn with strokes and no fonts are used.
//! Scenes are drawn in metres, the y axis upwards, under one transform: the numbers in the SVG are those of the Trial.

mod animation;
mod body;
mod chart;
mod colour;
mod colouring;
mod curve;
mod density;
mod frame;
mod glyphs;
mod page;
mod pdf;
mod raster;
mod scene;
mod sheet;
mod style;
mod text;
mod world;

pub use animation::{Animation, AnimationFormat};
pub use chart::{Chart, ChartPanel, ChartStyle, Curve, chart_svg};
pub use colour::{Colour, ColourMap, Theme};
pub use density::{DENSITY_KERNEL, DensityMap};
pub use lemons_core::plane::{Bounds, Pose};
pub use pdf::{A4, PdfPage, PdfText, document, pdf, text_width};
pub use raster::{PictureError, Pixels, pixels, png};
pub use scene::{DrawnForce, LoadMap, MarkKind, PictureScene, PlaceMark, Trail};
pub use sheet::{sheet, svg};
pub use style::{Fill, Style, Values, titled};
pub use world::ids_without_room;
