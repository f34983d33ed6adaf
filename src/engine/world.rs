//! The world owns scene, drive and state, and advances them in time.

use super::blocks::{Blocks, Renewed};
use super::broad_phase::{Crowded, Watch};
use super::compression::compressions;
use super::contacts::{SpringUpdate, Step};
use super::face::nearest_on_face;
use super::free_flight::Course;
use super::mechanical_step::{CommunicationStep, Expected, held_drives, ramps};
use super::report::ContactReport;
use super::shortlist::{Activity, Shortlist};
use super::slope::OnSlopes;
use super::{
    Body, BodyId, ChestExposure, Compression, DiskId, Exposure, Exposures, FaceExposure, InPlane, Pair, Pose,
    Scene, Shortlisting, State, Threads, ThreadsError, Twist, Vec2, WallId, Work, Wrench, rotation,
};
use lemons_core::plane::{self, Motion, body_meets};
use std::sync::OnceLock;
use thiserror::Error;

/// Largest number of mechanical steps that is counted.
const MOST_COUNTED: f64 = 1e12;

/// Largest number of mechanical steps in one communication step: evaluations are numbered with 32 bits. More would take
/// for ever.
const MOST_STEPS: u64 = 4_000_000_000;

/// See [`World::share_from`]. A step with this amount of work takes about 20 µs; sharing it costs a fraction of that.
const SHARE_FROM: usize = 1800;

/// Number of mechanical steps of each body that is there, from which on it is decided who is free: see [`World::activity`].
/// Found by counting instructions of crowds with 7 to 34 steps; some that touch nothing are not free.
const SHORTLIST_FROM: u64 = 8;

/// Largest number of threads that are started, however many are requested.
pub const MOST_THREADS: usize = 64;

/// By how much H / TimeStepMechanical may exceed a whole number and still count as this number: communication
/// steps contain rounding errors of the master.
const STEP_COUNT_TOLERANCE: f64 = 1e-9;

/// Why a step was refused or failed. The world is unchanged.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum AdvanceError {
    /// The communication step is not a positive finite number.
    #[error("a communication step of {0:?} s: must be positive and finite")]
    Duration(f64),
    /// The communication step contains far too many mechanical steps.
    #[error(
        "a communication step of {duration:?} s at a mechanical step of {mechanical_step:?} s takes too many steps"
    )]
    TooManySteps {
        /// \[s\] communication step.
        duration: f64,
        /// \[s\] mechanical step.
        mechanical_step: f64,
    },
    /// The motion of a body, or a force on it, is no longer a finite number: the mechanical step is too long, or the
    /// forces are far too large.
    #[error("its motion is no longer finite; the mechanical step may be too long")]
    NotFinite {
        /// The body.
        body: BodyId,
    },
    /// More pairs come near each other than the limit of memory allows.
    #[error(transparent)]
    Crowded(#[from] Crowded),
}

/// The number of mechanical steps in a communication step: the smallest n with
/// `duration / n ≤ mechanical_step` up to rounding.
///
/// # Errors
/// The duration is not positive and finite, or there are far too many steps.
pub fn step_count(duration: f64, mechanical_step: f64) -> Result<u64, AdvanceError> {
    if !(duration > 0.0 && duration.is_finite()) {
        return Err(AdvanceError::Duration(duration));
    }
    let ratio = duration / mechanical_step;
    if ratio > MOST_COUNTED || ratio.is_nan() {
        return Err(AdvanceError::TooManySteps { duration, mechanical_step });
    }
    let nearest = libm::round(ratio);
    let steps = if ratio - nearest <= STEP_COUNT_TOLERANCE * nearest { nearest } else { libm::ceil(ratio) };
    Ok(steps.max(1.0) as u64)
}

