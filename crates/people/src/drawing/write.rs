//! A plan -> GeoJSON, well-known text or DXF, as [`Drawing::read`](super::Drawing::read) reads them.

use super::DrawingFormat;
use super::areas::MOST_CORNERS;
use super::areas::{MOST_MADE, TOUCH};
use super::place::NamedPlace;
use super::plan::FloorPlan;
use super::role::LayerRole;
use crate::is_closed;
use lemons_core::plane::overlay::{InsideRule, contour, intersection, ring};
use lemons_core::plane::{Bounds, Polygon, Ring, Vec2, ground, vec2};
use serde_json::{Value, json};
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fmt::Write;

/// Returns the formats that are written.
pub fn written_formats() -> [DrawingFormat; 3] {
    [DrawingFormat::GeoJson, DrawingFormat::Wkt, DrawingFormat::Dxf]
}

/// The layer of walls: no role, all of them are walls.
const WALLS: &str = "walls";
/// \[m²\] What rounding does to an area.
const ROUNDING: f64 = 1e-6;

/// Writes walls, exits, distributions and way-points, in metres; walls as walkable areas and obstacles, if the plan has
/// any. Well-known text has walls only. `None` for a format that is not written.
pub fn write_plan(plan: &FloorPlan, format: DrawingFormat) -> Option<String> {
    match format {
        DrawingFormat::GeoJson => Some(geojson(plan)),
        DrawingFormat::Wkt => Some(wkt(plan)),
        DrawingFormat::Dxf => Some(dxf(plan)),
        DrawingFormat::Svg => None,
    }
}

/// A line with its layer, or an area with holes.
struct Written<'p> {
    layer: String,
    name: Option<&'p str>,
    corners: Cow<'p, [Vec2]>,
    closed: bool,
    holes: Vec<&'p [Vec2]>,
}

impl<'p> Written<'p> {
    /// Of a wall.
    fn new(layer: &str, wall: &'p [Vec2]) -> Written<'p> {
        let closed = is_closed(wall);
        let corners = Cow::Borrowed(&wall[..wall.len() - usize::from(closed)]);
        Written { layer: layer.to_owned(), name: None, corners, closed, holes: Vec::new() }
    }
}

fn lines(plan: &FloorPlan) -> Vec<Written<'_>> {
    let walls = || plan.walls.iter().map(|wall| Written::new(WALLS, wall)).collect();
    let mut all = areas(plan).unwrap_or_else(walls);
    let kinds = [
        (LayerRole::Exit, &plan.exits),
        (LayerRole::Distribution, &plan.distributions),
        (LayerRole::Waypoint, &plan.waypoints),
    ];
    for (role, places) in kinds {
        for NamedPlace { name, corners } in places {
            let layer = format!("{}-{name}", role.layer());
            let (corners, closed) = (Cow::Borrowed(&corners[..]), corners.len() > 2);
            all.push(Written { layer, name: Some(name), corners, closed, holes: Vec::new() });
        }
    }
    all
}

/// Returns walls as walkable areas and obstacles, from which the reader makes the same ground; `None` if none were drawn.
fn areas(plan: &FloorPlan) -> Option<Vec<Written<'_>>> {
    let (area, obstacle) = (LayerRole::WalkableArea.layer(), LayerRole::Obstacle.layer());
    let (closed, open): (Vec<&Vec<Vec2>>, Vec<&Vec<Vec2>>) =
        plan.walls.iter().partition(|wall| is_closed(wall));
    let rings: Vec<Ring> = closed.iter().filter_map(|wall| Ring::through(wall.to_vec())).collect();
    let corners: usize = rings.iter().map(|ring| ring.corners().len()).sum();
    if !plan.has_areas || rings.is_empty() || corners > MOST_CORNERS {
        return None;
    }
    let around = around(&rings.iter().collect::<Vec<_>>());
    // Ground in an obstacle was found only where areas and obstacles met.
    let depth = |k: usize| around[k].len().min(if plan.ground.is_some() { usize::MAX } else { 1 });
    let outer = (0..rings.len()).filter(|k| depth(*k) == 0);
    let rims: Vec<Polygon> = outer.map(|k| Polygon { outer: rings[k].clone(), holes: Vec::new() }).collect();
    let sum = |polygons: &[Polygon]| polygons.iter().map(Polygon::area).sum::<f64>();
    // The reader fills what is narrow between areas: then they are holes of one obstacle in a frame.
    let is_same = |read: Vec<Polygon>| (sum(&read) - sum(&rims)).abs() <= ROUNDING;
    let framed = plan.ground.is_some() && !ground(&rims, &[], TOUCH, MOST_MADE).is_some_and(is_same);
    let is_rim = |k: usize| depth(k) % 2 == 1 || depth(k) == 0 && !framed;
    let mut all = Vec::new();
    for (k, polygon) in grouped(&around, 0..rings.len(), is_rim).into_iter().enumerate() {
        let open = |k: &usize| &closed[*k][..closed[*k].len() - 1];
        if k == rings.len() && framed {
            let frame = Ring::around(plan.bounds()?.grown(1.0)).corners().to_vec();
            let new = |layer: &str, holes| Written {
                layer: layer.to_owned(),
                name: None,
                corners: Cow::Owned(frame.clone()),
                closed: true,
                holes,
            };
            all.extend([new(area, Vec::new()), new(obstacle, polygon.iter().map(open).collect())]);
        } else if let Some((rim, holes)) = polygon.split_first() {
            let layer = if depth(*rim) == 0 { area } else { obstacle };
            all.push(Written {
                holes: holes.iter().map(open).collect(),
                ..Written::new(layer, closed[*rim])
            });
        }
    }
    // The others are walls by their lines.
    all.extend(open.into_iter().map(|wall| Written::new(obstacle, wall)));
    Some(all)
}

