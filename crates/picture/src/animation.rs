//! Writes frames as animated PNG or GIF.
//!
//! In each frame the pixels that have not changed are transparent: long runs of them take little space. Only two frames
//! are kept in memory.

use crate::raster::{PictureError, Pixels};
use std::collections::HashMap;
use std::io::Write;

/// Index of the transparent colour in the palettes of a GIF.
const TRANSPARENT: u8 = 255;
/// \[s\] The delay of a frame of an animated PNG is a fraction; over this number most frame rates are exact.
const TICKS: f64 = 60_000.0;

/// The file format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AnimationFormat {
    /// Animated PNG: exact colours.
    Apng,
    /// GIF: 256 colours, at most 50 frames per second (players show faster ones slowly).
    Gif,
}

/// An animation, written frame by frame. Players repeat it for ever.
pub struct Animation<W: Write> {
    encoder: Encoder<W>,
    frames_per_second: f64,
    written: u32,
    /// Red, green, blue, alpha of the pixels of the last frame.
    last: Vec<u8>,
}

enum Encoder<W: Write> {
    Apng(png::Writer<W>),
    Gif(Box<gif::Encoder<W>>),
}

impl<W: Write> Animation<W> {
    /// Begins an animation of `frames` frames (an animated PNG stores their number first) with the size of the first.
    ///
    /// # Errors
    /// The file cannot be written, or a GIF cannot be so large.
    pub fn begin(
        to: W,
        format: AnimationFormat,
        frames_per_second: f64,
        frames: u32,
        first: &Pixels,
    ) -> Result<Animation<W>, PictureError> {
        let encoder = match format {
            AnimationFormat::Apng => Encoder::Apng(apng(to, first, frames)?),
            AnimationFormat::Gif => gif(to, first)?,
        };
        Ok(Animation { encoder, frames_per_second, written: 0, last: Vec::new() })
    }

    /// Adds the next frame, which is as large as the first.
    ///
    /// # Errors
    /// The file cannot be written, or this is a frame too many.
    pub fn add(&mut self, frame: &Pixels) -> Result<(), PictureError> {
        let ((pixels, _), last) = (frame.rgba.as_chunks::<4>(), self.last.as_chunks::<4>().0);
        let shown = |(k, pixel)| if last.get(k) == Some(pixel) { [0; 4] } else { *pixel };
        let pixels: Vec<[u8; 4]> = pixels.iter().enumerate().map(shown).collect();
        match &mut self.encoder {
            Encoder::Apng(writer) => {
                let over = (TICKS / self.frames_per_second.max(1.0)).floor();
                writer.set_frame_delay(over as u16, (over * self.frames_per_second).round() as u16)?;
                writer.write_image_data(&pixels.concat())?;
            }
            Encoder::Gif(encoder) => {
                // Round the end of each frame to hundredths of a second: rounding errors do not add up.
                let end = |k: u32| (f64::from(k) * 100.0 / self.frames_per_second).round() as u64;
                let delay = (end(self.written + 1) - end(self.written)).min(u64::from(u16::MAX)) as u16;
                let palette = palette(&pixels);
                let frame = gif::Frame {
                    delay,
                    dispose: gif::DisposalMethod::Keep,
                    transparent: Some(TRANSPARENT),
                    width: frame.width as u16,
                    height: frame.height as u16,
                    buffer: indices(&pixels, &palette).into(),
                    palette: Some(palette.concat()),
                    ..gif::Frame::default()
                };
                encoder.write_frame(&frame)?;
            }
        }
        self.last.clone_from(&frame.rgba);
        self.written += 1;
        Ok(())
    }

    /// Ends the file after the last frame.
    ///
    /// # Errors
    /// The file cannot be written, or frames are missing.
    pub fn finish(self) -> Result<(), PictureError> {
        match self.encoder {
            Encoder::Apng(writer) => Ok(writer.finish()?),
            Encoder::Gif(encoder) => Ok(encoder.into_inner()?.flush().map_err(gif::EncodingError::Io)?),
        }
    }
}

fn apng<W: Write>(to: W, first: &Pixels, frames: u32) -> Result<png::Writer<W>, PictureError> {
    let mut encoder = png::Encoder::new(to, first.width, first.height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Balanced);
    encoder.set_animated(frames, 0)?;
    encoder.validate_sequence(true);
    encoder.set_blend_op(png::BlendOp::Over)?;
    encoder.set_dispose_op(png::DisposeOp::None)?;
    Ok(encoder.write_header()?)
}

fn gif<W: Write>(to: W, first: &Pixels) -> Result<Encoder<W>, PictureError> {
    let [width, height] = [first.width, first.height].map(u16::try_from);
    let (Ok(width), Ok(height)) = (width, height) else {
        return Err(PictureError::Size { width: first.width, height: first.height.into() });
    };
    let mut encoder = gif::Encoder::new(to, width, height, &[])?;
    encoder.set_repeat(gif::Repeat::Infinite)?;
    Ok(Encoder::Gif(Box::new(encoder)))
}

/// Returns the 256 colours of a palette: the most frequent ones that differ enough from all before, until the palette is
/// full. Flat areas and lines keep their colours; their smooth edges share the others.
fn palette(pixels: &[[u8; 4]]) -> Vec<[u8; 3]> {
    let mut counts: HashMap<[u8; 3], usize> = HashMap::new();
    for [r, g, b, _] in pixels.iter().filter(|p| p[3] > 0) {
        *counts.entry([*r, *g, *b]).or_default() += 1;
    }
    let mut common: Vec<_> = counts.into_iter().collect();
    common.sort_unstable_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(&b.0)));
    // Colours of more than a thousandth of the pixels are exact.
    let large = common.iter().take(48).filter(|(_, n)| *n > pixels.len() / 1000);
    let mut colours: Vec<[u8; 3]> = large.map(|(colour, _)| *colour).collect();
    for apart in [40, 20, 10, 5, 1] {
        for (colour, _) in &common {
            if colours.len() < usize::from(TRANSPARENT)
                && colours.iter().all(|known| distance(*known, *colour) >= apart * apart)
            {
                colours.push(*colour);
            }
        }
    }
    colours.resize(256, [0; 3]);
    colours
}

/// Returns the places of the nearest colours in a palette.
fn indices(pixels: &[[u8; 4]], palette: &[[u8; 3]]) -> Vec<u8> {
    let mut known: HashMap<[u8; 3], u8> = HashMap::new();
    let mut index = |&[r, g, b, a]: &[u8; 4]| {
        let nearest = || {
            let all = palette.iter().zip(0..TRANSPARENT);
            all.min_by_key(|(colour, _)| distance(**colour, [r, g, b])).map_or(0, |(_, place)| place)
        };
        if a == 0 { TRANSPARENT } else { *known.entry([r, g, b]).or_insert_with(nearest) }
    };
    pixels.iter().map(&mut index).collect()
}

fn distance(a: [u8; 3], b: [u8; 3]) -> u32 {
    a.iter().zip(b).map(|(a, b)| u32::from(a.abs_diff(b)).pow(2)).sum()
}
