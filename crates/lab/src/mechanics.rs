//! Materials, contacts and steps that a page has changed.

use crate::{Refused, require};
use crowd_mechanics::setup;
use lemons_core::files::source::Memory;
use lemons_core::message::Message;
use lemons_core::trial::{FileNames, Problem, Trial};
use lemons_people::PART_MATERIALS;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Most materials, and most contacts, that may be changed.
const MOST: usize = 1000;

/// Changed numbers of a Trial. What is not among them is as the Trial has it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(deny_unknown_fields)]
pub struct Mechanics {
    /// \[s\]
    time_step: Option<f64>,
    /// \[s\]
    time_step_mechanical: Option<f64>,
    materials: Vec<Material2d>,
    contacts: Vec<Contact<Option<f64>>>,
}

/// Both moduli \[N/m\] of a material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(deny_unknown_fields)]
pub(crate) struct Material2d {
    pub id: String,
    pub young_modulus: f64,
    pub shear_modulus: f64,
}

/// Both dampings \[kg/s\] of a contact, and its friction: `None` for that of the Trial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(deny_unknown_fields)]
pub(crate) struct Contact<F> {
    pub id1: String,
    pub id2: String,
    pub gamma_normal: f64,
    pub gamma_tangential: f64,
    pub kinetic_friction: F,
}

impl Mechanics {
    /// Changes the Trial, and returns the warnings about what can be changed so. A crowd is drawn by chance: what is changed of
    /// things that nobody has waits until somebody has them.
    ///
    /// # Errors
    /// A material or a contact is not there, or the Trial's files would have errors: those that their reader finds, with
    /// file, element, attribute and value.
    pub fn change(&self, trial: &mut Trial, of_crowd: bool) -> Result<Vec<Message>, Refused> {
        require(self.materials.len().max(self.contacts.len()) <= MOST, || {
            format!("at most {MOST} materials and contacts can be changed")
        })?;
        let waits = |id: &str| of_crowd && PART_MATERIALS.contains(&id);
        let parameters = &mut trial.parameters;
        parameters.time_step = self.time_step.unwrap_or(parameters.time_step);
        parameters.time_step_mechanical =
            self.time_step_mechanical.unwrap_or(parameters.time_step_mechanical);
        for Material2d { id, young_modulus, shear_modulus } in &self.materials {
            let found = trial.materials.intrinsic.iter_mut().find(|material| material.id == *id);
            if found.is_none() && waits(id) {
                continue;
            }
            let found = found.ok_or_else(|| Refused::from(format!("there is no material {id:?}")))?;
            (found.young_modulus, found.shear_modulus) = (*young_modulus, *shear_modulus);
        }
        for Contact { id1, id2, gamma_normal, gamma_tangential, kinetic_friction } in &self.contacts {
            let pair = [(id1, id2), (id2, id1)];
            let found =
                trial.materials.binary.iter_mut().find(|found| pair.contains(&(&found.id1, &found.id2)));
            if found.is_none() && (waits(id1) || waits(id2)) {
                continue;
            }
            let found =
                found.ok_or_else(|| Refused::from(format!("there is no contact of {id1:?} and {id2:?}")))?;
            (found.gamma_normal, found.gamma_tangential) = (*gamma_normal, *gamma_tangential);
            found.kinetic_friction = kinetic_friction.unwrap_or(found.kinetic_friction);
        }
        checked(trial)
    }
}

/// Reads the Trial as another program would.
fn checked(trial: &Trial) -> Result<Vec<Message>, Refused> {
    let (mut files, place) = (Memory::default(), Path::new(&trial.name));
    for (path, text) in trial.texts(place) {
        files.put(&path, text.into_bytes());
    }
    let (_, warnings) = setup::read_from(&files, place, &FileNames::default())?;
    let of_these = |file: &Path| file.ends_with("Parameters.xml") || file.ends_with("Materials.xml");
    Ok(warnings.iter().filter(|warning| of_these(&warning.file)).map(Problem::told).collect())
}
