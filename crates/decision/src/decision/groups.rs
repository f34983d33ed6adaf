//! Groups that stay together, by Moussaïd, Perozo, Garnier, Helbing, Theraulaz, *The walking behaviour of pedestrian social
//! groups and its impact on crowd dynamics*, PLoS ONE 5 (2010) e10047.
//!
//! There, a member has three accelerations besides that towards the desired velocity: a deceleration β₁ α v, where α is the
//! angle by which the head must be turned to see the group's centre; β₂ towards the centre from further away than (N − 1)/2
//! metres; and β₃ away from a member who is nearer than d₀. Here they change the desired velocity by what they make of it in
//! the relaxation time τ, for any model of walking. Of ours are: they begin gradually, so that nobody jitters; nobody walks
//! back, or faster than their own desired speed; who is behind a wall, or far away, counts by the way that each has to go;
//! and who holds others up walks on as if alone, so that groups do not block doors.

use super::{Aim, Decision};
use crate::cells::sees;
use crate::target::Arrival;
use lemons_core::plane::{InPlane, Vec2};
use std::f64::consts::FRAC_PI_2;

/// \[s\] τ, relaxation time of the velocity in models of social forces (Helbing, Farkas, Vicsek 2000).
const RELAXATION: f64 = 0.5;
/// \[1/(s rad)\] β₁, how strongly those slow down who would have to turn the head.
const VISION: f64 = 4.0;
/// \[m/s²\] β₂, attraction by the centre.
const ATTRACTION: f64 = 3.0;
/// \[m/s²\] β₃, repulsion by other members.
const REPULSION: f64 = 1.0;
/// \[m\] d₀, distance of two members below which they repel each other.
const APART: f64 = 0.8;
/// \[m\] Distances over which vision, attraction and repulsion begin.
const SOFT: [f64; 3] = [0.3, 0.5, 0.3];
/// Part of the desired speed with which at most members walk sideways.
const ASIDE: f64 = 0.5;
/// \[m\] Who is further away is where the way says.
const SIGHT: f64 = 10.0;
/// \[m\] Who has others this close behind does not slow down for the group.
const HELD_UP: f64 = 1.0;

impl Decision {
    /// Returns the group of an agent, if it is in one.
    pub(super) fn group(&self, i: usize) -> Option<&[usize]> {
        self.groups[i].map(|group| &self.plan.groups[group][..])
    }

    /// Returns who decides for an agent: the first member of its group who has not left.
    pub(super) fn leader(&self, i: usize) -> usize {
        let group = self.group(i).into_iter().flatten().copied();
        group.into_iter().find(|&j| !self.agents[j].left).unwrap_or(i)
    }

    /// Changes where those in groups want to go, so that they stay together.
    pub(super) fn keep_together(&self, aims: &mut [Aim]) {
        if self.plan.groups.is_empty() {
            return;
        }
        let mut by_x: Vec<(f64, usize)> = (0..aims.len()).map(|i| (self.agents[i].at().x, i)).collect();
        by_x.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for group in &self.plan.groups {
            let there = group.iter().copied().filter(|&i| aims[i].arrival != Some(Arrival::Leaves));
            let there: Vec<usize> = there.collect();
            let speeds = there.iter().map(|&i| self.agents[i].walker.desired_speed);
            let slowest = speeds.fold(f64::INFINITY, f64::min);
            let goes: Vec<_> =
                there.iter().map(|&i| self.with_group(i, &there, slowest, aims, &by_x)).collect();
            for (&i, goes) in there.iter().zip(goes) {
                aims[i].goes = goes;
            }
        }
    }

    /// Returns where an agent goes with those of its group who are there, the slowest of whom has this speed \[m/s\].
    fn with_group(
        &self,
        i: usize,
        there: &[usize],
        slowest: f64,
        aims: &[Aim],
        by_x: &[(f64, usize)],
    ) -> Option<(Vec2, f64)> {
        let (way, own) = aims[i].goes?;
        if there.len() < 2 || own == 0.0 {
            return Some((way, own));
        }
        // In front of a goal or a closed exit, everybody walks with a part of the desired speed.
        let speed = own * (slowest / self.agents[i].walker.desired_speed);
        let at = self.agents[i].at();
        let (mut sum, mut push) = (Vec2::zeros(), Vec2::zeros());
        for &j in there.iter().filter(|&&j| j != i) {
            let to = self.agents[j].at() - at;
            let distance = to.norm();
            let further = aims[i].to_go - aims[j].to_go;
            if distance <= SIGHT && sees(at, at + to, &self.faces) || !further.is_finite() {
                sum += to;
                let near = ((APART - distance) / SOFT[2]).clamp(0.0, 1.0);
                push -= to.unit(1e-9).unwrap_or(Vec2::zeros()) * (REPULSION * near);
            } else {
                sum += way * further;
            }
        }
        let centre = sum * (1.0 / there.len() as f64);
        let distance = centre.norm();
        let towards = centre.unit(1e-9).unwrap_or(Vec2::zeros());
        // From the gaze, people see 90° to each side.
        let angle = libm::asin((-way.dot(&towards)).clamp(0.0, 1.0)).min(FRAC_PI_2);
        let angle = angle * (distance / SOFT[0]).min(1.0);
        let far = ((distance - 0.5 * (there.len() - 1) as f64) / SOFT[1]).clamp(0.0, 1.0);
        let pull = towards * (ATTRACTION * far) + push;
        let wanted = (way * speed + pull * RELAXATION) * (1.0 / (1.0 + RELAXATION * VISION * angle));
        let ahead = wanted.dot(&way).max(0.0).min(own);
        let ahead = if ahead < speed && self.holds_up(i, there, way, aims, by_x) { speed } else { ahead };
        let most = ASIDE * speed;
        let velocity = way * ahead + way.left() * wanted.dot(&way.left()).max(-most).min(most);
        Some((velocity.unit(1e-9).unwrap_or(way), velocity.norm().min(own)))
    }

    /// Returns whether somebody else is close behind an agent and goes the same way. All are given in the order of x \[m\].
    fn holds_up(&self, i: usize, group: &[usize], way: Vec2, aims: &[Aim], by_x: &[(f64, usize)]) -> bool {
        let at = self.agents[i].at();
        let first = by_x.partition_point(|(x, _)| *x < at.x - HELD_UP);
        let mut near = by_x[first..].iter().take_while(|(x, _)| *x <= at.x + HELD_UP);
        let behind = |&(_, j): &(f64, usize)| {
            let to = self.agents[j].at() - at;
            let same = aims[j].goes.is_some_and(|(direction, _)| direction.dot(&way) > 0.0);
            same && to.dot(&way) < 0.0 && to.dot(&to) < HELD_UP * HELD_UP && !group.contains(&j)
        };
        near.any(behind)
    }
}
