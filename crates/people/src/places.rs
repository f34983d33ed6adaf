//! Places of a drawn room that nobody can be at, or get to, in words.

use crate::drawing::{Place, Plan};
use crate::{closed_walls, is_closed};
use lemons_core::plane::overlay::{Contour, Fill, contour, intersection, ring};
use lemons_core::plane::{Ring, Vec2};

/// A smaller part of an area is outside by rounding.
const ROUNDING: f64 = 1e-6;
/// More areas than this are only counted.
const MOST: usize = 5;

fn area(polygons: &[Vec<Contour>]) -> f64 {
    polygons.iter().flatten().filter_map(ring).map(|ring| ring.signed_area()).sum::<f64>().abs()
}

/// Returns the closed walls that no other one holds.
fn outermost(plan: &Plan) -> Vec<Ring> {
    let all = closed_walls(&plan.geometry(""));
    let is_held = |k: usize| {
        let corner = all[k].corners()[0];
        let holds =
            |(j, other): (usize, &Ring)| j != k && other.area() > all[k].area() && other.contains(corner);
        all.iter().enumerate().any(holds)
    };
    (0..all.len()).filter(|k| !is_held(*k)).map(|k| all[k].clone()).collect()
}

/// What of an area lies in a room.
struct Part {
    /// Of the area.
    share: f64,
    pieces: usize,
    /// \[m\] The largest piece, without holes.
    largest: Vec<Vec2>,
}

impl Part {
    fn of(corners: &[Vec2], room: &Ring) -> Option<Part> {
        let own = Ring::through(corners.to_vec()).filter(|own| own.is_simple() && own.area() > 0.0)?;
        let inside = intersection(&[contour(&own)], &[contour(room)], Fill::EvenOdd);
        let least = ROUNDING * own.area();
        let pieces: Vec<Ring> = inside.iter().filter_map(|polygon| ring(polygon.first()?)).collect();
        let largest = pieces.iter().max_by(|a, b| a.area().total_cmp(&b.area()))?;
        Some(Part {
            share: area(&inside) / own.area(),
            pieces: pieces.iter().filter(|piece| piece.area() > least).count(),
            largest: largest.corners().to_vec(),
        })
    }
}

/// Returns what of a distribution lies in the room that holds most of it: as it is, if all does; `None` if nothing does.
/// Without closed walls everything is inside.
pub fn inside(plan: &Plan, corners: &[Vec2]) -> Option<Vec<Vec2>> {
    let rooms = outermost(plan);
    if rooms.is_empty() {
        return Some(corners.to_vec());
    }
    let parts = rooms.iter().filter_map(|room| Part::of(corners, room));
    let most = parts.max_by(|a, b| a.share.total_cmp(&b.share)).filter(|part| part.share > ROUNDING)?;
    Some(if most.share > 1.0 - ROUNDING { corners.to_vec() } else { most.largest })
}

