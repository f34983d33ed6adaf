//! Places of a drawn room that nobody can be at, or get to, in words.

use super::place::NamedPlace;
use super::plan::FloorPlan;
use crate::{closed_walls, is_closed};
use lemons_core::plane::overlay::{self, Contour, InsideRule, contour, intersection, ring};
use lemons_core::plane::{Ring, Vec2};

/// A closed wall that holds more of a region is taken as the room.
const MOSTLY: f64 = 0.5;
/// A smaller part of an area is outside by rounding.
const ROUNDING: f64 = 1e-6;
/// More areas than this are only counted.
const MOST: usize = 5;

/// Closed walls.
struct Ground {
    /// Those that no other one holds.
    rooms: Vec<Ring>,
    /// Those within them that are obstacles: none where the drawing does not say what a wall within another one is.
    obstacles: Vec<Ring>,
    /// Those around ground within obstacles.
    islands: Vec<Ring>,
}

impl Ground {
    fn of(plan: &FloorPlan) -> Ground {
        let all = closed_walls(&plan.geometry(""));
        let depth = |k: usize| {
            let corner = all[k].corners()[0];
            let holds = |(j, other): &(usize, &Ring)| {
                *j != k && other.area() > all[k].area() && other.contains(corner)
            };
            all.iter().enumerate().filter(holds).count()
        };
        let mut ground = Ground { rooms: Vec::new(), obstacles: Vec::new(), islands: Vec::new() };
        for (k, ring) in all.iter().enumerate() {
            match depth(k) {
                0 => ground.rooms.push(ring.clone()),
                depth if plan.has_areas && depth % 2 == 0 => ground.islands.push(ring.clone()),
                _ if plan.has_areas => ground.obstacles.push(ring.clone()),
                _ => {}
            }
        }
        ground
    }

    fn rings(&self) -> impl Iterator<Item = &Ring> {
        self.rooms.iter().chain(&self.obstacles).chain(&self.islands)
    }

    fn holds(&self, p: Vec2) -> bool {
        self.rings().filter(|ring| ring.contains(p)).count() % 2 == 1
    }

    /// Returns what is not ground, in words.
    fn outside(&self) -> &'static str {
        if self.obstacles.is_empty() { "outside the walls" } else { "outside the walls or in obstacles" }
    }
}

/// Part of an area that is ground.
struct Part {
    /// Of the area.
    share: f64,
    pieces: usize,
    /// \[m\] The largest piece without holes; none if holes are most of it.
    largest: Option<Vec<Vec2>>,
}

impl Part {
    /// `None` if the sides of the area cross.
    fn of<'a>(corners: &[Vec2], rings: impl Iterator<Item = &'a Ring>) -> Option<Part> {
        let own = Ring::through(corners.to_vec()).filter(|own| own.is_simple() && own.area() > 0.0)?;
        let rings: Vec<Contour> = rings.map(contour).collect();
        let inside = intersection(&[contour(&own)], &rings, InsideRule::EvenOdd);
        let least = ROUNDING * own.area();
        let areas = inside.iter().map(|piece| overlay::area(piece));
        let largest = inside.iter().max_by(|a, b| overlay::area(a).total_cmp(&overlay::area(b)));
        let largest = largest.and_then(|piece| {
            let outer = ring(piece.first()?)?;
            (2.0 * overlay::area(piece) > outer.area()).then(|| outer.corners().to_vec())
        });
        let pieces = areas.clone().filter(|area| *area > least).count();
        Some(Part { share: areas.sum::<f64>() / own.area(), pieces, largest })
    }
}

/// Returns the largest piece of a distribution that is ground: as it is, if all of it is; `None` if nothing is, or if
/// obstacles are most of what it is around. Without closed walls everything is ground.
pub fn inside(plan: &FloorPlan, corners: &[Vec2]) -> Option<Vec<Vec2>> {
    let ground = Ground::of(plan);
    if ground.rooms.is_empty() {
        return Some(corners.to_vec());
    }
    let part = Part::of(corners, ground.rings()).filter(|part| part.share > ROUNDING)?;
    let within = Part::of(corners, ground.rooms.iter())?;
    // Obstacles that are the lesser part are subtracted where people are placed.
    let is_whole = within.share > 1.0 - ROUNDING && part.share > MOSTLY && part.pieces == 1;
    if is_whole { Some(corners.to_vec()) } else { part.largest }
}

