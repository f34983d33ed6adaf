//! People: drawn, placed, and made a Trial.

use crate::error::{NO_ROOM, NUMBER, Of, ROUND, Result, ScenarioError, fits, impossible, require};
use crate::forms::{self, OrientationName};
use crate::place::{StandingArea, WalkableRoom};
use crate::{MOST_PEOPLE, Scenario, ScenarioDocuments, SourceForm, drive};
use lemons_core::files::input;
use lemons_core::files::source::FileSource;
use lemons_core::message::message;
use lemons_core::plane::{Pose, Vec2};
use lemons_core::trial::{Ground, Link, PanelChoice, Trial};
use lemons_decision::Plan;
use lemons_people::placing::{
    Ended, FreeSpace, Method, Orientation, Packing, PlacingSettings, Watch, within_area,
};
use lemons_people::{
    BICYCLE, CrowdMember, Custom, CustomMeasures, Disk, Kinds, PeopleError, Person, Population,
    PopulationSource, Sex, Shape, Slabs, Survey, TrialSettings, TruncatedNormal, choose_mechanical_step,
    crowd_trial, heading,
};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

/// Source of people.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
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
            People::Fixed { sex, measures } => Person::from_measures(*sex, *measures).check().of("`people`"),
            _ => Ok(()),
        }
    }
}

