//! Heights of disks and walls: what can touch what, and over which share of the load length; the load on chests.
//!
//! A plan view has none of it: then [`Scene::levels`](super::Scene) is `None`, and nothing here is done.

use super::compression::{Compression, ForceMoments};
use super::contact_events::ImpulseCorrection;
use super::contact_geometry::ContactForce;
use super::exposure::mean_of_both;
use super::report::ContactReport;
use super::{Body, BodyId, ContactDisk, DiskId, Face, InPlane, Rotation, Scene, Vec2, vec2};
use lemons_core::trial::Heights;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Heights of the disks and walls of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Levels {
    /// \[m\] Height over which the laws of the scene act.
    load_length: f64,
    /// Of each disk.
    disks: Vec<Heights>,
    /// Of each wall.
    walls: Vec<Heights>,
    /// \[m\] The greatest extent of a disk or a wall that ends.
    highest: f64,
    /// Of each body its disks as neighbours of the same heights.
    slabs: Vec<Vec<(Heights, Range<usize>)>>,
    /// Of each disk, whether it is one of its body's chest; empty if no chest is watched.
    of_chest: Vec<bool>,
}

impl Levels {
    /// Makes them of the disks of each body, and of all walls. `chests` \[m\] are the heights of chests whose load is to be
    /// found.
    pub fn new(
        load_length: f64,
        bodies: &[Vec<Heights>],
        walls: Vec<Heights>,
        chests: &[Option<f64>],
    ) -> Levels {
        let (mut slabs, mut of_chest) = (Vec::with_capacity(bodies.len()), Vec::new());
        let mut first = 0;
        for (disks, chest) in bodies.iter().zip(chests) {
            let ends = disks.chunk_by(|one, next| one == next).map(|same| {
                first += same.len();
                (same[0], first - same.len()..first)
            });
            slabs.push(ends.collect());
            let holds = |heights: &Heights| chest.is_some_and(|at| heights.hold(at));
            of_chest.extend(disks.iter().map(holds));
        }
        if !of_chest.contains(&true) {
            of_chest.clear();
        }
        let all = bodies.iter().flatten().chain(&walls).map(Heights::extent);
        let highest = all.filter(|extent| extent.is_finite()).fold(0.0, f64::max);
        Levels { load_length, disks: bodies.concat(), walls, highest, slabs, of_chest }
    }

    /// \[1\] Returns the share of the load length over which two disks touch; 0 if one is above the other.
    #[inline]
    pub fn share_of_disks(&self, first: DiskId, second: DiskId) -> f64 {
        self.share(&self.disks[first.index()], &self.disks[second.index()])
    }

    /// \[1\] Returns the same of a disk and a face.
    #[inline]
    pub fn share_of_face(&self, disk: DiskId, face: &Face) -> f64 {
        self.share(&self.disks[disk.index()], &self.walls[face.wall.index()])
    }

    /// Two things that go on for ever touch as in the plan.
    #[inline]
    fn share(&self, one: &Heights, other: &Heights) -> f64 {
        let common = one.common(other);
        if common == f64::INFINITY { 1.0 } else { common.max(0.0) / self.load_length }
    }

    /// \[1\] Returns the greatest sum of the shares of a body, whatever touches it.
    pub fn greatest_share(&self, body: BodyId) -> f64 {
        let mut heights: Vec<Heights> = self.slabs[body.index()].iter().map(|slab| slab.0).collect();
        heights.sort_by(|one, other| one.bottom.total_cmp(&other.bottom).then(one.top.total_cmp(&other.top)));
        heights.dedup();
        let share = |own: &Heights| match own.top.is_finite() {
            true => own.extent() / self.load_length,
            false => (self.highest / self.load_length).max(1.0),
        };
        heights.iter().map(share).sum()
    }

    /// Returns the heights of a wall.
    pub(super) fn of_wall(&self, wall: usize) -> &Heights {
        &self.walls[wall]
    }

    /// Returns whether a disk and a face have a height in common.
    pub(super) fn meets_face(&self, disk: usize, face: &Face) -> bool {
        self.disks[disk].common(&self.walls[face.wall.index()]) > 0.0
    }

    /// Returns those disks of a body that have a height in common with a disk, as ascending ranges.
    pub(super) fn beside(&self, disk: usize, body: usize) -> impl Iterator<Item = Range<usize>> {
        let own = &self.disks[disk];
        self.slabs[body].iter().filter(|slab| slab.0.common(own) > 0.0).map(|slab| slab.1.clone())
    }

    /// Returns whether the load on somebody's chest is to be found.
    pub fn watches_chests(&self) -> bool {
        !self.of_chest.is_empty()
    }

    fn is_of_chest(&self, disk: DiskId) -> bool {
        self.of_chest.get(disk.index()).is_some_and(|of_chest| *of_chest)
    }

