//! Well-known text -> lines.

use super::{DrawnLine, Reading, Tracer, UnitFrom};
use crate::error::{PeopleError, Result, require};
use lemons_core::plane::{Vec2, WktGeometry, shapes_from_wkt};

/// \[byte\] A corner takes four times as much memory as its text.
const LARGEST: usize = 16_000_000;

pub(super) fn read(text: &str, reading: &Reading) -> Result<Tracer> {
    require(text.len() <= LARGEST, || {
        format!("is larger than {} MB, the limit of well-known text", LARGEST / 1_000_000)
    })?;
    let mut tracer = Tracer::new(Tracer::unit_of(reading, Some((1.0, UnitFrom::Format))), reading);
    let scale = tracer.scale();
    for (number, shape) in shapes_from_wkt(text).map_err(PeopleError::new)?.into_iter().enumerate() {
        let mut take = |corners: &[Vec2], kind: &str, closed: bool, hole: bool| {
            tracer.look(1)?;
            tracer.take(DrawnLine {
                layer: String::new(),
                role: None,
                name: None,
                entity: format!("{kind} {number}"),
                corners: corners.iter().map(|corner| scale.of(*corner)).collect(),
                closed,
                hole,
                ground: closed,
            })
        };
        match shape {
            WktGeometry::Point(at) => take(&[at], "POINT", false, false)?,
            WktGeometry::Line(corners) => take(&corners, "LINESTRING", false, false)?,
            WktGeometry::Polygon(polygon) => {
                for (k, ring) in polygon.rings().enumerate() {
                    take(ring.corners(), "POLYGON", true, k > 0)?;
                }
            }
        }
    }
    Ok(tracer)
}
