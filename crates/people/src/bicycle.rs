//! Bicycles with their riders, seen from above: the paper's second kind of agent (section 2.1 and "Extension to
//! arbitrary shapes"). A body of the mechanics has the disks that cover both rectangles. The paper's mechanics has no
//! bicycles.

use lemons_core::distribution::TruncatedNormal;
use lemons_core::plane::{Disk, vec2};

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
    /// \[kg\] mass of the bicycle.
    pub mass: f64,
}

/// Largest number of cells along a rectangle in [`Bicycle::covering_disks`].
const MOST_CELLS: f64 = 64.0;

/// Names and units of a bicycle's measures, in the order of [`Bicycle::measures`].
pub const BICYCLE_MEASURES: [(&str, &str); 5] =
    [("wheel width", "m"), ("length", "m"), ("handlebar", "m"), ("top tube", "m"), ("mass", "kg")];

/// The least and the greatest value \[m\], \[kg\] of each measure that a bicycle can have.
pub(crate) const POSSIBLE: [[f64; 2]; 5] = [[0.01, 1.0], [0.5, 5.0], [0.1, 2.0], [0.1, 2.0], [1.0, 500.0]];

/// The paper's distributions of the measures of bicycles. They are independent, because no survey gives their
/// correlations.
pub const PAPER_BICYCLES: [TruncatedNormal; 5] = [
    TruncatedNormal { mean: 0.06, sd: 0.005, min: 0.02, max: 0.2 },
    TruncatedNormal { mean: 1.42, sd: 0.05, min: 1.0, max: 2.0 },
    TruncatedNormal { mean: 0.45, sd: 0.05, min: 0.3, max: 0.9 },
    TruncatedNormal { mean: 0.61, sd: 0.05, min: 0.4, max: 0.9 },
    TruncatedNormal { mean: 30.0, sd: 5.0, min: 10.0, max: 100.0 },
];

impl Bicycle {
    /// The paper's template: 11.137 × 142 cm and 59.863 × 68.912 cm.
    pub const TEMPLATE: Bicycle =
        Bicycle { wheel_width: 0.111_37, length: 1.42, handlebar: 0.598_63, top_tube: 0.689_12, mass: 30.0 };

    /// In the order of [`BICYCLE_MEASURES`].
    pub fn measures(&self) -> [f64; 5] {
        [self.wheel_width, self.length, self.handlebar, self.top_tube, self.mass]
    }

    /// Makes a bicycle from measures in the order of [`BICYCLE_MEASURES`].
    pub fn from_measures([wheel_width, length, handlebar, top_tube, mass]: [f64; 5]) -> Bicycle {
        Bicycle { wheel_width, length, handlebar, top_tube, mass }
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

    /// Number of disks across the rider's rectangle.
    pub const ACROSS: usize = 4;

    /// Returns disks that cover the bicycle's rectangle, and those that cover the rider's, each row from right to left, the
    /// foremost row last. The gaze is along +x.
    /// Each rectangle is cut into nearly square cells, and each cell gets the disk through its corners. The disks reach
    /// over the edge by at most a fifth of a cell's side: 1 to 2 cm beside the wheels, 3 cm beside the rider.
    pub fn covering_disks(&self) -> [Vec<Disk>; 2] {
        let [bicycle, rider] = self.rectangles();
        let cells = |(length, breadth): (f64, f64), across: usize| {
            let across = across as f64;
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
        [cells(bicycle, 1).collect(), cells(rider, Bicycle::ACROSS).collect()]
    }

    /// Returns the moment of inertia about the centre \[kg m²\], for a mass spread evenly over the union of both
    /// rectangles.
    pub fn inertia(&self) -> f64 {
        let second = |(sign, a, b): (f64, f64, f64)| sign * a * b * (a * a + b * b) / 12.0;
        let polar: f64 = self.parts().into_iter().map(second).sum();
        self.mass * polar / self.area()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn area_and_inertia_are_those_of_a_fine_grid() {
        let around = Bicycle { wheel_width: 0.8, ..Bicycle::TEMPLATE };
        let inside = Bicycle { handlebar: 0.1, top_tube: 0.5, ..Bicycle::TEMPLATE };
        for bicycle in [Bicycle::TEMPLATE, around, inside] {
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
            let disks = bicycle.covering_disks().concat();
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
}
