//! Colours and colour maps.

use std::fmt;

/// A colour: red, green, blue (sRGB).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Colour(pub u8, pub u8, pub u8);

impl Colour {
    /// The default blue of a body.
    pub const BODY: Colour = Colour(0x8c, 0xb4, 0xde);
    /// The colour of a body without a value.
    pub(crate) const MISSING: Colour = Colour(0xa8, 0xa8, 0xa8);

    /// Mixes two colours: `part` 0 is this one, 1 is the other.
    pub(crate) fn mixed(self, other: Colour, part: f64) -> Colour {
        let mix = |a: u8, b: u8| (f64::from(a) + part * (f64::from(b) - f64::from(a))).round() as u8;
        Colour(mix(self.0, other.0), mix(self.1, other.1), mix(self.2, other.2))
    }

    /// Returns near-black or white, whichever has more contrast on this colour.
    pub(crate) fn contrast(self) -> Colour {
        let luma = 0.299 * f64::from(self.0) + 0.587 * f64::from(self.1) + 0.114 * f64::from(self.2);
        if luma > 120.0 { Colour(0x11, 0x1a, 0x24) } else { Colour(0xff, 0xff, 0xff) }
    }
}

impl fmt::Display for Colour {
    /// As in CSS: `#8cb4de`.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "#{:02x}{:02x}{:02x}", self.0, self.1, self.2)
    }
}

/// Colours of everything except the bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Theme {
    /// Dark on white.
    #[default]
    Light,
    /// Light on near-black.
    Dark,
}

/// Number of colours of a colour map.
const SHADES: usize = 16;

/// *viridis* (S. van der Walt, N. Smith, public domain) at 16 equidistant places. Its lightness grows evenly, so that
/// it is readable for colour-blind people and in grey print.
const VIRIDIS: [Colour; SHADES] = [
    Colour(0x44, 0x01, 0x54),
    Colour(0x48, 0x1a, 0x6c),
    Colour(0x47, 0x2f, 0x7d),
    Colour(0x41, 0x44, 0x87),
    Colour(0x39, 0x56, 0x8c),
    Colour(0x31, 0x68, 0x8e),
    Colour(0x2a, 0x78, 0x8e),
    Colour(0x23, 0x88, 0x8e),
    Colour(0x1f, 0x98, 0x8b),
    Colour(0x22, 0xa8, 0x84),
    Colour(0x35, 0xb7, 0x79),
    Colour(0x54, 0xc5, 0x68),
    Colour(0x7a, 0xd1, 0x51),
    Colour(0xa5, 0xdb, 0x36),
    Colour(0xd2, 0xe2, 0x1b),
    Colour(0xfd, 0xe7, 0x25),
];

/// *magma* by the same authors, from its bright end, without the nearly black colours.
const MAGMA: [Colour; SHADES] = [
    Colour(0xfc, 0xfd, 0xbf),
    Colour(0xfd, 0xe2, 0xa3),
    Colour(0xfe, 0xc6, 0x8a),
    Colour(0xfe, 0xaa, 0x74),
    Colour(0xfc, 0x8e, 0x64),
    Colour(0xf7, 0x72, 0x5c),
    Colour(0xec, 0x58, 0x60),
    Colour(0xd9, 0x46, 0x6b),
    Colour(0xc2, 0x3b, 0x75),
    Colour(0xaa, 0x33, 0x7d),
    Colour(0x91, 0x2b, 0x81),
    Colour(0x79, 0x22, 0x82),
    Colour(0x62, 0x19, 0x80),
    Colour(0x4a, 0x10, 0x79),
    Colour(0x31, 0x11, 0x65),
    Colour(0x1a, 0x10, 0x42),
];

/// The colour map for numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ColourMap {
    /// From dark violet to yellow: for numbers whose zero has no special meaning.
    #[default]
    Viridis,
    /// Begins near the colour of the paper: for numbers that mean "nothing" at zero. Pale yellow to dark violet on
    /// white; the reverse on near-black.
    FromPaper,
}

/// The colours of a map for a theme, from its low end, equidistant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ramp([Colour; SHADES]);

impl Ramp {
    /// All maps in pictures.
    pub const ALL: [(ColourMap, Theme); 3] = [
        (ColourMap::Viridis, Theme::Light),
        (ColourMap::FromPaper, Theme::Light),
        (ColourMap::FromPaper, Theme::Dark),
    ];

