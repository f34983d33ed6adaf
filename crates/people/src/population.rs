//! Populations: from which statistics people are drawn, and how many of each kind.

use crate::anthropometry::{SexStatistics, ansur};
use crate::bicycle::{BICYCLE_MEASURES, Bicycle, PAPER_BICYCLES};
use crate::copula::{Copula, Correlations};
use crate::error::{Result, require};
use crate::normal::TruncatedNormal;
use crate::person::{Measure, Person, Sex};
use crate::random::Random;
use crate::survey::Survey;

/// The source of the people of a [`Population`].
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// The statistics of the public survey ANSUR II, see [`ansur`].
    Ansur,
    /// Custom statistics, in the order of [`Sex::ALL`].
    Custom(Box<[CustomMeasures; 2]>),
    /// Real people, drawn with replacement.
    Survey(Survey),
    /// Always the same person. The proportion of men then has no effect.
    Fixed(Person),
}

/// Custom statistics for one sex.
#[derive(Debug, Clone, PartialEq)]
pub struct CustomMeasures {
    /// Distributions \[m, kg\] of the measures, in the order of [`Measure::ALL`].
    pub measures: [TruncatedNormal; 4],
    /// Spearman's rank correlations between them, in the order of [`Measure::ALL`]. Where no four measures can have all
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
            let units = if Measure::ALL[k] == Measure::Mass { 1.0 } else { 100.0 };
            let [mean, sd, min, max] = measures[k].map(|value: f64| value / units);
            TruncatedNormal { mean, sd, min, max }
        });
        CustomMeasures { measures, spearman: ansur(sex).spearman }
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
    fn survey(sex: Sex) -> Result<Statistics> {
        let survey = ansur(sex);
        Ok(Statistics { sex, copula: copula(sex, &survey.spearman)?, margins: Margins::Survey(survey) })
    }

    fn custom(sex: Sex, custom: &CustomMeasures) -> Result<Statistics> {
        let name = sex.name();
        for (measure, normal) in Measure::ALL.into_iter().zip(custom.measures) {
            let (what, unit) = (measure.name(), measure.unit());
            normal.check().map_err(|error| error.of(format!("{name} statistics, {what}")))?;
            let [least, most] = measure.possible();
            for (limit, value) in [("min", normal.min), ("max", normal.max)] {
                require((least..=most).contains(&value), || {
                    format!(
                        "{name} statistics, {what}: {limit} = {value:.3} {unit}: measures of people are {least} to {most} {unit}"
                    )
                })?;
            }
        }
        let copula = copula(sex, &custom.spearman)?;
        let statistics = Statistics { sex, copula, margins: Margins::Custom(custom.measures) };
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

fn copula(sex: Sex, spearman: &Correlations) -> Result<Copula> {
    Copula::new(spearman).map_err(|error| error.of(format!("{} statistics", sex.name())))
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
    bicycles: [TruncatedNormal; 5],
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
    pub fn new(source: Source, proportions: Proportions) -> Result<Population> {
        for (of, value) in [("men", proportions.men), ("pedestrians", proportions.pedestrians)] {
            require((0.0..=1.0).contains(&value), || {
                format!("proportion of {of} = {value}: must be within 0…1")
            })?;
        }
        let people = match source {
            Source::Ansur => Ready::Statistics(Box::new([
                Statistics::survey(Sex::Male)?,
                Statistics::survey(Sex::Female)?,
            ])),
            Source::Custom(custom) => Ready::Statistics(Box::new([
                Statistics::custom(Sex::Male, &custom[0])?,
                Statistics::custom(Sex::Female, &custom[1])?,
            ])),
            Source::Survey(survey) => {
                for (sex, share) in [(Sex::Male, proportions.men), (Sex::Female, 1.0 - proportions.men)] {
                    require(share == 0.0 || !survey.people(sex).is_empty(), || {
                        format!("the survey has no {} people, but their proportion is not 0", sex.name())
                    })?;
                }
                Ready::Survey(survey)
            }
            Source::Fixed(person) => {
                person.check().map_err(|error| error.of("the fixed person"))?;
                Ready::Fixed(person)
            }
        };
        Ok(Population { people, proportions, bicycles: PAPER_BICYCLES })
    }

    /// Replaces the distributions of the measures of bicycles.
    ///
    /// # Errors
    /// A distribution is impossible.
    pub fn with_bicycles(self, bicycles: [TruncatedNormal; 5]) -> Result<Population> {
        for ((measure, _), normal) in BICYCLE_MEASURES.into_iter().zip(bicycles) {
            normal.check().map_err(|error| error.of(format!("bicycle's {measure}")))?;
        }
        Ok(Population { bicycles, ..self })
    }

    /// Draws one person.
    fn draw(&self, random: &mut Random) -> Person {
        if let Ready::Fixed(person) = self.people {
            return person;
        }
        // `uniform` excludes 0 and 1: a proportion of 0 or 1 excludes the other sex.
        let sex = if random.inside_unit() < self.proportions.men { Sex::Male } else { Sex::Female };
        match &self.people {
            Ready::Statistics(statistics) => statistics[sex as usize].draw(random),
            Ready::Survey(survey) => {
                let people = survey.people(sex);
                people[random.index(people.len())]
            }
            Ready::Fixed(person) => *person,
        }
    }

    /// Draws one agent: a pedestrian or a bicycle.
    fn draw_agent(&self, random: &mut Random) -> Agent {
        if random.inside_unit() < self.proportions.pedestrians {
            return Agent::Pedestrian(self.draw(random));
        }
        Agent::Bicycle(Bicycle::from_measures(
            self.bicycles.map(|normal| normal.quantile(random.inside_unit())),
        ))
    }

    /// Returns an endless sequence of people, the same for the same seed.
    pub fn people(&self, seed: u64) -> impl Iterator<Item = Person> + use<'_> {
        let mut random = Random::new(seed);
        std::iter::repeat_with(move || self.draw(&mut random))
    }

    /// Returns an endless sequence of agents, the same for the same seed.
    pub fn agents(&self, seed: u64) -> impl Iterator<Item = Agent> + use<'_> {
        let mut random = Random::new(seed);
        std::iter::repeat_with(move || self.draw_agent(&mut random))
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

    fn custom(change: impl FnOnce(&mut [CustomMeasures; 2])) -> Source {
        let mut statistics = Sex::ALL.map(CustomMeasures::paper);
        change(&mut statistics);
        Source::Custom(Box::new(statistics))
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
                assert!(worst < allowed, "{sex:?} {measure:?}: {worst}");
            }
            let ranked = drawn.map(|values| ranks(&values));
            for (row, a) in ranked.iter().enumerate() {
                for (column, b) in ranked.iter().enumerate().skip(row + 1) {
                    let (found, wanted) = (correlation(a, b), survey.spearman[row][column]);
                    assert!((found - wanted).abs() < 0.02, "{sex:?} ({row}, {column}): {found} {wanted}");
                }
            }
        }
    }

    /// Within the bounds, with the mean and the deviation: the bounds are three deviations away or more.
    fn follows(values: &[f64], normal: &TruncatedNormal) {
        assert!(values.iter().all(|value| (normal.min..=normal.max).contains(value)));
        let (mean, sd) = mean_and_sd(values);
        assert!((mean / normal.mean - 1.0).abs() < 0.005, "{normal:?}: {mean}");
        assert!((sd / normal.sd - 1.0).abs() < 0.02, "{normal:?}: {sd}");
    }

    #[test]
    fn custom_people_follow_their_statistics_and_belong_together() {
        for (sex, men) in [(Sex::Male, 1.0), (Sex::Female, 0.0)] {
            let statistics = CustomMeasures::paper(sex);
            let people: Vec<Person> = of(custom(|_| {}), men).people(2).take(50_000).collect();
            let drawn = columns(&people);
            drawn.iter().zip(&statistics.measures).for_each(|(values, normal)| follows(values, normal));
            let ranked = drawn.map(|values| ranks(&values));
            let found = correlation(&ranked[0], &ranked[3]);
            assert!((found - statistics.spearman[0][3]).abs() < 0.02, "{found}");
        }
    }

    #[test]
    fn depth_never_exceeds_breadth() {
        // One in two candidates is too deep.
        let source = custom(|statistics| {
            statistics[0].measures[1].mean = statistics[0].measures[0].mean;
            statistics[0].measures[1].max = 0.8;
        });
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
        let (mut people, mut bicycles) = (Vec::new(), Vec::new());
        for agent in &agents {
            match agent {
                Agent::Pedestrian(person) => people.push(*person),
                Agent::Bicycle(bicycle) => bicycles.push(bicycle.measures()),
            }
        }
        for (place, normal) in PAPER_BICYCLES.iter().enumerate() {
            follows(&bicycles.iter().map(|measures| measures[place]).collect::<Vec<f64>>(), normal);
        }
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
        let custom: Vec<Person> = of(custom(|_| {}), 0.5).people(42).take(1000).collect();
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
        let change = |change: fn(&mut CustomMeasures)| message(custom(|[men, _]| change(men)), 0.5, 1.0);
        assert_eq!(
            change(|men| men.measures[3].sd = 0.0),
            "male statistics, mass: the standard deviation = 0: must be positive"
        );
        assert_eq!(
            change(|men| men.measures[2].max = 4.0),
            "male statistics, stature: max = 4.000 m: measures of people are 0.3 to 3 m"
        );
        assert_eq!(
            change(|men| men.spearman[0][1] = 2.0),
            "male statistics: correlation (0, 1) = 2: must be within −1…1, and 1 on the diagonal"
        );
        let deep = TruncatedNormal { mean: 0.8, sd: 0.02, min: 0.7, max: 0.9 };
        assert_eq!(
            message(custom(|[men, _]| men.measures[1] = deep), 0.5, 1.0),
            "male statistics: chest depth exceeds bideltoid breadth in 2000 of 2000 draws: few people are possible"
        );
        let mut bicycles = PAPER_BICYCLES;
        bicycles[4].mean = 1e6;
        let error = Population::default().with_bicycles(bicycles).unwrap_err().to_string();
        assert!(error.starts_with("bicycle's mass: min = 10, max = 100: more than 6"), "{error}");
    }
}
