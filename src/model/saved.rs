//! The crowd's part of FMI's "FMU state": saving and restoring.

use super::CrowdModel;
use super::output::make_directory;
use super::packed::{Drive, Packed};
use super::running::give_threads;
use super::settings::Settings;
use crate::engine::{BodyId, ChestExposure, Exposure, Exposures, FaceExposure, State, World, Wrench};
use crate::quantities::{CrowdQuantity, shared};
use crate::setup::Setup;
use lemons_core::plane::InPlane;
use lemons_core::trial::Trial;
use lemons_fmi::variables::Domain;
use lemons_fmi::{Answer, damaged, refuse};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// The complete state of a crowd, without the location of its resources.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SavedCrowd {
    trial: String,
    fingerprint: u128,
    settings: Settings,
    running: Option<Running>,
}

/// The state that determines the future of a running world.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Running {
    drive: Vec<Wrench>,
    /// Places of the agents whom the packed drive drives. What it says follows from the time.
    played: BTreeSet<usize>,
    /// Fingerprint of the packed drive, if it drives anybody.
    packed_drive: Option<String>,
    present: Vec<bool>,
    /// Who has been switched on or off since the last step.
    moved: BTreeSet<usize>,
    /// Of each wall; one that closes may wait for somebody.
    present_walls: Vec<bool>,
    state: State,
    /// Outputs; the future does not depend on them.
    exposures: Exposures,
}

impl CrowdModel {
    pub(super) fn saved(&self) -> SavedCrowd {
        SavedCrowd {
            trial: self.packed.trial.name.clone(),
            fingerprint: self.packed.fingerprint,
            settings: self.settings.clone(),
            running: self.running(),
        }
    }

    /// Returns the state of the running world.
    pub(super) fn running(&self) -> Option<Running> {
        let world = self.world.as_ref()?;
        let drive = self.packed.drive.get().filter(|_| !self.played.is_empty());
        Some(Running {
            drive: world.drive.clone(),
            played: self.played.clone(),
            packed_drive: drive.map(|drive| drive.fingerprint.clone()),
            moved: self.moved.clone(),
            present: world.present().to_vec(),
            present_walls: world.present_walls().to_vec(),
            state: world.state().clone(),
            exposures: world.all_exposures().clone(),
        })
    }

    /// Puts a new world into a state that fits it.
    pub(super) fn run_on(&self, world: &mut World, running: &Running, threads: i32) -> Answer<()> {
        give_threads(world, threads, self.world.as_ref())?;
        let bodies = running.present.iter().enumerate();
        bodies.for_each(|(b, &present)| world.set_present(BodyId::from(b), present));
        let crowded = |_| damaged("more agents in one place than can be held");
        if running.present_walls != world.present_walls() {
            world.set_present_walls(&running.present_walls).or_else(crowded)?;
        }
        world.restore_with(running.state.clone(), running.exposures.clone()).or_else(crowded)?;
        world.drive.clone_from(&running.drive);
        Ok(())
    }

    /// Restores a state. After an error nothing has changed.
    pub(super) fn go_back(&mut self, saved: &SavedCrowd) -> Answer<()> {
        let packed = if saved.trial == self.packed.trial.name {
            self.packed.clone()
        } else {
            // Another name might lead out of the resources.
            self.known_trial(&saved.trial)?;
            Packed::load(&self.resources, &saved.trial)?.0
        };
        let fits = self.any_size || shared(&packed.trial) == shared(&self.packed.trial);
        if packed.fingerprint != saved.fingerprint || !fits {
            return other_trial(&saved.trial);
        }
        let settings = &saved.settings;
        let Some(mut trial) = settings.applied_to(&packed.trial) else {
            return damaged("a setting of an unknown variable");
        };
        let good = |(quantity, value): (CrowdQuantity, f64)| quantity.row().domain.check(value).is_ok();
        if !settings.elements.iter().all(|((quantity, _), value)| good((*quantity, *value))) {
            return damaged("a setting out of its domain");
        }
        if !settings.rates.iter().all(|(&i, rate)| i < packed.trial.agents.len() && finite(rate)) {
            return damaged("a rate of an unknown agent, or one that is not finite");
        }
        if settings.threads < 1 || settings.intermediate_steps < 0 || settings.output_directory.contains('\0')
        {
            return damaged("a number of threads or an OutputDirectory that cannot be set");
        }
        if Domain::Positive.check(settings.most_steps).is_err() {
            return damaged("a MostMechanicalSteps that cannot be set");
        }
        if settings.tolerance.is_some_and(|tolerance| Domain::Positive.check(tolerance).is_err()) {
            return damaged("a tolerance that is not possible");
        }
        settings.choose_step(&mut trial, &packed.trial);
        let world = match &saved.running {
            None => None,
            Some(running) => {
                let mut world = Setup::of(&trial).world()?;
                check_running(&world, &trial, running)?;
                if !running.played.is_empty() {
                    check_played(&packed, packed.drive(&self.resources)?, running)?;
                }
                self.run_on(&mut world, running, settings.threads)?;
                Some(world)
            }
        };
        if world.is_some() {
            make_directory(&settings.output_directory)?;
        }
        (self.packed, self.trial, self.world, self.tuned) = (packed, trial, world, false);
        self.said_coincident = self.first_coincident();
        self.moved = saved.running.as_ref().map(|running| running.moved.clone()).unwrap_or_default();
        self.settings.clone_from(settings);
        self.played = saved.running.as_ref().map(|running| running.played.clone()).unwrap_or_default();
        Ok(())
    }
}

