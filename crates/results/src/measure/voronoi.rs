//! The Voronoi cells of people in a room: of each place, whose it is, and walls hold cells back.

use lemons_core::plane::overlay::{Contour, InsideRule, contour, intersection, ring};
use lemons_core::plane::{Bounds, Polygon, Ring, Vec2};

/// Where people can be: a polygon with holes.
#[derive(Debug, Clone, PartialEq)]
pub struct VoronoiRoom {
    polygon: Vec<Contour>,
    bounds: Bounds,
    sides: Vec<Bounds>,
    of: Polygon,
}

impl VoronoiRoom {
    /// Makes the room of a polygon \[m\].
    pub fn of(polygon: &Polygon) -> VoronoiRoom {
        let sides = polygon.rings().flat_map(Ring::sides).filter_map(|(a, b)| Bounds::of([a, b])).collect();
        let contours = polygon.rings().map(contour).collect();
        VoronoiRoom { polygon: contours, bounds: polygon.outer.bounds(), sides, of: polygon.clone() }
    }

    /// Returns the nearest place \[m\] in the room, and how far it is.
    pub fn nearest(&self, place: Vec2) -> (Vec2, f64) {
        if self.of.contains(place) {
            return (place, 0.0);
        }
        let feet = self.of.rings().map(|ring| ring.nearest(place));
        let nearest = feet.min_by(|a, b| a.distance.total_cmp(&b.distance));
        nearest.map_or((place, 0.0), |foot| (foot.place, foot.distance))
    }

    /// The cells of people at these places \[m\], in their order, where they may meet a rectangle; else `None`.
    ///
    /// A cell is what is nearer to its person than to all others. A wall may cut it into parts; the cell is the part that
    /// the person is in. People at the same place have the same cell.
    pub(crate) fn cells(&self, people: &[Vec2], near: Bounds) -> Vec<Option<Vec<Contour>>> {
        let mut order: Vec<usize> = (0..people.len()).collect();
        order.sort_by(|a, b| people[*a].x.total_cmp(&people[*b].x));
        let mut cells = vec![None; people.len()];
        for (place, &agent) in order.iter().enumerate() {
            let corners = self.nearest_to(people, &order, place);
            let meets = Bounds::of(corners.iter().copied()).filter(|bounds| bounds.meets(&near));
            if let Some(bounds) = meets {
                cells[agent] = Some(self.cut(corners, bounds, people[agent]));
            }
        }
        cells
    }

    /// The convex polygon of what is nearest to somebody, within the room's bounds.
    fn nearest_to(&self, people: &[Vec2], order: &[usize], place: usize) -> Vec<Vec2> {
        let own = people[order[place]];
        let around = Bounds::of([self.bounds.low, self.bounds.high, own]).unwrap_or(self.bounds).grown(1.0);
        let mut cell = Ring::around(around).corners().to_vec();
        let reach = |cell: &[Vec2]| cell.iter().map(|corner| (*corner - own).norm()).fold(0.0, f64::max);
        let mut radius = reach(&cell);
        // By turns to both sides, from the nearest in x on, until nobody can come near enough.
        let (mut left, mut right) = (place, place + 1);
        loop {
            let off = |k: Option<usize>| k.map_or(f64::INFINITY, |k| (people[order[k]].x - own.x).abs());
            let [west, east] = [off(left.checked_sub(1)), off((right < order.len()).then_some(right))];
            if west.min(east) > 2.0 * radius || west.min(east) == f64::INFINITY {
                return cell;
            }
            let other = if west <= east {
                left -= 1;
                people[order[left]]
            } else {
                right += 1;
                people[order[right - 1]]
            };
            let away = other - own;
            // Nothing is between two at the same place.
            if away.norm_squared() > 0.0 && away.norm() <= 2.0 * radius {
                cell = halved(&cell, (own + other) * 0.5, away);
                radius = reach(&cell);
            }
        }
    }

    /// The part of a cell that is in the room, with its person in it.
    fn cut(&self, corners: Vec<Vec2>, bounds: Bounds, person: Vec2) -> Vec<Contour> {
        let whole: Vec<Contour> = vec![corners.iter().map(|p| [p.x, p.y]).collect()];
        if !self.sides.iter().any(|side| side.meets(&bounds)) {
            return whole;
        }
        let parts = intersection(&whole, &self.polygon, InsideRule::EvenOdd);
        let off = |polygon: &Vec<Contour>| {
            let ring = polygon.first().and_then(ring);
            ring.map_or(f64::INFINITY, |ring| {
                if ring.contains(person) { 0.0 } else { ring.nearest(person).distance }
            })
        };
        parts.into_iter().min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or_default()
    }
}

