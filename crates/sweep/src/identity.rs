//! What must be equal to continue a sweep.

use crate::error::{Place, Result};
use crate::models::Models;
use crate::points::hex;
use crate::spec::Spec;
use crate::subject::Subject;
use lemons_files::input;
use lemons_master::Part;
use serde_json::{Map, Value, json};
use sha2::{Digest, Sha256};

/// Of what is simulated: its FMU, its drive, its communication step; and of people who walk, their plan.
pub fn of_subject(spec: &Spec, subject: &Subject) -> Result<Map<String, Value>> {
    let model = &subject.model;
    let mut all = Map::new();
    for part in model.parts() {
        let key = if part.name == "decision" { "plan" } else { "fmu" };
        all.insert(key.into(), of_fmu(part)?);
    }
    if model.plan().is_some() {
        all.insert("algorithm".into(), spec.algorithm.to_string().into());
    }
    all.insert("drive".into(), subject.drive.fingerprint().into());
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

fn of_fmu(part: &Part) -> Result<Value> {
    let bytes = input::read(&part.file, input::LARGEST_BINARY).place(|| part.file.display().to_string())?;
    let description = &part.fmu.description;
    Ok(json!({
        "model": description.model_name,
        "guid": description.guid,
        "sha256": hex(&Sha256::digest(bytes)),
    }))
}
