//! The mechanical step: predict, evaluate, correct.
//!
//! Velocity Verlet written as half kick by the contacts, free flight, half kick; half kicks that follow
//! each other are one. The flight is the
//! closed form of drive and relaxation, so a body that touches nothing moves exactly and the step is
//! plain velocity Verlet where there is neither drive nor relaxation. Contact forces are taken
//! once per step, from positions and *predicted* velocities of the same instant (Vyas, Ottino, Lueptow,
//! Umbanhowar, Comput. Phys. Commun. 310 (2025) 109524), which keeps second order for forces that
//! depend on velocity.

use super::contacts::{Instant, Placement, Stretch};
use super::free_flight::{Drive, Ramp};
use super::neighbours::{Circle, SKIN, for_each_near_pair, list_pairs, near_faces};
use super::pairs::Pairs;
use super::shortlist::{Activity, Shortlist};
use super::{Body, BodyId, Pose, Scene, State, Twist, Work, Wrench};

/// Arrays that a communication step works in; what they hold between two steps is never used.
#[derive(Debug, Clone, Default)]
pub(super) struct Scratch {
    pub placement: Placement,
    pub pairs: Pairs,
    /// Who moves by mechanical steps, ascending.
    active: Vec<usize>,
    predicted: Vec<Twist>,
    /// By the contacts, at the present instant; taken by the next kick.
    wrenches: Vec<Wrench>,
    /// When the pairs were listed.
    listed_at: Vec<Pose>,
}

impl Scratch {
    pub fn new(scene: &Scene) -> Scratch {
        let bodies = scene.bodies.len();
        Scratch {
            placement: Placement::new(scene),
            predicted: vec![Twist::default(); bodies],
            wrenches: vec![Wrench::default(); bodies],
            listed_at: vec![Pose::default(); bodies],
            ..Scratch::default()
        }
    }
}

/// What a drive that is held over the communication step does to each body.
pub(super) fn held_drives(scene: &Scene, drive: &[Wrench]) -> Vec<Wrench> {
    let bodies = scene.bodies.iter().zip(drive);
    bodies.map(|(body, drive)| per_mass_and_inertia(body, drive)).collect()
}

/// What a drive that changes evenly over the communication step does to each body.
pub(super) fn ramps(scene: &Scene, drive: &[Wrench], rates: &[Wrench]) -> Vec<Ramp> {
    let bodies = scene.bodies.iter().zip(drive).zip(rates);
    bodies
        .map(|((body, drive), rate)| Ramp {
            start: per_mass_and_inertia(body, drive),
            rate: per_mass_and_inertia(body, rate),
        })
        .collect()
}

#[inline]
fn per_mass_and_inertia(body: &Body, wrench: &Wrench) -> Wrench {
    Wrench { force: wrench.force * body.inverse_mass, torque: wrench.torque * body.inverse_inertia }
}

/// One communication step under way.
pub(super) struct CommunicationStep<'a, D: Drive> {
    pub scene: &'a Scene,
    /// Of each body, as they are when the step begins.
    pub drives: &'a [D],
    /// Of each body, over one mechanical step; empty at first, and as long as everybody is free.
    pub flights: Vec<D::Flight>,
    pub shortlist: Shortlist,
    pub scratch: &'a mut Scratch,
    pub work: &'a mut Work,
    /// \[s\] the mechanical step.
    pub dt: f64,
}

