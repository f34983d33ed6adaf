//! A drawing that was read, and what is messages of it.

use super::areas::TOUCH;
use super::{
    Drawing, DrawingFormat, FloorPlan, LayerRole, NamedPlace, PlanSettings, Reading, UNITS, UnitFrom,
    WIDEST_GAP, left_out, some_of,
};
use super::{doubt, outside};
use crate::error::Result;
use crate::is_closed;
use crate::placing::FARTHEST;
use lemons_core::message::Message;
use lemons_core::plane::{Bounds, Vec2};
use std::collections::BTreeMap;

/// \[m\] Longer side of the smallest room, and of the largest, whose unit is not doubted. A small hall in millimetres that
/// is read in metres is larger.
const SMALLEST: f64 = 1.0;
const LARGEST: f64 = 3_000.0;
/// More kinds of what is left out are only counted.
const MOST_LEFT_OUT: usize = 100;

/// A drawing that was read: what it means, and how it was understood.
#[derive(Debug, Clone, PartialEq)]
pub struct Read {
    /// Meaning of its lines.
    pub plan: FloorPlan,
    /// Layers without a meaning, of which [`PlanSettings::walls`] can choose; none where others have one.
    pub layers: Vec<String>,
    /// Why the outline may not be the room; none where nothing speaks against it, or somebody has messages what it is.
    pub doubt: Option<Message>,
    format: DrawingFormat,
    unit: f64,
    unit_from: UnitFrom,
    curves: usize,
    deviation: f64,
    close: Option<f64>,
}

/// Says how large a drawing would be in each of [`UNITS`]. Its width and height are in its own units.
pub fn sizes([width, height]: [f64; 2]) -> String {
    let all =
        UNITS.map(|(name, metres)| format!("{name}: {:.2} m x {:.2} m", width * metres, height * metres));
    format!("it is {width:.2} x {height:.2} units, which would be {}", all.join(", "))
}

impl Read {
    /// Reads the content of a file.
    ///
    /// # Errors
    /// Those of [`Drawing::read`] and [`FloorPlan::of`].
    pub fn of(
        format: DrawingFormat,
        bytes: &[u8],
        reading: &Reading,
        settings: &PlanSettings,
    ) -> Result<Read> {
        let drawing = Drawing::read(format, bytes, reading)?;
        let &Drawing { unit, unit_from, curves, .. } = &drawing;
        let mut layers: BTreeMap<String, Option<LayerRole>> = BTreeMap::new();
        for line in &drawing.lines {
            layers.entry(line.layer.clone()).or_insert_with(|| line.role.as_ref().map(|(role, _)| *role));
        }
        let has_areas =
            layers.values().any(|role| matches!(role, Some(LayerRole::WalkableArea | LayerRole::Obstacle)));
        if has_areas {
            layers.clear();
        }
        let (deviation, close) = (reading.deviation, settings.close);
        // Who names walls knows that no frame is among them.
        let notes = settings.walls.is_empty().then(|| doubt::notes(&drawing.lines));
        let plan = FloorPlan::of(drawing, settings)?;
        let is_said = settings.enclosing.is_some() || has_areas || plan.ground.is_some();
        let doubt = (!is_said).then(|| doubt::doubt(&plan, notes.as_ref())).flatten();
        let layers = layers.into_iter().filter(|(_, role)| role.is_none()).map(|(layer, _)| layer).collect();
        Ok(Read { plan, layers, doubt, format, unit, unit_from, curves, deviation, close })
    }

