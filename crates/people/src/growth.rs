//! Children: stature and mass for their age, from the growth charts of the United States (CDC 2000), and what no chart
//! gives: breadth and depth.

use crate::anthropometry::ansur;
use crate::person::{Person, Sex};
use std::sync::LazyLock;

/// \[years\] The ages of the charts.
pub(crate) const AGES: [f64; 2] = [2.0, 18.0];
/// \[years\] Until here, boys and girls have the proportions of women.
const PUBERTY: f64 = 12.0;
/// \[standard deviations\] The charts say nothing about children further from the median.
const FARTHEST: f64 = 3.0;

/// L, M and S (Cole and Green 1992) of stature \[cm\] and mass \[kg\], at whole years.
type Chart = Vec<[[f64; 3]; 2]>;

fn chart(sex: Sex) -> &'static Chart {
    static CHARTS: LazyLock<[Chart; 2]> = LazyLock::new(|| {
        let lines = include_str!("../data/growth.txt").lines().filter(|line| !line.starts_with('#'));
        let mut charts = [Chart::new(), Chart::new()];
        let mut sex = Sex::Male;
        for line in lines {
            let numbers: Vec<f64> = line.split(' ').filter_map(|word| word.parse().ok()).collect();
            match numbers[..] {
                [_, l, m, s, l2, m2, s2] => charts[sex as usize].push([[l, m, s], [l2, m2, s2]]),
                _ => sex = if line == Sex::Female.name() { Sex::Female } else { Sex::Male },
            }
        }
        charts
    });
    &CHARTS[sex as usize]
}

/// The value that lies `z` standard deviations from the median: M (1 + L S z)^(1/L).
fn value([l, m, s]: [f64; 3], z: f64) -> f64 {
    m * libm::pow(1.0 + l * s * z, 1.0 / l)
}

/// Returns the stature \[m\] and the mass \[kg\] of a child who is so many standard deviations from the medians of the age
/// \[years\]. Between whole years values are linear: within 0.6 % of the charts, which are monthly.
fn growth(sex: Sex, age: f64, z: [f64; 2]) -> [f64; 2] {
    let chart = chart(sex);
    let place = (age - AGES[0]).clamp(0.0, AGES[1] - AGES[0]);
    let year = (place as usize).min(chart.len() - 2);
    let way = place - year as f64;
    std::array::from_fn(|which| {
        let at = |year: usize| value(chart[year][which], z[which].clamp(-FARTHEST, FARTHEST));
        let unit = if which == 0 { 0.01 } else { 1.0 };
        unit * (at(year) + way * (at(year + 1) - at(year)))
    })
}

/// Returns breadth and depth \[m\] of an adult of mean proportions, by the square root of mass/stature \[kg/m\].
fn proportions(sex: Sex) -> [f64; 2] {
    let [breadth, depth, stature, mass] = ansur(sex).measures.each_ref().map(|measure| measure.mean);
    let size = (mass / stature).sqrt();
    [breadth / size, depth / size]
}

/// Returns a child of an age \[years\], so many standard deviations from the medians of stature and mass.
///
/// Breadth and depth go with √(mass/stature), as for bodies of one shape and density (assumption): up to 12 years with
/// the proportions of women, from then on boys become men by 18 years.
pub(crate) fn child(sex: Sex, age: f64, z: [f64; 2]) -> Person {
    let [stature, mass] = growth(sex, age, z);
    let grown = match sex {
        Sex::Female => 0.0,
        Sex::Male => ((age - PUBERTY) / (AGES[1] - PUBERTY)).clamp(0.0, 1.0),
    };
    let [women, men] = [Sex::Female, Sex::Male].map(proportions);
    let size = (mass / stature).sqrt();
    let [breadth, depth] = std::array::from_fn(|k| size * (women[k] + grown * (men[k] - women[k])));
    Person { sex, breadth, depth, stature, mass }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Percentiles 5, 50 and 95 as the charts print them: stature \[cm\] and mass \[kg\].
    #[test]
    fn percentiles_are_those_of_the_charts() {
        let z = 1.644_853_6;
        // Boys of 24, 61.5 and 120.5 months.
        for (months, low, high) in
            [(24.0, 80.729_8, 92.196_9), (61.5, 101.937_2, 117.353_6), (120.5, 128.162_5, 149.905_3)]
        {
            let found = [-z, z].map(|z| 100.0 * growth(Sex::Male, months / 12.0, [z; 2])[0]);
            assert!((found[0] - low).abs() < 0.12 && (found[1] - high).abs() < 0.12, "{months}: {found:?}");
        }
        for (sex, age, stature, mass) in [
            (Sex::Male, 2.0, 86.45, 12.67),
            (Sex::Male, 6.0, 115.39, 20.68),
            (Sex::Female, 6.0, 114.71, 20.24),
            (Sex::Female, 17.0, 162.91, 55.14),
        ] {
            let median = growth(sex, age, [0.0; 2]);
            assert!(
                (median[0] * 100.0 - stature).abs() < 0.02 && (median[1] - mass).abs() < 0.01,
                "{median:?}"
            );
        }
    }

    #[test]
    fn children_grow_into_adults() {
        for sex in Sex::ALL {
            let mut before = child(sex, 2.0, [0.0; 2]);
            assert!((0.22..0.27).contains(&before.breadth), "{before:?}");
            for month in 25..=216 {
                let now = child(sex, f64::from(month) / 12.0, [0.0; 2]);
                assert!(
                    now.check().is_ok()
                        && now.breadth > before.breadth - 1e-3
                        && now.stature > before.stature
                );
                before = now;
            }
            let [adult, ..] = ansur(sex).measures.each_ref().map(|measure| measure.mean);
            // Of 18 years, and lighter than soldiers.
            assert!((0.85..0.97).contains(&(before.breadth / adult)), "{before:?}");
        }
    }
}
