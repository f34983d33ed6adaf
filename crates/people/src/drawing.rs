//! Rooms from drawings of other programs: DXF, GeoJSON, well-known text, SVG.
//!
//! [`Drawing::read`] turns a file into [`DrawnLine`]s in metres, each on a layer; curves become straight pieces. [`FloorPlan::of`]
//! says what they mean: walls, exits, where people stand, way-points. [`write_plan`] writes a plan back.
//!
//! The group codes of DXF are read by our own code (DESIGN.md, "Libraries", says why).

mod areas;
mod bands;
mod collinear;
mod curve;
mod doubt;
mod dxf;
mod enclosing;
mod filled;
mod gap;
mod geojson;
mod join;
pub mod outside;
mod pieces;
mod place;
mod plan;
mod proposal;
mod read;
mod role;
mod sort;
mod svg;
mod swings;
#[cfg(test)]
mod tests;
mod trace;
mod wkt;
mod write;

pub use bands::THICKNESS;
pub use enclosing::{Enclosing, WIDEST_DOOR};
pub use gap::{DOOR, Gap, Leads};
pub use join::{Joined, WIDEST_GAP};
pub use place::NamedPlace;
pub use plan::{FloorPlan, PlanSettings};
pub use proposal::Proposal;
pub use read::{Read, sizes};
pub use role::LayerRole;
pub use sort::{Flight, Layer, Sort};
pub use write::{write_plan, written_formats};

use crate::error::{PeopleError, Result, require};
use curve::Affine;
use lemons_core::files::input;
use lemons_core::plane::{Bounds, Vec2};
use lemons_core::trial::FARTHEST;
use std::collections::BTreeMap;
use std::path::Path;

/// \[m\] Largest deviation of straight pieces from their curve, if nothing else is said.
pub const DEVIATION: f64 = 0.01;
/// \[byte\] Largest file that is read.
pub const LARGEST_DRAWING: u64 = input::LARGEST_SETTINGS;
/// Largest number of corners of a drawing, and of the entities that are looked at: blocks in blocks grow fast.
const MOST: usize = 1_000_000;
/// Largest sum of the sizes of entities that are looked at, those of blocks counted each time: pairs of DXF, bytes of SVG.
const MOST_WORK: usize = 100_000_000;
/// Largest number of letters of a name in a drawing: each line has a copy of its own.
const MOST_LETTERS: usize = 255;

/// A format of drawings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DrawingFormat {
    /// Drawing Exchange Format of AutoCAD, as text.
    Dxf,
    /// RFC 7946, but in a plane.
    GeoJson,
    /// Well-known text (OGC Simple Features).
    Wkt,
    /// Scalable Vector Graphics.
    Svg,
}

impl DrawingFormat {
    /// Returns the format that the name of a file says; `None` for any other name.
    pub fn of(path: &Path) -> Option<DrawingFormat> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        Some(match extension.as_str() {
            "dxf" => DrawingFormat::Dxf,
            "geojson" | "json" => DrawingFormat::GeoJson,
            "wkt" | "txt" => DrawingFormat::Wkt,
            "svg" => DrawingFormat::Svg,
            _ => return None,
        })
    }

    /// Returns its name, for messages.
    pub fn name(self) -> &'static str {
        match self {
            DrawingFormat::Dxf => "DXF",
            DrawingFormat::GeoJson => "GeoJSON",
            DrawingFormat::Wkt => "well-known text",
            DrawingFormat::Svg => "SVG",
        }
    }
}

/// Units that a user can name, and how many metres each is.
pub const UNITS: [(&str, f64); 5] = [("m", 1.0), ("cm", 0.01), ("mm", 0.001), ("in", 0.0254), ("ft", 0.3048)];

/// How a drawing is read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// \[m\] Length of a unit of the drawing; `None`: as the file says.
    pub unit: Option<f64>,
    /// \[m\] Largest deviation of straight pieces from their curve, positive.
    pub deviation: f64,
}

impl Default for Reading {
    fn default() -> Reading {
        Reading { unit: None, deviation: DEVIATION }
    }
}

/// Why a unit of the drawing has its length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UnitFrom {
    /// The user says so.
    User,
    /// The file says so: `$INSUNITS`.
    File,
    /// The format is in metres by custom.
    Format,
}

