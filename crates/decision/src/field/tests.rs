use super::*;

fn places(at: &[(f64, f64)]) -> impl Iterator<Item = Vec2> {
    at.iter().map(|&(x, y)| vec2(x, y)).collect::<Vec<_>>().into_iter()
}

fn polyline(at: &[(f64, f64)]) -> Vec<Vec2> {
    places(at).collect()
}

/// The outside: straight lines. Fast marching of first order is some steps too long.
#[test]
fn in_the_open_the_distance_is_that_of_the_straight_line() {
    let grid = Grid::new(&[], places(&[(0.0, 0.0), (10.0, 6.0)])).unwrap();
    let field = grid.field(&[[vec2(5.0, 1.0), vec2(5.0, 2.0)]], &[]);
    for at in [vec2(0.3, 5.1), vec2(9.0, 1.5), vec2(5.2, 0.1), vec2(2.0, 1.2)] {
        let nearest = nearest_on_segment(vec2(5.0, 1.0), vec2(5.0, 2.0), at);
        let (wanted, found) = ((nearest - at).norm(), grid.distance(&field, at));
        assert!((found - wanted).abs() < 0.15, "{at:?}: {found} instead of {wanted}");
        let direction = grid.way(&field, at).1.unwrap();
        assert!(direction.dot(&((nearest - at) * (1.0 / wanted))) > 0.99, "{at:?}: {direction:?}");
    }
}

/// The outside: the shortest way round a wall is two straight lines over its end.
#[test]
fn ways_lead_round_walls_and_keep_off_them() {
    let wall = polyline(&[(5.0, -1.0), (5.0, 4.0)]);
    let barrier = polyline(&[(-1.0, -1.0), (11.0, -1.0)]);
    let grid = Grid::new(&[wall, barrier], places(&[(0.0, 0.0), (10.0, 8.0)])).unwrap();
    let exit = Ring::through(polyline(&[(8.0, 0.0), (9.0, 0.0), (9.0, 1.0), (8.0, 1.0)])).unwrap();
    let field = grid.field(&[], &[exit]);
    let (from, end, to) = (vec2(2.0, 0.5), vec2(5.0, 4.0), vec2(8.0, 1.0));
    let shortest = (end - from).norm() + (to - end).norm();
    let found = grid.distance(&field, from);
    assert!(shortest < found && found < shortest + 1.2, "{found} instead of {shortest}");
    // Down the field one arrives, and never crosses the wall.
    let (mut at, mut walked, mut nearest) = (from, 0.0, f64::INFINITY);
    while grid.distance(&field, at) > 0.05 {
        let next = at + grid.way(&field, at).1.unwrap() * 0.05;
        assert!(!segments_touch(at, next, vec2(5.0, -1.0), end), "through the wall at {at:?}");
        (at, walked) = (next, walked + 0.05);
        nearest = nearest.min((at - end).norm());
        assert!(walked < 12.0, "lost at {at:?}");
    }
    assert!((0.15..0.5).contains(&nearest), "{nearest} m off the end of the wall");
    assert!(walked < shortest + 0.5, "{walked} instead of {shortest}");
}

#[test]
fn a_door_is_found_and_a_closed_room_has_none() {
    let closed = polyline(&[(0.0, 0.0), (6.0, 0.0), (6.0, 4.0), (0.0, 4.0), (0.0, 0.0)]);
    let exit = [[vec2(7.0, 1.0), vec2(7.0, 3.0)]];
    let grid = Grid::new(&[closed], places(&[(8.0, 0.0)])).unwrap();
    let field = grid.field(&exit, &[]);
    assert_eq!(grid.distance(&field, vec2(3.0, 2.0)), f64::INFINITY);
    assert_eq!(grid.way(&field, vec2(3.0, 2.0)).1, None);
    assert_eq!(grid.distance(&field, vec2(1e9, 2.0)), f64::INFINITY);
    // Nobody fits through a slit.
    let slit = polyline(&[(6.0, 2.09), (6.0, 4.0), (0.0, 4.0), (0.0, 0.0), (6.0, 0.0), (6.0, 1.91)]);
    let grid = Grid::new(&[slit], places(&[(8.0, 0.0)])).unwrap();
    assert_eq!(grid.distance(&grid.field(&exit, &[]), vec2(3.0, 2.0)), f64::INFINITY);
    for width in [0.4, 0.8, 2.0] {
        let (low, high) = (2.0 - 0.5 * width, 2.0 + 0.5 * width);
        let open = polyline(&[(6.0, high), (6.0, 4.0), (0.0, 4.0), (0.0, 0.0), (6.0, 0.0), (6.0, low)]);
        let grid = Grid::new(&[open], places(&[(8.0, 0.0)])).unwrap();
        let field = grid.field(&exit, &[]);
        let found = grid.distance(&field, vec2(3.0, 2.0));
        assert!((3.99..5.5).contains(&found), "{width}: {found}");
    }
}

/// The outside: the widths that were drawn.
#[test]
fn a_way_is_as_wide_as_its_narrowest_door() {
    // A room with a door of 0.9 m, a corridor 2 m wide with a door of 1.4 m at its end, and what is behind it.
    let lower = polyline(&[(6.0, 2.1), (6.0, 0.0), (0.0, 0.0), (0.0, 8.0), (6.0, 8.0), (6.0, 3.0)]);
    let corridor = [
        polyline(&[(6.0, 1.5), (12.0, 1.5), (12.0, 1.7)]),
        polyline(&[(6.0, 3.5), (12.0, 3.5), (12.0, 3.1)]),
    ];
    let walls = [&[lower][..], &corridor].concat();
    let grid = Grid::new(&walls, places(&[(20.0, -2.0), (20.0, 10.0)])).unwrap();
    let area = polyline(&[(16.0, 0.0), (18.0, 0.0), (18.0, 6.0), (16.0, 6.0)]);
    let field = grid.field(&[], &[Ring::through(area).unwrap()]);
    let widths = grid.widths(&field);
    let rooms: [(f64, &[(f64, f64)]); 3] = [
        (0.9, &[(5.5, 2.5), (3.0, 4.0), (1.0, 7.5), (4.0, 1.0)]),
        (1.4, &[(6.5, 2.6), (9.0, 2.0), (11.5, 3.0)]),
        (3.0, &[(15.0, 2.0), (17.0, 3.0), (-0.5, 2.0), (99.0, 2.0)]),
    ];
    for (width, from) in rooms {
        for at in places(from) {
            // Beside no wall there is none.
            let found = grid.width(&widths, at).unwrap_or(3.0);
            assert!((found - width).abs() < 0.03, "{at:?}: {found} instead of {width}");
        }
    }
}

#[test]
fn an_area_beyond_all_measure_is_refused() {
    assert!(Grid::new(&[], places(&[(0.0, 0.0), (400.0, 400.0)])).is_ok());
    for far in [1e4, 1e300] {
        assert!(Grid::new(&[], places(&[(0.0, 0.0), (far, far)])).is_err(), "{far}");
    }
}
