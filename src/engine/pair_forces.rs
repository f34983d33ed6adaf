//! Forces of pairs of people: the contacts of two, taken together.

use super::{Pair, Pose, Vec2, World, rotation};
use std::collections::BTreeMap;

/// The normal forces between two bodies, or between a body and a wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairForce {
    /// \[m\] Centre of a body.
    pub from: Vec2,
    /// \[m\] Centre of the other body, or the strongest contact point on the wall.
    pub to: Vec2,
    /// \[N\] Sum of |F_n| over their contacts.
    pub normal_force: f64,
}

impl World {
    /// Returns the normal forces of the present contacts: pairs of bodies, then bodies at walls, both ascending. `poses`
    /// are where the bodies are drawn, one for each.
    pub fn pair_forces(&self, poses: &[Pose]) -> Vec<PairForce> {
        let scene = self.scene();
        let mut pairs: BTreeMap<(usize, usize), f64> = BTreeMap::new();
        // The strongest contact says where a body leans on a wall.
        let mut walls: BTreeMap<(usize, usize), (f64, f64, Vec2)> = BTreeMap::new();
        for contact in &self.contacts().contacts {
            let force = contact.normal_force.abs();
            match contact.pair {
                Pair::Disks { first, second } => {
                    let [first, second] = [first, second].map(|disk| scene.body_of(disk).index());
                    *pairs.entry((first, second)).or_default() += force;
                }
                Pair::Face { disk, face, .. } => {
                    let (body, disk) = (scene.body_of(disk).index(), &scene.disks[disk.index()]);
                    let centre = rotation(poses[body].orientation) * disk.offset;
                    let inwards = contact.normal * (disk.radius - 0.5 * contact.depth);
                    let point = poses[body].position + centre - inwards;
                    let wall = scene.faces[face.index()].wall.index();
                    let sum = walls.entry((body, wall)).or_insert((0.0, -1.0, point));
                    sum.0 += force;
                    if force > sum.1 {
                        (sum.1, sum.2) = (force, point);
                    }
                }
            }
        }
        let here = |body: usize| poses[body].position;
        let between = pairs.into_iter().map(|((first, second), normal_force)| PairForce {
            from: here(first),
            to: here(second),
            normal_force,
        });
        let leaning = walls.into_iter().map(|((body, _), (normal_force, _, to))| PairForce {
            from: here(body),
            to,
            normal_force,
        });
        between.chain(leaning).collect()
    }
}
