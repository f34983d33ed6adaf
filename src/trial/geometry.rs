//! `Geometry.xml`.

use super::problem::{Problem, Problems, Severity, quoted};
use super::xml::{Bound, Element, Ids, Out, number, vector};
use super::{Geometry, Wall};
use crate::engine::{Vec2, vec2};
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// The geometry and the walls' Ids; `materials` is `None` where they could not be read.
pub(super) fn read(root: Element<'_>, materials: Option<&Ids>, problems: &mut Problems) -> (Geometry, Ids) {
    let dimensions = root.at_most_one("Dimensions", problems).map(|element| {
        vec2(element.number("Lx", Bound::None, problems), element.number("Ly", Bound::None, problems))
    });
    let (mut walls, mut ids) = (Vec::new(), Ids::default());
    for element in root.children("Wall") {
        let id = ids.take(element, problems);
        let (material_id, _) = element.reference("MaterialId", materials, "material", problems);
        let corners = read_corners(element, &id, problems);
        walls.push(Wall { id, material_id, corners });
    }
    (Geometry { dimensions, walls }, ids)
}

fn read_corners(wall: Element<'_>, id: &str, problems: &mut Problems) -> Vec<Vec2> {
    let mut corners: Vec<Vec2> = Vec::new();
    // Where each face was drawn first, whichever its direction.
    let mut faces: HashMap<[[u64; 2]; 2], usize> = HashMap::new();
    for element in wall.children("Corner") {
        let corner = element.vector("Coordinates", problems);
        let place = corners.len();
        if let Some(&before) = corners.last() {
            if (corner - before).norm() == 0.0 {
                let message =
                    format!("corner {place} of wall {} is where corner {} is", quoted(id), place - 1);
                problems.push(element.wrong("Coordinates", &message));
            } else if (corner - before).is_finite() {
                let mut face = [bits(before), bits(corner)];
                face.sort_unstable();
                match faces.entry(face) {
                    Entry::Occupied(first) => {
                        let message = format!(
                            "wall {} draws its face {} a second time as face {}; both push",
                            quoted(id),
                            first.get(),
                            place - 1
                        );
                        let problem = element.wrong("Coordinates", &message);
                        problems.push(Problem { severity: Severity::Warning, ..problem });
                    }
                    Entry::Vacant(free) => {
                        free.insert(place - 1);
                    }
                }
            }
        }
        corners.push(corner);
    }
    if corners.len() < 2 {
        problems.push(wall.problem(format!(
            "wall {} has {} corners: it needs two",
            quoted(id),
            corners.len()
        )));
    }
    corners
}

/// Equal for equal points: the sum turns −0 into 0.
fn bits(point: Vec2) -> [u64; 2] {
    [(point.x + 0.0).to_bits(), (point.y + 0.0).to_bits()]
}

pub(super) fn xml(geometry: &Geometry) -> String {
    Out::document("Geometry", |out| {
        if let Some(size) = geometry.dimensions {
            out.empty("Dimensions", &[("Lx", &number(size.x)), ("Ly", &number(size.y))]);
        }
        for wall in &geometry.walls {
            out.element("Wall", &[("Id", &wall.id), ("MaterialId", &wall.material_id)], |out| {
                for &corner in &wall.corners {
                    out.empty("Corner", &[("Coordinates", &vector(corner))]);
                }
            });
        }
    })
}
