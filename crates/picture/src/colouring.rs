//! The colours of the bodies, and what they mean.

use crate::colour::{Colour, ColourMap, Ramp};
use crate::scene::Scene;
use crate::style::{Fill, Style, Values};
use crate::text::short;

#[derive(Debug, Clone)]
pub(crate) struct Colouring {
    pub single: Colour,
    pub scale: Option<Scale>,
    pub values: Vec<f64>,
}

/// The meaning of the colour map.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Scale {
    pub title: String,
    pub low: f64,
    pub high: f64,
    /// Whether values above the upper end occur; they have the colour of the end.
    pub clipped: bool,
    /// Words instead of a colour bar, if all values are equal to zero or unknown.
    pub nothing: Option<String>,
    pub ramp: Ramp,
}

impl Scale {
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

    /// Returns the label at the upper end of the colour bar.
    pub fn high_label(&self) -> String {
        format!("{}{}", if self.clipped { "≥ " } else { "" }, short(self.high))
    }
}

impl Colouring {
    /// Chooses the colours. In a scene with a density map the scale is that of the map, and bodies have no values.
    pub fn new(scene: &Scene, style: &Style) -> Colouring {
        let values = match (&scene.density, &style.fill) {
            (Some(map), _) => Values::of(map.values(), "density", "1/m²"),
            (None, Fill::Single(colour)) => {
                return Colouring { single: *colour, scale: None, values: Vec::new() };
            }
            (None, Fill::BodyArea) => {
                Values::of(scene.bodies.iter().map(|body| body.area).collect(), "body area", "m²")
            }
            (None, Fill::Values(values)) => values.clone(),
        };
        let Values { values, label, unit, quantile, beyond, map } = values;
        let given = style.range.filter(|(a, b)| a.is_finite() && b.is_finite() && a <= b);
        let finite = || values.iter().copied().filter(|v| v.is_finite());
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
            } else if scene.density.is_some() || map == ColourMap::FromPaper {
                (low.min(0.0), if high > 0.0 { high } else { 1.0 })
            } else {
                (low, high)
            }
        });
        let mut title = titled(&label, &unit);
        if let Some(quantile) = quantile {
            title += &format!(", to the {} % quantile", short(100.0 * quantile));
        }
        let ramp = Ramp::new(map, style.theme);
        if scene.density.is_some() {
            let scale = Scale { title, low, high, clipped: false, nothing, ramp };
            return Colouring { single: ramp.at(0.0), scale: Some(scale), values: Vec::new() };
        }
        let clipped = beyond || quantile.is_some() || finite().any(|value| value > high);
        let scale = Scale { title, low, high, clipped, nothing, ramp };
        Colouring { single: Colour::MISSING, scale: Some(scale), values }
    }

    pub fn of(&self, agent: usize) -> Colour {
        match &self.scale {
            None => self.single,
            Some(scale) => self.values.get(agent).map_or(self.single, |value| scale.of(*value)),
        }
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
