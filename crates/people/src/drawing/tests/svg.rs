//! Holes, fill and symbols of SVG.

use super::*;

#[test]
fn holes_of_paths_are_holes() {
    let square = |low: i32, high: i32, left: bool| {
        let side = high - low;
        if left {
            format!("M{low},{low} v{side} h{side} v-{side} z ")
        } else {
            format!("M{low},{low} h{side} v{side} h-{side} z ")
        }
    };
    let of = |role: &str, how: &str, path: &str| {
        let room = if role == "obstacles" { "<rect id='walkablearea' width='30' height='30'/>" } else { "" };
        let text =
            format!("<svg viewBox='0 0 30 30'>{room}<g {how}><path id='{role}' d='{path}'/></g></svg>");
        plan(DrawingFormat::Svg, &text).area().unwrap()
    };
    let [outer, same, other] = [square(0, 20, false), square(5, 10, false), square(5, 10, true)];
    let [inner, crossing] = [square(6, 8, false), square(8, 15, true)];
    for (how, path, expected) in [
        ("fill-rule='evenodd'", outer.clone() + &same, 375.0),
        ("style='fill: red; fill-rule: evenodd'", outer.clone() + &same, 375.0),
        ("style='fill-rule: evenodd !important'", outer.clone() + &same, 375.0),
        ("style='fill:none'", outer.clone() + &same, 375.0),
        ("", outer.clone() + &other, 375.0),
        ("fill-rule='nonzero'", outer.clone() + &same, 400.0),
        ("", other.clone() + &outer, 375.0),
        // An island in the hole; holes that overlap, of which even-odd fills what is in both.
        ("", outer.clone() + &other + &inner, 379.0),
        ("fill-rule='evenodd'", outer.clone() + &same + &inner, 379.0),
        ("fill-rule='evenodd'", outer.clone() + &same + &crossing, 400.0 - 25.0 - 49.0 + 8.0),
        // Filling closes what `z` does not.
        ("", outer.clone() + "M5,5 v5 h5 v-5", 375.0),
        ("", "M0,0 h20 v20 h-20 M5,5 v5 h5 v-5".into(), 375.0),
        ("", "M0,0 h20 v20 h-20".into(), 400.0),
        ("fill='none'", outer.clone() + "M5,5 v5 h5 v-5 h-5", 375.0),
    ] {
        let area = of("walkablearea", how, &path);
        assert!((area - expected).abs() < 1e-6, "{how} {path}: {area}");
        let area = of("obstacles", how, &path);
        assert!((area - (900.0 - expected)).abs() < 1e-6, "{how} {path}: {area}");
    }
}

#[test]
fn style_sheets_of_holes_and_names_in_other_letters_are_said_and_found() {
    let text = "<svg viewBox='0 0 9 9'><style>.a{fill-rule:evenodd}</style><path class='a' d='M0,0 h9 v9 h-9 z'/></svg>";
    let read = plan(DrawingFormat::Svg, text);
    assert!(
        read.left_out.keys().any(|(_, kind)| kind.starts_with("<style> with fill-rule")),
        "{:?}",
        read.left_out
    );
    let wall = "<svg viewBox='0 0 9 9'><g id='A-WALL'><path d='M0,0 h9 v9 h-9 z'/></g></svg>";
    let drawing = drawing(DrawingFormat::Svg, wall).unwrap();
    assert_eq!(drawing.layers(&["a-wall,other".to_owned()]), ["A-WALL", "other"]);
}

/// `fill` and `fill-rule` are each that of the nearest element that says it.
#[test]
fn fill_and_its_rule_are_inherited_apart() {
    let path = "d='M0,0 h20 v20 h-20 z M5,5 h5 v5 h-5 z'";
    for (group, own, expected) in [
        ("fill='none'", "", 375.0),
        ("fill='none'", "fill='red'", 400.0),
        ("fill='none'", "style='fill:red'", 400.0),
        ("fill='none'", "fill='inherit'", 375.0),
        ("fill='none'", "fill-rule='nonzero'", 375.0),
        ("fill='none' fill-rule='evenodd'", "fill='red'", 375.0),
        ("fill-rule='evenodd'", "fill='red'", 375.0),
        ("fill-rule='evenodd'", "fill='red' fill-rule='nonzero'", 400.0),
        ("fill='red'", "style='fill:red; fill:none'", 375.0),
    ] {
        let text =
            format!("<svg viewBox='0 0 30 30'><g {group}><path id='walkablearea' {own} {path}/></g></svg>");
        let area = plan(DrawingFormat::Svg, &text).area().unwrap();
        assert!((area - expected).abs() < 1e-6, "{group} {own}: {area}");
    }
}

/// An exit may be a line, also where nobody says that it is not filled.
#[test]
fn exits_are_not_closed_by_filling() {
    let text = "<svg viewBox='0 0 30 30'><rect id='walkablearea' width='30' height='30'/><path id='exits-a' d='M30,2 v1 v1'/></svg>";
    assert_eq!(plan(DrawingFormat::Svg, text).exits[0].corners, [vec2(30.0, 28.0), vec2(30.0, 26.0)]);
}

