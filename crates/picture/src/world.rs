//! Everything to scale, in metres.

use crate::body::{Body, TENTH_OF_MM, point};
use crate::colour::{Colour, Palette};
use crate::colouring::{Colouring, Scale};
use crate::furniture::Entry;
use crate::lettering::{self, Anchor, PEN, Place, Up};
use crate::page::{Frame, MARGIN};
use crate::scene::{Force, Pose, Scene, TrailKind, near};
use crate::style::Style;
use crate::text::{PX, escaped, number, round_below, text_of};
use contour::ContourBuilder;
use crowd_mechanics::engine::{Rotation, Vec2, vec2};
use std::fmt::Write;

/// \[px\]
const WALL_STROKE: f64 = 2.4;
/// \[px\] at most; small bodies have finer outlines.
const BODY_STROKE: f64 = 1.1;
/// Outline of a body, as a part of the square root of its area.
const BODY_STROKE_PART: f64 = 0.05;
/// \[px\] at most: the greatest force, or a part of a small body's size.
const FORCE_STROKE: f64 = 6.0;
/// The widest line of force, as a part of the square root of a body's area.
const FORCE_PART: f64 = 0.2;
/// \[px\] of the halo on each side of a line of force; no more than the line itself is wide.
const FORCE_HALO: f64 = 0.8;
/// \[px\]
const TRAIL_STROKE: f64 = 1.5;
/// \[px\] on each side.
const TRAIL_HALO: f64 = 0.9;
/// \[px\] dash and gap of what is measured.
const DASH: (f64, f64) = (4.2, 2.6);
/// \[px\] Points of a trail nearer than this to the last one are left out.
const TRAIL_STEP: f64 = 0.4;
/// Pieces of different paleness of a trail.
const AGES: usize = 8;
/// Shades of a map of density.
const SHADES: usize = 24;

/// What is drawn the same in every scene of a page.
pub(crate) struct Look<'a> {
    pub style: &'a Style,
    pub palette: Palette,
    /// \[px/N\]
    pub force_scale: f64,
}

impl Look<'_> {
    /// Lines of force as wide as these scenes at this scale ask for.
    pub fn new<'a>(style: &'a Style, scenes: &[&Scene], frame: &Frame) -> Look<'a> {
        let forces = scenes.iter().flat_map(|s| drawable_forces(s)).map(|f| f.normal_force);
        let given = style.forces.filter(|f| f.is_finite() && *f > 0.0);
        let largest = given.unwrap_or_else(|| forces.fold(0.0, f64::max));
        let areas = || scenes.iter().flat_map(|s| s.drawn()).map(|(_, _, body)| body.area);
        let size = (areas().sum::<f64>() / areas().count().max(1) as f64).max(0.0).sqrt();
        let mut widest = FORCE_STROKE * frame.unit;
        if size > 0.0 {
            widest = widest.min(FORCE_PART * size * frame.scale);
        }
        let force_scale = if largest > 0.0 { widest / largest } else { 0.0 };
        Look { style, palette: Palette::of(style.theme), force_scale }
    }

    /// What the lines of these scenes mean.
    pub fn legend(&self, scenes: &[&Scene], unit: f64) -> Vec<Entry> {
        let mut legend = Vec::new();
        if let Some(newton) = self.sample_force(scenes) {
            let label = if newton >= 1000.0 {
                format!("{} kN", newton / 1000.0)
            } else if newton >= 1.0 {
                format!("{newton} N")
            } else {
                format!("{} mN", (newton * 1e4).round() / 10.0)
            };
            let width = newton * self.force_scale;
            legend.push(Entry {
                class: "force",
                label,
                colour: self.palette.force,
                width,
                halo: Some((self.palette.halo, (FORCE_HALO * unit).min(width))),
                dash: None,
            });
        }
        if measured(scenes) {
            let entry = |class, label: &str, dash| Entry {
                class,
                label: label.to_owned(),
                colour: self.palette.ink,
                width: TRAIL_STROKE * unit,
                halo: None,
                dash,
            };
            let trails = || scenes.iter().flat_map(|s| &s.trails);
            if trails().any(|t| t.kind == TrailKind::Simulated) {
                legend.push(entry("simulated", "simulated", None));
            }
            legend.push(entry("measured", "measured", Some((DASH.0 * unit, DASH.1 * unit))));
        }
        legend
    }

    /// \[N\] the round force of the legend.
    fn sample_force(&self, scenes: &[&Scene]) -> Option<f64> {
        let given = self.style.forces.filter(|f| f.is_finite() && *f > 0.0);
        let forces = || scenes.iter().flat_map(|s| drawable_forces(s)).map(|f| f.normal_force);
        // A fixed scale is a movie's: its legend stays when nobody is touched.
        let largest = given.unwrap_or_else(|| forces().fold(0.0, f64::max));
        (largest > 0.0 && (given.is_some() || forces().next().is_some())).then(|| round_below(largest))
    }
}

