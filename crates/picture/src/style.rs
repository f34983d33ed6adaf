//! How it is drawn.

use crate::colour::{Colour, ColourMap, Theme};

/// How a scene is drawn. Lines and lettering grow with the width.
#[derive(Debug, Clone, PartialEq)]
pub struct Style {
    /// \[px\] the height follows from the scene.
    pub width: f64,
    /// Colour of the bodies.
    pub fill: Fill,
    /// Colour of everything else.
    pub theme: Theme,
    /// The agents' ids, on the bodies.
    pub ids: Visibility,
    /// A mark where each body faces.
    pub orientation: Visibility,
    /// A bar of a round number of metres.
    pub scale_bar: Visibility,
    /// What the colours mean, where they mean something.
    pub colour_bar: Visibility,
    /// \[s\] shown above the scene.
    pub time: Option<f64>,
    /// Decimals of the times.
    pub time_decimals: usize,
    /// The bodies; hidden for a map of density alone.
    pub bodies: Visibility,
    /// \[N\] the force that is drawn widest; the largest of the picture when `None`. Given, its legend is
    /// there even when no force is: a movie's.
    pub forces: Option<f64>,
}

impl Default for Style {
    fn default() -> Style {
        Style {
            width: 400.0,
            fill: Fill::Single(Colour::BODY),
            theme: Theme::Light,
            ids: Visibility::Hidden,
            orientation: Visibility::Shown,
            scale_bar: Visibility::Shown,
            colour_bar: Visibility::Shown,
            time: None,
            time_decimals: 2,
            bodies: Visibility::Shown,
            forces: None,
        }
    }
}

/// Colour of the bodies.
#[derive(Debug, Clone, PartialEq)]
pub enum Fill {
    /// One for all.
    Single(Colour),
    /// By the area that each body covers.
    BodyArea,
    /// By a number per agent.
    Values(Values),
}

/// A number per agent, shown as a colour.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Values {
    /// In the order of the agents; grey where missing or not finite.
    pub values: Vec<f64>,
    /// What the number is.
    pub label: String,
    /// Its unit; empty for none.
    pub unit: String,
    /// Values of the two ends of the colour map; lowest and highest value when `None`.
    pub range: Option<(f64, f64)>,
    /// The upper end of `range` is this quantile (0 to 1) of all that is shown, and some of it is beyond: the
    /// colour bar says so.
    pub quantile: Option<f64>,
    /// Its colours.
    pub map: ColourMap,
}

/// Whether something is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Visibility {
    /// Drawn.
    Shown,
    /// Not drawn.
    Hidden,
}

impl Visibility {
    pub(crate) fn shown(self) -> bool {
        self == Visibility::Shown
    }
}
