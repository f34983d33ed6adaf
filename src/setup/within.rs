//! Finds people inside closed walls.

use crate::engine::Vec2;
use lemons_core::plane::{Bounds, Ring, is_closed};
use lemons_core::trial::Wall;
use std::collections::BTreeMap;

/// Largest number of tests whether a person is beside a face of a wall; of a larger crowd an evenly chosen part is tested.
const MOST_LOOKS: u64 = 50_000_000;
/// At most this many people inside a wall may be a mistake ...
const FEW: usize = 2;
/// ... or at most this fraction (1/20) of the people around it; otherwise it is a room.
const SMALL_PART: usize = 20;
/// \[m\] A closed wall that is longer and wider is no pillar for somebody who is alone.
const ROOM: f64 = 2.0;

/// A person inside a closed wall while the others are around it.
#[derive(Debug, PartialEq)]
pub(super) struct Inside {
    /// Index of the first such agent.
    pub(super) agent: usize,
    /// Index of the closed wall around it.
    pub(super) wall: usize,
    /// Number of agents inside such walls.
    pub(super) count: usize,
    /// Number of agents around that wall.
    pub(super) around: usize,
}

/// Finds people inside pillars.
///
/// Closed walls bound areas, one inside the other. Compare an area with the closed walls directly inside it: if more
/// people are around these walls than in all of them together, the walls are pillars, and people inside them are
/// reported. Otherwise they are rooms of a larger one. A wall around several people, more than a twentieth of those
/// around it, is a room in any case.
pub(super) fn within_pillars(walls: &[Wall], places: &[Vec2]) -> Option<Inside> {
    // By the closed walls around each area, from the largest on.
    let mut areas: BTreeMap<Vec<usize>, Area> = BTreeMap::new();
    for (agent, around) in enclosing(walls, places, MOST_LOOKS) {
        for depth in 0..=around.len() {
            let new = Area { around: 0, total: 0, first: agent };
            let area = areas.entry(around[..depth].to_vec()).or_insert(new);
            area.total += 1;
            area.around += usize::from(depth == around.len());
            area.first = area.first.min(agent);
        }
    }
    // Walls inside a pillar are not reported again: either no person is around them in it, or the pillar itself is
    // reported.
    let doubted = areas.iter().filter_map(|(walls, area)| {
        let (wall, outside) = walls.split_last()?;
        let outer = &areas[outside];
        let inside = outer.total - outer.around;
        let few = outer.around > inside && area.total <= FEW.max(outer.around / SMALL_PART);
        few.then_some(Inside { agent: area.first, wall: *wall, count: area.total, around: outer.around })
    });
    doubted.reduce(|one, other| {
        let count = one.count + other.count;
        Inside { count, ..if one.agent < other.agent { one } else { other } }
    })
}

/// Returns the agents who stand outside of all closed walls, and the number of those inside one, if these are more; or
/// the only agent, if a wall is a [`ROOM`].
pub(super) fn outside_rooms(walls: &[Wall], places: &[Vec2]) -> Option<(Vec<usize>, usize)> {
    let (outside, inside): (Vec<_>, Vec<_>) =
        enclosing(walls, places, MOST_LOOKS).into_iter().partition(|(_, around)| around.is_empty());
    let mut outside: Vec<usize> = outside.into_iter().map(|(agent, _)| agent).collect();
    outside.sort_unstable();
    let is_room = |wall: &Wall| {
        let size = Bounds::of(wall.corners.iter().copied()).map(|bounds| bounds.size());
        is_closed(&wall.corners) && size.is_some_and(|size| size.x.min(size.y) > ROOM)
    };
    let alone = places.len() == 1 && outside.len() == 1 && walls.iter().any(is_room);
    (alone || outside.len() < inside.len()).then_some((outside, inside.len()))
}

/// The people in an area inside closed walls.
struct Area {
    /// Number of people in it and in no closed wall inside it.
    around: usize,
    /// Number of people in it.
    total: usize,
    /// Index of the first of these people.
    first: usize,
}

