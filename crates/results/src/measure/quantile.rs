//! Quantiles.

/// Returns the quantile of ascending values, `part` from 0 to 1, linear between two of them (as numpy's default);
/// `None` without any.
pub fn quantile(ascending: &[f64], part: f64) -> Option<f64> {
    let last = ascending.len().checked_sub(1)?;
    let place = part.clamp(0.0, 1.0) * last as f64;
    let below = (place.floor() as usize).min(last);
    let (low, high, part) = (ascending[below], ascending[(below + 1).min(last)], place - below as f64);
    // Without a part of it, the upper one may be infinite.
    Some(if part == 0.0 { low } else { low + (high - low) * part })
}
