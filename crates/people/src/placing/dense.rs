//! Our own packing algorithm. Soft shapes grow to their full size and move downhill in energy until nothing overlaps.
//! Where they are stuck, some are moved elsewhere.

use super::fire::Fire;
use super::hull::hull_area;
use super::soft_disks::{Boundary, SoftBody, SoftDisks};
use super::{
    Ended, Orientation, Packing, PlacingProgress, PlacingSettings, Region, Stage, TOLERANCE, Watch, reach,
};
use crate::error::{COVER_MORE, Result, require};
use crate::random::Random;
use crate::shape::Shape;
use lemons_core::message::message;
use std::f64::consts::PI;

/// \[m\] Distance that shapes keep while they are pushed apart. So none overlaps in the end, although the energy
/// approaches zero only slowly.
const PAD: f64 = TOLERANCE;
/// Relative sizes through which the shapes grow.
const SIZES: [f64; 5] = [0.6, 0.75, 0.87, 0.95, 1.0];
/// Steps at each size except the last.
const GROWING_STEPS: u64 = 200;
/// Largest number of steps of a slide.
const SLIDE_STEPS: u64 = 3000;
/// A slide is at rest at this imbalance: forces cancel to a thousandth.
const AT_REST: f64 = 1e-6;
/// Rounds of shaking without a gain before the shapes count as stuck.
const PATIENCE: u32 = 80;
/// A gain is at least this fraction of the energy.
const GAIN: f64 = 1e-3;
/// Steps between two progress reports.
const REPORT: u64 = 25;
/// Covered fraction of the circle in which a crowd in the open plane begins: the shapes hardly press on each other.
const LOOSE_COVER: f64 = 0.5;
/// Attempts to begin with at most the wanted density.
const LOOSER: u32 = 24;
/// Number of places tried for a shape that is moved elsewhere.
const TRIALS: u32 = 400;
/// \[rad\] Largest turn of a shape that is moved elsewhere, if shapes face one direction at the beginning.
const ASKEW: f64 = PI / 6.0;
/// Number of stuck shapes per centre of a round of shaking.
const STUCK_TO_A_PLACE: usize = 60;
/// Shaking is useless if the shapes overlap on average by more than this fraction of their size.
const HOPELESS: f64 = 0.05;
/// ... unless fewer than this fraction of them does so, in a region with places that are too narrow for them.
const A_FEW: f64 = 0.1;
/// Fraction of the shapes that is removed in a round (first), and number of rounds (second), if not all shapes fit.
const TAKEN_AWAY: f64 = 0.01;
const TAKING_ROUNDS: u32 = 150;
/// Steps of a slide after some shapes were removed.
const TAKING_STEPS: u64 = 500;

/// Largest number of iterations.
const ITERATIONS: u64 = 200_000;

/// Places shapes densely without overlap.
///
/// The shapes are soft: E = Σ ½ h² over all overlaps h of disks with each other and with the boundary. They start
/// evenly spread at a fraction of their size, grow, and slide (FIRE) to where E vanishes. Where that fails, some are
/// shaken, swapped or moved to the widest gap; changes that make E smaller are kept. In the open plane a circle presses
/// them together.
///
/// `watch` gets the progress and may stop the algorithm. The result may be incomplete (`complete` is false) if the
/// density is too high, or too high for that many iterations. Its `clear_density` is then the density of the shapes
/// that could spread without overlap after others were removed.
pub fn dense(
    shapes: &[Shape],
    region: &Region,
    settings: &PlacingSettings,
    watch: &mut Watch,
) -> Result<Packing> {
    let wanted = settings.density.filter(|_| region.is_plane());
    let covered: f64 = shapes.iter().map(|shape| shape.moments().area).sum();
    let room = wanted.map_or(region.area(), |density| shapes.len() as f64 / density);
    require(covered <= room, || message!(COVER_MORE, shapes = shapes.len(), covered, room))?;
    let random = Random::new(settings.seed);
    let (iteration, limit) = (0, settings.limit.unwrap_or(ITERATIONS));
    let (orientation, stage, density) = (settings.orientation, Stage::Growing, 0.0);
    let mut packer = Packer { random, watch, orientation, iteration, limit, stage, density };
    let (bodies, ended) = if shapes.is_empty() {
        (Vec::new(), Ended::Done)
    } else if region.is_plane() {
        packer.in_the_open(shapes, wanted, covered)
    } else {
        packer.density = shapes.len() as f64 / region.area();
        packer.in_region(shapes, region)
    };
    let mut packing = Packing::of(shapes, region, bodies.iter().map(SoftBody::pose).collect(), ended, 0);
    if !region.is_plane() && !packing.complete && packing.ended != Ended::Cancelled {
        match packer.without_some(shapes, &bodies, region) {
            Ok(density) => packing.clear_density = packing.clear_density.max(density),
            Err(cancelled) => packing.ended = cancelled,
        }
    }
    packing.iterations = packer.iteration;
    packing.complete &= wanted.is_none_or(|density| packing.density >= density);
    Ok(packing)
}

