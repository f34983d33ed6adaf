//! Lines below or over the bodies: their trails, and the forces between them.

use crate::body::polyline;
use crate::colour::{Colour, Palette};
use crate::look::{CASING, FORCE_HALO, Look, TRAIL_STROKE, dashes, drawable_forces, measured};
use crate::page::Frame;
use crate::plane::near;
use crate::scene::{Force, Scene, TrailKind};
use crate::text::text_of;
use lemons_core::plane::Vec2;
use std::fmt::Write;

/// \[px\] Halo on each side of a trail.
const TRAIL_HALO: f64 = 0.9;
/// \[px\] Points of a trail nearer than this to the previous one are left out.
const TRAIL_STEP: f64 = 0.4;
/// Number of shades of a trail.
const AGES: usize = 8;

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
    let mut lines: Vec<_> = scene
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
    // Draw dashed lines last, so that solid lines do not hide them.
    lines.sort_by_key(|(kind, _, _)| *kind == TrailKind::Measured);
    let all: String = lines.iter().map(|(_, _, d)| d.as_str()).collect();
    *out += &format!(
        "<g class=\"trails\" fill=\"none\">\n\
         <path class=\"halo\" stroke=\"{}\" stroke-width=\"{cased}\" stroke-opacity=\".85\" d=\"{all}\"/>\n",
        palette.paper
    );
    let [around, dashed] = dashes(px);
    for (kind, colour, d) in &lines {
        let (class, dashed) = match kind {
            TrailKind::Simulated => ("simulated", ""),
            TrailKind::Measured => ("measured", dashed.as_str()),
        };
        if *kind == TrailKind::Measured {
            let paper = palette.paper;
            *out += &format!(
                "<path class=\"casing\" stroke=\"{paper}\" stroke-width=\"{casing}\"{around} d=\"{d}\"/>\n"
            );
        }
        *out += &format!(
            "<path class=\"{class}\" stroke=\"{colour}\" stroke-width=\"{core}\"{dashed} d=\"{d}\"/>\n"
        );
    }
    *out += "</g>\n";
}

/// Draws all halos below all lines, so that a chain of forces looks connected.
pub(crate) fn forces(out: &mut String, scene: &Scene, look: &Look, frame: &Frame) {
    if scene.forces.is_empty() {
        return;
    }
    let px = frame.unit / frame.scale;
    // Weak forces first, so that they do not cross strong ones.
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
