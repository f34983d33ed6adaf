//! The mechanical step: predict, evaluate, correct.
//!
//! Velocity Verlet in the form: half kick by the contacts, free flight, half kick. Two successive half kicks are done
//! together. The flight is the closed-form solution for drive and relaxation. So a body without contacts moves exactly,
//! and without drive and relaxation the step is plain velocity Verlet. Contact forces are evaluated once per step, from
//! positions and *predicted* velocities of the same instant (Vyas, Ottino, Lueptow, Umbanhowar, Comput. Phys. Commun.
//! 310 (2025) 109524). This keeps second order for forces that depend on velocity.

use super::blocks::{BLOCK, Blocks, Bodies, Renewed};
use super::broad_phase::{
    AWAKE, CellGrid, Crowded, MOST_MARGIN, Watch, moved_further, near_margin, steps_of_near_pairs,
};
use super::circle::Circle;
use super::contacts::{SpringUpdate, Step, greater};
use super::free_flight::{AcrossFlight, Course, Ramp};
use super::shortlist::{Activity, Shortlist, disks_of};
use super::{Body, BodyId, Pose, Scene, State, Threads, Twist, Work, Wrench};

/// Accelerations of each body by a drive that is constant during the communication step.
pub(super) fn held_drives(scene: &Scene, drive: &[Wrench]) -> Vec<Wrench> {
    let bodies = scene.bodies.iter().zip(drive);
    bodies.map(|(body, drive)| per_mass_and_inertia(body, drive)).collect()
}

/// Accelerations of each body by a drive that changes linearly during the communication step.
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

/// The bodies of a block that move by mechanical steps.
pub(super) struct Movers<D: Course> {
    /// First those without wheels, then those with wheels; each ascending. So a step of most crowds has no branch for
    /// wheels.
    list: Vec<Mover<D>>,
    /// Number of those without wheels.
    without_wheels: usize,
}

impl<D: Course> Movers<D> {
    const NONE: Movers<D> = Movers { list: Vec::new(), without_wheels: 0 };

    /// Adds a body.
    fn insert(&mut self, scene: &Scene, mover: Mover<D>) {
        let has_wheels = scene.bodies[mover.body.index()].across_rate.is_some();
        let (from, of) = match has_wheels {
            false => (0, &self.list[..self.without_wheels]),
            true => (self.without_wheels, &self.list[self.without_wheels..]),
        };
        let at = from + of.partition_point(|other| other.body < mover.body);
        self.list.insert(at, mover);
        self.without_wheels += usize::from(!has_wheels);
    }
}

/// A body that moves by mechanical steps.
struct Mover<D: Course> {
    body: BodyId,
    /// Index of its flight over one mechanical step: [`Body::flyer`].
    flyer: u32,
    /// \[m\] [`Body::reach`]
    reach: f64,
    /// \[1/m²\] One over the square of its margin of near pairs.
    per_squared_margin: f64,
    /// \[1/rad\] [`Body::reach`] over this margin.
    reach_per_margin: f64,
    /// \[1/kg\]
    inverse_mass: f64,
    /// \[1/(kg.m2)\]
    inverse_inertia: f64,
    /// The drive at the start of the communication step.
    drive: D,
}

impl<D: Course> Mover<D> {
    fn new(scene: &Scene, drives: &[D], b: usize) -> Mover<D> {
        let body = &scene.bodies[b];
        Mover {
            body: BodyId::from(b),
            flyer: body.flyer,
            reach: body.reach,
            per_squared_margin: 0.0,
            reach_per_margin: 0.0,
            inverse_mass: body.inverse_mass,
            inverse_inertia: body.inverse_inertia,
            drive: drives[b],
        }
    }

    #[inline]
    fn acceleration(&self, wrench: &Wrench) -> Wrench {
        Wrench { force: wrench.force * self.inverse_mass, torque: wrench.torque * self.inverse_inertia }
    }

    /// Returns how far \[m\] a disk may move in a step \[s\] at a twist.
    fn movement(&self, twist: &Twist, dt: f64) -> f64 {
        dt * (twist.velocity.norm() + self.reach * twist.angular_velocity.abs())
    }

    /// Chooses the margin \[m\] of its near pairs.
    fn choose_margin(&mut self, twist: &Twist, expected: &Expected) -> f64 {
        let margin = near_margin(self.movement(twist, expected.dt), expected.mean, expected.steps);
        self.per_squared_margin = 1.0 / (margin * margin);
        self.reach_per_margin = self.reach / margin;
        margin
    }
}

