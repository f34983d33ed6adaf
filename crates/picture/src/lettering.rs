//! Text drawn with strokes: the same on every machine, without fonts.

use crate::text::pair;

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

/// The point of the text that is given.
#[derive(Clone, Copy)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// Position and size of text.
#[derive(Clone, Copy)]
pub(crate) struct Place {
    pub x: f64,
    /// y of the base line.
    pub y: f64,
    pub cap_height: f64,
    pub anchor: Anchor,
    /// Direction of y in which letters stand: 1 in the plane, −1 on a page.
    pub up: f64,
    pub decimals: usize,
}

/// Strokes of a glyph, each a list of points. A point is x and height, one base-36 digit each (base line 4, x-height c,
/// cap height g, descender 0). A stroke is the quadratic B-spline of its points: smooth, with a corner at a repeated
/// point. '@' closes it.
fn glyph(c: char) -> &'static str {
    match c {
        '0' => "@04848g0g",
        '1' => "1d5g5g54",
        '2' => "0c0g8g8b040484",
        '3' => "0d0g7g7a3a3a8a840407",
        '4' => "6g080888,6g64",
        '5' => "7g1g1g0a0a2c8c840406",
        '6' => "7e7g0g04848b0b08",
        '7' => "0g8g8g34",
        '8' => "@1a7a7g1g,@04848a0a",
        '9' => "1614848g0g09898c",
        '.' => "1415",
        ',' => "1502",
        ':' => "1415,1a1b",
        '·' => "1a1b",
        '-' | '−' | '–' => "0a6a",
        '+' => "0a8a,4e46",
        '=' => "0888,0c8c",
        '_' => "0383",
        '<' => "8e0a0a86",
        '>' => "0e8a8a06",
        '×' => "1c76,167c",
        '*' => "3g3b,1f5c,1c5f",
        '→' => "0aba,7dbaba77",
        '≤' => "8g0c0c88,0484",
        '≥' => "0g8c8c08,0484",
        '/' => "036h",
        '(' | '[' => "3h0e0633",
        ')' | ']' => "0h3e3603",
        '%' => "8g04,@0c3c3g0g,@54848858",
        '°' => "@0c4c4g0g",
        '²' => "0e0g4g4d0a0a4a",
        '³' => "0f0g4g4d1d1d4d4a0a0b",
        'µ' | 'μ' => "0c00,0c047478,7c74",
        'γ' => "0c2c3535,7c353530",
        'Δ' => "044g4g848404",
        'π' => "0c8c,2c24,6c64",
        'τ' => "0c7c,3c343454",
        'θ' => "@04747g0g,0a7a",
        'ω' => "1c0804444a,4a4484887c",
        'A' => "044g4g84,1878",
        'B' => "040g,0g7g7a0a,0a8a8404",
        'C' => "8d8g0g048487",
        'D' => "040g,0g8g8404",
        'E' => "7g0g0g040474,0a6a",
        'F' => "7g0g0g04,0a6a",
        'G' => "8d8g0g04848a8a5a",
        'H' => "040g,848g,0a8a",
        'I' => "0g04",
        'J' => "5g540407",
        'K' => "040g,7g09,2b84",
        'L' => "0g040474",
        'M' => "040g0g47478g8g84",
        'N' => "040g0g84848g",
        'O' => "@04949g0g",
        'P' => "040g,0g8g8909",
        'Q' => "@04949g0g,6793",
        'R' => "040g,0g8g8909,4984",
        'S' => "7d7g0g0a8a840407",
        'T' => "0g8g,4g44",
        'U' => "0g04848g",
        'V' => "0g44448g",
        'W' => "0g24245d5d8484ag",
        'X' => "0g84,048g",
        'Y' => "0g4a4a8g,4a44",
        'Z' => "0g8g8g040484",
        'a' => "@04747c0c,7c74",
        'b' => "0g04,@04747c0c",
        'c' => "7a7c0c047476",
        'd' => "7g74,@04747c0c",
        'e' => "0878787c0c047476",
        'f' => "5g2g24,0c4c",
        'g' => "@04747c0c,7c700002",
        'h' => "0g04,080c7c74",
        'i' => "0c04,0f0g",
        'j' => "3c3000,3f3g",
        'k' => "0g04,6c07,2974",
        'l' => "0g04",
        'm' => "0c04,080c5c54,585caca4",
        'n' => "0c04,080c7c74",
        'o' => "@04747c0c",
        'p' => "0c00,@04747c0c",
        'q' => "7c70,@04747c0c",
        'r' => "0c04,080c4c",
        's' => "6a6c0c0868640406",
        't' => "2g2454,0c5c",
        'u' => "0c047478,7c74",
        'v' => "0c34346c",
        'w' => "0c24244b4b64648c",
        'x' => "0c64,046c",
        'y' => "0c34,6c20",
        'z' => "0c6c6c040464",
        // Any other character: a box.
        _ => "04048484848g8g8g0g0g0404",
    }
}

fn points(stroke: &str) -> Vec<(f64, f64)> {
    let digits: Vec<f64> = stroke.chars().filter_map(|c| c.to_digit(36)).map(f64::from).collect();
    digits.chunks_exact(2).map(|p| (p[0], p[1] - BASE)).collect()
}

/// In grid units. All digits have the same width, so that a running clock does not move.
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
pub(crate) fn strokes(d: &mut String, text: &str, place: Place) {
    let unit = place.cap_height / CAP;
    let up = unit * place.up;
    let length = width(text, place.cap_height);
    let mut x = place.x
        - match place.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => 0.5 * length,
            Anchor::End => length,
        };
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
    // Split into halves, the next control point is the mirror image of the last one; 'T' omits it.
    let curve = |d: &mut String, corners: &mut dyn Iterator<Item = (Point, Point)>| {
        for (k, (corner, end)) in corners.enumerate() {
            if k == 0 {
                d.push('Q');
                put(d, corner);
                d.push(' ');
            } else {
                d.push('T');
            }
            put(d, end);
        }
    };
    d.push('M');
    if closed {
        put(d, middle(*last, *first));
        let around = p.iter().zip(p.iter().cycle().skip(1));
        curve(d, &mut around.map(|(a, b)| (*a, middle(*a, *b))));
        d.push('Z');
        return;
    }
    put(d, *first);
    if let Some(second) = inner.first() {
        d.push('L');
        put(d, middle(*first, *second));
    }
    curve(d, &mut p[1..].windows(2).map(|pair| (pair[0], middle(pair[0], pair[1]))));
    d.push('L');
    put(d, *last);
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
