//! A map of density as filled contours.

use crate::body::TENTH_OF_MM;
use crate::colouring::Scale;
use crate::page::Frame;
use crate::scene::Scene;
use crate::text::{escaped, pair, text_of};
use contour::ContourBuilder;

/// Shades of a map of density.
const SHADES: usize = 24;

/// Areas above one level after the other, each painted over the one before.
pub(crate) fn isobands(out: &mut String, scene: &Scene, frame: &Frame, scale: &Scale) {
    let Some(map) = &scene.density else { return };
    let (view, (columns, rows), cell) = (map.view(), map.cells(), map.cell());
    let shade = |k: usize| (k as f64 + 0.5) / SHADES as f64;
    let between = |part: f64| scale.low * (1.0 - part) + scale.high * part;
    let [x, y, w, h] = [view.low.x, view.low.y, view.high.x - view.low.x, view.high.y - view.low.y]
        .map(|v| text_of(v, TENTH_OF_MM));
    *out += &format!("<desc>{}</desc>\n", escaped(&map.described()));
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
                    pair(&mut d, (p.x, p.y), decimals);
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
