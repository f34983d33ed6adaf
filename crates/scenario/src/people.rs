//! People: drawn, placed, and made a Trial.

use crate::error::{Of, Result, ScenarioError, impossible, require};
use crate::forms::{self, OrientationName};
use crate::place::{Ground, Place};
use crate::{MOST_PEOPLE, ROUND, Scenario};
use lemons_core::files::input;
use lemons_core::files::source::Source as Files;
use lemons_core::plane::{Pose, Vec2};
use lemons_core::trial::{Contact, Geometry, Trial};
use lemons_people::placing::{Ended, Method, Orientation, Packing, Settings, Watch, within_area};
use lemons_people::{
    Agent, Custom, CustomMeasures, Disk, Kinds, PAPER_BICYCLES, PeopleError, Person, Population, Proportions,
    Sex, Shape, Source, Survey, TrialSettings, TruncatedNormal, choose_mechanical_step, crowd_trial, heading,
};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

/// Source of people.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum People {
    /// The statistics of the survey ANSUR II.
    Survey {},
    /// One's own statistics, with the rank correlations of that survey.
    Statistics {
        /// Men.
        male: Box<Four>,
        /// Women.
        female: Box<Four>,
    },
    /// One's own statistics, in a file ([`Custom`]).
    Custom {
        /// Its path.
        file: PathBuf,
    },
    /// The people of tables as that survey has them.
    Tables {
        /// Path of that of men.
        male: Option<PathBuf>,
        /// Path of that of women.
        female: Option<PathBuf>,
    },
    /// The same person every time \[m, kg\].
    Fixed {
        /// Sex.
        sex: Sex,
        /// Breadth, depth, stature and mass.
        measures: [f64; 4],
    },
}

/// The distribution of each measure: mean, standard deviation, smallest, largest value \[m, kg\].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)] // as said
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

impl Default for People {
    fn default() -> People {
        People::Survey {}
    }
}

impl People {
    pub(crate) fn check(&self) -> Result<()> {
        match self {
            People::Tables { male: None, female: None } => Err(impossible("`people`: there is no table")),
            People::Fixed { sex, measures } => {
                Person::from_measures(*sex, *measures).check().of(|| "`people`".into())
            }
            _ => Ok(()),
        }
    }
}

/// Placing of a crowd.
#[derive(Debug, Clone)]
pub struct Crowd {
    /// The placing of all, in the order of the people.
    pub packing: Packing,
    /// \[1/m²\] Density on each ground.
    pub densities: Vec<f64>,
    /// Everybody's shape.
    pub shapes: Vec<Shape>,
}

impl Scenario {
    /// Returns whom people are drawn from. Of one table alone come its people alone.
    ///
    /// # Errors
    /// A file cannot be read or has errors, or there is no such kind.
    pub fn population(&self, files: &dyn Files) -> Result<Population> {
        let mut proportions = Proportions::default();
        let mut bicycles = PAPER_BICYCLES;
        let (mut mix, mut kinds) = (forms::shares(&self.mix)?, Kinds::built_in()?);
        let custom = if let People::Custom { file } = &self.people {
            file.display().to_string()
        } else {
            String::new()
        };
        let named = || format!("`people.file` {custom}");
        let (mut from, own) = ("`mix`".to_owned(), !mix.is_empty());
        let source = match &self.people {
            People::Survey {} => Source::ansur()?,
            People::Statistics { male, female } => {
                Source::custom(&[male.of(Sex::Male), female.of(Sex::Female)])?
            }
            People::Custom { file } => {
                let text = files.read_text(file, input::LARGEST_SETTINGS);
                let text = text.map_err(|error| impossible(format!("{}: {error}", named())))?;
                let custom = Custom::from_toml(&text).of(named)?;
                proportions.men = custom.men.unwrap_or(proportions.men);
                proportions.pedestrians = custom.pedestrians.unwrap_or(proportions.pedestrians);
                bicycles = custom.bicycles;
                kinds = kinds.with(custom.kinds).of(named)?;
                if !own {
                    (mix, from) = (custom.mix, format!("{}, [mix]", named()));
                }
                Source::custom(&custom.people).of(named)?
            }
            People::Tables { male, female } => {
                proportions.men = match (male, female) {
                    (Some(_), None) => 1.0,
                    (None, Some(_)) => 0.0,
                    _ => proportions.men,
                };
                let mut survey = Survey::default();
                for (sex, path) in [(Sex::Male, male), (Sex::Female, female)] {
                    let Some(path) = path else { continue };
                    let content = files.read(path, input::LARGEST_SETTINGS).map_err(|error| {
                        impossible(format!("{}: cannot be read: {error}", path.display()))
                    })?;
                    survey.add(sex, path, &content)?;
                }
                Source::Survey(survey)
            }
            People::Fixed { sex, measures } => Source::Fixed(Person::from_measures(*sex, *measures)),
        };
        proportions.men = self.men.unwrap_or(proportions.men);
        proportions.pedestrians = self.pedestrians.unwrap_or(proportions.pedestrians);
        let population = Population::new(source, proportions, bicycles);
        let population = if custom.is_empty() { population? } else { population.of(named)? };
        require(!self.round || mix.is_empty(), || ROUND.into())?;
        if mix.is_empty() {
            return Ok(population);
        }
        Ok(population.mixed(kinds.mix(&mix).of(|| from)?))
    }