/// People of a scenario who are not placed yet.
pub struct Ready<'a> {
    scenario: &'a Scenario,
    /// The room.
    pub place: WalkableRoom,
    /// How many stand on each ground.
    pub numbers: Vec<usize>,
    /// Everybody who is there at the start, ground after ground.
    pub agents: Vec<CrowdMember>,
    /// Those who come later, by source.
    pub arriving: Vec<Vec<CrowdMember>>,
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
    pub fn population(&self, files: &dyn FileSource) -> Result<Population> {
        let (mut men, mut pedestrians, mut bicycles) = (0.5, 1.0, None);
        let (mut mix, mut kinds, mut from) =
            (forms::shares(&self.mix)?, Kinds::built_in()?, "`mix`".to_owned());
        let mut custom = None;
        let source = match &self.people {
            People::Survey {} => PopulationSource::ansur()?,
            People::Statistics { male, female } => {
                PopulationSource::custom(&[male.of(Sex::Male), female.of(Sex::Female)])?
            }
            People::Custom { file } => {
                let named = &*custom.insert(format!("`people.file` {}", file.display()));
                let text = files.read_text(file, input::LARGEST_SETTINGS);
                let text = text.map_err(|error| impossible(format!("{named}: {error}")))?;
                let own = Custom::from_toml(&text).of(named)?;
                men = own.men.unwrap_or(men);
                pedestrians = own.pedestrians.unwrap_or(pedestrians);
                bicycles = Some(own.bicycles);
                kinds = kinds.with(own.kinds).of(named)?;
                if mix.is_empty() {
                    (mix, from) = (own.mix, format!("{named}, [mix]"));
                }
                PopulationSource::custom(&own.people).of(named)?
            }
            People::Tables { male, female } => {
                men = match (male, female) {
                    (Some(_), None) => 1.0,
                    (None, Some(_)) => 0.0,
                    _ => men,
                };
                let mut survey = Survey::default();
                for (sex, path) in [(Sex::Male, male), (Sex::Female, female)] {
                    let Some(path) = path else { continue };
                    let content = files.read(path, input::LARGEST_SETTINGS).map_err(|error| {
                        impossible(format!("{}: cannot be read: {error}", path.display()))
                    })?;
                    survey.add(sex, path, &content)?;
                }
                PopulationSource::Survey(survey)
            }
            People::Fixed { sex, measures } => {
                PopulationSource::Fixed(Person::from_measures(*sex, *measures))
            }
        };
        let pedestrians = self.pedestrians.unwrap_or(pedestrians);
        let mut population = Population::new(source, self.men.unwrap_or(men));
        if let Some(bicycles) = bicycles {
            population = population.and_then(|population| population.with_bicycles(bicycles));
        }
        let population = match &custom {
            Some(named) => population.of(named)?,
            None => population?,
        };
        let of_file = custom.as_deref().filter(|_| self.pedestrians.is_none());
        let whose = of_file.unwrap_or("`pedestrians`");
        require(!self.round || mix.is_empty() && pedestrians == 1.0, || message!(ROUND))?;
        let population = match kinds.get(BICYCLE) {
            Some(bicycle) => population.with_riders(pedestrians, bicycle.clone()).of(whose)?,
            None => population,
        };
        if mix.is_empty() {
            return Ok(population);
        }
        Ok(population.mixed(kinds.mix(&mix).of(from)?))
    }

    /// Returns how many stand on each ground.
    fn numbers(&self, place: &WalkableRoom) -> Result<Vec<usize>> {
        let (number, density) = (self.number, self.density);
        if place.is_plane() {
            if let Some(density) = density {
                fits(number.is_some(), || {
                    format!("`density` {density} in the open needs `number`, or `box` or `geometry`")
                })?;
                let packed = self.manner_of_packing();
                fits(self.packing == Method::Dense, || {
                    format!("`density` {density} in the open is for `packing` dense, not {packed}")
                })?;
            }
            if let Some(number) = number {
                return Ok(vec![number as usize]);
            }
        }
        let open = place.grounds.iter().filter(|ground| ground.amount == (None, None));
        let open: f64 = open.map(|ground| ground.free.region.area()).sum();
        for (key, given) in [("number", number.is_some()), ("density", density.is_some())] {
            fits(!given || open > 0.0, || {
                format!("`{key}`: `regions` say themselves how many people they have")
            })?;
        }
        if !self.sources.is_empty() && self.regions.is_empty() && number.is_none() && density.is_none() {
            return Ok(vec![0; place.grounds.len()]);
        }
        let mut before = 0.0;
        let mut on = |StandingArea { free, name, amount }: &StandingArea| {
            let area = free.region.area();
            let own = *amount != (None, None);
            let wanted = match if own { *amount } else { (number, density) } {
                (Some(number), None) if own => f64::from(number),
                (None, Some(density)) => (density * area).round(),
                (Some(number), None) => {
                    // Shares of the whole that add up to it.
                    let upto = |area: f64| (f64::from(number) * area / open).round();
                    let from = before;
                    before += area;
                    upto(before) - upto(from)
                }
                given => {
                    fits(given.0.is_none(), || {
                        format!("`number` and `density`: one of them follows from the other in {name}")
                    })?;
                    return Err(ScenarioError::Misused(format!(
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

    /// Draws people who stand there, at most so many.
    ///
    /// # Errors
    /// Their number is not said, or said twice, or nobody or too many would stand somewhere.
    pub fn ready(&self, population: &Population, place: WalkableRoom, most: u32) -> Result<Ready<'_>> {
        let numbers = self.numbers(&place)?;
        let there = numbers.iter().sum::<usize>();
        let all = there + self.sources.iter().map(SourceForm::people).sum::<usize>();
        require(all <= most as usize, || message!(NUMBER, all, most = most as usize))?;
        let agents = population.agents(self.seed()).take(there).collect();
        let arriving = self.arriving(population)?;
        Ok(Ready { scenario: self, place, numbers, agents, arriving })
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

    /// Places shapes on the ground with this number.
    fn on(
        &self,
        ground: &StandingArea,
        number: usize,
        shapes: &[Shape],
        watch: &mut Watch,
    ) -> Result<Packing> {
        let StandingArea { free: FreeSpace { region, .. }, name, .. } = ground;
        // Equal grounds are filled in different ways.
        let seed = self.seed().wrapping_add(number as u64);
        let settings =
            PlacingSettings { orientation: self.orientation(), seed, density: self.density, limit: None };
        let few = self.packing == Method::Dense && !region.is_plane() && !self.allow_overlap;
        let tried = if few { within_area(shapes, region) } else { shapes };
        let (count, packed) = (shapes.len(), self.manner_of_packing());
        let packing = self.packing.place(tried, region, &settings, watch);
        let packing = packing.of(format_args!("{count} people in {name}, {packed}"))?;
        if packing.ended == Ended::Cancelled {
            return Err(ScenarioError::Stopped);
        }
        if self.allow_overlap || (packing.complete && tried.len() == count) {
            return Ok(packing);
        }
        let (area, clear, overlap) = (region.area(), packing.clear_density, 1e3 * packing.largest_overlap);
        if region.is_plane() {
            let wanted = self.density.map_or(String::new(), |density| format!(" at `density` {density}"));
            let density = packing.density;
            return Err(impossible(format!(
                "{count} in the open{wanted}, {packed}: reached {density:.2} /m², largest overlap {overlap:.2} mm"
            )));
        }
        let about = (area * clear).floor();
        let what = message!(NO_ROOM, count, area, about, clear);
        let mut hint = String::new();
        if tried.len() == count {
            hint = format!("; the others overlap by up to {overlap:.2} mm (`allow_overlap` writes it so)");
        }
        if self.packing == Method::Paper {
            hint += "; `packing` dense reaches more";
        }
        Err(ScenarioError::NoRoom { place: format!("{name}, {packed}"), what, hint })
    }

    /// Returns the slabs in which people have disks.
    pub(crate) fn slabs(&self) -> Result<Option<Slabs>> {
        self.levels.as_ref().map(|levels| levels.slabs().of("`levels`")).transpose()
    }

    /// Returns the shape of an agent that is placed, before it is made round.
    pub(crate) fn shape_of(&self, agent: &CrowdMember) -> Result<Shape> {
        match self.slabs()? {
            Some(slabs) => slabs.shape(agent).of("`levels`"),
            None => Ok(agent.shape()?),
        }
    }

    /// Returns the settings of the Trial. People who leave are driven by nothing else.
    pub fn settings(&self) -> TrialSettings {
        let speed = self.speed.filter(|_| !self.leave).unwrap_or(0.0);
        TrialSettings {
            time_step: self.time_step.unwrap_or(0.01),
            people: self.material().to_owned(),
            desired_velocity: heading(self.direction.unwrap_or(0.0)) * speed,
            slabs: self.slabs().unwrap_or_default(),
        }
    }

    /// Returns the path of the room's file, if it is a drawing.
    pub(crate) fn drawing_file(&self) -> Option<&Path> {
        self.geometry.as_deref().filter(|path| lemons_people::drawing::DrawingFormat::of(path).is_some())
    }
}

impl Ready<'_> {
    /// Places the people.
    ///
    /// # Errors
    /// They do not fit without overlap and may not overlap, or `watch` stopped the placing.
    pub fn crowd(&self, watch: &mut Watch) -> Result<Crowd> {
        let Ready { scenario, place, numbers, agents, .. } = self;
        let shapes = agents.iter().map(|agent| scenario.shape_of(agent));
        let mut shapes = shapes.collect::<Result<Vec<Shape>>>()?;
        if scenario.round {
            shapes = shapes.iter().map(round).collect();
        }
        let (mut packings, mut rest) = (Vec::new(), &shapes[..]);
        for (k, (ground, number)) in place.grounds.iter().zip(numbers).enumerate() {
            let (own, others) = rest.split_at(*number);
            rest = others;
            if own.is_empty() {
                let region = &ground.free.region;
                packings.push(Packing::of(own, region, Vec::new(), Ended::Done, 0));
                continue;
            }
            packings.push(scenario.on(ground, k, own, watch)?);
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

    /// Makes the documents of the Trial.
    ///
    /// # Errors
    /// People cannot leave, a push reaches nobody, or the mechanical step would be too short.
    pub fn into_documents(self, name: &str, crowd: Crowd) -> Result<ScenarioDocuments> {
        let Ready { scenario, place, mut agents, arriving, .. } = self;
        let poses = crowd.packing.poses.iter().copied();
        let mut placed: Vec<(CrowdMember, Pose)> = agents.iter().cloned().zip(poses).collect();
        placed.extend(scenario.entries(&place, &arriving)?);
        agents.extend(arriving.into_iter().flatten());
        let mut geometry = place.geometry.clone();
        for (k, ground) in scenario.grounds.iter().enumerate() {
            let id = unused(geometry.grounds.iter().map(|ground| &*ground.id));
            geometry.grounds.push(Ground { id, ..ground.ground(k)? });
        }
        for (k, link) in scenario.links.iter().enumerate() {
            let id = unused(geometry.links.iter().map(|link| &*link.id));
            geometry.links.push(Link { id, ..link.link(k)? });
        }
        if let Some(longest) = scenario.panel_length {
            let panels = PanelChoice::Longest(longest);
            geometry.divide(panels).map_err(|why| impossible(format!("`panel_length`: {why}")))?;
        }
        let mut trial = crowd_trial(name, &placed, geometry, &scenario.settings())?;
        if scenario.round {
            let later =
                agents[crowd.shapes.len()..].iter().map(|agent| agent.shape().map(|shape| round(&shape)));
            let later = later.collect::<Result<Vec<Shape>, PeopleError>>()?;
            for (agent, shape) in trial.agents.iter_mut().zip(crowd.shapes.iter().chain(&later)) {
                agent.moment_of_inertia = shape.inertia(agent.mass);
                agent.shapes.truncate(1);
                (agent.shapes[0].position, agent.shapes[0].radius) = (Vec2::zeros(), shape.disks[0].radius);
            }
            choose_mechanical_step(&mut trial);
        }
        if let Some(friction) = scenario.friction {
            let own = scenario.material();
            let contacts = trial.materials.binary.iter_mut().filter(|of| of.id1 == own || of.id2 == own);
            contacts.for_each(|contact| contact.kinetic_friction = friction);
        }
        let mut notes = place.notes.clone();
        let mut decision = scenario.decision(&agents, &trial, &place, &mut notes);
        decision.iter_mut().for_each(|config| scenario.with_sources(config, &trial));
        let pushed = drive(&trial, &scenario.pushes)?;
        let leave = if scenario.leave { "`leave`: people cannot leave: " } else { "" };
        let plan = |trial: &Trial, config: &_| {
            Plan::of(trial, config).map_err(|error| impossible(format!("{leave}{error}")))
        };
        let mut plans = decision.as_ref().map(|config| plan(&trial, config)).transpose()?;
        if let Some((config, made)) =
            decision.as_ref().zip(plans.as_mut()).filter(|(_, made)| !made.sources.is_empty())
        {
            Scenario::let_walk(&mut trial, made)?;
            *made = plan(&trial, config)?;
        }
        let decision = decision.zip(plans);
        Ok(ScenarioDocuments { trial, agents, crowd, place, drive: pushed, decision, notes })
    }
}

/// Returns one disk of the same area.
pub fn round(shape: &Shape) -> Shape {
    let radius = (shape.moments().area / PI).sqrt();
    Shape { disks: vec![Disk { centre: Vec2::zeros(), radius }] }
}

/// Returns the lowest number that is no Id yet.
fn unused<'a>(ids: impl Iterator<Item = &'a str> + Clone) -> String {
    let mut free = (0..).map(|k: usize| k.to_string()).filter(|id| ids.clone().all(|other| other != id));
    free.next().unwrap_or_default()
}