/// Returns whether the whole algorithm ends, not only a slide.
fn is_over(ended: Ended) -> bool {
    matches!(ended, Ended::Exhausted | Ended::Cancelled)
}

struct Packer<'w, 'c> {
    random: Random,
    watch: &'w mut Watch<'c>,
    orientation: Orientation,
    iteration: u64,
    limit: u64,
    stage: Stage,
    /// \[1/m²\] The reported density.
    density: f64,
}

impl Packer<'_, '_> {
    fn in_region(&mut self, shapes: &[Shape], region: &Region) -> (Vec<SoftBody>, Ended) {
        let mut disks = SoftDisks::new(shapes, Boundary::Region(region), self.orientation, PAD);
        self.strew(&mut disks);
        self.take_off_walls(&mut disks, region);
        let mut slide = self.grow(&mut disks);
        if slide == Ended::Stuck {
            slide = self.shake(&mut disks);
        }
        (disks.bodies, slide)
    }

    /// Compresses the crowd until the wanted density is reached. Returns the densest placing without overlap.
    fn in_the_open(&mut self, shapes: &[Shape], least: Option<f64>, covered: f64) -> (Vec<SoftBody>, Ended) {
        let wanted = least.unwrap_or(f64::INFINITY);
        let widest = shapes.iter().map(reach).fold(0.0, f64::max);
        let mut radius =
            (covered / (LOOSE_COVER * PI)).sqrt().max((shapes.len() as f64 / (wanted * PI)).sqrt());
        let mut disks = SoftDisks::new(shapes, Boundary::Circle(radius), self.orientation, PAD);
        let mut slide = Ended::Stuck;
        for _ in 0..LOOSER {
            disks.boundary = Boundary::Circle(radius.max(widest + PAD));
            self.strew(&mut disks);
            slide = self.grow(&mut disks);
            // The hull is smaller than the circle, so even a loose crowd may be too dense.
            let dense = shapes.len() as f64 / hull_area(&disks.circles()) / wanted;
            match slide {
                // The hull of a single shape is the shape itself, however large the circle is.
                Ended::Done if dense > 1.0 && shapes.len() > 1 => radius *= dense.sqrt() * 1.01,
                // Long shapes need more room than their area.
                Ended::Stuck => radius *= 1.3,
                _ => break,
            }
        }
        let mut best: Option<Vec<SoftBody>> = None;
        // The circle shrinks in smaller and smaller steps.
        let mut press = 0.04;
        loop {
            if slide == Ended::Stuck && (best.is_none() || press < 0.003) {
                slide = self.shake(&mut disks);
            }
            let Boundary::Circle(radius) = disks.boundary else { break };
            match slide {
                Ended::Done => {
                    let density = shapes.len() as f64 / hull_area(&disks.circles());
                    self.density = density;
                    best = Some(disks.bodies.clone());
                    if density >= wanted || shapes.len() == 1 {
                        return (disks.bodies, Ended::Done);
                    }
                    let needed = 1.0 - (density / wanted).sqrt() + 1e-5;
                    press = f64::min(press, needed);
                    disks.boundary = Boundary::Circle(radius * (1.0 - press));
                    disks.draw_in(1.0 - press);
                }
                // Go back, and then shrink by less.
                Ended::Stuck if press >= 0.003 && best.is_some() => {
                    disks.bodies = best.clone().unwrap_or_default();
                    let before = radius / (1.0 - press);
                    press *= 0.5;
                    disks.boundary = Boundary::Circle(before * (1.0 - press));
                    disks.draw_in(1.0 - press);
                }
                // Even shaking did not help: stop here.
                Ended::Stuck => {
                    let found = best.is_some();
                    let ended = if found && least.is_none() { Ended::Done } else { Ended::Stuck };
                    return (best.unwrap_or(disks.bodies), ended);
                }
                ended => return (best.unwrap_or(disks.bodies), ended),
            }
            self.stage = Stage::Pressing;
            slide = self.slide(&mut disks, SLIDE_STEPS);
        }
        (disks.bodies, Ended::Stuck)
    }