    /// Says what was understood, a line each: what, and how much of it. `name` is the drawing's.
    pub fn messages(&self, name: &str) -> Vec<(&'static str, String)> {
        let Read { plan, format, unit, unit_from, .. } = self;
        let from = match unit_from {
            UnitFrom::User => "as asked for",
            UnitFrom::File => "$INSUNITS",
            UnitFrom::Format => "by custom",
        };
        let mut messages = vec![("drawing", format!("{name}: {}, unit {unit} m ({from})", format.name()))];
        if let Some(Bounds { low, high }) = plan.bounds() {
            let size = high - low;
            let [x, y] = low.into();
            messages.push((
                "size",
                format!("{:.3} m x {:.3} m, lower left corner at {x:.3},{y:.3}", size.x, size.y),
            ));
        }
        messages.extend(self.doubtful());
        if plan.origin != Vec2::zeros() {
            let [x, y] = plan.origin.into();
            messages.push(("moved", format!("by {:?},{:?} m", told(-x), told(-y))));
        }
        messages.push(("walls", self.walls()));
        if let Some(area) = plan.area() {
            let of = if plan.ground.is_some() { "of all areas" } else { "within the outline" };
            messages.push(("ground", format!("{area:.3} m² {of}, without obstacles")));
        }
        let names = some_of(&plan.within);
        match plan.within.len() {
            0 => {}
            1 => messages.push((
                "warning",
                format!(
                    "{names} lies within another polygon and is counted as floor; if it is an obstacle, draw it as a hole"
                ),
            )),
            _ => messages.push((
                "warning",
                format!(
                    "{names} lie within other polygons and are counted as floor; if they are obstacles, draw them as holes"
                ),
            )),
        }
        messages.extend(self.doubt.iter().map(|doubt| ("in doubt", doubt.text.clone())));
        self.changes(&mut messages);
        let named = |places: &[NamedPlace]| {
            // Names may hold anything.
            let names: Vec<String> =
                places.iter().map(|place| place.name.escape_debug().to_string()).collect();
            format!("{}: {}", names.len(), names.join(", "))
        };
        for (what, places) in
            [("exits", &plan.exits), ("distributions", &plan.distributions), ("way-points", &plan.waypoints)]
        {
            if !places.is_empty() {
                messages.push((what, named(places)));
            }
        }
        for (exit, door) in plan.doors() {
            let name = &plan.exits[exit].name;
            messages.push((
                "door",
                format!(
                    "{} m wide where exit {name:?} lies on a closed wall, or up to 0.2 m from it",
                    told(door.width)
                ),
            ));
        }
        for exit in plan.inner_exits() {
            let name = &plan.exits[exit].name;
            let advice = "for a door, draw a line on the wall, or an exit beyond an opening";
            messages.push((
                "warning",
                format!(
                    "exit {name:?} lies inside closed walls: people vanish in the room, as by stairs or a lift; {advice}"
                ),
            ));
        }
        messages.extend(outside::doubts(plan).into_iter().map(|doubt| ("warning", doubt)));
        let kinds = plan.left_out.len();
        messages.extend(plan.left_out.iter().take(MOST_LEFT_OUT).map(|kind| ("left out", left_out(kind))));
        if kinds > MOST_LEFT_OUT {
            messages.push(("left out", format!("{} more kinds", kinds - MOST_LEFT_OUT)));
        }
        messages
    }

    /// Returns a doubt: probably another unit, or too far away.
    fn doubtful(&self) -> Option<(&'static str, String)> {
        let Bounds { low, high } = self.plan.bounds()?;
        let size = high - low;
        let farthest = low.amax().max(high.amax());
        if !(SMALLEST..=LARGEST).contains(&size.amax()) {
            let own = (size / self.unit).into();
            return Some(("unit?", format!("no room is {:.3} m x {:.3} m; {}", size.x, size.y, sizes(own))));
        }
        (farthest > FARTHEST).then(|| {
            let km = 1e-3 * FARTHEST;
            ("far", format!("{:.0} km from the origin; people stand within {km} km of it", 1e-3 * farthest))
        })
    }

    fn walls(&self) -> String {
        let walls = &self.plan.walls;
        let closed = walls.iter().filter(|wall| is_closed(wall)).count();
        let outline = match self.plan.outline {
            Some(outline) => format!("the outline is wall {outline}"),
            None => "none of them is an outline".to_owned(),
        };
        format!("{}: {closed} closed, {} open; {outline}", walls.len(), walls.len() - closed)
    }

    /// Adds what is other than in the drawing.
    fn changes(&self, messages: &mut Vec<(&'static str, String)>) {
        let FloorPlan { joined, doubles, on_others, ground, .. } = &self.plan;
        if self.curves > 0 {
            messages.push((
                "curves",
                format!(
                    "{} in straight pieces, at most {} mm away from them",
                    self.curves,
                    1e3 * self.deviation
                ),
            ));
        }
        if self.close.is_some() {
            let largest = if joined.gaps > 0 {
                format!(", the largest {:.1} mm", 1e3 * joined.largest)
            } else {
                String::new()
            };
            messages.push(("gaps closed", format!("{}{largest}", joined.gaps)));
        }
        if joined.left > 0 {
            messages.push((
                "gaps left",
                format!("{}, of at most {} cm, between ends of lines", joined.left, 100.0 * WIDEST_GAP),
            ));
        }
        if *doubles > 0 {
            messages.push(("doubles", format!("{doubles} lines lay on others, and are left out")));
        }
        if *on_others > 0 {
            messages.push((
                "on each other",
                format!("{on_others} pieces of walls lie on other walls, and push twice"),
            ));
        }
        if ground.is_some() {
            messages.push((
                "united",
                format!(
                    "areas that meet, or are at most {} cm apart: the walls are the rim of areas without obstacles",
                    100.0 * TOUCH
                ),
            ));
        }
    }
}

/// \[m\] A length as it is told: without what rounding has added.
fn told(length: f64) -> f64 {
    (length * 1e6).round() / 1e6
}