impl<D: Drive> CommunicationStep<'_, D> {
    /// Moves the state over `steps` mechanical steps.
    pub fn run(mut self, state: &mut State, steps: u64) {
        self.begin(state);
        if !self.scratch.active.is_empty() {
            for step in 1..=steps {
                // Between two steps the second half kick of the one and the first of the other are one.
                let kick = if step == 1 { Kick::Half } else { Kick::Full };
                let neighbours = self.predict(state, step, kick);
                if neighbours == Neighbours::MayBeMissing {
                    self.list_neighbours(state, step);
                }
                self.work.steps += 1;
                self.evaluate(Stretch::Over(self.dt));
            }
            self.correct(state);
        }
        self.end(state, steps);
    }

    /// Lists the active bodies and evaluates the contact forces of the first instant.
    fn begin(&mut self, state: &mut State) {
        let scratch = &mut *self.scratch;
        let bodies = &self.scene.bodies;
        scratch.active =
            (0..bodies.len()).filter(|&b| self.shortlist.activity[b] == Activity::Active).collect();
        if !scratch.active.is_empty() {
            self.flights = bodies.iter().map(|body| D::flight(body, self.dt)).collect();
        }
        scratch.pairs.load(self.scene, state);
        scratch.predicted.copy_from_slice(&state.twists);
        scratch.wrenches.fill(Wrench::default());
        for &b in &scratch.active {
            scratch.placement.place(self.scene, b, state.poses[b]);
        }
        self.list_neighbours(state, 0);
        self.evaluate(Stretch::Hold);
    }

    /// Kick, free flight; the velocity that another half kick would give is the predicted one.
    fn predict(&mut self, state: &mut State, step: u64, kick: Kick) -> Neighbours {
        let half = 0.5 * self.dt;
        let kick = if kick == Kick::Half { half } else { self.dt };
        // Of a whole number, so that rounding does not add up.
        let begun = (step - 1) as f64 * self.dt;
        let scratch = &mut *self.scratch;
        let mut neighbours = Neighbours::Listed;
        for &b in &scratch.active {
            let body = &self.scene.bodies[b];
            let acceleration = per_mass_and_inertia(body, &std::mem::take(&mut scratch.wrenches[b]));
            let (before, kicked) = (state.poses[b], kicked(state.twists[b], acceleration, kick));
            let (pose, twist) = self.drives[b].after(begun).fly(&self.flights[b], before, kicked);
            (state.poses[b], state.twists[b]) = (pose, twist);
            scratch.predicted[b] = self::kicked(twist, acceleration, half);
            scratch.placement.follow(self.scene, b, pose, pose.orientation - before.orientation);
            if moved_too_far(body.reach, &scratch.listed_at[b], &pose) {
                neighbours = Neighbours::MayBeMissing;
            }
        }
        neighbours
    }

    /// Lists the pairs of the active bodies, after taking in every free body that one of them nears.
    fn list_neighbours(&mut self, state: &mut State, step: u64) {
        self.work.rebuilds += 1;
        let mut circles: Vec<Circle> = self.shortlist.swept.clone();
        for &b in &self.scratch.active {
            circles[b] = self.circle_now(state, b);
        }
        let mut near_bodies = Vec::new();
        loop {
            near_bodies.clear();
            let mut promoted = Vec::new();
            for_each_near_pair(&circles, SKIN, |a, b| {
                match (self.shortlist.activity[a], self.shortlist.activity[b]) {
                    (Activity::Active, Activity::Active) => {
                        near_bodies.push((BodyId::from(a), BodyId::from(b)));
                    }
                    (Activity::Active, Activity::Free) => promoted.push(b),
                    (Activity::Free, Activity::Active) => promoted.push(a),
                    (Activity::Free, Activity::Free) => {}
                }
            });
            if promoted.is_empty() {
                break;
            }
            promoted.sort_unstable();
            promoted.dedup();
            for b in promoted {
                self.take_in(state, b, step);
                circles[b] = self.circle_now(state, b);
            }
        }
        for &b in &self.scratch.active {
            self.scratch.listed_at[b] = state.poses[b];
        }
        let near_faces = near_faces(self.scene, &circles, self.scratch.active.iter().copied());
        let Scratch { placement, pairs, .. } = &mut *self.scratch;
        list_pairs(self.scene, placement, &near_bodies, &near_faces, pairs);
    }

    fn circle_now(&self, state: &State, b: usize) -> Circle {
        Circle { centre: state.poses[b].position, radius: self.scene.bodies[b].bounding_radius }
    }

    /// A free body becomes active: it stands where the closed form puts it at this instant.
    fn take_in(&mut self, state: &mut State, b: usize, step: u64) {
        let scratch = &mut *self.scratch;
        if step > 0 {
            let flight = D::flight(&self.scene.bodies[b], step as f64 * self.dt);
            (state.poses[b], state.twists[b]) = self.drives[b].fly(&flight, state.poses[b], state.twists[b]);
        }
        self.shortlist.activity[b] = Activity::Active;
        let at = scratch.active.partition_point(|&other| other < b);
        scratch.active.insert(at, b);
        scratch.predicted[b] = state.twists[b];
        scratch.wrenches[b] = Wrench::default();
        scratch.placement.place(self.scene, b, state.poses[b]);
    }

    /// Adds the contact forces at the present positions and predicted velocities to the wrenches.
    fn evaluate(&mut self, stretch: Stretch) {
        let Scratch { placement, pairs, predicted, wrenches, .. } = &mut *self.scratch;
        let instant = Instant { scene: self.scene, placement, twists: predicted };
        instant.evaluate(pairs, stretch, wrenches, self.work);
    }

    /// The last half kick.
    fn correct(&mut self, state: &mut State) {
        for &b in &self.scratch.active {
            let acceleration = per_mass_and_inertia(&self.scene.bodies[b], &self.scratch.wrenches[b]);
            state.twists[b] = kicked(state.twists[b], acceleration, 0.5 * self.dt);
        }
    }

    /// Free bodies fly the whole step at once; the touching pairs' springs go into the state.
    fn end(&mut self, state: &mut State, steps: u64) {
        let duration = steps as f64 * self.dt;
        for (b, body) in self.scene.bodies.iter().enumerate() {
            if self.shortlist.activity[b] == Activity::Free {
                self.work.shortlisted += 1;
                let flight = D::flight(body, duration);
                (state.poses[b], state.twists[b]) =
                    self.drives[b].fly(&flight, state.poses[b], state.twists[b]);
            }
            self.scratch.placement.place(self.scene, b, state.poses[b]);
        }
        self.scratch.pairs.store(state);
        state.steps += steps;
    }
}

/// How long contact forces act on the velocity at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kick {
    /// Half a mechanical step.
    Half,
    /// From the middle of one step to the middle of the next.
    Full,
}

/// Whether the list of neighbours still holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Neighbours {
    /// Every pair that may touch is in it.
    Listed,
    /// A disk may have moved further than half the skin since it was made.
    MayBeMissing,
}

/// Whether a disk may have moved further than half the skin; `reach` \[m\] of the farthest from the centre of mass.
#[inline]
fn moved_too_far(reach: f64, then: &Pose, now: &Pose) -> bool {
    let left = 0.5 * SKIN - reach * (now.orientation - then.orientation).abs();
    // Negated so that a pose that is not a number counts as moved.
    !(left > 0.0 && (now.position - then.position).norm_squared() < left * left)
}

#[inline]
fn kicked(twist: Twist, acceleration: Wrench, duration: f64) -> Twist {
    Twist {
        velocity: twist.velocity + acceleration.force * duration,
        angular_velocity: twist.angular_velocity + acceleration.torque * duration,
    }
}
