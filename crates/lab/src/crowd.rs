//! A crowd: how many, of whom, in which room -> a Trial.

use crate::base::{Basis, Driven, split};
use crate::room::{self, REGION};
use crate::{Refused, require, within};
use lemons_core::plane::Vec2;
use lemons_core::trial::Contact;
use lemons_people::placing::{self, Ended, Method, Orientation, Packing, Region, TOLERANCE, Watch};
use lemons_people::room::Room;
use lemons_people::{
    Agent, CrowdStatistics, CustomMeasures, Disk, Kinds, PAPER_BICYCLES, Population, Proportions, Sex, Shape,
    Source, Survey, TrialSettings, TruncatedNormal, choose_mechanical_step, crowd_trial, heading,
};
use serde::Deserialize;
use serde_json::json;
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::path::Path;

/// Largest number of people: what a page can pack and show.
pub const MOST_PEOPLE: u32 = 5000;

/// Largest seed: the largest integer that a page's numbers hold exactly.
pub const LARGEST_SEED: u64 = (1 << 53) - 1;

/// A crowd. `lemons crowd` makes the same one, with the material's friction and without round bodies.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct CrowdRequest {
    /// How many; 1 to [`MOST_PEOPLE`].
    pub number: Option<u32>,
    /// \[1/m²\] Instead of the number.
    pub density: Option<f64>,
    /// The same seed gives the same crowd.
    pub seed: u64,
    /// Where they are.
    pub room: Room,
    /// \[m\] Corners of the part of the room where they are placed.
    pub region: Option<Vec<[f64; 2]>>,
    /// Whom they are drawn from.
    pub people: People,
    /// Shares of kinds of people, which need not sum up to 100; empty: adults with nothing.
    #[serde(default)]
    pub mix: BTreeMap<String, f64>,
    /// Probability that a person is a man.
    pub men: f64,
    /// \[°\] Which way people face at first, -360 to 360; `None`: any.
    pub direction: Option<f64>,
    /// \[m/s\] The speed at which each would walk alone, in this direction.
    pub speed: f64,
    /// The material of everybody: one of [`lemons_people::SKINS`].
    pub material: String,
    /// Kinetic friction of people with each other and with walls instead of the material's, 0 to 2.
    #[serde(default)]
    pub friction: Option<f64>,
    /// Whether each body is one disk, of the same area.
    #[serde(default)]
    pub round: bool,
}

/// Largest coefficient of kinetic friction.
const MOST_FRICTION: f64 = 2.0;

/// Whom people are drawn from.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
#[allow(missing_docs)] // as said
pub enum People {
    /// The statistics of the survey ANSUR II.
    Survey,
    /// One's own statistics, with the rank correlations of that survey.
    Statistics { male: Box<Four>, female: Box<Four> },
    /// The people of tables as that survey has them: sex, name and length of each. The bytes are their contents.
    Table { files: Vec<(Sex, String, usize)> },
}

/// The distribution of each measure: mean, standard deviation, smallest, largest value \[m, kg\].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[allow(missing_docs)]
pub struct Four {
    pub breadth: [f64; 4],
    pub depth: [f64; 4],
    pub stature: [f64; 4],
    pub mass: [f64; 4],
}

impl Four {
    fn of(self, sex: Sex) -> CustomMeasures {
        let Four { breadth, depth, stature, mass } = self;
        let measures = [breadth, depth, stature, mass].map(TruncatedNormal::from);
        CustomMeasures { measures, ..CustomMeasures::paper(sex) }
    }
}

impl CrowdRequest {
    fn population(&self, bytes: &[u8]) -> Result<Population, Refused> {
        let source = match &self.people {
            People::Survey => Source::ansur()?,
            People::Statistics { male, female } => {
                Source::custom(&[male.of(Sex::Male), female.of(Sex::Female)])?
            }
            People::Table { files } => {
                let mut survey = Survey::default();
                let named: Vec<_> = files.iter().map(|(_, name, length)| (name.clone(), *length)).collect();
                for ((sex, ..), (name, content)) in files.iter().zip(split(&named, bytes)?) {
                    survey.add(*sex, Path::new(name), content)?;
                }
                Source::Survey(survey)
            }
        };
        let proportions = Proportions { men: self.men, ..Proportions::default() };
        let population = Population::new(source, proportions, PAPER_BICYCLES)?;
        if self.mix.is_empty() {
            return Ok(population);
        }
        let mix = Kinds::built_in()?.mix(&self.mix);
        Ok(population.mixed(mix.map_err(|error| Refused(format!("the mix of kinds: {error}")))?))
    }

