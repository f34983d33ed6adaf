//! The drawing.

use crate::body::{Body, point};
use crate::colour::{Colour, VIRIDIS, viridis};
use crate::lettering::{self, Anchor, PEN, Place, Up};
use crate::scene::{Pose, Scene, View, near};
use crate::style::{Fill, Style, Theme, Values};
use crate::text::{escaped, number, round_below, short, text_of};
use crowd_mechanics::engine::{Rotation, Vec2, vec2};
use std::fmt::Write;

/// \[px\] Width at which lines and letters have the sizes given below.
const NOMINAL_WIDTH: f64 = 400.0;
/// \[px\] around everything.
const MARGIN: f64 = 14.0;
/// \[px\]
const CAP_HEIGHT: f64 = 7.5;
/// \[px\] between the scene and what stands above or below it.
const BAND_GAP: f64 = 12.0;
/// \[px\]
const WALL_STROKE: f64 = 2.4;
/// \[px\] at most; small bodies have finer outlines.
const BODY_STROKE: f64 = 1.1;
/// Outline of a body, as a part of the square root of its area.
const BODY_STROKE_PART: f64 = 0.05;
/// Height of the scene at most, as a part of its width.
const TALLEST: f64 = 1.4;
/// \[m\] Smallest width and height shown.
const SMALLEST_VIEW: f64 = 0.01;
/// Decimals of a length in pixels.
const PX: usize = 2;

/// Colours that are not the bodies'.
struct Palette {
    paper: Colour,
    ink: Colour,
    wall: Colour,
    outline: Colour,
}

impl Palette {
    fn of(theme: Theme) -> Palette {
        match theme {
            Theme::Light => Palette {
                paper: Colour(0xff, 0xff, 0xff),
                ink: Colour(0x3a, 0x43, 0x50),
                wall: Colour(0x2a, 0x30, 0x3a),
                outline: Colour(0x1c, 0x2b, 0x40),
            },
            Theme::Dark => Palette {
                paper: Colour(0x12, 0x16, 0x1d),
                ink: Colour(0xc4, 0xcc, 0xd8),
                wall: Colour(0xd5, 0xdb, 0xe4),
                outline: Colour(0xee, 0xf2, 0xf7),
            },
        }
    }
}

/// The colours of the bodies, and what they mean.
struct Colouring<'a> {
    single: Colour,
    scale: Option<(std::borrow::Cow<'a, [f64]>, String, f64, f64)>,
}

