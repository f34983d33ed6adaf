//! Populations: from which statistics people are drawn, and how many of each kind.

use crate::anthropometry::{SexStatistics, ansur};
use crate::bicycle::{Bicycle, BicycleError, BicycleStatistics};
use crate::copula::{Copula, Correlations, CorrelationsError};
use crate::normal::{TruncatedNormal, TruncatedNormalError};
use crate::person::{Measure, Person, PersonError, Sex};
use crate::random::{Generator, generator, place, uniform};
use crate::survey::Survey;
use rand_chacha::rand_core::Rng;
use thiserror::Error;

/// The source of the people of a [`Population`].
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// The statistics of the public survey ANSUR II, see [`ansur`].
    Ansur,
    /// Custom statistics.
    Custom(Box<CustomStatistics>),
    /// Real people, drawn with replacement.
    Survey(Survey),
    /// Always the same person. The proportion of men then has no effect.
    Fixed(Person),
}

/// Custom statistics for both sexes.
#[derive(Debug, Clone, PartialEq)]
pub struct CustomStatistics {
    /// Statistics of men.
    pub men: CustomMeasures,
    /// Statistics of women.
    pub women: CustomMeasures,
}

/// Custom statistics for one sex.
#[derive(Debug, Clone, PartialEq)]
pub struct CustomMeasures {
    /// \[m\] bideltoid breadth.
    pub breadth: TruncatedNormal,
    /// \[m\] chest depth.
    pub depth: TruncatedNormal,
    /// \[m\] stature.
    pub stature: TruncatedNormal,
    /// \[kg\] mass.
    pub mass: TruncatedNormal,
    /// Spearman's rank correlations between them, in the order of [`Measure::ALL`]. Where no four measures can have all
    /// of these, all are weakened by one common factor, as little as possible.
    pub spearman: Correlations,
}

impl CustomMeasures {
    fn all(&self) -> [TruncatedNormal; 4] {
        [self.breadth, self.depth, self.stature, self.mass]
    }
}

impl Default for CustomStatistics {
    /// The paper's defaults, with the rank correlations of ANSUR II.
    fn default() -> CustomStatistics {
        let length = |mean: f64, sd: f64, min: f64, max: f64| TruncatedNormal {
            mean: mean / 100.0,
            sd: sd / 100.0,
            min: min / 100.0,
            max: max / 100.0,
        };
        CustomStatistics {
            men: CustomMeasures {
                breadth: length(51.0, 2.0, 30.0, 65.0),
                depth: length(26.0, 2.0, 15.0, 45.0),
                stature: length(178.0, 8.0, 140.0, 240.0),
                mass: TruncatedNormal { mean: 85.0, sd: 15.0, min: 30.0, max: 160.0 },
                spearman: ansur(Sex::Male).spearman,
            },
            women: CustomMeasures {
                breadth: length(45.0, 1.5, 30.0, 60.0),
                depth: length(24.0, 1.5, 15.0, 45.0),
                stature: length(164.0, 7.0, 140.0, 210.0),
                mass: TruncatedNormal { mean: 67.0, sd: 11.0, min: 30.0, max: 130.0 },
                spearman: ansur(Sex::Female).spearman,
            },
        }
    }
}

/// Proportions of the kinds, as probabilities of each draw.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Proportions {
    /// Fraction of the pedestrians that are men, 0…1; the others are women.
    pub men: f64,
    /// Fraction of the agents that are pedestrians, 0…1; the others are bicycles with their riders.
    pub pedestrians: f64,
}

impl Default for Proportions {
    /// As many women as men, no bicycles.
    fn default() -> Proportions {
        Proportions { men: 0.5, pedestrians: 1.0 }
    }
}

/// An agent of a mixed crowd.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Agent {
    /// A pedestrian.
    Pedestrian(Person),
    /// A bicycle with its rider.
    Bicycle(Bicycle),
}