    pub fn new(map: ColourMap, theme: Theme) -> Ramp {
        let mut colours = match map {
            ColourMap::Viridis => VIRIDIS,
            ColourMap::FromPaper => MAGMA,
        };
        if (map, theme) == (ColourMap::FromPaper, Theme::Dark) {
            colours.reverse();
        }
        Ramp(colours)
    }

    pub fn colours(&self) -> &[Colour] {
        &self.0
    }

    /// Returns the colour of a fraction from 0 to 1. Beyond the ends it is the colour of the end; NaN is grey.
    pub fn at(&self, fraction: f64) -> Colour {
        if fraction.is_nan() {
            return Colour::MISSING;
        }
        let place = fraction.clamp(0.0, 1.0) * (SHADES - 1) as f64;
        let below = (place as usize).min(SHADES - 2);
        self.0[below].mixed(self.0[below + 1], place - below as f64)
    }
}

/// Returns the colour of a fraction: 0 is dark violet, 1 is yellow. Beyond the ends it is the colour of the end; NaN is
/// grey.
pub fn viridis(fraction: f64) -> Colour {
    Ramp(VIRIDIS).at(fraction)
}

/// Colours of everything except the bodies.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Palette {
    pub paper: Colour,
    pub ink: Colour,
    pub wall: Colour,
    pub outline: Colour,
    /// Lines of a grid.
    pub faint: Colour,
    /// A line of force, and the halo around it.
    pub force: Colour,
    pub halo: Colour,
}

impl Palette {
    pub fn of(theme: Theme) -> Palette {
        match theme {
            Theme::Light => Palette {
                paper: Colour(0xff, 0xff, 0xff),
                ink: Colour(0x3a, 0x43, 0x50),
                wall: Colour(0x2a, 0x30, 0x3a),
                outline: Colour(0x1c, 0x2b, 0x40),
                faint: Colour(0xe3, 0xe7, 0xec),
                force: Colour(0xd0, 0x1c, 0x3f),
                halo: Colour(0xff, 0xff, 0xff),
            },
            Theme::Dark => Palette {
                paper: Colour(0x12, 0x16, 0x1d),
                ink: Colour(0xc4, 0xcc, 0xd8),
                wall: Colour(0xd5, 0xdb, 0xe4),
                outline: Colour(0xee, 0xf2, 0xf7),
                faint: Colour(0x2a, 0x31, 0x3b),
                force: Colour(0xd0, 0x1c, 0x3f),
                halo: Colour(0xff, 0xff, 0xff),
            },
        }
    }

    /// Returns the colour of an agent, after M. Okabe and K. Ito (2008): distinguishable for colour-blind people. Their
    /// yellow is left out because it is hard to see on white; their black is the ink.
    pub fn series(&self, place: usize) -> Colour {
        match place % 7 {
            // Their blue is too dark on near-black.
            0 if self.paper.0 < 128 => Colour(0x40, 0x95, 0xc8),
            0 => Colour(0x00, 0x72, 0xb2),
            1 => Colour(0xd5, 0x5e, 0x00),
            2 => Colour(0x00, 0x9e, 0x73),
            3 => Colour(0xcc, 0x79, 0xa7),
            4 => Colour(0xe6, 0x9f, 0x00),
            5 => Colour(0x56, 0xb4, 0xe9),
            _ => self.ink,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lightness L* of CIELAB, from 0 to 100.
    fn lightness(colour: Colour) -> f64 {
        let linear = |part: u8| {
            let part = f64::from(part) / 255.0;
            if part <= 0.04045 { part / 12.92 } else { ((part + 0.055) / 1.055).powf(2.4) }
        };
        let y = 0.2126 * linear(colour.0) + 0.7152 * linear(colour.1) + 0.0722 * linear(colour.2);
        if y > 0.008856 { 116.0 * y.cbrt() - 16.0 } else { 903.3 * y }
    }

    #[test]
    fn maps_have_even_steps_of_lightness_and_nothing_is_as_the_paper() {
        for (map, theme) in Ramp::ALL {
            let lights: Vec<f64> = Ramp::new(map, theme).colours().iter().map(|c| lightness(*c)).collect();
            let mean = (lights[SHADES - 1] - lights[0]) / (SHADES - 1) as f64;
            let even = lights.windows(2).all(|two| ((two[1] - two[0]) / mean - 1.0).abs() < 0.3);
            assert!(even && mean.abs() > 4.5, "{map:?} {theme:?}: {lights:?}");
            if map == ColourMap::FromPaper {
                let paper = lightness(Palette::of(theme).paper);
                assert!((lights[0] - paper).abs() < 4.0, "{theme:?}: {} on {paper}", lights[0]);
            }
        }
    }
}
