//! Why the outline of a plan may not be the room.

use super::DrawnLine;
use super::bands::THICKNESS;
use super::enclosing::{Enclosing, asked, take};
use super::gap::{number, place};
use super::pieces::SNAP;
use super::plan::FloorPlan;
use super::proposal::{Proposal, about_frame, is_alone};
use super::sort::{Sort, of_name};
use super::swings::{self, Swing};
use crate::error::{BAND, BY_SWING, LITTLE_AROUND, NONE_CLOSED, ON_NOTES, TWO_LINES};
use crate::is_closed;
use lemons_core::message::{Message, message};
use lemons_core::plane::{Ring, Vec2, convex_hull};
use std::collections::BTreeMap;

/// Of what lies around all walls, an outline that lies around less is in doubt.
const MOST: f64 = 0.7;

/// Asks whether the outline of a plan is the frame of a sheet, as a proposal for its walls does.
fn frame(plan: &FloorPlan, outline: &Ring) -> Option<Message> {
    let sides = || plan.walls.iter().flat_map(|wall| wall.windows(2).map(|ends| [ends[0], ends[1]]));
    if plan.has_areas || plan.walls.len() < 2 || !is_alone(outline, sides()) {
        return None;
    }
    let line = |corners: &Vec<Vec2>| DrawnLine {
        layer: String::new(),
        role: None,
        name: None,
        entity: String::new(),
        corners: corners.clone(),
        closed: false,
        hole: false,
        ground: false,
    };
    let lines: Vec<DrawnLine> = plan.walls.iter().map(line).collect();
    // Too many lines are not looked at.
    let taken = take(&lines, &[], &Enclosing::default(), None).ok()?;
    let found = Proposal::from(taken, Vec::new(), Vec::new(), Enclosing::default(), None);
    let rim = Ring::through(found.ground.first()?.clone())?;
    found.is_frame(&rim).then(|| about_frame(&rim))
}

/// Lines of layers, by their corners.
type Layers = BTreeMap<String, Vec<Vec<Vec2>>>;

/// Returns layers that are no walls by their names, such as frames, titles and texts, with their lines.
pub(super) fn notes(lines: &[DrawnLine]) -> Layers {
    let mut notes = Layers::new();
    for (_, line) in asked(lines).filter(|(_, line)| of_name(&line.layer) == Some(Sort::Note)) {
        notes.entry(line.layer.clone()).or_default().push(line.corners.clone());
    }
    notes
}

/// Says why the outline of a plan may not be the room; `None` if nothing speaks against it. Without notes, it is no frame.
pub(super) fn doubt(plan: &FloorPlan, notes: Option<&Layers>) -> Option<Message> {
    let Some(outline) = plan.outline else {
        return Some(message!(NONE_CLOSED));
    };
    let swing = |(k, wall): (usize, &Vec<Vec2>)| Some((k, swings::within(wall)?));
    if let Some((k, Swing { hinge, shut, .. })) =
        plan.walls.iter().enumerate().filter(|(_, wall)| is_closed(wall)).find_map(swing)
    {
        return Some(message!(
            BY_SWING,
            wall = k,
            width = number((shut - hinge).norm()),
            at = place((hinge + shut) * 0.5)
        ));
    }
    let ring = Ring::through(plan.walls[outline].clone())?;
    let rim = |ring: &Ring| ring.sides().map(|(a, b)| (b - a).norm()).sum::<f64>();
    let thickest = THICKNESS[1] + 0.005;
    if 2.0 * ring.area() <= thickest * rim(&ring) {
        let thickness = 2.0 * ring.area() / rim(&ring);
        return Some(message!(BAND, outline, width = 100.0 * thickness));
    }
    let others = plan.walls.iter().enumerate().filter(|(k, _)| *k != outline);
    let inner = others.filter_map(|(k, wall)| Some((k, Ring::of_closed(wall)?)));
    let within = inner.filter(|(_, inner)| {
        let between = ring.area() - inner.area();
        inner.area() > 0.5 * ring.area()
            && 2.0 * between <= thickest * (rim(&ring) + rim(inner))
            && inner.corners().first().is_some_and(|corner| ring.contains(*corner))
    });
    if let Some((k, inner)) = within.max_by(|a, b| a.1.area().total_cmp(&b.1.area())) {
        let between = 2.0 * (ring.area() - inner.area()) / (rim(&ring) + rim(&inner));
        return Some(message!(TWO_LINES, wall = k, width = 100.0 * between, outline));
    }
    let hull = |corners: Vec<Vec2>| Ring::through(convex_hull(corners)).map_or(0.0, |ring| ring.area());
    let own = hull(ring.corners().to_vec());
    let all = hull(plan.walls.iter().flatten().copied().collect());
    if own < MOST * all {
        return Some(message!(LITTLE_AROUND, outline, own, all));
    }
    let notes = notes?;
    let is_on = |lines: &[Vec<Vec2>]| {
        let has =
            |line: &[Vec2], at: Vec2| line.iter().any(|corner| (at + plan.origin - corner).norm() <= SNAP);
        let drawn = |(a, b): (Vec2, Vec2)| lines.iter().any(|line| has(line, a) && has(line, b));
        ring.is_upright() && ring.sides().all(drawn)
    };
    if let Some((layer, _)) = notes.iter().find(|(_, lines)| is_on(lines)) {
        return Some(message!(ON_NOTES, outline, layer));
    }
    frame(plan, &ring)
}
