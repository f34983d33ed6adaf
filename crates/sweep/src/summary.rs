//! Summary of the runs of each case: means over seeds with their intervals, quantiles, and runs that got stuck.

use crate::error::Result;
use crate::points::Points;
use crate::spec::ENDED;
use crate::table::{Finished, MeasuredValue};
use lemons_core::require;
use lemons_results::measure::{MeanInterval, quantile};
use std::collections::BTreeMap;

/// The quantiles of a measure, and what is added to its name.
const QUANTILES: [(f64, &str); 3] = [(0.1, "quantile_10"), (0.5, "median"), (0.9, "quantile_90")];

/// Checks that the parameters that tell the runs of a case apart are those of a sweep.
///
/// # Errors
/// One is not.
pub fn check_over(points: &Points, over: &[String]) -> Result<()> {
    let known = |name: &String| points.parameters.iter().any(|own| own.name == *name);
    over.iter().try_for_each(|name| Ok(require(known(name), || format!("there is no parameter {name:?}"))?))
}

/// Returns a table in CSV with a row for each case: the runs that differ only in the parameters `over`, such as a seed. Of
/// each measure it has the mean, its 95 % interval (Student's t) and quantiles, of the runs that have a value.
///
/// # Errors
/// The table cannot be written.
pub fn summary(points: &Points, measures: &[String], rows: &[Finished], over: &[String]) -> Result<String> {
    let fixed: Vec<_> = points.parameters.iter().filter(|own| !over.contains(&own.name)).collect();
    let may_end = measures.last().is_some_and(|name| name == ENDED);
    let mut cases: BTreeMap<Vec<&str>, Vec<&Finished>> = BTreeMap::new();
    for row in rows {
        cases.entry(fixed.iter().map(|own| own.at(row.point)).collect()).or_default().push(row);
    }
    let mut ordered: Vec<_> = cases.into_iter().collect();
    ordered.sort_by_key(|(_, rows)| rows[0].point);
    let mut out = csv::Writer::from_writer(Vec::new());
    let names = fixed.iter().map(|own| own.name.clone()).chain(["runs", "failed"].map(str::to_owned));
    let stuck = may_end.then(|| "stuck".to_owned());
    let of_measures = measures.iter().flat_map(|name| {
        let more = QUANTILES.iter().map(|(_, quantile)| *quantile);
        ["mean", "low", "high"].into_iter().chain(more).map(move |what| format!("{name}_{what}"))
    });
    out.write_record(names.chain(stuck).chain(of_measures))?;
    for (key, rows) in ordered {
        let runs: Vec<_> = rows.iter().filter_map(|row| row.outcome.as_ref().ok()).collect();
        // Of the runs, those without an end.
        let stuck = runs.iter().filter(|values| values.last() == Some(&None)).count();
        let counts = [Some(runs.len()), Some(rows.len() - runs.len()), may_end.then_some(stuck)];
        let counts = counts.into_iter().flatten().map(|count| count.to_string());
        let values = |place: usize| {
            let values = runs.iter().filter_map(move |values| match values.get(place)? {
                Some(MeasuredValue::Number(number)) => Some(*number),
                _ => None,
            });
            numbers(values.collect())
        };
        let numbers = (0..measures.len()).flat_map(values);
        let numbers = numbers.map(|number| number.map_or(String::new(), |number| format!("{number:?}")));
        out.write_record(key.into_iter().map(str::to_owned).chain(counts).chain(numbers))?;
    }
    let bytes = out.into_inner().map_err(csv::IntoInnerError::into_error)?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// Returns mean, both ends of its interval, quantiles; `None`: not known.
fn numbers(mut values: Vec<f64>) -> Vec<Option<f64>> {
    values.sort_by(f64::total_cmp);
    let mean = MeanInterval::of(&values);
    let ends = mean.and_then(|mean| mean.ends()).map_or([None; 2], |ends| ends.map(Some));
    let quantiles = QUANTILES.map(|(part, _)| quantile(&values, part));
    [mean.map(|mean| mean.mean)].into_iter().chain(ends).chain(quantiles).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_that_differ_in_the_seed_are_one_case() {
        let axes = vec![
            ("width".to_owned(), ["1.2", "0.9"].map(str::to_owned).to_vec()),
            ("seed".to_owned(), ["1", "2", "3"].map(str::to_owned).to_vec()),
        ];
        let points = Points::grid(axes).unwrap();
        let number = |value: f64| Some(MeasuredValue::Number(value));
        let outcomes = [
            Ok(vec![number(1.0), number(9.0)]),
            Ok(vec![number(3.0), None]),
            Err("it fell".to_owned()),
            Ok(vec![None, number(5.0)]),
            Ok(vec![number(2.0), number(7.0)]),
            Ok(vec![number(2.0), number(6.0)]),
        ];
        let rows = outcomes.into_iter().enumerate().map(|(point, outcome)| Finished { point, outcome });
        let rows: Vec<Finished> = rows.collect();
        let measures = ["x".to_owned(), ENDED.to_owned()];
        let over = ["seed".to_owned()];
        let text = summary(&points, &measures, &rows, &over).unwrap();
        let lines: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
        assert_eq!(
            lines[0][..8],
            ["width", "runs", "failed", "stuck", "x_mean", "x_low", "x_high", "x_quantile_10"]
        );
        assert_eq!(lines[1][..5], ["1.2", "2", "1", "1", "2.0"]);
        let low: f64 = lines[1][5].parse().unwrap();
        assert!((low - (2.0 - 12.7062047)).abs() < 1e-6, "{low}");
        assert_eq!(lines[2][..7], ["0.9", "3", "0", "0", "2.0", "2.0", "2.0"]);
        assert_eq!(lines[2][10..11], ["6.0"]);
        assert!(check_over(&points, &["seeds".to_owned()]).is_err() && check_over(&points, &over).is_ok());
    }
}
