//! The drawings in `examples/plans`.

use super::*;

/// The areas of the examples are known: rectangles, circles.
#[test]
fn the_examples_have_their_areas() {
    let fine = Reading { deviation: 1e-5, unit: None };
    let hall = plan_of("hall.dxf", DrawingFormat::Dxf, fine, None);
    // The stage is half a circle of radius 2; six columns of radius 1/4; a kiosk of 3 by 0.6; a doorway of 2 by 0.5.
    let expected = 20.0 * 12.0 + 1.0 + 0.5 * PI * 4.0 - 6.0 * PI / 16.0 - 1.8;
    assert!((hall.area().unwrap() - expected).abs() < 1e-3, "{:?}", hall.area());
    assert_eq!((hall.walls.len(), hall.doubles, hall.outline), (8, 1, Some(0)));
    let names = |places: &[NamedPlace]| places.iter().map(|place| place.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&hall.exits), ["north", "south"]);
    assert_eq!((hall.exits[0].corners.len(), hall.exits[1].corners.len()), (4, 2));
    assert_eq!((hall.inner_exits(), hall.doors().len()), (vec![], 1));
    assert_eq!(
        left_out_of(&hall),
        [
            "1 MTEXT on layer \"0\"",
            "1 DIMENSION on layer \"A-ANNO-DIMS\"",
            "3 TEXT on layer \"A-ANNO-TEXT\"",
            "1 LINE (switched off or frozen) on layer \"A-ELEC\"",
            "1 HATCH on layer \"A-FLOR-PATT\"",
            "1 LINE (switched off or frozen) on layer \"G-FRAME\"",
            "1 INSERT of \"PLANT\", which is not in the file on layer \"Obstacles-Columns\"",
        ]
    );

    let millimetres = Reading { unit: Some(0.001), ..fine };
    let gaps = plan_of("office.dxf", DrawingFormat::Dxf, millimetres, None);
    assert_eq!((gaps.joined.left, gaps.doubles), (2, 2));
    let office = plan_of("office.dxf", DrawingFormat::Dxf, millimetres, Some(0.05));
    // Gaps of 30 mm and 20 mm at the ends of walls of 8 m and 6 m: corners move by half of them.
    assert_eq!((office.joined.gaps, office.joined.left), (2, 0));
    assert!((office.joined.largest - 0.03).abs() < 1e-9);
    assert!((office.area().unwrap() - 46.0).abs() < 8.0 * 0.015);
    assert_eq!((office.walls.len(), office.bounds().unwrap().low), (3, Vec2::zeros()));

    let centimetres = Reading { unit: Some(0.01), ..fine };
    let platform = plan_of("platform.svg", DrawingFormat::Svg, centimetres, None);
    let expected = 30.0 * 8.0 - 2.0 * PI * 0.25 - 2.0 * 2.0 * 0.5;
    assert!((platform.area().unwrap() - expected).abs() < 1e-3, "{:?}", platform.area());
    // y is upwards: on the page, people get on the train below.
    let train = &platform.distributions[0];
    assert!(near(train.corners[0], vec2(2.0, 3.0)), "{train:?}");
    assert!(platform.left_out.contains_key(&("waypoints-1".into(), "<g> (hidden)".into())));
}