/// What was expected when margins of near pairs were chosen.
#[derive(Debug, Default)]
pub(super) struct Expected {
    /// \[s\] The mechanical step.
    dt: f64,
    /// \[m\] Mean of what disks move in it.
    mean: f64,
    /// For how many of them a list lasts.
    steps: f64,
}

/// Entries of the grid of free bodies for each of them: most active ones have none near.
const ENTRIES: usize = 8;

/// A communication step in progress.
pub(super) struct CommunicationStep<'a, D: Course> {
    pub scene: &'a Scene,
    pub threads: &'a Threads,
    /// The state at its start.
    pub start: &'a State,
    /// For each body the drive at its start.
    pub drives: &'a [D],
    pub shortlist: Shortlist,
    pub blocks: &'a mut Blocks,
    pub work: &'a mut Work,
    pub mechanical: Step,
    /// The bodies that move by mechanical steps, in each block.
    pub movers: Vec<Movers<D>>,
    /// Flights over one mechanical step; empty as long as all bodies are free.
    pub flights: Vec<D::Flight>,
    /// For each of them what wheels add.
    pub across: Vec<Option<AcrossFlight>>,
    /// \[1\] Part of the margins by which bodies may move before the list of near pairs is made again.
    pub leeway: f64,
    /// \[1\] What it was when lists were made or changed.
    pub leeway_then: f64,
    /// What these margins are for.
    pub expected: Expected,
    /// When it is looked for free bodies again.
    pub watch: Watch,
    /// The poses when it was last looked for free bodies near active ones; empty if nobody is free.
    pub awoken_at: Vec<Pose>,
}

