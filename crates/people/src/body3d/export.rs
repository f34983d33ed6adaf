//! Writes bodies for other tools: OBJ, STL, GeoJSON, WKT. In metres, z up.

use super::{BodySlice, CrowdSection, MeshPart};
use nalgebra::Vector3;
use std::io::{self, Error, ErrorKind, Write};

/// Writes surfaces as Wavefront OBJ, one group for each part.
///
/// # Errors
/// The writer fails, or a vertex is not finite.
pub fn write_obj(parts: impl IntoIterator<Item = MeshPart>, to: &mut impl Write) -> io::Result<()> {
    writeln!(to, "# metres, z up")?;
    // Vertices are numbered from one through the whole file.
    let mut first = 1u64;
    for part in parts {
        writeln!(to, "g {}", part.name)?;
        for vertex in &part.vertices {
            let [x, y, z] = finite(*vertex)?;
            writeln!(to, "v {x:.6} {y:.6} {z:.6}")?;
        }
        for triangle in &part.triangles {
            let [a, b, c] = triangle.map(|index| first + u64::from(index));
            writeln!(to, "f {a} {b} {c}")?;
        }
        first += part.vertices.len() as u64;
    }
    Ok(())
}

/// Writes surfaces as binary STL: all parts in one list of triangles, in single precision.
///
/// # Errors
/// The writer fails, a vertex is not finite, or the number of triangles does not fit in 32 bits.
pub fn write_stl(parts: &[MeshPart], to: &mut impl Write) -> io::Result<()> {
    let count: usize = parts.iter().map(|part| part.triangles.len()).sum();
    let count = u32::try_from(count).map_err(|_| {
        Error::new(ErrorKind::InvalidInput, format!("{count} triangles: STL can hold at most {}", u32::MAX))
    })?;
    // Readers take a file whose header begins with "solid" for text.
    write!(to, "{:<80}", "body mesh, metres, z up")?;
    to.write_all(&count.to_le_bytes())?;
    for part in parts {
        for &triangle in &part.triangles {
            let [a, b, c] = triangle.map(|index| part.vertices[index as usize]);
            for corner in [normal([a, b, c]), finite(a)?, finite(b)?, finite(c)?] {
                to.write_all(&corner.map(|value| (value as f32).to_le_bytes()).concat())?;
            }
            to.write_all(&[0; 2])?;
        }
    }
    Ok(())
}

/// Returns the point, or an error if it is not finite (because a pose was not).
fn finite(point: [f64; 3]) -> io::Result<[f64; 3]> {
    if point.iter().all(|value| value.is_finite()) {
        return Ok(point);
    }
    let [x, y, z] = point;
    Err(Error::new(ErrorKind::InvalidInput, format!("the point ({x}, {y}, {z}) of a body is not finite")))
}

/// Returns the unit normal of a triangle, zero if it has no area.
fn normal(corners: [[f64; 3]; 3]) -> [f64; 3] {
    let [a, b, c] = corners.map(Vector3::from);
    (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_default().into()
}

/// Writes sections as GeoJSON: a FeatureCollection with one feature for each outline. Its properties are `altitude`
/// \[m\], `body` (index in the crowd) and `part`. Coordinates are x, y, z \[m\] of the scene, not degrees. For slices
/// of one body, give sections of a crowd of one.
///
/// # Errors
/// The writer fails, or a point is not finite.
pub fn write_geojson(sections: &[CrowdSection], to: &mut impl Write) -> io::Result<()> {
    write!(to, "{{\"type\":\"FeatureCollection\",\"features\":[")?;
    let mut comma = "\n";
    for section in sections {
        let z = section.altitude;
        for (body, polygons) in section.bodies.iter().enumerate() {
            for polygon in polygons {
                let part = polygon.part.name();
                let points = points(polygon, z, |[x, y, z]| format!("[{x:.6},{y:.6},{z:.6}]"))?.join(",");
                write!(
                    to,
                    "{comma}{{\"type\":\"Feature\",\"properties\":{{\"altitude\":{z:.6},\"body\":{body},\"part\":\"{part}\"}},\
                     \"geometry\":{{\"type\":\"Polygon\",\"coordinates\":[[{points}]]}}}}"
                )?;
                comma = ",\n";
            }
        }
    }
    writeln!(to, "\n]}}")
}

/// Writes sections as well-known text: one line with a `MULTIPOLYGON Z` for each section that cuts a body.
///
/// # Errors
/// The writer fails, or a point is not finite.
pub fn write_wkt(sections: &[CrowdSection], to: &mut impl Write) -> io::Result<()> {
    for section in sections.iter().filter(|section| section.cut() > 0) {
        let rings = section.bodies.iter().flatten().map(|polygon| {
            let ring = points(polygon, section.altitude, |[x, y, z]| format!("{x:.6} {y:.6} {z:.6}"))?;
            Ok(format!("(({}))", ring.join(", ")))
        });
        writeln!(to, "MULTIPOLYGON Z ({})", rings.collect::<io::Result<Vec<String>>>()?.join(", "))?;
    }
    Ok(())
}

/// The points at an altitude \[m\] as texts, the first again at the end.
fn points(polygon: &BodySlice, z: f64, shown: fn([f64; 3]) -> String) -> io::Result<Vec<String>> {
    let round = polygon.points.iter().chain(polygon.points.first());
    round.map(|point| finite([point.x, point.y, z]).map(shown)).collect()
}
