//! The colours of the bodies of scenes.

use crate::body::DrawnBody;
use crate::colour::{Colour, Palette};
use crate::scene::PictureScene;
use crate::style::{Fill, Scale, Style, Values};
use std::collections::BTreeSet;

/// The colours of the bodies of a scene.
#[derive(Debug, Clone)]
pub(crate) struct Colouring {
    pub single: Colour,
    pub scale: Option<Scale>,
    pub values: Vec<f64>,
    /// Of each agent, where colours say kinds.
    kinds: Vec<Colour>,
}

impl Colouring {
    /// Chooses the colours of scenes, on one scale. In scenes with a map of density or of loads the scale is that of the
    /// map, and bodies have no values.
    pub fn of_all(panels: &[(&PictureScene, &Style)]) -> Vec<Colouring> {
        let [(first, style), ..] = panels else { return Vec::new() };
        let values = |(scene, style): &(&PictureScene, &Style)| match (&scene.density, &style.fill) {
            _ if scene.loads.is_some() => scene.loads.as_ref().map(|map| map.values.clone()),
            (Some(map), _) => Some(Values::of(map.values(), "density", "1/m²")),
            (None, Fill::Single(_) | Fill::Kind) => None,
            (None, Fill::BodyArea) => {
                Some(Values::of(scene.bodies.iter().map(|body| body.area).collect(), "body area", "m²"))
            }
            (None, Fill::Values(values)) => Some(values.clone()),
        };
        let shown: Vec<Option<Values>> = panels.iter().map(values).collect();
        let known: Vec<&Values> = shown.iter().flatten().collect();
        let all = Scale::spanning(&known, style, first.density.is_some() || first.loads.is_some());
        let colouring = |(shown, (scene, style)): (&Option<Values>, &(&PictureScene, &Style))| {
            let scale = all.clone().filter(|_| shown.is_some());
            let single = match (&style.fill, &scale) {
                (Fill::Single(colour), None) => *colour,
                (_, Some(scale)) if scene.density.is_some() => scale.ramp.at(0.0),
                _ => Colour::MISSING,
            };
            let of_bodies = scene.density.is_none() && scene.loads.is_none();
            let values = shown.iter().filter(|_| of_bodies).flat_map(|of| &of.values);
            let kinds =
                if style.fill == Fill::Kind { kinds(panels.iter().map(|panel| panel.0)) } else { Vec::new() };
            let palette = Palette::of(style.theme);
            let of_kind = |body: &DrawnBody| {
                let place = kinds.iter().position(|kind| Some(*kind) == body.kind.as_deref());
                place.map_or(single, |place| palette.kind(place))
            };
            let kinds =
                if kinds.is_empty() { Vec::new() } else { scene.bodies.iter().map(of_kind).collect() };
            Colouring { single, scale, values: values.copied().collect(), kinds }
        };
        shown.iter().zip(panels).map(colouring).collect()
    }

    /// Returns the colour of the body of an agent.
    pub fn of(&self, agent: usize) -> Colour {
        match &self.scale {
            None => self.kinds.get(agent).copied().unwrap_or(self.single),
            Some(scale) => self.values.get(agent).map_or(self.single, |value| scale.of(*value)),
        }
    }
}

/// Returns the kinds of people in scenes, in the order of their names.
pub(crate) fn kinds<'a>(scenes: impl Iterator<Item = &'a PictureScene<'a>>) -> Vec<&'a str> {
    let all = scenes.flat_map(|scene| scene.bodies.iter()).filter_map(|body| body.kind.as_deref());
    all.collect::<BTreeSet<&str>>().into_iter().collect()
}
