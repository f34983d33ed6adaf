//! Numbers by their names: those of the fields of what `lemons measure` writes.

use serde::Serialize;
use serde_json::Value;

fn fields(seen: &impl Serialize) -> serde_json::Map<String, Value> {
    match serde_json::to_value(seen) {
        Ok(Value::Object(fields)) => fields,
        _ => serde_json::Map::new(),
    }
}

/// Returns a number; `None` if it is not known.
pub(crate) fn number_of(name: &str, seen: &impl Serialize) -> Option<f64> {
    fields(seen).get(name)?.as_f64()
}

/// Checks that a number has the name that a key gives.
///
/// # Errors
/// A sentence with all names.
pub(crate) fn check_number(key: &str, name: &str, any: &impl Serialize) -> Result<(), String> {
    let numbers = fields(any).into_iter().filter(|(_, value)| value.is_number() || value.is_null());
    let names: Vec<String> = numbers.map(|(name, _)| name).collect();
    match names.iter().any(|known| known == name) {
        true => Ok(()),
        false => Err(format!("{key} = {name:?}: must be one of {}", names.join(", "))),
    }
}
