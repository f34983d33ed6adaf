//! SVG to PNG.

use resvg::{tiny_skia, usvg};

/// \[px\] Largest picture: 400 MB of pixels.
const MOST_PIXELS: f64 = 1e8;

/// Why there is no PNG.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The text is not SVG.
    #[error("not an SVG picture: {0}")]
    Svg(#[from] usvg::Error),
    /// No pixels, or too many.
    #[error("a picture of {width} × {height} pixels cannot be made")]
    Size {
        /// \[px\]
        width: u32,
        /// \[px\]
        height: f64,
    },
    /// The encoder failed.
    #[error("PNG: {0}")]
    Png(String),
}

/// The SVG as a PNG of this width; the height follows from the SVG.
pub fn png(svg: &str, width_px: u32) -> Result<Vec<u8>, PictureError> {
    let tree = usvg::Tree::from_str(svg, &usvg::Options::default())?;
    let scale = f64::from(width_px) / f64::from(tree.size().width());
    let height = (scale * f64::from(tree.size().height())).round().max(1.0);
    let too_big = || PictureError::Size { width: width_px, height };
    if f64::from(width_px) * height > MOST_PIXELS {
        return Err(too_big());
    }
    let mut pixels = tiny_skia::Pixmap::new(width_px, height as u32).ok_or_else(too_big)?;
    let stretch = height as f32 / tree.size().height();
    resvg::render(&tree, tiny_skia::Transform::from_scale(scale as f32, stretch), &mut pixels.as_mut());
    pixels.encode_png().map_err(|e| PictureError::Png(e.to_string()))
}