/// Returns for each tested agent the closed walls around it, from the largest on.
fn enclosing(walls: &[Wall], places: &[Vec2], most: u64) -> Vec<(usize, Vec<usize>)> {
    let closed = |(wall, of): (usize, &Wall)| Some((Ring::of_closed(&of.corners)?, wall));
    let mut closed: Vec<(Ring, usize)> = walls.iter().enumerate().filter_map(closed).collect();
    closed.sort_by(|a, b| b.0.area().total_cmp(&a.0.area()).then(a.1.cmp(&b.1)));
    if closed.is_empty() {
        return Vec::new();
    }
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by(|&a, &b| places[a].y.total_cmp(&places[b].y));
    // Those as high as a wall.
    let level = |order: &[usize], bounds: Bounds| {
        let from = order.partition_point(|&agent| places[agent].y < bounds.low.y);
        from..from + order[from..].partition_point(|&agent| places[agent].y < bounds.high.y)
    };
    let looks =
        |(ring, _): &(Ring, usize)| (ring.corners().len() * level(&order, ring.bounds()).len()) as u64;
    let each = closed.iter().map(looks).sum::<u64>().div_ceil(most).max(1);
    let order: Vec<usize> = order.into_iter().step_by(usize::try_from(each).unwrap_or(usize::MAX)).collect();
    let mut around: Vec<Vec<usize>> = vec![Vec::new(); order.len()];
    for (ring, wall) in &closed {
        let bounds = ring.bounds();
        for at in level(&order, bounds) {
            let place = places[order[at]];
            if bounds.contains(place) && ring.contains(place) {
                around[at].push(*wall);
            }
        }
    }
    order.into_iter().zip(around).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::vec2;

    fn closed(id: &str, corners: impl IntoIterator<Item = (f64, f64)>) -> Wall {
        let mut corners: Vec<Vec2> = corners.into_iter().map(|(x, y)| vec2(x, y)).collect();
        corners.extend(corners.first().copied());
        Wall::new(id, "concrete", corners)
    }

    fn square(id: &str, x: f64, y: f64, side: f64) -> Wall {
        closed(id, [(x, y), (x + side, y), (x + side, y + side), (x, y + side)])
    }

    /// So many, side by side.
    fn row(count: u32, x: f64, y: f64) -> Vec<Vec2> {
        (0..count).map(|k| vec2(x + 0.1 * f64::from(k), y)).collect()
    }

    #[test]
    fn who_stands_in_a_pillar_of_a_room_is_told_and_nobody_in_rooms() {
        let (room, pillar) = (square("room", 0.0, 0.0, 10.0), square("pillar", 4.0, 4.0, 1.0));
        let told = |walls: &[&Wall], more: &[Vec2]| {
            let walls: Vec<Wall> = walls.iter().map(|wall| (*wall).clone()).collect();
            let found = within_pillars(&walls, &[row(4, 1.0, 1.0), more.to_vec()].concat());
            found.map(|Inside { agent, wall, count, around }| (agent, wall, count, around))
        };
        let inside = vec2(4.5, 4.5);
        assert_eq!(told(&[&room, &pillar], &[inside]), Some((4, 1, 1, 4)));
        // Of a room with a door, which is not closed, too; and in the open.
        assert_eq!(told(&[&pillar], &[inside]), Some((4, 0, 1, 4)));
        assert_eq!(told(&[&pillar, &room], &[inside, vec2(4.2, 4.7)]), Some((4, 0, 2, 4)));
        // On its edge's line, beside it, and in nothing at all.
        for beside in [vec2(4.5, 3.9), vec2(3.0, 4.0), vec2(5.1, 5.0), vec2(-1.0, 4.5)] {
            assert_eq!(told(&[&room, &pillar], &[beside]), None, "{beside:?}");
        }
        // A hollow pillar is told once.
        assert_eq!(told(&[&square("hollow", 4.2, 4.2, 0.6), &room, &pillar], &[inside]), Some((4, 2, 1, 4)));
    }

    #[test]
    fn rooms_within_larger_ones_are_no_pillars() {
        let hall = [square("hall", 0.0, 0.0, 30.0), square("cabin", 20.0, 20.0, 5.0)];
        // All in the inner one; most there; a cabin for ten of a hundred.
        let inner = row(20, 21.0, 22.0);
        for people in [
            inner.clone(),
            [inner, row(5, 2.0, 2.0)].concat(),
            [row(100, 2.0, 2.0), row(10, 21.0, 22.0)].concat(),
        ] {
            assert_eq!(within_pillars(&hall, &people), None);
        }
        // Rooms beside each other.
        let rooms = (0..10).map(|k| square("room", 2.0 * f64::from(k), 5.0, 1.5));
        let people = (0..10).flat_map(|k| row(1 + k % 3, 2.0 * f64::from(k) + 0.2, 5.5));
        let all: Vec<Wall> = hall[..1].iter().cloned().chain(rooms).collect();
        assert_eq!(within_pillars(&all, &people.chain(row(12, 1.0, 1.0)).collect::<Vec<_>>()), None);
    }

    /// Closed walls of 100 000 corners among as many people.
    #[test]
    fn the_work_has_a_bound_however_many_people_and_faces_there_are() {
        // Each face is as high as the wall.
        let comb = |teeth: u32| {
            let teeth = (0..teeth).map(f64::from);
            closed("comb", teeth.flat_map(|k| [(k, 0.0), (k + 0.5, 9.0)]).chain([(0.0, 10.0)]))
        };
        let people: Vec<Vec2> = (0..3000).map(|k| vec2(f64::from(k), 1e-3 * f64::from(k))).collect();
        let tested = enclosing(&[comb(3000)], &people, 100_000).len();
        assert!((10..=17).contains(&tested), "{tested}");
        let angle = |k: u32| f64::from(k) * 1e-3;
        let circle =
            closed("circle", (0..6283).map(|k| (50.0 * libm::cos(angle(k)), 50.0 * libm::sin(angle(k)))));
        let all = enclosing(&[circle], &people, MOST_LOOKS);
        assert_eq!((all.len(), all.iter().filter(|(_, within)| within.len() == 1).count()), (3000, 50));
    }
}
