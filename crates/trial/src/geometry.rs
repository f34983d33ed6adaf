//! `Geometry.xml`.

use crate::problem::Problems;
use crate::xml::{Bound, Element, Ids, Kind, document, read_file, vector};
use lemons_files::source::{Disk, Source};
use lemons_plane::{Vec2, vec2};
use lemons_xml::{Problem, Severity, number, quoted};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::Path;

/// `Geometry.xml`.
#[derive(Debug, Clone, PartialEq)]
pub struct Geometry {
    /// \[m\] `<Dimensions Lx Ly>`: the size of the drawn area; not used by the mechanics.
    pub dimensions: Option<Vec2>,
    /// In file order.
    pub walls: Vec<Wall>,
}

impl Geometry {
    /// Reads and checks a single `Geometry.xml`, without its materials. Returns its walls and the warnings.
    ///
    /// # Errors
    /// All errors in the file.
    pub fn read(path: &Path) -> Result<(Geometry, Problems), Problems> {
        Geometry::read_from(&Disk, path)
    }

    /// As [`Geometry::read`], from these files.
    ///
    /// # Errors
    /// As [`Geometry::read`].
    pub fn read_from(files: &dyn Source, path: &Path) -> Result<(Geometry, Problems), Problems> {
        let mut problems = Problems::default();
        let read =
            read_file(files, path, &GEOMETRY, &mut problems, |root, problems| read(root, None, problems).0);
        match read {
            Some(geometry) if !problems.has_errors() => Ok((geometry, problems)),
            _ => Err(problems),
        }
    }
}

/// `<Wall>`: a polyline without thickness, which acts on both sides.
#[derive(Debug, Clone, PartialEq)]
pub struct Wall {
    /// Id, unique among the walls.
    pub id: String,
    /// Id of its material.
    pub material_id: String,
    /// \[m\] at least two corners; the wall is closed if the last one is at the place of the first.
    pub corners: Vec<Vec2>,
}

pub(crate) static GEOMETRY: Kind =
    Kind { name: "Geometry", attributes: &[], children: &[&DIMENSIONS, &WALL] };
static DIMENSIONS: Kind = Kind { name: "Dimensions", attributes: &["Lx", "Ly"], children: &[] };
static WALL: Kind = Kind { name: "Wall", attributes: &["Id", "MaterialId"], children: &[&CORNER] };
static CORNER: Kind = Kind { name: "Corner", attributes: &["Coordinates"], children: &[] };

/// The geometry and the walls' Ids; `materials` is `None` where they could not be read.
pub(crate) fn read(root: Element<'_>, materials: Option<&Ids>, problems: &mut Problems) -> (Geometry, Ids) {
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
        let corner = element.point("Coordinates", problems);
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
                            "wall {} draws its face {} a second time as face {}; they act like one",
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

pub(crate) fn xml(geometry: &Geometry) -> String {
    document("Geometry", |out| {
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
