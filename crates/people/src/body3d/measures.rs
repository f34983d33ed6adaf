//! The mean body of each sex, and how its measures follow the four of a person.
//!
//! Measures have the names of the survey's columns. All are in m:
//!
//! - `acromialheight`: height of the bony tip of the shoulder
//! - `axillaheight`: height of the armpit
//! - `chestheight`: height of the nipples
//! - `tenthribheight`: height of the lowest rib
//! - `waistheightomphalion`: height of the navel
//! - `buttockheight`: height of the most prominent point of the buttocks
//! - `crotchheight`: height of the crotch
//! - `kneeheightmidpatella`: height of the middle of the kneecap
//! - `tibialheight`: height of the top of the shinbone
//! - `lateralmalleolusheight`: height of the outer ankle bone
//! - `wristheight`: height of the wrist
//! - `tragiontopofhead`: from the ear's notch up to the top of the head
//! - `acromionradialelength`: from the shoulder's tip to the elbow
//! - `handlength`: from the wrist to the fingertip
//! - `biacromialbreadth`: between the tips of the shoulders
//! - `chestbreadth`: at the nipples
//! - `waistbreadth`: at the navel
//! - `waistdepth`: at the navel
//! - `hipbreadth`: widest of the hips
//! - `buttockdepth`: at the buttocks
//! - `headbreadth`: widest above the ears
//! - `headlength`: from the brow to the back of the head
//! - `footlength`: heel to toe
//! - `footbreadthhorizontal`: widest of the foot
//! - `handbreadth`: across the knuckles
//! - `chestcircumference`: at the nipples
//! - `waistcircumference`: at the navel
//! - `buttockcircumference`: at the buttocks
//! - `headcircumference`: above the brow
//! - `neckcircumference`: at the larynx
//! - `neckcircumferencebase`: at the root of the neck
//! - `bicepscircumferenceflexed`: flexed
//! - `forearmcircumferenceflexed`: flexed
//! - `wristcircumference`: at the wrist
//! - `thighcircumference`: just below the buttocks
//! - `lowerthighcircumference`: just above the kneecap
//! - `calfcircumference`: widest of the calf
//! - `anklecircumference`: narrowest above the ankle

use crate::person::{Person, Sex};
use std::collections::HashMap;
use std::sync::LazyLock;

/// The mean body of one sex.
pub(super) struct MeanBody {
    /// \[m, m, m, kg\] means of bideltoid breadth, chest depth, stature, mass.
    pub given: [f64; 4],
    /// Of each measure: mean \[m\], then its slopes with respect to the four given ones.
    pub measures: HashMap<&'static str, [f64; 5]>,
}

/// Returns the mean body, of the table that `data/body_measures.py` made from the survey ANSUR II.
pub(super) fn mean_body(sex: Sex) -> &'static MeanBody {
    static BODIES: LazyLock<[MeanBody; 2]> = LazyLock::new(|| {
        parse(include_str!("../../data/bodies.txt"))
            .expect("the committed data file is whole, every test of bodies reads it")
    });
    &BODIES[sex as usize]
}

/// Each line: a name, then numbers; first the means of the given measures.
fn parse(text: &'static str) -> Option<[MeanBody; 2]> {
    let mut bodies = Vec::new();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let (name, numbers) = line.split_once(' ')?;
        let numbers = numbers.split(' ').map(|number| number.parse().ok()).collect::<Option<Vec<f64>>>()?;
        match <[f64; 4]>::try_from(&numbers[..]) {
            Ok(given) => bodies.push(MeanBody { given, measures: HashMap::new() }),
            Err(_) => drop(bodies.last_mut()?.measures.insert(name, numbers.try_into().ok()?)),
        }
    }
    bodies.try_into().ok()
}

/// \[m\] All measures of a person.
pub(super) struct Measures {
    values: HashMap<&'static str, f64>,
    /// The given measures.
    pub person: Person,
}

impl Measures {
    /// Conditional means of the measures, given the four, for a multivariate normal distribution. Girths and breadths
    /// are kept between half and twice the mean; no person is outside.
    pub(super) fn of(person: &Person) -> Measures {
        let MeanBody { given: means, measures } = mean_body(person.sex);
        let given = person.measures();
        let value = |(name, [mean, slopes @ ..]): (&&'static str, &[f64; 5])| {
            let follows: f64 = (0..4).map(|g| slopes[g] * (given[g] - means[g])).sum();
            (*name, (mean + follows).clamp(0.5 * mean, 2.0 * mean))
        };
        Measures { values: measures.iter().map(value).collect(), person: *person }
    }

    /// Returns a measure \[m\] by its name in the survey.
    pub(super) fn get(&self, name: &str) -> f64 {
        self.values[name]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The table against the survey's summary: means, and residuals that do not correlate with what is given.
    #[test]
    fn measures_follow_the_survey() {
        let Some(path) = lemons_testing::shared("anthropometry/ansur_body_summary.json") else {
            return;
        };
        let text = std::fs::read_to_string(path).unwrap();
        let data: serde_json::Value = serde_json::from_str(&text).unwrap();
        for sex in Sex::ALL {
            let (table, sex) = (mean_body(sex), sex.name());
            let survey = &data[sex];
            let order = survey["order"].as_array().unwrap();
            let place = |name: &str| order.iter().position(|other| other == name).unwrap();
            let unit = |name: &str| if name == "weightkg" { 1.0 } else { 0.01 };
            let value = |what: &str, name: &str| survey[what][name].as_f64().unwrap() * unit(name);
            // Pearson's coefficient of a normal pair by its rank correlation.
            let correlation = |a: &str, b: &str| {
                let rho = survey["spearman"][place(a)][place(b)].as_f64().unwrap();
                if a == b { 1.0 } else { 2.0 * libm::sin(std::f64::consts::PI * rho / 6.0) }
            };
            let given = ["bideltoidbreadth", "chestdepth", "stature", "weightkg"];
            for (name, mean) in given.iter().zip(table.given) {
                assert!((value("mean", name) - mean).abs() < 1e-5, "{sex} {name}");
            }
            assert_eq!(table.measures.len(), 38);
            for (name, [mean, slopes @ ..]) in &table.measures {
                assert!((value("mean", name) - mean).abs() < 1e-5, "{sex} {name}");
                for j in given {
                    let explained: f64 =
                        (0..4).map(|k| slopes[k] * value("sd", given[k]) * correlation(given[k], j)).sum();
                    let rest = correlation(name, j) - explained / value("sd", name);
                    // Slopes have six decimals.
                    assert!(rest.abs() < 0.003, "{sex} {name} with {j}: {rest}");
                }
            }
        }
    }
}
