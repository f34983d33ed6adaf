//! The paper's packing algorithm (appendix D).

use super::measure::{overlap, through_boundary};
use super::random::Random;
use super::{
    Ended, Orientation, Packing, PlacingError, Progress, Region, Stage, TOLERANCE, Watch, check,
    check_orientation, check_shapes, disks_at, measure, reach,
};
use crate::shape::Shape;
use lemons_core::plane::{Disk, Pose, Rotation, Vec2, vec2};
use std::f64::consts::PI;

/// Settings of [`paper()`]. The paper names them but does not give their values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Paper {
    /// \[m\] λ: distance over which the repulsion of two agents falls to 1/e.
    pub repulsion_length: f64,
    /// \[m\] Displacement in one iteration by which two agents at the same place would repel each other. The paper's
    /// formula has the number 1 in its unit of length: 1 cm.
    pub repulsion_intensity: f64,
    /// \[m\] k: displacement in one iteration of each agent that overlaps another.
    pub contact_intensity: f64,
    /// \[rad\] α: an agent that overlaps another turns by at most ± this × the temperature.
    pub rotational_intensity: f64,
    /// The temperature begins at 1. In each iteration it falls by this, down to 0.
    pub cooling: f64,
    /// Largest number of iterations.
    pub max_iterations: u64,
    /// With `Free` and `Towards` agents turn (`variable_orientation` in the paper); with `Free` they begin in random
    /// directions.
    pub orientation: Orientation,
    /// The same seed gives the same placing.
    pub seed: u64,
}

impl Default for Paper {
    fn default() -> Paper {
        Paper {
            repulsion_length: 0.05,
            repulsion_intensity: 0.01,
            contact_intensity: 0.01,
            rotational_intensity: PI / 18.0,
            cooling: 0.1,
            max_iterations: 1000,
            orientation: Orientation::Towards(0.0),
            seed: 0,
        }
    }
}

/// Repulsions below this fraction of their intensity are left out.
const NEGLIGIBLE: f64 = 1e-6;
/// \[1/m²\] In the open plane the agents begin at random places in a square of this density, and spread from there.
const BEGIN_DENSITY: f64 = 8.0;

/// Places shapes by the paper's algorithm (appendix D): one shape after the other moves by the sum of its forces.
///
/// The paper does not say how to begin and when to stop. Here agents begin at random places, evenly distributed, and
/// the algorithm stops when nothing overlaps. Overlaps may remain; the result then says that it is not complete.
/// [`dense()`](super::dense()) reaches higher densities.
pub fn paper(
    shapes: &[Shape],
    region: &Region,
    settings: &Paper,
    watch: &mut Watch,
) -> Result<Packing, PlacingError> {
    check_shapes(shapes)?;
    check_orientation(settings.orientation)?;
    let positive = "positive";
    check("the repulsion length", settings.repulsion_length, settings.repulsion_length > 0.0, positive)?;
    for (name, value) in [
        ("the repulsion intensity", settings.repulsion_intensity),
        ("the contact intensity", settings.contact_intensity),
        ("the rotational intensity", settings.rotational_intensity),
        ("the cooling", settings.cooling),
    ] {
        check(name, value, value >= 0.0, "0 or positive")?;
    }
    let mut crowd = Crowd::new(shapes, region, settings);
    let mut temperature = 1.0;
    let (mut iterations, mut ended) = (0, Ended::Exhausted);
    let density = |poses: &[Pose]| measure(shapes, region, poses).density;
    // The hull of a crowd in the open plane takes a while: the density is not updated at every report.
    let mut reported = if shapes.is_empty() { 0.0 } else { density(&crowd.poses) };
    for iteration in 0..settings.max_iterations {
        let overlap = crowd.largest_overlap();
        if overlap <= TOLERANCE {
            ended = Ended::Done;
            break;
        }
        if region.is_plane() && iteration % 50 == 49 {
            reported = density(&crowd.poses);
        }
        let (stage, limit) = (Stage::Spreading, settings.max_iterations);
        if watch(&Progress { stage, iteration, limit, overlap, density: reported }).is_break() {
            ended = Ended::Cancelled;
            break;
        }
        for agent in 0..shapes.len() {
            crowd.step(agent, temperature);
        }
        temperature = f64::max(0.0, temperature - settings.cooling);
        iterations += 1;
    }
    let poses = crowd.poses;
    let measured = measure(shapes, region, &poses);
    let packing = Packing::of(poses, &measured, ended, iterations);
    // Perhaps the last iteration removed the last overlap.
    let done = packing.complete && ended == Ended::Exhausted;
    Ok(Packing { ended: if done { Ended::Done } else { ended }, ..packing })
}

