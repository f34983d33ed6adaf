//! Populations: from which statistics people are drawn, and how many of each kind.

use crate::anthropometry::{SexStatistics, ansur};
use crate::bicycle::{BICYCLE_MEASURES, Bicycle, PAPER_BICYCLES, POSSIBLE};
use crate::copula::{Copula, Correlations};
use crate::error::{PeopleError, Result, require};
use crate::kinds::{BodyDisk, BodyStatistics, Member, PersonKind, draw_child};
use crate::person::{BodyMeasure, Person, Sex};
use crate::random::Random;
use crate::shape::Shape;
use crate::survey::Survey;
use lemons_core::distribution::TruncatedNormal;
use lemons_core::plane::Vec2;
use std::sync::Arc;

/// The source of the people of a [`Population`].
#[derive(Debug, Clone, PartialEq)]
pub enum PopulationSource {
    /// Statistics, in the order of [`Sex::ALL`].
    Statistics(Box<[Statistics; 2]>),
    /// Real people, drawn with replacement.
    Survey(Survey),
    /// Always the same person. The proportion of men then has no effect.
    Fixed(Person),
}

impl PopulationSource {
    /// Returns the statistics of the public survey ANSUR II, see [`ansur`].
    ///
    /// # Errors
    /// None: the survey's own statistics are possible.
    pub fn ansur() -> Result<PopulationSource> {
        let [men, women] = Sex::ALL.map(|sex| {
            let survey = ansur(sex);
            Statistics::new(sex, &survey.spearman, Margins::Survey(survey))
        });
        Ok(PopulationSource::Statistics(Box::new([men?, women?])))
    }

    /// Returns custom statistics, in the order of [`Sex::ALL`].
    ///
    /// # Errors
    /// They are impossible.
    pub fn custom([men, women]: &[CustomMeasures; 2]) -> Result<PopulationSource> {
        let both = [Statistics::custom(Sex::Male, men)?, Statistics::custom(Sex::Female, women)?];
        Ok(PopulationSource::Statistics(Box::new(both)))
    }
}

/// Custom statistics for one sex.
#[derive(Debug, Clone, PartialEq)]
pub struct CustomMeasures {
    /// Distributions \[m, kg\] of the measures, in the order of [`BodyMeasure::ALL`].
    pub measures: [TruncatedNormal; 4],
    /// Spearman's rank correlations between them, in the order of [`BodyMeasure::ALL`]. Where no four measures can have all
    /// of these, all are weakened by one common factor, as little as possible.
    pub spearman: Correlations,
}

impl CustomMeasures {
    /// Returns the paper's defaults, with the rank correlations of ANSUR II.
    pub fn paper(sex: Sex) -> CustomMeasures {
        // In cm and kg.
        let measures = match sex {
            Sex::Male => [
                [51.0, 2.0, 30.0, 65.0],
                [26.0, 2.0, 15.0, 45.0],
                [178.0, 8.0, 140.0, 240.0],
                [85.0, 15.0, 30.0, 160.0],
            ],
            Sex::Female => [
                [45.0, 1.5, 30.0, 60.0],
                [24.0, 1.5, 15.0, 45.0],
                [164.0, 7.0, 140.0, 210.0],
                [67.0, 11.0, 30.0, 130.0],
            ],
        };
        let measures = std::array::from_fn(|k| {
            let units = if BodyMeasure::ALL[k] == BodyMeasure::Mass { 1.0 } else { 100.0 };
            TruncatedNormal::from(measures[k].map(|value: f64| value / units))
        });
        CustomMeasures { measures, spearman: ansur(sex).spearman }
    }
}

/// A member of a crowd, before it has an Id.
#[derive(Debug, Clone, PartialEq)]
pub enum CrowdMember {
    /// A pedestrian.
    Pedestrian(Person),
    /// A person of some kind, with what goes along.
    Member(Box<Member>),
}

impl CrowdMember {
    /// Returns the people who stand upright, with their places \[m\] from the centre of mass: nobody on a bicycle or in a
    /// wheelchair.
    pub fn people(&self) -> Vec<(Person, Vec2)> {
        match self {
            CrowdMember::Pedestrian(person) => vec![(*person, Vec2::zeros())],
            CrowdMember::Member(member) if !member.kind.seated => member.people.clone(),
            CrowdMember::Member(_) => Vec::new(),
        }
    }

    /// Returns all people of it, also those who sit.
    pub fn everybody(&self) -> Vec<Person> {
        match self {
            CrowdMember::Pedestrian(person) => vec![*person],
            CrowdMember::Member(member) => member.people.iter().map(|(person, _)| *person).collect(),
        }
    }

    /// Returns the member, if the agent is of a kind.
    pub fn member(&self) -> Option<&Member> {
        match self {
            CrowdMember::Member(member) => Some(member),
            CrowdMember::Pedestrian(_) => None,
        }
    }

    /// Returns the disks of the plan.
    ///
    /// # Errors
    /// As those of [`Shape::of`].
    pub fn disks(&self) -> Result<Vec<BodyDisk>> {
        match self {
            CrowdMember::Pedestrian(person) => {
                Ok(Shape::of(person)?.disks.into_iter().map(BodyDisk::of).collect())
            }
            CrowdMember::Member(member) => Ok(member.disks.clone()),
        }
    }

