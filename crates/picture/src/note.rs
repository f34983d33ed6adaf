//! Notes: marks and words that explain a scene.

use crate::plane::near;
use lemons_plane::{Rotation, Vec2, vec2};

/// A mark or words that explain a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Note {
    /// What is drawn. It is left out if one of its points is not finite or too far away.
    pub mark: Mark,
    /// Place in the series of colours that are easy to tell apart, as of agents; `None`: the colour of text.
    pub series: Option<usize>,
    /// Whether lines are dashed.
    pub dashed: bool,
}

/// What a note draws. Lengths are in metres of the scene; lines, heads of arrows, dots and letters keep their size on
/// the page.
#[derive(Debug, Clone, PartialEq)]
pub enum Mark {
    /// A line through points.
    Line(Vec<Vec2>),
    /// A circle.
    Circle {
        /// \[m\]
        centre: Vec2,
        /// \[m\] positive.
        radius: f64,
    },
    /// A dot at a point \[m\].
    Dot(Vec2),
    /// An arrow.
    Arrow {
        /// \[m\]
        from: Vec2,
        /// \[m\] its head.
        to: Vec2,
    },
    /// A length between two points: a line with a head at each end. Where there is no room, the heads are outside and
    /// point at each other.
    Length {
        /// \[m\]
        from: Vec2,
        /// \[m\]
        to: Vec2,
    },
    /// An angle: an arc with a head at its end.
    Angle {
        /// \[m\]
        centre: Vec2,
        /// \[m\] positive.
        radius: f64,
        /// \[rad\] from the x axis, counter-clockwise.
        from: f64,
        /// \[rad\] the arc ends here; less than `from`: it goes clockwise.
        to: f64,
    },
    /// Words, with a halo.
    Words {
        /// \[m\]
        at: Vec2,
        /// Where the words are, seen from the point.
        side: Side,
        /// An underscore lowers the next character, or those in braces: `k_n`, `v_{rel}`. A line break begins a line.
        text: String,
    },
}

/// Where words are, seen from a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Left of it.
    Left,
    /// Right of it.
    Right,
    /// Centred above it.
    Above,
    /// Centred below it.
    Below,
    /// Centred on it.
    On,
}

impl Mark {
    /// Makes a note in the colour of text.
    pub fn note(self) -> Note {
        Note { mark: self, series: None, dashed: false }
    }

    /// Makes words in one of the positions beside a point.
    pub fn words(at: Vec2, side: Side, text: &str) -> Mark {
        Mark::Words { at, side, text: text.to_owned() }
    }

    /// \[m\] The points that must be seen, each with a radius. Words may need more room than their point.
    pub(crate) fn reach(&self) -> Vec<(Vec2, f64)> {
        match self {
            Mark::Line(points) => points.iter().map(|p| (*p, 0.0)).collect(),
            Mark::Circle { centre, radius } => vec![(*centre, *radius)],
            Mark::Angle { centre, radius, from, to } => {
                vec![(around(*centre, *radius, *from), 0.0), (around(*centre, *radius, *to), 0.0)]
            }
            Mark::Dot(at) | Mark::Words { at, .. } => vec![(*at, 0.0)],
            Mark::Arrow { from, to } | Mark::Length { from, to } => vec![(*from, 0.0), (*to, 0.0)],
        }
    }
}

impl Note {
    /// The same with a colour of the series.
    pub fn in_series(self, place: usize) -> Note {
        Note { series: Some(place), ..self }
    }

    /// The same with dashed lines.
    pub fn dashed(self) -> Note {
        Note { dashed: true, ..self }
    }

    pub(crate) fn drawable(&self) -> bool {
        let reach = self.mark.reach();
        let round = match self.mark {
            Mark::Circle { radius, .. } | Mark::Angle { radius, .. } => radius > 0.0,
            _ => true,
        };
        round && !reach.is_empty() && reach.iter().all(|(p, r)| near(*p) && near(vec2(*r, 0.0)))
    }
}

/// \[m\] The point of a circle at an angle \[rad\].
pub(crate) fn around(centre: Vec2, radius: f64, angle: f64) -> Vec2 {
    centre + vec2(radius, 0.0).rotated(Rotation::by(angle))
}