impl<D: Course> CommunicationStep<'_, D> {
    /// Returns the state after `steps` mechanical steps.
    ///
    /// # Errors
    /// More pairs are near each other than the limit of memory allows.
    pub fn run(mut self, steps: u64) -> Result<State, Crowded> {
        self.begin(steps)?;
        if all(&self.movers).next().is_some() {
            for step in 1..=steps {
                let moved = self.step(step);
                // A pose that is not a number is ignored here: the communication step then ends with an error.
                let woken = self.wakes(step, moved);
                if self.leeway <= 0.0 {
                    self.leeway = self.left_of_margins();
                }
                if self.leeway <= 0.0 {
                    self.renew_lists(step, steps)?;
                } else if !woken.is_empty() {
                    self.list_woken(&woken)?;
                }
            }
            self.correct();
        }
        Ok(self.end(steps))
    }

    /// Lists the active bodies and their pairs at the first instant.
    fn begin(&mut self, steps: u64) -> Result<(), Crowded> {
        let blocks = &mut *self.blocks;
        blocks.load(self.scene, self.start);
        self.movers.resize_with(blocks.blocks.len(), || Movers::NONE);
        for (b, activity) in self.shortlist.activity.iter().enumerate() {
            if *activity == Activity::Active {
                self.movers[b / BLOCK].insert(self.scene, Mover::new(self.scene, self.drives, b));
                blocks.put(b, self.start.poses[b], self.start.twists[b]);
            }
        }
        if all(&self.movers).next().is_some() {
            self.flights = D::flights(self.scene, self.mechanical.dt);
            self.across = AcrossFlight::all_over(self.scene, self.mechanical.dt);
        }
        self.awake(0);
        self.renew_lists(0, steps)
    }

    /// Evaluates the contacts, kicks, and flies to the next instant. Returns how far \[m\] a disk may have moved.
    fn step(&mut self, step: u64) -> f64 {
        // Between two steps, the last half kick of one and the first of the next are done together.
        let (update, kick) = match step {
            1 => (SpringUpdate::Hold, 0.5 * self.mechanical.dt),
            _ => (SpringUpdate::Over(&self.mechanical), self.mechanical.dt),
        };
        let half_kick = 0.5 * self.mechanical.dt;
        // Multiplied, not added up, so that rounding errors do not accumulate.
        let begun = (step - 1) as f64 * self.mechanical.dt;
        let (scene, movers, flights, across) =
            (self.scene, &self.movers, &self.flights[..], &self.across[..]);
        let predict = |k: usize, mut bodies: Bodies| {
            apply_impulses(scene, &mut bodies);
            let plain = |mover: &Mover<D>, pose: Pose, twist: Twist| {
                mover.drive.after(begun).plain(&flights[mover.flyer as usize], pose, twist)
            };
            let fly = |mover: &Mover<D>, pose: Pose, twist: Twist| {
                plain(mover, pose, twist).fly(&flights[mover.flyer as usize], pose, twist)
            };
            let (without_wheels, with_wheels) = movers[k].list.split_at(movers[k].without_wheels);
            let moved = predict(without_wheels, &mut bodies, kick, half_kick, fly);
            if with_wheels.is_empty() {
                return moved;
            }
            let roll = |mover: &Mover<D>, pose: Pose, twist: Twist| {
                let (mut end, mut end_twist) = fly(mover, pose, twist);
                if let Some(across) = &across[mover.flyer as usize] {
                    let drive = plain(mover, pose, twist).ramp();
                    across.add(drive, pose, twist, &mut end, &mut end_twist);
                }
                (end, end_twist)
            };
            let rolled = predict(with_wheels, &mut bodies, kick, half_kick, roll);
            [0, 1].map(|k| moved[k].max(rolled[k]))
        };
        let [used, moved] = self.blocks.evaluate(self.scene, self.threads, update, kick, predict);
        self.leeway -= used;
        self.work.steps += 1;
        moved
    }

    /// Evaluates the forces of the last instant and does the last half kick.
    fn correct(&mut self) {
        let (scene, movers, half_kick) = (self.scene, &self.movers, 0.5 * self.mechanical.dt);
        let correct = |k: usize, mut bodies: Bodies| {
            apply_impulses(scene, &mut bodies);
            for mover in &movers[k].list {
                let b = mover.body.index() - bodies.start;
                let (load, flown) = (std::mem::take(&mut bodies.loads[b]), &mut bodies.flown[b]);
                flown.exposure_sum.add(&load, half_kick);
                flown.twist = kicked(flown.twist, mover.acceleration(&load.wrench), half_kick);
            }
            [0.0; 2]
        };
        let update = SpringUpdate::Over(&self.mechanical);
        self.blocks.evaluate(self.scene, self.threads, update, half_kick, correct);
    }

    /// Makes the lists valid after some steps: the near pairs and, if necessary, the candidates.
    fn renew_lists(&mut self, step: u64, steps: u64) -> Result<(), Crowded> {
        self.choose_margins((steps - step) as f64);
        self.list(Renewed::All)?;
        self.note_lists(1.0);
        Ok(())
    }

    /// Returns the part of its margin by which every body may still move. It is more than what is left of a sum over steps,
    /// each of the body that moved by the largest part.
    fn left_of_margins(&self) -> f64 {
        let Blocks { kinematics, near_at, .. } = &*self.blocks;
        let moved = |mover: &Mover<D>| {
            let (then, now) = (&near_at[mover.body.index()], &kinematics[mover.body.index()].pose());
            let squared = (now.position - then.position).norm_squared() * mover.per_squared_margin;
            squared.sqrt() + (now.orientation - then.orientation).abs() * mover.reach_per_margin
        };
        self.leeway_then - all(&self.movers).map(moved).fold(0.0, f64::max)
    }

    /// Notes where bodies are when lists were made or changed, and by which part of their margins they may move from there.
    fn note_lists(&mut self, leeway: f64) {
        let Blocks { kinematics, near_at, .. } = &mut *self.blocks;
        near_at.clear();
        near_at.extend(kinematics.iter().map(|body| body.pose()));
        (self.leeway, self.leeway_then) = (leeway, leeway);
    }

    /// Adds the pairs of bodies that have become active to valid lists.
    fn list_woken(&mut self, woken: &[usize]) -> Result<(), Crowded> {
        for &b in woken {
            let list = &mut self.movers[b / BLOCK].list;
            let mover = list.iter_mut().find(|mover| mover.body.index() == b);
            let mover = mover.expect("it has just become active");
            self.blocks.margins[b] = mover.choose_margin(&self.blocks.kinematics[b].twist, &self.expected);
        }
        self.list(Renewed::Joined)?;
        // Some blocks have pairs of those who are near now, others of those who were near then.
        self.note_lists(self.leeway);
        Ok(())
    }

    fn list(&mut self, which: Renewed) -> Result<(), Crowded> {
        let activity = &self.shortlist.activity;
        let listed = |b| activity[b] == Activity::Active;
        self.work.listed += self.blocks.list(self.scene, self.threads, listed)?;
        self.work.refreshes += u64::from(which == Renewed::All);
        self.blocks.renew(self.scene, self.threads, which);
        Ok(())
    }

    /// Chooses how near to each body near pairs are, if at most some steps are left.
    fn choose_margins(&mut self, left: f64) {
        let Blocks { kinematics, margins, .. } = &mut *self.blocks;
        let dt = self.mechanical.dt;
        let count = all(&self.movers).count().max(1) as f64;
        let movement =
            |mover: &Mover<D>| mover.movement(&kinematics[mover.body.index()].twist, dt).min(MOST_MARGIN);
        let mean = all(&self.movers).map(movement).sum::<f64>() / count;
        self.expected = Expected { dt, mean, steps: steps_of_near_pairs(mean, left.max(1.0)) };
        // Pairs of others are never near: a longer list would change the order of impulses, and so last digits.
        margins.fill(f64::NAN);
        for mover in self.movers.iter_mut().flat_map(|of_block| &mut of_block.list) {
            let b = mover.body.index();
            margins[b] = mover.choose_margin(&kinematics[b].twist, &self.expected);
        }
    }

    /// Looks for free bodies, if it is time, after a step in which disks have moved by a distance \[m\] at most. Returns
    /// those that became active.
    fn wakes(&mut self, step: u64, moved: f64) -> Vec<usize> {
        if self.awoken_at.is_empty() || !self.watch.is_over(moved) {
            return Vec::new();
        }
        let most = self.watch.begin(step);
        let has_moved = |mover: &Mover<D>| {
            let b = mover.body.index();
            moved_further(most, mover.reach, &self.awoken_at[b], &self.blocks.kinematics[b].pose())
        };
        if all(&self.movers).any(has_moved) { self.awake(step) } else { Vec::new() }
    }

    /// Makes free bodies near active ones active, then those near these, and so on. Returns which.
    fn awake(&mut self, step: u64) -> Vec<usize> {
        let is_free = |activity: &Activity| *activity == Activity::Free;
        let free: Vec<usize> =
            (0..self.scene.bodies.len()).filter(|&b| is_free(&self.shortlist.activity[b])).collect();
        let mut woken = Vec::new();
        if !free.is_empty() {
            let largest = self.scene.bodies.iter().map(|body| body.bounding_radius);
            let swept = free.iter().map(|&b| self.shortlist.swept[b].radius);
            let largest = swept.chain(largest).fold(0.0, f64::max);
            let who = free.iter().copied();
            let grid = CellGrid::near(largest, &self.shortlist.swept, who, AWAKE, ENTRIES);
            let mut near = vec![Vec::new(); self.movers.len()];
            let each = self.movers.iter().zip(&mut near);
            self.threads.each(each, |(movers, near)| {
                movers.list.iter().for_each(|mover| self.find_free(&grid, mover.body.index(), near));
            });
            let mut near = near.concat();
            while let Some(b) = near.pop() {
                // Several may have found it.
                if is_free(&self.shortlist.activity[b]) {
                    self.take_in(b, step);
                    woken.push(b);
                    self.find_free(&grid, b, &mut near);
                }
            }
        }
        self.awoken_at.clear();
        if woken.len() < free.len() {
            self.awoken_at.extend(self.blocks.kinematics.iter().map(|body| body.pose()));
        } else {
            // They take many bytes per agent.
            self.shortlist.forget_circles();
        }
        woken
    }

    /// Finds the free bodies near an active one.
    fn find_free(&self, free: &CellGrid, active: usize, found: &mut Vec<usize>) {
        let (now, before) = (&self.blocks.kinematics[active], found.len());
        let circle = Circle { centre: now.position, radius: self.scene.bodies[active].bounding_radius };
        free.for_each_near(&circle, AWAKE, |b| {
            if self.shortlist.activity[b] == Activity::Free {
                found.push(b);
            }
        });
        if found.len() == before {
            return;
        }
        let disks: Vec<Circle> = disks_of(self.scene, active, now).collect();
        let mut kept = before;
        for k in before..found.len() {
            if self.shortlist.nears(self.scene, &disks, &circle, found[k], AWAKE) {
                found[kept] = found[k];
                kept += 1;
            }
        }
        found.truncate(kept);
    }

    /// Makes a free body active, at the pose of the closed form at this instant.
    fn take_in(&mut self, b: usize, step: u64) {
        let (mut pose, mut twist) = (self.start.poses[b], self.start.twists[b]);
        if step > 0 {
            let flight = D::flight(&self.scene.bodies[b], step as f64 * self.mechanical.dt);
            (pose, twist) = self.drives[b].fly(&flight, pose, twist);
        }
        self.shortlist.activity[b] = Activity::Active;
        self.movers[b / BLOCK].insert(self.scene, Mover::new(self.scene, self.drives, b));
        self.blocks.put(b, pose, twist);
    }

    /// Free bodies fly the whole step at once; the springs of touching pairs are written into the state.
    fn end(self, steps: u64) -> State {
        let mut state = State { steps: self.start.steps + steps, ..State::default() };
        let flights = D::flights(self.scene, steps as f64 * self.mechanical.dt);
        let blocks = &mut *self.blocks;
        for (b, body) in self.scene.bodies.iter().enumerate() {
            let (pose, twist) = match self.shortlist.activity[b] {
                Activity::Active => (blocks.kinematics[b].pose(), blocks.flown[b].twist),
                Activity::Free => {
                    self.work.shortlisted += 1;
                    let flight = &flights[body.flyer as usize];
                    self.drives[b].fly(flight, self.start.poses[b], self.start.twists[b])
                }
                Activity::Absent => (self.start.poses[b], Twist::default()),
            };
            blocks.put(b, pose, twist);
            state.poses.push(pose);
            state.twists.push(twist);
        }
        blocks.store(&mut state);
        state
    }
}

