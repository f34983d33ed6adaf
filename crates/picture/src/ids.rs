//! The size of the Ids on the bodies.

use crate::body::Body;
use crate::lettering;
use crate::scene::Scene;

/// Largest height of an Id / half depth of a body.
const TALLEST: f64 = 0.56;
/// Ids with less room than this fraction of the median are left out, so that one small body does not make all Ids
/// small.
const LEAST: f64 = 0.5;

/// \[m\] Cap height for which a body has room.
fn room(id: &str, body: &Body) -> f64 {
    (body.front / lettering::width(id, 1.0).max(0.1)).min(TALLEST * body.front)
}

fn rooms<'a>(scene: &'a Scene) -> impl Iterator<Item = (&'a str, f64)> {
    let named = scene.trial.agents.iter().map(|agent| agent.id.as_str());
    named.zip(&scene.bodies).filter(|(_, body)| !body.disks.is_empty()).map(|(id, body)| (id, room(id, body)))
}

/// \[m\] Cap height of all Ids: the smallest for which there is room, without those left out. It depends on the Trial
/// only, so that it is the same in all frames of a movie.
pub(crate) fn height(scene: &Scene) -> f64 {
    let mut all: Vec<f64> = rooms(scene).map(|(_, room)| room).collect();
    all.sort_by(f64::total_cmp);
    let Some(middle) = all.get(all.len().saturating_sub(1) / 2) else { return 0.0 };
    all.iter().copied().find(|room| *room >= LEAST * middle).unwrap_or(*middle)
}

/// Whether the body has room for the Id at this height.
pub(crate) fn fits(id: &str, body: &Body, height: f64) -> bool {
    room(id, body) >= height
}

/// Returns the Ids that pictures leave out because they would be much smaller than the others.
pub fn ids_without_room<'a>(scene: &'a Scene) -> Vec<&'a str> {
    let height = height(scene);
    rooms(scene).filter(|(_, room)| *room < height).map(|(id, _)| id).collect()
}
