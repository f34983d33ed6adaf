//! Several scenes on one page.

use crate::colouring::{Colouring, Scale};
use crate::draw::{begin, stamp};
use crate::furniture::{Header, colour_bar, footer_height, lettered, scale_bar, small};
use crate::lettering::{self, Anchor, Place};
use crate::look::Look;
use crate::page::{BAND_GAP, CAP_HEIGHT, Frame, MARGIN, NOMINAL_WIDTH, Page, page_width, view_of};
use crate::plane::View;
use crate::scene::Scene;
use crate::style::{Fill, Style, Visibility};
use crate::world::{CUT_BORDER, is_cut, world};
use crowd_mechanics::engine::vec2;

/// \[px\] between two panels.
const GUTTER: f64 = 14.0;
/// Part of the lettering of a lone scene's page.
const FINER: f64 = 0.85;

/// One scene of a sheet.
#[derive(Debug, Clone)]
pub struct Panel<'a> {
    /// What is drawn.
    pub scene: &'a Scene<'a>,
    /// \[s\] shown above the scene.
    pub time: Option<f64>,
    /// Colour of the bodies; that of the sheet's style when `None`.
    pub fill: Option<Fill>,
}

/// How a sheet is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct SheetStyle {
    /// Of the whole sheet; `width` is the sheet's. The times are those of the panels, not the style's.
    pub style: Style,
    /// (a), (b), … beside the times.
    pub letters: Visibility,
}

impl Default for SheetStyle {
    fn default() -> SheetStyle {
        SheetStyle { style: Style::default(), letters: Visibility::Shown }
    }
}

/// Several scenes as one SVG, row by row in so many columns: one scale and one view for all, one colour
/// bar, one scale bar, one width per force. The view is the smallest around those of all scenes; a colour
/// scale without a range of its own is that of all panels.
///
/// A group `panel` per scene, with the groups of [`svg`](crate::svg) in it.
pub fn sheet(panels: &[Panel], columns: usize, style: &SheetStyle) -> String {
    let SheetStyle { style, letters } = style;
    let columns = columns.clamp(1, panels.len().max(1));
    let rows = panels.len().div_ceil(columns);
    let scenes: Vec<&Scene> = panels.iter().map(|p| p.scene).collect();
    let width = page_width(style.width);
    let mut colourings: Vec<_> = panels
        .iter()
        .map(|p| Colouring::new(p.scene, p.fill.as_ref().unwrap_or(&style.fill), style.theme))
        .collect();
    let scale = shared(&mut colourings);
    let bar = scale.as_ref().filter(|_| style.colour_bar.shown());

    let headings: Vec<String> = panels
        .iter()
        .enumerate()
        .map(|(k, panel)| {
            let letter = if letters.shown() && panels.len() > 1 { lettered_place(k) } else { String::new() };
            let time = panel
                .time
                .filter(|t| t.is_finite())
                .map(|t| stamp(t, style.time_decimals))
                .unwrap_or_default();
            [letter, time].iter().filter(|t| !t.is_empty()).cloned().collect::<Vec<_>>().join(" ")
        })
        .collect();
    // As on a lone scene's page where the headings leave room for it.
    let mut unit = width / NOMINAL_WIDTH * if columns > 1 { FINER } else { 1.0 };
    let view = scenes.iter().map(|s| view_of(s)).reduce(around);
    let view = view.unwrap_or(View { low: vec2(-0.5, -0.5), high: vec2(0.5, 0.5) });
    // What is cut goes on beyond its panel, and would meet that of the next.
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
    let footer = footer_height(bar.is_some(), style.scale_bar.shown()) * unit;
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
            // Over the scene's own corner, or where the cell begins when the scene is narrower than it.
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
    if style.scale_bar.shown() {
        scale_bar(&mut out, &page, &look.palette, frame.scale, (100.0 * unit).min(cell));
    }
    if let Some(scale) = bar {
        colour_bar(&mut out, &page, &look.palette, scale);
    }
    out += "</svg>\n";
    out
}

/// (a), (b), … (z), (aa), …
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

/// One scale for all: from the lowest to the highest of all, the name of the first.
fn shared(colourings: &mut [Colouring]) -> Option<Scale> {
    let scales = || colourings.iter().filter_map(|c| c.scale.as_ref());
    let first = scales().next()?.clone();
    let low = scales().map(|s| s.low).fold(f64::INFINITY, f64::min);
    let high = scales().map(|s| s.high).fold(f64::NEG_INFINITY, f64::max);
    // Nothing is clipped where the highest of the panels is.
    let clipped = scales().any(|s| s.clipped && s.high == high);
    let scale = Scale { low, high, clipped, ..first };
    colourings.iter_mut().filter(|c| c.scale.is_some()).for_each(|c| c.scale = Some(scale.clone()));
    Some(scale)
}

fn around(a: View, b: View) -> View {
    View {
        low: vec2(a.low.x.min(b.low.x), a.low.y.min(b.low.y)),
        high: vec2(a.high.x.max(b.high.x), a.high.y.max(b.high.y)),
    }
}
