//! Draws everything that is to scale, in metres.

use crate::bicycle::{Bicycle, bicycles};
use crate::body::{Body, begin_at, near, point, polyline};
use crate::colour::{Colour, Palette};
use crate::density::density;
use crate::glyphs::{self, Anchor, PEN, Place};
use crate::page::{CASING, MARGIN, Page, dashes};
use crate::scene::{Force, Scene};
use crate::sheet::Frame;
use crate::style::{Colouring, Style};
use crate::text::{PX, escaped, text_of};
use lemons_core::plane::{Pose, Rotation, Vec2, vec2};
use std::fmt::Write;

/// \[px\] Width of walls.
const WALL_STROKE: f64 = 2.4;
/// \[px\] Largest width of the outline of a body.
const BODY_STROKE: f64 = 1.1;
/// Width of the outline of a body / square root of its area.
const BODY_STROKE_PART: f64 = 0.05;

/// Largest height of an Id / half depth of a body.
const TALLEST_ID: f64 = 0.56;
/// Ids with less room than this fraction of the median are left out, so that one small body does not make all Ids
/// small.
const LEAST_ID: f64 = 0.5;
/// \[px\] Objects that are cut extend this far beyond the view.
pub(crate) const CUT_BORDER: f64 = 0.4 * MARGIN;

/// \[px\] Halo on each side of a line of force; at most the width of the line.
pub(crate) const FORCE_HALO: f64 = 0.8;
/// \[px\] Width of a trail.
pub(crate) const TRAIL_STROKE: f64 = 1.5;
/// \[px\] Halo on each side of a trail.
const TRAIL_HALO: f64 = 0.9;
/// \[px\] Points of a trail nearer than this to the previous one are left out.
const TRAIL_STEP: f64 = 0.4;
/// Number of shades of a trail.
const AGES: usize = 8;

/// Returns the bodies on the page, with their indices.
fn seen<'a>(scene: &'a Scene, frame: &Frame) -> Vec<(usize, &'a Pose, &'a Body)> {
    scene.drawn().filter(|(_, pose, body)| !frame.misses(pose.position, body.reach)).collect()
}

fn ridden<'a>(scene: &'a Scene, frame: &Frame) -> Vec<&'a Bicycle> {
    scene.drawn_bicycles().filter(|b| !frame.misses(b.pose.position, b.reach())).collect()
}

fn walls_of(scene: &Scene) -> Vec<Vec<Vec2>> {
    let finite = |corners: &[Vec2]| corners.iter().copied().filter(|c| near(*c)).collect();
    scene.trial.geometry.walls.iter().map(|wall| finite(&wall.corners)).collect()
}

/// Returns whether the view cuts anything. Clipping makes rasterizing slow.
pub(crate) fn is_cut(scene: &Scene, frame: &Frame) -> bool {
    let trails = scene.trails.iter().flat_map(|t| t.points.iter().copied());
    let mut lines = trails.chain(drawable_forces(scene).flat_map(|f| [f.from, f.to])).filter(|p| near(*p));
    seen(scene, frame).iter().any(|(_, pose, body)| frame.cuts(pose.position, body.reach))
        || ridden(scene, frame).iter().any(|b| frame.cuts(b.pose.position, b.reach()))
        || walls_of(scene).iter().flatten().any(|c| frame.cuts(*c, 0.0))
        || lines.any(|p| frame.cuts(p, 0.0))
}