fn measured(scenes: &[&Scene]) -> bool {
    scenes.iter().flat_map(|s| &s.trails).any(|t| t.kind == TrailKind::Measured)
}

fn drawable_forces<'a>(scene: &'a Scene) -> impl Iterator<Item = &'a Force> {
    let drawable =
        |f: &&Force| near(f.from) && near(f.to) && f.normal_force.is_finite() && f.normal_force > 0.0;
    scene.forces.iter().filter(drawable)
}

/// Draws the scene where the frame has it.
pub(crate) fn world(out: &mut String, scene: &Scene, look: &Look, frame: &Frame, colouring: &Colouring) {
    let Look { style, palette, .. } = look;
    let pale;
    let colouring = if colouring.scale.is_none() && measured(&[scene]) {
        // Of one colour, bodies are only the ground on which the trails' colours are compared.
        let single = colouring.single.mixed(palette.paper, 0.6);
        pale = Colouring { single, ..colouring.clone() };
        &pale
    } else {
        colouring
    };
    let drawn: Vec<_> = scene
        .drawn()
        .filter(|(_, pose, body)| style.bodies.shown() && !frame.misses(pose.position, body.reach))
        .collect();
    let walls: Vec<Vec<Vec2>> = {
        let finite = |corners: &[Vec2]| corners.iter().copied().filter(|c| near(*c)).collect::<Vec<_>>();
        scene.trial.geometry.walls.iter().map(|w| finite(&w.corners)).collect()
    };
    let lines = || {
        let trails = scene.trails.iter().flat_map(|t| t.points.iter().copied());
        trails.chain(drawable_forces(scene).flat_map(|f| [f.from, f.to])).filter(|p| near(*p))
    };
    // Only a view of the caller's choice can cut anything; a clip costs the rasteriser dear.
    let cut = scene.view.is_some()
        && (drawn.iter().any(|(_, pose, body)| frame.cuts(pose.position, body.reach))
            || walls.iter().flatten().any(|c| frame.cuts(*c, 0.0))
            || lines().any(|p| frame.cuts(p, 0.0)));
    let (mut left, mut top) = (frame.left, frame.top);
    if cut {
        let border = 0.4 * MARGIN * frame.unit;
        let [x, y, w, h] =
            [left - border, top - border, frame.drawn.x + 2.0 * border, frame.drawn.y + 2.0 * border]
                .map(|v| text_of(v, PX));
        *out += &format!("<svg x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\">\n");
        (left, top) = (border, border);
    }
    let scale = frame.scale;
    let (x, y) = (left - scale * frame.view.low.x, top + scale * frame.view.high.y);
    let [s, x, y] = [scale, x, y].map(|v| text_of(v, 6));
    *out += &format!(
        "<g transform=\"matrix({s} 0 0 -{s} {x} {y})\" stroke-linejoin=\"round\" stroke-linecap=\"round\">\n"
    );

    let over_density = match (&scene.density, &colouring.scale) {
        (Some(_), Some(scale)) => {
            density(out, scene, frame, scale);
            true
        }
        _ => false,
    };
    draw_walls(out, &walls, palette, frame, over_density);
    bodies(out, scene, style, palette, frame, colouring, &drawn);
    trails(out, scene, palette, frame);
    forces(out, scene, look, frame);
    if style.ids.shown() {
        let crossed = !scene.trails.is_empty() || !scene.forces.is_empty();
        let pen = text_of(PEN * lettering::CAP, PX);
        *out += &format!("<g class=\"ids\" fill=\"none\" stroke-width=\"{pen}\">\n");
        for (agent, pose, body) in &drawn {
            if let Some(a) = scene.trial.agents.get(*agent) {
                id_on(out, &a.id, pose, body, colouring.of(*agent), crossed);
            }
        }
        *out += "</g>\n";
    }
    *out += "</g>\n";
    if cut {
        *out += "</svg>\n";
    }
}

