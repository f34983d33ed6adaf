use super::*;
use crate::kinds::Kinds;
use std::path::Path;

fn of(source: PopulationSource, men: f64, seed: u64, count: usize) -> Vec<Person> {
    let population = Population::new(source, men);
    population.unwrap().agents(seed).take(count).map(|agent| agent.people()[0].0).collect()
}

fn ansur_source() -> PopulationSource {
    PopulationSource::ansur().unwrap()
}

fn custom(change: impl FnOnce(&mut [CustomMeasures; 2])) -> Result<PopulationSource> {
    let mut statistics = Sex::ALL.map(CustomMeasures::paper);
    change(&mut statistics);
    PopulationSource::custom(&statistics)
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
        let people = of(ansur_source(), men, 1, 100_000);
        assert!(people.iter().all(|person| person.sex == sex && person.check().is_ok()));
        let survey = ansur(sex);
        let drawn = columns(&people);
        for (measure, (values, statistics)) in
            BodyMeasure::ALL.into_iter().zip(drawn.iter().zip(&survey.measures))
        {
            let (mean, sd) = mean_and_sd(values);
            let off = [mean / statistics.mean - 1.0, sd / statistics.sd - 1.0];
            assert!(off.iter().all(|off| off.abs() < 0.01), "{sex:?} {measure:?}: {off:?}");
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
        let people = of(custom(|_| {}).unwrap(), men, 2, 50_000);
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
    for person in [of(source.unwrap(), 1.0, 3, 20_000), of(ansur_source(), 0.5, 4, 20_000)].concat() {
        assert!(person.depth <= person.breadth && Shape::of(&person).is_ok());
    }
}

#[test]
fn proportions_are_met() {
    let bicycle = Kinds::built_in().unwrap().get("bicycle").unwrap().clone();
    let population = Population::new(ansur_source(), 0.3).unwrap();
    let refused = population.clone().with_riders(f64::NAN, bicycle.clone()).unwrap_err().to_string();
    assert_eq!(refused, "proportion of pedestrians = NaN: must be within 0…1");
    let population = population.with_riders(0.8, bicycle).unwrap();
    let agents: Vec<CrowdMember> = population.agents(5).take(50_000).collect();
    let people: Vec<Person> = agents.iter().flat_map(CrowdMember::everybody).collect();
    let bicycles = agents.iter().filter_map(|agent| agent.member()?.bicycle);
    let bicycles: Vec<[f64; 5]> = bicycles.map(|bicycle| bicycle.measures()).collect();
    for (place, normal) in PAPER_BICYCLES.iter().enumerate() {
        follows(&bicycles.iter().map(|measures| measures[place]).collect::<Vec<f64>>(), normal);
    }
    let pedestrians = 1.0 - bicycles.len() as f64 / agents.len() as f64;
    let men = people.iter().filter(|person| person.sex == Sex::Male).count() as f64 / people.len() as f64;
    // Three standard deviations of the counts.
    assert!((pedestrians - 0.8).abs() < 0.0054 && (men - 0.3).abs() < 0.0069, "{pedestrians} {men}");
}

/// Bits that another machine must find as well.
#[test]
fn the_same_seed_is_the_same_crowd() {
    let drawn = |seed| of(ansur_source(), 0.5, seed, 1000);
    let first = drawn(42);
    assert_eq!(first, drawn(42));
    assert_ne!(first[0], drawn(43)[0]);
    let fold = |people: &[Person]| {
        let bits = people.iter().flat_map(Person::measures).map(f64::to_bits);
        bits.fold(0u64, |hash, bits| hash.rotate_left(5).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ bits)
    };
    let custom = of(custom(|_| {}).unwrap(), 0.5, 42, 1000);
    assert_eq!([fold(&first), fold(&custom)], [9_565_764_317_232_420_663, 17_214_876_747_763_847_768]);
}

#[test]
fn a_survey_gives_its_own_people() {
    let mut survey = Survey::default();
    let content = b"bideltoidbreadth,chestdepth,stature,weightkg\n493,237,1776,815\n479,253,1702,726\n";
    survey.add(Sex::Male, Path::new("m.csv"), content).unwrap();
    let drawn = of(PopulationSource::Survey(survey.clone()), 1.0, 6, 1000);
    assert!(drawn.iter().all(|person| survey.people(Sex::Male).contains(person)));
    let first = drawn.iter().filter(|person| person.breadth == 0.493).count();
    assert!((420..580).contains(&first), "{first}");
    let person = Person { sex: Sex::Female, breadth: 0.4, depth: 0.2, stature: 1.6, mass: 55.0 };
    assert!(of(PopulationSource::Fixed(person), 1.0, 7, 10).into_iter().all(|drawn| drawn == person));
    let message = |source, men| Population::new(source, men).unwrap_err().to_string();
    assert_eq!(
        message(PopulationSource::Survey(survey), 0.5),
        "the survey has no female people, but their proportion is not 0"
    );
    assert_eq!(message(ansur_source(), 1.5), "proportion of men = 1.5: must be within 0…1");
    assert_eq!(message(ansur_source(), f64::NAN), "proportion of men = NaN: must be within 0…1");
    let wrong = PopulationSource::Fixed(Person { mass: -55.0, ..person });
    let refusal = message(wrong, 0.5);
    assert_eq!(refusal, "the fixed person: mass = -55 kg: must be positive and finite");
    let mut bicycles = PAPER_BICYCLES;
    bicycles[4].mean = 1e6;
    let refusal = Population::new(ansur_source(), 0.5).unwrap().with_bicycles(bicycles);
    let refusal = refusal.unwrap_err().to_string();
    assert!(refusal.starts_with("bicycle's mass: min = 10, max = 100: more than 6"), "{refusal}");
    for (place, min, max, message) in [
        (2, 0.0, 5e-322, "bicycle's handlebar: min = 0 m: bicycles have 0.1 to 2 m"),
        (1, 1.0, 1e305, "bicycle's length: max = 1"),
        (4, f64::NAN, 2.0, "bicycle's mass"),
    ] {
        let mut bicycles = PAPER_BICYCLES;
        bicycles[place] = TruncatedNormal { mean: 1.0, sd: 1e300, min, max };
        let refused = Population::new(ansur_source(), 0.5).unwrap().with_bicycles(bicycles).unwrap_err();
        assert!(refused.to_string().starts_with(message), "{refused}");
    }
}

#[test]
fn a_mix_has_its_shares_ages_and_speeds() {
    let shares = [("adult", 60.0), ("child", 25.0), ("elderly", 15.0)];
    let shares = shares.map(|(name, share)| (name.to_owned(), share)).into();
    let mix = Kinds::built_in().unwrap().mix(&shares).unwrap();
    let population = Population::new(ansur_source(), 0.5).unwrap().mixed(mix);
    let drawn: Vec<CrowdMember> = population.agents(9).take(20_000).collect();
    assert_eq!(drawn, population.agents(9).take(20_000).collect::<Vec<CrowdMember>>());
    let of = |name: &str| -> Vec<&Member> {
        drawn.iter().filter_map(CrowdMember::member).filter(|of| of.kind.name == name).collect()
    };
    let part = |name: &str| of(name).len() as f64 / drawn.len() as f64;
    // Three standard deviations of the counts.
    for (name, share) in [("adult", 0.60), ("child", 0.25), ("elderly", 0.15)] {
        assert!((part(name) - share).abs() < 3.0 * (share * (1.0 - share) / 2e4).sqrt(), "{name}");
    }
    let children = of("child");
    let statures: Vec<f64> = children.iter().map(|child| child.people[0].0.stature).collect();
    // The mean of the medians of boys (1.353 m) and girls (1.332 m) from 2 to 17 years, by trapezoids.
    let (mean, _) = mean_and_sd(&statures);
    assert!((mean - 1.343).abs() < 0.01, "{mean}");
    assert!(statures.iter().all(|stature| (0.73..2.05).contains(stature)));
    let pairs: Vec<f64> =
        children.iter().map(|child| child.mass / child.people[0].0.stature.powi(2)).collect();
    // Body mass index \[kg/m²\]: 16 at 6 years, 21 at 17.
    assert!((16.5..19.0).contains(&mean_and_sd(&pairs).0));
    for elder in of("elderly") {
        let [low, high] = if elder.people[0].0.sex == Sex::Male { [0.84, 1.4] } else { [0.56, 0.94] };
        assert!((low..=high).contains(&elder.speed));
    }
    let (mean, sd) = mean_and_sd(&of("adult").iter().map(|adult| adult.speed).collect::<Vec<f64>>());
    assert!((mean - 1.34).abs() < 0.01 && (sd - 0.256).abs() < 0.01, "{mean} {sd}");
}

#[test]
fn impossible_statistics_are_refused() {
    let deep = TruncatedNormal { mean: 0.8, sd: 0.02, min: 0.7, max: 0.9 };
    type Change = fn(&mut CustomMeasures, TruncatedNormal);
    let changes: [(Change, &str); 4] = [
        (|men, _| men.measures[3].sd = 0.0, ", mass: the standard deviation = 0: must be positive"),
        (|men, _| men.measures[2].max = 4.0, ", stature: max = 4.000 m: measures of people are 0.3 to 3 m"),
        (
            |men, _| men.spearman[0][1] = 2.0,
            ": correlation (0, 1) = 2: must be within −1…1, and 1 on the diagonal",
        ),
        (
            |men, deep| men.measures[1] = deep,
            ": chest depth exceeds bideltoid breadth in 2000 of 2000 draws: few people are possible",
        ),
    ];
    for (change, message) in changes {
        let refused = custom(|[men, _]| change(men, deep)).unwrap_err();
        assert_eq!(refused.to_string(), format!("male statistics{message}"));
    }
}