    /// Spreads the shapes in random order over evenly spread points, each with a small random offset.
    fn strew(&mut self, disks: &mut SoftDisks) {
        // The R2 sequence (Roberts 2018) with a random start: 1/p, 1/p² with p³ = p + 1.
        const STEPS: (f64, f64) = (0.754_877_666_246_692_7, 0.569_840_290_998_053_2);
        let count = disks.bodies.len();
        let (begin_u, begin_v) = (self.random.unit(), self.random.unit());
        let off = 0.4 / (count as f64).sqrt();
        for (k, who) in self.random.order(count).into_iter().enumerate() {
            let u = begin_u + STEPS.0 * k as f64 + self.random.within(off);
            let v = begin_v + STEPS.1 * k as f64 + self.random.within(off);
            disks.bodies[who].position = disks.boundary.point_at(u - libm::floor(u), v - libm::floor(v));
            disks.bodies[who].angle = self.orientation.start().unwrap_or_else(|| self.random.within(PI));
        }
    }

    /// Moves the shapes that stand across a wall to other places: they would hold on to both of its sides.
    fn take_off_walls(&mut self, disks: &mut SoftDisks, region: &Region) {
        for who in 0..disks.bodies.len() {
            for _ in 0..TRIALS {
                if !disks.is_across(who, region) {
                    break;
                }
                disks.bodies[who].position = disks.boundary.random_point(&mut self.random);
                if self.orientation == Orientation::Free {
                    disks.bodies[who].angle = self.random.within(PI);
                }
            }
        }
    }

    fn grow(&mut self, disks: &mut SoftDisks) -> Ended {
        self.stage = Stage::Growing;
        for size in SIZES {
            disks.scale = size;
            let steps = if size < 1.0 { GROWING_STEPS } else { SLIDE_STEPS };
            if size == 1.0 {
                self.stage = Stage::Spreading;
            }
            let slide = self.slide(disks, steps);
            if size == 1.0 || is_over(slide) {
                return slide;
            }
        }
        Ended::Stuck
    }

    /// Moves downhill for some steps: `Done` if nothing overlaps in the end, `Stuck` if overlaps remain.
    fn slide(&mut self, disks: &mut SoftDisks, steps: u64) -> Ended {
        let mut fire = Fire::new(disks);
        for step in 0..=steps {
            let overlap = fire.pressure().overlap;
            // A tenth of the pad is left for what remains after a slide.
            if overlap <= 0.9 * PAD {
                return Ended::Done;
            }
            if step == steps || fire.imbalance() < AT_REST {
                break;
            }
            if self.iteration >= self.limit {
                return Ended::Exhausted;
            }
            if self.iteration.is_multiple_of(REPORT) {
                let progress = PlacingProgress {
                    stage: self.stage,
                    iteration: self.iteration,
                    limit: self.limit,
                    overlap: (overlap - PAD).max(0.0),
                    density: self.density * disks.scale * disks.scale,
                };
                if (self.watch)(&progress).is_break() {
                    return Ended::Cancelled;
                }
            }
            fire.step(disks);
            self.iteration += 1;
        }
        // At rest with almost no overlap left.
        if fire.pressure().overlap <= PAD + 0.9 * TOLERANCE { Ended::Done } else { Ended::Stuck }
    }

    /// Moves shapes that overlap until nothing overlaps or no attempt helps. Leaves the best state.
    fn shake(&mut self, disks: &mut SoftDisks) -> Ended {
        self.stage = Stage::Shaking;
        let mut best = (disks.press().energy, disks.bodies.clone());
        let size = disks.bodies.iter().map(|b| b.reach * b.reach).sum::<f64>();
        if 2.0 * best.0 > HOPELESS * HOPELESS * size && !a_few(disks) {
            return Ended::Stuck;
        }
        let (mut vain, mut round) = (0, 0);
        while vain < PATIENCE {
            let swell = self.disturb(disks, round);
            round += 1;
            disks.scale = swell;
            let mut slide = if swell > 1.0 { self.slide(disks, GROWING_STEPS) } else { Ended::Stuck };
            disks.scale = 1.0;
            if !is_over(slide) {
                slide = self.slide(disks, SLIDE_STEPS);
            }
            if slide == Ended::Done {
                return slide;
            }
            let energy = disks.press().energy;
            vain = if energy < best.0 * (1.0 - GAIN) { 0 } else { vain + 1 };
            if energy < best.0 {
                best = (energy, disks.bodies.clone());
            }
            disks.bodies.clone_from(&best.1);
            if is_over(slide) {
                return slide;
            }
        }
        Ended::Stuck
    }

