//! Bicycles with their riders, seen from above: the paper's second kind of agent (section 2.1 and "Extension to
//! arbitrary shapes"). They can be placed and written to files. The mechanics does not simulate them; neither does the
//! paper's.

use crate::normal::{TruncatedNormal, TruncatedNormalError};
use crate::random::uniform;
use lemons_core::plane::Disk;
use lemons_core::plane::vec2;
use rand_chacha::rand_core::Rng;
use thiserror::Error;

/// A bicycle and its rider: two rectangles with the same centre. Lengths are along the gaze (direction of travel).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bicycle {
    /// \[m\] width across the wheels: breadth of the bicycle's rectangle.
    pub wheel_width: f64,
    /// \[m\] length over both wheels: length of the bicycle's rectangle.
    pub length: f64,
    /// \[m\] width across the handlebar: breadth of the rider's rectangle.
    pub handlebar: f64,
    /// \[m\] length of the top tube: length of the rider's rectangle.
    pub top_tube: f64,
    /// \[kg\] mass of bicycle and rider.
    pub mass: f64,
}

/// Largest number of cells along a rectangle in [`Bicycle::covering_disks`].
const MOST_CELLS: f64 = 64.0;

/// The names of a bicycle's measures, in the order of [`Bicycle::measures`].
pub const BICYCLE_MEASURES: [&str; 5] = ["wheel width", "length", "handlebar", "top tube", "mass"];

/// A measure of a bicycle that is not positive and finite, or whose statistics are impossible.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[allow(missing_docs)] // the messages say it
pub enum BicycleError {
    #[error("{measure} = {value}: must be positive and finite")]
    NotPositive { measure: &'static str, value: f64 },
    #[error("bicycle's {measure}: {error}")]
    Statistics { measure: &'static str, error: TruncatedNormalError },
}

impl Bicycle {
    /// The paper's template: 11.137 × 142 cm and 59.863 × 68.912 cm.
    pub const TEMPLATE: Bicycle =
        Bicycle { wheel_width: 0.111_37, length: 1.42, handlebar: 0.598_63, top_tube: 0.689_12, mass: 30.0 };

    /// In the order of [`BICYCLE_MEASURES`].
    pub fn measures(&self) -> [f64; 5] {
        [self.wheel_width, self.length, self.handlebar, self.top_tube, self.mass]
    }

    /// Checks that it has an area and a mass.
    ///
    /// # Errors
    /// A measure is not positive and finite.
    pub fn check(&self) -> Result<(), BicycleError> {
        for (measure, value) in BICYCLE_MEASURES.into_iter().zip(self.measures()) {
            if !(value > 0.0 && value.is_finite()) {
                return Err(BicycleError::NotPositive { measure, value });
            }
        }
        Ok(())
    }

    /// Returns length and breadth \[m\] of the bicycle's rectangle, then of the rider's. Both are centred on the centre
    /// of mass.
    pub fn rectangles(&self) -> [(f64, f64); 2] {
        [(self.length, self.wheel_width), (self.top_tube, self.handlebar)]
    }

    /// Both rectangles and their intersection, which is a rectangle too: its area counts as negative.
    fn parts(&self) -> [(f64, f64, f64); 3] {
        let [(a, b), (c, d)] = self.rectangles();
        [(1.0, a, b), (1.0, c, d), (-1.0, a.min(c), b.min(d))]
    }

    /// Returns the area of the union of both rectangles \[m²\].
    pub fn area(&self) -> f64 {
        self.parts().into_iter().map(|(sign, length, breadth)| sign * length * breadth).sum()
    }

    /// Returns disks that cover both rectangles, to place bicycles among people without overlap. The gaze is along +x.
    /// Each rectangle is cut into nearly square cells, and each cell gets the disk through its corners. The disks reach
    /// over the edge by at most a fifth of a cell's side: 1 to 2 cm beside the wheels, 3 cm beside the rider.
    pub fn covering_disks(&self) -> Vec<Disk> {
        let [bicycle, rider] = self.rectangles();
        let cells = |(length, breadth): (f64, f64), across: f64| {
            let side = breadth / across;
            let along = libm::ceil(length / side).clamp(1.0, MOST_CELLS);
            let (a, b) = (length / along, side);
            let radius = 0.5 * libm::hypot(a, b);
            let places = move |count: f64, size: f64| {
                (0..count as u32).map(move |k| (f64::from(k) + 0.5 - 0.5 * count) * size)
            };
            places(along, a)
                .flat_map(move |x| places(across, b).map(move |y| Disk { radius, centre: vec2(x, y) }))
        };
        cells(bicycle, 1.0).chain(cells(rider, 4.0)).collect()
    }

    /// Returns the moment of inertia about the centre \[kg m²\], for a mass spread evenly over the union of both
    /// rectangles.
    pub fn inertia(&self) -> f64 {
        let second = |(sign, a, b): (f64, f64, f64)| sign * a * b * (a * a + b * b) / 12.0;
        let polar: f64 = self.parts().into_iter().map(second).sum();
        self.mass * polar / self.area()
    }
}

/// Distributions of the measures of bicycles. They are independent, because no survey gives their correlations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BicycleStatistics {
    /// \[m\] width across the wheels.
    pub wheel_width: TruncatedNormal,
    /// \[m\] length over both wheels.
    pub length: TruncatedNormal,
    /// \[m\] width across the handlebar.
    pub handlebar: TruncatedNormal,
    /// \[m\] length of the top tube.
    pub top_tube: TruncatedNormal,
    /// \[kg\] mass of bicycle and rider.
    pub mass: TruncatedNormal,
}

impl Default for BicycleStatistics {
    /// The paper's defaults.
    fn default() -> BicycleStatistics {
        let normal = |mean, sd, min, max| TruncatedNormal { mean, sd, min, max };
        BicycleStatistics {
            wheel_width: normal(0.06, 0.005, 0.02, 0.2),
            length: normal(1.42, 0.05, 1.0, 2.0),
            handlebar: normal(0.45, 0.05, 0.3, 0.9),
            top_tube: normal(0.61, 0.05, 0.4, 0.9),
            mass: normal(30.0, 5.0, 10.0, 100.0),
        }
    }
}

impl BicycleStatistics {
    fn all(&self) -> [TruncatedNormal; 5] {
        [self.wheel_width, self.length, self.handlebar, self.top_tube, self.mass]
    }

