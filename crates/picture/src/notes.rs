//! Draws notes on top of a scene.

use crate::body::point;
use crate::colour::{Colour, Palette};
use crate::lettering::{self, Anchor, PEN, Place, Up};
use crate::look::DASH;
use crate::note::{Mark, Note, Side, around};
use crate::page::{CAP_HEIGHT, Frame};
use crate::text::{escaped, number, text_of};
use lemons_plane::Vec2;
use std::f64::consts::{PI, TAU};

/// \[px\] Width of a line.
const STROKE: f64 = 1.3;
/// \[px\] Length of an arrow head, and half its width.
const HEAD: (f64, f64) = (7.0, 2.6);
/// A head is at most this part of its arrow.
const HEAD_PART: f64 = 0.6;
/// \[px\] Radius of a dot.
const DOT: f64 = 2.2;
/// \[px\] Distance between a point and the words beside it.
const GAP: f64 = 5.0;
/// Distance between two lines of words / height of capital letters.
const LINE: f64 = 1.8;
/// Size of an index, and how far it is lowered, relative to capital letters.
const INDEX: (f64, f64) = (0.7, 0.35);
/// \[px\] Halo on each side of the strokes of letters.
const HALO: f64 = 1.6;
/// Number of decimals of a length in metres.
const DECIMALS: usize = 5;

/// Draws notes in their order, in the metres of the scene.
pub(crate) fn notes(out: &mut String, notes: &[Note], palette: &Palette, frame: &Frame) {
    if notes.is_empty() {
        return;
    }
    let pen = Pen { px: frame.unit / frame.scale, palette };
    *out += "<g class=\"notes\" fill=\"none\">\n";
    notes.iter().filter(|note| note.drawable()).for_each(|note| pen.note(out, note));
    *out += "</g>\n";
}

struct Pen<'a> {
    /// \[m\] one pixel.
    px: f64,
    palette: &'a Palette,
}

impl Pen<'_> {
    fn note(&self, out: &mut String, note: &Note) {
        let colour = note.series.map_or(self.palette.ink, |place| self.palette.series(place));
        let line = |out: &mut String, class: &str, d: &str| {
            let mut more = String::new();
            if note.dashed {
                let [dash, gap] = [DASH.0, DASH.1].map(|v| text_of(v * self.px, 6));
                more = format!(" stroke-linecap=\"butt\" stroke-dasharray=\"{dash} {gap}\"");
            }
            let width = text_of(STROKE * self.px, 6);
            *out += &format!(
                "<path class=\"{class}\" stroke=\"{colour}\" stroke-width=\"{width}\"{more} d=\"{d}\"/>\n"
            );
        };
        let solid = |out: &mut String, class: &str, d: &str| {
            *out += &format!("<path class=\"{class}\" fill=\"{colour}\" stroke=\"none\" d=\"{d}\"/>\n");
        };
        match &note.mark {
            Mark::Line(points) => line(out, "line", &polyline(points)),
            Mark::Circle { centre, radius } => line(out, "circle", &circle(*centre, *radius)),
            Mark::Dot(at) => solid(out, "dot", &circle(*at, DOT * self.px)),
            Mark::Arrow { from, to } => {
                let length = (*to - *from).norm();
                if length > 0.0 {
                    let ahead = (*to - *from) * (1.0 / length);
                    let head = self.head(*to, ahead, HEAD_PART * length);
                    line(out, "arrow", &polyline(&[*from, head.back]));
                    solid(out, "head", &head.d);
                }
            }
            Mark::Length { from, to } => {
                let length = (*to - *from).norm();
                if length > 0.0 {
                    let ahead = (*to - *from) * (1.0 / length);
                    let room = length > 2.5 * HEAD.0 * self.px;
                    let out_of = if room { 1.0 } else { -1.0 };
                    let first = self.head(*from, ahead * -out_of, f64::INFINITY);
                    let second = self.head(*to, ahead * out_of, f64::INFINITY);
                    if room {
                        line(out, "length", &polyline(&[first.back, second.back]));
                    } else {
                        let tail = ahead * (HEAD.0 * self.px);
                        let tails = [[first.back, first.back - tail], [second.back, second.back + tail]];
                        line(out, "length", &tails.map(|tail| polyline(&tail)).concat());
                    }
                    solid(out, "head", &[first.d, second.d].concat());
                }
            }
            Mark::Angle { centre, radius, from, to } => {
                let sense = if to < from { -1.0 } else { 1.0 };
                // The head is a chord: it covers the end of the arc.
                let covered = (HEAD.0 * self.px / radius).min(HEAD_PART * (to - from).abs());
                let tip = around(*centre, *radius, *to);
                let back = around(*centre, *radius, to - sense * covered);
                let chord = tip - back;
                line(out, "angle", &arc(*centre, *radius, *from, to - sense * covered));
                if chord.norm() > 0.0 {
                    let head = self.head(tip, chord * (1.0 / chord.norm()), chord.norm());
                    solid(out, "head", &head.d);
                }
            }
            Mark::Words { at, side, text } => self.words(out, *at, *side, text, colour),
        }
    }

    /// The head of an arrow at a point, not longer than `longest` \[m\].
    fn head(&self, tip: Vec2, ahead: Vec2, longest: f64) -> Head {
        let length = (HEAD.0 * self.px).min(longest);
        let aside = ahead.perp() * (HEAD.1 / HEAD.0 * length);
        let back = tip - ahead * length;
        Head { d: polyline(&[tip, back + aside, back - aside]) + "Z", back }
    }

    fn words(&self, out: &mut String, at: Vec2, side: Side, text: &str, colour: Colour) {
        let (cap, gap) = (CAP_HEIGHT * self.px, GAP * self.px);
        let lines: Vec<Vec<Run>> = text.lines().map(runs).collect();
        let height = cap * (1.0 + LINE * (lines.len().max(1) - 1) as f64);
        // The base line of the first line, from the point.
        let first = match side {
            Side::Above => gap + height - cap,
            Side::Below => -gap - cap,
            Side::Left | Side::Right | Side::On => 0.5 * height - cap,
        };
        let mut d = String::new();
        for (k, line) in lines.iter().enumerate() {
            let length = length_of(line, cap);
            let mut x = at.x
                + match side {
                    Side::Left => -gap - length,
                    Side::Right => gap,
                    Side::Above | Side::Below | Side::On => -0.5 * length,
                };
            let y = at.y + first - LINE * cap * k as f64;
            for run in line {
                let cap_height = cap * run.size();
                let y = if run.index { y - INDEX.1 * cap } else { y };
                let place =
                    Place { x, y, cap_height, anchor: Anchor::Start, up: Up::Positive, decimals: DECIMALS };
                lettering::strokes(&mut d, &run.text, place);
                x += lettering::width(&run.text, cap_height) + SPACING * cap;
            }
        }
        let pen = PEN * cap;
        let halo = text_of(pen + 2.0 * HALO * self.px, 6);
        *out += &format!(
            "<path class=\"halo\" stroke=\"{}\" stroke-opacity=\".8\" stroke-width=\"{halo}\" d=\"{d}\"/>\n\
             <path class=\"words\" aria-label=\"{}\" stroke=\"{colour}\" stroke-width=\"{}\" d=\"{d}\"/>\n",
            self.palette.paper,
            escaped(text),
            text_of(pen, 6)
        );
    }
}

