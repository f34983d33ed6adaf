//! The world: owns scene, drive and state, and advances them.

use super::blocks::Flown;
use super::contacts::{ContactReport, Stretch};
use super::free_flight::Drive;
use super::mechanical_step::{CommunicationStep, Scratch, held_drives, ramps};
use super::neighbours::{CellGrid, Circle, Crowded, Near, SKIN};
use super::shortlist::{Activity, Shortlist};
use super::{BodyId, Exposure, Scene, Shortlisting, State, Threads, ThreadsError, Work, Wrench};
use thiserror::Error;

/// More mechanical steps than this in one communication step are refused: they would never end.
const MOST_STEPS: f64 = 1e12;

/// See [`World::share_from`]. A step of so much work takes some 20 µs; handing it over takes some of them.
const SHARE_FROM: usize = 1800;

/// More threads than this are not started, however many somebody asks for.
pub const MOST_THREADS: usize = 64;

/// How far H / TimeStepMechanical may exceed an integer and still be it: communication steps come with
/// rounding errors from other people's arithmetic.
const STEP_COUNT_TOLERANCE: f64 = 1e-9;

/// Why a step was refused or failed; the world is as it was before.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum AdvanceError {
    /// The communication step is not a positive finite number.
    #[error("a communication step of {0:?} s: must be positive and finite")]
    Duration(f64),
    /// The communication step holds absurdly many mechanical steps.
    #[error(
        "a communication step of {duration:?} s at a mechanical step of {mechanical_step:?} s takes too many steps"
    )]
    TooManySteps {
        /// \[s\]
        duration: f64,
        /// \[s\]
        mechanical_step: f64,
    },
    /// The motion of a body, or a force on it, is no longer a finite number: the mechanical step is too long, or forces are absurd.
    #[error("its motion is no longer finite: is the mechanical step short enough?")]
    NotFinite {
        /// Which.
        body: BodyId,
    },
    /// More pairs come near each other than are held in memory.
    #[error(transparent)]
    Crowded(#[from] Crowded),
}

/// The number of mechanical steps in a communication step: the smallest n with
/// `duration / n ≤ mechanical_step` up to rounding.
///
/// # Errors
/// A duration that is not positive and finite, or absurdly many steps.
pub fn step_count(duration: f64, mechanical_step: f64) -> Result<u64, AdvanceError> {
    if !(duration > 0.0 && duration.is_finite()) {
        return Err(AdvanceError::Duration(duration));
    }
    let ratio = duration / mechanical_step;
    if ratio > MOST_STEPS || ratio.is_nan() {
        return Err(AdvanceError::TooManySteps { duration, mechanical_step });
    }
    let nearest = libm::round(ratio);
    let steps = if ratio - nearest <= STEP_COUNT_TOLERANCE * nearest { nearest } else { libm::ceil(ratio) };
    Ok(steps.max(1.0) as u64)
}

/// Scene, drive and state; advanced by [`World::advance`].
#[derive(Debug, Clone)]
pub struct World {
    scene: Scene,
    state: State,
    /// F_p and M_p of each body when a communication step begins; held over it where `drive_rate` is zero.
    pub drive: Vec<Wrench>,
    /// \[N/s\], \[N.m/s\] how F_p and M_p of each body change during a communication step; zero at first.
    ///
    /// A time t into the step the drive is `drive + drive_rate·t`. [`World::advance`] changes neither of
    /// them, so a rate acts in every step until it is set back, from `drive` anew each time. Like the drive
    /// it is no part of the [`State`].
    pub drive_rate: Vec<Wrench>,
    /// \[s\] positive; the longest mechanical step.
    pub mechanical_step: f64,
    /// Whether bodies that can touch nothing are moved by the closed form.
    pub shortlisting: Shortlisting,
    /// Communication steps in which fewer bodies move by mechanical steps, twice the contacts added, are left
    /// to one thread, as it is when they begin; results do not depend on it.
    pub share_from: usize,
    threads: Threads,
    /// Communication steps that threads have shared.
    shared: u64,
    contacts: ContactReport,
    exposures: Vec<Exposure>,
    work: Work,
    scratch: Scratch,
}

