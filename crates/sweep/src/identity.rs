//! What must be equal to continue a sweep.

use crate::error::{Error, Result};
use crate::models::Models;
use crate::points::hex;
use crate::spec::Spec;
use crate::subject::Subject;
use serde_json::{Map, Value, json};
use sha2::{Digest, Sha256};

/// Of what is simulated: its Trial, its drive, its communication step; and of people who walk, their plan.
pub fn of_subject(spec: &Spec, subject: &Subject) -> Result<Map<String, Value>> {
    let mut all = Map::new();
    let trial = &subject.documents.trial;
    let fingerprint = format!("{:032x}", trial.fingerprint());
    all.insert("trial".into(), json!({ "name": trial.name, "fingerprint": fingerprint }));
    if let Some(plan) = &subject.documents.plan {
        let text = plan.to_toml().map_err(|error| Error::Spec(error.to_string()))?;
        all.insert("plan".into(), hex(&Sha256::digest(text)).into());
        all.insert("algorithm".into(), spec.algorithm.to_string().into());
    }
    all.insert("drive".into(), subject.documents.drive.fingerprint().into());
    all.insert("step".into(), json!(subject.clock.step));
    Ok(all)
}

/// Of several of them, by their digests: which point has which, and which parameters only choose.
pub fn of_subjects(spec: &Spec, each: &[String], models: &Models) -> Map<String, Value> {
    let mut digest = Sha256::new();
    each.iter().for_each(|one| digest.update(one));
    (0..spec.points.count).for_each(|point| digest.update((models.place(point) as u64).to_le_bytes()));
    (0..spec.points.columns.len()).for_each(|column| digest.update([u8::from(spec.only_chooses(column))]));
    let digest = hex(&digest.finalize());
    Map::from_iter([("models".to_owned(), json!({ "count": each.len(), "sha256": digest }))])
}

/// Of a map, by its text.
pub fn digest(map: &Map<String, Value>) -> Result<String> {
    Ok(hex(&Sha256::digest(serde_json::to_string(map)?)))
}

/// Of what is done with it.
pub fn of_spec(spec: &Spec) -> Map<String, Value> {
    let names: Vec<&str> = spec.points.columns.iter().map(|(name, _)| name.as_str()).collect();
    let points = json!({ "parameters": names, "count": spec.points.count, "sha256": spec.points.sha256() });
    let mut all = spec.identity.clone();
    all.insert("points".into(), points);
    all.extend(spec.places.walkable_digest().map(|digest| ("walkable".into(), digest.into())));
    all
}
