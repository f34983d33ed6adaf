//! A plan -> GeoJSON, well-known text or DXF, as [`Drawing::read`](super::Drawing::read) reads them.

use super::Format;
use super::areas::TOUCH;
use super::plan::{MOST_CORNERS, Place, Plan, Role};
use crate::is_closed;
use lemons_core::plane::{Bounds, Ring, Vec2};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::fmt::Write;

/// Returns the formats that are written.
pub fn written_formats() -> [Format; 3] {
    [Format::GeoJson, Format::Wkt, Format::Dxf]
}

/// The layer of walls: no role, all of them are walls.
const WALLS: &str = "walls";

/// Writes walls, exits, distributions and way-points, in metres. Well-known text has walls only. `None` for a format that
/// is not written.
pub fn write_plan(plan: &Plan, format: Format) -> Option<String> {
    match format {
        Format::GeoJson => Some(geojson(plan)),
        Format::Wkt => Some(wkt(plan)),
        Format::Dxf => Some(dxf(plan)),
        Format::Svg => None,
    }
}

/// A line with its layer.
struct Written<'p> {
    layer: String,
    name: Option<&'p str>,
    corners: &'p [Vec2],
    closed: bool,
}

fn lines(plan: &Plan) -> Vec<Written<'_>> {
    let mut all = Vec::new();
    for wall in &plan.walls {
        let closed = is_closed(wall);
        let corners = &wall[..wall.len() - usize::from(closed)];
        all.push(Written { layer: WALLS.to_owned(), name: None, corners, closed });
    }
    let kinds = [
        (Role::Exit, &plan.exits),
        (Role::Distribution, &plan.distributions),
        (Role::Waypoint, &plan.waypoints),
    ];
    for (role, places) in kinds {
        for Place { name, corners } in places {
            let layer = format!("{}-{name}", role.layer());
            all.push(Written { layer, name: Some(name), corners, closed: corners.len() > 2 });
        }
    }
    all
}

fn geojson(plan: &Plan) -> String {
    let point = |corner: &Vec2| json!([corner.x, corner.y]);
    let feature = |Written { layer, name, corners, closed }: Written| {
        let mut points: Vec<Value> = corners.iter().map(point).collect();
        if closed {
            points.extend(corners.first().map(point));
        }
        let geometry = match (closed, &points[..]) {
            (true, _) => json!({"type": "Polygon", "coordinates": [points]}),
            (false, [point]) => json!({"type": "Point", "coordinates": point}),
            (false, _) => json!({"type": "LineString", "coordinates": points}),
        };
        let properties =
            name.map_or_else(|| json!({"layer": layer}), |name| json!({"layer": layer, "name": name}));
        json!({"type": "Feature", "properties": properties, "geometry": geometry})
    };
    let features: Vec<String> = lines(plan).into_iter().map(|line| format!("  {}", feature(line))).collect();
    format!("{{\"type\": \"FeatureCollection\", \"features\": [\n{}\n]}}\n", features.join(",\n"))
}

/// Closed walls that are apart from all others are polygons, and those within them holes, as other programs take them. The
/// reader unites polygons that meet, so walls that do so are lines, and what is within such a wall.
fn wkt(plan: &Plan) -> String {
    let text = |wall: &[Vec2]| {
        let corners: Vec<String> = wall.iter().map(|corner| format!("{} {}", corner.x, corner.y)).collect();
        format!("({})", corners.join(", "))
    };
    let polygons = polygons(&plan.walls);
    let in_polygons: BTreeSet<usize> = polygons.iter().flatten().copied().collect();
    let polygon = |walls: &Vec<usize>| {
        let rings: Vec<String> = walls.iter().map(|wall| text(&plan.walls[*wall])).collect();
        format!("POLYGON ({})", rings.join(", "))
    };
    let lines = plan.walls.iter().enumerate().filter(|(k, _)| !in_polygons.contains(k));
    let lines = lines.map(|(_, wall)| format!("LINESTRING {}", text(wall)));
    let parts: Vec<String> = polygons.iter().map(polygon).chain(lines).collect();
    match &parts[..] {
        [one] => format!("{one}\n"),
        _ => format!("GEOMETRYCOLLECTION ({})\n", parts.join(",\n  ")),
    }
}

