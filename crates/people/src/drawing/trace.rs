//! Lines and curves of an element of SVG, as corners.

use super::curve::{Affine, Arc, bezier, by_ends, check_length};
use crate::error::Result;
use lemons_core::plane::Vec2;

/// Lines of one element; corners are in metres, places that are given are in its own coordinates.
pub(super) struct Trace<'t> {
    pub into: &'t Affine,
    pub deviation: f64,
    pub lines: Vec<(Vec<Vec2>, bool)>,
    /// Where the line ends, in the element's own coordinates.
    pub last: Vec2,
    pub curved: bool,
    /// Number of corners of all its lines.
    pub corners: usize,
}

impl Trace<'_> {
    pub fn begin(&mut self, at: Vec2) {
        // A move without a line draws nothing.
        self.lines.pop_if(|(corners, _)| corners.len() < 2);
        self.lines.push((vec![self.into.of(at)], false));
        self.last = at;
    }

    pub fn to(&mut self, at: Vec2) -> Result<()> {
        self.corners += 1;
        check_length(self.corners)?;
        let place = self.into.of(at);
        if let Some((corners, _)) = self.lines.last_mut() {
            corners.push(place);
        }
        self.last = at;
        Ok(())
    }

    pub fn line(&mut self, from: &mut Vec2, to: Vec2) -> Result<()> {
        *from = to;
        self.to(to)
    }

    pub fn close(&mut self) {
        if let Some((_, closed)) = self.lines.last_mut() {
            *closed = true;
        }
    }

    pub fn bezier(&mut self, from: &mut Vec2, control: &[Vec2]) -> Result<()> {
        let all: Vec<Vec2> =
            std::iter::once(&*from).chain(control).map(|point| self.into.of(*point)).collect();
        let mut corners = Vec::new();
        bezier(&all, self.deviation, &mut corners)?;
        self.curve(corners, control[control.len() - 1])?;
        *from = self.last;
        Ok(())
    }

    pub fn arc(&mut self, arc: &Arc) -> Result<()> {
        let mut corners = Vec::new();
        arc.mapped(self.into).trace(self.deviation, &mut corners)?;
        let end = self.last;
        self.curve(corners, end)
    }

    /// Appends corners of a curve, the last one exactly at `to`.
    pub fn curve(&mut self, mut corners: Vec<Vec2>, to: Vec2) -> Result<()> {
        corners.pop();
        self.corners += corners.len();
        check_length(self.corners)?;
        if let Some((line, _)) = self.lines.last_mut() {
            line.extend(corners);
        }
        self.curved = true;
        self.to(to)
    }

    pub fn by_ends(&mut self, to: Vec2, radii: Vec2, degrees: f64, large: bool, sweep: bool) -> Result<()> {
        let Some(arc) = by_ends(self.last, to, radii, degrees, large, sweep) else {
            return self.to(to);
        };
        let mut corners = Vec::new();
        arc.mapped(self.into).trace(self.deviation, &mut corners)?;
        self.curve(corners, to)
    }
}
