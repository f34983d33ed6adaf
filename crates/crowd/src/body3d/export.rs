//! Bodies as files of other tools: OBJ, STL, GeoJSON, WKT. Metres, z up.

use super::{CrowdSection, Mesh, Polygon};
use std::io::{self, Error, ErrorKind, Write};

/// A mesh as Wavefront OBJ, one group a part.
///
/// # Errors
/// Those of the writer.
pub fn write_obj(mesh: &Mesh, to: &mut impl Write) -> io::Result<()> {
    writeln!(to, "# metres, z up")?;
    // Vertices count from one through the whole file.
    let mut first = 1u64;
    for part in &mesh.parts {
        writeln!(to, "g {}", part.name)?;
        for [x, y, z] in &part.vertices {
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

/// A mesh as binary STL: all parts in one list of triangles, in single precision.
///
/// # Errors
/// Those of the writer; more triangles than 32 bits count.
pub fn write_stl(mesh: &Mesh, to: &mut impl Write) -> io::Result<()> {
    let count: usize = mesh.parts.iter().map(|part| part.triangles.len()).sum();
    let count = u32::try_from(count)
        .map_err(|_| Error::new(ErrorKind::InvalidInput, format!("{count} triangles: STL counts to {}", u32::MAX)))?;
    let mut header = [b' '; 80];
    // A header that begins with "solid" is taken for text.
    let title = b"body mesh, metres, z up";
    header[..title.len()].copy_from_slice(title);
    to.write_all(&header)?;
    to.write_all(&count.to_le_bytes())?;
    for part in &mesh.parts {
        for &triangle in &part.triangles {
            let [a, b, c] = part.corners(triangle);
            let mut record = [0u8; 50];
            for (k, value) in [normal(a, b, c), a, b, c].into_iter().flatten().enumerate() {
                record[4 * k..4 * k + 4].copy_from_slice(&(value as f32).to_le_bytes());
            }
            to.write_all(&record)?;
        }
    }
    Ok(())
}

/// The unit normal of a triangle; nothing of one without area.
fn normal(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> [f64; 3] {
    let [u, v] = [b, c].map(|p| [p[0] - a[0], p[1] - a[1], p[2] - a[2]]);
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
    if length > 0.0 { n.map(|x| x / length) } else { [0.0; 3] }
}

/// Sections as GeoJSON: a FeatureCollection with a feature an outline, its properties `altitude` \[m\], `body` (the place
/// in the crowd) and `part`. Coordinates are x, y, z \[m\] of the scene, not degrees. One body's slices are sections of a
/// crowd of one.
///
/// # Errors
/// Those of the writer.
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
                    polygon.part
                )?;
                for (k, point) in closed(polygon).enumerate() {
                    let comma = if k == 0 { "" } else { "," };
                    write!(to, "{comma}[{:.6},{:.6},{z:.6}]", point.x, point.y)?;
                }
                write!(to, "]]}}}}")?;
                comma = ",\n";
            }
        }
    }
    writeln!(to, "\n]}}")
}

/// Sections as well-known text: one `MULTIPOLYGON Z` a line for each section that cuts somebody.
///
/// # Errors
/// Those of the writer.
pub fn write_wkt(sections: &[CrowdSection], to: &mut impl Write) -> io::Result<()> {
    for section in sections.iter().filter(|section| section.cut() > 0) {
        let z = section.altitude;
        write!(to, "MULTIPOLYGON Z (")?;
        for (k, polygon) in section.bodies.iter().flatten().enumerate() {
            write!(to, "{}((", if k == 0 { "" } else { ", " })?;
            for (k, point) in closed(polygon).enumerate() {
                let comma = if k == 0 { "" } else { ", " };
                write!(to, "{comma}{:.6} {:.6} {z:.6}", point.x, point.y)?;
            }
            write!(to, "))")?;
        }
        writeln!(to, ")")?;
    }
    Ok(())
}

/// The points with the first once more at the end.
fn closed(polygon: &Polygon) -> impl Iterator<Item = &crowd_mechanics::engine::Vec2> {
    polygon.points.iter().chain(polygon.points.first())
}
