//! Who crosses a line on the way from one place to another.

use crate::measure::density::FARTHEST;
use lemons_core::plane::{Vec2, segments_touch, turn, vec2};
use serde::Deserialize;

/// A straight line across which people are counted; it has two ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
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

impl Line {
    /// Of the numbers x1, y1, x2, y2 \[m\]; `None` if these are not two different points within 1e6 m of the origin.
    pub fn of_numbers(numbers: &[f64]) -> Option<Line> {
        let near = numbers.iter().all(|number| number.abs() <= FARTHEST);
        match *numbers {
            [x1, y1, x2, y2] if near && (x1, y1) != (x2, y2) => {
                Some(Line { from: vec2(x1, y1), to: vec2(x2, y2) })
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
    /// Who stands on the line is on its right. So whoever stops on it and goes on, or back, is not counted twice.
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
    const DOOR: Line = Line { from: vec2(2.0, 0.0), to: vec2(2.0, 1.0) };

    fn over(before: (f64, f64), after: (f64, f64)) -> Option<(Way, f64)> {
        let place = |(x, y)| vec2(x, y);
        DOOR.crossing(place(before), place(after)).map(|Crossing { way, part }| (way, part))
    }

    #[test]
    fn a_crossing_has_a_direction_and_a_moment() {
        assert_eq!(over((1.0, 0.5), (5.0, 0.5)), Some((Way::Right, 0.25)));
        assert_eq!(over((5.0, 0.5), (1.0, 0.5)), Some((Way::Left, 0.75)));
        assert_eq!(over((1.0, 0.5), (1.5, 0.5)), None);
        // Past its end, though from side to side.
        assert_eq!(over((1.0, 1.5), (3.0, 1.5)), None);
        assert_eq!(over((1.0, 0.0), (3.0, 2.1)), None);
        // Across its end, straight.
        assert_eq!(over((1.0, 1.0), (3.0, 1.0)), Some((Way::Right, 0.5)));
    }

    #[test]
    fn who_is_nowhere_crosses_nothing() {
        assert_eq!(over((1.0, 0.5), (f64::NAN, f64::NAN)), None);
        assert_eq!(over((f64::NAN, f64::NAN), (1.0, 0.5)), None);
    }

    #[test]
    fn who_stops_on_the_line_is_counted_once() {
        assert_eq!(over((1.0, 0.5), (2.0, 0.5)), Some((Way::Right, 1.0)));
        assert_eq!(over((2.0, 0.5), (3.0, 0.5)), None);
        assert_eq!(over((2.0, 0.5), (2.0, 0.75)), None);
        // And back: from where it is, on the right, to the left.
        assert_eq!(over((2.0, 0.5), (1.0, 0.5)), Some((Way::Left, 0.0)));
    }
}
