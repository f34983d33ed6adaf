//! Draws several scenes on one page.

use crate::colouring::{Colouring, Scale};
use crate::draw::{begin, stamp};
use crate::furniture::{Header, colour_bar, footer_height, lettered, scale_bar, small};
use crate::lettering::{self, Anchor, Place};
use crate::look::Look;
use crate::page::{BAND_GAP, CAP_HEIGHT, Frame, MARGIN, NOMINAL_WIDTH, Page, page_width, view_of};
use crate::scene::Scene;
use crate::style::{Fill, Style};
use crate::world::{CUT_BORDER, is_cut, world};
use lemons_core::plane::Bounds;

/// \[px\] Distance between two panels.
const GUTTER: f64 = 14.0;
/// Size of lettering and lines, relative to the page of a single scene.
const FINER: f64 = 0.85;

/// A scene of a sheet.
#[derive(Debug, Clone)]
pub struct Panel<'a> {
    /// The scene.
    pub scene: &'a Scene<'a>,
    /// \[s\] Time, written above the scene.
    pub time: Option<f64>,
    /// Colour of the bodies; `None`: that of the sheet's style.
    pub fill: Option<Fill>,
}

/// Returns several scenes as one SVG, row by row in `columns` columns. All share one scale, view, colour bar, scale bar
/// and width of forces; the style's time is not used. Letters (a), (b), … are beside the times. The view is the smallest that contains those of all scenes. A colour scale without a given
/// range covers the values of all panels.
///
/// Each scene is a group `panel` that contains the groups of [`svg`](crate::svg).
pub fn sheet(panels: &[Panel], columns: usize, style: &Style) -> String {
    let columns = columns.clamp(1, panels.len().max(1));
    let rows = panels.len().div_ceil(columns);
    let scenes: Vec<&Scene> = panels.iter().map(|p| p.scene).collect();
    let width = page_width(style.width);
    let mut colourings: Vec<_> = panels
        .iter()
        .map(|p| Colouring::new(p.scene, p.fill.as_ref().unwrap_or(&style.fill), style.theme))
        .collect();
    let scale = shared(&mut colourings);
    let bar = scale.as_ref();

    let headings: Vec<String> = panels
        .iter()
        .enumerate()
        .map(|(k, panel)| {
            let letter = if panels.len() > 1 { lettered_place(k) } else { String::new() };
            let time = panel
                .time
                .filter(|t| t.is_finite())
                .map(|t| stamp(t, style.time_decimals))
                .unwrap_or_default();
            [letter, time].iter().filter(|t| !t.is_empty()).cloned().collect::<Vec<_>>().join(" ")
        })
        .collect();
    // As large as on the page of a single scene, if the headings leave room.
    let mut unit = width / NOMINAL_WIDTH * if columns > 1 { FINER } else { 1.0 };
    let views = scenes.iter().map(|s| view_of(s));
    let view = Bounds::of(views.flat_map(|view| [view.low, view.high])).unwrap_or(Bounds::UNIT);
    // Objects that extend beyond their panel are cut, so that they do not reach the next one.
    let cut = {
        let anywhere = Frame::fit(view, unit, 0.0, width, 0.0);
        panels.iter().any(|p| is_cut(&Scene { view: Some(view), ..p.scene.clone() }, style, &anywhere))
    };
    let more = if cut { 2.0 * CUT_BORDER } else { 0.0 };
    let gutter = GUTTER + more;
    let cell_at =
        |unit: f64| (width - 2.0 * MARGIN * unit - (columns - 1) as f64 * gutter * unit) / columns as f64;
    let widest = headings.iter().map(|h| lettering::width(h, CAP_HEIGHT)).fold(0.0, f64::max);
    let needed = columns as f64 * widest + 2.0 * MARGIN + (columns - 1) as f64 * gutter;
    unit = unit.min(width / needed);
    let (margin, cell) = (MARGIN * unit, cell_at(unit));

    let frame = Frame::fit(view, unit, margin, cell, margin);
    let look = Look::new(style, &scenes, &frame);
    let header = Header::new(None, look.legend(&scenes, unit), unit, width);
    let heading = if headings.iter().all(String::is_empty) { 0.0 } else { (CAP_HEIGHT + 7.0) * unit };
    let gap = (1.3 * BAND_GAP + more) * unit;
    let pitch = heading + frame.drawn.y + gap;
    let top = margin + header.height;
    let footer = footer_height(bar.is_some()) * unit;
    let gaps = if rows > 0 { gap } else { 0.0 };
    let height = (top + rows as f64 * pitch - gaps + footer + margin - 1e-6).ceil();
    let page = Page { unit, width, height };

    let mut out = String::new();
    begin(&mut out, &page, scenes.first().map_or("", |s| &s.trial.name), look.palette.paper);
    for (k, (panel, colouring)) in panels.iter().zip(&colourings).enumerate() {
        let (column, row) = (k % columns, k / columns);
        let left = margin + column as f64 * (cell + gutter * unit);
        let above = top + row as f64 * pitch;
        let frame = Frame::fit(view, unit, left, cell, above + heading);
        out += "<g class=\"panel\">\n";
        if !headings[k].is_empty() {
            // Above the left edge of the scene, or at the start of the cell if the scene is narrower than the heading.
            let length = lettering::width(&headings[k], CAP_HEIGHT * unit);
            let x = if length <= frame.drawn.x { frame.left } else { left };
            let place = Place { x, y: above + CAP_HEIGHT * unit, ..small(unit, Anchor::Start) };
            lettered(&mut out, "time", &headings[k], place, look.palette.ink);
        }
        let scene = Scene { view: Some(view), ..panel.scene.clone() };
        world(&mut out, &scene, &look, &frame, colouring);
        out += "</g>\n";
    }
    header.draw(&mut out, &page, &look.palette, margin);
    scale_bar(&mut out, &page, &look.palette, frame.scale, (100.0 * unit).min(cell));
    if let Some(scale) = bar {
        colour_bar(&mut out, &page, &look.palette, scale);
    }
    out += "</svg>\n";
    out
}

/// Returns (a), (b), … (z), (aa), …
fn lettered_place(mut k: usize) -> String {
    let mut letters = Vec::new();
    loop {
        letters.push(char::from(b'a' + (k % 26) as u8));
        if k < 26 {
            break;
        }
        k = k / 26 - 1;
    }
    format!("({})", letters.iter().rev().collect::<String>())
}

/// Makes one scale for all: from the lowest to the highest value, with the name of the first.
fn shared(colourings: &mut [Colouring]) -> Option<Scale> {
    let all = || colourings.iter().filter_map(|c| c.scale.as_ref());
    let empty = all().all(|scale| scale.nothing.is_some());
    let scales = || all().filter(|scale| empty || scale.nothing.is_none());
    let first = scales().next()?.clone();
    let low = scales().map(|s| s.low).fold(f64::INFINITY, f64::min);
    let high = scales().map(|s| s.high).fold(f64::NEG_INFINITY, f64::max);
    // Values are clipped only if that holds for the panel with the highest end.
    let clipped = scales().any(|s| s.clipped && s.high == high);
    let scale = Scale { low, high, clipped, ..first };
    colourings.iter_mut().filter(|c| c.scale.is_some()).for_each(|c| c.scale = Some(scale.clone()));
    Some(scale)
}
