//! Numbers and names as values of options.

use clap::builder::{PossibleValuesParser, TypedValueParser};

/// A parser of a number that `fits`; its error says what it must be.
pub fn number<F: Fn(f64) -> bool + Clone + Send + Sync>(
    fits: F,
    must: &str,
) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + use<F> {
    let must = format!("must be {must}");
    move |text| text.trim().parse().ok().filter(|value| fits(*value)).ok_or_else(|| must.clone())
}

/// A parser of a number within bounds, both allowed; `unit` follows them in the error.
pub fn within(
    low: f64,
    high: f64,
    unit: &str,
) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + use<> {
    number(move |value| (low..=high).contains(&value), &format!("a number from {low} to {high}{unit}"))
}

/// Reads a positive number.
pub fn positive(text: &str) -> Result<f64, String> {
    number(|value| value > 0.0 && value.is_finite(), "a positive number")(text)
}

/// Reads a duration.
pub fn duration(text: &str) -> Result<f64, String> {
    positive(text).map_err(|must| format!("{must} of seconds"))
}

/// Reads a time.
pub fn seconds(text: &str) -> Result<f64, String> {
    number(f64::is_finite, "a number of seconds")(text)
}

/// Reads finite numbers between commas.
pub fn list(text: &str) -> Option<Vec<f64>> {
    let number = |text: &str| text.trim().parse().ok().filter(|number: &f64| number.is_finite());
    text.split(',').map(number).collect()
}

/// Reads so many of them.
pub fn array<const N: usize>(text: &str) -> Option<[f64; N]> {
    list(text)?.try_into().ok()
}

/// A parser of the names of some values.
pub fn parser_of<T: Copy + Send + Sync>(
    all: &'static [T],
    name: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    let parser = PossibleValuesParser::new(all.iter().map(|value| name(*value)));
    parser.map(move |text| all.iter().copied().find(|value| name(*value) == text).unwrap_or(all[0]))
}