/// Returns the walls that are polygons, by their numbers: of each its rim, then its holes. There are none if walls have more
/// corners than polygons that are read.
fn polygons(walls: &[Vec<Vec2>]) -> Vec<Vec<usize>> {
    let ring = |(k, wall): (usize, &Vec<Vec2>)| {
        let ring = Ring::through(wall.clone()).filter(|_| is_closed(wall))?;
        Some((k, ring.bounds().grown(TOUCH), ring))
    };
    let rings: Vec<(usize, Bounds, Ring)> = walls.iter().enumerate().filter_map(ring).collect();
    // Where doors open the outline, it is no polygon: then what stands in it is none, either.
    let within = |wall: &Vec<Vec2>| {
        rings.iter().any(|(_, bounds, _)| wall.iter().all(|corner| bounds.contains(*corner)))
    };
    let corners: usize = rings.iter().map(|(.., ring)| ring.corners().len()).sum();
    if corners > MOST_CORNERS || !walls.iter().filter(|wall| !is_closed(wall)).all(within) {
        return Vec::new();
    }
    let is_near = |(_, of, one): &(usize, Bounds, Ring), (_, bounds, other): &(usize, Bounds, Ring)| {
        let near = |ring: &Ring, corner: &Vec2| ring.nearest(*corner).distance <= TOUCH;
        of.meets(bounds)
            && (one.touches(other)
                || one.corners().iter().any(|corner| near(other, corner))
                || other.corners().iter().any(|corner| near(one, corner)))
    };
    let mut is_line: Vec<bool> = rings.iter().map(|(.., ring)| !ring.is_simple()).collect();
    for k in 0..rings.len() {
        for other in 0..k {
            if !(is_line[k] && is_line[other]) && is_near(&rings[k], &rings[other]) {
                (is_line[k], is_line[other]) = (true, true);
            }
        }
    }
    let around = |k: usize| -> Vec<usize> {
        let corner = rings[k].2.corners()[0];
        let holds = |&other: &usize| {
            let (_, bounds, ring) = &rings[other];
            other != k && bounds.contains(corner) && ring.contains(corner)
        };
        (0..rings.len()).filter(holds).collect()
    };
    let around: Vec<Vec<usize>> = (0..rings.len()).map(around).collect();
    let apart = || (0..rings.len()).filter(|&k| !is_line[k] && !around[k].iter().any(|of| is_line[*of]));
    let is_rim = |k: usize| around[k].len().is_multiple_of(2);
    let mut polygons: Vec<Vec<usize>> = vec![Vec::new(); rings.len()];
    for k in apart().filter(|k| is_rim(*k)) {
        polygons[k].push(rings[k].0);
    }
    for k in apart().filter(|k| !is_rim(*k)) {
        // The innermost one around it.
        let of = around[k].iter().copied().filter(|of| is_rim(*of)).max_by_key(|of| around[*of].len());
        polygons[of.unwrap_or(k)].push(rings[k].0);
    }
    polygons.retain(|walls| !walls.is_empty());
    polygons
}

/// Release 12, which every program reads: POLYLINE with VERTEX. The unit is that of later releases, in the header.
fn dxf(plan: &Plan) -> String {
    let mut text = String::from(
        "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n9\n$INSUNITS\n70\n6\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n",
    );
    for Written { layer, corners, closed, .. } in lines(plan) {
        let layer = plain(&layer);
        // Writing to a string does not fail.
        let _ = match corners {
            [at] => write!(text, "0\nPOINT\n8\n{layer}\n10\n{}\n20\n{}\n30\n0.0\n", at.x, at.y),
            _ => write!(
                text,
                "0\nPOLYLINE\n8\n{layer}\n66\n1\n10\n0.0\n20\n0.0\n30\n0.0\n70\n{}\n",
                i32::from(closed)
            ),
        };
        for corner in corners.iter().filter(|_| corners.len() > 1) {
            let _ = write!(text, "0\nVERTEX\n8\n{layer}\n10\n{}\n20\n{}\n30\n0.0\n", corner.x, corner.y);
        }
        if corners.len() > 1 {
            let _ = write!(text, "0\nSEQEND\n8\n{layer}\n");
        }
    }
    text + "0\nENDSEC\n0\nEOF\n"
}

/// A name of a layer on one line, in ASCII: \U+00E4 is ä.
fn plain(name: &str) -> String {
    let letter = |letter: char| match u32::from(letter) {
        0x20..=0x7e => letter.to_string(),
        code @ 0xa0..=0xffff => format!("\\U+{code:04X}"),
        _ => "_".to_owned(),
    };
    name.chars().map(letter).collect()
}