/// Draws the scene into the frame, with lines of force of a width \[px/N\]; `cut`: without what is beyond the frame.
pub(crate) fn world(
    page: &mut Page,
    scene: &Scene,
    style: &Style,
    force_scale: f64,
    frame: &Frame,
    colouring: &Colouring,
    cut: bool,
) {
    let Page { out, palette, .. } = page;
    // Trails that are compared with measured ones must be seen completely.
    let compared = measured(&[scene]);
    let mut colouring = colouring.clone();
    if colouring.scale.is_none() && compared {
        // Bodies of one colour become paler, so that the colours of the trails stand out.
        colouring.single = colouring.single.mixed(palette.paper, 0.6);
    }
    let (drawn, walls) = (seen(scene, frame), walls_of(scene));
    let (mut left, mut top) = (frame.left, frame.top);
    if cut {
        let border = CUT_BORDER * frame.unit;
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

    if let (Some(map), Some(scale)) = (&scene.density, &colouring.scale) {
        density(out, map, frame, scale);
    }
    draw_walls(out, &walls, palette, frame, scene.density.is_some());
    if !compared {
        trails(out, scene, palette, frame);
    }
    bodies(out, scene, style, palette, frame, &colouring, &drawn);
    let ridden = ridden(scene, frame);
    let riders = ridden.iter().map(|b| b.rider.0 * b.rider.1).sum::<f64>() / ridden.len().max(1) as f64;
    bicycles(out, &ridden, palette, outline(frame, riders));
    if compared {
        trails(out, scene, palette, frame);
    }
    forces(out, scene, force_scale, frame);
    if style.ids {
        let crossed = !scene.trails.is_empty() || !scene.forces.is_empty();
        let pen = text_of(PEN * glyphs::CAP, PX);
        *out += &format!("<g class=\"ids\" fill=\"none\" stroke-width=\"{pen}\">\n");
        let height = id_height(scene);
        for (agent, pose, body) in &drawn {
            if let Some(a) = scene.trial.agents.get(*agent).filter(|a| room(&a.id, body) >= height) {
                id_on(out, &a.id, height, pose, body, colouring.of(*agent), crossed);
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
        // White on the dark end of the map; dark around it on the bright end and on paper.
        group("halo", Colour::hex(0x1c2b40), 1.6 * WALL_STROKE);
        group("walls", Colour::WHITE, 0.7 * WALL_STROKE);
    } else {
        group("walls", palette.wall, WALL_STROKE);
    }
}

/// \[m\] Width of the outlines of bodies with a mean area \[m²\].
fn outline(frame: &Frame, area: f64) -> f64 {
    (BODY_STROKE * frame.unit / frame.scale).min(BODY_STROKE_PART * area.max(0.0).sqrt())
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
    let stroke = text_of(outline(frame, area), 6);
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
        begin_at(out, pose);
        if fill != colouring.single && !outlined {
            let _ = write!(out, " fill=\"{fill}\"");
        }
        let _ = write!(out, "><title>{}</title><path d=\"{}\"/>", escaped(id), body.outline);
        if style.orientation && !outlined {
            mark(out, body, fill);
        }
        *out += "</g>\n";
    }
    *out += "</g>\n";
}

fn wall(out: &mut String, corners: &[Vec2]) {
    let [first, .., last] = corners else { return };
    *out += "<path d=\"";
    let closed = first == last && corners.len() > 3;
    polyline(out, if closed { &corners[..corners.len() - 1] } else { corners });
    *out += if closed { "Z\"/>\n" } else { "\"/>\n" };
}

/// Draws a small arrow head inside the front.
fn mark(out: &mut String, body: &Body, fill: Colour) {
    let at = |ahead: f64, aside: f64| body.middle + vec2(ahead, aside) * body.front;
    let colour = fill.mixed(fill.contrast(), 0.7);
    let _ = write!(out, "<path fill=\"{colour}\" stroke=\"none\" d=\"");
    polyline(out, &[at(0.88, 0.0), at(0.58, 0.23), at(0.58, -0.23)]);
    *out += "Z\"/>";
}

/// \[m\] Cap height of an Id for which a body has room.
fn room(id: &str, body: &Body) -> f64 {
    (body.front / glyphs::width(id, 1.0).max(0.1)).min(TALLEST_ID * body.front)
}

fn rooms<'a>(scene: &'a Scene) -> impl Iterator<Item = (&'a str, f64)> {
    let named = scene.trial.agents.iter().map(|agent| agent.id.as_str());
    named.zip(&scene.bodies).filter(|(_, body)| !body.disks.is_empty()).map(|(id, body)| (id, room(id, body)))
}

/// \[m\] Cap height of all Ids: the smallest for which there is room, without those left out. It depends on the Trial
/// only, so that it is the same in all frames of a movie.
fn id_height(scene: &Scene) -> f64 {
    let mut all: Vec<f64> = rooms(scene).map(|(_, room)| room).collect();
    all.sort_by(f64::total_cmp);
    let Some(middle) = all.get(all.len().saturating_sub(1) / 2) else { return 0.0 };
    all.iter().copied().find(|room| *room >= LEAST_ID * middle).unwrap_or(*middle)
}

/// Returns the Ids that pictures leave out because they would be much smaller than the others.
pub fn ids_without_room<'a>(scene: &'a Scene) -> Vec<&'a str> {
    let height = id_height(scene);
    rooms(scene).filter(|(_, room)| *room < height).map(|(id, _)| id).collect()
}