/// A polyline of a drawing, or a point.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnLine {
    /// As the file has it; empty if there is none.
    pub layer: String,
    /// Role by the name of its layer, or another name of it, and the rest of that name.
    pub role: Option<(LayerRole, String)>,
    /// A name that the file gives this one.
    pub name: Option<String>,
    /// Its kind, as messages call it, with its place in the file: `LINE in line 12`.
    pub entity: String,
    /// \[m\] One corner is a point. The first one is not repeated where the line is closed.
    pub corners: Vec<Vec2>,
    /// Whether a side goes from the last corner to the first.
    pub closed: bool,
    /// Whether it is a hole of the polygon before.
    pub hole: bool,
    /// Whether the format says that what is inside is ground: a polygon of well-known text.
    pub ground: bool,
}

/// A drawing, in metres.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    /// The format that it was in.
    pub format: DrawingFormat,
    /// In the order of the file; blocks are resolved.
    pub lines: Vec<DrawnLine>,
    /// \[m\] Length of a unit.
    pub unit: f64,
    /// Origin of the unit.
    pub unit_from: UnitFrom,
    /// Number of curves that are straight pieces now.
    pub curves: usize,
    /// Entities that were left out: layer and kind, with the number of each.
    pub left_out: BTreeMap<(String, String), usize>,
}

impl Drawing {
    /// Reads the content of a file.
    ///
    /// # Errors
    /// It is not of this format, is too large, or does not say its unit. The message names line, entity and value, but
    /// not the file.
    pub fn read(format: DrawingFormat, bytes: &[u8], reading: &Reading) -> Result<Drawing> {
        let tracer = match format {
            DrawingFormat::Dxf => dxf::read(bytes, reading)?,
            DrawingFormat::GeoJson => geojson::read(text(bytes)?, reading)?,
            DrawingFormat::Wkt => wkt::read(text(bytes)?, reading)?,
            DrawingFormat::Svg => svg::read(bytes, reading)?,
        };
        let size = || Bounds::of(tracer.lines.iter().flat_map(|line| line.corners.iter().copied()));
        let Some((unit, unit_from)) = tracer.unit else {
            let size = size().map(|bounds| bounds.size());
            return Err(PeopleError::NoUnit {
                size: size.map(Into::into),
                scale: format == DrawingFormat::Svg,
            });
        };
        require(!tracer.lines.is_empty(), || {
            let what: Vec<String> = tracer.left_out.iter().map(left_out).collect();
            let what = if what.is_empty() { "nothing is in it".to_owned() } else { what.join(", ") };
            format!("there are no lines in this {}: {what}", format.name())
        })?;
        let Tracer { lines, curves, left_out, .. } = tracer;
        Ok(Drawing { format, lines, unit, unit_from, curves, left_out })
    }

    /// Returns the layers that are listed, spelt as in the drawing: each is the name of a layer, or such names with commas
    /// between. Names that are not in the drawing are among them.
    pub fn layers(&self, listed: &[String]) -> Vec<String> {
        let there =
            || self.lines.iter().map(|line| &line.layer).chain(self.left_out.keys().map(|(layer, _)| layer));
        let is_one = |name: &str| !name.contains(',') || there().any(|layer| is_same(layer, name));
        let names = |name: &String| -> Vec<String> {
            if is_one(name) { vec![name.clone()] } else { name.split(',').map(str::to_owned).collect() }
        };
        let spelt = |name: String| match there().find(|layer| is_same(layer, &name)) {
            Some(layer) if !there().any(|layer| *layer == name) => layer.clone(),
            _ => name,
        };
        listed.iter().flat_map(names).map(spelt).collect()
    }

    /// Returns the lowest and the highest coordinates \[m\].
    pub fn bounds(&self) -> Option<Bounds> {
        Bounds::of(self.lines.iter().flat_map(|line| line.corners.iter().copied()))
    }
}

/// Returns whether two names are those of one layer.
fn is_same(layer: &str, other: &str) -> bool {
    layer.to_uppercase() == other.to_uppercase()
}

/// Says what was left out: `3 TEXT on layer "A"`.
pub fn left_out(((layer, kind), count): (&(String, String), &usize)) -> String {
    let layer = if layer.is_empty() { String::new() } else { format!(" on layer {layer:?}") };
    format!("{count} {kind}{layer}")
}