struct Crowd<'a> {
    shapes: &'a [Shape],
    region: &'a Region,
    settings: &'a Paper,
    random: Random,
    poses: Vec<Pose>,
    disks: Vec<Vec<Disk>>,
    reaches: Vec<f64>,
    cells: Cells,
    /// \[m\] Repulsion is negligible beyond this distance.
    cutoff: f64,
    /// Scratch space: the agents near one agent.
    near: Vec<u32>,
}

impl<'a> Crowd<'a> {
    fn new(shapes: &'a [Shape], region: &'a Region, settings: &'a Paper) -> Crowd<'a> {
        let mut random = Random::new(settings.seed);
        let half = 0.5 * (shapes.len() as f64 / BEGIN_DENSITY).sqrt();
        let mut poses = Vec::with_capacity(shapes.len());
        for _ in shapes {
            let position =
                if region.is_plane() { random.vector(half) } else { region.random_point(&mut random) };
            let orientation = match settings.orientation {
                Orientation::Free => random.within(PI),
                Orientation::Fixed(angle) | Orientation::Towards(angle) => super::wrapped(angle),
            };
            poses.push(Pose { position, orientation });
        }
        let reaches: Vec<f64> = shapes.iter().map(reach).collect();
        let widest = 2.0 * reaches.iter().copied().fold(0.0, f64::max);
        let cutoff = -settings.repulsion_length * libm::log(NEGLIGIBLE);
        let mut cells = Cells::new(cutoff.max(widest), shapes.len());
        for (k, pose) in poses.iter().enumerate() {
            cells.add(k, pose.position);
        }
        let disks = shapes.iter().zip(&poses).map(|(s, p)| disks_at(s, *p).collect()).collect();
        Crowd { shapes, region, settings, random, poses, disks, reaches, cells, cutoff, near: Vec::new() }
    }

    fn overlap(&self, a: usize, b: usize) -> f64 {
        let reach = self.reaches[a] + self.reaches[b];
        if (self.poses[a].position - self.poses[b].position).norm_squared() >= reach * reach {
            return 0.0;
        }
        overlap(&self.disks[a], &self.disks[b]).max(0.0)
    }

    fn largest_overlap(&mut self) -> f64 {
        let mut largest = 0.0f64;
        for a in 0..self.poses.len() {
            largest = largest.max(through_boundary(self.region, &self.disks[a]));
            let mut near = std::mem::take(&mut self.near);
            self.cells.near(self.poses[a].position, &mut near);
            for &b in near.iter().filter(|&&b| b as usize > a) {
                largest = largest.max(self.overlap(a, b as usize));
            }
            self.near = near;
        }
        largest
    }

    /// The body of the paper's inner loop.
    fn step(&mut self, i: usize, temperature: f64) {
        let settings = self.settings;
        let (mut force, mut turn) = (Vec2::ZERO, 0.0);
        let mut near = std::mem::take(&mut self.near);
        self.cells.near(self.poses[i].position, &mut near);
        for &j in near.iter().filter(|&&j| j as usize != i) {
            let apart = self.poses[i].position - self.poses[j as usize].position;
            let distance = apart.norm();
            if distance < self.cutoff {
                let strength =
                    settings.repulsion_intensity * libm::exp(-distance / settings.repulsion_length);
                force += self.along(apart, strength);
            }
            if self.overlap(i, j as usize) > 0.0 {
                force += self.along(apart, settings.contact_intensity);
                turn += self.random.within(settings.rotational_intensity) * temperature;
            }
        }
        self.near = near;
        if through_boundary(self.region, &self.disks[i]) > 0.0 {
            let position = self.poses[i].position;
            let nearest = self.region.edges().iter().map(|e| e.nearest(position)).min_by(|a, b| {
                let square = |p: &Vec2| (*p - position).norm_squared();
                square(a).total_cmp(&square(b))
            });
            if let Some(nearest) = nearest {
                force += self.along(position - nearest, settings.contact_intensity);
                turn += self.random.within(settings.rotational_intensity) * temperature;
            }
        }
        if !matches!(settings.orientation, Orientation::Fixed(_)) {
            self.poses[i].orientation = super::wrapped(self.poses[i].orientation + turn);
        }
        let wanted = self.poses[i].position + force;
        // The paper's `valid_position`: the centroid stays inside, and here on its side of a wall.
        if self.region.contains(wanted) && !self.region.parted(self.poses[i].position, wanted) {
            self.cells.remove(i, self.poses[i].position);
            self.cells.add(i, wanted);
            self.poses[i].position = wanted;
        }
        self.disks[i].clear();
        self.disks[i].extend(disks_at(&self.shapes[i], self.poses[i]));
    }

    /// A vector of this length in the direction of `way`; a small random one if `way` has no direction.
    fn along(&mut self, way: Vec2, strength: f64) -> Vec2 {
        let distance = way.norm();
        if distance > 0.0 {
            way * (strength / distance)
        } else {
            vec2(strength, 0.0).rotated(Rotation::by(self.random.within(PI)))
        }
    }
}

/// Agents by cells of the plane. Cells share a table of lists, so agents may move one by one and any distance.
struct Cells {
    cells_per_length: f64,
    mask: u64,
    lists: Vec<Vec<u32>>,
}

impl Cells {
    fn new(cell: f64, count: usize) -> Cells {
        let places = (2 * count).next_power_of_two().max(64);
        Cells { cells_per_length: 1.0 / cell, mask: places as u64 - 1, lists: vec![Vec::new(); places] }
    }