    /// Returns the shape that is placed.
    ///
    /// # Errors
    /// As those of [`Shape::of`].
    pub fn shape(&self) -> Result<Shape> {
        match self {
            CrowdMember::Pedestrian(person) => Shape::of(person),
            CrowdMember::Member(member) => Ok(member.shape()),
        }
    }
}

/// Number of test draws; at least [`LEAST_POSSIBLE`] of them must be possible people.
const TRIAL_DRAWS: u32 = 2000;
/// With fewer, the statistics are taken for a mistake: drawing could take for ever.
const LEAST_POSSIBLE: u32 = TRIAL_DRAWS / 20;

/// The measures of one sex, each with its own distribution.
#[derive(Debug, Clone, PartialEq)]
enum Margins {
    Survey(&'static SexStatistics),
    Custom([TruncatedNormal; 4]),
}

/// Statistics of one sex, from which people are drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Statistics {
    sex: Sex,
    copula: Copula,
    margins: Margins,
}

impl Statistics {
    fn new(sex: Sex, spearman: &Correlations, margins: Margins) -> Result<Statistics> {
        let copula = Copula::new(spearman).map_err(|error| error.of(format!("{} statistics", sex.name())))?;
        Ok(Statistics { sex, copula, margins })
    }

    fn custom(sex: Sex, custom: &CustomMeasures) -> Result<Statistics> {
        let name = sex.name();
        for (measure, normal) in BodyMeasure::ALL.into_iter().zip(custom.measures) {
            let (what, unit) = (measure.name(), measure.unit());
            normal
                .check()
                .map_err(|error| PeopleError::new(error).of(format!("{name} statistics, {what}")))?;
            let [least, most] = measure.possible();
            for (limit, value) in [("min", normal.min), ("max", normal.max)] {
                require((least..=most).contains(&value), || {
                    format!(
                        "{name} statistics, {what}: {limit} = {value:.3} {unit}: measures of people are {least} to {most} {unit}"
                    )
                })?;
            }
        }
        let statistics = Statistics::new(sex, &custom.spearman, Margins::Custom(custom.measures))?;
        let random = &mut Random::new(0);
        let refused =
            (0..TRIAL_DRAWS).filter(|_| statistics.candidate(random).check().is_err()).count() as u32;
        require(TRIAL_DRAWS - refused >= LEAST_POSSIBLE, || {
            format!(
                "{name} statistics: chest depth exceeds bideltoid breadth in {refused} of {TRIAL_DRAWS} draws: few people are possible"
            )
        })?;
        Ok(statistics)
    }

    /// One draw; its chest may be deeper than its shoulders are broad.
    fn candidate(&self, random: &mut Random) -> Person {
        let ranks = self.copula.ranks(random);
        let measures = match &self.margins {
            Margins::Survey(statistics) => {
                std::array::from_fn(|place| statistics.measures[place].quantile(ranks[place]))
            }
            Margins::Custom(normals) => std::array::from_fn(|place| normals[place].quantile(ranks[place])),
        };
        Person::from_measures(self.sex, measures)
    }

    /// Draws until the chest is not deeper than the shoulders are broad.
    fn draw(&self, random: &mut Random) -> Person {
        loop {
            let person = self.candidate(random);
            if person.depth <= person.breadth {
                return person;
            }
        }
    }
}

/// The population from which a crowd is drawn. The same seed gives the same people on every machine.
///
/// The breadth, depth, stature and mass of one person are correlated: their ranks have the correlations of the survey
/// (a Gaussian copula). A draw whose chest is deeper than its shoulders are broad is repeated.
#[derive(Debug, Clone, PartialEq)]
pub struct Population {
    source: PopulationSource,
    /// Fraction of men, 0…1; the others are women.
    men: f64,
    bicycles: [TruncatedNormal; 5],
    /// Kinds and their shares, which sum up to 1; empty: adults with nothing.
    mix: Vec<(Arc<PersonKind>, f64)>,
    /// Those who ride, and the probability of them; the others are of the mix.
    riders: Option<(Arc<PersonKind>, f64)>,
    /// Of the stature and the mass of children, in the order of [`Sex::ALL`].
    children: [Copula; 2],
}

impl Population {
    /// Makes a population with a fraction of men, of adults with nothing.
    ///
    /// # Errors
    /// The fraction is outside 0…1, a survey has no people of a sex whose proportion is not 0, or the fixed person is
    /// impossible.
    pub fn new(source: PopulationSource, men: f64) -> Result<Population> {
        require((0.0..=1.0).contains(&men), || format!("proportion of men = {men}: must be within 0…1"))?;
        match &source {
            PopulationSource::Statistics(_) => {}
            PopulationSource::Survey(survey) => {
                for (sex, share) in [(Sex::Male, men), (Sex::Female, 1.0 - men)] {
                    require(share == 0.0 || !survey.people(sex).is_empty(), || {
                        format!("the survey has no {} people, but their proportion is not 0", sex.name())
                    })?;
                }
            }
            PopulationSource::Fixed(person) => {
                person.check().map_err(|error| error.of("the fixed person"))?
            }
        }
        let [of_boys, of_girls] = Sex::ALL.map(|sex| Copula::new(&ansur(sex).spearman));
        let children = [of_boys?, of_girls?];
        Ok(Population { source, men, bicycles: PAPER_BICYCLES, mix: Vec::new(), riders: None, children })
    }

