//! How dense a crowd is in an area, and how fast.

use crate::Frame;
use crate::measure::present;
use crate::measure::voronoi::VoronoiRoom;
use crate::shapes::check;
use lemons_core::plane::overlay::{InsideRule, area, contour, intersection};
use lemons_core::plane::{Bounds, Polygon, Ring, Vec2, vec2};
use serde::Serialize;

/// An area in which a crowd is measured.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuringArea(Ring);

/// A crowd in an area at one time. The names of the fields are those of the numbers in files.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Density {
    /// \[s\]
    #[serde(skip)]
    pub time: f64,
    /// People whose centre of mass is in the area.
    pub people: usize,
    /// \[1/m²\] Their number over the area.
    pub density: f64,
    /// \[1/m²\] Of each person the part of the Voronoi cell that is in the area; the sum over the area. `None` without a
    /// room.
    pub voronoi_density: Option<f64>,
    /// \[m/s\] Mean speed of those in the area whose speed is known; `None` without any.
    pub speed: Option<f64>,
}

impl MeasuringArea {
    /// Makes the area inside a ring \[m\]; `None` if it crosses itself, has no area, more than 10 000 corners, or one further than 1e6 m from
    /// the origin.
    pub fn inside(ring: Ring) -> Option<MeasuringArea> {
        (check(&ring).is_ok() && ring.area() > 0.0).then_some(MeasuringArea(ring))
    }

    /// Makes the area of numbers \[m\]: four are the lower left and the upper right corner of a rectangle, six or more the corners of a
    /// polygon. `None` if they are neither.
    pub fn of_numbers(numbers: &[f64]) -> Option<MeasuringArea> {
        let corners: Vec<Vec2> = numbers.chunks_exact(2).map(|point| vec2(point[0], point[1])).collect();
        let ring = match corners[..] {
            _ if !numbers.len().is_multiple_of(2) => None,
            [low, high] if low.x < high.x && low.y < high.y => Some(Ring::around(Bounds { low, high })),
            [_, _] => None,
            _ => Ring::through(corners),
        };
        ring.and_then(MeasuringArea::inside)
    }

    /// Returns the area \[m²\].
    pub fn area(&self) -> f64 {
        self.0.area()
    }

    /// Returns the corners as [`MeasuringArea::of_numbers`] wants them \[m\].
    pub fn numbers(&self) -> Vec<f64> {
        self.0.corners().iter().flat_map(|corner| [corner.x, corner.y]).collect()
    }

    /// Returns whether a place \[m\] is in it.
    pub fn contains(&self, place: Vec2) -> bool {
        self.0.contains(place)
    }

    /// Returns whether it has some area in common with a polygon.
    pub fn meets(&self, polygon: &Polygon) -> bool {
        let other: Vec<_> = polygon.rings().map(contour).collect();
        intersection(&[contour(&self.0)], &other, InsideRule::EvenOdd).iter().any(|part| area(part) > 0.0)
    }