    fn cell(&self, point: Vec2) -> (i64, i64) {
        let cell = |x: f64| libm::floor(x * self.cells_per_length) as i64;
        (cell(point.x), cell(point.y))
    }

    fn place(&self, column: i64, row: i64) -> usize {
        let mixed = (column as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15)
            ^ (row as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F);
        ((mixed ^ mixed >> 32) & self.mask) as usize
    }

    fn add(&mut self, who: usize, point: Vec2) {
        let (column, row) = self.cell(point);
        let place = self.place(column, row);
        self.lists[place].push(who as u32);
    }

    fn remove(&mut self, who: usize, point: Vec2) {
        let (column, row) = self.cell(point);
        let place = self.place(column, row);
        self.lists[place].retain(|&k| k != who as u32);
    }

    /// All agents in the cell of a point and in the cells around it, perhaps with some others; each once, ascending.
    fn near(&self, point: Vec2, found: &mut Vec<u32>) {
        found.clear();
        let (column, row) = self.cell(point);
        for r in -1..=1 {
            for c in -1..=1 {
                found.extend(&self.lists[self.place(column.wrapping_add(c), row.wrapping_add(r))]);
            }
        }
        found.sort_unstable();
        // Several cells may share a list.
        found.dedup();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn disks(count: usize) -> Vec<Shape> {
        vec![Shape { disks: vec![Disk { radius: 0.2, centre: Vec2::ZERO }] }; count]
    }

    /// The forces of appendix D on an agent that overlaps one, repels another and stands in contact with a wall.
    #[test]
    fn forces_are_those_of_the_paper() {
        let region = Region::rectangle(vec2(0.0, 0.0), vec2(5.0, 5.0)).unwrap();
        let shapes = disks(3);
        let settings =
            Paper { repulsion_length: 0.3, orientation: Orientation::Fixed(0.0), ..Paper::default() };
        let mut crowd = Crowd::new(&shapes, &region, &settings);
        for (k, (x, y)) in [(0.15, 2.0), (0.45, 2.0), (0.15, 2.5)].into_iter().enumerate() {
            crowd.cells.remove(k, crowd.poses[k].position);
            crowd.cells.add(k, vec2(x, y));
            crowd.poses[k].position = vec2(x, y);
            crowd.disks[k] = disks_at(&shapes[k], crowd.poses[k]).collect();
        }
        crowd.step(0, 1.0);
        let moved = crowd.poses[0].position - vec2(0.15, 2.0);
        // Repulsion of both, contact with the neighbour at 0.3 m, and with the wall to the left.
        let (x, y) = (-0.01 * (-1.0f64).exp() - 0.01 + 0.01, -0.01 * (-0.5f64 / 0.3).exp());
        assert!((moved - vec2(x, y)).norm() < 1e-15, "{moved:?}");
        assert_eq!(crowd.poses[0].orientation, 0.0);
    }

    /// A step out of the region is not made; agents turn only while it is warm.
    #[test]
    fn stays_inside_and_cools() {
        let region = Region::rectangle(vec2(0.0, 0.0), vec2(1.0, 1.0)).unwrap();
        let shapes = disks(30);
        let settings = Paper { contact_intensity: 0.05, max_iterations: 40, ..Paper::default() };
        let mut seen = Vec::new();
        let packing = paper(&shapes, &region, &settings, &mut |p| {
            seen.push(p.iteration);
            std::ops::ControlFlow::Continue(())
        })
        .unwrap();
        assert_eq!(seen, (0..40).collect::<Vec<_>>());
        assert_eq!((packing.ended, packing.iterations, packing.complete), (Ended::Exhausted, 40, false));
        assert!(packing.poses.iter().all(|p| region.contains(p.position)));
        let turned = |iterations: u64, cooling: f64| -> Vec<f64> {
            let settings = Paper { max_iterations: iterations, cooling, ..settings };
            let packing =
                paper(&shapes, &region, &settings, &mut |_| std::ops::ControlFlow::Continue(())).unwrap();
            packing.poses.iter().map(|p| p.orientation).collect()
        };
        // At 0.1 a step the temperature is 0 after ten (and a rounding): nobody turns then.
        assert_eq!(turned(12, 0.1), turned(30, 0.1));
        assert_ne!(turned(12, 0.0), turned(30, 0.0));
        assert!(turned(12, 0.1).iter().any(|a| *a != 0.0));
    }
}