    /// Returns how many stand on each ground.
    ///
    /// # Errors
    /// The number is not said, or said twice, or nobody or too many would stand there.
    pub fn numbers(&self, place: &Place) -> Result<Vec<usize>> {
        let misused = ScenarioError::Misused;
        let (number, density) = (self.number, self.density);
        if place.is_plane() {
            match (number, density) {
                (Some(_), Some(density)) if self.packing != Method::Dense => {
                    return Err(misused(format!(
                        "`density` {density} in the open is for `packing` dense, not {}",
                        self.manner_of_packing()
                    )));
                }
                (None, Some(density)) => {
                    return Err(misused(format!(
                        "`density` {density} in the open needs `number`, or `box` or `geometry`"
                    )));
                }
                (Some(number), _) => return Ok(vec![number as usize]),
                (None, None) => {}
            }
        }
        let open = place.grounds.iter().filter(|ground| ground.amount == (None, None));
        let open: f64 = open.map(|ground| ground.free.region.area()).sum();
        if open == 0.0
            && let Some(key) = number.map(|_| "number").or(density.map(|_| "density"))
        {
            return Err(misused(format!("`{key}`: the `regions` say themselves how many people they have")));
        }
        let mut before = 0.0;
        let mut on = |Ground { free, name, amount }: &Ground| {
            let area = free.region.area();
            let wanted = match (amount, number, density) {
                ((Some(number), _), ..) => f64::from(*number),
                ((None, Some(density)), ..) => (density * area).round(),
                (_, Some(_), Some(_)) => {
                    return Err(misused(format!(
                        "`number` and `density`: one of them follows from the other in {name}"
                    )));
                }
                (_, None, Some(density)) => (density * area).round(),
                (_, Some(number), None) => {
                    // Shares of the whole that add up to it.
                    let upto = |area: f64| (f64::from(number) * area / open).round();
                    let from = before;
                    before += area;
                    upto(before) - upto(from)
                }
                (_, None, None) => {
                    return Err(misused(format!(
                        "the number of people is missing in {name}: give `number` or `density`, of all or of \
                         each of the `regions`"
                    )));
                }
            };
            require((1.0..=f64::from(MOST_PEOPLE)).contains(&wanted), || {
                format!("{name}: {wanted} people on its {area:.3} m²; there must be from 1 to {MOST_PEOPLE}")
            })?;
            Ok(wanted as usize)
        };
        place.grounds.iter().map(&mut on).collect()
    }

    /// The packing, as messages call it.
    fn manner_of_packing(&self) -> String {
        format!("`packing` {}", self.packing.name())
    }

    /// Returns the direction that people face at first, and whether it stays.
    pub fn orientation(&self) -> Orientation {
        let angle = self.direction.unwrap_or(0.0).to_radians();
        let usual = if self.direction.is_some() { OrientationName::Towards } else { OrientationName::Free };
        match self.orientation.unwrap_or(usual) {
            OrientationName::Free => Orientation::Free,
            OrientationName::Fixed => Orientation::Fixed(angle),
            OrientationName::Towards => Orientation::Towards(angle),
        }
    }