struct Head {
    d: String,
    /// \[m\] where the line meets it.
    back: Vec2,
}

/// Distance between two runs / height of capital letters.
const SPACING: f64 = 0.2;

/// Letters of one size.
struct Run {
    text: String,
    index: bool,
}

impl Run {
    fn size(&self) -> f64 {
        if self.index { INDEX.0 } else { 1.0 }
    }
}

fn length_of(line: &[Run], cap: f64) -> f64 {
    let gaps = SPACING * cap * line.len().saturating_sub(1) as f64;
    gaps + line.iter().map(|run| lettering::width(&run.text, cap * run.size())).sum::<f64>()
}

/// Splits a line into normal letters and indices.
fn runs(line: &str) -> Vec<Run> {
    let mut all: Vec<Run> = Vec::new();
    let mut rest = line;
    while let Some((before, after)) = rest.split_once('_') {
        let braced = after.strip_prefix('{').and_then(|inside| inside.split_once('}'));
        let one = after.char_indices().nth(1).map_or(after.len(), |(end, _)| end);
        let (index, behind) = braced.unwrap_or_else(|| after.split_at(one));
        all.push(Run { text: before.to_owned(), index: false });
        all.push(Run { text: index.to_owned(), index: true });
        rest = behind;
    }
    all.push(Run { text: rest.to_owned(), index: false });
    all.retain(|run| !run.text.is_empty());
    all
}

fn polyline(points: &[Vec2]) -> String {
    let mut d = String::new();
    for (k, p) in points.iter().enumerate() {
        d.push(if k == 0 { 'M' } else { 'L' });
        point(&mut d, *p);
    }
    d
}

fn circle(centre: Vec2, radius: f64) -> String {
    arc(centre, radius, 0.0, TAU) + "Z"
}

/// In pieces of less than half a turn: otherwise the centre would depend on the last digit.
fn arc(centre: Vec2, radius: f64, from: f64, to: f64) -> String {
    let mut d = polyline(&[around(centre, radius, from)]);
    let pieces = ((to - from).abs() / (0.7 * PI)).ceil().max(1.0);
    for k in 1..=pieces as usize {
        d.push('A');
        number(&mut d, radius, DECIMALS);
        d.push(' ');
        number(&mut d, radius, DECIMALS);
        d += if to < from { " 0 00" } else { " 0 01" };
        point(&mut d, around(centre, radius, from + (to - from) * (k as f64 / pieces)));
    }
    d
}
