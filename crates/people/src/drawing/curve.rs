//! Curves -> straight pieces that are nowhere further from the curve than a length.

use super::MOST;
use crate::error::{Result, require};
use lemons_core::plane::{InPlane, Vec2, vec2};
use nalgebra::Matrix2;
use std::f64::consts::{FRAC_PI_4, PI, TAU};

/// More pieces of one curve are a mistake.
const MOST_PIECES: f64 = 1e5;

/// A map p -> origin + linear p.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Affine {
    /// Maps a difference of two points.
    pub linear: Matrix2<f64>,
    pub origin: Vec2,
}

impl Affine {
    /// Numbers in the order of SVG: where (1, 0), (0, 1) and the origin go, the first two without the third.
    pub fn new([a, b, c, d, e, f]: [f64; 6]) -> Affine {
        Affine { linear: Matrix2::new(a, c, b, d), origin: vec2(e, f) }
    }

    pub fn scale(by: f64) -> Affine {
        Affine { linear: Matrix2::from_diagonal_element(by), origin: Vec2::zeros() }
    }

    pub fn shift(by: Vec2) -> Affine {
        Affine { origin: by, ..Affine::scale(1.0) }
    }

    /// Returns the turn by an angle, counter-clockwise. Quarters of a turn are exact.
    pub fn turn(degrees: f64) -> Affine {
        let x = crate::heading(degrees);
        Affine { linear: Matrix2::from_columns(&[x, x.left()]), origin: Vec2::zeros() }
    }

    pub fn of(&self, p: Vec2) -> Vec2 {
        self.origin + self.linear * p
    }

    /// Returns the map that does `first`, then this one.
    pub fn after(&self, first: &Affine) -> Affine {
        Affine { linear: self.linear * first.linear, origin: self.of(first.origin) }
    }
}

/// Part of an ellipse: c + u cos t + v sin t, t from `from` to `to`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arc {
    pub centre: Vec2,
    pub u: Vec2,
    pub v: Vec2,
    pub from: f64,
    pub to: f64,
}

impl Arc {
    pub fn circle(centre: Vec2, radius: f64) -> Arc {
        Arc { centre, u: vec2(radius, 0.0), v: vec2(0.0, radius), from: 0.0, to: TAU }
    }

    /// Returns the arc from `a` to `b`; `bulge` is the tangent of a quarter of the angle, positive counter-clockwise.
    pub fn bulge(a: Vec2, b: Vec2, bulge: f64) -> Arc {
        let centre = (a + b) * 0.5 + (b - a).left() * ((1.0 - bulge * bulge) / (4.0 * bulge));
        let u = a - centre;
        Arc { centre, u, v: u.left(), from: 0.0, to: 4.0 * libm::atan(bulge) }
    }

    pub fn mapped(&self, by: &Affine) -> Arc {
        Arc { centre: by.of(self.centre), u: by.linear * self.u, v: by.linear * self.v, ..*self }
    }

    fn at(&self, t: f64) -> Vec2 {
        self.centre + self.u * libm::cos(t) + self.v * libm::sin(t)
    }

    /// Appends points after that of `from`, up to that of `to`.
    ///
    /// It is the image of a circle of radius 1. There a chord over an angle d is at most 1 − cos(d/2) from its arc, here
    /// at most so much times the longer half axis.
    pub fn trace(&self, deviation: f64, to: &mut Vec<Vec2>) -> Result<()> {
        let (p, q) = (self.u.norm_squared(), self.v.norm_squared());
        let longer = (0.5 * (p + q + libm::hypot(p - q, 2.0 * self.u.dot(&self.v)))).sqrt();
        let step = (2.0 * libm::acos((1.0 - deviation / longer).max(-1.0))).clamp(0.0, FRAC_PI_4);
        require(longer.is_finite(), || "a curve is too large".to_owned())?;
        let pieces = pieces(((self.to - self.from).abs() / step).ceil(), longer, deviation)?;
        check_length(to.len() + pieces)?;
        to.extend(
            (1..=pieces).map(|k| self.at(self.from + (self.to - self.from) * k as f64 / pieces as f64)),
        );
        Ok(())
    }
}