    /// Moves some of the stuck shapes. Returns the size to which all shapes then grow for a while.
    fn disturb(&mut self, disks: &mut SoftDisks, round: u32) -> f64 {
        let loads = disks.loads();
        let stuck: Vec<usize> = (0..loads.len()).filter(|&k| loads[k].1 > PAD).collect();
        if stuck.is_empty() {
            return 1.0;
        }
        for _ in 0..1 + stuck.len() / STUCK_TO_A_PLACE {
            let one = stuck[self.random.below(stuck.len())];
            match round % 4 {
                // Move one of the worst shapes to the widest gap.
                0 => {
                    let rivals: [usize; 4] = std::array::from_fn(|_| stuck[self.random.below(stuck.len())]);
                    let heaviest = |a: usize, b: usize| if loads[b].0 > loads[a].0 { b } else { a };
                    self.reinsert(disks, rivals.into_iter().fold(one, heaviest));
                }
                // Exchange two shapes.
                1 => {
                    let other = self.random.below(disks.bodies.len());
                    let (a, b) = (disks.bodies[one], disks.bodies[other]);
                    (disks.bodies[one].position, disks.bodies[one].angle) = (b.position, b.angle);
                    (disks.bodies[other].position, disks.bodies[other].angle) = (a.position, a.angle);
                }
                // Shake all shapes around one.
                _ => {
                    let (middle, wide) = (disks.bodies[one].position, 0.5 + 1.5 * self.random.unit());
                    let far = 0.02 + 0.1 * self.random.unit();
                    for body in &mut disks.bodies {
                        if (body.position - middle).norm() < wide {
                            body.position += self.random.vector(far);
                            if self.orientation.turns() {
                                body.angle += self.random.within(6.0 * far);
                            }
                        }
                    }
                }
            }
        }
        if round % 4 == 3 { 1.0 + 0.05 * self.random.unit() } else { 1.0 }
    }

    /// Returns the density \[1/m²\] that is possible without overlap if, little by little, the shapes with the largest
    /// overlap are removed and the others spread; 0 if that takes too long.
    fn without_some(&mut self, shapes: &[Shape], bodies: &[SoftBody], region: &Region) -> Result<f64, Ended> {
        self.stage = Stage::Thinning;
        self.limit = self.iteration + u64::from(TAKING_ROUNDS) * TAKING_STEPS;
        let mut left: Vec<(&Shape, SoftBody)> = shapes.iter().zip(bodies.iter().copied()).collect();
        for _ in 0..TAKING_ROUNDS {
            if left.is_empty() {
                break;
            }
            let shapes: Vec<Shape> = left.iter().map(|(s, _)| (*s).clone()).collect();
            let mut disks = SoftDisks::new(&shapes, Boundary::Region(region), self.orientation, PAD);
            for (body, (_, old)) in disks.bodies.iter_mut().zip(&left) {
                (body.position, body.angle) = (old.position, old.angle);
            }
            self.density = left.len() as f64 / region.area();
            match self.slide(&mut disks, TAKING_STEPS) {
                Ended::Done => return Ok(self.density),
                Ended::Cancelled => return Err(Ended::Cancelled),
                Ended::Exhausted => break,
                Ended::Stuck => {}
            }
            let loads = disks.loads();
            let mut worst: Vec<usize> = (0..loads.len()).collect();
            worst.sort_by(|&a, &b| loads[b].0.total_cmp(&loads[a].0).then(a.cmp(&b)));
            worst.truncate(1 + (TAKEN_AWAY * left.len() as f64) as usize);
            let mut k = 0;
            left.iter_mut().zip(&disks.bodies).for_each(|(old, new)| old.1 = *new);
            left.retain(|_| {
                k += 1;
                !worst.contains(&(k - 1))
            });
        }
        Ok(0.0)
    }

    /// Moves a shape to the place with the smallest overlap among some hundred random places.
    fn reinsert(&mut self, disks: &mut SoftDisks, who: usize) {
        let grid = disks.grid();
        let mut best = (f64::INFINITY, disks.bodies[who].position, disks.bodies[who].angle);
        for _ in 0..TRIALS {
            let position = disks.boundary.random_point(&mut self.random);
            let angle = match self.orientation {
                Orientation::Fixed(angle) => angle,
                Orientation::Towards(angle) => angle + self.random.within(ASKEW),
                Orientation::Free => self.random.within(PI),
            };
            let energy = disks.energy_at(&grid, who, position, angle, best.0);
            if energy < best.0 {
                best = (energy, position, angle);
            }
        }
        (disks.bodies[who].position, disks.bodies[who].angle) = (best.1, best.2);
    }
}

/// Returns whether only some shapes of a region overlap: between its walls, some places may be too narrow for anybody.
fn a_few(disks: &mut SoftDisks) -> bool {
    let stuck = |loads: Vec<(f64, f64)>| loads.iter().filter(|load| load.1 > PAD).count() as f64;
    matches!(disks.boundary, Boundary::Region(_))
        && stuck(disks.loads()) <= (A_FEW * disks.bodies.len() as f64).max(2.0)
}
