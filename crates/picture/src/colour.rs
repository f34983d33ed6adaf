//! Colours and colour maps.

use std::fmt;

/// A colour: red, green, blue (sRGB).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Colour(pub u8, pub u8, pub u8);

impl Colour {
    /// The default blue of a body.
    pub const BODY: Colour = Colour::hex(0x8cb4de);
    /// A line of force, and the halo around it.
    pub(crate) const FORCE: Colour = Colour::hex(0xd01c3f);
    pub(crate) const WHITE: Colour = Colour::hex(0xffffff);
    /// The colour of a body without a value.
    pub(crate) const MISSING: Colour = Colour::hex(0xa8a8a8);

    /// Makes a colour of a number such as 0x8cb4de.
    pub(crate) const fn hex(rgb: u32) -> Colour {
        Colour((rgb >> 16) as u8, (rgb >> 8) as u8, rgb as u8)
    }

    /// Mixes two colours: `part` 0 is this one, 1 is the other.
    pub(crate) fn mixed(self, other: Colour, part: f64) -> Colour {
        let mix = |a: u8, b: u8| (f64::from(a) + part * (f64::from(b) - f64::from(a))).round() as u8;
        Colour(mix(self.0, other.0), mix(self.1, other.1), mix(self.2, other.2))
    }

    /// Returns near-black or white, whichever has more contrast on this colour.
    pub(crate) fn contrast(self) -> Colour {
        let luma = 0.299 * f64::from(self.0) + 0.587 * f64::from(self.1) + 0.114 * f64::from(self.2);
        if luma > 120.0 { Colour::hex(0x111a24) } else { Colour::WHITE }
    }
}

impl fmt::Display for Colour {
    /// Writes it as in CSS: `#8cb4de`.
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
const VIRIDIS: [u32; SHADES] = [
    0x440154, 0x481a6c, 0x472f7d, 0x414487, 0x39568c, 0x31688e, 0x2a788e, 0x23888e, 0x1f988b, 0x22a884,
    0x35b779, 0x54c568, 0x7ad151, 0xa5db36, 0xd2e21b, 0xfde725,
];

/// *magma* by the same authors, from its bright end, without the nearly black colours.
const MAGMA: [u32; SHADES] = [
    0xfcfdbf, 0xfde2a3, 0xfec68a, 0xfeaa74, 0xfc8e64, 0xf7725c, 0xec5860, 0xd9466b, 0xc23b75, 0xaa337d,
    0x912b81, 0x792282, 0x621980, 0x4a1079, 0x311165, 0x1a1042,
];

/// A warm grey, then *magma* from its bright part; as dark as the map goes on.
const FROM_GREY: [u32; SHADES] = [
    0xdcd6cb, 0xfeb57d, 0xfd9c6c, 0xfa8461, 0xf46b5d, 0xe95562, 0xd8466b, 0xc43c74, 0xaf357b, 0x992e80,
    0x832682, 0x6e1e81, 0x5a167e, 0x441074, 0x2e1161, 0x1a1042,
];

/// The same on near-black: a warm grey, then *magma* from a darker part to its bright end.
const FROM_DARK_GREY: [u32; SHADES] = [
    0x7a7268, 0xd4446d, 0xdf4c68, 0xe95562, 0xf0615f, 0xf56e5d, 0xf97c5f, 0xfb8b63, 0xfd996a, 0xfea873,
    0xfeb67d, 0xfec489, 0xfed395, 0xfde1a2, 0xfdefb1, 0xfcfdbf,
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
    /// Begins with a warm grey: for numbers that are of no interest up to the lower end of the range.
    FromGrey,
}

/// The colours of a map for a theme, from its low end, equidistant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ramp(pub [Colour; SHADES]);

impl Ramp {
    pub fn new(map: ColourMap, theme: Theme) -> Ramp {
        let mut colours = match (map, theme) {
            (ColourMap::Viridis, _) => VIRIDIS,
            (ColourMap::FromPaper, _) => MAGMA,
            (ColourMap::FromGrey, Theme::Light) => FROM_GREY,
            (ColourMap::FromGrey, Theme::Dark) => FROM_DARK_GREY,
        };
        if (map, theme) == (ColourMap::FromPaper, Theme::Dark) {
            colours.reverse();
        }
        Ramp(colours.map(Colour::hex))
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

/// Colours of everything except the bodies.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Palette {
    pub paper: Colour,
    pub ink: Colour,
    pub wall: Colour,
    pub outline: Colour,
    /// Lines of a grid.
    pub faint: Colour,
}

impl Palette {
    pub fn of(theme: Theme) -> Palette {
        let colours = match theme {
            Theme::Light => [0xffffff, 0x3a4350, 0x2a303a, 0x1c2b40, 0xe3e7ec],
            Theme::Dark => [0x12161d, 0xc4ccd8, 0xd5dbe4, 0xeef2f7, 0x2a313b],
        };
        let [paper, ink, wall, outline, faint] = colours.map(Colour::hex);
        Palette { paper, ink, wall, outline, faint }
    }

    /// Returns the colour of a kind of people: after seven, paler ones follow.
    pub fn kind(&self, place: usize) -> Colour {
        let colour = self.series(place);
        if place < 7 { colour } else { colour.mixed(self.paper, 0.5) }
    }

    /// Returns the colour of an agent, after M. Okabe and K. Ito (2008): distinguishable for colour-blind people. Their
    /// yellow is left out because it is hard to see on white; their black is the ink.
    pub fn series(&self, place: usize) -> Colour {
        // Their blue is too dark on near-black.
        let blue = if self.paper.0 < 128 { 0x4095c8 } else { 0x0072b2 };
        let colours = [blue, 0xd55e00, 0x009e73, 0xcc79a7, 0xe69f00, 0x56b4e9];
        colours.get(place % 7).map_or(self.ink, |colour| Colour::hex(*colour))
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

    /// The page draws people itself.
    #[test]
    fn the_page_of_the_lab_has_the_same_greys_and_colours() {
        let page = include_str!("../../../lab/src/colour.ts");
        for colours in [FROM_GREY, FROM_DARK_GREY] {
            let list = colours.map(|colour| format!("\"{}\"", Colour::hex(colour))).join(", ");
            assert!(page.contains(&list), "{list}");
        }
    }

    #[test]
    fn maps_have_even_steps_of_lightness_and_begin_as_the_paper() {
        use {ColourMap::*, Theme::*};
        let all =
            [(Viridis, Light), (FromPaper, Light), (FromPaper, Dark), (FromGrey, Light), (FromGrey, Dark)];
        for (map, theme) in all {
            let lights = Ramp::new(map, theme).0.map(lightness);
            let mean = (lights[SHADES - 1] - lights[0]) / (SHADES - 1) as f64;
            let even = lights.windows(2).all(|two| ((two[1] - two[0]) / mean - 1.0).abs() < 0.3);
            assert!(even && mean.abs() > 3.2, "{map:?} {theme:?}: {lights:?}");
            let paper = lightness(Palette::of(theme).paper);
            assert!(
                map != FromPaper || (lights[0] - paper).abs() < 4.0,
                "{theme:?}: {} on {paper}",
                lights[0]
            );
        }
    }
}