    /// Gives it other distributions of the measures of bicycles, in the order of [`BICYCLE_MEASURES`].
    ///
    /// # Errors
    /// A distribution is impossible, or goes beyond what bicycles have.
    pub fn with_bicycles(self, bicycles: [TruncatedNormal; 5]) -> Result<Population> {
        for (((measure, unit), normal), [least, most]) in
            BICYCLE_MEASURES.into_iter().zip(bicycles).zip(POSSIBLE)
        {
            normal.check().map_err(|error| PeopleError::new(error).of(format!("bicycle's {measure}")))?;
            for (limit, value) in [("min", normal.min), ("max", normal.max)] {
                require((least..=most).contains(&value), || {
                    format!(
                        "bicycle's {measure}: {limit} = {value} {unit}: bicycles have {least} to {most} {unit}"
                    )
                })?;
            }
        }
        Ok(Population { bicycles, ..self })
    }

    /// Makes it a mix of kinds, as [`Kinds::mix`](crate::Kinds::mix) returns it.
    pub fn mixed(self, mix: Vec<(Arc<PersonKind>, f64)>) -> Population {
        Population { mix, ..self }
    }

    /// Makes a fraction of it pedestrians, and all others of a kind.
    ///
    /// # Errors
    /// The fraction is outside 0…1.
    pub fn with_riders(self, pedestrians: f64, kind: Arc<PersonKind>) -> Result<Population> {
        require((0.0..=1.0).contains(&pedestrians), || {
            format!("proportion of pedestrians = {pedestrians}: must be within 0…1")
        })?;
        Ok(Population { riders: Some((kind, 1.0 - pedestrians)), ..self })
    }

    /// Returns whether bicycles can be drawn.
    pub fn has_bicycles(&self) -> bool {
        self.mix.iter().chain(&self.riders).any(|(kind, share)| kind.bicycle && *share > 0.0)
    }

    /// Draws one adult.
    fn draw(&self, random: &mut Random) -> Person {
        match &self.source {
            PopulationSource::Fixed(person) => *person,
            PopulationSource::Statistics(statistics) => statistics[self.sex(random) as usize].draw(random),
            PopulationSource::Survey(survey) => {
                let people = survey.people(self.sex(random));
                people[random.index(people.len())]
            }
        }
    }

    fn sex(&self, random: &mut Random) -> Sex {
        // `inside_unit` excludes 0 and 1: a proportion of 0 or 1 excludes the other sex.
        if random.inside_unit() < self.men { Sex::Male } else { Sex::Female }
    }

    /// Draws one child of an age between two \[years\].
    fn draw_child(&self, ages: [f64; 2], random: &mut Random) -> Person {
        let sex = self.sex(random);
        let [_, _, stature, mass] = self.children[sex as usize].ranks(random);
        draw_child(sex, ages, [stature, mass], random)
    }

    /// Draws a member of a kind.
    fn draw_member(&self, kind: &Arc<PersonKind>, random: &mut Random) -> CrowdMember {
        let person = match (kind.person, kind.ages) {
            (BodyStatistics::Child, Some(ages)) => self.draw_child(ages, random),
            _ => self.draw(random),
        };
        let companion = kind.companion.map(|ages| self.draw_child(ages, random));
        let mut measure = |normal: TruncatedNormal| normal.quantile(random.inside_unit());
        let bicycle = kind.bicycle.then(|| Bicycle::from_measures(self.bicycles.map(&mut measure)));
        CrowdMember::Member(Box::new(kind.draw(person, companion, bicycle, random)))
    }

    /// Draws one agent: a pedestrian, a member of the mix, or somebody who rides.
    fn draw_agent(&self, random: &mut Random) -> CrowdMember {
        // Also without riders: the same seed gives the same people.
        let rank = random.inside_unit();
        if let Some((kind, _)) = self.riders.as_ref().filter(|(_, share)| rank >= 1.0 - share) {
            return self.draw_member(kind, random);
        }
        let Some(last) = self.mix.last() else { return CrowdMember::Pedestrian(self.draw(random)) };
        let mut left = random.inside_unit();
        let reached = |(_, share): &&(Arc<PersonKind>, f64)| {
            left -= share;
            left < 0.0
        };
        let (kind, _) = self.mix.iter().find(reached).unwrap_or(last);
        self.draw_member(kind, random)
    }

    /// Returns an endless sequence of agents, the same for the same seed.
    pub fn agents(&self, seed: u64) -> impl Iterator<Item = CrowdMember> + use<'_> {
        let mut random = Random::new(seed);
        std::iter::repeat_with(move || self.draw_agent(&mut random))
    }
}

#[cfg(test)]
mod tests;