/// Scene, drive and state. [`World::advance`] advances them.
#[derive(Debug, Clone)]
pub struct World {
    scene: Scene,
    state: State,
    /// F_p and M_p of each body at the start of a communication step; constant over the step if `drive_rate` is zero.
    pub drive: Vec<Wrench>,
    /// \[N/s\], \[N.m/s\] rates at which F_p and M_p of each body change during a communication step; initially zero.
    ///
    /// At a time t after the start of the step the drive is `drive + drive_rate·t`. [`World::advance`] changes
    /// neither of them. A rate therefore acts in every step until it is set to zero, and each step begins again
    /// with `drive`. Like the drive, the rate is not part of the [`State`].
    pub drive_rate: Vec<Wrench>,
    /// \[s\] the longest mechanical step; positive.
    pub mechanical_step: f64,
    /// Whether bodies that can touch nothing are moved by the closed-form solution.
    pub shortlisting: Shortlisting,
    /// A communication step is left to one thread if, at its start, the number of bodies that move by mechanical
    /// steps plus twice the number of contacts is less than this; which bodies these are is found by one thread if
    /// those that are there count less. Results do not depend on it.
    pub share_from: usize,
    /// Of each body, whether it is there.
    present: Vec<bool>,
    /// The same of each wall.
    present_walls: Vec<bool>,
    threads: Threads,
    /// Number of communication steps that several threads have shared.
    shared: u64,
    contacts: ContactReport,
    /// Whether bodies have come since the contacts were found.
    came: bool,
    compressions: OnceLock<Vec<Compression>>,
    exposures: Exposures,
    work: Work,
    blocks: Blocks,
}

impl World {
    /// Makes a world in a given state, without drive.
    ///
    /// The state must have one pose and one twist for each body. Springs of pairs that do not touch are dropped.
    ///
    /// # Errors
    /// More pairs are near each other than the limit of memory allows.
    pub fn new(scene: Scene, state: State, mechanical_step: f64) -> Result<World, Crowded> {
        let present = vec![true; scene.bodies.len()];
        World::of_present(scene, state, mechanical_step, present)
    }

    /// Makes the same, in which some bodies are not there.
    ///
    /// # Errors
    /// Those of [`World::new`].
    pub fn of_present(
        scene: Scene,
        state: State,
        mechanical_step: f64,
        present: Vec<bool>,
    ) -> Result<World, Crowded> {
        assert_eq!(present.len(), scene.bodies.len(), "one for each body");
        assert_eq!(state.poses.len(), scene.bodies.len(), "one pose for each body");
        assert_eq!(state.twists.len(), scene.bodies.len(), "one twist for each body");
        let mut world = World {
            drive: vec![Wrench::default(); scene.bodies.len()],
            drive_rate: vec![Wrench::default(); scene.bodies.len()],
            blocks: Blocks::new(&scene),
            mechanical_step,
            shortlisting: Shortlisting::On,
            share_from: SHARE_FROM,
            present,
            present_walls: vec![true; scene.wall_faces.len()],
            threads: Threads::default(),
            shared: 0,
            contacts: ContactReport::default(),
            came: false,
            compressions: OnceLock::new(),
            exposures: Exposures::default(),
            work: Work::default(),
            state: State::default(),
            scene,
        };
        world.restore(state)?;
        Ok(world)
    }

    /// Bodies, walls and laws.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Poses, twists and springs.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Whether a body is there.
    pub fn is_present(&self, body: BodyId) -> bool {
        self.present[body.index()]
    }

    /// Of each body, whether it is there.
    pub fn present(&self) -> &[bool] {
        &self.present
    }

    /// From the next step on, a body is there or not. One that is not there touches nothing, does not move, and costs
    /// almost nothing. When it comes back, it stands where it was.
    ///
    /// The [`World::contacts`] are still those of the step before. Like the drive, this is not part of the [`State`]:
    /// it must be set before [`World::restore`].
    pub fn set_present(&mut self, body: BodyId, present: bool) {
        if std::mem::replace(&mut self.present[body.index()], present) != present {
            self.blocks.forget_candidates();
            self.came |= present;
        }
    }

    /// A body that comes has this motion from the next step on. Contacts are those of the step before.
    pub fn set_twist(&mut self, body: BodyId, twist: Twist) {
        self.state.twists[body.index()] = twist;
    }

    /// Of each wall, whether it is there.
    pub fn present_walls(&self) -> &[bool] {
        &self.present_walls
    }