    /// Measures a frame. `room` is where people can be, which Voronoi cells need.
    pub fn measure(&self, frame: &Frame, room: Option<&VoronoiRoom>) -> Density {
        let there: Vec<_> = (0..frame.agents.len()).filter_map(|agent| present(frame, agent)).collect();
        let inside = there.iter().filter(|motion| self.contains(motion.pose.position));
        let speeds: Vec<f64> = inside.map(|motion| motion.twist.velocity.norm()).collect();
        let count = speeds.len();
        // Of trajectories, the speed of somebody may not be known.
        let speeds: Vec<f64> = speeds.into_iter().filter(|speed| !speed.is_nan()).collect();
        let voronoi_density = room.map(|room| {
            // Heads lean over walls.
            let people: Vec<Vec2> = there.iter().map(|motion| room.nearest(motion.pose.position).0).collect();
            let shape = vec![contour(&self.0)];
            let cells = room.cells(&people, self.0.bounds()).into_iter().flatten();
            // A cell without area is that of somebody outside of the room, or squeezed into a corner of the polygon.
            let cells = cells.map(|cell| (area(&cell), cell)).filter(|(area, _)| *area > 0.0);
            let parts = cells.map(|(whole, cell)| {
                let common: f64 =
                    intersection(&cell, &shape, InsideRule::EvenOdd).iter().map(|part| area(part)).sum();
                common / whole
            });
            // A sum of nothing is -0.
            (0.0 + parts.sum::<f64>()) / self.area()
        });
        Density {
            time: frame.time,
            people: count,
            density: count as f64 / self.area(),
            voronoi_density,
            speed: (!speeds.is_empty()).then(|| speeds.iter().sum::<f64>() / speeds.len() as f64),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measured_area;
    use lemons_core::plane::{Motion, Polygon, Pose, Twist};
    use lemons_core::trial::Wall;

    fn frame(places: &[(f64, f64)]) -> Frame {
        let motion = |&(x, y): &(f64, f64)| Motion {
            pose: Pose { position: vec2(x, y), orientation: 0.0 },
            twist: Twist { velocity: vec2(0.3 * x, 0.4 * x), angular_velocity: 0.0 },
        };
        Frame { agents: places.iter().map(motion).collect(), ..Frame::default() }
    }

    fn square(low: f64, high: f64) -> Ring {
        Ring::around(Bounds { low: vec2(low, low), high: vec2(high, high) })
    }

    #[test]
    fn a_lattice_has_the_density_of_its_cells() {
        let places: Vec<(f64, f64)> = (0..10)
            .flat_map(|i| (0..10).map(move |k| (f64::from(i) * 0.5 + 0.25, f64::from(k) * 0.5 + 0.25)))
            .collect();
        let room = VoronoiRoom::of(&Polygon { outer: square(0.0, 5.0), holes: Vec::new() });
        // Its rim cuts cells, which the classic density cannot see.
        let area = MeasuringArea::inside(square(1.1, 3.7)).unwrap();
        let seen = area.measure(&frame(&places), Some(&room));
        assert!((seen.voronoi_density.unwrap() - 4.0).abs() < 1e-6, "{seen:?}");
        assert_eq!((seen.people, seen.density), (25, 25.0 / area.area()));
        // |v| = x / 2, of x = 1.25, 1.75, …, 3.25.
        assert!((seen.speed.unwrap() - 1.125).abs() < 1e-12);
        let nobody = area.measure(&frame(&[]), Some(&room));
        assert_eq!((nobody.people, nobody.voronoi_density, nobody.speed), (0, Some(0.0), None));
        // Printed, it was -0.0; also where people are, but not in the area.
        let elsewhere = MeasuringArea::inside(square(0.0, 1.0)).unwrap();
        let elsewhere = elsewhere.measure(&frame(&[(4.5, 4.5), (0.5, 3.5), (3.5, 0.5)]), Some(&room));
        assert!(elsewhere.people == 0 && elsewhere.voronoi_density.unwrap() > 0.0, "{elsewhere:?}");
        assert!(nobody.voronoi_density.unwrap().is_sign_positive());
    }

    /// Three rows of people in a corridor 2 m wide, 0.5 m apart; the outer two lean over its walls by 5 cm and a hand. Within
    /// the walls a column of 0.5 m · 2 m belongs to three people, so the density is 3 /m², as N / A of all would be.
    #[test]
    fn heads_over_the_walls_count_at_the_walls() {
        let places: Vec<(f64, f64)> =
            (0..20).flat_map(|k| [-0.05, 1.0, 2.2].map(|y| (0.25 + 0.5 * f64::from(k), y))).collect();
        let heads: Vec<Vec2> = places.iter().map(|(x, y)| vec2(*x, *y)).collect();
        let line = |y: f64| Wall::new(y.to_string(), "stone", vec![vec2(0.0, y), vec2(10.0, y)]);
        let all_around: Vec<Vec2> = square(0.0, 10.0).corners().to_vec();
        let closed = all_around.iter().map(|p| vec2(p.x, 0.2 * p.y)).chain([vec2(0.0, 0.0)]).collect();
        let area = MeasuringArea::of_numbers(&[2.0, -0.5, 8.0, 2.5]).unwrap();
        let within = MeasuringArea::of_numbers(&[2.0, 0.0, 8.0, 2.0]).unwrap();
        for walls in [vec![line(0.0), line(2.0)], vec![Wall::new("all", "stone", closed)]] {
            let measured = measured_area(&walls, &heads).unwrap();
            assert!((measured.polygon.outer.area() - 20.0).abs() < 1e-9, "{:?}", measured.messages);
            let room = VoronoiRoom::of(&measured.polygon);
            let seen = within.measure(&frame(&places), Some(&room));
            assert!((seen.voronoi_density.unwrap() - 3.0).abs() < 1e-6, "{seen:?}");
            // All of them are in an area that is wider than the corridor, two thirds of it being in it.
            let seen = area.measure(&frame(&places), Some(&room));
            assert!(
                (seen.voronoi_density.unwrap() - seen.density).abs() < 1e-6 && seen.density == 2.0,
                "{seen:?}"
            );
            // Who is far from the walls is beyond them: they hold nobody back.
            let far: Vec<Vec2> = heads.iter().copied().chain([vec2(5.0, 4.0)]).collect();
            let other = measured_area(&walls, &far);
            assert!(other.is_none() || walls.len() == 2, "{other:?}");
        }
        // Without walls it is the box of all.
        let boxed = measured_area(&[], &heads).unwrap();
        assert!((boxed.polygon.outer.area() - 10.5 * 3.25).abs() < 1e-9);
    }

    #[test]
    fn who_has_left_counts_no_more() {
        let room = VoronoiRoom::of(&Polygon { outer: square(0.0, 5.0), holes: Vec::new() });
        let area = MeasuringArea::inside(square(0.0, 5.0)).unwrap();
        let seen = area.measure(&frame(&[(1.0, 1.0), (f64::NAN, f64::NAN)]), Some(&room));
        assert!(
            (seen.people, seen.density) == (1, 0.04) && (seen.voronoi_density.unwrap() - 0.04).abs() < 1e-9,
            "{seen:?}"
        );
        // Two at one place are two.
        let seen = area.measure(&frame(&[(1.0, 1.0), (1.0, 1.0)]), Some(&room));
        assert!((seen.voronoi_density.unwrap() - 0.08).abs() < 1e-9, "{seen:?}");
    }

    #[test]
    fn an_area_is_no_line_and_no_bow() {
        let ring = |corners: &[(f64, f64)]| {
            Ring::through(corners.iter().map(|&(x, y)| vec2(x, y)).collect()).unwrap()
        };
        assert_eq!(MeasuringArea::inside(ring(&[(0.0, 0.0), (1.0, 1.0), (2.0, 2.0)])), None);
        assert_eq!(MeasuringArea::inside(ring(&[(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)])), None);
    }
}
