//! The colours of the bodies, and what they mean.

use crate::colour::{Colour, viridis};
use crate::scene::Scene;
use crate::style::{Fill, Values};
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
}

impl Scale {
    /// The colour of a value.
    pub fn of(&self, value: f64) -> Colour {
        let Scale { low, high, .. } = *self;
        if !value.is_finite() {
            Colour::MISSING
        } else if high > low {
            // Halved: the difference of two finite numbers may be infinite.
            viridis((value / 2.0 - low / 2.0) / (high / 2.0 - low / 2.0))
        } else {
            viridis(0.5)
        }
    }
}

impl<'a> Colouring<'a> {
    /// Of a scene with a map of density, the scale is that of the map, and the values are none's.
    pub fn new(scene: &Scene, fill: &'a Fill) -> Colouring<'a> {
        if let Some(map) = &scene.density {
            let high = map.values().into_iter().fold(0.0, f64::max);
            let (low, high) = given(map.range).unwrap_or((0.0, if high > 0.0 { high } else { 1.0 }));
            let scale = Scale { title: titled("density", "1/m²"), low, high };
            return Colouring { single: viridis(0.0), scale: Some(scale), values: Cow::Borrowed(&[]) };
        }
        let (values, label, unit, range): (Cow<[f64]>, &str, &str, _) = match fill {
            Fill::Single(colour) => {
                return Colouring { single: *colour, scale: None, values: Cow::Borrowed(&[]) };
            }
            Fill::BodyArea => (scene.bodies.iter().map(|b| b.area).collect(), "body area", "m²", None),
            Fill::Values(Values { values, label, unit, range }) => {
                (values.as_slice().into(), label, unit, *range)
            }
        };
        let finite = || values.iter().copied().filter(|v| v.is_finite());
        let (low, high) = given(range).unwrap_or_else(|| {
            let low = finite().fold(f64::INFINITY, f64::min);
            let high = finite().fold(f64::NEG_INFINITY, f64::max);
            if low <= high { (low, high) } else { (0.0, 1.0) }
        });
        let scale = Scale { title: titled(label, unit), low, high };
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