/// Says which places lie outside all closed walls, and which areas do not touch the largest one.
pub fn doubts(plan: &Plan) -> Vec<String> {
    let rooms = outermost(plan);
    let mut doubts = Vec::new();
    if rooms.is_empty() {
        return doubts;
    }
    let named = |what: &str, Place { name, corners }: &Place| {
        let [x, y] = corners[0].into();
        format!("{what} {name:?} at ({x:.2}, {y:.2}) m")
    };
    for place in &plan.distributions {
        let parts: Vec<Part> = rooms.iter().filter_map(|room| Part::of(&place.corners, room)).collect();
        let share: f64 = parts.iter().map(|part| part.share).sum();
        let pieces: usize = parts.iter().map(|part| part.pieces).sum();
        let said = named("distribution", place);
        if share <= ROUNDING {
            doubts.push(format!("{said} lies outside the walls: nobody can be placed there"));
        } else if share < 1.0 - ROUNDING {
            let outside = 100.0 * (1.0 - share);
            doubts.push(format!(
                "{outside:.0} % of {said} lie outside the walls: people are placed inside only"
            ));
        }
        if pieces > 1 {
            doubts.push(format!(
                "{said} lies in {pieces} places that walls keep apart: people are placed in one of them only"
            ));
        }
    }
    for place in &plan.waypoints {
        let middle = place.middle().0;
        if !rooms.iter().any(|room| room.contains(middle)) {
            doubts.push(format!(
                "{} lies outside the walls: nobody gets there through them",
                named("way-point", place)
            ));
        }
    }
    let opens = !plan.doors().is_empty() || plan.walls.iter().any(|wall| !is_closed(wall));
    for place in plan.exits.iter().filter(|_| !opens) {
        if !place.corners.iter().any(|corner| rooms.iter().any(|room| room.contains(*corner))) {
            doubts.push(format!("{} lies outside the walls, which have no opening", named("exit", place)));
        }
    }
    let largest = rooms.iter().map(Ring::area).fold(0.0, f64::max);
    let others: Vec<&Ring> = rooms.iter().filter(|room| room.area() < largest).collect();
    let equal = rooms.len() - others.len();
    let apart = others.into_iter().chain(rooms.iter().filter(|room| room.area() == largest).take(equal - 1));
    let apart: Vec<&Ring> = apart.collect();
    for room in apart.iter().take(MOST) {
        let bounds = room.bounds();
        let ([x, y], [right, top]): ([f64; 2], [f64; 2]) = (bounds.low.into(), bounds.high.into());
        doubts.push(format!(
            "the area of {:.2} m² from ({x:.2}, {y:.2}) to ({right:.2}, {top:.2}) m does not touch the largest one: nobody is \
             placed there without a distribution or --region",
            room.area()
        ));
    }
    if apart.len() > MOST {
        doubts.push(format!("{} more areas do not touch the largest one", apart.len() - MOST));
    }
    doubts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::{Format, PlanSettings, Read, Reading};

    fn plan(areas: &[(&str, [f64; 4])]) -> Plan {
        let feature = |(layer, [x, y, right, top]): &(&str, [f64; 4])| {
            format!(
                "{{\"type\":\"Feature\",\"properties\":{{\"layer\":\"{layer}\"}},\"geometry\":{{\"type\":\"Polygon\",\
                 \"coordinates\":[[[{x},{y}],[{right},{y}],[{right},{top}],[{x},{top}],[{x},{y}]]]}}}}"
            )
        };
        let all: Vec<String> = areas.iter().map(feature).collect();
        let text = format!("{{\"type\":\"FeatureCollection\",\"features\":[{}]}}", all.join(","));
        let read = Read::of(Format::GeoJson, text.as_bytes(), &Reading::default(), &PlanSettings::default());
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
        let said = doubts(&far);
        assert!(
            said[0].contains("way-point \"1\" at (-5.00, 3.00) m") && said[1].contains("exit \"a\""),
            "{said:?}"
        );
        let apart = plan(&[room, ("walkablearea-1", [20.0, 0.0, 25.0, 5.0])]);
        assert!(doubts(&apart)[0].starts_with("the area of 25.00 m² from (20.00, 0.00) to (25.00, 5.00) m"));
        let both = plan(&[
            room,
            ("walkablearea-1", [20.0, 0.0, 25.0, 5.0]),
            ("distributions-1", [4.0, 1.0, 21.0, 2.0]),
        ]);
        assert_eq!(inside(&both, &both.distributions[0].corners).unwrap().len(), 4);
        let said = doubts(&both);
        // 4 m of 17 m in the one, 1 m in the other.
        assert!(
            said[0].starts_with("71 % of distribution") && said[1].contains("lies in 2 places"),
            "{said:?}"
        );
        // All is well; an obstacle is no area apart.
        let well =
            plan(&[room, ("obstacles-0", [2.0, 2.0, 3.0, 3.0]), ("distributions-1", [0.0, 0.0, 8.0, 6.0])]);
        assert!(doubts(&well).is_empty(), "{:?}", doubts(&well));
        assert_eq!(inside(&well, &well.distributions[0].corners).unwrap(), well.distributions[0].corners);
    }
}