    /// Returns what a contact does to the chests of two disks, which are the same at a wall.
    #[inline]
    pub(super) fn chest_forces(
        &self,
        scene: &Scene,
        [first, second]: [DiskId; 2],
        turn: impl Fn(DiskId) -> Rotation,
        force: &ContactForce,
        impulse: Option<&ImpulseCorrection>,
        share: f64,
    ) -> impl Iterator<Item = ChestForce> {
        let by_wall = first == second;
        let on = |disk: DiskId, arm: Vec2, sign: f64| {
            let (normal, tangential, squeeze) = match impulse {
                None => (force.reaction.normal, force.reaction.tangential, force.reaction.normal.abs()),
                Some(by) => (by.normal, by.tangential, by.squeeze),
            };
            let vector = force.overlap.normal * normal + force.overlap.normal.left() * tangential;
            ChestForce {
                body: scene.body_of(disk),
                by_wall,
                is_impulse: impulse.is_some(),
                squeeze: squeeze * share,
                moments: ForceMoments::of(turn(disk), arm, vector * (sign * share)),
            }
        };
        let one = self.is_of_chest(first).then(|| on(first, force.arm, 1.0));
        let other = (!by_wall && self.is_of_chest(second)).then(|| on(second, force.other_arm, -1.0));
        one.into_iter().chain(other)
    }

    /// \[m\] Returns the extent of somebody's chest along the gaze, and across it; none if it is not watched.
    fn chest_extent(&self, body: &Body, disks: &[ContactDisk]) -> Option<Vec2> {
        let own = body.disks.clone().filter(|disk| self.is_of_chest(DiskId::from(*disk)));
        extent(own.map(|disk| &disks[disk]))
    }
}

/// \[m\] Returns the extent of disks along the gaze, and across it.
pub(super) fn extent<'a>(disks: impl Iterator<Item = &'a ContactDisk>) -> Option<Vec2> {
    let around = disks.map(|disk| {
        let corner = vec2(disk.radius, disk.radius);
        (disk.offset - corner, disk.offset + corner)
    });
    let around = around.reduce(|(low, high), (one, other)| {
        (vec2(low.x.min(one.x), low.y.min(one.y)), vec2(high.x.max(other.x), high.y.max(other.y)))
    });
    around.map(|(low, high)| high - low)
}

/// What a contact does to a chest at an instant: a force, or an impulse besides it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ChestForce {
    body: BodyId,
    by_wall: bool,
    is_impulse: bool,
    /// \[N\] or \[N.s\]
    squeeze: f64,
    moments: ForceMoments,
}

/// The load on a chest in the last communication step, as means.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ChestExposure {
    /// \[N\] Sum of |F_n| over its contacts with others.
    pub people_force: f64,
    /// \[N\] The same with walls.
    pub wall_force: f64,
    /// Forces that press it together.
    pub compression: Compression,
}

impl ChestExposure {
    /// Returns the exposure over a time of two parts, as [`super::Exposure::and`].
    pub(super) fn and(&self, before: f64, after: &ChestExposure, duration: f64) -> ChestExposure {
        let mean = |one, other| mean_of_both([one, other], [before, duration]);
        ChestExposure {
            people_force: mean(self.people_force, after.people_force),
            wall_force: mean(self.wall_force, after.wall_force),
            compression: self.compression.and(before, &after.compression, duration),
        }
    }

    /// Returns whether all of it are numbers.
    pub fn is_finite(&self) -> bool {
        self.people_force.is_finite() && self.wall_force.is_finite() && self.compression.is_finite()
    }
}

/// The sums for a [`ChestExposure`] \[N.s\], \[N.m.s\].
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ChestSum {
    people: f64,
    walls: f64,
    moments: ForceMoments,
}

impl ChestSum {
    /// Returns one for each body; none if no chest is watched.
    pub fn of(scene: &Scene) -> Vec<ChestSum> {
        let watched = scene.levels.as_ref().is_some_and(|levels| levels.watches_chests());
        vec![ChestSum::default(); if watched { scene.bodies.len() } else { 0 }]
    }

    /// Adds what acts at an instant that counts for a duration \[s\].
    pub fn add_all<'a>(sums: &mut [ChestSum], forces: impl Iterator<Item = &'a ChestForce>, duration: f64) {
        for ChestForce { body, by_wall, is_impulse, squeeze, moments } in forces {
            let sum = &mut sums[body.index()];
            let by = if *is_impulse { 1.0 } else { duration };
            *(if *by_wall { &mut sum.walls } else { &mut sum.people }) += squeeze * by;
            sum.moments.add(moments, by);
        }
    }

    /// Returns the exposures over a duration \[s\]; over none those at its end.
    pub fn exposures(
        sums: &[ChestSum],
        scene: &Scene,
        duration: f64,
        end: &ContactReport,
    ) -> Vec<ChestExposure> {
        if duration == 0.0 && !sums.is_empty() {
            let mut sums = ChestSum::of(scene);
            ChestSum::add_all(&mut sums, end.chest_forces.iter(), 1.0);
            return ChestSum::exposures(&sums, scene, 1.0, end);
        }
        let Some(levels) = scene.levels.as_deref() else { return Vec::new() };
        let of = |(sum, body): (&ChestSum, &Body)| {
            let Some(extent) = levels.chest_extent(body, &scene.disks) else {
                return ChestExposure::default();
            };
            let mut moments = ForceMoments::default();
            moments.add(&sum.moments, 1.0 / duration);
            ChestExposure {
                people_force: (sum.people / duration).max(0.0),
                wall_force: (sum.walls / duration).max(0.0),
                compression: moments.compression(extent),
            }
        };
        sums.iter().zip(&scene.bodies).map(of).collect()
    }
}