impl<'a> Colouring<'a> {
    fn new(scene: &Scene, fill: &'a Fill) -> Colouring<'a> {
        let (values, label, unit, range): (std::borrow::Cow<[f64]>, &str, &str, _) = match fill {
            Fill::Single(colour) => {
                return Colouring { single: *colour, scale: None };
            }
            Fill::BodyArea => (scene.bodies.iter().map(|b| b.area).collect(), "body area", "m²", None),
            Fill::Values(Values { values, label, unit, range }) => {
                (values.as_slice().into(), label, unit, *range)
            }
        };
        let finite = || values.iter().copied().filter(|v| v.is_finite());
        let (low, high) =
            range.filter(|(a, b)| a.is_finite() && b.is_finite() && a <= b).unwrap_or_else(|| {
                let (low, high) =
                    (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
                if low <= high { (low, high) } else { (0.0, 1.0) }
            });
        let title = match (label.is_empty(), unit.is_empty()) {
            (_, true) => label.to_owned(),
            (true, false) => unit.to_owned(),
            (false, false) => format!("{label} ({unit})"),
        };
        Colouring { single: Colour::MISSING, scale: Some((values, title, low, high)) }
    }

    fn of(&self, agent: usize) -> Colour {
        let Some((values, _, low, high)) = &self.scale else {
            return self.single;
        };
        match values.get(agent) {
            Some(value) if !value.is_finite() => Colour::MISSING,
            // Halved: the difference of two finite numbers may be infinite.
            Some(value) if high > low => viridis((value / 2.0 - low / 2.0) / (high / 2.0 - low / 2.0)),
            Some(_) => viridis(0.5),
            None => Colour::MISSING,
        }
    }
}

/// Where things are on the page \[px\].
struct Page {
    /// Size of everything that is not to scale.
    unit: f64,
    width: f64,
    height: f64,
    view: View,
    /// \[px/m\]
    scale: f64,
    /// Upper left corner and size of the view.
    left: f64,
    top: f64,
    drawn: Vec2,
}

impl Page {
    fn new(scene: &Scene, style: &Style, header: bool, footer: f64) -> Page {
        let width = if style.width.is_finite() { style.width.clamp(32.0, 32_768.0) } else { NOMINAL_WIDTH };
        let unit = width / NOMINAL_WIDTH;
        let mut view = scene.view.filter(|v| near(v.low) && near(v.high)).unwrap_or_else(|| scene.extent());
        let grow = |low: f64, high: f64| 0.5 * (SMALLEST_VIEW - (high - low)).max(0.0);
        let (dx, dy) = (grow(view.low.x, view.high.x), grow(view.low.y, view.high.y));
        view = View { low: view.low - vec2(dx, dy), high: view.high + vec2(dx, dy) };
        let size = view.high - view.low;

        let margin = MARGIN * unit;
        let room = width - 2.0 * margin;
        let scale = (room / size.x).min(TALLEST * room / size.y);
        let drawn = size * scale;
        let top = margin + if header { (CAP_HEIGHT + BAND_GAP) * unit } else { 0.0 };
        let height = (top + drawn.y + footer * unit + margin - 1e-6).ceil();
        Page { unit, width, height, view, scale, left: 0.5 * (width - drawn.x), top, drawn }
    }

    /// Whether a disk would be cut by the border.
    fn cuts(&self, p: Vec2, r: f64) -> bool {
        let View { low, high } = self.view;
        p.x - r < low.x || p.x + r > high.x || p.y - r < low.y || p.y + r > high.y
    }

    /// Whether a disk is nowhere on the page.
    fn misses(&self, p: Vec2, r: f64) -> bool {
        let View { low, high } = self.view;
        let r = r + MARGIN * self.unit / self.scale;
        p.x + r < low.x || p.x - r > high.x || p.y + r < low.y || p.y - r > high.y
    }
}

/// The scene as SVG.
///
/// Groups `walls`, `bodies` (one group per agent, in the order of the agents, its title the agent's id)
/// and, outside the metres, `time`, `scale-bar`, `colour-bar`.
pub fn svg(scene: &Scene, style: &Style) -> String {
    let palette = Palette::of(style.theme);
    let colouring = Colouring::new(scene, &style.fill);
    let bar = style.colour_bar.shown() && colouring.scale.is_some();
    let time = style.time.filter(|t| t.is_finite());
    let footer = match (bar, style.scale_bar.shown()) {
        (true, _) => BAND_GAP + 2.4 * CAP_HEIGHT + 2.0,
        (false, true) => BAND_GAP + CAP_HEIGHT,
        (false, false) => 0.0,
    };
    let page = Page::new(scene, style, time.is_some(), footer);

    let mut out = String::new();
    let (w, h) = (text_of(page.width, PX), text_of(page.height, PX));
    out += &format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" role=\"img\">\n\
         <title>{}</title>\n<rect width=\"{w}\" height=\"{h}\" fill=\"{}\"/>\n",
        escaped(&scene.trial.name),
        palette.paper
    );
    world(&mut out, scene, style, &page, &palette, &colouring);
    if let Some(t) = time {
        let place = Place { x: page.left, y: page.top - BAND_GAP * page.unit, ..small(&page, Anchor::Start) };
        lettered(&mut out, "time", &format!("t = {t:.2} s"), place, palette.ink);
    }
    if style.scale_bar.shown() {
        scale_bar(&mut out, &page, &palette);
    }
    if let Some((_, title, low, high)) = colouring.scale.as_ref().filter(|_| bar) {
        colour_bar(&mut out, &page, &palette, title, *low, *high);
    }
    out += "</svg>\n";
    out
}

/// Everything to scale, in metres.
fn world(
    out: &mut String,
    scene: &Scene,
    style: &Style,
    page: &Page,
    palette: &Palette,
    colouring: &Colouring,
) {
    let drawn: Vec<_> =
        scene.drawn().filter(|(_, pose, body)| !page.misses(pose.position, body.reach)).collect();
    let walls: Vec<Vec<Vec2>> = {
        let finite = |corners: &[Vec2]| corners.iter().copied().filter(|c| near(*c)).collect::<Vec<_>>();
        scene.trial.geometry.walls.iter().map(|w| finite(&w.corners)).collect()
    };
    // Only a view of the caller's choice can cut anything; a clip costs the rasteriser dear.
    let cut = scene.view.is_some()
        && (drawn.iter().any(|(_, pose, body)| page.cuts(pose.position, body.reach))
            || walls.iter().flatten().any(|c| page.cuts(*c, 0.0)));
    let (mut left, mut top) = (page.left, page.top);
    if cut {
        let border = 0.4 * MARGIN * page.unit;
        let [x, y, w, h] =
            [left - border, top - border, page.drawn.x + 2.0 * border, page.drawn.y + 2.0 * border]
                .map(|v| text_of(v, PX));
        *out += &format!("<svg x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\">\n");
        (left, top) = (border, border);
    }
    let scale = page.scale;
    let (x, y) = (left - scale * page.view.low.x, top + scale * page.view.high.y);
    let [s, x, y] = [scale, x, y].map(|v| text_of(v, 6));
    *out += &format!(
        "<g transform=\"matrix({s} 0 0 -{s} {x} {y})\" stroke-linejoin=\"round\" stroke-linecap=\"round\">\n"
    );

    let stroke = text_of(WALL_STROKE * page.unit / scale, 6);
    *out +=
        &format!("<g class=\"walls\" fill=\"none\" stroke=\"{}\" stroke-width=\"{stroke}\">\n", palette.wall);
    walls.iter().for_each(|corners| wall(out, corners));
    *out += "</g>\n";

    let count = drawn.len().max(1) as f64;
    let area = drawn.iter().map(|(_, _, body)| body.area).sum::<f64>() / count;
    let stroke = (BODY_STROKE * page.unit / scale).min(BODY_STROKE_PART * area.max(0.0).sqrt());
    let stroke = text_of(stroke, 6);
    *out += &format!(
        "<g class=\"bodies\" fill=\"{}\" stroke=\"{}\" stroke-width=\"{stroke}\">\n",
        colouring.single, palette.outline
    );
    for (agent, pose, body) in &drawn {
        let id = scene.trial.agents.get(*agent).map_or("", |a| &a.id);
        let fill = colouring.of(*agent);
        *out += "<g transform=\"translate(";
        point(out, pose.position);
        *out += ")rotate(";
        number(out, pose.theta.rem_euclid(std::f64::consts::TAU).to_degrees(), 2);
        *out += ")\"";
        if fill != colouring.single {
            let _ = write!(out, " fill=\"{fill}\"");
        }
        let _ = write!(out, "><title>{}</title><path d=\"{}\"/>", escaped(id), body.outline);
        if style.orientation.shown() {
            mark(out, body, fill);
        }
        *out += "</g>\n";
    }
    *out += "</g>\n";

    if style.ids.shown() {
        let pen = text_of(PEN * lettering::CAP, PX);
        *out += &format!("<g class=\"ids\" fill=\"none\" stroke-width=\"{pen}\">\n");
        for (agent, pose, body) in &drawn {
            if let Some(a) = scene.trial.agents.get(*agent) {
                id_on(out, &a.id, pose, body, colouring.of(*agent));
            }
        }
        *out += "</g>\n";
    }
    *out += "</g>\n";
    if cut {
        *out += "</svg>\n";
    }
}

fn wall(out: &mut String, corners: &[Vec2]) {
    let [first, .., last] = corners else { return };
    *out += "<path d=\"M";
    let closed = first == last && corners.len() > 3;
    let drawn = if closed { &corners[..corners.len() - 1] } else { corners };
    for (k, corner) in drawn.iter().enumerate() {
        *out += if k == 0 { "" } else { "L" };
        point(out, *corner);
    }
    *out += if closed { "Z\"/>\n" } else { "\"/>\n" };
}

/// A small arrow head inside the front.
fn mark(out: &mut String, body: &Body, fill: Colour) {
    let at = |ahead: f64, aside: f64| body.middle + vec2(ahead, aside) * body.front;
    let colour = fill.mixed(fill.contrast(), 0.7);
    let _ = write!(out, "<path fill=\"{colour}\" stroke=\"none\" d=\"M");
    for (k, p) in [at(0.88, 0.0), at(0.58, 0.23), at(0.58, -0.23)].into_iter().enumerate() {
        *out += if k == 0 { "" } else { "L" };
        point(out, p);
    }
    *out += "Z\"/>";
}

/// The id upright in the middle of the body, as large as there is room.
fn id_on(out: &mut String, id: &str, pose: &Pose, body: &Body, fill: Colour) {
    let turn = Rotation::by(pose.theta);
    let middle = pose.position + (body.middle - vec2(0.18 * body.front, 0.0)).rotated(turn);
    let height = (body.front / lettering::width(id, 1.0).max(0.1)).min(0.56 * body.front);
    // In the letters' own grid: whole and half numbers are short and exact.
    let grid = lettering::CAP;
    let (x, y) = (-(0.5 * lettering::width(id, grid)).round(), -0.5 * grid);
    let (anchor, up, decimals) = (Anchor::Start, Up::Positive, 1);
    let mut d = String::new();
    lettering::strokes(&mut d, id, Place { x, y, cap_height: grid, anchor, up, decimals });
    *out += "<path transform=\"translate(";
    point(out, middle);
    let _ =
        writeln!(out, ")scale({})\" stroke=\"{}\" d=\"{d}\"/>", text_of(height / grid, 6), fill.contrast());
}

fn scale_bar(out: &mut String, page: &Page, palette: &Palette) {
    let metres = round_below(0.27 * (page.width - 2.0 * MARGIN * page.unit) / page.scale);
    let label = if metres >= 1000.0 {
        format!("{} km", metres / 1000.0)
    } else if metres >= 1.0 {
        format!("{metres} m")
    } else if metres >= 0.01 {
        format!("{} cm", (metres * 100.0).round())
    } else {
        format!("{} mm", (metres * 1e4).round() / 10.0)
    };
    let cap = CAP_HEIGHT * page.unit;
    let (y, x0) = (page.height - MARGIN * page.unit - 0.5 * cap, page.left.min(MARGIN * page.unit));
    let (x1, tick) = (x0 + metres * page.scale, 0.42 * cap);
    let [ax, bx, up, mid, down] = [x0, x1, y - tick, y, y + tick].map(|v| text_of(v, PX));
    *out += &format!(
        "<path class=\"scale-bar\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" d=\"M{ax} {up}V{down}M{ax} {mid}H{bx}M{bx} {up}V{down}\"/>\n",
        palette.ink,
        text_of(1.2 * page.unit, PX)
    );
    let place = Place { x: x1 + 0.9 * cap, y: y + 0.5 * cap, ..small(page, Anchor::Start) };
    lettered(out, "scale", &label, place, palette.ink);
}

fn colour_bar(out: &mut String, page: &Page, palette: &Palette, title: &str, low: f64, high: f64) {
    let (cap, right) = (CAP_HEIGHT * page.unit, page.width - MARGIN * page.unit);
    let y = page.height - MARGIN * page.unit;
    let numbers = if low == high { [None, Some(short(high))] } else { [Some(short(low)), Some(short(high))] };
    let space = 0.8 * cap;
    let length_of = |t: &Option<String>| t.as_ref().map_or(0.0, |t| lettering::width(t, cap) + space);
    let bar = 0.3 * page.width;
    let x1 = right - length_of(&numbers[1]);
    let x0 = x1 - bar;

    *out += "<g class=\"colour-bar\">\n<linearGradient id=\"viridis\">";
    for (k, colour) in VIRIDIS.iter().enumerate() {
        let offset = text_of(k as f64 / (VIRIDIS.len() - 1) as f64, 4);
        *out += &format!("<stop offset=\"{offset}\" stop-color=\"{colour}\"/>");
    }
    *out += "</linearGradient>\n";
    let fill = if low == high { viridis(0.5).to_string() } else { "url(#viridis)".to_owned() };
    let [x, top, w, h, r] = [x0, y - cap, bar, cap, 0.2 * cap].map(|v| text_of(v, PX));
    *out +=
        &format!("<rect x=\"{x}\" y=\"{top}\" width=\"{w}\" height=\"{h}\" rx=\"{r}\" fill=\"{fill}\"/>\n");
    if let [Some(number), _] = &numbers {
        lettered(out, "low", number, Place { x: x0 - space, y, ..small(page, Anchor::End) }, palette.ink);
    }
    if let [_, Some(number)] = &numbers {
        lettered(out, "high", number, Place { x: x1 + space, y, ..small(page, Anchor::Start) }, palette.ink);
    }
    // A title longer than the bar is centred on it while there is room, and shrinks after that.
    let length = lettering::width(title, cap);
    let room = page.width - 2.0 * MARGIN * page.unit;
    let shrink = (room / length.max(1e-9)).min(1.0);
    let x = (0.5 * (x0 + x1)).min(right - 0.5 * length * shrink);
    let place = Place { x, y: y - 1.9 * cap, ..small(page, Anchor::Middle) };
    lettered(out, "label", title, Place { cap_height: cap * shrink, ..place }, palette.ink);
    *out += "</g>\n";
}

/// The one size of text beside the scene.
fn small(page: &Page, anchor: Anchor) -> Place {
    Place { x: 0.0, y: 0.0, cap_height: CAP_HEIGHT * page.unit, anchor, up: Up::Negative, decimals: PX }
}

/// Text beside the scene; whoever cannot see the strokes reads the label.
fn lettered(out: &mut String, class: &str, text: &str, place: Place, colour: Colour) {
    let mut d = String::new();
    lettering::strokes(&mut d, text, place);
    *out += &format!(
        "<path class=\"{class}\" aria-label=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{}\" \
         stroke-linecap=\"round\" stroke-linejoin=\"round\" d=\"{d}\"/>\n",
        escaped(text),
        text_of(PEN * place.cap_height, PX)
    );
}