    /// Places people, so many on each ground.
    ///
    /// # Errors
    /// They do not fit without overlap and may not overlap, or `watch` stopped the placing.
    pub fn crowd(
        &self,
        agents: &[Agent],
        place: &Place,
        numbers: &[usize],
        watch: &mut Watch,
    ) -> Result<Crowd> {
        let mut shapes = agents.iter().map(Agent::shape).collect::<Result<Vec<Shape>, PeopleError>>()?;
        if self.round {
            shapes = shapes.iter().map(round).collect();
        }
        let (mut packings, mut rest) = (Vec::new(), &shapes[..]);
        for (k, (ground, number)) in place.grounds.iter().zip(numbers).enumerate() {
            let (own, others) = rest.split_at(*number);
            rest = others;
            packings.push(self.on(ground, k, own, watch)?);
        }
        let densities = packings.iter().map(|packing| packing.density).collect();
        let mut packings = packings.into_iter();
        let mut packing = packings.next().ok_or_else(|| impossible("there is no ground"))?;
        for next in packings {
            packing.poses.extend(next.poses);
            packing.density = packing.poses.len() as f64 / place.area();
            packing.largest_overlap = packing.largest_overlap.max(next.largest_overlap);
            packing.iterations += next.iterations;
            packing.complete &= next.complete;
        }
        Ok(Crowd { packing, densities, shapes })
    }

    /// Places shapes on the ground with this number.
    fn on(
        &self,
        Ground { free, name, .. }: &Ground,
        number: usize,
        shapes: &[Shape],
        watch: &mut Watch,
    ) -> Result<Packing> {
        let region = &free.region;
        // Equal grounds are filled in different ways.
        let seed = self.seed.wrapping_add(number as u64);
        let settings = Settings { orientation: self.orientation(), seed, density: self.density, limit: None };
        let few = self.packing == Method::Dense && !region.is_plane() && !self.allow_overlap;
        let tried = if few { within_area(shapes, region) } else { shapes };
        let (count, packed) = (shapes.len(), self.manner_of_packing());
        let packing = self.packing.place(tried, region, &settings, watch);
        let packing = packing.of(|| format!("{count} people in {name}, {packed}"))?;
        if packing.ended == Ended::Cancelled {
            return Err(ScenarioError::Stopped);
        }
        if self.allow_overlap || (packing.complete && tried.len() == count) {
            return Ok(packing);
        }
        if region.is_plane() {
            let wanted = self.density.map_or(String::new(), |density| format!(" at `density` {density}"));
            let Packing { density, largest_overlap, .. } = packing;
            let overlap = 1e3 * largest_overlap;
            return Err(impossible(format!(
                "{count} in the open{wanted}, {packed}: reached {density:.2} /m², largest overlap {overlap:.2} mm"
            )));
        }
        let (area, clear) = (region.area(), packing.clear_density);
        let (about, packing) = ((area * clear).floor() as usize, packing);
        let overlap = (tried.len() == count).then_some(packing.largest_overlap);
        Err(ScenarioError::NoRoom {
            number: count,
            place: format!("{name}, {packed}"),
            area,
            about,
            clear,
            overlap,
            better: self.packing == Method::Paper,
        })
    }

    /// Makes the Trial of people who were placed, with these shapes.
    ///
    /// # Errors
    /// Its mechanical step would be too short, or a part of the crowd rides bicycles.
    pub fn trial(
        &self,
        name: &str,
        placed: &[(Agent, Pose)],
        shapes: &[Shape],
        geometry: &Geometry,
    ) -> Result<Trial> {
        let mut trial = crowd_trial(name, placed, geometry.clone(), &self.settings())?;
        if self.round {
            for (agent, shape) in trial.agents.iter_mut().zip(shapes) {
                agent.moment_of_inertia = shape.inertia(agent.mass);
                agent.shapes.truncate(1);
                (agent.shapes[0].position, agent.shapes[0].radius) = (Vec2::zeros(), shape.disks[0].radius);
            }
            choose_mechanical_step(&mut trial);
        }
        if let Some(friction) = self.friction {
            let theirs =
                |contact: &&mut Contact| contact.id1 == self.material || contact.id2 == self.material;
            let contacts = trial.materials.binary.iter_mut().filter(theirs);
            contacts.for_each(|contact| contact.kinetic_friction = friction);
        }
        Ok(trial)
    }

    /// Returns the settings of the Trial. People who leave are driven by nothing else.
    pub fn settings(&self) -> TrialSettings {
        let speed = self.speed.filter(|_| !self.leave).unwrap_or(0.0);
        TrialSettings {
            time_step: self.time_step,
            people: self.material.clone(),
            desired_velocity: heading(self.direction.unwrap_or(0.0)) * speed,
        }
    }

    /// Returns the path of the room's file, if it is a drawing.
    pub(crate) fn drawing_file(&self) -> Option<&Path> {
        self.geometry.as_deref().filter(|path| lemons_people::drawing::Format::of(path).is_some())
    }
}

/// Returns one disk of the same area.
pub fn round(shape: &Shape) -> Shape {
    let radius = (shape.moments().area / PI).sqrt();
    Shape { disks: vec![Disk { centre: Vec2::zeros(), radius }] }
}