/// Rings in each other, every second one a hole; of all paths together only so many corners are looked at.
#[test]
fn corners_of_paths_of_several_parts_are_counted_together() {
    let ring = |k: u32| format!("M{k},{k} h{side} v{side} h-{side} z ", side = 2 * (1000 - k));
    let nested = |from: u32, count: u32| (from..from + count).map(ring).collect::<String>();
    let of = |paths: &[String]| {
        let path = |d: &String| format!("<path class='obstacles' fill-rule='evenodd' d='{d}'/>");
        let paths: String = paths.iter().map(path).collect();
        let text = format!(
            "<svg viewBox='0 0 2000 2000'><rect id='walkablearea' width='2000' height='2000'/>{paths}</svg>"
        );
        drawing(DrawingFormat::Svg, &text)
    };
    let lines = of(&[nested(1, 900)]).unwrap().lines;
    assert_eq!((lines.len(), lines.iter().filter(|line| line.hole).count()), (901, 450));
    // Each hole follows the rim around it.
    let size = |line: &DrawnLine| area(line).abs().sqrt().round() as i64;
    assert!(lines[1..].chunks(2).all(|pair| pair[1].hole && size(&pair[0]) - size(&pair[1]) == 2));
    // 2500 squares have 10 000 corners; paths of one part are not counted.
    let mut paths: Vec<String> = (0..5).map(|k| nested(100 * k, 500)).collect();
    paths.push(ring(1));
    assert!(of(&paths).is_ok());
    paths.push(nested(1, 2));
    let message = of(&paths).unwrap_err().to_string();
    assert_eq!(
        message,
        "line 1: <path>: paths of several parts have 10008 corners so far; at most 10000 are allowed"
    );
}

/// The rectangle of each, as the standard says.
#[test]
fn symbols_and_inner_pictures_have_coordinates_of_their_own() {
    for (kind, own, by, low, high) in [
        (
            "symbol",
            "viewBox='0 0 10 10'",
            "x='100' y='100' width='50' height='50'",
            [100.0, 100.0],
            [150.0, 150.0],
        ),
        (
            "symbol",
            "viewBox='0 0 10 10' width='50' height='50'",
            "x='100' y='100'",
            [100.0, 100.0],
            [150.0, 150.0],
        ),
        ("symbol", "viewBox='0 0 10 10'", "x='100' width='80' height='20'", [130.0, 0.0], [150.0, 20.0]),
        (
            "symbol",
            "viewBox='0 0 10 10' preserveAspectRatio='none'",
            "x='100' width='80' height='20'",
            [100.0, 0.0],
            [180.0, 20.0],
        ),
        (
            "symbol",
            "viewBox='0 0 10 10' preserveAspectRatio='xMaxYMin meet'",
            "width='20' height='80'",
            [0.0, 0.0],
            [20.0, 20.0],
        ),
        (
            "symbol",
            "viewBox='0 0 10 10' preserveAspectRatio='xMinYMax'",
            "width='20' height='80'",
            [0.0, 60.0],
            [20.0, 80.0],
        ),
        ("symbol", "viewBox='5 5 20 20'", "x='100' width='40' height='40'", [90.0, -10.0], [110.0, 10.0]),
        ("symbol", "viewBox='0 0 10 10'", "width='50%' height='25%'", [125.0, 0.0], [275.0, 150.0]),
        ("symbol", "viewBox='0 0 10 10'", "", [100.0, 0.0], [700.0, 600.0]),
        ("symbol", "", "x='7' width='50' height='50'", [7.0, 0.0], [17.0, 10.0]),
        (
            "svg",
            "x='3' width='20' height='20' viewBox='0 0 10 10'",
            "x='7' width='40' height='40'",
            [10.0, 0.0],
            [50.0, 40.0],
        ),
    ] {
        let text = format!(
            "<svg viewBox='0 0 800 600'><defs><{kind} id='s' {own}><rect width='10' height='10'/></{kind}></defs>\
             <use href='#s' {by}/></svg>"
        );
        let line = drawing(DrawingFormat::Svg, &text).unwrap().lines.remove(0);
        let bounds = Bounds::of(line.corners.iter().copied()).unwrap();
        // y is upwards.
        let expected = Bounds { low: vec2(low[0], 600.0 - high[1]), high: vec2(high[0], 600.0 - low[1]) };
        assert!(near(bounds.low, expected.low) && near(bounds.high, expected.high), "{own} {by}: {bounds:?}");
    }
    let text = "<svg viewBox='0 0 80 60'><svg x='10' y='10' width='20' height='20' viewBox='0 0 5 5'><rect width='5' height='5'/></svg></svg>";
    let line = drawing(DrawingFormat::Svg, text).unwrap().lines.remove(0);
    assert!(line.corners.iter().any(|at| near(*at, vec2(30.0, 30.0))), "{line:?}");
}