    /// Takes walls out, or puts them back: doors that open and close. Faces keep their numbers. Those of an absent wall
    /// touch nothing; where walls met it, they end. Contacts are found anew; the [`World::exposures`] stay. This
    /// is not part of the [`State`] either.
    ///
    /// # Errors
    /// More pairs are near each other than the limit of memory allows. The world is then unchanged.
    pub fn set_present_walls(&mut self, present: &[bool]) -> Result<(), Crowded> {
        assert_eq!(present.len(), self.present_walls.len(), "one for each wall");
        let scene = self.scene.with_walls(present);
        let before = std::mem::replace(&mut self.scene, scene);
        let exposures = self.exposures.clone();
        if let Err(crowded) = self.restore(self.state.clone()) {
            self.scene = before;
            return Err(crowded);
        }
        self.exposures = exposures;
        self.present_walls.copy_from_slice(present);
        Ok(())
    }

    /// Whether no body that is there is in a wall, or would be in it if it were there: none of its disks touches it, and it
    /// does not pass between them. Of each disk so large a part of the radius counts.
    pub fn is_free(&self, wall: WallId, part: f64) -> bool {
        let (scene, poses) = (&self.scene, &self.state.poses);
        let faces = &scene.faces[scene.wall_faces[wall.index()].clone()];
        let near = |at: Vec2, radius: f64| {
            faces.iter().any(|face| (nearest_on_face(face, at).0 - at).norm() < radius)
        };
        let is_in = |(b, body): (usize, &Body)| {
            if !self.present[b] || !near(poses[b].position, body.bounding_radius) {
                return false;
            }
            let disk = |d: usize| (scene.centre(DiskId::from(d), poses), part * scene.disks[d].radius);
            let disks: Vec<(Vec2, f64)> = body.disks.clone().map(disk).collect();
            faces.iter().any(|face| body_meets(&disks, face.start, face.end))
        };
        !scene.bodies.iter().enumerate().any(is_in)
    }

    /// Returns whether a body at a pose would touch no wall and nobody who is there; and at a line that it passes on the way,
    /// nobody who is beyond it.
    fn has_room(&self, body: BodyId, pose: Pose, line: Vec2) -> bool {
        let (scene, poses) = (&self.scene, &self.state.poses);
        let disk = |d: usize, pose: Pose| {
            (pose.position + rotation(pose.orientation) * scene.disks[d].offset, scene.disks[d].radius)
        };
        let disks = |b: usize, pose: Pose| scene.bodies[b].disks.clone().map(move |d| disk(d, pose));
        let own = |pose: Pose| disks(body.index(), pose).collect::<Vec<_>>();
        let there = |b: &usize| self.present[*b] && *b != body.index();
        let other = |b: usize| (poses[b].position, scene.bodies[b].bounding_radius, disks(b, poses[b]));
        let others = || (0..poses.len()).filter(there).map(other);
        let beyond = others().filter(|(at, ..)| (at - line).dot(&(pose.position - line)) > 0.0);
        let walls = scene.wall_faces.iter().zip(&self.present_walls).filter(|(_, is_there)| **is_there);
        let faces = walls.flat_map(|(faces, _)| &scene.faces[faces.clone()]);
        plane::has_room(pose.position, &own(pose), faces.map(|face| [face.start, face.end]), others())
            && plane::has_room(line, &own(Pose { position: line, ..pose }), std::iter::empty(), beyond)
    }

    /// Puts bodies elsewhere, one after the other, if they have room there, and at a line that they pass on the way: people who
    /// change the floor. Their contacts end; the [`World::exposures`] stay.
    ///
    /// # Errors
    /// More pairs are near each other than the limit of memory allows. The world is then unchanged.
    pub fn relocate(&mut self, moved: &[(BodyId, Motion, Vec2)]) -> Result<(), Crowded> {
        if moved.is_empty() {
            return Ok(());
        }
        let before = self.state.clone();
        for (body, Motion { pose, twist }, line) in moved {
            if self.has_room(*body, *pose, *line) {
                let b = body.index();
                (self.state.poses[b], self.state.twists[b]) = (*pose, *twist);
            }
        }
        if self.state.poses == before.poses {
            return Ok(());
        }
        let exposures = self.exposures.clone();
        let state = std::mem::replace(&mut self.state, before);
        self.restore(state)?;
        self.exposures = exposures;
        Ok(())
    }

