//! Widths and meanings of lines.

use crate::bicycle::Bicycle;
use crate::colour::Palette;
use crate::furniture::Entry;
use crate::page::Frame;
use crate::plane::near;
use crate::scene::{Force, Scene, TrailKind};
use crate::style::Style;
use crate::text::{round_below, text_of};

/// \[px\] Largest width of a line of force (for the largest force, or limited by small bodies).
const FORCE_STROKE: f64 = 6.0;
/// Largest width of a line of force / square root of a body's area.
const FORCE_PART: f64 = 0.2;
/// \[px\] Halo on each side of a line of force; at most the width of the line.
pub(crate) const FORCE_HALO: f64 = 0.8;
/// \[px\] Width of a trail.
pub(crate) const TRAIL_STROKE: f64 = 1.5;
/// \[px\] Width of the line of a bicycle in the legend.
const BICYCLE_STROKE: f64 = 5.0;
/// \[px\] Dash and gap of measured lines.
pub(crate) const DASH: (f64, f64) = (4.2, 3.4);
/// \[px\] Border of paper around each dash. So dashes are visible on a solid line of their colour, and that line
/// between the dashes.
pub(crate) const CASING: f64 = 0.9;

/// As SVG: the dashes of the border and those of the measured line; `px` is one pixel.
pub(crate) fn dashes(px: f64) -> [String; 2] {
    let pattern = |dash: f64, gap: f64, begun: f64| {
        let [dash, gap, begun] = [dash, gap, begun].map(|v| text_of(v * px, 6));
        format!(" stroke-linecap=\"butt\" stroke-dasharray=\"{dash} {gap}\" stroke-dashoffset=\"{begun}\"")
    };
    [pattern(DASH.0 + 2.0 * CASING, DASH.1 - 2.0 * CASING, CASING), pattern(DASH.0, DASH.1, 0.0)]
}

/// Settings that are the same in every scene of a page.
pub(crate) struct Look<'a> {
    pub style: &'a Style,
    pub palette: Palette,
    /// \[px/N\] Width of lines of force.
    pub force_scale: f64,
}

impl Look<'_> {
    /// Chooses the width of lines of force for these scenes at this scale.
    pub fn new<'a>(style: &'a Style, scenes: &[&Scene], frame: &Frame) -> Look<'a> {
        let largest = largest_force(style, scenes);
        let areas = || scenes.iter().flat_map(|s| s.drawn()).map(|(_, _, body)| body.area);
        let size = (areas().sum::<f64>() / areas().count().max(1) as f64).max(0.0).sqrt();
        let mut widest = FORCE_STROKE * frame.unit;
        if size > 0.0 {
            widest = widest.min(FORCE_PART * size * frame.scale);
        }
        let force_scale = if largest > 0.0 { widest / largest } else { 0.0 };
        Look { style, palette: Palette::of(style.theme), force_scale }
    }

    /// Returns the legend for the lines of these scenes.
    pub fn legend(&self, scenes: &[&Scene], unit: f64) -> Vec<Entry> {
        let mut legend = Vec::new();
        if let Some(newton) = self.sample_force(scenes) {
            let label = if newton >= 1000.0 {
                format!("{} kN", newton / 1000.0)
            } else if newton >= 1.0 {
                format!("{newton} N")
            } else {
                format!("{} mN", (newton * 1e4).round() / 10.0)
            };
            let width = newton * self.force_scale;
            legend.push(Entry {
                class: "force",
                label,
                colour: self.palette.force,
                width,
                halo: Some((self.palette.halo, (FORCE_HALO * unit).min(width))),
                dash: None,
            });
        }
        if measured(scenes) {
            let width = TRAIL_STROKE * unit;
            let trails = || scenes.iter().flat_map(|s| &s.trails);
            if trails().any(|t| t.kind == TrailKind::Simulated) {
                legend.push(Entry::of_line("simulated", &self.palette, width));
            }
            legend.push(Entry::of_line("measured", &self.palette, width).dashed(unit));
        }
        if scenes.iter().any(|scene| scene.drawn_bicycles().next().is_some()) {
            legend.push(Entry {
                class: "bicycle",
                label: "bicycle with rider".to_owned(),
                colour: Bicycle::FILL,
                width: BICYCLE_STROKE * unit,
                halo: Some((self.palette.outline, FORCE_HALO * unit)),
                dash: None,
            });
        }
        legend
    }

    /// \[N\] The round force in the legend.
    fn sample_force(&self, scenes: &[&Scene]) -> Option<f64> {
        let largest = largest_force(self.style, scenes);
        (largest > 0.0).then(|| round_below(largest))
    }
}

/// \[N\] The force with the widest line. A given one belongs to a movie: its legend stays when there are no forces.
fn largest_force(style: &Style, scenes: &[&Scene]) -> f64 {
    let given = style.forces.filter(|f| f.is_finite() && *f > 0.0);
    let forces = scenes.iter().flat_map(|s| drawable_forces(s)).map(|f| f.normal_force);
    given.unwrap_or_else(|| forces.fold(0.0, f64::max))
}

pub(crate) fn measured(scenes: &[&Scene]) -> bool {
    scenes.iter().flat_map(|s| &s.trails).any(|t| t.kind == TrailKind::Measured)
}

pub(crate) fn drawable_forces<'a>(scene: &'a Scene) -> impl Iterator<Item = &'a Force> {
    let drawable =
        |f: &&Force| near(f.from) && near(f.to) && f.normal_force.is_finite() && f.normal_force > 0.0;
    scene.forces.iter().filter(drawable)
}
