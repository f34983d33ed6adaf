//! Formats numbers and text for SVG.

/// Number of decimals of a length in pixels.
pub(crate) const PX: usize = 2;

/// Returns 1, 2, 5 · 10ⁿ for these n.
fn round_numbers(powers: std::ops::RangeInclusive<i32>) -> impl Iterator<Item = f64> {
    // As a quotient of integers: 0.2 is then the nearest double.
    let times = |digit: f64, n: i32| if n < 0 { digit / 10f64.powi(-n) } else { digit * 10f64.powi(n) };
    powers.flat_map(move |n| [1.0, 2.0, 5.0].map(|digit| times(digit, n)))
}

/// Returns the largest of 1, 2, 5 · 10ⁿ that is not above the limit.
pub(crate) fn round_below(limit: f64) -> f64 {
    round_numbers(-6..=7).take_while(|number| *number <= limit).last().unwrap_or(1e-6)
}

/// Returns the smallest of 1, 2, 5 · 10ⁿ that is not below the limit.
pub(crate) fn round_above(limit: f64) -> f64 {
    let power = limit.log10().floor().clamp(-300.0, 307.0) as i32;
    let mut four = round_numbers(power..=power + 1).take(4);
    four.find(|number| *number >= limit * (1.0 - 1e-12)).unwrap_or(10f64.powi(power + 1))
}

/// Formats with three significant digits.
pub(crate) fn short(value: f64) -> String {
    let scientific = format!("{value:.2e}");
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    match exponent.parse::<i32>() {
        Ok(e @ -3..=4) => text_of(value, (2 - e).max(0) as usize),
        _ => format!("{}e{exponent}", mantissa.trim_end_matches('0').trim_end_matches('.')),
    }
}

/// Formats a value of a quantity in the first of some units, each with its name, that is not above it; else in the last.
pub(crate) fn in_units(value: f64, units: &[(f64, &str)]) -> String {
    let fitting = units.iter().find(|(unit, _)| value >= *unit);
    let (unit, name) = fitting.or(units.last()).copied().unwrap_or((1.0, ""));
    format!("{} {name}", text_of(value / unit, 1))
}

/// Formats a number with at most `decimals` decimals, without trailing zeros and −0.
pub(crate) fn text_of(value: f64, decimals: usize) -> String {
    let mut text = format!("{value:.decimals$}");
    if decimals > 0 {
        text.truncate(text.trim_end_matches('0').trim_end_matches('.').len());
    }
    if text == "-0" { "0".to_owned() } else { text }
}

/// Formats a number as in path data: without the 0 before the point.
pub(crate) fn number(value: f64, decimals: usize) -> String {
    let mut text = text_of(value, decimals);
    if let Some(zero) = ["0.", "-0."].iter().position(|start| text.starts_with(start)) {
        text.remove(zero);
    }
    text
}

/// Writes two numbers; a minus sign is enough to separate them.
pub(crate) fn pair(out: &mut String, (x, y): (f64, f64), decimals: usize) {
    *out += &number(x, decimals);
    let y = number(y, decimals);
    if !y.starts_with('-') {
        out.push(' ');
    }
    *out += &y;
}

/// Escapes text for XML, and replaces characters that XML 1.0 does not allow.
pub(crate) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            '\t' | '\n' | '\r' => out.push(' '),
            '\0'..='\u{1f}' | '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers() {
        let values = [0.0, -0.00001, 0.5, -0.25, 100.0, 1.23456, -3.0];
        assert_eq!(values.map(|v| number(v, 4)), ["0", "0", ".5", "-.25", "100", "1.2346", "-3"]);
        assert_eq!(text_of(10.0, 0), "10");
        let values = [0.0, 1.5, 1234.5, 0.01234, 1.2e7, -3e-9, 9.999];
        assert_eq!(values.map(short), ["0", "1.5", "1234", "0.0123", "1.2e7", "-3e-9", "10"]);
        assert_eq!([0.49, 73.0, 1.0].map(round_below), [0.2, 50.0, 1.0]);
        assert_eq!([0.21, 0.2, 7.0].map(round_above), [0.5, 0.2, 10.0]);
        let units = &[(1.0, "m"), (0.01, "cm")];
        assert_eq!([2.0, 0.5, 0.001].map(|v| in_units(v, units)), ["2 m", "50 cm", "0.1 cm"]);
    }
}