/// The part of a convex polygon that is not beyond a line through a point, across a direction.
fn halved(corners: &[Vec2], through: Vec2, away: Vec2) -> Vec<Vec2> {
    let beyond = |p: Vec2| (p - through).dot(&away);
    let mut left = Vec::with_capacity(corners.len() + 1);
    for (k, &b) in corners.iter().enumerate() {
        let a = corners[(k + corners.len() - 1) % corners.len()];
        let (from, to) = (beyond(a), beyond(b));
        if (from > 0.0) != (to > 0.0) {
            left.push(a + (b - a) * (from / (from - to)));
        }
        if to <= 0.0 {
            left.push(b);
        }
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;
    use lemons_core::plane::overlay::area;
    use lemons_core::plane::vec2;

    fn room_of<const N: usize>(holes: [Ring; N], outer: Ring) -> VoronoiRoom {
        VoronoiRoom::of(&Polygon { outer, holes: holes.into() })
    }

    fn square(low: f64, high: f64) -> Ring {
        Ring::around(Bounds { low: vec2(low, low), high: vec2(high, high) })
    }

    fn areas(room: &VoronoiRoom, people: &[Vec2]) -> Vec<f64> {
        room.cells(people, room.bounds).into_iter().map(|cell| area(&cell.unwrap())).collect()
    }

    #[test]
    fn cells_fill_the_room() {
        let room = room_of([square(1.0, 2.0)], square(0.0, 4.0));
        let people: Vec<Vec2> =
            (0..40).map(f64::from).map(|k| vec2((k * 0.61) % 4.0, (k * 0.37) % 4.0)).collect();
        let people: Vec<Vec2> = people.into_iter().filter(|p| !square(0.9, 2.1).contains(*p)).collect();
        let total: f64 = areas(&room, &people).iter().sum();
        // The hole parts some cells; nobody is behind it.
        assert!(total <= 15.0 + 1e-6 && total > 14.5, "{total}");
        let whole = room_of([], square(0.0, 4.0));
        assert!((areas(&whole, &people).iter().sum::<f64>() - 16.0).abs() < 1e-6);
    }

    #[test]
    fn two_share_a_room_by_the_line_between_them() {
        let room = room_of([], square(0.0, 4.0));
        let cells = areas(&room, &[vec2(0.5, 2.0), vec2(1.5, 2.0)]);
        assert!((cells[0] - 4.0).abs() < 1e-6 && (cells[1] - 12.0).abs() < 1e-6, "{cells:?}");
        let alone = areas(&room, &[vec2(1.0, 1.0)]);
        assert!((alone[0] - 16.0).abs() < 1e-6);
        // At the same place nothing is between them.
        let cells = room.cells(&[vec2(1.0, 1.0), vec2(1.0, 1.0)], room.bounds);
        assert!(cells.iter().flatten().all(|cell| (area(cell) - 16.0).abs() < 1e-6) && cells.len() == 2);
    }

    #[test]
    fn a_wall_holds_a_cell_back() {
        // A U of two corridors, 1 m wide, with a wall of 1 m between them.
        let u =
            [(0.0, 0.0), (3.0, 0.0), (3.0, 3.0), (2.0, 3.0), (2.0, 1.0), (1.0, 1.0), (1.0, 3.0), (0.0, 3.0)];
        let room = room_of([], Ring::through(u.iter().map(|&(x, y)| vec2(x, y)).collect()).unwrap());
        // Nearer to 2.9, 2.5 than to 0.2, 2.5 begins at 1.55, within the wall.
        let cells = areas(&room, &[vec2(0.2, 2.5), vec2(2.9, 2.5)]);
        assert!((cells[0] - 3.55).abs() < 1e-6 && (cells[1] - 3.45).abs() < 1e-6, "{cells:?}");
        // With a third one below, what is left of the first beyond the wall is not his.
        let cells = areas(&room, &[vec2(0.9, 2.5), vec2(0.5, 0.5)]);
        assert!((cells[0] + cells[1]) < 7.0 - 0.5, "{cells:?}");
    }
}
