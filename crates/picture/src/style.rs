//! Settings of a drawing.

use crate::colour::{Colour, ColourMap, Theme};

/// Settings of a drawing. Lines and lettering scale with the width.
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
    /// \[s\] Time, written above the scene.
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
