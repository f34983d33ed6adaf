//! Draws scenes on a page: one, or several in rows and columns.

use crate::body::near;
use crate::colour::{Colour, Palette};
use crate::colouring::{Colouring, kinds};
use crate::frame::Frame;
use crate::glyphs::{self, START};
use crate::page::{
    BAND_GAP, CAP_HEIGHT, Entry, Header, MARGIN, NOMINAL_WIDTH, Page, footer_height, page_width,
};
use crate::scene::{MarkKind, PictureScene};
use crate::style::{Fill, Style};
use crate::text::{in_units, round_below};
use crate::world::{
    CUT_BORDER, FORCE_HALO, MARK_STROKE, TRAIL_STROKE, drawable_forces, is_cut, mean, measured, world,
};
use lemons_core::plane::{Bounds, vec2};
use std::collections::BTreeSet;

/// \[px\] Distance between two panels.
const GUTTER: f64 = 14.0;
/// Size of letters and lines where panels are beside each other, relative to the page of a single scene.
const FINER: f64 = 0.85;
/// \[m\] Smallest width and height of a view.
const SMALLEST_VIEW: f64 = 0.01;
/// \[px\] Largest width of a line of force (for the largest force, or limited by small bodies).
const FORCE_STROKE: f64 = 6.0;
/// Largest width of a line of force / square root of a body's area.
const FORCE_PART: f64 = 0.2;
/// \[px\] Width of the line of a kind in the legend.
const KIND_STROKE: f64 = 5.0;

/// Returns the scene as SVG.
///
/// Groups, from the lowest: `density`, `walls`, `loads`, `marks` (paths of class `exit`, `distribution` and `way-point`, with their names
/// as titles), `bodies` (one group for each agent, in their order, with the agent's Id
/// as title), `feet`, `leans`, `trails` (paths of class `simulated` and `measured`; below the bodies if none is measured),
/// `forces`, `ids`. Outside the scene, in pixels: `time`, `legend`, `scale-bar`, `colour-bar`.
pub fn svg(scene: &PictureScene, style: &Style) -> String {
    sheet(&[(scene, style)], 1)
}

/// Returns several scenes as one SVG, row by row in `columns` columns. All share one scale, view, colour bar, scale bar
/// and width of forces; everything but times and colours of bodies is as the first style says. Letters (a), (b), … are
/// beside the times. The view is the smallest that contains those of all scenes. A colour scale without a given range
/// covers the values of all scenes.
///
/// Each of several scenes is a group `panel` that contains the groups of [`svg`].
pub fn sheet(panels: &[(&PictureScene, &Style)], columns: usize) -> String {
    let [(first, style), ..] = panels else { return String::new() };
    let alone = panels.len() == 1;
    let columns = columns.clamp(1, panels.len());
    let rows = panels.len().div_ceil(columns);
    let scenes: Vec<&PictureScene> = panels.iter().map(|(scene, _)| *scene).collect();
    let width = page_width(style.width);
    let colourings = Colouring::of_all(panels);
    let bar = colourings.iter().find_map(|colouring| colouring.scale.as_ref());

    let decimals = style.time_decimals.min(9);
    let heading = |(k, (_, style)): (usize, &(&PictureScene, &Style))| {
        let time = style.time.filter(|t| t.is_finite());
        let time = time.map_or(String::new(), |t| format!("t = {t:.decimals$} s"));
        // (a), (b), … (z), (aa), (bb), …
        let letters = char::from(b'a' + (k % 26) as u8).to_string().repeat(k / 26 + 1);
        if alone { time } else { format!("({letters}) {time}").trim_end().to_owned() }
    };
    let headings: Vec<String> = panels.iter().enumerate().map(heading).collect();
    // The time of a single scene is beside the legend.
    let time = if alone { headings[0].as_str() } else { "" };
    let mut unit = width / NOMINAL_WIDTH * if columns > 1 { FINER } else { 1.0 };
    let view = Bounds::of(scenes.iter().map(|s| view_of(s)).flat_map(|view| [view.low, view.high]));
    let view = view.unwrap_or(Bounds::UNIT);
    let (mut gutter, mut gap) = (GUTTER, 1.3 * BAND_GAP);
    if !alone {
        // Objects that extend beyond their panel are cut, so that they do not reach the next one.
        let anywhere = Frame::fit(view, unit, 0.0, width, 0.0);
        if scenes.iter().any(|scene| is_cut(scene, &anywhere)) {
            gutter += 2.0 * CUT_BORDER;
            gap += 2.0 * CUT_BORDER;
        }
        // As large as on the page of a single scene, if the headings leave room.
        let widest = headings.iter().map(|h| glyphs::width(h, CAP_HEIGHT)).fold(0.0, f64::max);
        let needed = columns as f64 * widest + 2.0 * MARGIN + (columns - 1) as f64 * gutter;
        unit = unit.min(width / needed);
    }
    let (margin, gap) = (MARGIN * unit, gap * unit);
    let cell = (width - 2.0 * margin - (columns - 1) as f64 * gutter * unit) / columns as f64;

    let Frame { scale, left, drawn, .. } = Frame::fit(view, unit, margin, cell, margin);
    let (force_scale, legend) = forces_and_legend(&scenes, style, unit, scale);
    let left_of_time = if legend.is_empty() { left } else { margin };
    let header = Header::new(time, legend, unit, width);
    let heading = if alone { 0.0 } else { (CAP_HEIGHT + 7.0) * unit };
    let pitch = heading + drawn.y + gap;
    let top = margin + header.height;
    let footer = footer_height(bar.is_some()) * unit;
    let height = (top + rows as f64 * pitch - gap + footer + margin - 1e-6).ceil();

    let mut page = Page::begin(&first.trial.name, style.theme, unit, width, height);
    for (k, (scene, colouring)) in scenes.iter().zip(&colourings).enumerate() {
        let (column, row) = (k % columns, k / columns);
        let left = margin + column as f64 * (cell + gutter * unit);
        let above = top + row as f64 * pitch;
        let frame = Frame::fit(view, unit, left, cell, above + heading);
        let cut = (!alone || scene.view.is_some()) && is_cut(scene, &frame);
        if !alone {
            page.out += "<g class=\"panel\">\n";
            // Above the left edge of the scene, or at the start of the cell if the scene is narrower than the heading.
            let length = glyphs::width(&headings[k], CAP_HEIGHT * unit);
            let x = if length <= drawn.x { frame.left } else { left };
            page.text("time", &headings[k], page.place(x, above + CAP_HEIGHT * unit, START));
        }
        // Doors are as at the time of the panel.
        let style = Style { time: panels[k].1.time, ..(*style).clone() };
        world(&mut page, (scene, &style), &frame, colouring.clone(), force_scale, cut);
        if !alone {
            page.out += "</g>\n";
        }
    }
    if !time.is_empty() {
        page.text("time", time, page.place(left_of_time, margin + CAP_HEIGHT * unit, START));
    }
    header.draw(&mut page);
    page.scale_bar(scale, if alone { 0.27 * cell } else { (100.0 * unit).min(cell) });
    if let Some(scale) = bar {
        page.colour_bar(scale);
    }
    page.end()
}

