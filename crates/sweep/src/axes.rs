//! The values of parameters, as they are written in `sweep.toml`.

use lemons_master::ensure;
use serde::Deserialize;

/// The values of a parameter.
#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "expected a list of numbers or of texts, { from, to, count, spacing }, or { from, to } of whole numbers"
)]
pub(crate) enum Axis {
    Integers(Vec<i64>),
    Reals(Vec<f64>),
    Texts(Vec<String>),
    Range(Range),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Range {
    from: f64,
    to: f64,
    count: Option<u32>,
    #[serde(default)]
    spacing: Spacing,
}

#[derive(Deserialize, Default, PartialEq, Clone, Copy)]
#[serde(rename_all = "snake_case")]
enum Spacing {
    #[default]
    Linear,
    Logarithmic,
}

/// Largest number of values of a range.
const MOST_VALUES: u32 = 1_000_000;

impl Axis {
    /// Returns the values as text.
    ///
    /// # Errors
    /// A sentence: a number is not finite, or the range has no such values.
    pub(crate) fn values(self) -> Result<Vec<String>, String> {
        let reals = match self {
            Axis::Integers(values) => return Ok(values.iter().map(i64::to_string).collect()),
            Axis::Texts(values) => return Ok(values),
            Axis::Range(Range { from, to, count: None, spacing }) => return whole_numbers(from, to, spacing),
            Axis::Range(Range { from, to, count: Some(count), spacing }) => range(from, to, count, spacing)?,
            Axis::Reals(values) => match values.iter().find(|value| !value.is_finite()) {
                Some(value) => return Err(format!("{value}: must be a finite number")),
                None => values,
            },
        };
        Ok(reals.iter().map(|value| format!("{value:?}")).collect())
    }
}

fn range(from: f64, to: f64, count: u32, spacing: Spacing) -> Result<Vec<f64>, String> {
    ensure(from.is_finite() && to.is_finite(), || NOT_FINITE.to_owned())?;
    let possible = (2..=MOST_VALUES).contains(&count);
    ensure(possible, || format!("count = {count}: must be from 2 to {MOST_VALUES}"))?;
    let positive = spacing == Spacing::Linear || from > 0.0 && to > 0.0;
    ensure(positive, || "spacing = \"logarithmic\": from and to must be positive".to_owned())?;
    let part = |k: u32| f64::from(k) / f64::from(count - 1);
    let (difference, ratio) = (to - from, to / from);
    let value = |k: u32| match (k, spacing) {
        (0, _) => from,
        (k, _) if k + 1 == count => to,
        (k, Spacing::Linear) if difference.is_finite() => from + part(k) * difference,
        (k, Spacing::Linear) => (1.0 - part(k)) * from + part(k) * to,
        (k, Spacing::Logarithmic) if ratio.is_normal() => from * ratio.powf(part(k)),
        (k, Spacing::Logarithmic) => from.powf(1.0 - part(k)) * to.powf(part(k)),
    };
    Ok((0..count).map(value).collect())
}

const NOT_FINITE: &str = "from and to must be finite";

/// Returns all whole numbers from one to another.
fn whole_numbers(from: f64, to: f64, spacing: Spacing) -> Result<Vec<String>, String> {
    ensure(from.is_finite() && to.is_finite(), || NOT_FINITE.to_owned())?;
    let is_whole = |value: f64| value.fract() == 0.0 && value.abs() < 2f64.powi(53);
    let whole = is_whole(from) && is_whole(to) && spacing == Spacing::Linear;
    ensure(whole, || "count: is missing; without it, from and to must be whole numbers".to_owned())?;
    ensure(from <= to && to - from < f64::from(MOST_VALUES), || {
        format!(
            "from = {from}, to = {to}: from must not be greater than to, and there are at most {MOST_VALUES} values"
        )
    })?;
    Ok((from as i64..=to as i64).map(|value| value.to_string()).collect())
}
