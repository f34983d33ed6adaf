//! Identity of a sweep: what must be equal to continue it.

use crate::error::Result;
use crate::models::Models;
use crate::points::Points;
use crate::spec::Spec;
use lemons_sim::{Algorithm, Documents};
use serde_json::{Map, Value, json};
use sha1_smol::Sha1;

/// Returns what must be equal of several models, by their digests: which point has which, and which parameters only
/// choose.
pub fn of_models(points: &Points, digests: &[String], models: &Models) -> Map<String, Value> {
    let mut digest = Sha1::new();
    digests.iter().for_each(|one| digest.update(one.as_bytes()));
    (0..points.count).for_each(|point| digest.update(&(models.place(point) as u64).to_le_bytes()));
    (0..points.parameters.len()).for_each(|place| digest.update(&[u8::from(models.only_chooses(place))]));
    let digest = digest.digest().to_string();
    Map::from_iter([("models".to_owned(), json!({ "count": digests.len(), "sha1": digest }))])
}

/// Returns the digest of a map, by its text.
///
/// # Errors
/// It cannot be written.
pub fn digest(map: &Map<String, Value>) -> Result<String> {
    Ok(Sha1::from(serde_json::to_string(map)?).digest().to_string())
}

/// Returns what must be equal of points.
pub fn of_points(points: &Points) -> Value {
    let names: Vec<&str> = points.parameters.iter().map(|parameter| parameter.name.as_str()).collect();
    json!({ "parameters": names, "count": points.count, "sha1": points.sha1() })
}

/// Returns what must be equal of a Trial, its drive, its communication step \[s\]; and of people who walk, their `decision.toml`.
///
/// # Errors
/// It cannot be written.
pub fn of_documents(documents: &Documents, algorithm: Algorithm, step: f64) -> Result<Map<String, Value>> {
    let mut all = Map::new();
    let Documents { trial, drive, plan } = documents;
    let fingerprint = format!("{:032x}", trial.fingerprint());
    all.insert("trial".into(), json!({ "name": trial.name, "fingerprint": fingerprint }));
    if let Some(plan) = plan {
        all.insert("decision".into(), format!("{:032x}", plan.fingerprint).into());
        all.insert("algorithm".into(), algorithm.to_string().into());
    }
    all.insert("drive".into(), drive.fingerprint().into());
    all.insert("step".into(), json!(step));
    Ok(all)
}

/// Returns what must be equal of points and measures.
pub(crate) fn of_spec(spec: &Spec) -> Map<String, Value> {
    let mut all = spec.identity.clone();
    all.insert("points".into(), of_points(&spec.points));
    let walkable =
        spec.places.walkable.as_ref().map(|walkable| Sha1::from(&walkable.wkt).digest().to_string());
    all.extend(walkable.map(|digest| ("walkable".into(), digest.into())));
    all
}
