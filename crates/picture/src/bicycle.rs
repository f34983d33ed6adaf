//! Bicycles with their riders, seen from above, facing +x. They are given apart from the Trial, which cannot contain
//! them.

use crate::body::{TENTH_OF_MM, begin_at, drawable, near};
use crate::colour::{Colour, Palette};
use crate::text::{escaped, text_of};
use lemons_core::plane::{Pose, Vec2, rotation, vec2};
use std::fmt::Write;

/// \[m\] Thickness of the handlebar, seen from above.
const BAR: f64 = 0.035;
/// \[m\] Radius of a head.
const HEAD: f64 = 0.09;
/// Half depth and half breadth of the shoulders, as fractions of the rider's rectangle.
const SHOULDERS: (f64, f64) = (0.15, 0.42);
/// Position of the shoulders, as a fraction of its length.
const BEHIND: f64 = -0.15;
/// Half breadth of an arm, as a fraction of its breadth.
const ARM: f64 = 0.06;

/// A bicycle and its rider: two rectangles with the same centre. Lengths are along the gaze.
#[derive(Debug, Clone, PartialEq)]
pub struct Bicycle {
    /// Its name in the picture.
    pub id: String,
    /// Its pose. It is drawn if the pose is finite and both rectangles have an area.
    pub pose: Pose,
    /// \[m\] Length over both wheels and breadth across them: the bicycle's rectangle.
    pub wheels: (f64, f64),
    /// \[m\] Length of the top tube and breadth across the handlebar: the rider's rectangle.
    pub rider: (f64, f64),
}

impl Bicycle {
    /// Colour of the rider.
    pub(crate) const FILL: Colour = Colour::BODY;

    pub(crate) fn drawable(&self) -> bool {
        let sides = [self.wheels.0, self.wheels.1, self.rider.0, self.rider.1];
        drawable(&self.pose) && sides.iter().all(|side| *side > 0.0 && near(vec2(*side, 0.0)))
    }

    /// \[m\] Distance from the centre to the furthest corner.
    pub(crate) fn reach(&self) -> f64 {
        let half = |(length, breadth): (f64, f64)| 0.5 * vec2(length, breadth).norm();
        half(self.wheels).max(half(self.rider))
    }

    /// \[m\] Corners of both rectangles, in the world.
    pub(crate) fn corners(&self) -> impl Iterator<Item = Vec2> {
        let (turn, at) = (rotation(self.pose.orientation), self.pose.position);
        [self.wheels, self.rider].into_iter().flat_map(move |(length, breadth)| {
            let corner = move |(x, y): (f64, f64)| at + turn * vec2(x * length, y * breadth);
            [(0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)].into_iter().map(corner)
        })
    }

    /// Draws it in the plane.
    pub(crate) fn draw(&self, out: &mut String, palette: &Palette) {
        let ((along, across), (length, breadth)) = (self.wheels, self.rider);
        begin_at(out, &self.pose);
        let _ = write!(out, "><title>{}</title>", escaped(&self.id));
        let mut part = |more: &str, centre: Vec2, half: Vec2, corner: f64| {
            let low = centre - half;
            let [x, y, width, height, corner] =
                [low.x, low.y, 2.0 * half.x, 2.0 * half.y, corner].map(|v| text_of(v, TENTH_OF_MM));
            let _ = write!(
                out,
                "<rect {more} x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" rx=\"{corner}\"/>"
            );
        };
        let shade =
            |part: f64| format!("fill=\"{}\" stroke=\"none\"", Bicycle::FILL.mixed(palette.outline, part));
        let (pale, dark) = (shade(0.3), shade(0.85));
        // The wheels, and the frame between them below the rider.
        let wheels = format!("class=\"wheels\" fill=\"{}\"", palette.wall);
        part(&wheels, Vec2::zeros(), vec2(along, across) * 0.5, 0.5 * across);
        let half = vec2(length, breadth) * 0.5;
        part("class=\"rider\"", Vec2::zeros(), half, 0.0);
        // Shoulders, arms to the handlebar, and the head above them.
        let bar = 0.5 * BAR.min(0.2 * length);
        let shoulders = vec2(SHOULDERS.0 * length, SHOULDERS.1 * breadth);
        let behind = vec2(BEHIND * length, 0.0);
        part(&pale, behind, shoulders, shoulders.x.min(shoulders.y));
        let arm = vec2(0.5 * (half.x - behind.x), ARM * breadth);
        for side in [-1.0, 1.0] {
            part(&pale, vec2(behind.x + arm.x, side * (shoulders.y - arm.y)), arm, arm.y);
        }
        part(&dark, vec2(half.x - bar, 0.0), vec2(bar, half.y), bar);
        let head = HEAD.min(0.25 * length).min(0.4 * breadth);
        part(&dark, behind + vec2(0.04 * length, 0.0), vec2(head, head), head);
        *out += "</g>\n";
    }
}
