//! The paper's packing algorithm (appendix D).

use super::measure::{Overlaps, density, overlap, through_boundary};
use super::neighbours::CellGrid;
use super::{
    Ended, Packing, PlacingProgress, PlacingSettings, Region, Stage, TOLERANCE, Watch, reach, wrapped,
};
use crate::random::Random;
use crate::shape::Shape;
use lemons_core::plane::{Disk, Pose, Vec2, rotation, vec2};
use std::f64::consts::PI;

/// \[m\] λ: distance over which the repulsion of two agents falls to 1/e. The paper names this setting and the next ones
/// but does not give their values.
const REPULSION_LENGTH: f64 = 0.05;
/// \[m\] Displacement in one iteration by which two agents at the same place would repel each other. The paper's formula
/// has the number 1 in its unit of length: 1 cm.
const REPULSION_INTENSITY: f64 = 0.01;
/// \[m\] k: displacement in one iteration of each agent that overlaps another.
const CONTACT_INTENSITY: f64 = 0.01;
/// \[rad\] α: an agent that overlaps another turns by at most ± this × the temperature.
const ROTATIONAL_INTENSITY: f64 = PI / 18.0;
/// The temperature begins at 1. In each iteration it falls by this, down to 0.
const COOLING: f64 = 0.1;

/// Largest number of iterations.
const ITERATIONS: u64 = 1000;
/// Repulsions below this fraction of their intensity are left out.
const NEGLIGIBLE: f64 = 1e-6;
/// \[1/m²\] In the open plane the agents begin at random places in a square of this density, and spread from there.
const BEGIN_DENSITY: f64 = 8.0;

/// Places shapes by the paper's algorithm (appendix D): one shape after the other moves by the sum of its forces. With
/// [`Orientation::Fixed`](super::Orientation::Fixed) they do not turn (`variable_orientation` in the paper).
///
/// The paper does not say how to begin and when to stop. Here agents begin at random places, evenly distributed, and
/// the algorithm stops when nothing overlaps. Overlaps may remain; the result then says that it is not complete.
/// [`dense()`](super::dense()) reaches higher densities.
pub fn paper(shapes: &[Shape], region: &Region, settings: &PlacingSettings, watch: &mut Watch) -> Packing {
    let limit = settings.limit.unwrap_or(ITERATIONS);
    let mut crowd = Crowd::new(shapes, region, settings);
    let mut temperature = 1.0;
    let (mut iterations, mut ended) = (0, Ended::Exhausted);
    // The hull of a crowd in the open plane takes a while: the density is not updated at every report.
    let mut reported = density(region, &crowd.disks);
    for iteration in 0..limit {
        let overlap = Overlaps::of(shapes, region, &crowd.poses, &crowd.disks).largest();
        if overlap <= TOLERANCE {
            ended = Ended::Done;
            break;
        }
        if region.is_plane() && iteration % 50 == 49 {
            reported = density(region, &crowd.disks);
        }
        let stage = Stage::Spreading;
        if watch(&PlacingProgress { stage, iteration, limit, overlap, density: reported }).is_break() {
            ended = Ended::Cancelled;
            break;
        }
        for agent in 0..shapes.len() {
            crowd.step(agent, temperature);
        }
        temperature = f64::max(0.0, temperature - COOLING);
        iterations += 1;
    }
    let packing = Packing::of(shapes, region, crowd.poses, ended, iterations);
    // Perhaps the last iteration removed the last overlap.
    let done = packing.complete && ended == Ended::Exhausted;
    Packing { ended: if done { Ended::Done } else { ended }, ..packing }
}

struct Crowd<'a> {
    shapes: &'a [Shape],
    region: &'a Region,
    settings: &'a PlacingSettings,
    random: Random,
    poses: Vec<Pose>,
    disks: Vec<Vec<Disk>>,
    reaches: Vec<f64>,
    cells: CellGrid,
    /// \[m\] Repulsion is negligible beyond this distance.
    cutoff: f64,
}