    fn number(&self, region: &Region) -> Result<u32, Refused> {
        let number = match (self.number, self.density) {
            (Some(number), None) => f64::from(number),
            (None, Some(density)) => {
                (within("people per m²", density, [1e-3, 100.0])? * region.area()).round()
            }
            _ => return Err(Refused("give either the number of people or their density".into())),
        };
        if (1.0..=f64::from(MOST_PEOPLE)).contains(&number) {
            return Ok(number as u32);
        }
        Err(Refused(format!("{number} people: the number must be 1 to {MOST_PEOPLE}")))
    }
}

/// One disk of the same area.
pub(crate) fn round(shape: &Shape) -> Shape {
    let radius = (shape.moments().area / PI).sqrt();
    Shape { disks: vec![Disk { centre: Vec2::zeros(), radius }] }
}

/// Draws people and places them without overlap, as `lemons crowd --seed` does.
///
/// # Errors
/// A number is out of range, there is no room, or `watch` stopped the placing.
pub fn crowd(wanted: &CrowdRequest, bytes: &[u8], watch: &mut Watch) -> Result<Basis, Refused> {
    within("seed", wanted.seed as f64, [0.0, LARGEST_SEED as f64])?;
    let direction = within("direction [°]", wanted.direction.unwrap_or(0.0), [-360.0, 360.0])?;
    let speed = within("speed [m/s]", wanted.speed, [0.0, 20.0])?;
    within("friction", wanted.friction.unwrap_or(0.0), [0.0, MOST_FRICTION])?;
    require(!wanted.round || wanted.mix.is_empty(), || {
        "round bodies are of adults with nothing: take no mix of kinds, or no round bodies".into()
    })?;
    let (whole, geometry) = room::built(&wanted.room)?;
    let region = match &wanted.region {
        Some(corners) => room::part(&wanted.room, &whole, corners)?,
        None => whole.clone(),
    };
    let number = wanted.number(&region)?;
    let agents: Vec<Agent> = wanted.population(bytes)?.agents(wanted.seed).take(number as usize).collect();
    let mut shapes = agents.iter().map(Agent::shape).collect::<Result<Vec<_>, _>>()?;
    if wanted.round {
        shapes = shapes.iter().map(round).collect();
    }
    let orientation =
        wanted.direction.map_or(Orientation::Free, |angle| Orientation::Towards(angle.to_radians()));
    let placing = placing::Settings { orientation, seed: wanted.seed, ..placing::Settings::default() };
    let tried = placing::within_area(&shapes, &region);
    let packing = Method::Dense.place(tried, &region, &placing, watch)?;
    require(packing.ended != Ended::Cancelled, || "the placing was stopped".into())?;
    require(packing.complete && tried.len() == shapes.len(), || {
        let (area, clear) = (region.area(), packing.clear_density);
        let about = (area * clear).floor();
        format!(
            "{number} people do not fit on {area:.2} m² without overlap; about {about} of them do, {clear:.1} per m²"
        )
    })?;
    let largest_overlap =
        Packing::of(&shapes, &whole, packing.poses.clone(), packing.ended, 0).largest_overlap;
    require(largest_overlap <= TOLERANCE, || {
        format!("{REGION} goes over a wall: somebody would stand in it")
    })?;
    let settings = TrialSettings {
        desired_velocity: heading(direction) * speed,
        people: wanted.material.clone(),
        ..TrialSettings::default()
    };
    let name = format!("crowd_{number}_seed_{}", wanted.seed);
    let placed: Vec<_> = agents.iter().cloned().zip(packing.poses).collect();
    let mut trial = crowd_trial(&name, &placed, geometry, &settings)?;
    if wanted.round {
        for (agent, shape) in trial.agents.iter_mut().zip(&shapes) {
            agent.moment_of_inertia = shape.inertia(agent.mass);
            agent.shapes.truncate(1);
            (agent.shapes[0].position, agent.shapes[0].radius) = (Vec2::zeros(), shape.disks[0].radius);
        }
        choose_mechanical_step(&mut trial);
    }
    if let Some(friction) = wanted.friction {
        let theirs =
            |contact: &&mut Contact| contact.id1 == wanted.material || contact.id2 == wanted.material;
        trial
            .materials
            .binary
            .iter_mut()
            .filter(theirs)
            .for_each(|contact| contact.kinetic_friction = friction);
    }
    let made = json!({
        "density": packing.density, "area": region.area(), "iterations": packing.iterations,
        "largest_overlap": largest_overlap, "statistics": CrowdStatistics::of(&agents),
    });
    Ok(Basis { driven: Driven::alone(trial, Some(agents)), notes: Vec::new(), made })
}
