//! `<Link>`: two lines of the plan that are one: floors that are drawn beside each other.

use crate::plane::{Motion, Pose, Twist, Vec2, rotation};
use crate::require;
use crate::trial::schema::{AttributeValue, Schema};
use std::f64::consts::PI;

/// \[m\] Depth of the strip behind a line in which people are carried over.
const STRIP: f64 = 0.5;
/// \[m\] By how much the lengths of both lines may differ.
const SAME_LENGTH: f64 = 1e-3;
/// Most links of a Trial.
pub(crate) const MOST_LINKS: usize = 1000;

/// `<Link>`: who walks over one line goes on at the other. The ground is to the left of each, seen from its first to its
/// second end; so the first end of one is the second end of the other.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// Id, unique among the links.
    pub id: String,
    /// \[m\] Ends of both lines.
    pub lines: [[Vec2; 2]; 2],
}

impl Link {
    /// Checks that its lines can be one.
    ///
    /// # Errors
    /// A sentence: what is wrong.
    pub fn check(&self) -> Result<(), String> {
        let [here, there] = self.lines.map(|[from, to]| (to - from).norm());
        require(here > 0.1 && there > 0.1, || "its lines must be longer than 0.1 m".to_owned())?;
        require((here - there).abs() <= SAME_LENGTH, || {
            format!("its lines are {here} m and {there} m long: they must be equally long")
        })
    }

    /// Returns both ways over it.
    pub fn passages(&self) -> [LinkPassage; 2] {
        let [here, there] = self.lines;
        [LinkPassage { from: here, to: there }, LinkPassage { from: there, to: here }]
    }
}

/// A way over a link, from a line to a line \[m\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkPassage {
    from: [Vec2; 2],
    to: [Vec2; 2],
}

impl LinkPassage {
    /// Returns whether a place \[m\] is in the strip behind the line.
    pub fn is_beyond(&self, place: Vec2) -> bool {
        let [start, end] = self.from;
        let (along, way) = (end - start, place - start);
        let length = along.norm();
        (0.0..=length * length).contains(&along.dot(&way)) && {
            let depth = way.perp(&along) / length;
            depth > 0.0 && depth <= STRIP
        }
    }

    /// \[m\] Returns the corners of that strip.
    pub fn strip(&self) -> [Vec2; 4] {
        let [start, end] = self.from;
        let along = (end - start).normalize();
        let out = crate::plane::vec2(along.y, -along.x) * STRIP;
        [start, end, end + out, start + out]
    }

    /// Returns the motion on the other side.
    pub fn carried(&self, Motion { pose, twist }: Motion) -> Motion {
        let [from, to] = [self.from, self.to].map(|[start, end]| end - start);
        let turn = PI + libm::atan2(to.y, to.x) - libm::atan2(from.y, from.x);
        let turned = rotation(turn);
        let position = self.to[1] + turned * (pose.position - self.from[0]);
        Motion {
            pose: Pose { position, orientation: pose.orientation + turn },
            twist: Twist { velocity: turned * twist.velocity, ..twist },
        }
    }
}

pub(crate) static LINK: Schema =
    Schema { name: "Link", attributes: &[("Id", AttributeValue::Id)], children: &[&super::geometry::CORNER] };