impl World {
    /// A world at a state, without drive.
    ///
    /// The state has one pose and one twist for each body; springs of pairs that do not touch are dropped.
    ///
    /// # Errors
    /// More pairs are near each other than are held in memory.
    pub fn new(scene: Scene, state: State, mechanical_step: f64) -> Result<World, Crowded> {
        assert_eq!(state.poses.len(), scene.bodies.len(), "one pose for each body");
        assert_eq!(state.twists.len(), scene.bodies.len(), "one twist for each body");
        let mut world = World {
            drive: vec![Wrench::default(); scene.bodies.len()],
            drive_rate: vec![Wrench::default(); scene.bodies.len()],
            scratch: Scratch::new(&scene),
            mechanical_step,
            shortlisting: Shortlisting::On,
            share_from: SHARE_FROM,
            threads: Threads::default(),
            shared: 0,
            contacts: ContactReport::default(),
            exposures: Vec::new(),
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

    /// Shares the work out to so many threads, of a pool that this world and its clones own; results do not depend
    /// on it, to the last bit.
    ///
    /// No more are started than there are blocks of 512 bodies, nor than [`MOST_THREADS`], and none where there is one
    /// block: handing work over would cost more than it saves.
    ///
    /// # Errors
    /// The system does not give them; the world works on as it did.
    pub fn set_threads(&mut self, count: usize) -> Result<(), ThreadsError> {
        let count = count.min(self.scratch.blocks.blocks.len()).clamp(1, MOST_THREADS);
        if count != self.threads.count() {
            self.threads = Threads::new(count)?;
        }
        Ok(())
    }

    /// Works with the threads of another world: starting new ones takes longer.
    pub fn share_threads(&mut self, other: &World) {
        self.threads = other.threads.clone();
    }

    /// How many threads do the work.
    pub fn threads(&self) -> usize {
        self.threads.count()
    }

    /// How many communication steps threads have shared since the world was made.
    pub fn shared(&self) -> u64 {
        self.shared
    }

    /// The contacts at the present state.
    pub fn contacts(&self) -> &ContactReport {
        &self.contacts
    }

    /// What the contacts did to each body during the last communication step.
    pub fn exposures(&self) -> &[Exposure] {
        &self.exposures
    }

    /// \[m\] the deepest overlap during the last communication step; zero without contacts.
    pub fn largest_overlap(&self) -> f64 {
        self.exposures.iter().map(|exposure| exposure.peak_overlap).fold(0.0, f64::max)
    }

    /// Work done since the world was made.
    pub fn work(&self) -> &Work {
        &self.work
    }

    /// Puts the world into a state of the same scene; run on, it gives the same bits as the world that
    /// the state was taken from.
    ///
    /// The [`World::exposures`] are no part of a state: they are those of its instant then.
    ///
    /// # Errors
    /// More pairs are near each other than are held in memory; nothing has changed then.
    pub fn restore(&mut self, mut state: State) -> Result<(), Crowded> {
        let (scene, blocks) = (&self.scene, &mut self.scratch.blocks);
        blocks.load(scene, &state);
        let mut circles = Vec::with_capacity(state.poses.len());
        for (b, (pose, twist)) in state.poses.iter().zip(&state.twists).enumerate() {
            blocks.put(b, *pose, *twist);
            circles.push(Circle { centre: pose.position, radius: scene.bodies[b].bounding_radius });
        }
        let (grid, alone) = (CellGrid::new(&circles, 0..circles.len(), SKIN), Threads::default());
        blocks.list(scene, &alone, &grid, &circles, |_| true)?;
        blocks.renew(scene, &alone, Near::default());
        // Finds out which pairs touch, and how deeply; the forces are not wanted.
        blocks.evaluate(scene, &alone, Stretch::Hold, |_, bodies| {
            bodies.flown.iter_mut().zip(bodies.loads).for_each(|(flown, load)| flown.tally.add(load, 0.0));
            0.0
        });
        blocks.take_work();
        self.contacts = blocks.report(scene);
        // What a step of no duration would show.
        self.exposures = exposures(&blocks.flown, 0.0, &self.contacts);
        blocks.store(&mut state);
        self.state = state;
        Ok(())
    }

    /// As [`World::restore`], with the exposures of the step that ended there, one for each body.
    ///
    /// # Errors
    /// As [`World::restore`].
    pub fn restore_with(&mut self, state: State, exposures: Vec<Exposure>) -> Result<(), Crowded> {
        assert_eq!(exposures.len(), self.scene.bodies.len(), "one exposure for each body");
        self.restore(state)?;
        self.exposures = exposures;
        Ok(())
    }

    /// Advances by one communication step of a duration H \[s\], in mechanical steps of equal length.
    ///
    /// # Errors
    /// [`AdvanceError`]; nothing has changed then.
    pub fn advance(&mut self, duration: f64) -> Result<(), AdvanceError> {
        let steps = step_count(duration, self.mechanical_step)?;
        let held = self.drive_rate.iter().all(|rate| *rate == Wrench::default());
        let state = if held {
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
        let contacts = self.scratch.blocks.report(&self.scene);
        // Forces that the next step would find absurd.
        if let Some(body) = contacts.not_finite(&self.scene) {
            return Err(AdvanceError::NotFinite { body });
        }
        let exposures = exposures(&self.scratch.blocks.flown, duration, &contacts);
        if let Some(b) = exposures.iter().position(|exposure| !exposure.is_finite()) {
            return Err(AdvanceError::NotFinite { body: BodyId::from(b) });
        }
        self.contacts = contacts;
        self.exposures = exposures;
        self.state = state;
        Ok(())
    }

    /// The state after a communication step under drives of one kind.
    fn moved<D: Drive>(&mut self, drives: &[D], duration: f64, steps: u64) -> Result<State, Crowded> {
        let shortlist = Shortlist::decide(&self.scene, &self.state, drives, duration, self.shortlisting);
        let active = shortlist.activity.iter().filter(|activity| **activity == Activity::Active).count();
        let alone = Threads::default();
        let work = active + 2 * self.contacts.contacts.len();
        let threads = if work >= self.share_from { &self.threads } else { &alone };
        self.shared += u64::from(threads.count() > 1);
        let step = CommunicationStep {
            scene: &self.scene,
            threads,
            start: &self.state,
            drives,
            shortlist,
            scratch: &mut self.scratch,
            work: &mut self.work,
            dt: duration / steps as f64,
            movers: Vec::new(),
            flights: Vec::new(),
            leeway: 0.0,
            listed: 0,
        };
        let state = threads.enter(|| step.run(steps));
        self.work = [self.work, self.scratch.blocks.take_work()].into_iter().sum();
        state
    }
}

/// What was added up over a duration \[s\]; at its end the contacts are these.
fn exposures(bodies: &[Flown], duration: f64, contacts: &ContactReport) -> Vec<Exposure> {
    let bodies = bodies.iter().zip(&contacts.bodies);
    bodies.map(|(flown, body)| flown.tally.exposure(duration, body.squeeze)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{BodySpec, DiskSpec, LawTable, PairLaw, Pose, Twist, vec2};

    /// Two equal and opposite forces that move nobody: their sum of sizes is beyond all numbers.
    #[test]
    fn a_squeeze_beyond_all_numbers_is_an_error_and_changes_nothing() {
        let mut laws = LawTable::new(1);
        let (stiffness, none) = (1e308, 0.0);
        laws.set(
            0,
            0,
            PairLaw {
                normal_stiffness: stiffness,
                tangential_stiffness: stiffness,
                normal_damping: none,
                tangential_damping: none,
                friction: none,
            },
        );
        let body = BodySpec {
            mass: 1e300,
            inertia: 1.0,
            translation_rate: 0.0,
            rotation_rate: 0.0,
            disks: vec![DiskSpec { radius: 1.0, position: vec2(0.0, 0.0), material: 0 }],
        };
        let scene = Scene::new(&[body.clone(), body.clone(), body], &[], &laws).unwrap();
        let poses = [-1.0, 0.0, 1.0].map(|x| Pose { position: vec2(x, 0.0), orientation: 0.0 });
        let mut world =
            World::new(scene, State::new(poses.to_vec(), vec![Twist::default(); 3]), 1e-12).unwrap();
        let before = world.state().clone();
        assert_eq!(world.advance(1e-12), Err(AdvanceError::NotFinite { body: BodyId(1) }));
        assert_eq!(*world.state(), before);
    }

    /// Three thousand grains fly to one point, where there are 4.5 million pairs of them.
    #[test]
    fn who_come_together_in_thousands_are_an_error_and_change_nothing() {
        let mut laws = LawTable::new(1);
        let law = PairLaw {
            normal_stiffness: 1.0,
            tangential_stiffness: 1.0,
            normal_damping: 0.0,
            tangential_damping: 0.0,
            friction: 0.0,
        };
        laws.set(0, 0, law);
        let body = BodySpec {
            mass: 1e3,
            inertia: 1.0,
            translation_rate: 0.0,
            rotation_rate: 0.0,
            disks: vec![DiskSpec { radius: 1e-3, position: vec2(0.0, 0.0), material: 0 }],
        };
        let scene = Scene::new(&vec![body; 3000], &[], &laws).unwrap();
        let out = |k: i32| vec2(100.0, 0.0).rotated(crate::engine::Rotation::by(f64::from(k) * 0.002));
        let poses = (0..3000).map(|k| Pose { position: out(k), orientation: 0.0 }).collect();
        let twists = (0..3000).map(|k| Twist { velocity: -out(k), angular_velocity: 0.0 }).collect();
        let mut world = World::new(scene, State::new(poses, twists), 0.1).unwrap();
        world.advance(0.5).unwrap();
        let before = world.state().clone();
        let Err(AdvanceError::Crowded(crowded)) = world.advance(0.5) else { panic!("all were held") };
        assert_eq!((crowded.others, crowded.faces, crowded.most), (2999, 0, 2_000_000));
        assert_eq!(*world.state(), before);
        // It goes on as if nothing had been.
        world.advance(0.2).unwrap();
    }

    #[test]
    fn step_counts_are_integers() {
        assert_eq!(step_count(0.02, 1e-5), Ok(2000));
        assert_eq!(step_count(0.099_999_999_999_999_98, 1e-5), Ok(10_000));
        assert_eq!(step_count(0.100_000_000_000_000_03, 1e-5), Ok(10_000));
        assert_eq!(step_count(0.1, 0.03), Ok(4));
        assert_eq!(step_count(1e-7, 1e-5), Ok(1));
        assert!(step_count(0.0, 1e-5).is_err());
        assert!(step_count(-0.1, 1e-5).is_err());
        assert!(step_count(f64::NAN, 1e-5).is_err());
        assert!(step_count(1e300, 1e-5).is_err());
    }
}
