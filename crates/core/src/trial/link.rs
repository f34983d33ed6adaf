//! `<Link>`: two lines of the plan that are one: floors that are drawn beside each other.

use crate::plane::{Motion, Pose, Twist, Vec2, nearest_on_segment, vec2};
use crate::require;
use crate::trial::schema::{AttributeValue, Schema};

/// \[m\] Depth of the strip behind a line in which people are carried over.
const STRIP: f64 = 0.5;
/// \[m\] By how much the lengths of both lines may differ.
const SAME_LENGTH: f64 = 1e-3;
/// \[m\] Length of the longest line.
const LONGEST: f64 = 50.0;
/// Most links of a Trial.
pub(crate) const MOST_LINKS: usize = 100;

/// Returns where somebody comes from \[m\] who was at one place and is at another one now, if a link is between: that is a place
/// in front of the line where the person is now.
pub fn carried_from(links: &[Link], before: Vec2, now: Vec2) -> Option<Vec2> {
    let far = (now - before).norm();
    let passages = links.iter().flat_map(Link::passages);
    let mut from = passages.map(|passage| passage.place(before));
    // Who walked is nearer to the place of before than to any place beyond a link.
    from.find(|from| (now - from).norm() < far)
}

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
        let possible = 0.1..=LONGEST;
        require(possible.contains(&here) && possible.contains(&there), || {
            format!("its lines must be from 0.1 to {LONGEST} m long")
        })?;
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
        let out = vec2(along.y, -along.x) * STRIP;
        [start, end, end + out, start + out]
    }

    /// Returns the motion on the other side.
    pub fn carried(&self, Motion { pose, twist }: Motion) -> Motion {
        let [from, to] = [self.from, self.to].map(|[start, end]| end - start);
        let turn = libm::atan2(-from.perp(&to), -from.dot(&to));
        Motion {
            pose: Pose { position: self.place(pose.position), orientation: pose.orientation + turn },
            twist: Twist { velocity: self.turned(twist.velocity), ..twist },
        }
    }

    /// Returns a place \[m\] as it is on the other side.
    pub fn place(&self, place: Vec2) -> Vec2 {
        self.to[1] + self.turned(place - self.from[0])
    }

    /// Returns a vector as it is on the other side: the line becomes the other one, backwards. Exact where they are parallel.
    fn turned(&self, vector: Vec2) -> Vec2 {
        let [from, to] = [self.from, self.to].map(|[start, end]| (end - start).normalize());
        let (cos, sin) = (-from.dot(&to), -from.perp(&to));
        vec2(cos * vector.x - sin * vector.y, sin * vector.x + cos * vector.y)
    }

    /// Returns the nearest place \[m\] on the line.
    pub fn foot(&self, place: Vec2) -> Vec2 {
        nearest_on_segment(self.from[0], self.from[1], place)
    }
}

pub(crate) static LINK: Schema =
    Schema { name: "Link", attributes: &[("Id", AttributeValue::Id)], children: &[&super::geometry::CORNER] };