    /// Shares the work among this number of threads, of a pool that belongs to this world and its clones. The results
    /// are the same for any number, to the last bit.
    ///
    /// At most as many threads are started as there are blocks of 512 bodies, and at most [`MOST_THREADS`]. For one
    /// block none is started: to hand work over would cost more than it saves.
    ///
    /// # Errors
    /// The system cannot start them. The world then works as before.
    pub fn set_threads(&mut self, count: usize) -> Result<(), ThreadsError> {
        let count = count.min(self.blocks.blocks.len()).clamp(1, MOST_THREADS);
        if count != self.threads.count() {
            self.threads = Threads::new(count)?;
        }
        Ok(())
    }

    /// Uses the threads of another world, because it takes longer to start new ones.
    pub fn share_threads(&mut self, other: &World) {
        self.threads = other.threads.clone();
    }

    /// The number of threads that do the work.
    pub fn threads(&self) -> usize {
        self.threads.count()
    }

    /// The number of communication steps that several threads have shared since the world was made.
    pub fn shared(&self) -> u64 {
        self.shared
    }

    /// The contacts in the present state.
    pub fn contacts(&self) -> &ContactReport {
        &self.contacts
    }

    /// \[m/s²\], \[rad/s²\] the accelerations of a body in the present state under the present drive (PHYSICS: the
    /// equations of motion).
    pub fn acceleration(&self, body: BodyId) -> Wrench {
        let b = body.index();
        let (of, pose, twist) = (&self.scene.bodies[b], &self.state.poses[b], &self.state.twists[b]);
        let (contacts, drive) = (&self.contacts.bodies[b].wrench, &self.drive[b]);
        Wrench {
            force: (contacts.force + drive.force) * of.inverse_mass
                + of.by_floor(pose.orientation, twist.velocity)
                + self.scene.pull(pose.position),
            torque: (contacts.torque + drive.torque) * of.inverse_inertia
                - twist.angular_velocity * of.rotation_rate,
        }
    }

    /// Returns what the contacts did to each body during the last communication step.
    pub fn exposures(&self) -> &[Exposure] {
        &self.exposures.bodies
    }

    /// Returns what bodies did to each face of a wall in the last communication step. A corner belongs to the face that
    /// has the contact in [`World::contacts`].
    pub fn face_exposures(&self) -> &[FaceExposure] {
        &self.exposures.faces
    }

    /// Returns the same of each panel of the walls that have some ([`Scene::with_panels`]), from the start of a wall to its
    /// end. A contact belongs to the panel, on the straight stretch of its face, that is nearest to the disk's
    /// centre.
    pub fn panel_exposures(&self) -> &[FaceExposure] {
        &self.exposures.panels
    }

    /// Returns the load on each chest in the last communication step; empty if no chest is watched ([`Levels::new`](super::Levels::new)).
    pub fn chest_exposures(&self) -> &[ChestExposure] {
        &self.exposures.chests
    }

    /// Returns what presses each body together in the present state: its contacts, over its extent. They are found when
    /// somebody asks.
    pub fn compressions(&self) -> &[Compression] {
        self.compressions.get_or_init(|| compressions(&self.scene, &self.state, &self.contacts))
    }

    /// \[N/m\] Returns mean and peak load of a panel, over its length; 0 if there is no such panel, or it has no length.
    pub fn panel_loads(&self, panel: usize) -> (f64, f64) {
        let seen = self.exposures.panels.get(panel).zip(self.scene.panels.lengths.get(panel));
        let seen = seen.filter(|(_, length)| **length > 0.0);
        let over = |force: f64, length: &f64| (force / length).clamp(-f64::MAX, f64::MAX);
        seen.map_or((0.0, 0.0), |(of, length)| (over(of.mean_force, length), over(of.peak_force, length)))
    }

    /// Returns what the contacts did in the last communication step, to save it.
    pub fn all_exposures(&self) -> &Exposures {
        &self.exposures
    }

    /// \[m\] the deepest overlap during the last communication step; zero without contacts.
    pub fn largest_overlap(&self) -> f64 {
        self.exposures().iter().map(|exposure| exposure.peak_overlap).fold(0.0, f64::max)
    }

