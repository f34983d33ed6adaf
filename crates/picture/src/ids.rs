//! The size of the ids on the bodies.

use crate::body::Body;
use crate::lettering;
use crate::scene::Scene;

/// Of a body's half depth: ids are not higher.
const TALLEST: f64 = 0.56;
/// Ids that ask for less than this part of what the one in the middle has room for are left out: a single
/// small body does not make all ids small.
const LEAST: f64 = 0.5;

/// \[m\] The cap height for which there is room on a body.
fn room(id: &str, body: &Body) -> f64 {
    (body.front / lettering::width(id, 1.0).max(0.1)).min(TALLEST * body.front)
}

fn rooms<'a>(scene: &'a Scene) -> impl Iterator<Item = (&'a str, f64)> {
    let named = scene.trial.agents.iter().map(|agent| agent.id.as_str());
    named.zip(&scene.bodies).filter(|(_, body)| !body.disks.is_empty()).map(|(id, body)| (id, room(id, body)))
}

/// \[m\] The cap height of all ids: the smallest that there is room for, but for those left out. It hangs on
/// the Trial alone, so that it is the same in all frames of a movie.
pub(crate) fn height(scene: &Scene) -> f64 {
    let mut all: Vec<f64> = rooms(scene).map(|(_, room)| room).collect();
    all.sort_by(f64::total_cmp);
    let Some(middle) = all.get(all.len().saturating_sub(1) / 2) else { return 0.0 };
    all.iter().copied().find(|room| *room >= LEAST * middle).unwrap_or(*middle)
}

/// Whether there is room for the id at this height.
pub(crate) fn fits(id: &str, body: &Body, height: f64) -> bool {
    room(id, body) >= height
}

/// Agents whose id is left out of pictures with ids: it would be much smaller than the others are.
pub fn ids_without_room<'a>(scene: &'a Scene) -> Vec<&'a str> {
    let height = height(scene);
    rooms(scene).filter(|(_, room)| *room < height).map(|(id, _)| id).collect()
}
