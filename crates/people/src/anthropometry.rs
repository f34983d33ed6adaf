//! Statistics of the US Army's survey ANSUR II (2012, public; 4081 men, 1986 women): bideltoid breadth, chest depth,
//! stature and mass. These are measured values, not what people reported of themselves.
//!
//! `data/make_ansur.py` wrote them into `data/ansur.txt`.

use crate::copula::Correlations;
use crate::person::{BodyMeasure, Sex};
use lemons_core::distribution::bisected;
use std::sync::LazyLock;

/// Number of cells of the quantile tables; each is 0.5 % wide.
const CELLS: usize = 200;

/// The distribution of a measure.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasureStatistics {
    /// \[m or kg\] mean of the survey.
    pub mean: f64,
    /// \[m or kg\] standard deviation of the survey.
    pub sd: f64,
    /// \[m or kg\] the quantiles 0, 0.5 %, …, 100 %.
    pub quantiles: Vec<f64>,
    /// Exponent for the outermost cells, which are half a percent wide. The few people in them are not evenly
    /// distributed but closer to the inner end. A value moves from the extreme by this power of its relative position
    /// in the cell. With it the distribution has the survey's standard deviation.
    tail: f64,
}

impl MeasureStatistics {
    /// Returns the value \[m or kg\] below which the fraction `rank` (0…1) of the people lies. It is linear between the
    /// quantiles of the table.
    pub fn quantile(&self, rank: f64) -> f64 {
        let place = rank.clamp(0.0, 1.0) * CELLS as f64;
        let cell = (place as usize).min(CELLS - 1);
        let (left, right) = (self.quantiles[cell], self.quantiles[cell + 1]);
        let way = place - cell as f64;
        if cell == 0 {
            left + (right - left) * libm::pow(way, self.tail)
        } else if cell == CELLS - 1 {
            right - (right - left) * libm::pow(1.0 - way, self.tail)
        } else {
            left + (right - left) * way
        }
    }

    /// Returns the fraction of the people below a value \[m or kg\], by bisection of [`quantile`](Self::quantile). Where
    /// many have the same value: in their middle.
    pub fn rank(&self, value: f64) -> f64 {
        if value < self.quantiles[0] {
            return 0.0;
        }
        let from = |below: &dyn Fn(f64) -> bool| {
            let (_, high) = bisected([0.0, 1.0], 40, |rank| below(self.quantile(rank)));
            if below(self.quantile(1.0)) { 1.0 } else { high }
        };
        0.5 * (from(&|found| found < value) + from(&|found| found <= value))
    }
}

/// Statistics of the people of one sex.
#[derive(Debug, Clone, PartialEq)]
pub struct SexStatistics {
    /// Number of people who were measured.
    pub count: u32,
    /// The measures, in the order of [`BodyMeasure::ALL`].
    pub measures: [MeasureStatistics; 4],
    /// Spearman's rank correlations, in the order of [`BodyMeasure::ALL`].
    pub spearman: Correlations,
}

/// Returns the statistics of one sex.
pub fn ansur(sex: Sex) -> &'static SexStatistics {
    static SURVEY: LazyLock<[SexStatistics; 2]> = LazyLock::new(|| {
        parse(include_str!("../data/ansur.txt")).expect("the committed data file is whole, a test reads it")
    });
    &SURVEY[sex as usize]
}

/// Reads the data file word by word; `None` if it is damaged.
fn parse(text: &str) -> Option<[SexStatistics; 2]> {
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    let is_number = |word: &&str| !word.starts_with(char::is_alphabetic);
    let mut numbers = lines.flat_map(str::split_whitespace).filter(is_number).map(str::parse::<f64>);
    let mut number = || numbers.next()?.ok();
    let mut of_a_sex = || {
        let count = number()? as u32;
        let mut measures = Vec::new();
        for measure in BodyMeasure::ALL {
            // Lengths are in 10 µm, masses in g.
            let units = if measure == BodyMeasure::Mass { 1e3 } else { 1e5 };
            let (mean, sd, tail) = (number()? / units, number()? / units, number()?);
            let quantiles = (0..=CELLS).map(|_| Some(number()? / units)).collect::<Option<_>>()?;
            measures.push(MeasureStatistics { mean, sd, quantiles, tail });
        }
        let mut spearman = [[1.0; 4]; 4];
        for (row, column) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
            let value = number()? / 1e4;
            (spearman[row][column], spearman[column][row]) = (value, value);
        }
        Some(SexStatistics { count, measures: measures.try_into().ok()?, spearman })
    };
    Some([of_a_sex()?, of_a_sex()?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;

    /// The tables against the summary of the survey that they were made from.
    #[test]
    fn the_tables_are_those_of_the_survey() {
        let Some(path) = lemons_testing::shared("anthropometry/ansur_summary.json") else { return };
        let text = std::fs::read_to_string(path).unwrap();
        let summary: Value = serde_json::from_str(&text).unwrap();
        let columns = ["bideltoid_breadth_cm", "chest_depth_cm", "stature_measured_cm", "weight_measured_kg"];
        for sex in Sex::ALL {
            let (part, ours) = (&summary[sex.name()], ansur(sex));
            assert_eq!(part["n_used"], ours.count);
            let order = part["order"].as_array().unwrap();
            let places = columns.map(|column| order.iter().position(|name| name == column).unwrap());
            for (place, column) in columns.into_iter().enumerate() {
                let (theirs, ours) = (&part["measures"][column], &ours.measures[place]);
                let unit = if column.ends_with("kg") { 1.0 } else { 100.0 };
                let close = |a: &Value, b: f64| (a.as_f64().unwrap() - b * unit).abs() < 0.51e-3;
                assert!(close(&theirs["mean"], ours.mean) && close(&theirs["sd"], ours.sd), "{column}");
                let table = theirs["quantile_table_201"].as_array().unwrap();
                assert_eq!(table.len(), ours.quantiles.len());
                assert!(table.iter().zip(&ours.quantiles).all(|(a, &b)| close(a, b)), "{column}");
                for other in 0..4 {
                    let theirs = part["spearman"][places[place]][places[other]].as_f64().unwrap();
                    assert_eq!(theirs, ansur(sex).spearman[place][other]);
                }
            }
        }
    }

    #[test]
    fn quantiles_rise_from_the_smallest_to_the_largest() {
        for statistics in Sex::ALL.iter().flat_map(|&sex| &ansur(sex).measures) {
            let values: Vec<f64> = (0..=100_000).map(|k| statistics.quantile(f64::from(k) / 1e5)).collect();
            assert!(values.is_sorted());
            assert_eq!((values[0], values[100_000]), (statistics.quantiles[0], statistics.quantiles[CELLS]));
            for (place, &value) in statistics.quantiles.iter().enumerate() {
                assert!((values[500 * place] - value).abs() < 1e-9, "{place}");
            }
            for rank in [0.1234, 0.5, 0.8765] {
                // Many people may have the same value: their middle rank has it, too.
                let value = statistics.quantile(rank);
                assert!((statistics.quantile(statistics.rank(value)) - value).abs() < 1e-9);
            }
            assert_eq!(statistics.rank(statistics.quantiles[0] - 1.0), 0.0);
            assert_eq!(statistics.rank(statistics.quantiles[CELLS] + 1.0), 1.0);
            // Half way between two knots.
            let middle = 0.5 * (statistics.quantiles[100] + statistics.quantiles[101]);
            assert!((statistics.quantile(0.5025) - middle).abs() < 1e-12);
        }
    }
}
