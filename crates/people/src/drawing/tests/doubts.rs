//! Doubts about units, and outlines.

use super::*;

#[test]
fn units_and_places_that_no_room_has_are_doubted() {
    let of = |unit: &str, [x, y]: [f64; 2]| {
        let (right, top) = (x + 8.0, y + 6.0);
        let square = rectangle("walkablearea", [x, y, right, top]);
        let text = dxf_of(&format!("9 $INSUNITS 70 {unit}"), "", &square);
        let reading = Reading::default();
        let read = Read::of(DrawingFormat::Dxf, text.as_bytes(), &reading, &PlanSettings::default()).unwrap();
        let messages = read.messages("x");
        let find = |key: &str| messages.iter().find(|(what, _)| *what == key).map(|(_, how)| how.clone());
        (find("unit?"), find("far"), find("ground").unwrap())
    };
    assert_eq!(of("6", [0.0, 0.0]), (None, None, "48.000 m² within the outline, without obstacles".into()));
    let (unit, far, _) = of("1", [0.0, 0.0]);
    assert!(
        far.is_none()
            && unit.unwrap().starts_with(
                "no room is 0.203 m x 0.152 m; it is 8.00 x 6.00 units, which would be m: 8.00 m"
            )
    );
    let (unit, far, ground) = of("6", [500_000.0, 5_600_000.0]);
    assert_eq!(
        (unit, far.unwrap()),
        (None, "5600 km from the origin; people stand within 1000 km of it".into())
    );
    assert!(ground.starts_with("48.000 m²"));
    // A hall of 15 m x 12 m that is drawn in millimetres, and read in metres; a platform of 400 m is a room.
    let of = |x: f64, y: f64| {
        let read =
            read_as(DrawingFormat::Wkt, &format!("POLYGON ((0 0, {x} 0, {x} {y}, 0 {y}, 0 0))")).unwrap();
        read.messages("x").into_iter().find(|(what, _)| *what == "unit?").map(|(_, how)| how)
    };
    let hall = of(15_000.0, 12_000.0).unwrap();
    assert!(hall.contains("mm: 15.00 m x 12.00 m"), "{hall}");
    assert_eq!((of(400.0, 12.0), of(3001.0, 12.0).is_some()), (None, true));
}

/// The outside: by hand. A room of one line has a door of 0.9 m or of 1.8 m, and only its swings close the line. A room
/// with a round corner, and one with a bar that is a quarter of a circle, have none.
#[test]
fn a_wall_that_only_the_swing_of_a_door_closes_is_doubted() {
    let line =
        |a: (f64, f64), b: (f64, f64)| format!("0 LINE 8 W 10 {} 20 {} 11 {} 21 {} ", a.0, a.1, b.0, b.1);
    let arc = |x: f64, y: f64, radius: f64, from: u32, to: u32| {
        format!("0 ARC 8 W 10 {x} 20 {y} 40 {radius} 50 {from} 51 {to} ")
    };
    let chain =
        |corners: &[(f64, f64)]| corners.windows(2).map(|ends| line(ends[0], ends[1])).collect::<String>();
    let of = |entities: &str| {
        let text = dxf_of("", "", entities);
        let read = |settings: &PlanSettings| {
            Read::of(DrawingFormat::Dxf, text.as_bytes(), &METRES, settings).unwrap()
        };
        let drawing = drawing(DrawingFormat::Dxf, &text).unwrap();
        let doors = Proposal::of(&drawing, &[], None, None).unwrap().unwrap().doors();
        let at = |door: &crate::Door| ((1e3 * door.at).into(), 1e3 * door.width);
        let doors: Vec<([f64; 2], f64)> = doors.iter().map(at).collect();
        let chosen = PlanSettings { walls: vec!["w".to_owned()], ..PlanSettings::default() };
        assert_eq!(read(&chosen).doubt, read(&PlanSettings::default()).doubt);
        (read(&chosen).doubt, doors)
    };
    let swing = "is closed by the swing of a door only, 0.9 m wide at";
    let room =
        |right: f64| chain(&[(right, 0.0), (6.0, 0.0), (6.0, 4.0), (0.0, 4.0), (0.0, 0.0), (2.0, 0.0)]);
    let left = line((2.0, 0.0), (2.0, 0.9)) + &arc(2.0, 0.0, 0.9, 0, 90);
    let (doubt, doors) = of(&(room(2.9) + &left));
    assert!(doubt.as_ref().is_some_and(|message| message.contains(&format!("{swing} 2.45,0:"))), "{doubt:?}");
    assert_eq!(doors, [([2450.0, 0.0], 900.0)]);
    let right = line((3.8, 0.0), (3.8, 0.9)) + &arc(3.8, 0.0, 0.9, 90, 180);
    let (doubt, doors) = of(&(room(3.8) + &left + &right));
    assert!(doubt.as_ref().is_some_and(|message| message.contains(swing)), "{doubt:?}");
    assert_eq!(doors, [([2900.0, 0.0], 1800.0)]);
    let round =
        chain(&[(5.0, 0.0), (0.0, 0.0), (0.0, 4.0), (6.0, 4.0), (6.0, 1.0)]) + &arc(5.0, 1.0, 1.0, 270, 360);
    let bar = room(2.0) + &chain(&[(3.0, 3.0), (3.0, 2.0), (4.0, 2.0)]) + &arc(3.0, 2.0, 1.0, 0, 90);
    for entities in [round, bar] {
        assert_eq!(of(&entities).0, None);
    }
}