/// Says which places lie outside all closed walls or in obstacles, and which areas do not touch that of the outline.
pub fn doubts(plan: &FloorPlan) -> Vec<String> {
    let ground = Ground::of(plan);
    let outside = ground.outside();
    let mut doubts = Vec::new();
    if ground.rooms.is_empty() {
        return doubts;
    }
    let named = |what: &str, NamedPlace { name, corners }: &NamedPlace| {
        let [x, y] = corners[0].into();
        format!("{what} {name:?} at ({x:.2}, {y:.2}) m")
    };
    for place in &plan.distributions {
        let label = named("distribution", place);
        let parts = (Part::of(&place.corners, ground.rooms.iter()), Part::of(&place.corners, ground.rings()));
        let (Some(within), Some(Part { share, pieces, largest })) = parts else {
            doubts.push(format!("the sides of {label} cross: nobody can be placed there"));
            continue;
        };
        if share <= ROUNDING {
            doubts.push(format!("{label} lies {outside}: nobody can be placed there"));
            continue;
        }
        for (part, of_whole, place) in [
            (within.share, 1.0 - ROUNDING, "outside the walls"),
            (share / within.share, MOSTLY, "in obstacles"),
        ] {
            if part < of_whole {
                let part = 100.0 * (1.0 - part);
                doubts.push(format!("{part:.0} % of {label} lie {place}: people are placed elsewhere in it"));
            }
        }
        if pieces > 1 {
            doubts.push(format!(
                "{label} lies in {pieces} places that walls keep apart: people are placed in one of them only"
            ));
        }
        if largest.is_none() {
            doubts.push(format!("obstacles are most of {label}: nobody can be placed there"));
        }
    }
    for place in &plan.waypoints {
        if !ground.holds(place.middle().0) {
            doubts.push(format!(
                "{} lies {outside}: nobody gets there through them",
                named("way-point", place)
            ));
        }
    }
    let opens = !plan.doors().is_empty() || plan.walls.iter().any(|wall| !is_closed(wall));
    for place in plan.exits.iter().filter(|_| !opens) {
        if !place.corners.iter().any(|corner| ground.holds(*corner)) {
            doubts.push(format!("{} lies outside the walls, which have no opening", named("exit", place)));
        }
    }
    // Of two that are as large, one is the outline.
    let is_outline = |room: &Ring| plan.outline.is_some_and(|k| plan.walls[k].starts_with(room.corners()));
    let all = ground.rooms.iter().chain(&ground.islands);
    let apart: Vec<&Ring> = all.filter(|room| !is_outline(room)).collect();
    for room in apart.iter().take(MOST) {
        let bounds = room.bounds();
        let ([x, y], [right, top]): ([f64; 2], [f64; 2]) = (bounds.low.into(), bounds.high.into());
        doubts.push(format!(
            "the area of {:.2} m² from ({x:.2}, {y:.2}) to ({right:.2}, {top:.2}) m does not touch that of the outline: nobody is \
             placed there without a distribution or --region",
            room.area()
        ));
    }
    if apart.len() > MOST {
        doubts.push(format!("{} more areas do not touch that of the outline", apart.len() - MOST));
    }
    doubts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::{DrawingFormat, PlanSettings, Read, Reading};

    fn plan(areas: &[(&str, [f64; 4])]) -> FloorPlan {
        let feature = |(layer, [x, y, right, top]): &(&str, [f64; 4])| {
            format!(
                "{{\"type\":\"Feature\",\"properties\":{{\"layer\":\"{layer}\"}},\"geometry\":{{\"type\":\"Polygon\",\
                 \"coordinates\":[[[{x},{y}],[{right},{y}],[{right},{top}],[{x},{top}],[{x},{y}]]]}}}}"
            )
        };
        let all: Vec<String> = areas.iter().map(feature).collect();
        let text = format!("{{\"type\":\"FeatureCollection\",\"features\":[{}]}}", all.join(","));
        let read =
            Read::of(DrawingFormat::GeoJson, text.as_bytes(), &Reading::default(), &PlanSettings::default());
        read.unwrap().plan
    }

    /// The outside: by hand. Of 5 m by 6 m from x = 7 m on, 1 m lies in the room.
    #[test]
    fn what_is_outside_is_cut_or_named_with_its_place() {
        let room = ("walkablearea-0", [0.0, 0.0, 8.0, 6.0]);
        let half = plan(&[room, ("distributions-1", [7.0, 0.0, 12.0, 6.0])]);
        let cut = Ring::through(inside(&half, &half.distributions[0].corners).unwrap()).unwrap();
        assert!((cut.area() - 6.0).abs() < 1e-6 && cut.bounds().high.x <= 8.0 + 1e-9);
        assert!(doubts(&half)[0].starts_with("80 % of distribution \"1\" at (7.00, 0.00) m lie outside"));
        let far = plan(&[room, ("distributions-1", [20.0, 0.0, 22.0, 6.0])]);
        assert_eq!(inside(&far, &far.distributions[0].corners), None);
        let far = plan(&[room, ("waypoints-1", [-5.0, 3.0, -4.0, 4.0]), ("exits-a", [9.0, 0.0, 10.0, 1.0])]);
        let messages = doubts(&far);
        assert!(
            messages[0].contains("way-point \"1\" at (-5.00, 3.00) m") && messages[1].contains("exit \"a\""),
            "{messages:?}"
        );
        let apart = plan(&[room, ("walkablearea-1", [20.0, 0.0, 25.0, 5.0])]);
        assert!(doubts(&apart)[0].starts_with("the area of 25.00 m² from (20.00, 0.00) to (25.00, 5.00) m"));
        // Of two that are as large, one is the outline.
        let equal = plan(&[room, ("walkablearea-1", [20.0, 0.0, 28.0, 6.0])]);
        let (messages, outline) =
            (doubts(&equal), Ring::through(equal.walls[equal.outline.unwrap()].clone()));
        let other =
            if outline.unwrap().contains(Vec2::from([1.0, 1.0])) { "(20.00, 0.00)" } else { "(0.00, 0.00)" };
        assert!(messages.len() == 1 && messages[0].contains(other), "{messages:?}");
        assert!(messages[0].contains("does not touch that of the outline"), "{messages:?}");
        let both = plan(&[
            room,
            ("walkablearea-1", [20.0, 0.0, 25.0, 5.0]),
            ("distributions-1", [4.0, 1.0, 21.0, 2.0]),
        ]);
        assert_eq!(inside(&both, &both.distributions[0].corners).unwrap().len(), 4);
        let messages = doubts(&both);
        // 4 m of 17 m in the one, 1 m in the other.
        assert!(
            messages[0].starts_with("71 % of distribution") && messages[1].contains("lies in 2 places"),
            "{messages:?}"
        );
        // Of 8 m by 6.5 m, 8 m by 2.5 m are beside the bar.
        let hall = ("walkablearea-0", [0.0, 0.0, 30.0, 20.0]);
        let bar = ("obstacles-bar", [10.0, 6.0, 18.0, 10.0]);
        let queue = plan(&[hall, bar, ("distributions-1", [10.0, 6.0, 18.0, 12.5])]);
        let beside = Ring::through(inside(&queue, &queue.distributions[0].corners).unwrap()).unwrap();
        assert!((beside.area() - 20.0).abs() < 1e-6 && beside.bounds().low.y >= 10.0 - 1e-9);
        assert!(doubts(&queue)[0].contains("62 % of") && doubts(&queue)[0].contains("in obstacles"));
        let around = plan(&[
            hall,
            bar,
            ("distributions-1", [9.9, 5.9, 18.1, 10.1]),
            ("waypoints-1", [13.0, 7.0, 14.0, 8.0]),
        ]);
        assert_eq!(inside(&around, &around.distributions[0].corners), None);
        let messages = doubts(&around);
        assert!(
            messages[1].contains("obstacles are most of") && messages[2].contains("way-point \"1\""),
            "{messages:?}"
        );
        // Ground that an obstacle encloses.
        let ring = [[1.0, 1.0, 9.0, 2.0], [1.0, 8.0, 9.0, 9.0], [1.0, 1.0, 2.0, 9.0], [8.0, 1.0, 9.0, 9.0]];
        let mut hall = vec![hall];
        hall.extend(ring.map(|at| ("obstacles-ring", at)));
        hall.push(("distributions-1", [3.0, 3.0, 7.0, 7.0]));
        let island = plan(&hall);
        assert_eq!(
            inside(&island, &island.distributions[0].corners).unwrap(),
            island.distributions[0].corners
        );
        let messages = doubts(&island);
        assert!(
            messages.len() == 1 && messages[0].starts_with("the area of 36.00 m² from (2.00, 2.00)"),
            "{messages:?}"
        );
        // All is well; an obstacle is no area apart.
        let well =
            plan(&[room, ("obstacles-0", [2.0, 2.0, 3.0, 3.0]), ("distributions-1", [0.0, 0.0, 8.0, 6.0])]);
        assert!(doubts(&well).is_empty(), "{:?}", doubts(&well));
        assert_eq!(inside(&well, &well.distributions[0].corners).unwrap(), well.distributions[0].corners);
    }
}
