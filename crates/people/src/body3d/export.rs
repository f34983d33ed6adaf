//! Writes bodies for other tools: OBJ, STL, GeoJSON, WKT. In metres, z up.

use super::{CrowdSection, MeshPart, Polygon};
use lemons_core::plane::Vec2;
use std::borrow::Borrow;
use std::io::{self, Error, ErrorKind, Write};

/// Writes surfaces as Wavefront OBJ, one group for each part.
///
/// # Errors
/// The writer fails, or a vertex is not finite.
pub fn write_obj(parts: impl IntoIterator<Item: Borrow<MeshPart>>, to: &mut impl Write) -> io::Result<()> {
    writeln!(to, "# metres, z up")?;
    // Vertices are numbered from one through the whole file.
    let mut first = 1u64;
    for part in parts {
        let part = part.borrow();
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

/// Writes surfaces as binary STL: all parts in one list of triangles, in single precision. It iterates over the parts
/// twice, because the file begins with the number of triangles.
///
/// # Errors
/// The writer fails, a vertex is not finite, or the number of triangles does not fit in 32 bits.
pub fn write_stl(
    parts: impl IntoIterator<Item: Borrow<MeshPart>, IntoIter: Clone>,
    to: &mut impl Write,
) -> io::Result<()> {
    let parts = parts.into_iter();
    let count: usize = parts.clone().map(|part| part.borrow().triangles.len()).sum();
    let count = u32::try_from(count).map_err(|_| {
        Error::new(ErrorKind::InvalidInput, format!("{count} triangles: STL can hold at most {}", u32::MAX))
    })?;
    let mut header = [b' '; 80];
    // Readers take a file whose header begins with "solid" for text.
    let title = b"body mesh, metres, z up";
    header[..title.len()].copy_from_slice(title);
    to.write_all(&header)?;
    to.write_all(&count.to_le_bytes())?;
    for part in parts {
        let part = part.borrow();
        for &triangle in &part.triangles {
            let [a, b, c] = part.corners(triangle);
            let mut record = [0u8; 50];
            for (k, corner) in [normal(a, b, c), finite(a)?, finite(b)?, finite(c)?].into_iter().enumerate() {
                for (i, value) in corner.into_iter().enumerate() {
                    let at = 12 * k + 4 * i;
                    record[at..at + 4].copy_from_slice(&(value as f32).to_le_bytes());
                }
            }
            to.write_all(&record)?;
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
fn normal(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> [f64; 3] {
    let [u, v] = [b, c].map(|p| [p[0] - a[0], p[1] - a[1], p[2] - a[2]]);
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
    if length > 0.0 { n.map(|x| x / length) } else { [0.0; 3] }
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
                write!(
                    to,
                    "{comma}{{\"type\":\"Feature\",\"properties\":{{\"altitude\":{z:.6},\"body\":{body},\"part\":\"{}\"}},\
                     \"geometry\":{{\"type\":\"Polygon\",\"coordinates\":[[",
                    polygon.part.name()
                )?;
                for (k, point) in closed(polygon).enumerate() {
                    let comma = if k == 0 { "" } else { "," };
                    let [x, y, z] = finite([point.x, point.y, z])?;
                    write!(to, "{comma}[{x:.6},{y:.6},{z:.6}]")?;
                }
                write!(to, "]]}}}}")?;
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
        let z = section.altitude;
        write!(to, "MULTIPOLYGON Z (")?;
        for (k, polygon) in section.bodies.iter().flatten().enumerate() {
            write!(to, "{}((", if k == 0 { "" } else { ", " })?;
            for (k, point) in closed(polygon).enumerate() {
                let comma = if k == 0 { "" } else { ", " };
                let [x, y, z] = finite([point.x, point.y, z])?;
                write!(to, "{comma}{x:.6} {y:.6} {z:.6}")?;
            }
            write!(to, "))")?;
        }
        writeln!(to, ")")?;
    }
    Ok(())
}

/// The points, with the first repeated at the end.
fn closed(polygon: &Polygon) -> impl Iterator<Item = &Vec2> {
    polygon.points.iter().chain(polygon.points.first())
}
