//! GeoJSON -> lines. Coordinates are those of a plane, not longitude and latitude.

use super::curve::Affine;
use super::role::LayerRole;
use super::{DrawnLine, Reading, Tracer, UnitFrom, check_name};
use crate::error::{PeopleError, Result, require};
use lemons_core::plane::{Vec2, vec2};
use serde_json::Value;

/// \[byte\] A value takes up to 20 times as much memory as its text.
const LARGEST: usize = 16_000_000;

pub(super) fn read(text: &str, reading: &Reading) -> Result<Tracer> {
    require(text.len() <= LARGEST, || {
        format!("is larger than {} MB, the limit of GeoJSON", LARGEST / 1_000_000)
    })?;
    let value: Value = serde_json::from_str(text).map_err(|error| PeopleError::new(error.to_string()))?;
    refuse_degrees(&value)?;
    let mut tracer = Tracer::new(Tracer::unit_of(reading, Some((1.0, UnitFrom::Format))), reading);
    let scale = tracer.scale();
    Walk { tracer: &mut tracer, scale }.object(&value, "", &Value::Null)?;
    Ok(tracer)
}

/// Earlier drafts of the format name their coordinates.
fn refuse_degrees(value: &Value) -> Result<()> {
    let name = value["crs"]["properties"]["name"].as_str().unwrap_or("");
    Ok(require(!name.ends_with("CRS84") && !name.ends_with(":4326"), || {
        format!("crs: {name:?}: coordinates are degrees; project them to metres first")
    })?)
}

struct Walk<'t> {
    tracer: &'t mut Tracer,
    scale: Affine,
}

impl Walk<'_> {
    /// `at` is the place in the file, as in features\[3\].geometry.
    fn object(&mut self, value: &Value, at: &str, properties: &Value) -> Result<()> {
        self.tracer.look(1)?;
        let kind = value["type"]
            .as_str()
            .ok_or_else(|| wrong(at, "type", value, "the name of a geometry or feature"))?;
        match kind {
            "FeatureCollection" => self.each(value, at, "features", properties),
            "GeometryCollection" => self.each(value, at, "geometries", properties),
            // Without a place it is none.
            "Feature" if value["geometry"].is_null() => {
                self.tracer.leave_out("", "Feature without geometry");
                Ok(())
            }
            "Feature" => self.object(&value["geometry"], &inner(at, "geometry"), &value["properties"]),
            _ => self.geometry(kind, &value["coordinates"], &inner(at, "coordinates"), properties),
        }
    }

    fn each(&mut self, value: &Value, at: &str, key: &str, properties: &Value) -> Result<()> {
        let at = inner(at, key);
        for (k, object) in list(&value[key], &at)?.iter().enumerate() {
            self.object(object, &format!("{at}[{k}]"), properties)?;
        }
        Ok(())
    }

    fn geometry(&mut self, kind: &str, value: &Value, at: &str, properties: &Value) -> Result<()> {
        match kind {
            "Point" => self.line(vec![self.point(value, at)?], false, (kind, at), properties, false),
            "LineString" => self.line(self.points(value, at)?, false, (kind, at), properties, false),
            "Polygon" => {
                for (k, ring) in list(value, at)?.iter().enumerate() {
                    let at = format!("{at}[{k}]");
                    let corners = self.points(ring, &at)?;
                    require(corners.len() >= 4 && corners.first() == corners.last(), || {
                        format!("{at}: the ring is not closed: its first corner must be repeated at its end")
                    })?;
                    self.line(corners, true, (kind, &at), properties, k > 0)?;
                }
                Ok(())
            }
            "MultiPoint" | "MultiLineString" | "MultiPolygon" => {
                for (k, part) in list(value, at)?.iter().enumerate() {
                    self.geometry(&kind[5..], part, &format!("{at}[{k}]"), properties)?;
                }
                Ok(())
            }
            other => Err(PeopleError::new(format!(
                "{at}: type = {other:?}: must be one of Point, LineString, Polygon, MultiPoint, MultiLineString, MultiPolygon, \
                 GeometryCollection, Feature, FeatureCollection"
            ))),
        }
    }

    fn line(
        &mut self,
        corners: Vec<Vec2>,
        closed: bool,
        (kind, at): (&str, &str),
        properties: &Value,
        hole: bool,
    ) -> Result<()> {
        self.tracer.look(1)?;
        let texts = ["layer", "name", "type"].map(|key| properties[key].as_str());
        for name in texts.into_iter().flatten() {
            check_name(name).map_err(|error| PeopleError::new(format!("{at}: {error}")))?;
        }
        // Only the name of a layer has something before it; the others are free text.
        let role = |(k, text): (usize, Option<&'_ str>)| {
            let text = text?;
            Some((text.to_owned(), if k == 0 { LayerRole::of(text) } else { LayerRole::of_name(text) }?))
        };
        let mut roles = texts.into_iter().enumerate().filter_map(role);
        let (with_role, role) = roles.next().unzip();
        let layer = with_role.or(texts.into_iter().flatten().next().map(str::to_owned)).unwrap_or_default();
        let name = texts[1].filter(|name| *name != layer).map(str::to_owned);
        self.tracer.take(DrawnLine {
            layer,
            role,
            name,
            entity: format!("{kind} at {at}"),
            corners,
            closed,
            hole,
            ground: false,
        })
    }

    fn points(&self, value: &Value, at: &str) -> Result<Vec<Vec2>> {
        list(value, at)?
            .iter()
            .enumerate()
            .map(|(k, point)| self.point(point, &format!("{at}[{k}]")))
            .collect()
    }

    fn point(&self, value: &Value, at: &str) -> Result<Vec2> {
        match &list(value, at)?[..] {
            [x, y, ..] => match (x.as_f64(), y.as_f64()) {
                (Some(x), Some(y)) => Ok(self.scale.of(vec2(x, y))),
                _ => Err(PeopleError::new(format!("{at} = {}: must be numbers", short(value)))),
            },
            _ => Err(PeopleError::new(format!("{at} = {}: must be [x, y]", short(value)))),
        }
    }
}

fn inner(at: &str, key: &str) -> String {
    if at.is_empty() { key.to_owned() } else { format!("{at}.{key}") }
}

fn list<'v>(value: &'v Value, at: &str) -> Result<&'v Vec<Value>> {
    value.as_array().ok_or_else(|| PeopleError::new(format!("{at} = {}: must be an array", short(value))))
}

fn wrong(at: &str, key: &str, value: &Value, must: &str) -> PeopleError {
    PeopleError::new(format!("{} = {}: must be {must}", inner(at, key), short(&value[key])))
}

/// Returns a value for messages. Long ones are not written out.
fn short(value: &Value) -> String {
    match value {
        Value::Array(all) if all.len() > 3 => format!("an array of {}", all.len()),
        Value::Array(all) if all.iter().any(|part| part.is_array() || part.is_object()) => {
            "an array".to_owned()
        }
        Value::Object(_) => "an object".to_owned(),
        value => value.to_string().chars().take(60).collect(),
    }
}