pub(super) fn check_length(corners: usize) -> Result<()> {
    Ok(require(corners <= MOST, || format!("it has more than {MOST} corners: too many"))?)
}

/// Returns a number of pieces, at least 1. Refuses too many, and what is not a number.
fn pieces(wanted: f64, size: f64, deviation: f64) -> Result<usize> {
    require(wanted <= MOST_PIECES, || {
        format!(
            "a curve of size {size:?} m with straight pieces that deviate by {deviation:?} m would have more than {MOST_PIECES} pieces"
        )
    })?;
    Ok((wanted as usize).max(1))
}

/// Appends points of a Bézier curve of degree 1 to 3 after its first control point, up to its last.
pub(super) fn bezier(control: &[Vec2], deviation: f64, to: &mut Vec<Vec2>) -> Result<()> {
    let degree = control.len().saturating_sub(1);
    let bend = control.windows(3).map(|p| (p[0] - p[1] * 2.0 + p[2]).norm()).fold(0.0, f64::max);
    // |C''| is at most degree (degree − 1) bend; a chord over h is at most h²/8 |C''| from the curve.
    let second = (degree * degree.saturating_sub(1)) as f64 * bend;
    let pieces = pieces((second / (8.0 * deviation)).sqrt().ceil(), bend, deviation)?;
    for k in 1..=pieces {
        to.push(casteljau(control, k as f64 / pieces as f64));
    }
    Ok(())
}

fn casteljau(control: &[Vec2], t: f64) -> Vec2 {
    let mut points = control.to_vec();
    for left in (1..points.len()).rev() {
        for k in 0..left {
            points[k] = points[k] * (1.0 - t) + points[k + 1] * t;
        }
    }
    points[0]
}

/// A B-spline, perhaps rational.
pub(super) struct Spline {
    pub degree: usize,
    /// One more than points and degree together.
    pub knots: Vec<f64>,
    pub control: Vec<Vec2>,
    /// As many as points, or none.
    pub weights: Vec<f64>,
}

impl Spline {
    /// Checks numbers and order.
    pub fn check(&self) -> Result<()> {
        let Spline { degree, knots, control, weights } = self;
        require((1..=25).contains(degree), || format!("degree {degree}: must be from 1 to 25"))?;
        let points = control.len();
        require(points > *degree, || format!("{points} control points are too few for degree {degree}"))?;
        require(knots.len() == points + degree + 1, || {
            format!(
                "{} knots: for {points} control points of degree {degree} there must be {}",
                knots.len(),
                points + degree + 1
            )
        })?;
        let ordered = knots.windows(2).all(|pair| pair[0] <= pair[1]) && knots[*degree] < knots[points];
        require(ordered, || "its knots do not ascend".to_owned())?;
        Ok(require(
            weights.is_empty() || weights.len() == points && weights.iter().all(|w| *w > 0.0),
            || "weights must be positive, one for each control point".to_owned(),
        )?)
    }

    /// Appends all points.
    pub fn trace(&self, deviation: f64, to: &mut Vec<Vec2>) -> Result<()> {
        to.push(self.at(self.knots[self.degree], self.degree));
        for span in self.degree..self.control.len() {
            let (low, high) = (self.knots[span], self.knots[span + 1]);
            if low == high {
                continue;
            }
            let pieces = if self.is_rational() {
                self.measured(span, deviation)?
            } else {
                let second = (high - low) * (high - low) * self.second_derivative(span);
                pieces((second / (8.0 * deviation)).sqrt().ceil(), second, deviation)?
            };
            check_length(to.len() + pieces)?;
            to.extend((1..=pieces).map(|k| self.at(low + (high - low) * k as f64 / pieces as f64, span)));
        }
        Ok(())
    }

    fn is_rational(&self) -> bool {
        self.weights.iter().any(|weight| *weight != self.weights[0])
    }

