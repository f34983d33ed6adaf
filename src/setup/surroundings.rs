//! The area that walls span, and who is far from it.

use crate::engine::{Scene, Vec2, vec2};
use lemons_core::plane::{Bounds, ConvexHull};

/// The area of the walls.
pub(super) struct Surroundings {
    pub(super) bounds: Bounds,
    hull: ConvexHull,
}

impl Surroundings {
    /// `None` without walls.
    pub(super) fn of(scene: &Scene) -> Option<Surroundings> {
        let corners = || scene.corners.iter().map(|corner| corner.position);
        Some(Surroundings { bounds: Bounds::of(corners())?, hull: ConvexHull::of(corners())? })
    }

    /// Returns those of some indexed places that are further \[m\] than a distance from the walls' convex hull (at its
    /// corners by up to 2 % more). Each place needs some binary searches; computing its distance would visit each
    /// corner.
    pub(super) fn beyond<'a>(
        &self,
        far: f64,
        places: impl Iterator<Item = (usize, &'a Vec2)>,
    ) -> impl Iterator<Item = usize> {
        let mut around = None;
        let outside = places.filter(move |(_, place)| {
            // Nearly all people are between the walls.
            let between = self.bounds.contains(**place) && self.hull.contains(**place);
            !between
                && around
                    .get_or_insert_with(|| grown(&self.hull, far))
                    .as_ref()
                    .is_none_or(|around| !around.contains(**place))
        });
        outside.map(|(b, _)| b)
    }
}

/// Returns the hull enlarged by a distance \[m\], at its corners by up to 2 % more.
fn grown(hull: &ConvexHull, by: f64) -> Option<ConvexHull> {
    const SIDES: u32 = 16;
    let turn = std::f64::consts::TAU / f64::from(SIDES);
    // The polygon contains the circle.
    let reach = by / libm::cos(0.5 * turn);
    let offset = |k: u32| {
        let angle = f64::from(k) * turn;
        vec2(reach * libm::cos(angle), reach * libm::sin(angle))
    };
    let around: Vec<Vec2> = (0..SIDES).map(offset).collect();
    ConvexHull::of(hull.corners().iter().flat_map(|corner| around.iter().map(|offset| *corner + *offset)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hull_grows_by_the_distance() {
        let circle =
            |k: u32| vec2(50.0 * libm::cos(f64::from(k) * 1e-2), 50.0 * libm::sin(f64::from(k) * 1e-2));
        let corners: [Vec<Vec2>; 3] =
            [vec![vec2(50.0, 0.0)], vec![vec2(50.0, 0.0), vec2(0.0, 0.0)], (0..629).map(circle).collect()];
        for corners in corners {
            let hull = ConvexHull::of(corners).unwrap();
            let grown = grown(&hull, 2.0).unwrap();
            for k in 0..2000 {
                let place = vec2(45.0 + 5e-3 * f64::from(k), 3.0 - 3e-3 * f64::from(k));
                let (away, within) = (hull.distance(place), grown.contains(place));
                assert!(if within { away < 2.04 } else { away > 1.999 }, "{place:?} {away}");
            }
        }
    }
}
