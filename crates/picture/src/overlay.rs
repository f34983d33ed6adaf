//! Lines below or over the bodies: their trails, and the forces between them.

use crate::body::{near, polyline};
use crate::colour::{Colour, Palette};
use crate::page::{CASING, dashes};
use crate::scene::{Force, Scene};
use crate::sheet::Frame;
use crate::text::text_of;
use lemons_core::plane::Vec2;
use std::fmt::Write;

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