/// All movers of some blocks.
fn all<D: Course>(movers: &[Movers<D>]) -> impl Iterator<Item = &Mover<D>> {
    movers.iter().flat_map(|of_block| &of_block.list)
}

/// Kicks bodies of a block over a duration \[s\] and lets them fly to the next instant; their velocity there is predicted
/// with a half kick \[s\]. Returns the largest part of its margin by which a disk of them may have moved, and the
/// largest distance \[m\].
#[inline(always)]
fn predict<D: Course>(
    movers: &[Mover<D>],
    bodies: &mut Bodies,
    kick: f64,
    half_kick: f64,
    fly: impl Fn(&Mover<D>, Pose, Twist) -> (Pose, Twist),
) -> [f64; 2] {
    // Squares, so that one root is enough for all.
    let (mut moved, mut turned, mut moved_by, mut turned_by) = (0.0f64, 0.0f64, 0.0f64, 0.0f64);
    for mover in movers {
        let b = mover.body.index() - bodies.start;
        let load = std::mem::take(&mut bodies.loads[b]);
        let (flown, kinematics) = (&mut bodies.flown[b], &mut bodies.kinematics[b]);
        flown.exposure_sum.add(&load, kick);
        let acceleration = mover.acceleration(&load.wrench);
        let before = kinematics.pose();
        let (pose, twist) = fly(mover, before, kicked(flown.twist, acceleration, kick));
        flown.twist = twist;
        let turn = pose.orientation - before.orientation;
        // The predicted velocity is the one after another half kick.
        kinematics.follow(pose, turn, kicked(twist, acceleration, half_kick));
        let squared = (pose.position - before.position).norm_squared();
        moved = greater(moved, squared * mover.per_squared_margin);
        turned = greater(turned, turn.abs() * mover.reach_per_margin);
        moved_by = greater(moved_by, squared);
        turned_by = greater(turned_by, mover.reach * turn.abs());
    }
    [moved.sqrt() + turned, moved_by.sqrt() + turned_by]
}

/// Adds the impulses by contacts that began or ended within the last step.
#[inline]
fn apply_impulses(scene: &Scene, bodies: &mut Bodies) {
    for impulse in bodies.impulses {
        let flown = &mut bodies.flown[impulse.body.index() - bodies.start];
        flown.exposure_sum.add_impulse(impulse);
        let gain = per_mass_and_inertia(&scene.bodies[impulse.body.index()], &impulse.wrench);
        flown.twist.velocity += gain.force;
        flown.twist.angular_velocity += gain.torque;
    }
}

#[inline]
fn kicked(twist: Twist, acceleration: Wrench, duration: f64) -> Twist {
    Twist {
        velocity: twist.velocity + acceleration.force * duration,
        angular_velocity: twist.angular_velocity + acceleration.torque * duration,
    }
}