fn draw_walls(out: &mut String, walls: &[Vec<Vec2>], palette: &Palette, frame: &Frame, over_density: bool) {
    let width = |px: f64| text_of(px * frame.unit / frame.scale, 6);
    let mut group = |class: &str, colour: Colour, px: f64| {
        *out += &format!(
            "<g class=\"{class}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{}\">\n",
            width(px)
        );
        walls.iter().for_each(|corners| wall(out, corners));
        *out += "</g>\n";
    };
    if over_density {
        // White on the dark end of the map, dark around it on the bright end and on paper.
        group("halo", Colour(0x1c, 0x2b, 0x40), 1.6 * WALL_STROKE);
        group("walls", Colour(0xff, 0xff, 0xff), 0.7 * WALL_STROKE);
    } else {
        group("walls", palette.wall, WALL_STROKE);
    }
}

fn bodies(
    out: &mut String,
    scene: &Scene,
    style: &Style,
    palette: &Palette,
    frame: &Frame,
    colouring: &Colouring,
    drawn: &[(usize, &Pose, &Body)],
) {
    let count = drawn.len().max(1) as f64;
    let area = drawn.iter().map(|(_, _, body)| body.area).sum::<f64>() / count;
    let stroke = (BODY_STROKE * frame.unit / frame.scale).min(BODY_STROKE_PART * area.max(0.0).sqrt());
    let stroke = text_of(stroke, 6);
    let outlined = scene.density.is_some();
    if outlined {
        *out += &format!(
            "<g class=\"bodies\" fill=\"none\" stroke=\"#ffffff\" stroke-opacity=\".75\" stroke-width=\"{stroke}\">\n"
        );
    } else {
        *out += &format!(
            "<g class=\"bodies\" fill=\"{}\" stroke=\"{}\" stroke-width=\"{stroke}\">\n",
            colouring.single, palette.outline
        );
    }
    for (agent, pose, body) in drawn {
        let id = scene.trial.agents.get(*agent).map_or("", |a| &a.id);
        let fill = colouring.of(*agent);
        *out += "<g transform=\"translate(";
        point(out, pose.position);
        *out += ")rotate(";
        number(out, pose.theta.rem_euclid(std::f64::consts::TAU).to_degrees(), 2);
        *out += ")\"";
        if fill != colouring.single && !outlined {
            let _ = write!(out, " fill=\"{fill}\"");
        }
        let _ = write!(out, "><title>{}</title><path d=\"{}\"/>", escaped(id), body.outline);
        if style.orientation.shown() && !outlined {
            mark(out, body, fill);
        }
        *out += "</g>\n";
    }
    *out += "</g>\n";
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

/// The id upright in the middle of the body, as large as there is room; with a halo where lines cross it.
fn id_on(out: &mut String, id: &str, pose: &Pose, body: &Body, fill: Colour, crossed: bool) {
    let turn = Rotation::by(pose.theta);
    let middle = pose.position + (body.middle - vec2(0.18 * body.front, 0.0)).rotated(turn);
    let height = (body.front / lettering::width(id, 1.0).max(0.1)).min(0.56 * body.front);
    // In the letters' own grid: whole and half numbers are short and exact.
    let grid = lettering::CAP;
    let (x, y) = (-(0.5 * lettering::width(id, grid)).round(), -0.5 * grid);
    let (anchor, up, decimals) = (Anchor::Start, Up::Positive, 1);
    let mut d = String::new();
    lettering::strokes(&mut d, id, Place { x, y, cap_height: grid, anchor, up, decimals });
    let mut path = |colour: Colour, more: &str| {
        *out += "<path transform=\"translate(";
        point(out, middle);
        let _ =
            writeln!(out, ")scale({})\" stroke=\"{colour}\"{more} d=\"{d}\"/>", text_of(height / grid, 6));
    };
    if crossed {
        path(fill, &format!(" stroke-width=\"{}\"", text_of(4.0 * PEN * grid, PX)));
    }
    path(fill.contrast(), "");
}

/// The pieces of a row of points between those that cannot be drawn, thinned to what can be seen; a lone
/// point is none.
fn pieces(points: &[Vec2], step: f64) -> Vec<Vec<Vec2>> {
    let mut all = Vec::new();
    for piece in points.split(|p| !near(*p)) {
        let mut kept: Vec<Vec2> = Vec::new();
        for (k, p) in piece.iter().enumerate() {
            let far = kept.last().is_none_or(|last| (*p - *last).norm() >= step);
            if far || k + 1 == piece.len() {
                kept.push(*p);
            }
        }
        // Whoever stood still has left no trail: a dot would be all halo.
        if kept.len() > 2 || matches!(kept[..], [a, b] if (b - a).norm() >= step) {
            all.push(kept);
        }
    }
    all
}

fn polyline(d: &mut String, points: &[Vec2]) {
    for (k, p) in points.iter().enumerate() {
        d.push(if k == 0 { 'M' } else { 'L' });
        point(d, *p);
    }
}

fn trails(out: &mut String, scene: &Scene, palette: &Palette, frame: &Frame) {
    if scene.trails.is_empty() {
        return;
    }
    let px = frame.unit / frame.scale;
    let [core, cased, dash, gap] =
        [TRAIL_STROKE, TRAIL_STROKE + 2.0 * TRAIL_HALO, DASH.0, DASH.1].map(|v| text_of(v * px, 6));
    let step = TRAIL_STEP * px;
    if !measured(&[scene]) {
        // Whose trail it is, the body at its end says. Pieces of one age are one path.
        let mut ages = vec![String::new(); AGES];
        for trail in &scene.trails {
            let n = trail.points.len();
            for (age, d) in ages.iter_mut().enumerate() {
                let (from, to) = (age * n / AGES, ((age + 1) * n / AGES + 1).min(n));
                for piece in pieces(&trail.points[from.min(to)..to], step) {
                    polyline(d, &piece);
                }
            }
        }
        *out += "<g class=\"trails\" fill=\"none\" stroke-linecap=\"butt\">\n";
        for (age, d) in ages.iter().enumerate().filter(|(_, d)| !d.is_empty()) {
            let opacity = 0.15 + 0.8 * (age + 1) as f64 / AGES as f64;
            let [halo, line] = [0.6 * opacity, opacity].map(|v| text_of(v, 3));
            *out += &format!(
                "<path class=\"halo\" stroke=\"{}\" stroke-width=\"{cased}\" stroke-opacity=\"{halo}\" d=\"{d}\"/>\n\
                 <path class=\"simulated\" stroke=\"{}\" stroke-width=\"{core}\" stroke-opacity=\"{line}\" d=\"{d}\"/>\n",
                palette.paper, palette.ink
            );
        }
        *out += "</g>\n";
        return;
    }
    let lines: Vec<_> = scene
        .trails
        .iter()
        .enumerate()
        .map(|(k, trail)| {
            let mut d = String::new();
            pieces(&trail.points, step).iter().for_each(|piece| polyline(&mut d, piece));
            (trail.kind, palette.series(trail.agent.unwrap_or(k)), d)
        })
        .filter(|(_, _, d)| !d.is_empty())
        .collect();
    let all: String = lines.iter().map(|(_, _, d)| d.as_str()).collect();
    *out += &format!(
        "<g class=\"trails\" fill=\"none\">\n\
         <path class=\"halo\" stroke=\"{}\" stroke-width=\"{cased}\" stroke-opacity=\".85\" d=\"{all}\"/>\n",
        palette.paper
    );
    for (kind, colour, d) in &lines {
        let (class, dashes) = match kind {
            TrailKind::Simulated => ("simulated", String::new()),
            TrailKind::Measured => {
                ("measured", format!(" stroke-linecap=\"butt\" stroke-dasharray=\"{dash} {gap}\""))
            }
        };
        *out += &format!(
            "<path class=\"{class}\" stroke=\"{colour}\" stroke-width=\"{core}\"{dashes} d=\"{d}\"/>\n"
        );
    }
    *out += "</g>\n";
}

/// All halos below all lines, so that a chain of forces is one thing.
fn forces(out: &mut String, scene: &Scene, look: &Look, frame: &Frame) {
    if scene.forces.is_empty() {
        return;
    }
    let px = frame.unit / frame.scale;
    // Weak ones first: a strong one is never crossed by a weak one.
    let mut drawn: Vec<(f64, &Force)> =
        drawable_forces(scene).map(|f| (f.normal_force * look.force_scale / frame.scale, f)).collect();
    drawn.retain(|(width, _)| *width > 0.01 * px);
    drawn.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut group = |class: &str, colour: Colour, halo: f64| {
        *out += &format!("<g class=\"{class}\" fill=\"none\" stroke=\"{colour}\">\n");
        for (width, force) in &drawn {
            let _ = write!(out, "<path stroke-width=\"{}\" d=\"", text_of(width + 2.0 * halo.min(*width), 6));
            polyline(out, &[force.from, force.to]);
            *out += "\"/>\n";
        }
        *out += "</g>\n";
    };
    group("force-halos", look.palette.halo, FORCE_HALO * px);
    group("forces", look.palette.force, 0.0);
}

/// Areas above one level after the other, each painted over the one before.
fn density(out: &mut String, scene: &Scene, frame: &Frame, scale: &Scale) {
    let Some(map) = &scene.density else { return };
    let (view, (columns, rows), cell) = (map.view(), map.cells(), map.cell());
    let shade = |k: usize| (k as f64 + 0.5) / SHADES as f64;
    let between = |part: f64| scale.low * (1.0 - part) + scale.high * part;
    let [x, y, w, h] = [view.low.x, view.low.y, view.high.x - view.low.x, view.high.y - view.low.y]
        .map(|v| text_of(v, TENTH_OF_MM));
    *out += "<g class=\"density\" stroke=\"none\">\n";
    *out += &format!(
        "<rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" fill=\"{}\"/>\n",
        scale.of(between(shade(0)))
    );
    let levels: Vec<f64> = (1..SHADES).map(|k| between(k as f64 / SHADES as f64)).collect();
    let builder = ContourBuilder::new(columns, rows, true)
        .x_origin(view.low.x)
        .y_origin(view.low.y)
        .x_step(cell.x)
        .y_step(cell.y);
    let contours = builder.contours(&map.values(), &levels).unwrap_or_default();
    let decimals = if frame.scale > 300.0 { 4 } else { 3 };
    for (k, contour) in contours.iter().enumerate() {
        let mut d = String::new();
        for polygon in contour.geometry() {
            for ring in std::iter::once(polygon.exterior()).chain(polygon.interiors()) {
                let points = &ring.0[..ring.0.len().saturating_sub(1)];
                for (n, p) in points.iter().enumerate() {
                    d.push(if n == 0 { 'M' } else { 'L' });
                    crate::text::pair(&mut d, (p.x, p.y), decimals);
                }
                d.push('Z');
            }
        }
        if !d.is_empty() {
            let colour = scale.of(between(shade(k + 1)));
            *out += &format!("<path fill=\"{colour}\" fill-rule=\"evenodd\" d=\"{d}\"/>\n");
        }
    }
    *out += "</g>\n";
}