/// Names a few of many.
fn some_of(all: &[String]) -> String {
    const MOST_NAMED: usize = 20;
    let more = all.len().saturating_sub(MOST_NAMED);
    let named = all[..all.len() - more].join(", ");
    if more > 0 { format!("{named} and {more} more") } else { named }
}

/// Refuses a name that is too long.
fn check_name(name: &str) -> Result<()> {
    Ok(require(name.chars().nth(MOST_LETTERS).is_none(), || {
        let begin: String = name.chars().take(40).collect();
        format!("the name that begins with {begin:?} has more than {MOST_LETTERS} characters: too many")
    })?)
}

fn text(bytes: &[u8]) -> Result<&str> {
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let before = bytes[..error.valid_up_to()].iter().filter(|byte| **byte == b'\n').count();
        PeopleError::new(format!("line {}: is not UTF-8 text", before + 1))
    })?;
    Ok(text.strip_prefix('\u{feff}').unwrap_or(text))
}

/// Collects what a reader finds.
struct Tracer {
    lines: Vec<DrawnLine>,
    /// Where the length of a unit is known.
    unit: Option<(f64, UnitFrom)>,
    /// \[m\]
    deviation: f64,
    curves: usize,
    left_out: BTreeMap<(String, String), usize>,
    corners: usize,
    looked_at: usize,
    /// Sum of their sizes.
    work: usize,
}

impl Tracer {
    /// Makes one without lines. Without a unit, curves get few corners: only the size is asked for.
    fn new(unit: Option<(f64, UnitFrom)>, reading: &Reading) -> Tracer {
        let deviation = if unit.is_some() { reading.deviation } else { f64::INFINITY };
        let (lines, left_out) = (Vec::new(), BTreeMap::new());
        Tracer { lines, unit, deviation, curves: 0, left_out, corners: 0, looked_at: 0, work: 0 }
    }

    /// Returns the unit that the user gives, else that of the file or format.
    fn unit_of(reading: &Reading, otherwise: Option<(f64, UnitFrom)>) -> Option<(f64, UnitFrom)> {
        reading.unit.map(|unit| (unit, UnitFrom::User)).or(otherwise)
    }

    /// Returns the map from units of the drawing to metres.
    fn scale(&self) -> Affine {
        Affine::scale(self.unit.map_or(1.0, |(unit, _)| unit))
    }

    fn leave_out(&mut self, layer: &str, kind: &str) {
        *self.left_out.entry((layer.to_owned(), kind.to_owned())).or_default() += 1;
    }

    /// Counts an entity that is looked at, of a size in pairs or bytes.
    fn look(&mut self, size: usize) -> Result<()> {
        self.looked_at += 1;
        self.work = self.work.saturating_add(size);
        require(self.work <= MOST_WORK, || {
            format!("entities, those of blocks counted each time, have more than {MOST_WORK} parts: too many")
        })?;
        Ok(require(self.looked_at <= MOST, || {
            format!("there are more than {MOST} entities, those of blocks counted each time: too many")
        })?)
    }

    /// Takes a line. Corners that repeat the one before are left out.
    fn take(&mut self, mut line: DrawnLine) -> Result<()> {
        line.corners.dedup();
        while line.closed && line.corners.len() > 1 && line.corners.first() == line.corners.last() {
            line.corners.pop();
        }
        self.corners += line.corners.len();
        require(self.corners <= MOST, || format!("there are more than {MOST} corners: too many"))?;
        let is_near = |corner: &&Vec2| corner.x.abs() <= FARTHEST && corner.y.abs() <= FARTHEST;
        // Without a unit, these are no metres.
        let far = line.corners.iter().find(|corner| !is_near(corner)).filter(|_| self.unit.is_some());
        if let Some([x, y]) = far.map(|corner| <[f64; 2]>::from(*corner)) {
            return Err(PeopleError::new(format!(
                "{}: a corner at ({x:?}, {y:?}) m is not within {FARTHEST} m of the origin",
                line.label()
            )));
        }
        self.lines.push(line);
        Ok(())
    }
}

impl DrawnLine {
    fn has(&self, role: LayerRole) -> bool {
        self.role.as_ref().is_some_and(|(of, _)| *of == role)
    }

    /// Says what it is, and on which layer.
    pub fn label(&self) -> String {
        if self.layer.is_empty() {
            self.entity.clone()
        } else {
            format!("{} on layer {:?}", self.entity, self.layer)
        }
    }
}
