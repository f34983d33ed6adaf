//! What must be equal to continue a sweep.

use crate::error::{Error, Result};
use crate::models::Models;
use crate::points::{Points, hex};
use crate::spec::Spec;
use lemons_sim::{Algorithm, Documents};
use serde_json::{Map, Value, json};
use sha2::{Digest, Sha256};

/// Of what is simulated: its Trial, its drive, its communication step; and of people who walk, their plan.
///
/// # Errors
/// The plan cannot be written.
pub fn of_documents(documents: &Documents, algorithm: Algorithm, step: f64) -> Result<Map<String, Value>> {
    let mut all = Map::new();
    let Documents { trial, drive, plan } = documents;
    let fingerprint = format!("{:032x}", trial.fingerprint());
    all.insert("trial".into(), json!({ "name": trial.name, "fingerprint": fingerprint }));
    if let Some(plan) = plan {
        let text = plan.to_toml().map_err(|error| Error::Spec(error.to_string()))?;
        all.insert("plan".into(), hex(&Sha256::digest(text)).into());
        all.insert("algorithm".into(), algorithm.to_string().into());
    }
    all.insert("drive".into(), drive.fingerprint().into());
    all.insert("step".into(), json!(step));
    Ok(all)
}

/// Of several of them, by their digests: which point has which, and which parameters only choose.
pub fn of_models(points: &Points, each: &[String], models: &Models) -> Map<String, Value> {
    let mut digest = Sha256::new();
    each.iter().for_each(|one| digest.update(one));
    (0..points.count).for_each(|point| digest.update((models.place(point) as u64).to_le_bytes()));
    (0..points.columns.len()).for_each(|column| digest.update([u8::from(models.only_chooses(column))]));
    let digest = hex(&digest.finalize());
    Map::from_iter([("models".to_owned(), json!({ "count": each.len(), "sha256": digest }))])
}

/// Of a map, by its text.
///
/// # Errors
/// It cannot be written as JSON.
pub fn digest(map: &Map<String, Value>) -> Result<String> {
    Ok(hex(&Sha256::digest(serde_json::to_string(map)?)))
}

/// Of points.
pub fn of_points(points: &Points) -> Value {
    let names: Vec<&str> = points.columns.iter().map(|(name, _)| name.as_str()).collect();
    json!({ "parameters": names, "count": points.count, "sha256": points.sha256() })
}

/// Of what is done with it.
pub(crate) fn of_spec(spec: &Spec) -> Map<String, Value> {
    let mut all = spec.identity.clone();
    all.insert("points".into(), of_points(&spec.points));
    all.extend(spec.places.walkable_digest().map(|digest| ("walkable".into(), digest.into())));
    all
}
