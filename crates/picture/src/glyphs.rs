//! Text drawn with strokes: the same on every machine, without fonts.

use crate::text::pair;
use std::collections::HashMap;
use std::sync::LazyLock;

/// Cap height in units of the glyph grid.
pub(crate) const CAP: f64 = 12.0;
/// Height of the base line in the grid.
const BASE: f64 = 4.0;
/// Space between two glyphs.
const GAP: f64 = 3.5;
/// Advance of a space.
const SPACE: f64 = 4.0;
/// Width of the pen / cap height.
pub(crate) const PEN: f64 = 0.125;

/// The point of the text that is given: its start, its middle or its end, as a fraction of its length.
pub(crate) const START: f64 = 0.0;
pub(crate) const MIDDLE: f64 = 0.5;
pub(crate) const END: f64 = 1.0;

/// Position and size of text.
#[derive(Clone, Copy)]
pub(crate) struct TextPlace {
    pub x: f64,
    /// y of the base line.
    pub y: f64,
    pub cap_height: f64,
    pub anchor: f64,
    /// Direction of y in which letters stand: 1 in the plane, −1 on a page.
    pub up: f64,
    pub decimals: usize,
}

/// Characters, then the strokes of their glyph, each a list of points. A point is x and height, one base-36 digit each
/// (base line 4, x-height c, cap height g, descender 0). A stroke is the quadratic B-spline of its points: smooth, with a
/// corner at a repeated point. '@' closes it.
const GLYPHS: &str = include_str!("glyphs.txt");
/// Any other character: a box.
const BOX: &str = "04048484848g8g8g0g0g0404";

/// Returns the strokes of a character.
fn glyph(c: char) -> &'static str {
    static ALL: LazyLock<HashMap<char, &str>> = LazyLock::new(|| {
        let glyphs = GLYPHS.lines().filter_map(|line| line.split_once(' '));
        glyphs.flat_map(|(characters, strokes)| characters.chars().map(move |c| (c, strokes))).collect()
    });
    ALL.get(&c).copied().unwrap_or(BOX)
}

fn points(stroke: &str) -> Vec<(f64, f64)> {
    let digits: Vec<f64> = stroke.chars().filter_map(|c| c.to_digit(36)).map(f64::from).collect();
    digits.chunks_exact(2).map(|p| (p[0], p[1] - BASE)).collect()
}

/// Returns the width in grid units. All digits have the same width, so that a running clock does not move.
fn glyph_width(c: char) -> f64 {
    match c {
        ' ' => SPACE,
        '0'..='9' => 8.0,
        '.' | ',' | ':' | '·' => 2.0,
        _ => glyph(c).split(',').flat_map(points).fold(0.0, |w, p| f64::max(w, p.0)),
    }
}

/// Length of the text at a cap height.
pub(crate) fn width(text: &str, cap_height: f64) -> f64 {
    let advance: f64 = text.chars().map(|c| glyph_width(c) + GAP).sum();
    (advance - GAP).max(0.0) * cap_height / CAP
}

/// Writes the text as SVG path data, to be stroked with a round pen of width [`PEN`] cap heights.
pub(crate) fn strokes(d: &mut String, text: &str, place: TextPlace) {
    let unit = place.cap_height / CAP;
    let up = unit * place.up;
    let mut x = place.x - place.anchor * width(text, place.cap_height);
    for c in text.chars() {
        if c != ' ' {
            for stroke in glyph(c).split(',') {
                spline(d, &points(stroke), stroke.starts_with('@'), |d, (px, py)| {
                    pair(d, (x + unit * px, place.y + up * py), place.decimals);
                });
            }
        }
        x += (glyph_width(c) + GAP) * unit;
    }
}

type Point = (f64, f64);

fn spline(d: &mut String, p: &[Point], closed: bool, put: impl Fn(&mut String, Point)) {
    let middle = |a: Point, b: Point| (0.5 * (a.0 + b.0), 0.5 * (a.1 + b.1));
    let [first, inner @ .., last] = p else { return };
    d.push('M');
    put(d, if closed { middle(*last, *first) } else { *first });
    if let Some(second) = inner.first().filter(|_| !closed) {
        d.push('L');
        put(d, middle(*first, *second));
    }
    let corners = if closed { p } else { inner };
    for (k, corner) in corners.iter().enumerate() {
        // Split into halves, the next control point is the mirror image of the last one; 'T' omits it.
        if k == 0 {
            d.push('Q');
            put(d, *corner);
            d.push(' ');
        } else {
            d.push('T');
        }
        let next = corners.get(k + 1).unwrap_or(if closed { first } else { last });
        put(d, middle(*corner, *next));
    }
    if closed {
        d.push('Z');
    } else {
        d.push('L');
        put(d, *last);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_glyph_is_whole_points() {
        for c in (' '..='~').chain("²³°µμγΔπτθω·−×→≤≥".chars()) {
            for stroke in glyph(c).split(',').map(|s| s.trim_start_matches('@')) {
                assert!(
                    stroke.len().is_multiple_of(2)
                        && points(stroke).len() * 2 == stroke.len()
                        && stroke.len() >= 4,
                    "{c}"
                );
            }
        }
    }
}