/// Returns of each ring the numbers of those around it.
fn around(rings: &[&Ring]) -> Vec<Vec<usize>> {
    let bounds: Vec<Bounds> = rings.iter().map(|ring| ring.bounds()).collect();
    let around = |k: usize| -> Vec<usize> {
        // Some may lie on the other one.
        let holds = |&other: &usize| {
            let inside = |at: &&Vec2| bounds[other].contains(**at) && rings[other].contains(**at);
            other != k && 2 * rings[k].corners().iter().filter(inside).count() > rings[k].corners().len()
        };
        (0..rings.len()).filter(holds).collect()
    };
    (0..rings.len()).map(around).collect()
}

/// Returns polygons by the numbers of their rings: of each its rim, then the holes that it is the innermost rim around; at the
/// end holes without a rim.
fn grouped(
    around: &[Vec<usize>],
    all: impl Iterator<Item = usize> + Clone,
    is_rim: impl Fn(usize) -> bool,
) -> Vec<Vec<usize>> {
    let mut polygons: Vec<Vec<usize>> = vec![Vec::new(); around.len() + 1];
    for k in all.clone().filter(|k| is_rim(*k)) {
        polygons[k].push(k);
    }
    for k in all.filter(|k| !is_rim(*k)) {
        let of = around[k].iter().copied().filter(|of| is_rim(*of)).max_by_key(|of| around[*of].len());
        polygons[of.unwrap_or(around.len())].push(k);
    }
    polygons
}

/// Cuts a polygon through the middle of each hole: DXF has no holes.
fn without_holes(Written { corners, holes, .. }: &Written) -> Vec<Vec<Vec2>> {
    let rings = std::iter::once(&corners[..]).chain(holes.iter().copied());
    let rings: Vec<Ring> = rings.filter_map(|ring| Ring::through(ring.to_vec())).collect();
    let bounds: Vec<Bounds> = rings.iter().map(|ring| ring.bounds().grown(1.0)).collect();
    let Some((whole, inner)) = bounds.split_first().filter(|(_, inner)| !inner.is_empty()) else {
        return vec![corners.to_vec()];
    };
    let mut cuts: Vec<f64> = inner.iter().map(|of| 0.5 * (of.low.x + of.high.x)).collect();
    cuts.extend([whole.low.x, whole.high.x]);
    cuts.sort_by(f64::total_cmp);
    let polygon: Vec<_> = rings.iter().map(contour).collect();
    let part = |cut: &[f64]| {
        let strip = Bounds { low: vec2(cut[0], whole.low.y), high: vec2(cut[1], whole.high.y) };
        intersection(&polygon, &[contour(&Ring::around(strip))], InsideRule::EvenOdd)
    };
    let parts = cuts.windows(2).filter(|cut| cut[0] < cut[1]).flat_map(part);
    parts.filter_map(|part| Some(ring(part.first()?)?.corners().to_vec())).collect()
}

fn geojson(plan: &FloorPlan) -> String {
    let point = |corner: &Vec2| json!([corner.x, corner.y]);
    let feature = |Written { layer, name, corners, closed, holes }: Written| {
        let ring = |ring: &[Vec2]| ring.iter().chain(ring.first()).map(point).collect::<Vec<Value>>();
        let points: Vec<Value> = corners.iter().map(point).collect();
        let rings = || std::iter::once(&corners[..]).chain(holes).map(ring).collect::<Vec<_>>();
        let geometry = match (closed, &points[..]) {
            (true, _) => json!({"type": "Polygon", "coordinates": rings()}),
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
fn wkt(plan: &FloorPlan) -> String {
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
        let ring = Ring::of_closed(wall)?;
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
    let around = around(&rings.iter().map(|(.., ring)| ring).collect::<Vec<_>>());
    let apart = (0..rings.len()).filter(|&k| !is_line[k] && !around[k].iter().any(|of| is_line[*of]));
    let mut polygons = grouped(&around, apart, |k| around[k].len().is_multiple_of(2));
    polygons.iter_mut().flatten().for_each(|k| *k = rings[*k].0);
    polygons.retain(|walls| !walls.is_empty());
    polygons
}

/// Release 12, which every program reads: POLYLINE with VERTEX. The unit is that of later releases, in the header.
fn dxf(plan: &FloorPlan) -> String {
    let mut text = String::from(
        "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n9\n$INSUNITS\n70\n6\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n",
    );
    let parts = |line: &Written| {
        without_holes(line).into_iter().map(|part| (plain(&line.layer), part, line.closed)).collect()
    };
    let parts: Vec<Vec<(String, Vec<Vec2>, bool)>> = lines(plan).iter().map(parts).collect();
    for (layer, corners, closed) in parts.into_iter().flatten() {
        // Writing to a string does not fail.
        let _ = match corners[..] {
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
