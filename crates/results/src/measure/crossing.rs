//! Crossing of a line on the way from one place to another.

use crate::shapes::FARTHEST;
use lemons_core::plane::{Vec2, segments_touch, turn, vec2};
use serde::Deserialize;

/// A straight line across which people are counted; it has two ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CountingLine {
    /// \[m\] Its beginning.
    pub from: Vec2,
    /// \[m\] Its end.
    pub to: Vec2,
}

/// A direction across a line, as somebody sees it who stands at the line's beginning and looks at its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Way {
    /// From the left to the right.
    Right,
    /// From the right to the left.
    Left,
}

/// \[m\], \[m/s\] Who was both further away and faster than this did not walk: floors lie beside each other in a plan.
const WALKED: (f64, f64) = (1.0, 10.0);

/// Returns whether somebody may have walked from one place to another \[m\] within a duration \[s\], and was not carried
/// over a link.
pub fn is_walked(from: Vec2, to: Vec2, duration: f64) -> bool {
    let way = (to - from).norm();
    way <= WALKED.0 || way <= WALKED.1 * duration
}

impl Way {
    /// Both.
    pub const ALL: [Way; 2] = [Way::Right, Way::Left];

    /// Returns its name in tables: to which side it leads.
    pub fn name(self) -> &'static str {
        match self {
            Way::Right => "right",
            Way::Left => "left",
        }
    }
}

/// Somebody crosses a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// In which direction.
    pub way: Way,
    /// Which part of the straight way between both places lies before the line, 0 to 1.
    pub part: f64,
}

impl CountingLine {
    /// Makes the line of the numbers x1, y1, x2, y2 \[m\]; `None` if these are not two different points within 1e6 m of the origin.
    pub fn of_numbers(numbers: &[f64]) -> Option<CountingLine> {
        let near = numbers.iter().all(|number| number.abs() <= FARTHEST);
        match *numbers {
            [x1, y1, x2, y2] if near && (x1, y1) != (x2, y2) => {
                Some(CountingLine { from: vec2(x1, y1), to: vec2(x2, y2) })
            }
            _ => None,
        }
    }

    /// Returns the length \[m\].
    pub fn length(&self) -> f64 {
        (self.to - self.from).norm()
    }

    /// Returns how somebody crosses the line who goes straight from one place to another \[m\]; `None` who does not, or
    /// goes past one of its ends, or is at no finite place.
    ///
    /// A person on the line is on its right. So whoever stops on it and goes on, or back, is not counted twice.
    pub fn crossing(&self, before: Vec2, after: Vec2) -> Option<Crossing> {
        let [from, to] = [before, after].map(|place| turn(self.from, self.to, place));
        if !(from - to).is_finite() {
            return None;
        }
        let left = |side: f64| side > 0.0;
        if left(from) == left(to) || !segments_touch(before, after, self.from, self.to) {
            return None;
        }
        let way = if left(from) { Way::Right } else { Way::Left };
        Some(Crossing { way, part: from / (from - to) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    /// Upwards, from (2, 0) to (2, 1): its right is where x is larger.
    const DOOR: CountingLine = CountingLine { from: vec2(2.0, 0.0), to: vec2(2.0, 1.0) };

    #[test]
    fn a_crossing_has_a_direction_and_a_moment() {
        let nan = f64::NAN;
        for (before, after, expected) in [
            ((1.0, 0.5), (5.0, 0.5), Some((Way::Right, 0.25))),
            ((5.0, 0.5), (1.0, 0.5), Some((Way::Left, 0.75))),
            ((1.0, 0.5), (1.5, 0.5), None),
            // Past its end, though from side to side.
            ((1.0, 1.5), (3.0, 1.5), None),
            ((1.0, 0.0), (3.0, 2.1), None),
            // Across its end, straight.
            ((1.0, 1.0), (3.0, 1.0), Some((Way::Right, 0.5))),
            // Who is nowhere crosses nothing.
            ((1.0, 0.5), (nan, nan), None),
            ((nan, nan), (1.0, 0.5), None),
            // Who stops on the line is counted once; and back, from where it is, on the right, to the left.
            ((1.0, 0.5), (2.0, 0.5), Some((Way::Right, 1.0))),
            ((2.0, 0.5), (3.0, 0.5), None),
            ((2.0, 0.5), (2.0, 0.75), None),
            ((2.0, 0.5), (1.0, 0.5), Some((Way::Left, 0.0))),
        ] {
            let seen = DOOR.crossing(vec2(before.0, before.1), vec2(after.0, after.1));
            assert_eq!(seen.map(|Crossing { way, part }| (way, part)), expected, "{before:?} to {after:?}");
        }
    }
}
