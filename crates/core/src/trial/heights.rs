//! Heights at which disks and walls are: what is above something else does not touch it.

use crate::trial::schema::AttributeValue;
use crate::trial::xml::Element;
use crate::xml::number;

/// \[m\] The paper's load length: its two-dimensional moduli are those of the material times this height.
pub const LOAD_LENGTH: f64 = 0.1;

/// An interval of heights above the floor, of a disk or a wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Heights {
    /// \[m\] `Bottom`, ≥ 0.
    pub bottom: f64,
    /// \[m\] `Top`, above `bottom`; infinite if nothing ends it.
    pub top: f64,
}

impl Default for Heights {
    /// All heights: the plan view of the paper.
    fn default() -> Heights {
        Heights { bottom: 0.0, top: f64::INFINITY }
    }
}

/// \[m\] The highest end of anything.
const HIGHEST: f64 = 1000.0;

/// The attributes `Bottom` and `Top`.
pub(crate) const HEIGHTS: [(&str, AttributeValue); 2] =
    [("Bottom", AttributeValue::NotNegative), ("Top", AttributeValue::Positive)];

impl Heights {
    /// Returns whether it is of all heights.
    pub fn is_all(&self) -> bool {
        *self == Heights::default()
    }

    /// \[m\] Returns the height that both have; 0 or less if one is above the other.
    #[inline]
    pub fn common(&self, other: &Heights) -> f64 {
        self.top.min(other.top) - self.bottom.max(other.bottom)
    }

    /// Returns whether a height \[m\] is in it.
    pub fn hold(&self, height: f64) -> bool {
        self.bottom <= height && height < self.top
    }

    /// \[m\] Returns top − bottom.
    pub fn extent(&self) -> f64 {
        self.top - self.bottom
    }

    pub(crate) fn read(element: Element<'_>) -> Heights {
        let value = |name, missing| if element.node.has(name) { element.number(name) } else { missing };
        let all = Heights::default();
        let heights = Heights { bottom: value("Bottom", all.bottom), top: value("Top", all.top) };
        if heights.top <= heights.bottom {
            element.wrong("Top", format!("must be above Bottom, {:?}", heights.bottom));
        }
        for (name, value) in [("Bottom", heights.bottom), ("Top", heights.top)] {
            if value > HIGHEST && value.is_finite() {
                element.wrong(name, format!("must be at most {HIGHEST} m"));
            }
        }
        heights
    }

    /// The values of `Bottom` and `Top`, if they are written.
    pub(crate) fn values(&self) -> [Option<String>; 2] {
        let all = Heights::default();
        [(self.bottom, all.bottom), (self.top, all.top)]
            .map(|(value, missing)| (value != missing).then(|| number(value)))
    }
}