    /// Work done since the world was made.
    pub fn work(&self) -> &Work {
        &self.work
    }

    /// Puts the world into a state of the same scene. From there on it gives the same bits as the world from which
    /// the state was taken, if the same bodies and walls are there.
    ///
    /// The [`World::exposures`] are not part of a state. They are then those of the contacts at this time. Whether pairs are
    /// too many may depend on when they were listed; then one world goes on and the other does not.
    ///
    /// # Errors
    /// More pairs are near each other than the limit of memory allows. The world is then unchanged.
    pub fn restore(&mut self, mut state: State) -> Result<(), Crowded> {
        let (scene, present, blocks) = (&self.scene, &self.present, &mut self.blocks);
        blocks.load(scene, &state);
        for (b, (pose, twist)) in state.poses.iter().zip(&state.twists).enumerate() {
            blocks.put(b, *pose, *twist);
        }
        let alone = Threads::default();
        blocks.forget_candidates();
        blocks.margins.fill(0.0);
        blocks.list(scene, &alone, |b| present[b])?;
        blocks.renew(scene, &alone, Renewed::All);
        // Finds which pairs touch and how deeply; the forces are not used.
        blocks.evaluate(scene, &alone, SpringUpdate::Hold, 0.0, |_, bodies| {
            bodies
                .flown
                .iter_mut()
                .zip(bodies.loads)
                .for_each(|(flown, load)| flown.exposure_sum.add(&std::mem::take(load), 0.0));
            [0.0; 2]
        });
        blocks.take_work();
        self.contacts = blocks.report(scene);
        self.came = false;
        self.compressions.take();
        // As after a step of duration zero.
        self.exposures = blocks.exposures(scene, 0.0, &self.contacts);
        blocks.store(&mut state);
        self.state = state;
        Ok(())
    }

    /// Like [`World::restore`], with the exposures of the step that ended in this state, one for each body, face and panel.
    ///
    /// # Errors
    /// Those of [`World::restore`].
    pub fn restore_with(&mut self, state: State, exposures: Exposures) -> Result<(), Crowded> {
        assert_eq!(exposures.counts(), self.exposures.counts(), "one exposure for each body, face and panel");
        self.restore(state)?;
        self.exposures = exposures;
        Ok(())
    }

    /// Advances by one communication step of a duration H \[s\], in mechanical steps of equal length.
    ///
    /// # Errors
    /// See [`AdvanceError`]. The world is then unchanged.
    pub fn advance(&mut self, duration: f64) -> Result<(), AdvanceError> {
        self.advance_on(duration, 0.0)
    }

    /// Advances by a part of a communication step, of which `so_far` \[s\] are over: the [`World::exposures`] are then
    /// those of the whole of it. Otherwise the same as [`World::advance`] by the part.
    ///
    /// # Errors
    /// See [`AdvanceError`]. The world is then unchanged.
    pub fn advance_on(&mut self, duration: f64, so_far: f64) -> Result<(), AdvanceError> {
        let steps = step_count(duration, self.mechanical_step)?;
        if steps > MOST_STEPS {
            return Err(AdvanceError::TooManySteps { duration, mechanical_step: self.mechanical_step });
        }
        if self.came {
            // Who touches those who have come must be known, as in a world that is restored.
            let exposures = self.exposures.clone();
            self.restore(self.state.clone())?;
            self.exposures = exposures;
        }
        let held = self.drive_rate.iter().all(|rate| *rate == Wrench::default());
        let slopes = self.scene.slopes.clone();
        let state = if !slopes.is_empty() {
            let drives = ramps(&self.scene, &self.drive, &self.drive_rate).into_iter();
            let drives: Vec<OnSlopes> = drives.map(|drive| OnSlopes { drive, slopes: &slopes }).collect();
            self.moved(&drives, duration, steps)?
        } else if held {
            self.moved(&held_drives(&self.scene, &self.drive), duration, steps)?
        } else {
            self.moved(&ramps(&self.scene, &self.drive, &self.drive_rate), duration, steps)?
        };
        let finite = |b: &usize| {
            let (pose, twist) = (&state.poses[*b], &state.twists[*b]);
            pose.position.is_finite()
                && pose.orientation.is_finite()
                && twist.velocity.is_finite()
                && twist.angular_velocity.is_finite()
        };
        if let Some(b) = (0..state.poses.len()).find(|b| !finite(b)) {
            return Err(AdvanceError::NotFinite { body: BodyId::from(b) });
        }
        let contacts = self.blocks.report(&self.scene);
        // Report forces that are not finite now, not in the next step.
        if let Some(body) = contacts.not_finite(&self.scene) {
            return Err(AdvanceError::NotFinite { body });
        }
        let mut exposures = self.blocks.exposures(&self.scene, duration, &contacts);
        if so_far > 0.0 {
            exposures.come_after(so_far, &self.exposures, duration);
        }
        let of_bodies = exposures.bodies.iter().position(|exposure| !exposure.is_finite());
        if let Some(b) = of_bodies.or_else(|| exposures.chests.iter().position(|chest| !chest.is_finite())) {
            return Err(AdvanceError::NotFinite { body: BodyId::from(b) });
        }
        self.contacts = contacts;
        self.compressions.take();
        self.exposures = exposures;
        self.state = state;
        Ok(())
    }

