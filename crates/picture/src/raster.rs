//! Converts SVG to PNG.

use resvg::{tiny_skia, usvg};

/// \[px\] Largest number of pixels: 400 MB.
const MOST_PIXELS: f64 = 1e8;

/// Why a picture cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The text is not SVG.
    #[error("not an SVG picture: {0}")]
    Svg(#[from] usvg::Error),
    /// No pixels, or too many.
    #[error("a picture of {width} × {height} pixels cannot be made")]
    Size {
        /// \[px\] width.
        width: u32,
        /// \[px\] height.
        height: f64,
    },
    /// The SVG has a feature that pictures of this crate do not have.
    #[error("PDF: the SVG contains {0}, which is not supported")]
    Pdf(&'static str),
    /// The PNG cannot be made, or its file cannot be written.
    #[error(transparent)]
    Png(#[from] png::EncodingError),
    /// The GIF cannot be made, or its file cannot be written.
    #[error(transparent)]
    Gif(#[from] gif::EncodingError),
}

/// A picture as pixels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pixels {
    /// \[px\] width.
    pub width: u32,
    /// \[px\] height.
    pub height: u32,
    /// Red, green, blue, alpha of each pixel, row by row from the top; all opaque.
    pub rgba: Vec<u8>,
}

/// Returns the SVG as a PNG of a width; the height follows from the SVG.
pub fn png(svg: &str, width_px: u32) -> Result<Vec<u8>, PictureError> {
    let Pixels { width, height, rgba } = pixels(svg, width_px, 1)?;
    let rgb: Vec<u8> = rgba.chunks_exact(4).flat_map(|pixel| &pixel[..3]).copied().collect();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_compression(png::Compression::Balanced);
    // Flat colours repeat exactly; filters would only hide that.
    encoder.set_filter(png::Filter::NoFilter);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&rgb)?;
    writer.finish()?;
    Ok(bytes)
}

/// Returns the SVG as pixels of a width; the height follows from the SVG. Both are rounded up to multiples of a number:
/// H.264 in 4:2:0, which all players support, needs 2. Transparent areas become white.
pub fn pixels(svg: &str, width: u32, multiple_of: u32) -> Result<Pixels, PictureError> {
    let tree = usvg::Tree::from_str(svg, &usvg::Options::default())?;
    let size = tree.size();
    let height = (f64::from(width) * f64::from(size.height()) / f64::from(size.width())).round().max(1.0);
    let too_big = || PictureError::Size { width, height };
    if f64::from(width) * height > MOST_PIXELS {
        return Err(too_big());
    }
    let [width, rows] = [width, height as u32].map(|side| side.next_multiple_of(multiple_of));
    let mut picture = tiny_skia::Pixmap::new(width, rows).ok_or_else(too_big)?;
    picture.fill(tiny_skia::Color::WHITE);
    let scale = tiny_skia::Transform::from_scale(width as f32 / size.width(), rows as f32 / size.height());
    resvg::render(&tree, scale, &mut picture.as_mut());
    Ok(Pixels { width, height: rows, rgba: picture.take() })
}
