//! The colours of the bodies, and what they mean.

use crate::colour::{Colour, ColourMap, Ramp, Theme};
use crate::scene::Scene;
use crate::style::{Fill, Values};
use crate::text::short;
use std::borrow::Cow;

#[derive(Debug, Clone)]
pub(crate) struct Colouring<'a> {
    pub single: Colour,
    pub scale: Option<Scale>,
    pub values: Cow<'a, [f64]>,
}

/// What the colour map stands for.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Scale {
    pub title: String,
    pub low: f64,
    pub high: f64,
    /// What is beyond the upper end is shown as the end is.
    pub clipped: bool,
    pub ramp: Ramp,
}

impl Scale {
    /// The colour of a value.
    pub fn of(&self, value: f64) -> Colour {
        let Scale { low, high, ramp, .. } = *self;
        if !value.is_finite() {
            Colour::MISSING
        } else if high > low {
            // Halved: the difference of two finite numbers may be infinite.
            ramp.at((value / 2.0 - low / 2.0) / (high / 2.0 - low / 2.0))
        } else {
            ramp.at(0.5)
        }
    }

    /// What stands at the upper end of the colour bar.
    pub fn high_label(&self) -> String {
        format!("{}{}", if self.clipped { "≥ " } else { "" }, short(self.high))
    }
}

impl<'a> Colouring<'a> {
    /// Of a scene with a map of density, the scale is that of the map, and the values are none's.
    pub fn new(scene: &Scene, fill: &'a Fill, theme: Theme) -> Colouring<'a> {
        if let Some(map) = &scene.density {
            let high = map.values().into_iter().fold(0.0, f64::max);
            let (low, high) = given(map.range).unwrap_or((0.0, if high > 0.0 { high } else { 1.0 }));
            let ramp = Ramp::new(ColourMap::Viridis, theme);
            let scale = Scale { title: titled("density", "1/m²"), low, high, clipped: false, ramp };
            return Colouring { single: ramp.at(0.0), scale: Some(scale), values: Cow::Borrowed(&[]) };
        }
        let areas;
        let Values { values, label, unit, range, quantile, map } = match fill {
            Fill::Single(colour) => {
                return Colouring { single: *colour, scale: None, values: Cow::Borrowed(&[]) };
            }
            Fill::Values(values) => values,
            Fill::BodyArea => {
                let values = scene.bodies.iter().map(|body| body.area).collect();
                let (label, unit) = ("body area".to_owned(), "m²".to_owned());
                areas = Values { values, label, unit, ..Values::default() };
                &areas
            }
        };
        let finite = || values.iter().copied().filter(|v| v.is_finite());
        let (low, high) = given(*range).unwrap_or_else(|| {
            let low = finite().fold(f64::INFINITY, f64::min);
            let high = finite().fold(f64::NEG_INFINITY, f64::max);
            match map {
                _ if low > high => (0.0, 1.0),
                // Such a map begins at zero, and nothing is not half of anything.
                ColourMap::FromPaper if high <= 0.0 => (low.min(0.0), 1.0),
                ColourMap::FromPaper => (low.min(0.0), high),
                ColourMap::Viridis => (low, high),
            }
        });
        let mut title = titled(label, unit);
        if let Some(quantile) = quantile {
            title += &format!(", to the {} % quantile", short(100.0 * quantile));
        }
        let (clipped, ramp) = (quantile.is_some(), Ramp::new(*map, theme));
        let scale = Scale { title, low, high, clipped, ramp };
        let values = match fill {
            Fill::Values(own) => Cow::Borrowed(own.values.as_slice()),
            _ => Cow::Owned(values.clone()),
        };
        Colouring { single: Colour::MISSING, scale: Some(scale), values }
    }

    pub fn of(&self, agent: usize) -> Colour {
        match &self.scale {
            None => self.single,
            Some(scale) => self.values.get(agent).map_or(self.single, |value| scale.of(*value)),
        }
    }
}

fn given(range: Option<(f64, f64)>) -> Option<(f64, f64)> {
    range.filter(|(a, b)| a.is_finite() && b.is_finite() && a <= b)
}

/// The label with its unit.
pub(crate) fn titled(label: &str, unit: &str) -> String {
    match (label.is_empty(), unit.is_empty()) {
        (_, true) => label.to_owned(),
        (true, false) => unit.to_owned(),
        (false, false) => format!("{label} ({unit})"),
    }
}