    /// What is known of each body before it is decided who is free in a communication step of so many mechanical steps: who
    /// touches somebody or a wall is not, and nobody is if the mechanical steps of all others cost less than to decide.
    fn activity(&self, steps: u64) -> Vec<Activity> {
        let of = |present: &bool| if *present { Activity::Free } else { Activity::Absent };
        let mut activity: Vec<Activity> = self.present.iter().map(of).collect();
        for contact in &self.contacts.contacts {
            let disks = match contact.pair {
                Pair::Disks { first, second } => [first, second],
                Pair::Face { disk, .. } => [disk; 2],
            };
            let bodies = disks.map(|disk| self.scene.body_of(disk).index());
            // Contacts of those who have left since are still there.
            if bodies.iter().all(|b| self.present[*b]) {
                bodies.iter().for_each(|b| activity[*b] = Activity::Active);
            }
        }
        let count = |of: Activity| activity.iter().filter(|activity| **activity == of).count() as u64;
        let (free, active) = (count(Activity::Free), count(Activity::Active));
        if self.shortlisting == Shortlisting::Off
            || free.saturating_mul(steps) < SHORTLIST_FROM * (free + active)
        {
            let there = activity.iter_mut().filter(|activity| **activity == Activity::Free);
            there.for_each(|activity| *activity = Activity::Active);
        }
        activity
    }

    /// Computes the state after a communication step under drives of one kind.
    fn moved<D: Course>(&mut self, drives: &[D], duration: f64, steps: u64) -> Result<State, Crowded> {
        let alone = Threads::default();
        let there = self.present.iter().filter(|there| **there).count();
        let threads =
            if there + 2 * self.contacts.contacts.len() >= self.share_from { &self.threads } else { &alone };
        let (scene, activity) = (&self.scene, self.activity(steps));
        let decide = || Shortlist::decide(scene, &self.state, activity, drives, duration, threads);
        let shortlist = threads.enter(decide);
        let active = shortlist.activity.iter().filter(|activity| **activity == Activity::Active).count();
        let work = active + 2 * self.contacts.contacts.len();
        let threads = if work >= self.share_from { &self.threads } else { &alone };
        self.shared += u64::from(threads.count() > 1);
        let step = CommunicationStep {
            scene: &self.scene,
            threads,
            start: &self.state,
            drives,
            shortlist,
            blocks: &mut self.blocks,
            work: &mut self.work,
            mechanical: Step::new(&self.scene, duration / steps as f64),
            movers: Vec::new(),
            flights: Vec::new(),
            across: Vec::new(),
            leeway: 0.0,
            leeway_then: 0.0,
            expected: Expected::default(),
            watch: Watch::new(),
            awoken_at: Vec::new(),
        };
        let state = threads.enter(|| step.run(steps));
        self.work = [self.work, self.blocks.take_work()].into_iter().sum();
        state
    }
}

#[cfg(test)]
mod tests;