/// Draws the Id upright in the middle of the body, with a halo where lines cross it.
fn id_on(out: &mut String, id: &str, height: f64, pose: &Pose, body: &Body, fill: Colour, crossed: bool) {
    let turn = Rotation::by(pose.orientation);
    let middle = pose.position + (body.middle - vec2(0.18 * body.front, 0.0)).rotated(turn);
    // In units of the letters' grid: integers and halves are short and exact.
    let grid = glyphs::CAP;
    let (x, y) = (-(0.5 * glyphs::width(id, grid)).round(), -0.5 * grid);
    let (anchor, up, decimals) = (Anchor::Start, 1.0, 1);
    let mut d = String::new();
    glyphs::strokes(&mut d, id, Place { x, y, cap_height: grid, anchor, up, decimals });
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

/// Returns whether trails are compared with measured ones.
pub(crate) fn measured(scenes: &[&Scene]) -> bool {
    scenes.iter().flat_map(|s| &s.trails).any(|t| t.measured)
}

/// Returns the forces that can be drawn.
pub(crate) fn drawable_forces<'a>(scene: &'a Scene) -> impl Iterator<Item = &'a Force> {
    let drawable =
        |f: &&Force| near(f.from) && near(f.to) && f.normal_force.is_finite() && f.normal_force > 0.0;
    scene.forces.iter().filter(drawable)
}

/// Splits points at those that cannot be drawn, and removes points too close to be seen. Single points are dropped.
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
        // A person who stood still has no trail: a dot would be only halo.
        if kept.len() > 2 || matches!(kept[..], [a, b] if (b - a).norm() >= step) {
            all.push(kept);
        }
    }
    all
}

pub(crate) fn trails(out: &mut String, scene: &Scene, palette: &Palette, frame: &Frame) {
    if scene.trails.is_empty() {
        return;
    }
    let px = frame.unit / frame.scale;
    let [core, cased, casing] =
        [0.0, TRAIL_HALO, CASING].map(|around| text_of((TRAIL_STROKE + 2.0 * around) * px, 6));
    let step = TRAIL_STEP * px;
    if !measured(&[scene]) {
        // The body at the end of a trail shows whose it is. Pieces of the same age are one path.
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
            let [halo, line] =
                [0.6 * opacity, opacity].map(|v| format!(" stroke-opacity=\"{}\"", text_of(v, 3)));
            path(out, "halo", palette.paper, &cased, &halo, d);
            path(out, "simulated", palette.ink, &core, &line, d);
        }
        *out += "</g>\n";
        return;
    }
    let mut lines: Vec<_> = scene
        .trails
        .iter()
        .map(|trail| {
            let mut d = String::new();
            pieces(&trail.points, step).iter().for_each(|piece| polyline(&mut d, piece));
            (trail.measured, palette.series(trail.agent), d)
        })
        .filter(|(_, _, d)| !d.is_empty())
        .collect();
    // Draw dashed lines last, so that solid lines do not hide them.
    lines.sort_by_key(|(measured, _, _)| *measured);
    let all: String = lines.iter().map(|(_, _, d)| d.as_str()).collect();
    *out += "<g class=\"trails\" fill=\"none\">\n";
    path(out, "halo", palette.paper, &cased, " stroke-opacity=\".85\"", &all);
    let [around, dashed] = dashes(px);
    for (measured, colour, d) in &lines {
        if *measured {
            path(out, "casing", palette.paper, &casing, &around, d);
            path(out, "measured", *colour, &core, &dashed, d);
        } else {
            path(out, "simulated", *colour, &core, "", d);
        }
    }
    *out += "</g>\n";
}

fn path(out: &mut String, class: &str, colour: Colour, width: &str, more: &str, d: &str) {
    *out +=
        &format!("<path class=\"{class}\" stroke=\"{colour}\" stroke-width=\"{width}\"{more} d=\"{d}\"/>\n");
}

/// Draws all halos below all lines, so that a chain of forces looks connected.
pub(crate) fn forces(out: &mut String, scene: &Scene, force_scale: f64, frame: &Frame) {
    if scene.forces.is_empty() {
        return;
    }
    let px = frame.unit / frame.scale;
    // Weak forces first, so that they do not cross strong ones.
    let mut drawn: Vec<(f64, &Force)> =
        drawable_forces(scene).map(|f| (f.normal_force * force_scale / frame.scale, f)).collect();
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
    group("force-halos", Colour::WHITE, FORCE_HALO * px);
    group("forces", Colour::FORCE, 0.0);
}
