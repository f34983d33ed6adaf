//! Bodies in three dimensions, and their sections.

use crate::loaded::LoadedTrial;
use crate::run::LabRun;
use crate::{Refused, Reply, require, within};
use lemons_core::plane::{Disk, union};
use lemons_core::trial::Agent;
use lemons_people::{Body3d, BodySlice, Figure, MeshPart, Person, packed};
use serde::Serialize;

/// Most people whose bodies are shown: a quarter of a MB each.
const MOST: usize = 1000;

/// The numbers of a surface.
#[derive(Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub(crate) struct Surface {
    vertices: usize,
    triangles: usize,
}

/// Everybody's section with a plane.
#[derive(Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub(crate) struct Sections {
    altitude: f64,
    /// \[m\] Polygons of each agent, in its frame; none where the plane is above it.
    bodies: Vec<Vec<Vec<[f64; 2]>>>,
    /// How many bodies the plane cuts.
    cut: usize,
    /// \[m²\] The area of their sections.
    area: f64,
    /// Sex and measures are not known: bodies are those that fit the disks, height and mass.
    estimated: bool,
    /// How many have no body, because none fits the disks.
    without: usize,
}

/// Everybody's surface: numbers of vertices and triangles of each.
#[derive(Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub(crate) struct Bodies {
    agents: Vec<[usize; 2]>,
    /// The same of what goes along, after all agents.
    things: Vec<[usize; 2]>,
    estimated: bool,
    without: usize,
}

/// Returns the surface of a person's body: numbers of vertices and triangles, then [`packed`].
///
/// # Errors
/// A measure is not a person's.
pub fn of_person(person: &Person) -> Result<Reply, Refused> {
    let body = Body3d::of(person)?;
    let ([vertices, triangles], bytes) = packed(&body.mesh());
    Reply::with(Surface { vertices, triangles }, bytes)
}

/// A person's outlines at an altitude \[m\], in the body's frame.
///
/// # Errors
/// A measure is not a person's, or the altitude is out of range.
pub fn section_of(person: &Person, altitude: f64) -> Result<Vec<Vec<[f64; 2]>>, Refused> {
    within("altitude [m]", altitude, [0.0, 3.0])?;
    Ok(outlines(&Body3d::of(person)?.slice_at(altitude)))
}

fn outlines(polygons: &[BodySlice]) -> Vec<Vec<[f64; 2]>> {
    polygons.iter().map(|polygon| polygon.points.iter().map(|p| [p.x, p.y]).collect()).collect()
}

/// Everybody in three dimensions; `None` of whom no body fits the disks.
///
/// # Errors
/// There are too many people.
pub fn of_everybody(of: &LoadedTrial) -> Result<Vec<Option<Figure>>, Refused> {
    let agents = &of.trial.agents;
    let count = agents.len();
    require(count <= MOST, || format!("bodies of {count} people are too many: at most {MOST}"))?;
    Ok(match &of.people {
        Some(people) => people.iter().map(|agent| Figure::of(agent).ok()).collect(),
        None => agents.iter().map(|agent| Figure::fitting(agent).ok()).collect(),
    })
}

/// How many have no body.
fn without(figures: &[Option<Figure>]) -> usize {
    figures.iter().filter(|figure| figure.is_none()).count()
}

/// Returns everybody's outlines at an altitude \[m\], in the body's frame. Of people in levels it finds how many have disks
/// there, and their area: pages know the disks.
///
/// # Errors
/// The altitude is out of range, or there are too many people.
pub fn sections(run: &LabRun, altitude: f64) -> Result<Reply, Refused> {
    within("altitude [m]", altitude, [0.0, 3.0])?;
    let of = &run.loaded;
    if !run.loads.levels.is_empty() {
        let areas = of.trial.agents.iter().map(|agent| area_at(agent, altitude));
        let there: Vec<f64> = areas.filter(|area| *area > 0.0).collect();
        let (cut, area) = (there.len(), there.iter().sum());
        return Reply::of(Sections { altitude, bodies: Vec::new(), cut, area, estimated: false, without: 0 });
    }
    let bodies = run.bodies()?;
    let slice = |of: &Option<Figure>| of.as_ref().map_or(Vec::new(), |figure| figure.slice_at(altitude));
    let slices: Vec<Vec<BodySlice>> = bodies.iter().map(slice).collect();
    let area: f64 = slices.iter().flatten().map(BodySlice::area).sum();
    let cut = slices.iter().filter(|polygons| !polygons.is_empty()).count();
    let (estimated, without) = (of.people.is_none(), without(bodies));
    let bodies = slices.iter().map(|polygons| outlines(polygons)).collect();
    Reply::of(Sections { altitude, bodies, cut, area, estimated, without })
}

/// \[m²\] The area of an agent's disks at an altitude \[m\].
fn area_at(agent: &Agent, altitude: f64) -> f64 {
    let all = agent.disks_facing_x().into_iter().zip(&agent.shapes);
    let there = all.filter(|(_, shape)| shape.heights.hold(altitude));
    let disks: Vec<Disk> = there.map(|((centre, radius), _)| Disk { centre, radius }).collect();
    union(&disks).area
}

/// Returns everybody's surface, in the body's frame; less fine, because there are many. Then come the surfaces of things.
///
/// # Errors
/// The numbers cannot be written.
pub fn surfaces(of: &LoadedTrial, figures: &[Option<Figure>]) -> Result<Reply, Refused> {
    let mut bytes = Vec::new();
    let mut all = |parts: fn(&Figure) -> Vec<MeshPart>| -> Vec<[usize; 2]> {
        let of_one = |figure: &Option<Figure>| {
            let (counts, surface) = packed(&figure.as_ref().map_or(Vec::new(), parts));
            bytes.extend(surface);
            counts
        };
        figures.iter().map(of_one).collect()
    };
    let (agents, things) = (all(|figure| figure.bodies(false)), all(Figure::things));
    let (estimated, without) = (of.people.is_none(), without(figures));
    Reply::with(Bodies { agents, things, estimated, without }, bytes)
}
