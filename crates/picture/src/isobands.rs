//! Density maps as filled contours.

use crate::body::TENTH_OF_MM;
use crate::colouring::Scale;
use crate::density::DensityMap;
use crate::sheet::Frame;
use crate::text::{escaped, pair, text_of};
use contour::ContourBuilder;
use lemons_core::plane::{Vec2, vec2};
use std::collections::BTreeMap;

/// Number of shades of a density map.
const SHADES: usize = 24;

/// Draws the areas above each level, from the lowest level to the highest.
pub(crate) fn isobands(out: &mut String, map: &DensityMap, frame: &Frame, scale: &Scale) {
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
    let walls = Crossings::new(map);
    let decimals = if frame.scale > 300.0 { 4 } else { 3 };
    for (k, contour) in contours.iter().enumerate() {
        let mut d = String::new();
        for polygon in contour.geometry() {
            for ring in std::iter::once(polygon.exterior()).chain(polygon.interiors()) {
                let points = &ring.0[..ring.0.len().saturating_sub(1)];
                for (n, p) in points.iter().enumerate() {
                    d.push(if n == 0 { 'M' } else { 'L' });
                    let p = walls.ended(vec2(p.x, p.y));
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

/// Crossings of walls with the lines between centres of neighbouring cells. Contours run between the centres; a contour
/// between two sides of a wall is moved onto the wall.
struct Crossings {
    low: Vec2,
    cell: Vec2,
    /// By column and row of the left centre: the position of the crossing, in cells from there.
    along_x: BTreeMap<(i64, i64), f64>,
    /// By column and row of the lower centre.
    along_y: BTreeMap<(i64, i64), f64>,
}

impl Crossings {
    fn new(map: &DensityMap) -> Crossings {
        let (low, cell, (columns, rows)) = (map.view().low, map.cell(), map.cells());
        let mut all = Crossings { low, cell, along_x: BTreeMap::new(), along_y: BTreeMap::new() };
        for side in map.walls() {
            let [a, b] = side.map(|corner| all.in_cells(corner));
            // Each row of centres, then each column.
            for row in within(a.y, b.y, rows) {
                let x = a.x + (b.x - a.x) * (row as f64 - a.y) / (b.y - a.y);
                all.along_x.insert((x.floor() as i64, row), x - x.floor());
            }
            for column in within(a.x, b.x, columns) {
                let y = a.y + (b.y - a.y) * (column as f64 - a.x) / (b.x - a.x);
                all.along_y.insert((column, y.floor() as i64), y - y.floor());
            }
        }
        all
    }

    /// In units of cells: centres have integer coordinates.
    fn in_cells(&self, p: Vec2) -> Vec2 {
        vec2((p.x - self.low.x) / self.cell.x - 0.5, (p.y - self.low.y) / self.cell.y - 0.5)
    }

    /// Moves a corner of a contour onto the wall, if there is one between its two centres.
    fn ended(&self, p: Vec2) -> Vec2 {
        let at = self.in_cells(p);
        let (column, row) = (at.x.floor() as i64, at.y.floor() as i64);
        let whole = |v: f64| (v - v.round()).abs() < 1e-6;
        if whole(at.y)
            && let Some(part) = self.along_x.get(&(column, at.y.round() as i64))
        {
            return vec2(self.low.x + (column as f64 + part + 0.5) * self.cell.x, p.y);
        }
        if whole(at.x)
            && let Some(part) = self.along_y.get(&(at.x.round() as i64, row))
        {
            return vec2(p.x, self.low.y + (row as f64 + part + 0.5) * self.cell.y);
        }
        p
    }
}

/// The integers between two numbers, from 0 to `count`.
fn within(a: f64, b: f64, count: usize) -> std::ops::Range<i64> {
    let (low, high) = (a.min(b).max(-1.0), a.max(b).min(count as f64));
    if a == b { 0..0 } else { low.ceil() as i64..high.floor() as i64 + 1 }
}
