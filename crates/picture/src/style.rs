//! Settings of a drawing, and the colours of values.

use crate::colour::{Colour, ColourMap, Ramp, Theme};
use crate::text::short;

/// Settings of a drawing. Lines and letters scale with the width.
#[derive(Debug, Clone, PartialEq)]
pub struct Style {
    /// \[px\] Width. The height follows from the scene.
    pub width: f64,
    /// Colour of the bodies.
    pub fill: Fill,
    /// Colour of everything else.
    pub theme: Theme,
    /// Whether the agents' Ids are drawn, on the bodies.
    pub ids: bool,
    /// Whether a mark shows where each body faces.
    pub orientation: bool,
    /// \[s\] Time, written above the scene; without one, doors are as at 0 s.
    pub time: Option<f64>,
    /// Number of decimals of times.
    pub time_decimals: usize,
    /// Values at the ends of the colour map; `None`: the lowest and the highest value of all scenes.
    pub range: Option<(f64, f64)>,
    /// \[N\] The force with the widest line; `None`: the largest force of the picture. If it is given (for movies), the
    /// legend is drawn even without forces.
    pub forces: Option<f64>,
}

impl Default for Style {
    fn default() -> Style {
        Style {
            width: 400.0,
            fill: Fill::Single(Colour::BODY),
            theme: Theme::Light,
            ids: false,
            orientation: true,
            time: None,
            time_decimals: 2,
            range: None,
            forces: None,
        }
    }
}

/// Colour of the bodies.
#[derive(Debug, Clone, PartialEq)]
pub enum Fill {
    /// One colour for all.
    Single(Colour),
    /// Colours by the area of each body.
    BodyArea,
    /// A colour for each kind of people, with a legend.
    Kind,
    /// Colours by one number for each agent.
    Values(Values),
}

/// One number for each agent, shown as a colour.
#[derive(Debug, Clone, PartialEq)]
pub struct Values {
    /// Values, in the order of the agents; missing ones and those that are not finite are grey.
    pub values: Vec<f64>,
    /// Name of the quantity.
    pub label: String,
    /// Unit; empty if there is none.
    pub unit: String,
    /// The upper end of the style's `range` is this quantile (0 to 1) of all shown values, and some are above it. The colour bar
    /// says so.
    pub quantile: Option<f64>,
    /// Some of all shown values are above the upper end of the style's `range`. The colour bar says so.
    pub beyond: bool,
    /// The colour map.
    pub map: ColourMap,
}

impl Values {
    /// Returns values of a quantity, on the default colour map.
    pub fn of(values: Vec<f64>, label: &str, unit: &str) -> Values {
        let (label, unit, map) = (label.to_owned(), unit.to_owned(), ColourMap::default());
        Values { values, label, unit, quantile: None, beyond: false, map }
    }
}

/// The meaning of the colour map.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Scale {
    pub title: String,
    pub low: f64,
    pub high: f64,
    /// True if all up to the lower end have one colour.
    pub grey: bool,
    /// True if values above the upper end occur; they have the colour of the end.
    pub clipped: bool,
    /// Words instead of a colour bar, if all values are equal to zero or unknown.
    pub nothing: Option<String>,
    pub ramp: Ramp,
}

impl Scale {
    /// Makes one scale for the values of all scenes, with the names of the first; `from_zero`: it begins at 0.
    pub fn spanning(all: &[&Values], style: &Style, from_zero: bool) -> Option<Scale> {
        let Values { label, unit, quantile, map, .. } = *all.first()?;
        let given = style.range.filter(|(a, b)| a.is_finite() && b.is_finite() && a <= b);
        let finite = || all.iter().flat_map(|of| &of.values).copied().filter(|v| v.is_finite());
        // All values are zero, or all are unknown: a colour bar would need invented ends.
        let nothing = given.is_none() && finite().all(|value| value == 0.0);
        let nothing = nothing.then(|| match finite().next() {
            Some(_) if unit.is_empty() => format!("{label}: 0 everywhere"),
            Some(_) => format!("{label}: 0 {unit} everywhere"),
            None => format!("{label}: not known"),
        });
        let (low, high) = given.unwrap_or_else(|| {
            let low = finite().fold(f64::INFINITY, f64::min);
            let high = finite().fold(f64::NEG_INFINITY, f64::max);
            if nothing.is_some() {
                (0.0, 1.0)
            } else if from_zero || *map != ColourMap::Viridis {
                (low.min(0.0), if high > 0.0 { high } else { 1.0 })
            } else {
                (low, high)
            }
        });
        let mut title = titled(label, unit);
        if let Some(quantile) = quantile {
            title += &format!(", to the {} % quantile", short(100.0 * quantile));
        }
        let beyond = all.iter().any(|of| of.beyond || of.quantile.is_some());
        let clipped = beyond || finite().any(|value| value > high);
        let grey = *map == ColourMap::FromGrey && low > 0.0;
        Some(Scale { title, low, high, grey, clipped, nothing, ramp: Ramp::new(*map, style.theme) })
    }

    /// Returns the colour of a value.
    pub fn of(&self, value: f64) -> Colour {
        let Scale { low, high, ramp, .. } = *self;
        if !value.is_finite() {
            Colour::MISSING
        } else if high > low {
            // Halved first, because the difference of two finite numbers may be infinite.
            ramp.at((value / 2.0 - low / 2.0) / (high / 2.0 - low / 2.0))
        } else {
            ramp.at(0.5)
        }
    }

    /// Returns the label at the lower end of the colour bar.
    pub fn low_label(&self) -> String {
        format!("{}{}", if self.grey { "≤ " } else { "" }, short(self.low))
    }

    /// Returns the label at the upper end of the colour bar.
    pub fn high_label(&self) -> String {
        format!("{}{}", if self.clipped { "≥ " } else { "" }, short(self.high))
    }
}

/// Returns the name of a quantity with its unit, which may be empty: "speed (m/s)".
pub fn titled(label: &str, unit: &str) -> String {
    match (label.is_empty(), unit.is_empty()) {
        (_, true) => label.to_owned(),
        (true, false) => unit.to_owned(),
        (false, false) => format!("{label} ({unit})"),
    }
}