impl<'a> Crowd<'a> {
    fn new(shapes: &'a [Shape], region: &'a Region, settings: &'a PlacingSettings) -> Crowd<'a> {
        let mut random = Random::new(settings.seed);
        let half = 0.5 * (shapes.len() as f64 / BEGIN_DENSITY).sqrt();
        let mut poses = Vec::with_capacity(shapes.len());
        for _ in shapes {
            let position =
                if region.is_plane() { random.vector(half) } else { region.random_point(&mut random) };
            let orientation = settings.orientation.start().map_or_else(|| random.within(PI), wrapped);
            poses.push(Pose { position, orientation });
        }
        let reaches: Vec<f64> = shapes.iter().map(reach).collect();
        let widest = 2.0 * reaches.iter().copied().fold(0.0, f64::max);
        let cutoff = -REPULSION_LENGTH * libm::log(NEGLIGIBLE);
        let places: Vec<Vec2> = poses.iter().map(|pose| pose.position).collect();
        let cells = CellGrid::new(&places, cutoff.max(widest));
        let disks = shapes.iter().zip(&poses).map(|(s, p)| s.placed(p).collect()).collect();
        Crowd { shapes, region, settings, random, poses, disks, reaches, cells, cutoff }
    }

    fn overlap(&self, a: usize, b: usize) -> f64 {
        let reach = self.reaches[a] + self.reaches[b];
        if (self.poses[a].position - self.poses[b].position).norm_squared() >= reach * reach {
            return 0.0;
        }
        overlap(&self.disks[a], &self.disks[b]).max(0.0)
    }

    /// The agents near an agent, in their order.
    fn near(&self, agent: usize) -> Vec<usize> {
        let mut near = Vec::new();
        self.cells.for_each_near(self.poses[agent].position, |other| near.push(other));
        near.retain(|&other| other != agent);
        near.sort_unstable();
        near
    }

    /// The body of the paper's inner loop.
    fn step(&mut self, i: usize, temperature: f64) {
        let settings = self.settings;
        let (mut force, mut turn) = (Vec2::zeros(), 0.0);
        for j in self.near(i) {
            let apart = self.poses[i].position - self.poses[j].position;
            let distance = apart.norm();
            if distance < self.cutoff {
                let strength = REPULSION_INTENSITY * libm::exp(-distance / REPULSION_LENGTH);
                force += self.along(apart, strength);
            }
            if self.overlap(i, j) > 0.0 {
                force += self.along(apart, CONTACT_INTENSITY);
                turn += self.random.within(ROTATIONAL_INTENSITY) * temperature;
            }
        }
        if through_boundary(self.region, &self.disks[i]) > 0.0 {
            let position = self.poses[i].position;
            let nearest = self.region.edges().iter().map(|e| e.nearest(position)).min_by(|a, b| {
                let square = |p: &Vec2| (*p - position).norm_squared();
                square(a).total_cmp(&square(b))
            });
            if let Some(nearest) = nearest {
                force += self.along(position - nearest, CONTACT_INTENSITY);
                turn += self.random.within(ROTATIONAL_INTENSITY) * temperature;
            }
        }
        if settings.orientation.turns() {
            self.poses[i].orientation = wrapped(self.poses[i].orientation + turn);
        }
        let wanted = self.poses[i].position + force;
        // The paper's `valid_position`: the centroid stays inside, and here on its side of a wall.
        if self.region.contains(wanted) && !self.region.parted(self.poses[i].position, wanted) {
            self.cells.shift(i, self.poses[i].position, wanted);
            self.poses[i].position = wanted;
        }
        self.disks[i].clear();
        self.disks[i].extend(self.shapes[i].placed(&self.poses[i]));
    }

    /// A vector of this length in the direction of `way`; a small random one if `way` has no direction.
    fn along(&mut self, way: Vec2, strength: f64) -> Vec2 {
        let distance = way.norm();
        if distance > 0.0 {
            way * (strength / distance)
        } else {
            rotation(self.random.within(PI)) * vec2(strength, 0.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::placing::Orientation;

    fn disks(count: usize) -> Vec<Shape> {
        vec![Shape { disks: vec![Disk { radius: 0.2, centre: Vec2::zeros() }] }; count]
    }

    /// The forces of appendix D on an agent that overlaps one, repels another and stands in contact with a wall.
    #[test]
    fn forces_are_those_of_the_paper() {
        let region = Region::rectangle(vec2(0.0, 0.0), vec2(5.0, 5.0)).unwrap();
        let shapes = disks(3);
        let settings = PlacingSettings { orientation: Orientation::Fixed(0.0), ..PlacingSettings::default() };
        let mut crowd = Crowd::new(&shapes, &region, &settings);
        for (k, (x, y)) in [(0.15, 2.0), (0.45, 2.0), (0.15, 2.5)].into_iter().enumerate() {
            crowd.cells.shift(k, crowd.poses[k].position, vec2(x, y));
            crowd.poses[k].position = vec2(x, y);
            crowd.disks[k] = shapes[k].placed(&crowd.poses[k]).collect();
        }
        crowd.step(0, 1.0);
        let moved = crowd.poses[0].position - vec2(0.15, 2.0);
        // Repulsion of both, contact with the neighbour at 0.3 m, and with the wall to the left.
        let (x, y) = (-0.01 * (-6.0f64).exp() - 0.01 + 0.01, -0.01 * (-10.0f64).exp());
        assert!((moved - vec2(x, y)).norm() < 1e-15, "{moved:?}");
        assert_eq!(crowd.poses[0].orientation, 0.0);
    }

    /// A step out of the region is not made; agents turn only while it is warm.
    #[test]
    fn stays_inside_and_cools() {
        let region = Region::rectangle(vec2(0.0, 0.0), vec2(1.0, 1.0)).unwrap();
        let shapes = disks(30);
        let settings =
            PlacingSettings { orientation: Orientation::Towards(0.0), ..PlacingSettings::default() };
        let after = |iterations: u64| {
            let settings = PlacingSettings { limit: Some(iterations), ..settings };
            paper(&shapes, &region, &settings, &mut |_| std::ops::ControlFlow::Continue(()))
        };
        let packing = after(40);
        assert_eq!((packing.ended, packing.iterations, packing.complete), (Ended::Exhausted, 40, false));
        assert!(packing.poses.iter().all(|p| region.contains(p.position)));
        let turned =
            |iterations: u64| -> Vec<f64> { after(iterations).poses.iter().map(|p| p.orientation).collect() };
        // At 0.1 a step the temperature is 0 after ten (and a rounding): nobody turns then.
        assert_eq!(turned(12), turned(30));
        assert_ne!(turned(5), turned(8));
        assert!(turned(12).iter().any(|a| *a != 0.0));
    }
}
