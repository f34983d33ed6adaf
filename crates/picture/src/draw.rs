//! Draws one scene on a page.

use crate::colour::Colour;
use crate::colouring::Colouring;
use crate::furniture::{Header, colour_bar, footer_height, lettered, scale_bar, small};
use crate::lettering::{Anchor, Place};
use crate::look::Look;
use crate::page::{CAP_HEIGHT, Frame, MARGIN, NOMINAL_WIDTH, Page, page_width, view_of};
use crate::scene::Scene;
use crate::style::Style;
use crate::text::{PX, escaped, text_of};
use crate::world::world;

/// Returns the scene as SVG.
///
/// Groups, from the lowest: `density`, `walls`, `bodies` (one group for each agent, in their order, with the agent's Id
/// as title), `bicycles`, `trails` (paths of class `simulated` and `measured`; below the bodies if none is measured),
/// `forces`, `ids`. Outside the scene, in pixels: `time`, `legend`, `scale-bar`, `colour-bar`.
pub fn svg(scene: &Scene, style: &Style) -> String {
    let width = page_width(style.width);
    let unit = width / NOMINAL_WIDTH;
    let margin = MARGIN * unit;
    let colouring = Colouring::new(scene, &style.fill, style.theme);
    let bar = colouring.scale.as_ref();
    let time = style.time.filter(|t| t.is_finite()).map(|t| stamp(t, style.time_decimals));

    let mut frame = Frame::fit(view_of(scene), unit, margin, width - 2.0 * margin, margin);
    let look = Look::new(style, &[scene], &frame);
    let legend = look.legend(&[scene], unit);
    let alone = legend.is_empty();
    let header = Header::new(time.as_deref(), legend, unit, width);
    frame.top += header.height;
    let footer = footer_height(bar.is_some()) * unit;
    let height = (frame.top + frame.drawn.y + footer + margin - 1e-6).ceil();
    let page = Page { unit, width, height };

    let mut out = String::new();
    begin(&mut out, &page, &scene.trial.name, look.palette.paper);
    world(&mut out, scene, &look, &frame, &colouring);
    if let Some(text) = &time {
        let x = if alone { frame.left } else { margin };
        let place = Place { x, y: margin + CAP_HEIGHT * unit, ..small(unit, Anchor::Start) };
        lettered(&mut out, "time", text, place, look.palette.ink);
    }
    header.draw(&mut out, &page, &look.palette, margin);
    scale_bar(&mut out, &page, &look.palette, frame.scale, 0.27 * (width - 2.0 * margin));
    if let Some(scale) = bar {
        colour_bar(&mut out, &page, &look.palette, scale);
    }
    out += "</svg>\n";
    out
}

/// The time as text.
pub(crate) fn stamp(t: f64, decimals: usize) -> String {
    let decimals = decimals.min(9);
    format!("t = {t:.decimals$} s")
}

/// Begins the page and fills it with the colour of the paper.
pub(crate) fn begin(out: &mut String, page: &Page, title: &str, paper: Colour) {
    let (w, h) = (text_of(page.width, PX), text_of(page.height, PX));
    *out += &format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" role=\"img\">\n\
         <title>{}</title>\n<rect width=\"{w}\" height=\"{h}\" fill=\"{}\"/>\n",
        escaped(title),
        paper
    );
}
