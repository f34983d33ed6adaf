//! Drawings against closed forms, against other readers, and against what is no drawing.

use super::*;
use lemons_core::plane::{Ring, nearest_on_segment, vec2};
use std::f64::consts::PI;

mod areas;
mod curves;
mod doubts;
mod dxf;
mod examples;
mod hostile;
mod layers;
mod made;
mod places;
mod plans;
mod svg;
mod written;

const METRES: Reading = Reading { unit: Some(1.0), deviation: DEVIATION };

/// A DXF of entities: group codes and values, separated by spaces.
fn dxf_of(header: &str, blocks: &str, entities: &str) -> String {
    let section = |name: &str, pairs: &str| format!("0 SECTION 2 {name} {pairs} 0 ENDSEC ");
    let text =
        section("HEADER", header) + &section("BLOCKS", blocks) + &section("ENTITIES", entities) + "0 EOF";
    text.split_whitespace().collect::<Vec<_>>().join("\n")
}

fn lines_of(entities: &str) -> Vec<DrawnLine> {
    with_blocks("", entities)
}

fn with_blocks(blocks: &str, entities: &str) -> Vec<DrawnLine> {
    drawing(DrawingFormat::Dxf, &dxf_of("", blocks, entities)).unwrap().lines
}

fn area(line: &DrawnLine) -> f64 {
    Ring::through(line.corners.clone()).unwrap().signed_area()
}

fn near(a: Vec2, b: Vec2) -> bool {
    (a - b).norm() < 1e-9
}

fn example(name: &str) -> Vec<u8> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/plans").join(name);
    std::fs::read(path).unwrap()
}

fn plan_of(name: &str, format: DrawingFormat, reading: Reading, close: Option<f64>) -> FloorPlan {
    let drawing = Drawing::read(format, &example(name), &reading).unwrap();
    FloorPlan::of(drawing, &PlanSettings { close, to_origin: true, ..PlanSettings::default() }).unwrap()
}

fn drawing(format: DrawingFormat, text: &str) -> Result<Drawing> {
    Drawing::read(format, text.as_bytes(), &METRES)
}

fn plan(format: DrawingFormat, text: &str) -> FloorPlan {
    FloorPlan::of(drawing(format, text).unwrap(), &PlanSettings::default()).unwrap()
}

/// The plan of a DXF of entities.
fn plan_of_dxf(entities: &str) -> FloorPlan {
    plan(DrawingFormat::Dxf, &dxf_of("", "", entities))
}

/// Entities of a rectangle.
fn rectangle(layer: &str, [x0, y0, x1, y1]: [f64; 4]) -> String {
    format!("0 LWPOLYLINE 8 {layer} 70 1 10 {x0} 20 {y0} 10 {x1} 20 {y0} 10 {x1} 20 {y1} 10 {x0} 20 {y1} ")
}

fn left_out_of(plan: &FloorPlan) -> Vec<String> {
    plan.left_out.iter().map(left_out).collect()
}

fn read_as(format: DrawingFormat, text: &str) -> Result<Read> {
    Read::of(format, text.as_bytes(), &METRES, &PlanSettings::default())
}

fn feature(layer: &str, corners: &[Vec2]) -> String {
    let text = |at: &Vec2| format!("[{}, {}]", at.x, at.y);
    let corners: Vec<String> = corners.iter().chain(&corners[..1]).map(text).collect();
    format!(
        r#"{{"type": "Feature", "properties": {{"layer": "{layer}"}}, "geometry": {{"type": "Polygon", "coordinates": [[{}]]}}}}"#,
        corners.join(", ")
    )
}

fn collection(features: &[String]) -> String {
    format!(r#"{{"type": "FeatureCollection", "features": [{}]}}"#, features.join(", "))
}

/// Checks that corners are on a curve, and that no place of the curve is further than the deviation from them.
fn check_curve(line: &DrawnLine, curve: impl Fn(f64) -> Vec2, deviation: f64) {
    let ends = line.corners.iter().skip(1).chain(line.closed.then(|| &line.corners[0]));
    let sides: Vec<(Vec2, Vec2)> = line.corners.iter().copied().zip(ends.copied()).collect();
    for k in 0..=2000 {
        let at = curve(f64::from(k) / 2000.0);
        let distance = sides
            .iter()
            .map(|(a, b)| (at - nearest_on_segment(*a, *b, at)).norm())
            .fold(f64::INFINITY, f64::min);
        assert!(distance <= deviation * (1.0 + 1e-9), "{distance} at {at:?}");
    }
}