/// Returns the view of a scene, not smaller than can be drawn.
fn view_of(scene: &PictureScene) -> Bounds {
    let view = scene.view.filter(|v| near(v.low) && near(v.high)).unwrap_or_else(|| scene.extent());
    let size = view.size();
    let grow = |size: f64| 0.5 * (SMALLEST_VIEW - size).max(0.0);
    let by = vec2(grow(size.x), grow(size.y));
    Bounds { low: view.low - by, high: view.high + by }
}

/// Returns the width of lines of force \[px/N\] in these scenes at a scale \[px/m\], and the legend for their lines.
fn forces_and_legend(scenes: &[&PictureScene], style: &Style, unit: f64, scale: f64) -> (f64, Vec<Entry>) {
    let palette = Palette::of(style.theme);
    let mut legend = Vec::new();
    // A given force belongs to a movie: its legend stays when there are no forces.
    let given = style.forces.filter(|f| f.is_finite() && *f > 0.0);
    let forces = scenes.iter().flat_map(|s| drawable_forces(s)).map(|f| f.normal_force);
    let largest = given.unwrap_or_else(|| forces.fold(0.0, f64::max));
    let mut force_scale = 0.0;
    if largest > 0.0 {
        let areas = scenes.iter().flat_map(|s| s.drawn()).map(|(_, _, body)| body.area);
        let size = mean(areas).max(0.0).sqrt();
        let by_size = if size > 0.0 { FORCE_PART * size * scale } else { f64::INFINITY };
        force_scale = (FORCE_STROKE * unit).min(by_size) / largest;
        let newton = round_below(largest);
        let label = in_units(newton, &[(1000.0, "kN"), (1.0, "N"), (0.001, "mN")]);
        let width = newton * force_scale;
        let halo = Some((Colour::WHITE, (FORCE_HALO * unit).min(width)));
        legend.push(Entry { class: "force", label, colour: Colour::FORCE, width, halo, dashed: false });
    }
    if measured(scenes) {
        let simulated = |s: &&PictureScene| s.trails.iter().any(|t| !t.measured);
        let without = if scenes.iter().any(simulated) { 0 } else { 1 };
        legend.extend(Entry::simulated_and_measured(&palette, TRAIL_STROKE * unit).into_iter().skip(without));
    }
    if style.fill == Fill::Kind {
        let halo = Some((palette.outline, FORCE_HALO * unit));
        let entry = |(place, kind): (usize, &str)| {
            let (label, colour, width) = (kind.to_owned(), palette.kind(place), KIND_STROKE * unit);
            Entry { class: "kind", label, colour, width, halo, dashed: false }
        };
        legend.extend(kinds(scenes.iter().copied()).into_iter().enumerate().map(entry));
    }
    let kinds: BTreeSet<MarkKind> = scenes.iter().flat_map(|s| &s.marks).map(|mark| mark.kind).collect();
    legend.extend(kinds.into_iter().map(|kind| {
        let (class, colour) = (kind.class(), kind.colour(&palette));
        Entry { class, label: class.to_owned(), colour, width: MARK_STROKE * unit, halo: None, dashed: false }
    }));
    (force_scale, legend)
}