    /// The largest second derivative in a span: that of its control points.
    fn second_derivative(&self, span: usize) -> f64 {
        let (p, knots) = (self.degree, &self.knots);
        if p < 2 {
            return 0.0;
        }
        let first = |i: usize| {
            let width = knots[i + p + 1] - knots[i + 1];
            if width > 0.0 {
                (self.control[i + 1] - self.control[i]) * (p as f64 / width)
            } else {
                Vec2::zeros()
            }
        };
        let second = |i: usize| {
            let width = knots[i + p + 1] - knots[i + 2];
            if width > 0.0 { (first(i + 1) - first(i)).norm() * ((p - 1) as f64 / width) } else { 0.0 }
        };
        (span - p..=span - 2).map(second).fold(0.0, f64::max)
    }

    /// Returns the number of pieces of a span: doubles it until three places of each are near enough.
    fn measured(&self, span: usize, deviation: f64) -> Result<usize> {
        let (low, high) = (self.knots[span], self.knots[span + 1]);
        let mut count = 4;
        loop {
            let at = |k: f64| self.at(low + (high - low) * k / count as f64, span);
            let near = |k: usize| {
                let (a, b) = (at(k as f64), at(k as f64 + 1.0));
                let off = |part: f64| {
                    let p = at(k as f64 + part);
                    (p - lemons_core::plane::nearest_on_segment(a, b, p)).norm()
                };
                [0.25, 0.5, 0.75].into_iter().all(|part| off(part) <= 0.9 * deviation)
            };
            if (0..count).all(near) {
                return Ok(count);
            }
            count = pieces(2.0 * count as f64, (at(0.0) - at(count as f64)).norm(), deviation)?;
        }
    }

    /// De Boor's algorithm, in homogeneous coordinates.
    fn at(&self, t: f64, span: usize) -> Vec2 {
        let p = self.degree;
        let weight = |k: usize| self.weights.get(k).copied().unwrap_or(1.0);
        let mut points: Vec<(Vec2, f64)> =
            (span - p..=span).map(|k| (self.control[k] * weight(k), weight(k))).collect();
        for level in 1..=p {
            for j in (level..=p).rev() {
                let i = span - p + j;
                let width = self.knots[i + p + 1 - level] - self.knots[i];
                let a = if width > 0.0 { (t - self.knots[i]) / width } else { 0.0 };
                points[j] = (
                    points[j - 1].0 * (1.0 - a) + points[j].0 * a,
                    points[j - 1].1 * (1.0 - a) + points[j].1 * a,
                );
            }
        }
        let (point, weight) = points[p];
        point * (1.0 / weight)
    }
}

/// The arc of an ellipse in SVG, by its ends: radii, rotation of the x axis in degrees, and two choices among four.
pub(super) fn by_ends(
    a: Vec2,
    b: Vec2,
    radii: Vec2,
    degrees: f64,
    large: bool,
    counter: bool,
) -> Option<Arc> {
    let (rx, ry) = (radii.x.abs(), radii.y.abs());
    if a == b || rx == 0.0 || ry == 0.0 {
        return None;
    }
    let axes = Affine::turn(degrees).linear;
    // The ellipse becomes a circle of radius 1.
    let there = (axes.transpose() * (a - b) * 0.5).component_div(&vec2(rx, ry));
    let length = there.norm();
    // Radii that are too small grow until the ends are on the ellipse.
    let grown = length.max(1.0);
    let there = there * (1.0 / grown);
    let square = there.norm_squared();
    let far = ((1.0 - square).max(0.0) / square).sqrt() * if large == counter { -1.0 } else { 1.0 };
    let centre = vec2(there.y, -there.x) * far;
    let angle = |p: Vec2| libm::atan2(p.y, p.x);
    let (from, to) = (angle(there - centre), angle(there * -1.0 - centre));
    let mut sweep = (to - from).rem_euclid(TAU);
    if !counter {
        sweep -= TAU;
    }
    let (u, v) = (axes.column(0) * (rx * grown), axes.column(1) * (ry * grown));
    let centre = (a + b) * 0.5 + u * centre.x + v * centre.y;
    Some(Arc { centre, u, v, from, to: from + sweep })
}

/// Returns the ends of an arc \[rad\] such that it goes counter-clockwise; a whole turn where they are the same.
pub(super) fn sweep(from: f64, to: f64) -> [f64; 2] {
    let (from, to) = (from.rem_euclid(TAU), to.rem_euclid(TAU));
    [from, if to <= from + 1e-12 * PI { to + TAU } else { to }]
}
