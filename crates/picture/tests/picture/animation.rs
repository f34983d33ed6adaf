//! Animations, as decoders see them.

use lemons_picture::*;
use std::io::Cursor;

/// A white picture with one square, whose shades no other frame has.
fn frame(k: u32) -> Pixels {
    let (width, height) = (40, 30);
    let mut rgba = vec![255; 4 * width as usize * height as usize];
    for y in 5..15 {
        for x in 2 * k..2 * k + 10 {
            let at = 4 * (y * width + x) as usize;
            rgba[at..at + 3].copy_from_slice(&[28 * k as u8, 90, (150 + x + y) as u8]);
        }
    }
    Pixels { width, height, rgba }
}

fn film(format: AnimationFormat, rate: f64, frames: &[Pixels]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut film = Animation::begin(&mut bytes, format, rate, frames.len() as u32, &frames[0]).unwrap();
    frames.iter().for_each(|f| film.add(f).unwrap());
    film.finish().unwrap();
    bytes
}

/// Draws the opaque pixels of a frame.
fn draw(canvas: &mut [u8], frame: &[u8]) {
    for (to, pixel) in canvas.chunks_exact_mut(4).zip(frame.chunks_exact(4)) {
        if pixel[3] == 255 {
            to.copy_from_slice(pixel);
        }
    }
}

/// Ten frames, the fifth like the fourth.
fn frames() -> Vec<Pixels> {
    (0..10).map(|k| frame(if k == 4 { 3 } else { k })).collect()
}

#[test]
fn every_frame_of_an_animated_png() {
    let frames = frames();
    let bytes = film(AnimationFormat::Apng, 12.5, &frames);
    let mut reader = png::Decoder::new(Cursor::new(&bytes)).read_info().unwrap();
    let control = reader.info().animation_control.unwrap();
    assert_eq!((control.num_frames, control.num_plays), (10, 0));
    let mut canvas = vec![0u8; frames[0].rgba.len()];
    for (k, frame) in frames.iter().enumerate() {
        let mut buffer = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut buffer).unwrap();
        let at = *reader.info().frame_control().unwrap();
        assert_eq!(f64::from(at.delay_num) / f64::from(at.delay_den), 0.08);
        draw(&mut canvas, &buffer[..info.buffer_size()]);
        assert!(canvas == frame.rgba, "frame {k}");
        // Of the squares of this frame and the last one, no more.
        let shown = buffer.chunks_exact(4).filter(|pixel| pixel[3] == 255).count();
        assert!(k == 0 || shown <= 140 && (shown == 0) == (k == 4), "{shown} pixels of frame {k}");
    }
}

#[test]
fn every_frame_of_a_gif() {
    let frames = frames();
    // 30 per second in hundredths: some frames longer than others, the film as long as it should be.
    let bytes = film(AnimationFormat::Gif, 30.0, &frames);
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options.read_info(&bytes[..]).unwrap();
    assert_eq!(decoder.repeat(), gif::Repeat::Infinite);
    let (mut canvas, mut hundredths, mut count) = (vec![0u8; frames[0].rgba.len()], 0, 0);
    while let Some(part) = decoder.read_next_frame().unwrap() {
        hundredths += part.delay;
        assert!((3..=4).contains(&part.delay));
        draw(&mut canvas, &part.buffer);
        assert!(canvas == frames[count].rgba, "frame {count}");
        count += 1;
    }
    assert_eq!((count, hundredths), (10, 33));
}

#[test]
fn what_cannot_be_an_animation() {
    let mut short = Animation::begin(Vec::new(), AnimationFormat::Apng, 25.0, 2, &frame(0)).unwrap();
    short.add(&frame(0)).unwrap();
    assert!(short.finish().is_err());
    let wide = Pixels { width: 70_000, height: 1, rgba: vec![255; 280_000] };
    assert!(Animation::begin(Vec::new(), AnimationFormat::Gif, 25.0, 1, &wide).is_err());
}

#[test]
fn a_full_disk_is_told() {
    for format in [AnimationFormat::Apng, AnimationFormat::Gif] {
        for room in [0, 10, 100, 900] {
            let mut file = vec![0; room];
            let film = Animation::begin(&mut file[..], format, 25.0, 10, &frame(0));
            let told = film.and_then(|mut film| {
                frames().iter().try_for_each(|f| film.add(f))?;
                film.finish()
            });
            let told = told.unwrap_err().to_string();
            assert_eq!(told, "failed to write whole buffer", "{format:?} {room}");
        }
    }
}

#[test]
fn pixels_are_opaque_and_even() {
    let svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"3\" height=\"5\"><rect width=\"1\" height=\"5\" fill=\"#102030\"/><rect x=\"1\" width=\"1\" height=\"5\" fill=\"#000\" fill-opacity=\".5\"/></svg>";
    let picture = pixels(svg, 3, 1).unwrap();
    assert_eq!((picture.width, picture.height), (3, 5));
    assert_eq!(picture.rgba[..12], [0x10, 0x20, 0x30, 255, 127, 127, 127, 255, 255, 255, 255, 255]);
    let even = pixels(svg, 3, 2).unwrap();
    assert_eq!((even.width, even.height, even.rgba.len()), (4, 6, 96));
    assert!(pixels(svg, 0, 1).is_err() && pixels("<svg", 3, 1).is_err());
}