    /// Checks that bicycles can be drawn.
    ///
    /// # Errors
    /// The first measure whose distribution is impossible.
    pub fn check(&self) -> Result<(), BicycleError> {
        for (measure, normal) in BICYCLE_MEASURES.into_iter().zip(self.all()) {
            normal.check().map_err(|error| BicycleError::Statistics { measure, error })?;
        }
        Ok(())
    }

    /// Draws one bicycle. The statistics must have passed [`check`](BicycleStatistics::check).
    pub fn draw<R: Rng + ?Sized>(&self, rng: &mut R) -> Bicycle {
        let [wheel_width, length, handlebar, top_tube, mass] =
            self.all().map(|normal| normal.quantile(uniform(rng)));
        Bicycle { wheel_width, length, handlebar, top_tube, mass }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::generator;

    #[test]
    fn area_and_inertia_are_those_of_a_fine_grid() {
        let around = Bicycle { wheel_width: 0.8, ..Bicycle::TEMPLATE };
        let inside = Bicycle { handlebar: 0.1, top_tube: 0.5, ..Bicycle::TEMPLATE };
        for bicycle in [Bicycle::TEMPLATE, around, inside] {
            bicycle.check().unwrap();
            let cell = 1e-3;
            let (mut area, mut polar) = (0.0, 0.0);
            for i in -800..800 {
                for j in -500..500 {
                    let (x, y) = ((f64::from(i) + 0.5) * cell, (f64::from(j) + 0.5) * cell);
                    let inside = |(a, b): (f64, f64)| 2.0 * x.abs() < a && 2.0 * y.abs() < b;
                    if bicycle.rectangles().into_iter().any(inside) {
                        area += cell * cell;
                        polar += cell * cell * (x * x + y * y);
                    }
                }
            }
            assert!((bicycle.area() / area - 1.0).abs() < 1e-2, "{} {area}", bicycle.area());
            let inertia = bicycle.mass * polar / area;
            assert!((bicycle.inertia() / inertia - 1.0).abs() < 5e-3, "{} {inertia}", bicycle.inertia());
        }
        // One rectangle in the other: m (a² + b²)/12.
        let one = Bicycle { wheel_width: 0.4, length: 1.0, handlebar: 0.3, top_tube: 0.5, mass: 12.0 };
        assert!((one.inertia() - 1.16).abs() < 1e-14 && (one.area() - 0.4).abs() < 1e-15);
    }

    #[test]
    fn disks_cover_the_rectangles_closely() {
        let small = Bicycle { wheel_width: 0.06, length: 1.4, handlebar: 0.45, top_tube: 0.61, mass: 20.0 };
        for bicycle in [Bicycle::TEMPLATE, small] {
            let disks = bicycle.covering_disks();
            for (length, breadth) in bicycle.rectangles() {
                for i in -50..=50 {
                    for j in -20..=20 {
                        let point = vec2(0.01 * f64::from(i) * length, 0.025 * f64::from(j) * breadth);
                        let covers = |disk: &Disk| (disk.centre - point).norm() <= disk.radius + 1e-12;
                        assert!(disks.iter().any(covers), "{point:?}");
                    }
                }
            }
            let far = |along: fn(&Disk) -> f64| disks.iter().map(along).fold(0.0, f64::max);
            let (ahead, aside) = (far(|d| d.centre.x + d.radius), far(|d| d.centre.y + d.radius));
            assert!(ahead < 0.5 * bicycle.length + 0.03, "{ahead}");
            assert!(aside < 0.5 * bicycle.handlebar + 0.04, "{aside}");
        }
    }

    #[test]
    fn drawn_bicycles_follow_the_statistics() {
        let statistics = BicycleStatistics::default();
        statistics.check().unwrap();
        let rng = &mut generator(3);
        let drawn: Vec<[f64; 5]> = (0..40_000).map(|_| statistics.draw(rng).measures()).collect();
        for (place, normal) in statistics.all().into_iter().enumerate() {
            let values = drawn.iter().map(|measures| measures[place]);
            let mean = values.clone().sum::<f64>() / drawn.len() as f64;
            let sd = (values.map(|x| (x - mean).powi(2)).sum::<f64>() / drawn.len() as f64).sqrt();
            // The bounds are three standard deviations away or more: 1 % of the deviation at most.
            assert!(
                (mean / normal.mean - 1.0).abs() < 0.005 && (sd / normal.sd - 1.0).abs() < 0.02,
                "{place}"
            );
        }
    }

    #[test]
    fn bad_statistics_are_named() {
        let mut statistics = BicycleStatistics::default();
        statistics.top_tube.sd = -1.0;
        assert_eq!(
            statistics.check().unwrap_err().to_string(),
            "bicycle's top tube: the standard deviation = -1: must be positive"
        );
        let wrong = Bicycle { mass: 0.0, ..Bicycle::TEMPLATE };
        assert_eq!(wrong.check().unwrap_err().to_string(), "mass = 0: must be positive and finite");
    }
}
