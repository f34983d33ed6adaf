//! Curves over time.

use crate::style::Theme;

/// Panels above each other that share the x axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// Below all panels.
    pub x: Axis,
    /// From the top down.
    pub panels: Vec<ChartPanel>,
}

/// What an axis shows.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Axis {
    /// What it is.
    pub label: String,
    /// Its unit; empty for none.
    pub unit: String,
}

/// One set of lines.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ChartPanel {
    /// Written above the panel.
    pub y: Axis,
    /// In the order in which they are drawn.
    pub lines: Vec<Line>,
    /// The value holds until the next point: for counts.
    pub steps: bool,
}

/// One curve.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Line {
    /// Written at its end, such as an agent's id.
    pub name: String,
    /// x and y, x growing. What is not finite interrupts the curve.
    pub points: Vec<(f64, f64)>,
    /// Lines of one group have one colour and one name in all panels: an agent, simulated and measured.
    pub group: usize,
    /// For what is measured; solid lines are simulated.
    pub dashed: bool,
}

/// How a chart is drawn. Lines and lettering grow with the width.
#[derive(Debug, Clone, PartialEq)]
pub struct ChartStyle {
    /// \[px\] the height follows from the panels.
    pub width: f64,
    /// Colours.
    pub theme: Theme,
    /// Height of a panel, as a part of the width; by the number of panels when `None`.
    pub aspect: Option<f64>,
}

impl Default for ChartStyle {
    fn default() -> ChartStyle {
        ChartStyle { width: 400.0, theme: Theme::Light, aspect: None }
    }
}

/// The chart as SVG.
pub fn chart_svg(chart: &Chart, style: &ChartStyle) -> String {
    let _ = chart;
    format!("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{0}\"/>", style.width)
}