/// Checks that a state from outside fits the scene, before the engine uses its indices.
fn check_running(world: &World, trial: &Trial, running: &Running) -> Answer<()> {
    let (scene, state) = (world.scene(), &running.state);
    let bodies = scene.bodies.len();
    let (disks, faces) = (scene.disks.len(), scene.faces.len());
    let fits = state.poses.len() == bodies
        && state.twists.len() == bodies
        && running.moved.iter().all(|&i| i < bodies)
        && running.drive.len() == bodies
        && running.present.len() == bodies
        && running.present_walls.len() == trial.geometry.walls.len()
        && running
            .present_walls
            .iter()
            .zip(&trial.geometry.walls)
            .all(|(there, wall)| *there || wall.open.is_some())
        && running.exposures.counts() == world.all_exposures().counts()
        && state.disk_springs.iter().all(|s| s.first.index() < disks && s.second.index() < disks)
        && state.face_springs.iter().all(|s| s.disk.index() < disks && s.face.index() < faces);
    if !fits {
        return damaged("it does not fit the scene");
    }
    let positive = |number: f64| number >= 0.0 && number.is_finite();
    let exposed = |of: &Exposure| {
        let Exposure { mean_force, mean_wall_force, peak_force, peak_overlap } = *of;
        mean_wall_force <= mean_force
            && [mean_force, mean_wall_force, peak_force, peak_overlap].into_iter().all(positive)
    };
    let pressed = |of: &FaceExposure| [of.mean_force, of.peak_force].into_iter().all(positive);
    let pressed_chest =
        |of: &ChestExposure| of.is_finite() && positive(of.people_force) && positive(of.wall_force);
    let finite = running.drive.iter().all(finite)
        && running.exposures.bodies.iter().all(exposed)
        && running.exposures.faces.iter().all(pressed)
        && running.exposures.chests.iter().all(pressed_chest)
        && running.exposures.panels.iter().all(|of| of.mean_force.is_finite() && positive(of.peak_force))
        && state.poses.iter().all(|pose| pose.position.is_finite() && pose.orientation.is_finite())
        && state.twists.iter().all(|twist| twist.velocity.is_finite() && twist.angular_velocity.is_finite())
        && state.disk_springs.iter().all(|spring| spring.elongation.is_finite())
        && state.face_springs.iter().all(|spring| spring.elongation.is_finite());
    if finite { Ok(()) } else { damaged("a number that is not finite") }
}

/// Checks that a state from outside plays a drive of this Trial.
fn check_played(packed: &Packed, drive: &Drive, running: &Running) -> Answer<()> {
    let Packed { trial, .. } = packed;
    if running.packed_drive.as_ref() != Some(&drive.fingerprint) {
        return other_trial(&trial.name);
    }
    let driven = |i: &usize| trial.agents.get(*i).is_some_and(|agent| drive.table.rows(&agent.id).is_some());
    if running.played.iter().all(driven) {
        Ok(())
    } else {
        damaged("an agent whom the packed drive does not name")
    }
}

fn other_trial(name: &str) -> Answer<()> {
    refuse(format!(
        "the state belongs to another model: Trial {name:?} has changed since the state was saved"
    ))
}

fn finite(wrench: &Wrench) -> bool {
    wrench.force.is_finite() && wrench.torque.is_finite()
}
