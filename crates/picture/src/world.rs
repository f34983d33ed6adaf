//! Draws everything that is to scale, in metres.

use crate::bicycle::{Bicycle, bicycles};
use crate::body::{Body, point, polyline};
use crate::colour::{Colour, Palette};
use crate::colouring::Colouring;
use crate::ids;
use crate::isobands::isobands;
use crate::lettering::{self, Anchor, PEN, Place, Up};
use crate::look::{Look, drawable_forces, measured};
use crate::overlay::{forces, trails};
use crate::page::{Frame, MARGIN};
use crate::plane::near;
use crate::scene::Scene;
use crate::style::Style;
use crate::text::{PX, escaped, number, text_of};
use lemons_core::plane::{Pose, Rotation, Vec2, vec2};
use std::fmt::Write;

/// \[px\] Width of walls.
const WALL_STROKE: f64 = 2.4;
/// \[px\] Largest width of the outline of a body.
const BODY_STROKE: f64 = 1.1;
/// Width of the outline of a body / square root of its area.
const BODY_STROKE_PART: f64 = 0.05;

/// \[px\] Objects that are cut extend this far beyond the view.
pub(crate) const CUT_BORDER: f64 = 0.4 * MARGIN;

/// The bodies that are drawn, with their indices.
fn seen<'a>(scene: &'a Scene, style: &Style, frame: &Frame) -> Vec<(usize, &'a Pose, &'a Body)> {
    let seen =
        |(_, pose, body): &(usize, &Pose, &Body)| style.bodies && !frame.misses(pose.position, body.reach);
    scene.drawn().filter(seen).collect()
}

fn ridden<'a>(scene: &'a Scene, style: &Style, frame: &Frame) -> Vec<&'a Bicycle> {
    let seen = |b: &&Bicycle| style.bodies && !frame.misses(b.pose.position, b.reach());
    scene.drawn_bicycles().filter(seen).collect()
}

fn walls_of(scene: &Scene) -> Vec<Vec<Vec2>> {
    let finite = |corners: &[Vec2]| corners.iter().copied().filter(|c| near(*c)).collect();
    scene.trial.geometry.walls.iter().map(|wall| finite(&wall.corners)).collect()
}

/// Whether the view cuts anything. Only a view that the caller gives can. Clipping makes rasterizing slow.
pub(crate) fn is_cut(scene: &Scene, style: &Style, frame: &Frame) -> bool {
    let trails = scene.trails.iter().flat_map(|t| t.points.iter().copied());
    let mut lines = trails.chain(drawable_forces(scene).flat_map(|f| [f.from, f.to])).filter(|p| near(*p));
    scene.view.is_some()
        && (seen(scene, style, frame).iter().any(|(_, pose, body)| frame.cuts(pose.position, body.reach))
            || ridden(scene, style, frame).iter().any(|b| frame.cuts(b.pose.position, b.reach()))
            || walls_of(scene).iter().flatten().any(|c| frame.cuts(*c, 0.0))
            || lines.any(|p| frame.cuts(p, 0.0)))
}

/// Draws the scene into the frame.
pub(crate) fn world(out: &mut String, scene: &Scene, look: &Look, frame: &Frame, colouring: &Colouring) {
    let Look { style, palette, .. } = look;
    let pale;
    let colouring = if colouring.scale.is_none() && measured(&[scene]) {
        // Bodies of one colour become paler, so that the colours of the trails stand out.
        let single = colouring.single.mixed(palette.paper, 0.6);
        pale = Colouring { single, ..colouring.clone() };
        &pale
    } else {
        colouring
    };
    let (drawn, walls) = (seen(scene, style, frame), walls_of(scene));
    let cut = is_cut(scene, style, frame);
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

    let over_density = match (&scene.density, &colouring.scale) {
        (Some(_), Some(scale)) => {
            isobands(out, scene, frame, scale);
            true
        }
        _ => false,
    };
    draw_walls(out, &walls, palette, frame, over_density);
    // Trails that are compared with measured ones must be seen completely.
    let compared = measured(&[scene]);
    if !compared {
        trails(out, scene, palette, frame);
    }
    bodies(out, scene, style, palette, frame, colouring, &drawn);
    let ridden = ridden(scene, style, frame);
    let riders = ridden.iter().map(|b| b.rider.0 * b.rider.1).sum::<f64>() / ridden.len().max(1) as f64;
    bicycles(out, &ridden, palette, outline(frame, riders));
    if compared {
        trails(out, scene, palette, frame);
    }
    forces(out, scene, look, frame);
    if style.ids {
        let crossed = !scene.trails.is_empty() || !scene.forces.is_empty();
        let pen = text_of(PEN * lettering::CAP, PX);
        *out += &format!("<g class=\"ids\" fill=\"none\" stroke-width=\"{pen}\">\n");
        let height = ids::height(scene);
        for (agent, pose, body) in &drawn {
            if let Some(a) = scene.trial.agents.get(*agent).filter(|a| ids::fits(&a.id, body, height)) {
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
        group("halo", Colour(0x1c, 0x2b, 0x40), 1.6 * WALL_STROKE);
        group("walls", Colour(0xff, 0xff, 0xff), 0.7 * WALL_STROKE);
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
        *out += "<g transform=\"translate(";
        point(out, pose.position);
        *out += ")rotate(";
        number(out, pose.orientation.rem_euclid(std::f64::consts::TAU).to_degrees(), 2);
        *out += ")\"";
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

/// Draws the Id upright in the middle of the body, with a halo where lines cross it.
fn id_on(out: &mut String, id: &str, height: f64, pose: &Pose, body: &Body, fill: Colour, crossed: bool) {
    let turn = Rotation::by(pose.orientation);
    let middle = pose.position + (body.middle - vec2(0.18 * body.front, 0.0)).rotated(turn);
    // In units of the letters' grid: integers and halves are short and exact.
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
