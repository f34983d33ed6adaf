//! What must be equal to continue a sweep.

use crate::error::Result;
use crate::models::Models;
use crate::points::hex;
use crate::spec::Spec;
use serde_json::{Map, Value, json};
use sha2::{Digest, Sha256};

/// Returns what must be equal of several models, by their digests: which point has which, and which parameters only
/// choose.
pub fn of_models(spec: &Spec, digests: &[String], models: &Models) -> Map<String, Value> {
    let mut digest = Sha256::new();
    digests.iter().for_each(|one| digest.update(one));
    (0..spec.points.count).for_each(|point| digest.update((models.place(point) as u64).to_le_bytes()));
    (0..spec.points.parameters.len()).for_each(|place| digest.update([u8::from(spec.only_chooses(place))]));
    let digest = hex(&digest.finalize());
    Map::from_iter([("models".to_owned(), json!({ "count": digests.len(), "sha256": digest }))])
}

/// Returns the digest of a map, by its text.
///
/// # Errors
/// It cannot be written.
pub fn digest(map: &Map<String, Value>) -> Result<String> {
    Ok(hex(&Sha256::digest(serde_json::to_string(map)?)))
}

/// Returns what must be equal of points and measures.
pub fn of_spec(spec: &Spec) -> Map<String, Value> {
    let names: Vec<&str> = spec.points.parameters.iter().map(|parameter| parameter.name.as_str()).collect();
    let points = json!({ "parameters": names, "count": spec.points.count, "sha256": spec.points.sha256() });
    let mut all = spec.identity.clone();
    all.insert("points".into(), points);
    let walkable = spec.places.walkable.as_ref().map(|walkable| hex(&Sha256::digest(&walkable.wkt)));
    all.extend(walkable.map(|digest| ("walkable".into(), digest.into())));
    all
}
