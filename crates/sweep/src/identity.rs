//! What must be equal to continue a sweep.

use crate::error::{Place, Result};
use crate::models::Models;
use crate::points::hex;
use crate::spec::{End, Spec};
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
    all.insert("drive".into(), of_drive(subject));
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
pub fn of_spec(spec: &Spec) -> Result<Map<String, Value>> {
    let names: Vec<&str> = spec.points.columns.iter().map(|(name, _)| name.as_str()).collect();
    let measures =
        spec.measures.iter().map(|(name, measure)| Ok((name.clone(), serde_json::to_value(measure)?)));
    let until = match spec.until {
        End::At(time) => json!(time),
        End::Left => json!("left"),
    };
    let points = json!({ "parameters": names, "count": spec.points.count, "sha256": spec.points.sha256() });
    let mut all = Map::from_iter([
        ("points".to_owned(), points),
        ("measure".to_owned(), Value::Object(measures.collect::<Result<_>>()?)),
        ("until".to_owned(), until),
    ]);
    all.extend(spec.places.identity());
    if let Some(stop) = &spec.stop {
        all.insert("stop".into(), serde_json::to_value(stop)?);
    }
    Ok(all)
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

/// As in the Python package: by the values, independent of how the file is written.
fn of_drive(subject: &Subject) -> Value {
    let mut digest = Sha256::new();
    let mut driven = false;
    for (place, agent) in subject.trial.agents.iter().enumerate() {
        let Some(rows) = subject.drive.rows(&agent.id) else { continue };
        driven = true;
        [place, rows.len()].iter().for_each(|number| digest.update((*number as u64).to_le_bytes()));
        for (time, push) in rows {
            std::iter::once(time).chain(push).for_each(|value| digest.update(value.to_le_bytes()));
        }
    }
    match driven {
        true => {
            json!({ "kind": "table", "at": "start", "per_mass": false, "sha256": hex(&digest.finalize()) })
        }
        false => json!({ "kind": "none" }),
    }
}
