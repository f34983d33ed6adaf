//! A smooth skin through outlines: monotone cubics of the altitude, cut into rings.

use super::outline::{POINTS, Points};
use lemons_core::plane::{Vec2, vec2};

/// \[m\] Largest distance between two rings; the walls between them are straight. Smaller is smoother and slower.
const STEP: f64 = 0.02;

/// An outline at an altitude.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Ring {
    /// \[m\] altitude.
    pub z: f64,
    /// \[m\] counter-clockwise.
    pub points: Points,
}

/// Returns rings through landmark rings, which are sorted by altitude and stay unchanged. Each coordinate of each point
/// is a monotone cubic of the altitude, so nothing bulges beyond the landmarks.
pub(super) fn skin(landmarks: &[Ring]) -> Vec<Ring> {
    let slopes = slopes(landmarks);
    let mut rings = Vec::new();
    for (k, pair) in landmarks.windows(2).enumerate() {
        let (low, high) = (&pair[0], &pair[1]);
        rings.push(low.clone());
        let height = high.z - low.z;
        let pieces = (height / STEP).ceil().max(2.0) as usize;
        for piece in 1..pieces {
            let t = piece as f64 / pieces as f64;
            let points = std::array::from_fn(|i| {
                let hermite = |a, b, da, db| hermite(t, height, [a, b], [da, db]);
                let (p, q, dp, dq) = (low.points[i], high.points[i], slopes[k][i], slopes[k + 1][i]);
                vec2(hermite(p.x, q.x, dp.x, dq.x), hermite(p.y, q.y, dp.y, dq.y))
            });
            rings.push(Ring { z: low.z + t * height, points });
        }
    }
    rings.extend(landmarks.last().cloned());
    rings
}

/// The cubic with these values and slopes at the ends of an interval.
fn hermite(t: f64, height: f64, ends: [f64; 2], slopes: [f64; 2]) -> f64 {
    let s = 1.0 - t;
    ends[0] * (1.0 + 2.0 * t) * s * s
        + ends[1] * (1.0 + 2.0 * s) * t * t
        + height * t * s * (slopes[0] * s - slopes[1] * t)
}

/// Slopes at the landmarks that keep the cubics monotone: Fritsch and Butland (1984).
fn slopes(landmarks: &[Ring]) -> Vec<[Vec2; POINTS]> {
    let count = landmarks.len();
    let secant = |k: usize, i: usize| {
        let (low, high) = (&landmarks[k], &landmarks[k + 1]);
        (high.points[i] - low.points[i]) * (1.0 / (high.z - low.z))
    };
    (0..count)
        .map(|k| {
            std::array::from_fn(|i| match (k, count) {
                (_, 0 | 1) => Vec2::zeros(),
                (0, _) => secant(0, i),
                (k, _) if k == count - 1 => secant(k - 1, i),
                _ => {
                    let (below, above) = (secant(k - 1, i), secant(k, i));
                    let (h, g) = (landmarks[k].z - landmarks[k - 1].z, landmarks[k + 1].z - landmarks[k].z);
                    vec2(between(below.x, above.x, h, g), between(below.y, above.y, h, g))
                }
            })
        })
        .collect()
}

/// The slope between two secants over intervals h and g: zero if their signs differ, else their weighted harmonic mean.
fn between(below: f64, above: f64, h: f64, g: f64) -> f64 {
    if below * above <= 0.0 {
        return 0.0;
    }
    let (first, second) = (2.0 * g + h, g + 2.0 * h);
    (first + second) / (first / below + second / above)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(z: f64, radius: f64) -> Ring {
        Ring { z, points: super::super::outline::directions(0.0).map(|way| way * radius) }
    }

    #[test]
    fn a_cone_stays_a_cone() {
        let rings = skin(&[ring(0.0, 1.0), ring(0.1, 0.9), ring(0.3, 0.7)]);
        for ring in &rings {
            assert!((ring.points[0].x - (1.0 - ring.z)).abs() < 1e-14, "{}", ring.z);
        }
        assert!(rings.windows(2).all(|pair| pair[1].z - pair[0].z < STEP * (1.0 + 1e-12)));
    }

    #[test]
    fn nothing_swells_beyond_its_landmarks() {
        let rings = skin(&[ring(0.0, 1.0), ring(0.2, 1.0), ring(0.25, 0.2), ring(0.5, 0.3)]);
        let radius = |ring: &Ring| ring.points[0].x;
        assert!(rings.iter().all(|ring| (0.2..=1.0).contains(&radius(ring))));
        let falling = rings.iter().filter(|ring| ring.z <= 0.25);
        assert!(falling.clone().zip(falling.skip(1)).all(|(a, b)| radius(a) >= radius(b) - 1e-15));
    }
}
