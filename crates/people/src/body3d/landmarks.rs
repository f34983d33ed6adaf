//! Measures of a person that follow from the four given ones, and altitudes of landmarks.

use super::measures::{COUNT, Measure, mean_body};
use crate::person::Person;

/// Altitude of the torso, where breadth and depth are measured, as a fraction of the stature (the paper: 151.6 cm of
/// 186.6 cm).
pub const TORSO_ALTITUDE: f64 = 0.8124;

/// \[m\] All measures of a person.
pub(super) struct Measures {
    values: [f64; COUNT],
    /// The given measures.
    pub person: Person,
}

impl Measures {
    /// Conditional means of the measures, given the four, for a multivariate normal distribution. Girths and breadths
    /// are kept between half and twice the mean; no person is outside.
    pub(super) fn of(person: &Person) -> Measures {
        let mean = mean_body(person.sex);
        let given = person.measures();
        let values = std::array::from_fn(|k| {
            let [mean_value, slopes @ ..] = mean.measures[k];
            let follows: f64 = (0..4).map(|g| slopes[g] * (given[g] - mean.given[g])).sum();
            (mean_value + follows).clamp(0.5 * mean_value, 2.0 * mean_value)
        });
        Measures { values, person: *person }
    }

    pub(super) fn get(&self, measure: Measure) -> f64 {
        self.values[measure as usize]
    }
}

/// \[m\] Altitudes of landmarks, from low to high.
pub(super) struct Heights {
    pub malleolus: f64,
    pub tibial: f64,
    pub knee: f64,
    pub crotch: f64,
    pub buttock: f64,
    pub waist: f64,
    pub rib: f64,
    pub chest: f64,
    pub axilla: f64,
    pub torso: f64,
    pub shoulder: f64,
    pub trapezius: f64,
    pub neck: f64,
    pub throat: f64,
    pub chin: f64,
    pub wrist: f64,
    pub elbow: f64,
    pub fingertip: f64,
}

impl Heights {
    /// Each altitude is at least a little above the one before, for any person.
    pub(super) fn of(m: &Measures) -> Heights {
        use Measure as M;
        let stature = m.person.stature;
        let step = 0.012 * stature / 1.75;
        let mut floor = 0.0;
        let mut above = |z: f64, gap: f64| {
            floor = z.max(floor + gap * step);
            floor
        };
        let malleolus = above(m.get(M::MalleolusHeight), 3.0);
        let tibial = above(m.get(M::TibialHeight), 8.0);
        let knee = above(m.get(M::KneeHeight), 1.0);
        let torso = TORSO_ALTITUDE * stature;
        // Landmarks below the torso's altitude leave enough room for those between.
        let below = |z: f64, gaps: f64| z.min(torso - gaps * step);
        let crotch = above(below(m.get(M::CrotchHeight), 20.0), 10.0);
        let buttock = above(below(m.get(M::ButtockHeight), 17.0), 3.0);
        let waist = above(below(m.get(M::WaistHeight), 12.0), 4.0);
        let rib = above(below(m.get(M::TenthRibHeight), 9.0), 2.0);
        let chest = above(below(m.get(M::ChestHeight), 6.0), 2.0);
        let axilla = above(below(m.get(M::AxillaHeight), 4.0), 1.0);
        // The face: chin to top is 1.77 times tragion to top.
        let chin = (stature - 1.77 * m.get(M::TragionToTop)).max(torso + 6.0 * step);
        let between = |share: f64| torso + share * (chin - torso);
        let acromial = (m.get(M::AcromialHeight) + 0.012).clamp(between(0.27), between(0.36));
        let elbow = (m.get(M::AcromialHeight) - m.get(M::UpperArmLength)).min(axilla - 8.0 * step);
        let wrist = m.get(M::WristHeight).min(elbow - 10.0 * step);
        let fingertip = (wrist - m.get(M::HandLength)).max(0.05 * stature);
        Heights {
            malleolus,
            tibial,
            knee,
            crotch,
            buttock,
            waist,
            rib,
            chest,
            axilla,
            torso,
            shoulder: acromial,
            trapezius: between(0.58),
            neck: between(0.78),
            throat: between(0.9),
            chin,
            wrist,
            elbow,
            fingertip,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::measures::TABLE;
    use super::*;
    use crate::person::Sex;

    /// The table against the survey's summary: means, and residuals that do not correlate with what is given.
    #[test]
    fn measures_follow_the_survey() {
        let Some(path) = lemons_verify::testing::shared("anthropometry/ansur_body_summary.json") else {
            return;
        };
        let text = std::fs::read_to_string(path).unwrap();
        let data: serde_json::Value = serde_json::from_str(&text).unwrap();
        let names = TABLE.lines().filter_map(|line| line.split_once(' ')).map(|(name, _)| name);
        let names: Vec<&str> = names.skip_while(|name| *name != "male").skip(1).take(COUNT).collect();
        for sex in Sex::ALL {
            let (table, sex) = (mean_body(sex), sex.name());
            let survey = &data[sex];
            let order: Vec<&str> =
                survey["order"].as_array().unwrap().iter().map(|v| v.as_str().unwrap()).collect();
            let place = |name: &str| order.iter().position(|&other| other == name).unwrap();
            let unit = |name: &str| if name == "weightkg" { 1.0 } else { 0.01 };
            let value = |what: &str, name: &str| survey[what][name].as_f64().unwrap() * unit(name);
            // Pearson's coefficient of a normal pair by its rank correlation.
            let correlation = |a: &str, b: &str| {
                let rho = survey["spearman"][place(a)][place(b)].as_f64().unwrap();
                if a == b { 1.0 } else { 2.0 * libm::sin(std::f64::consts::PI * rho / 6.0) }
            };
            let given = ["bideltoidbreadth", "chestdepth", "stature", "weightkg"];
            for (k, name) in given.iter().enumerate() {
                assert!((value("mean", name) - table.given[k]).abs() < 1e-5, "{sex} {name}");
            }
            for (name, [mean, slopes @ ..]) in names.iter().zip(table.measures) {
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