/// Why a population is impossible.
#[derive(Debug, Clone, PartialEq, Error)]
#[allow(missing_docs)] // the messages say it
pub enum PopulationError {
    #[error("proportion of {of} = {value}: must be within 0…1")]
    Proportion { of: &'static str, value: f64 },
    #[error("{} statistics, {}: {error}", sex.name(), measure.name())]
    Statistics { sex: Sex, measure: Measure, error: TruncatedNormalError },
    #[error(
        "{} statistics, {}: {limit} = {value:.3} {unit}: measures of people are {} to {} {unit}",
        sex.name(), measure.name(), measure.possible()[0], measure.possible()[1], unit = measure.unit()
    )]
    Impossible { sex: Sex, measure: Measure, limit: &'static str, value: f64 },
    #[error("{} statistics: {error}", sex.name())]
    Correlations { sex: Sex, error: CorrelationsError },
    #[error(
        "{} statistics: chest depth exceeds bideltoid breadth in {refused} of {tried} draws: few people are possible",
        sex.name()
    )]
    TooDeep { sex: Sex, refused: u32, tried: u32 },
    #[error("the survey has no {} people, but their proportion is not 0", sex.name())]
    Nobody { sex: Sex },
    #[error("the fixed person: {0}")]
    Person(#[from] PersonError),
    #[error(transparent)]
    Bicycle(#[from] BicycleError),
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

/// People of one sex, drawn from statistics.
#[derive(Debug, Clone, PartialEq)]
struct Statistics {
    sex: Sex,
    copula: Copula,
    margins: Margins,
}

impl Statistics {
    fn survey(sex: Sex) -> Result<Statistics, PopulationError> {
        let statistics = ansur(sex);
        let copula = Copula::new(&statistics.spearman);
        let copula = copula.map_err(|error| PopulationError::Correlations { sex, error })?;
        Ok(Statistics { sex, copula, margins: Margins::Survey(statistics) })
    }

    fn custom(sex: Sex, custom: &CustomMeasures) -> Result<Statistics, PopulationError> {
        for (measure, normal) in Measure::ALL.into_iter().zip(custom.all()) {
            normal.check().map_err(|error| PopulationError::Statistics { sex, measure, error })?;
            let [least, most] = measure.possible();
            for (limit, value) in [("min", normal.min), ("max", normal.max)] {
                if !(least..=most).contains(&value) {
                    return Err(PopulationError::Impossible { sex, measure, limit, value });
                }
            }
        }
        let copula = Copula::new(&custom.spearman);
        let copula = copula.map_err(|error| PopulationError::Correlations { sex, error })?;
        let statistics = Statistics { sex, copula, margins: Margins::Custom(custom.all()) };
        let rng = &mut generator(0);
        let refused = (0..TRIAL_DRAWS).filter(|_| statistics.candidate(rng).check().is_err()).count() as u32;
        if TRIAL_DRAWS - refused < LEAST_POSSIBLE {
            return Err(PopulationError::TooDeep { sex, refused, tried: TRIAL_DRAWS });
        }
        Ok(statistics)
    }

    /// One draw; its chest may be deeper than its shoulders are broad.
    fn candidate<R: Rng + ?Sized>(&self, rng: &mut R) -> Person {
        let ranks = self.copula.ranks(rng);
        let measures = match &self.margins {
            Margins::Survey(statistics) => {
                std::array::from_fn(|place| statistics.measures[place].quantile(ranks[place]))
            }
            Margins::Custom(normals) => std::array::from_fn(|place| normals[place].quantile(ranks[place])),
        };
        Person::from_measures(self.sex, measures)
    }

    /// Draws until the chest is not deeper than the shoulders are broad.
    fn draw<R: Rng + ?Sized>(&self, rng: &mut R) -> Person {
        loop {
            let person = self.candidate(rng);
            if person.depth <= person.breadth {
                return person;
            }
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
enum Ready {
    /// Men, women.
    Statistics(Box<[Statistics; 2]>),
    Survey(Survey),
    Fixed(Person),
}

/// The population from which a crowd is drawn. The same seed gives the same people on every machine.
///
/// The breadth, depth, stature and mass of one person are correlated: their ranks have the correlations of the survey
/// (a Gaussian copula). A draw whose chest is deeper than its shoulders are broad is repeated.
#[derive(Debug, Clone, PartialEq)]
pub struct Population {
    people: Ready,
    proportions: Proportions,
    bicycles: BicycleStatistics,
}

impl Default for Population {
    /// As many women as men, from ANSUR II.
    fn default() -> Population {
        Population::new(Source::Ansur, Proportions::default()).expect("the survey's own statistics")
    }
}

impl Population {
    /// Makes a population with the default statistics of bicycles.
    ///
    /// # Errors
    /// A proportion is outside 0…1, statistics are impossible, a survey has no people of a sex whose proportion is not
    /// 0, or the fixed person is impossible.
    pub fn new(source: Source, proportions: Proportions) -> Result<Population, PopulationError> {
        for (of, value) in [("men", proportions.men), ("pedestrians", proportions.pedestrians)] {
            if !(0.0..=1.0).contains(&value) {
                return Err(PopulationError::Proportion { of, value });
            }
        }
        let people = match source {
            Source::Ansur => Ready::Statistics(Box::new([
                Statistics::survey(Sex::Male)?,
                Statistics::survey(Sex::Female)?,
            ])),
            Source::Custom(custom) => Ready::Statistics(Box::new([
                Statistics::custom(Sex::Male, &custom.men)?,
                Statistics::custom(Sex::Female, &custom.women)?,
            ])),
            Source::Survey(survey) => {
                for (sex, share) in [(Sex::Male, proportions.men), (Sex::Female, 1.0 - proportions.men)] {
                    if share > 0.0 && survey.people(sex).is_empty() {
                        return Err(PopulationError::Nobody { sex });
                    }
                }
                Ready::Survey(survey)
            }
            Source::Fixed(person) => {
                person.check()?;
                Ready::Fixed(person)
            }
        };
        Ok(Population { people, proportions, bicycles: BicycleStatistics::default() })
    }

    /// Replaces the statistics of bicycles.
    ///
    /// # Errors
    /// The statistics are impossible.
    pub fn with_bicycles(self, bicycles: BicycleStatistics) -> Result<Population, PopulationError> {
        bicycles.check()?;
        Ok(Population { bicycles, ..self })
    }

    /// Draws one person.
    pub fn draw<R: Rng + ?Sized>(&self, rng: &mut R) -> Person {
        if let Ready::Fixed(person) = self.people {
            return person;
        }
        // `uniform` excludes 0 and 1: a proportion of 0 or 1 excludes the other sex.
        let sex = if uniform(rng) < self.proportions.men { Sex::Male } else { Sex::Female };
        self.draw_of(sex, rng)
    }

    /// Draws one person of a sex whose proportion is not 0.
    fn draw_of<R: Rng + ?Sized>(&self, sex: Sex, rng: &mut R) -> Person {
        match &self.people {
            Ready::Statistics(statistics) => statistics[sex as usize].draw(rng),
            Ready::Survey(survey) => {
                let people = survey.people(sex);
                people[place(rng, people.len())]
            }
            Ready::Fixed(person) => *person,
        }
    }

    /// Draws one agent: a pedestrian or a bicycle.
    pub fn draw_agent<R: Rng + ?Sized>(&self, rng: &mut R) -> Agent {
        if uniform(rng) < self.proportions.pedestrians {
            Agent::Pedestrian(self.draw(rng))
        } else {
            Agent::Bicycle(self.bicycles.draw(rng))
        }
    }

    /// Returns an endless sequence of people, the same for the same seed.
    pub fn people(&self, seed: u64) -> impl Iterator<Item = Person> + use<'_> {
        let mut rng: Generator = generator(seed);
        std::iter::repeat_with(move || self.draw(&mut rng))
    }

    /// Returns an endless sequence of agents, the same for the same seed.
    pub fn agents(&self, seed: u64) -> impl Iterator<Item = Agent> + use<'_> {
        let mut rng: Generator = generator(seed);
        std::iter::repeat_with(move || self.draw_agent(&mut rng))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Shape;
    use std::path::Path;

    fn of(source: Source, men: f64) -> Population {
        Population::new(source, Proportions { men, pedestrians: 1.0 }).unwrap()
    }

    fn custom() -> Source {
        Source::Custom(Box::default())
    }

    fn mean_and_sd(values: &[f64]) -> (f64, f64) {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        (mean, (squares / (values.len() - 1) as f64).sqrt())
    }

    /// Ranks from 0; ties, which continuous draws hardly have, in any order.
    fn ranks(values: &[f64]) -> Vec<f64> {
        let mut order: Vec<usize> = (0..values.len()).collect();
        order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
        let mut ranks = vec![0.0; values.len()];
        for (rank, place) in order.into_iter().enumerate() {
            ranks[place] = rank as f64;
        }
        ranks
    }

    fn correlation(a: &[f64], b: &[f64]) -> f64 {
        let ((mean_a, sd_a), (mean_b, sd_b)) = (mean_and_sd(a), mean_and_sd(b));
        let sum: f64 = a.iter().zip(b).map(|(a, b)| (a - mean_a) * (b - mean_b)).sum();
        sum / (sd_a * sd_b * (a.len() - 1) as f64)
    }

    fn columns(people: &[Person]) -> [Vec<f64>; 4] {
        std::array::from_fn(|place| people.iter().map(|person| person.measures()[place]).collect())
    }

    #[test]
    fn hundred_thousand_people_are_those_of_the_survey() {
        for (sex, men) in [(Sex::Male, 1.0), (Sex::Female, 0.0)] {
            let people: Vec<Person> = of(Source::Ansur, men).people(1).take(100_000).collect();
            assert!(people.iter().all(|person| person.sex == sex && person.check().is_ok()));
            let survey = ansur(sex);
            let drawn = columns(&people);
            for (measure, (values, statistics)) in
                Measure::ALL.into_iter().zip(drawn.iter().zip(&survey.measures))
            {
                let (mean, sd) = mean_and_sd(values);
                let off = [mean / statistics.mean - 1.0, sd / statistics.sd - 1.0];
                assert!(off.iter().all(|off| off.abs() < 0.01), "{sex:?} {measure:?}: {off:?}");
                let mut sorted = values.clone();
                sorted.sort_by(f64::total_cmp);
                let mut worst = 0.0f64;
                for percent in 1..=99 {
                    let table = statistics.quantiles[2 * percent];
                    worst = worst.max((sorted[percent * 1000] - table).abs());
                }
                // 0.5 cm, 1 kg.
                let allowed = if measure == Measure::Mass { 1.0 } else { 0.005 };
                println!(
                    "{} {}: mean {:+.3} %, deviation {:+.3} %, quantiles within {worst:.5} {}",
                    sex.name(),
                    measure.name(),
                    100.0 * off[0],
                    100.0 * off[1],
                    measure.unit()
                );
                assert!(worst < allowed, "{sex:?} {measure:?}: {worst}");
            }
            let ranked = drawn.map(|values| ranks(&values));
            for (row, a) in ranked.iter().enumerate() {
                for (column, b) in ranked.iter().enumerate().skip(row + 1) {
                    let (found, wanted) = (correlation(a, b), survey.spearman[row][column]);
                    println!(
                        "{} rank correlation ({row}, {column}): {found:.4}, survey {wanted}",
                        sex.name()
                    );
                    assert!((found - wanted).abs() < 0.02, "{sex:?} ({row}, {column}): {found} {wanted}");
                }
            }
        }
    }

    #[test]
    fn custom_people_follow_their_statistics_and_belong_together() {
        let statistics = CustomStatistics::default();
        for (men, measures) in [(1.0, statistics.men), (0.0, statistics.women)] {
            let people: Vec<Person> = of(custom(), men).people(2).take(50_000).collect();
            let drawn = columns(&people);
            for (values, normal) in drawn.iter().zip(measures.all()) {
                assert!(values.iter().all(|value| (normal.min..=normal.max).contains(value)));
                let (mean, sd) = mean_and_sd(values);
                assert!((mean / normal.mean - 1.0).abs() < 0.005, "{normal:?}: {mean}");
                assert!((sd / normal.sd - 1.0).abs() < 0.02, "{normal:?}: {sd}");
            }
            let ranked = drawn.map(|values| ranks(&values));
            let found = correlation(&ranked[0], &ranked[3]);
            assert!((found - measures.spearman[0][3]).abs() < 0.02, "{found}");
        }
    }

    #[test]
    fn depth_never_exceeds_breadth() {
        let mut statistics = CustomStatistics::default();
        // One in two candidates is too deep.
        statistics.men.depth.mean = statistics.men.breadth.mean;
        statistics.men.depth.max = 0.8;
        let source = Source::Custom(Box::new(statistics));
        for person in of(source, 1.0).people(3).take(20_000) {
            assert!(person.depth <= person.breadth && Shape::of(&person).is_ok());
        }
        for person in Population::default().people(4).take(20_000) {
            assert!(Shape::of(&person).is_ok());
        }
    }

    #[test]
    fn proportions_are_met() {
        let proportions = Proportions { men: 0.3, pedestrians: 0.8 };
        let population = Population::new(Source::Ansur, proportions).unwrap();
        let agents: Vec<Agent> = population.agents(5).take(50_000).collect();
        let people: Vec<Person> = agents
            .iter()
            .filter_map(|agent| match agent {
                Agent::Pedestrian(person) => Some(*person),
                Agent::Bicycle(bicycle) => {
                    bicycle.check().unwrap();
                    None
                }
            })
            .collect();
        let pedestrians = people.len() as f64 / agents.len() as f64;
        let men = people.iter().filter(|person| person.sex == Sex::Male).count() as f64 / people.len() as f64;
        // Three standard deviations of the counts.
        assert!((pedestrians - 0.8).abs() < 0.0054 && (men - 0.3).abs() < 0.0069, "{pedestrians} {men}");
    }

    /// Bits that another machine must find as well.
    #[test]
    fn the_same_seed_is_the_same_crowd() {
        let population = Population::default();
        let first: Vec<Person> = population.people(42).take(1000).collect();
        let again: Vec<Person> = population.people(42).take(1000).collect();
        assert_eq!(first, again);
        assert_ne!(first[0], population.people(43).next().unwrap());
        let fold = |people: &[Person]| {
            let bits = people.iter().flat_map(Person::measures).map(f64::to_bits);
            bits.fold(0u64, |hash, bits| hash.rotate_left(5).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ bits)
        };
        let custom: Vec<Person> = of(custom(), 0.5).people(42).take(1000).collect();
        assert_eq!([fold(&first), fold(&custom)], [15_789_684_364_619_433_590, 14_494_445_155_975_987_607]);
    }

    #[test]
    fn a_survey_gives_its_own_people() {
        let mut survey = Survey::default();
        let content = b"bideltoidbreadth,chestdepth,stature,weightkg\n493,237,1776,815\n479,253,1702,726\n";
        survey.add(Sex::Male, Path::new("m.csv"), content).unwrap();
        let drawn: Vec<Person> = of(Source::Survey(survey.clone()), 1.0).people(6).take(1000).collect();
        assert!(drawn.iter().all(|person| survey.people(Sex::Male).contains(person)));
        let first = drawn.iter().filter(|person| person.breadth == 0.493).count();
        assert!((420..580).contains(&first), "{first}");
        let error = Population::new(Source::Survey(survey), Proportions::default()).unwrap_err();
        assert_eq!(error.to_string(), "the survey has no female people, but their proportion is not 0");
        let person = Person { sex: Sex::Female, breadth: 0.4, depth: 0.2, stature: 1.6, mass: 55.0 };
        assert!(of(Source::Fixed(person), 1.0).people(7).take(10).all(|drawn| drawn == person));
    }

    #[test]
    fn impossible_populations_are_refused() {
        let message = |source, men, pedestrians| {
            Population::new(source, Proportions { men, pedestrians }).unwrap_err().to_string()
        };
        assert_eq!(message(Source::Ansur, 1.5, 1.0), "proportion of men = 1.5: must be within 0…1");
        assert_eq!(
            message(Source::Ansur, 0.5, f64::NAN),
            "proportion of pedestrians = NaN: must be within 0…1"
        );
        let person = Person { sex: Sex::Male, breadth: 0.5, depth: 0.2, stature: 1.6, mass: -55.0 };
        assert_eq!(
            message(Source::Fixed(person), 0.5, 1.0),
            "the fixed person: mass = -55 kg: must be positive and finite"
        );
        let change = |change: fn(&mut CustomStatistics)| {
            let mut statistics = CustomStatistics::default();
            change(&mut statistics);
            message(Source::Custom(Box::new(statistics)), 0.5, 1.0)
        };
        assert_eq!(
            change(|statistics| statistics.women.mass.sd = 0.0),
            "female statistics, mass: the standard deviation = 0: must be positive"
        );
        assert_eq!(
            change(|statistics| statistics.men.stature.min = 2.5),
            "male statistics, stature: min = 2.5, max = 2.4: min must be below max"
        );
        assert_eq!(
            change(|statistics| statistics.men.spearman[0][1] = 2.0),
            "male statistics: correlation (0, 1) = 2: must be within −1…1, and 1 on the diagonal"
        );
        let deep = change(|statistics| {
            statistics.men.depth = TruncatedNormal { mean: 0.8, sd: 0.02, min: 0.7, max: 0.9 };
        });
        assert_eq!(
            deep,
            "male statistics: chest depth exceeds bideltoid breadth in 2000 of 2000 draws: few people are possible"
        );
        let mut bicycles = BicycleStatistics::default();
        bicycles.mass.mean = 1e6;
        let error = Population::default().with_bicycles(bicycles).unwrap_err();
        assert!(
            error
                .to_string()
                .starts_with("bicycle's mass: min = 10, max = 100: more than 6 standard deviations"),
            "{error}"
        );
    }
}
