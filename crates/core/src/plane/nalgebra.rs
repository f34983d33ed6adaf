//! Conversions for programs that compute with `nalgebra`.

use crate::plane::{Pose, Rotation, Vec2, vec2};
use nalgebra::{Isometry2, Point2, Translation2, UnitComplex, Vector2};

impl From<Vec2> for Vector2<f64> {
    fn from(vector: Vec2) -> Vector2<f64> {
        Vector2::new(vector.x, vector.y)
    }
}

impl From<Vector2<f64>> for Vec2 {
    fn from(vector: Vector2<f64>) -> Vec2 {
        vec2(vector.x, vector.y)
    }
}

impl From<Vec2> for Point2<f64> {
    fn from(point: Vec2) -> Point2<f64> {
        Point2::new(point.x, point.y)
    }
}

impl From<Point2<f64>> for Vec2 {
    fn from(point: Point2<f64>) -> Vec2 {
        vec2(point.x, point.y)
    }
}

/// Copies sine and cosine bit by bit.
impl From<Rotation> for UnitComplex<f64> {
    fn from(rotation: Rotation) -> UnitComplex<f64> {
        UnitComplex::from_cos_sin_unchecked(rotation.cos, rotation.sin)
    }
}

/// Copies sine and cosine bit by bit.
impl From<UnitComplex<f64>> for Rotation {
    fn from(rotation: UnitComplex<f64>) -> Rotation {
        Rotation { sin: rotation.im, cos: rotation.re }
    }
}

/// The map from a body's frame to the plane: turned about its centre of mass, then moved. Sine and cosine are those of
/// [`Rotation::by`], the same bits on every machine.
impl From<Pose> for Isometry2<f64> {
    fn from(pose: Pose) -> Isometry2<f64> {
        let Pose { position, orientation } = pose;
        Isometry2::from_parts(Translation2::new(position.x, position.y), Rotation::by(orientation).into())
    }
}

/// The orientation is between −π and π, because an isometry does not contain whole turns.
impl From<Isometry2<f64>> for Pose {
    fn from(isometry: Isometry2<f64>) -> Pose {
        let orientation = libm::atan2(isometry.rotation.im, isometry.rotation.re);
        Pose { position: isometry.translation.vector.into(), orientation }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::{PI, TAU};

    fn vector() -> impl Strategy<Value = Vec2> {
        (-1e3..1e3, -1e3..1e3).prop_map(|(x, y)| vec2(x, y))
    }

    fn pose() -> impl Strategy<Value = Pose> {
        (vector(), -20.0..20.0).prop_map(|(position, orientation)| Pose { position, orientation })
    }

    /// Where a pose takes a point of its body.
    fn taken(pose: Pose, point: Vec2) -> Vec2 {
        point.rotated(Rotation::by(pose.orientation)) + pose.position
    }

    fn apart(one: Vec2, other: Vec2) -> f64 {
        (one - other).norm()
    }

    proptest! {
        #[test]
        fn vectors_come_back_bit_for_bit(vector in vector()) {
            prop_assert_eq!(Vec2::from(Vector2::from(vector)), vector);
            prop_assert_eq!(Vec2::from(Point2::from(vector)), vector);
            let (one, other) = (vector, vector.perp() + vec2(0.5, 2.0));
            let (left, right) = (Vector2::from(one), Vector2::from(other));
            prop_assert_eq!(left.dot(&right), one.dot(other));
            prop_assert_eq!(left.perp(&right), one.cross(other));
        }

        #[test]
        fn poses_follow_each_other_as_isometries_do(first in pose(), second in pose(), point in vector()) {
            let (one, other) = (Isometry2::from(first), Isometry2::from(second));
            // nalgebra turns by the same products: no bit is lost.
            prop_assert_eq!(Vec2::from(one * Point2::from(point)), taken(first, point));
            let both = Pose::from(other * one);
            prop_assert!(apart(taken(both, point), taken(second, taken(first, point))) < 1e-11);
            let turned = (both.orientation - first.orientation - second.orientation).rem_euclid(TAU);
            prop_assert!(turned.min(TAU - turned) < 1e-14);
            prop_assert!(apart(taken(Pose::from(one.inverse()), taken(first, point)), point) < 1e-11);
        }

        #[test]
        fn a_pose_comes_back_but_for_whole_turns(pose in pose()) {
            let back = Pose::from(Isometry2::from(pose));
            prop_assert_eq!(back.position, pose.position);
            prop_assert!((-PI..=PI).contains(&back.orientation));
            let turns = (back.orientation - pose.orientation) / TAU;
            prop_assert!((turns - turns.round()).abs() < 1e-14);
        }

        /// Theirs are of the platform or of `libm`, ours of polynomials.
        #[test]
        fn a_turn_is_that_of_nalgebra(angle in -100.0..100.0) {
            let (ours, theirs) = (UnitComplex::from(Rotation::by(angle)), UnitComplex::new(angle));
            prop_assert!((ours.re - theirs.re).abs() < 3e-16 && (ours.im - theirs.im).abs() < 3e-16);
            prop_assert_eq!(Rotation::from(ours), Rotation::by(angle));
        }
    }
}
