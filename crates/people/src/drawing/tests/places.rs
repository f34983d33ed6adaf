//! Exits, way-points, and the middles of areas.

use super::*;

#[test]
fn the_middle_of_an_area_is_inside() {
    let middle = |corners: &[(f64, f64)]| {
        let corners = corners.iter().map(|(x, y)| vec2(*x, *y)).collect();
        NamedPlace { name: String::new(), corners }.middle()
    };
    assert_eq!(middle(&[(0.0, 0.0), (4.0, 0.0), (4.0, 2.0), (0.0, 2.0)]), (vec2(2.0, 1.0), Some(1.0)));
    // Two L, the middle outside, or on a corner.
    for width in [1.0, 2.0] {
        let l = [(0.0, 0.0), (4.0, 0.0), (4.0, width), (width, width), (width, 4.0), (0.0, 4.0)];
        let (at, radius) = middle(&l);
        let radius = radius.unwrap();
        assert!(radius > 0.4 * width && radius < 0.6 * width, "{at:?} {radius}");
        assert!(at.x >= radius && at.y >= radius && (at.x < width || at.y < width));
    }
    // Without an inside, it is a point.
    assert_eq!(middle(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)]).1, None);
}

#[test]
fn way_points_have_an_order_if_their_names_say_one() {
    let of = |layers: [&str; 2]| {
        let entities = format!(
            "0 LINE 8 A 10 0 20 0 11 9 21 0 0 CIRCLE 8 {} 10 5 20 5 40 0.5 0 POINT 8 {} 10 1 20 1",
            layers[0], layers[1]
        );
        let plan = plan_of_dxf(&entities);
        plan.way().map(|way| way.iter().map(|place| place.middle()).collect::<Vec<_>>())
    };
    let way = of(["waypoints-stairs2", "waypoints-hall1"]).unwrap();
    assert_eq!(way[0], (vec2(1.0, 1.0), None));
    assert!(near(way[1].0, vec2(5.0, 5.0)) && (way[1].1.unwrap() - 0.5).abs() < DEVIATION);
    assert_eq!(of(["waypoints-a", "waypoints-b"]), None);
    assert_eq!(of(["waypoints-1", "waypoints-a1"]), None);
}

#[test]
fn an_exit_on_a_closed_wall_is_a_door() {
    let exits = "0 LINE 8 exits-a 10 8 20 2 11 8 21 3 0 LINE 8 exits-b 10 7 20 2 11 7 21 3";
    let found = plan_of_dxf(&(rectangle("walkablearea", [0.0, 0.0, 8.0, 6.0]) + exits));
    assert_eq!(found.doors(), [(0, crate::Door::new(vec2(8.0, 2.5), 1.0))]);
    assert_eq!(found.inner_exits(), [1]);
}

#[test]
fn an_exit_inside_closed_walls_is_named() {
    let of = |outline: &str, x: f64| {
        let text = format!(
            "0 LWPOLYLINE 8 A 70 {outline} 10 0 20 0 10 8 20 0 10 8 20 6 10 0 20 6 \
             0 LWPOLYLINE 8 exits-a 70 1 10 {x} 20 2 10 {x} 20 4 10 7 20 4 10 7 20 2"
        );
        plan_of_dxf(&text).inner_exits()
    };
    // An area inside, one whose side lies on the wall, one that goes beyond it; and beside a wall that is open.
    assert_eq!((of("1", 6.0), of("1", 8.0), of("1", 8.5)), (vec![0], vec![0], vec![]));
    assert!(of("0", 6.0).is_empty());
}
