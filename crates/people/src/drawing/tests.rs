//! Drawings against closed forms, against other readers, and against what is no drawing.

use super::*;
use lemons_core::plane::{Ring, nearest_on_segment, vec2};
use std::f64::consts::PI;

pub(super) const METRES: Reading = Reading { unit: Some(1.0), deviation: DEVIATION };

/// A DXF of entities: group codes and values, separated by spaces.
fn dxf_of(header: &str, blocks: &str, entities: &str) -> String {
    let section = |name: &str, pairs: &str| format!("0 SECTION 2 {name} {pairs} 0 ENDSEC ");
    let text =
        section("HEADER", header) + &section("BLOCKS", blocks) + &section("ENTITIES", entities) + "0 EOF";
    text.split_whitespace().collect::<Vec<_>>().join("\n")
}

fn lines_of(entities: &str) -> Vec<Line> {
    with_blocks("", entities)
}

fn with_blocks(blocks: &str, entities: &str) -> Vec<Line> {
    let text = dxf_of("", blocks, entities);
    Drawing::read(Format::Dxf, text.as_bytes(), &METRES).unwrap().lines
}

fn area(line: &Line) -> f64 {
    Ring::through(line.corners.clone()).unwrap().signed_area()
}

fn near(a: Vec2, b: Vec2) -> bool {
    (a - b).norm() < 1e-9
}

/// Checks that corners are on a curve, and that no place of the curve is further than the deviation from them.
fn check_curve(line: &Line, curve: impl Fn(f64) -> Vec2, deviation: f64) {
    let ends = line.corners.iter().skip(1).chain(line.closed.then(|| &line.corners[0]));
    let sides: Vec<(Vec2, Vec2)> = line.corners.iter().copied().zip(ends.copied()).collect();
    for k in 0..=2000 {
        let at = curve(f64::from(k) / 2000.0);
        let distance = sides
            .iter()
            .map(|(a, b)| (at - nearest_on_segment(*a, *b, at)).norm())
            .fold(f64::INFINITY, f64::min);
        assert!(distance <= deviation * (1.0 + 1e-9), "{distance} at {at:?}");
    }
}

#[test]
fn curves_deviate_by_no_more_than_was_asked_for() {
    let arc = |radius: f64, from: f64, to: f64| {
        move |t: f64| {
            let angle = (from + (to - from) * t).to_radians();
            vec2(1.0 + radius * angle.cos(), 2.0 + radius * angle.sin())
        }
    };
    for deviation in [0.1, 0.01, 1e-4] {
        let reading = Reading { deviation, ..METRES };
        let read = |entities: &str| {
            let text = dxf_of("", "", entities);
            Drawing::read(Format::Dxf, text.as_bytes(), &reading).unwrap().lines.remove(0)
        };
        let circle = read("0 CIRCLE 8 A 10 1 20 2 40 3");
        check_curve(&circle, arc(3.0, 0.0, 360.0), deviation);
        assert!(
            circle.closed && circle.corners.iter().all(|c| ((*c - vec2(1.0, 2.0)).norm() - 3.0).abs() < 1e-9)
        );
        // Not many more than are needed: a chord over d is 1 − cos(d/2) away.
        let needed = PI / (1.0 - deviation / 3.0).acos();
        assert!((circle.corners.len() as f64) < (needed + 1.0).max(9.0));
        let part = read("0 ARC 8 A 10 1 20 2 40 3 50 350 51 100");
        check_curve(&part, arc(3.0, 350.0, 460.0), deviation);
        assert!(!part.closed && near(part.corners[0], arc(3.0, -10.0, 0.0)(0.0)));
        let ellipse = read("0 ELLIPSE 8 A 10 1 20 2 11 3 21 4 40 0.4");
        let (u, v) = (vec2(3.0, 4.0), vec2(-1.6, 1.2));
        check_curve(
            &ellipse,
            |t| vec2(1.0, 2.0) + u * (2.0 * PI * t).cos() + v * (2.0 * PI * t).sin(),
            deviation,
        );
        // A parabola from (0, 0) over (2, 4) to (4, 0), in two spans: y = 2 x − x²/2.
        let parabola = read(
            "0 SPLINE 8 A 71 2 40 0 40 0 40 0 40 0.5 40 1 40 1 40 1 10 0 20 0 10 1 20 2 10 3 20 2 10 4 20 0",
        );
        check_curve(&parabola, |t| vec2(4.0 * t, 8.0 * t - 8.0 * t * t), deviation);
        // A quarter of a circle as a rational curve.
        let weight = 0.5f64.sqrt();
        let quarter = read(&format!(
            "0 SPLINE 8 A 70 4 71 2 40 0 40 0 40 0 40 1 40 1 40 1 10 5 20 0 10 5 20 5 10 0 20 5 41 1 41 {weight} 41 1"
        ));
        check_curve(&quarter, |t| vec2(5.0 * (0.5 * PI * t).cos(), 5.0 * (0.5 * PI * t).sin()), deviation);
        let svg = |path: &str| {
            let text = format!("<svg viewBox='0 0 9 9'><path d='{path}'/></svg>");
            Drawing::read(Format::Svg, text.as_bytes(), &reading).unwrap().lines.remove(0)
        };
        let cubic = |t: f64| {
            let s = 1.0 - t;
            vec2(0.0, 9.0) * (s * s * s)
                + vec2(0.0, 4.0) * (3.0 * s * s * t)
                + vec2(8.0, 9.0) * (3.0 * s * t * t)
                + vec2(9.0, 1.0) * (t * t * t)
        };
        check_curve(&svg("M0 0 c 0 5 8 0 9 8"), cubic, deviation);
        check_curve(
            &svg("M4 1 A 3 3 0 0 1 4 7"),
            |t| vec2(4.0 + 3.0 * (PI * t).sin(), 5.0 + 3.0 * (PI * t).cos()),
            deviation,
        );
    }
}

#[test]
fn bulges_are_arcs() {
    // A square of side 2 with a half circle outside, and one with a quarter circle inside.
    let half = lines_of("0 LWPOLYLINE 8 A 70 1 10 0 20 0 10 2 20 0 42 1 10 2 20 2 10 0 20 2").remove(0);
    assert!((area(&half) - (4.0 + 0.5 * PI)).abs() < 0.05 && area(&half) < 4.0 + 0.5 * PI);
    // tan(22.5°) is a quarter of a circle: radius √2, segment ½ r² (π/2 − 1).
    let quarter = lines_of(
        "0 POLYLINE 8 A 66 1 70 1 0 VERTEX 10 0 20 0 42 -0.41421356237309503 0 VERTEX 10 2 20 0 0 VERTEX 10 2 20 2 0 VERTEX 10 0 20 2 0 SEQEND",
    );
    assert!((area(&quarter[0]) - (4.0 - (0.5 * PI - 1.0))).abs() < 0.02);
    assert_eq!(quarter[0].corners[0], Vec2::zeros());
    assert!(quarter[0].corners.contains(&vec2(2.0, 0.0)), "ends of arcs are exact");
    // What is as good as straight is so.
    for bulge in ["1e-12", "-1e-300", "0.0099"] {
        let flat = lines_of(&format!("0 LWPOLYLINE 8 A 10 0 20 0 42 {bulge} 10 2 20 0")).remove(0);
        assert_eq!(flat.corners, [Vec2::zeros(), vec2(2.0, 0.0)]);
    }
}

#[test]
fn blocks_are_scaled_turned_moved_repeated_and_nested() {
    let block =
        |name: &str, base: &str, entities: &str| format!("0 BLOCK 2 {name} {base} {entities} 0 ENDBLK ");
    let line = block("L", "10 1 20 1", "0 LINE 8 0 10 1 20 1 11 3 21 1 0 LINE 8 B 10 1 20 1 11 1 21 2");
    let insert = "0 INSERT 8 WALLS 2 l 10 10 20 20 41 2 42 3 50 90";
    let lines = with_blocks(&line, insert);
    assert_eq!(lines.iter().map(|line| &*line.layer).collect::<Vec<_>>(), ["WALLS", "B"]);
    assert_eq!(lines[0].corners, [vec2(10.0, 20.0), vec2(10.0, 24.0)]);
    assert_eq!(lines[1].corners, [vec2(10.0, 20.0), vec2(7.0, 20.0)]);
    // Columns and rows go along the turned axes, and are not scaled.
    let many = with_blocks(&line, &format!("{insert} 70 2 71 3 44 5 45 7"));
    assert_eq!(many.len(), 12);
    assert!(many.iter().any(|line| near(line.corners[0], vec2(10.0 - 14.0, 25.0))));
    // Within each other, and mirrored: seen from below, x is −x.
    let outer = block("O", "10 0 20 0", "0 INSERT 8 0 2 L 10 1 20 0");
    let nested = with_blocks(&(line + &outer), "0 INSERT 8 W 2 O 10 2 20 0 230 -1");
    assert_eq!(nested[0].corners, [vec2(-3.0, 0.0), vec2(-5.0, 0.0)]);
    assert_eq!(nested[0].layer, "W");
    // A circle that is scaled to an ellipse.
    let circle = block("C", "", "0 CIRCLE 8 0 10 0 20 0 40 1");
    let ellipse = with_blocks(&circle, "0 INSERT 8 W 2 C 10 0 20 0 41 4 42 0.5").remove(0);
    check_curve(&ellipse, |t| vec2(4.0 * (2.0 * PI * t).cos(), 0.5 * (2.0 * PI * t).sin()), DEVIATION);
}

#[test]
fn units_are_those_of_the_file_or_of_the_user() {
    let read = |header: &str, unit| {
        let text = dxf_of(header, "", "0 LINE 8 A 10 0 20 0 11 2000 21 0");
        let drawing = Drawing::read(Format::Dxf, text.as_bytes(), &Reading { unit, deviation: DEVIATION });
        drawing.map(|drawing| (drawing.lines[0].corners[1].x, drawing.unit_from))
    };
    assert_eq!(read("9 $INSUNITS 70 4", None).unwrap(), (2.0, UnitFrom::File));
    assert_eq!(read("9 $INSUNITS 70 4", Some(0.01)).unwrap(), (20.0, UnitFrom::User));
    assert!((read("9 $INSUNITS 70 2", None).unwrap().0 - 609.6).abs() < 1e-9);
    for header in ["", "9 $INSUNITS 70 0", "9 $ACADVER 1 AC1009"] {
        assert!(matches!(
            read(header, None),
            Err(PeopleError::NoUnit { size: Some([2000.0, 0.0]), scale: false })
        ));
    }
    assert!(
        read("9 $INSUNITS 70 12", None)
            .unwrap_err()
            .to_string()
            .starts_with("$INSUNITS = 12: must be 1 (in)")
    );
}

#[test]
fn the_user_overrides_a_unit_that_is_not_known() {
    let read = |unit: Option<f64>, code: &str, x: &str| {
        let header = format!("9 $INSUNITS 70 {code}");
        let text = dxf_of(&header, "", &format!("0 LINE 8 A 10 0 20 0 11 {x} 21 0"));
        Drawing::read(Format::Dxf, text.as_bytes(), &Reading { unit, ..METRES })
    };
    for code in ["99", "x"] {
        assert!(read(None, code, "1").unwrap_err().to_string().contains("$INSUNITS"));
        assert_eq!(read(Some(0.001), code, "1").unwrap().unit_from, UnitFrom::User);
    }
    // What is far is known only with a unit.
    assert!(matches!(read(None, "0", "2e9").unwrap_err(), PeopleError::NoUnit { .. }));
    assert!(read(Some(0.001), "0", "2e9").is_ok() && read(Some(1.0), "0", "2e9").is_err());
}

#[test]
fn what_is_wrong_is_said_with_line_entity_layer_and_value() {
    let said = |entities: &str| {
        let text = dxf_of("", "", entities);
        Drawing::read(Format::Dxf, text.as_bytes(), &METRES).unwrap_err().to_string()
    };
    for (entities, expected) in [
        (
            "0 LINE 8 A 10 x 20 0",
            "line 22: LINE on layer \"A\": group code 10 = \"x\": must be a finite number",
        ),
        (
            "0 LINE 8 A 10 1e999 20 0",
            "line 22: LINE on layer \"A\": group code 10 = \"1e999\": must be a finite number",
        ),
        ("0 LINE 8 A 10 0 20 0", "line 18: LINE on layer \"A\": has no group code 11"),
        (
            "0 SPLINE 8 A 71 3 10 0 20 0",
            "line 18: SPLINE on layer \"A\": 1 control points are too few for degree 3",
        ),
        ("0 CIRCLE 8 A 10 0 20 0 40 1e300", "line 18: CIRCLE on layer \"A\": a curve is too large"),
        ("0 CIRCLE 8 A 10 0 20 0 40 1e20", "line 18: CIRCLE on layer \"A\": a curve of size 1"),
        (
            "0 LINE 8 A 10 0 20 0 11 2e9 21 0",
            "LINE in line 18 on layer \"A\": a corner at (2000000000.0, 0.0) m is not within",
        ),
        ("0 LINE x A", "line 19: \"x\": must be a group code"),
        (
            "0 TEXT 8 A 1 hello 0 HATCH 8 B",
            "there are no lines in this DXF: 1 TEXT on layer \"A\", 1 HATCH on layer \"B\"",
        ),
    ] {
        let said = said(entities);
        assert!(said.starts_with(expected), "{entities}: {said}");
    }
    let read = |format, text: &str| Drawing::read(format, text.as_bytes(), &METRES).unwrap_err().to_string();
    for (format, text, expected) in [
        (Format::Dxf, "AutoCAD Binary DXF\r\n", "is a binary DXF"),
        (Format::Dxf, "AC1032\0\0", "is a DWG"),
        (
            Format::GeoJson,
            "{\"type\": \"Polygon\", \"coordinates\": [[[0, 0], [1, 0], [1, \"a\"], [0, 0]]]}",
            "coordinates[0][2] = [1,\"a\"]: must be numbers",
        ),
        (
            Format::GeoJson,
            "{\"type\": \"Polygon\", \"coordinates\": [[[0, 0], [1, 0], [1, 1]]]}",
            "coordinates[0]: the ring is not closed",
        ),
        (Format::GeoJson, "{\"type\": \"Circle\"}", "coordinates: type = \"Circle\": must be one of"),
        (Format::GeoJson, "{", "EOF while parsing an object at line 1 column 1"),
        (
            Format::GeoJson,
            "{\"crs\": {\"properties\": {\"name\": \"urn:ogc:def:crs:OGC:1.3:CRS84\"}}}",
            "crs: ",
        ),
        (Format::Wkt, "POLYGON ((0 0, 1 0, 1 1))", "the ring that ends at 1 1 is not closed"),
        (Format::Wkt, "CIRCLE (0 0)", "\"CIRCLE (0 0)\" is not a POLYGON or another geometry"),
        (
            Format::Svg,
            "<svg>\n<path d='M 0 0 L 1 x'/></svg>",
            "line 2: <path> d=\"M 0 0 L 1 x\": is not a path",
        ),
        (
            Format::Svg,
            "<svg><line x1='50%'/></svg>",
            "line 1: <line> x1=\"50%\": must be a number, or a length",
        ),
        (Format::Svg, "<svg><text>a</text></svg>", "there are no lines in this SVG: 1 <text>"),
    ] {
        let said = read(format, text);
        assert!(said.starts_with(expected), "{text}: {said}");
    }
}

#[test]
fn large_entities_that_are_repeated_are_refused() {
    let refused = |format: Format, text: &str| {
        let error = Drawing::read(format, text.as_bytes(), &METRES).unwrap_err().to_string();
        assert!(error.contains("have more than 100000000 parts"), "{error}");
    };
    // A text of 20 000 pairs in a block, 10 000 times.
    let block = format!("0 BLOCK 2 B 0 TEXT 8 A {} 0 ENDBLK", "1 x ".repeat(20_000));
    refused(Format::Dxf, &dxf_of("", &block, "0 INSERT 8 A 2 B 10 0 20 0 70 100 71 100"));
    let style = format!("<path id='p' style='{}' d='M0 0 H1'/>", " ".repeat(100_000));
    let uses = "<use href='#p'/>".repeat(1001);
    refused(Format::Svg, &format!("<svg viewBox='0 0 9 9'>{style}{uses}</svg>"));
}

#[test]
fn long_names_are_refused() {
    let refused = |format: Format, text: &str| {
        let error = Drawing::read(format, text.as_bytes(), &METRES).unwrap_err().to_string();
        assert!(error.contains("has more than 255 characters"), "{error}");
    };
    let (long, fits) = ("ä".repeat(256), "ä".repeat(255));
    refused(Format::Dxf, &dxf_of("", "", &format!("0 LINE 8 {long} 10 0 20 0 11 1 21 0")));
    refused(Format::Dxf, &dxf_of("", "", &format!("0 INSERT 8 A 2 {long} 10 0 20 0")));
    assert_eq!(lines_of(&format!("0 LINE 8 {fits} 10 0 20 0 11 1 21 0"))[0].layer, fits);
    for key in ["layer", "name"] {
        let geometry = r#"{"type": "LineString", "coordinates": [[0, 0], [1, 0]]}"#;
        let text =
            format!(r#"{{"type": "Feature", "geometry": {geometry}, "properties": {{"{key}": "{long}"}}}}"#);
        refused(Format::GeoJson, &text);
    }
    for inner in
        [format!("<g id='{long}'><path d='M0 0 H1'/></g>"), format!("<path id='{long}' d='M0 0 H1'/>")]
    {
        refused(Format::Svg, &format!("<svg viewBox='0 0 9 9'>{inner}</svg>"));
    }
}

#[test]
fn blocks_that_grow_without_end_are_refused() {
    let read = |blocks: &str, entities: &str| {
        let text = dxf_of("", blocks, entities);
        Drawing::read(Format::Dxf, text.as_bytes(), &METRES).unwrap_err().to_string()
    };
    let itself = read("0 BLOCK 2 A 0 INSERT 8 0 2 A 10 0 20 0 0 ENDBLK", "0 INSERT 8 0 2 A 10 0 20 0");
    assert!(
        itself.contains("more than 16 blocks are within each other; does \"A\" contain itself?"),
        "{itself}"
    );
    let mut blocks = String::from("0 BLOCK 2 B0 0 ENDBLK ");
    for k in 1..16 {
        blocks += &format!("0 BLOCK 2 B{k} 0 INSERT 8 0 2 B{} 10 0 20 0 70 9 71 9 0 ENDBLK ", k - 1);
    }
    let bomb = read(&blocks, "0 INSERT 8 0 2 B15 10 0 20 0");
    assert!(bomb.contains("more than 1000000 entities"), "{bomb}");
    let array = read(
        "0 BLOCK 2 B 0 ENDBLK",
        "0 INSERT 8 0 2 B 10 0 20 0 70 9223372036854775807 71 9223372036854775807",
    );
    assert!(array.contains("more than 1000000 entities"), "{array}");
    let uses: String = (1..60)
        .map(|k| format!("<g id='g{k}'><use href='#g{}'/><use href='#g{}'/></g>", k - 1, k - 1))
        .collect();
    let svg =
        Drawing::read(Format::Svg, format!("<svg>{uses}</svg>").as_bytes(), &METRES).unwrap_err().to_string();
    assert!(svg.contains("more than"), "{svg}");
}

/// Numbers that repeat.
fn next(state: &mut u64) -> usize {
    *state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
    (*state >> 33) as usize
}

fn example(name: &str) -> Vec<u8> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/plans").join(name);
    std::fs::read(path).unwrap()
}

/// Cuts, doubles and changes lines and bytes: an error or a drawing, never a panic.
#[test]
fn damaged_files_do_no_harm() {
    let geojson = b"{\"type\": \"FeatureCollection\", \"features\": [{\"type\": \"Feature\", \"properties\": {\"layer\": \"exits\"},\
        \"geometry\": {\"type\": \"MultiPolygon\", \"coordinates\": [[[[0, 0], [4, 0], [4, 3], [0, 0]]]]}}]}";
    let wkt = b"GEOMETRYCOLLECTION (POLYGON ((0 0, 4 0, 4 3, 0 0), (1 1, 2 1, 2 2, 1 1)), MULTIPOINT ((1 2), (3 4)), LINESTRING Z (0 0 1, 1 1 1))";
    let all = [
        (Format::Dxf, example("hall.dxf")),
        (Format::Dxf, example("office.dxf")),
        (Format::Svg, example("platform.svg")),
        (Format::GeoJson, geojson.to_vec()),
        (Format::Wkt, wkt.to_vec()),
    ];
    let mut state = 7;
    let words = [
        "-1",
        "1e300",
        "nan",
        "0",
        "99999999999999999999",
        "inf",
        "(",
        "]",
        "}",
        "<",
        "é",
        "10",
        "70",
        "-0.0",
        "1e-300",
    ];
    let mut read = 0;
    for (format, bytes) in all {
        for _ in 0..400 {
            let mut damaged = bytes.clone();
            for _ in 0..=next(&mut state) % 2 {
                let at = next(&mut state) % damaged.len();
                let end = (at + next(&mut state) % 30).min(damaged.len());
                match next(&mut state) % 5 {
                    0 => damaged[at] = next(&mut state) as u8,
                    1 => damaged.truncate(at.max(1)),
                    2 => drop(damaged.drain(at..end.min(damaged.len() - 1).max(at))),
                    3 => {
                        let word = words[next(&mut state) % words.len()].bytes();
                        drop(damaged.splice(at..end, word));
                        damaged.push(b'\n');
                    }
                    _ => {
                        let part = damaged[at..end].to_vec();
                        let to = next(&mut state) % damaged.len();
                        drop(damaged.splice(to..to, part));
                    }
                }
            }
            if let Ok(drawing) = Drawing::read(format, &damaged, &METRES) {
                read += 1;
                let settings = PlanSettings { close: Some(0.05), to_origin: true, ..PlanSettings::default() };
                if let Ok(plan) = Plan::of(drawing, &settings) {
                    let _ = (plan.area(), plan.doors(), plan.way());
                    let _ = written_formats().map(|format| write_plan(&plan, format));
                }
            }
        }
    }
    assert!(read > 100, "{read} were read: most damage is too great to test much");
}

fn plan_of(name: &str, format: Format, reading: Reading, close: Option<f64>) -> Plan {
    let drawing = Drawing::read(format, &example(name), &reading).unwrap();
    Plan::of(drawing, &PlanSettings { close, to_origin: true, ..PlanSettings::default() }).unwrap()
}

/// The areas of the examples are known: rectangles, circles.
#[test]
fn the_examples_have_their_areas() {
    let fine = Reading { deviation: 1e-5, unit: None };
    let hall = plan_of("hall.dxf", Format::Dxf, fine, None);
    // The stage is half a circle of radius 2; six columns of radius 1/4; a kiosk of 3 by 0.6; a doorway of 2 by 0.5.
    let expected = 20.0 * 12.0 + 1.0 + 0.5 * PI * 4.0 - 6.0 * PI / 16.0 - 1.8;
    assert!((hall.area().unwrap() - expected).abs() < 1e-3, "{:?}", hall.area());
    assert_eq!((hall.walls.len(), hall.doubles, hall.outline), (8, 1, Some(0)));
    let names = |places: &[Place]| places.iter().map(|place| place.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&hall.exits), ["north", "south"]);
    assert_eq!((hall.exits[0].corners.len(), hall.exits[1].corners.len()), (4, 2));
    assert_eq!((hall.inner_exits(), hall.doors().len()), (vec![], 1));
    let left_out: Vec<String> = hall.left_out.iter().map(left_out).collect();
    assert_eq!(
        left_out,
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
    let gaps = plan_of("office.dxf", Format::Dxf, millimetres, None);
    assert_eq!((gaps.joined.left, gaps.doubles), (2, 2));
    let office = plan_of("office.dxf", Format::Dxf, millimetres, Some(0.05));
    // Gaps of 30 mm and 20 mm at the ends of walls of 8 m and 6 m: corners move by half of them.
    assert_eq!((office.joined.gaps, office.joined.left), (2, 0));
    assert!((office.joined.largest - 0.03).abs() < 1e-9);
    assert!((office.area().unwrap() - 46.0).abs() < 8.0 * 0.015);
    assert_eq!((office.walls.len(), office.bounds().unwrap().low), (3, Vec2::zeros()));

    let centimetres = Reading { unit: Some(0.01), ..fine };
    let platform = plan_of("platform.svg", Format::Svg, centimetres, None);
    let expected = 30.0 * 8.0 - 2.0 * PI * 0.25 - 2.0 * 2.0 * 0.5;
    assert!((platform.area().unwrap() - expected).abs() < 1e-3, "{:?}", platform.area());
    // y is upwards: on the page, people get on the train below.
    let train = &platform.distributions[0];
    assert!(near(train.corners[0], vec2(2.0, 3.0)), "{train:?}");
    assert!(platform.left_out.contains_key(&("waypoints-1".into(), "<g> (hidden)".into())));
}

#[test]
fn layers_say_what_lines_are() {
    for (layer, expected) in [
        ("walkablearea-0", Some((Role::WalkableArea, "0"))),
        ("WalkableArea", Some((Role::WalkableArea, ""))),
        ("walkable_area_hall", Some((Role::WalkableArea, "hall"))),
        ("JuPedSim_walkable_area", Some((Role::WalkableArea, ""))),
        ("jps-walkablearea-0", Some((Role::WalkableArea, "0"))),
        ("JPS-Obstacles", Some((Role::Obstacle, ""))),
        ("jps-exits-north", Some((Role::Exit, "north"))),
        ("jps-distributions_2", Some((Role::Distribution, "2"))),
        ("jps_waypoints3", Some((Role::Waypoint, "3"))),
        ("jps-journeys-0", Some((Role::Unused, "0"))),
        ("journeys", Some((Role::Unused, ""))),
        ("jps-parameters", Some((Role::Unused, "parameters"))),
        ("plan$0$walkablearea-0", Some((Role::WalkableArea, "0"))),
        ("plan$12$jps-exits-a", Some((Role::Exit, "a"))),
        ("A$0$B$0$obstacles", Some((Role::Obstacle, ""))),
        ("plan|exits-0", Some((Role::Exit, "0"))),
        ("plan|A-WALL", None),
        ("Level 1::obstacles-b", Some((Role::Obstacle, "b"))),
        ("0 - distributions-0", Some((Role::Distribution, "0"))),
        ("wall beside ramp - exit 2", None),
        ("Level 1 - exits-0", None),
        ("walkablearea - 0|1", Some((Role::WalkableArea, "0|1"))),
        ("plan$0$exit-signs", None),
        ("jupedsim", None),
        ("OBSTACLES-Columns", Some((Role::Obstacle, "Columns"))),
        ("obstacle", Some((Role::Obstacle, ""))),
        ("exit 2", Some((Role::Exit, "2"))),
        ("exits-", Some((Role::Exit, ""))),
        ("exit-signs", None),
        ("exitsigns", None),
        ("waypoints3", Some((Role::Waypoint, "3"))),
        ("A-WALL", None),
        ("", None),
    ] {
        assert_eq!(Role::of(layer), expected.map(|(role, name)| (role, name.to_owned())), "{layer}");
    }
}

fn plan(format: Format, text: &str) -> Plan {
    let drawing = Drawing::read(format, text.as_bytes(), &METRES).unwrap();
    Plan::of(drawing, &PlanSettings::default()).unwrap()
}

#[test]
fn areas_that_meet_are_united_and_obstacles_cut() {
    let square = |layer: &str, [x0, y0, x1, y1]: [f64; 4]| {
        format!(
            "0 LWPOLYLINE 8 {layer} 70 1 10 {x0} 20 {y0} 10 {x1} 20 {y0} 10 {x1} 20 {y1} 10 {x0} 20 {y1} "
        )
    };
    let of = |squares: &[(&str, [f64; 4])]| {
        let entities: String = squares.iter().map(|(layer, sides)| square(layer, *sides)).collect();
        plan(Format::Dxf, &dxf_of("", "", &entities))
    };
    // Two rooms of 4 by 3 that share a square metre, and a pillar half in the wall.
    let united = of(&[
        ("walkablearea-a", [0.0, 0.0, 4.0, 3.0]),
        ("walkablearea-b", [3.0, 2.0, 7.0, 5.0]),
        ("obstacles", [-1.0, 1.0, 1.0, 2.0]),
    ]);
    assert!((united.area().unwrap() - (12.0 + 12.0 - 1.0 - 1.0)).abs() < 1e-6);
    assert!(united.ground.is_some() && united.walls.len() == 1);
    // Where nothing meets, walls are as drawn.
    let apart = of(&[
        ("walkablearea", [0.0, 0.0, 4.0, 3.0]),
        ("obstacles", [1.0, 1.0, 2.0, 2.0]),
        ("furniture", [0.5, 0.5, 0.7, 0.7]),
    ]);
    assert!(apart.ground.is_none() && apart.walls.len() == 2 && apart.area() == Some(11.0));
    assert_eq!(apart.left_out.len(), 1);
    // Without such layers, all lines are walls, also outside.
    let plain =
        of(&[("a", [1.0, 1.0, 2.0, 2.0]), ("b", [0.0, 0.0, 4.0, 3.0]), ("c", [9.0, 9.0, 10.0, 10.0])]);
    assert_eq!((plain.walls.len(), plain.outline, plain.area()), (3, Some(1), Some(11.0)));
}

#[test]
fn an_area_between_others_is_no_double() {
    // A grid of 3 x 3 squares, the middle one last: all its sides are on those of others.
    let places = [(0, 0), (1, 0), (2, 0), (0, 1), (2, 1), (0, 2), (1, 2), (2, 2), (1, 1)];
    let square = |(x, y): (i32, i32)| {
        let (right, top) = (x + 1, y + 1);
        format!("10 {x} 20 {y} 10 {right} 20 {y} 10 {right} 20 {top} 10 {x} 20 {top}")
    };
    let closed: String =
        places.iter().map(|at| format!("0 LWPOLYLINE 8 walkablearea 70 1 {} ", square(*at))).collect();
    // The same, open, with the first corner repeated.
    let open: String = places
        .iter()
        .map(|at| format!("0 LWPOLYLINE 8 walkablearea {} 10 {} 20 {} ", square(*at), at.0, at.1))
        .collect();
    for entities in [closed, open] {
        let plan = plan(Format::Dxf, &dxf_of("9 $INSUNITS 70 6", "", &entities));
        assert_eq!((plan.walls.len(), plan.doubles), (1, 0));
        assert!((plan.area().unwrap() - 9.0).abs() < 1e-6);
    }
}

#[test]
fn lines_that_meet_are_one_wall_where_no_third_one_ends() {
    let lines = |all: &[[f64; 4]]| {
        let line = |[a, b, c, d]: &[f64; 4]| format!("0 LINE 8 A 10 {a} 20 {b} 11 {c} 21 {d} ");
        plan(Format::Dxf, &dxf_of("", "", &all.iter().map(line).collect::<String>()))
    };
    let square = [[0.0, 0.0, 1.0, 0.0], [1.0, 1.0, 1.0, 0.0], [1.0, 1.0, 0.0, 1.0], [0.0, 0.0, 0.0, 1.0]];
    let closed = lines(&square);
    assert_eq!((closed.walls.len(), closed.area()), (1, Some(1.0)));
    // A third wall begins at a corner: the others go round, and it is a wall of its own.
    let third = lines(&[&square[..], &[[0.0, 0.0, -1.0, -1.0]]].concat());
    assert_eq!((third.walls.len(), third.outline), (2, Some(0)));
    let open = lines(&[[0.0, 0.0, 1.0, 0.0], [1.0, 0.0, 2.0, 1.0]]);
    assert_eq!(open.walls, [[vec2(0.0, 0.0), vec2(1.0, 0.0), vec2(2.0, 1.0)]]);
    // A part of a longer wall is there once.
    let double = lines(&[&square[..], &[[1.0, 0.0, 0.0, 0.0]]].concat());
    assert_eq!((double.walls.len(), double.doubles), (1, 1));
}

/// Sides of walls, to a micrometre.
fn sides(walls: &[Vec<Vec2>]) -> Vec<[i64; 4]> {
    let whole = |x: f64| (x * 1e6).round() as i64;
    let side = |pair: &[Vec2]| {
        let mut ends = [[whole(pair[0].x), whole(pair[0].y)], [whole(pair[1].x), whole(pair[1].y)]];
        ends.sort_unstable();
        [ends[0][0], ends[0][1], ends[1][0], ends[1][1]]
    };
    let mut all: Vec<[i64; 4]> = walls.iter().flat_map(|wall| wall.windows(2).map(side)).collect();
    all.sort_unstable();
    all
}

#[test]
fn what_is_written_is_read_back() {
    let hall = plan_of("hall.dxf", Format::Dxf, Reading::default(), None);
    for format in written_formats() {
        let text = write_plan(&hall, format).unwrap();
        let drawing = Drawing::read(format, text.as_bytes(), &Reading::default()).unwrap();
        let again = Plan::of(drawing, &PlanSettings::default()).unwrap();
        assert_eq!(sides(&again.walls), sides(&hall.walls), "{format:?}");
        if format != Format::Wkt {
            assert_eq!(
                (&again.exits, &again.distributions),
                (&hall.exits, &hall.distributions),
                "{format:?}"
            );
        }
    }
    assert_eq!(write_plan(&hall, Format::Svg), None);
    // Names are of other programs, too.
    let mut named = hall.clone();
    named.exits[0].name = "Süd\n  0\nEOF".into();
    let text = write_plan(&named, Format::Dxf).unwrap();
    let again = Drawing::read(Format::Dxf, text.as_bytes(), &Reading::default()).unwrap();
    assert_eq!(Plan::of(again, &PlanSettings::default()).unwrap().exits[0].name, "Süd_  0_EOF");
}

/// Walls of closed rooms that meet are there as often as before, and so is the ground of the largest.
#[test]
fn rooms_that_meet_are_read_back_from_well_known_text() {
    let rectangle = |[x0, y0, x1, y1]: [f64; 4]| {
        [[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]].map(Vec2::from).to_vec()
    };
    let room = [0.0, 0.0, 10.0, 5.0];
    // Walls, how many polygons and lines are written, and the ground.
    for (rectangles, written, area) in [
        // Two rooms with one wall between them, that share a corner, that are a hair apart.
        (&[room, [10.0, 0.0, 20.0, 5.0]][..], [0, 2], 50.0),
        (&[room, [10.0, 5.0, 20.0, 9.0]], [0, 2], 50.0),
        (&[room, [10.012, 1.0, 20.0, 4.0]], [0, 2], 50.0),
        // A cupboard in the corner, one nearly at a wall, one that goes through it.
        (&[room, [9.0, 4.0, 10.0, 5.0]], [0, 2], 49.0),
        (&[room, [4.0, 0.01, 5.0, 1.0]], [0, 2], 50.0 - 0.99),
        (&[room, [4.0, -0.5, 5.0, 0.5]], [0, 2], 49.5),
        // With a column, which is not ground, either; and a room that is apart from both.
        (&[room, [9.0, 4.0, 10.0, 5.0], [2.0, 2.0, 3.0, 3.0], [12.0, 0.0, 15.0, 4.0]], [1, 3], 48.0),
        // Tables at each other in a room; a column in it, and an island in that.
        (&[room, [2.0, 2.0, 3.0, 3.0], [3.0, 2.0, 4.0, 3.0]], [1, 2], 48.0),
        (&[room, [2.0, 2.0, 4.0, 4.0], [2.5, 2.5, 3.5, 3.5]], [2, 0], 47.0),
        // Apart: one polygon with a hole.
        (&[room, [9.0, 3.9, 9.9, 4.9]], [1, 0], 50.0 - 0.9),
    ] {
        let walls = rectangles.iter().map(|sides| rectangle(*sides)).collect::<Vec<_>>();
        let mut geometry = lemons_core::trial::Geometry { dimensions: None, walls: Vec::new() };
        for (id, wall) in walls.iter().enumerate() {
            geometry.walls.push(lemons_core::trial::Wall::new(id.to_string(), "wood", wall.clone()));
        }
        let text = write_plan(&Plan::of_geometry(&geometry, Vec::new()), Format::Wkt).unwrap();
        let kinds = ["POLYGON", "LINESTRING"].map(|kind| text.matches(kind).count());
        assert_eq!(kinds, written, "{rectangles:?}: {text}");
        let again = plan(Format::Wkt, &text);
        assert_eq!(sides(&again.walls), sides(&walls), "{rectangles:?}: {text}");
        let found = again.area();
        assert!(
            found.is_some_and(|found| (found - area).abs() < 1e-6),
            "{rectangles:?}: {found:?}, not {area}"
        );
    }
    // A wall that touches itself is a line, too: a polygon would be mended, or refused.
    let wall = [[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0], [0.0, 0.0]].map(Vec2::from).to_vec();
    let wall = lemons_core::trial::Wall::new("0", "wood", wall);
    let geometry = lemons_core::trial::Geometry { dimensions: None, walls: vec![wall] };
    let text = write_plan(&Plan::of_geometry(&geometry, Vec::new()), Format::Wkt).unwrap();
    assert_eq!(text, "LINESTRING (0 0, 2 2, 2 0, 0 2, 0 0)\n");
}

/// The crates wkt and geojson read the same.
#[test]
fn other_readers_agree() {
    let hall = plan_of("hall.dxf", Format::Dxf, Reading::default(), None);
    let text = write_plan(&hall, Format::GeoJson).unwrap();
    let ::geojson::GeoJson::FeatureCollection(all) = text.parse().unwrap() else { panic!("no collection") };
    let polygons = all.features.iter().filter(|feature| feature.property("layer").unwrap() == "walls");
    let corners: Vec<usize> = polygons
        .map(|feature| match &feature.geometry.as_ref().unwrap().value {
            ::geojson::GeometryValue::Polygon { coordinates } => coordinates[0].len(),
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(corners, hall.walls.iter().map(Vec::len).collect::<Vec<_>>());
    let text = write_plan(&hall, Format::Wkt).unwrap();
    // The outline is the first wall, the others are in it.
    let ::wkt::Wkt::Polygon(polygon) = text.trim().parse::<::wkt::Wkt<f64>>().unwrap() else {
        panic!("no polygon")
    };
    assert_eq!(polygon.rings().len(), hall.walls.len());
    for (ring, wall) in polygon.rings().iter().zip(&hall.walls) {
        let corners: Vec<Vec2> = ring.coords().iter().map(|c| vec2(c.x, c.y)).collect();
        assert_eq!(corners, *wall);
    }
}

#[test]
fn the_middle_of_an_area_is_inside() {
    let middle = |corners: &[(f64, f64)]| {
        let corners = corners.iter().map(|(x, y)| vec2(*x, *y)).collect();
        Place { name: String::new(), corners }.middle()
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
        let plan = plan(Format::Dxf, &dxf_of("", "", &entities));
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
    let text = dxf_of(
        "",
        "",
        "0 LWPOLYLINE 8 walkablearea 70 1 10 0 20 0 10 8 20 0 10 8 20 6 10 0 20 6 \
         0 LINE 8 exits-a 10 8 20 2 11 8 21 3 0 LINE 8 exits-b 10 7 20 2 11 7 21 3",
    );
    let found = plan(Format::Dxf, &text);
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
        plan(Format::Dxf, &dxf_of("", "", &text)).inner_exits()
    };
    // An area inside, one whose side lies on the wall, one that goes beyond it; and beside a wall that is open.
    assert_eq!((of("1", 6.0), of("1", 8.0), of("1", 8.5)), (vec![0], vec![0], vec![]));
    assert!(of("0", 6.0).is_empty());
}

fn read_as(format: Format, text: &str) -> crate::error::Result<Read> {
    Read::of(format, text.as_bytes(), &METRES, &PlanSettings::default())
}

/// Exits, journeys and obstacles of JuPedSim's converter, with the signs that others put before names: no walls.
#[test]
fn layers_of_jupedsim_and_of_bound_references_are_no_walls() {
    let area = |layer: &str, [x0, y0, x1, y1]: [f64; 4]| {
        format!(
            "0 LWPOLYLINE 8 {layer} 70 1 10 {x0} 20 {y0} 10 {x1} 20 {y0} 10 {x1} 20 {y1} 10 {x0} 20 {y1} "
        )
    };
    for [before, after] in
        [["jps-", "-0"], ["jps-", ""], ["", ""], ["plan$0$", "-7"], ["plan|", "-0"], ["X$0$jps-", ""]]
    {
        let layer = |name: &str| format!("{before}{name}{after}");
        let entities = area(&layer("walkablearea"), [0.0, 0.0, 8.0, 6.0])
            + &area(&layer("obstacles"), [4.0, 2.5, 5.0, 3.5])
            + &area(&layer("distributions"), [0.5, 0.5, 3.0, 5.5])
            + &area(&layer("exits"), [7.2, 2.0, 7.8, 4.0])
            + &format!("0 CIRCLE 8 {} 10 2 20 2 40 0.5 ", layer("waypoints"))
            + &format!("0 LINE 8 {} 10 1 20 3 11 7 21 3", layer("journeys"));
        let found = plan(Format::Dxf, &dxf_of("", "", &entities));
        let places = (found.exits.len(), found.distributions.len(), found.waypoints.len());
        assert_eq!((found.walls.len(), found.area(), places), (2, Some(47.0), (1, 1, 1)), "{before} {after}");
        let left_out: Vec<String> = found.left_out.iter().map(left_out).collect();
        assert_eq!(left_out, [format!("1 LINE (of JuPedSim, not used) on layer {:?}", layer("journeys"))]);
    }
    // Journeys are none without areas, too.
    let text = area("A", [0.0, 0.0, 8.0, 6.0]) + "0 LINE 8 jps-journeys 10 1 20 3 11 7 21 3";
    assert_eq!(plan(Format::Dxf, &dxf_of("", "", &text)).walls.len(), 1);
}

/// As shapely unites them.
#[test]
fn polygons_of_well_known_text_are_one_area() {
    for (text, walls, area, within) in [
        // Two halls and a passage, which touch; that overlap; a collection in a collection.
        (
            "MULTIPOLYGON (((0 0, 10 0, 10 5, 0 5, 0 0)), ((10 2, 20 2, 20 3, 10 3, 10 2)), ((20 0, 30 0, 30 5, 20 5, 20 0)))",
            1,
            110.0,
            0,
        ),
        (
            "GEOMETRYCOLLECTION (POLYGON ((0 0, 10 0, 10 5, 0 5, 0 0)), GEOMETRYCOLLECTION (POLYGON ((9 2, 20 2, 20 3, 9 3, 9 2))), \
             POLYGON ((19 0, 30 0, 30 5, 19 5, 19 0)))",
            1,
            50.0 + 55.0 + 9.0,
            0,
        ),
        // Apart: all of it counts.
        ("MULTIPOLYGON (((0 0, 10 0, 10 5, 0 5, 0 0)), ((12 0, 15 0, 15 4, 12 4, 12 0)))", 2, 62.0, 0),
        // A hole that another polygon covers in part; holes that overlap; one that holds an island.
        (
            "MULTIPOLYGON (((0 0, 10 0, 10 5, 0 5, 0 0), (2 2, 4 2, 4 4, 2 4, 2 2)), ((3 1, 5 1, 5 3, 3 3, 3 1)))",
            2,
            47.0,
            0,
        ),
        (
            "POLYGON ((0 0, 10 0, 10 5, 0 5, 0 0), (2 2, 4 2, 4 4, 2 4, 2 2), (3 1, 5 1, 5 3, 3 3, 3 1))",
            2,
            43.0,
            0,
        ),
        (
            "MULTIPOLYGON (((0 0, 10 0, 10 5, 0 5, 0 0), (2 1, 5 1, 5 4, 2 4, 2 1)), ((3 2, 4 2, 4 3, 3 3, 3 2)))",
            3,
            42.0,
            0,
        ),
        // What lies within another one changes nothing, and is said.
        (
            "GEOMETRYCOLLECTION (POLYGON ((0 0, 10 0, 10 5, 0 5, 0 0)), POLYGON ((2 1, 5 1, 5 4, 2 4, 2 1)))",
            1,
            50.0,
            1,
        ),
        // Also where it touches the rim, at a side or in a corner, or rounding puts it a millimetre beyond.
        (
            "GEOMETRYCOLLECTION (POLYGON ((0 0, 10 0, 10 5, 0 5, 0 0)), POLYGON ((9 4, 10 4, 10 5, 9 5, 9 4)))",
            1,
            50.0,
            1,
        ),
        (
            "GEOMETRYCOLLECTION (POLYGON ((0 0, 10 0, 10 5, 0 5, 0 0)), POLYGON ((10 2, 9 3, 8 2, 9 1, 10 2)))",
            1,
            50.0,
            1,
        ),
        (
            "GEOMETRYCOLLECTION (POLYGON ((9 4, 10 4, 10 5, 9 5, 9 4)), POLYGON ((0 0, 9.999999 0, 9.999999 5, 0 5, 0 0)))",
            1,
            50.0,
            1,
        ),
        // Not where a part of it is beyond the rim, though all its corners are within; nor in a hole.
        (
            "GEOMETRYCOLLECTION (POLYGON ((0 0, 10 0, 10 5, 6 5, 6 2, 4 2, 4 5, 0 5, 0 0)), POLYGON ((3 3, 7 3, 7 4, 3 4, 3 3)))",
            2,
            44.0 + 2.0,
            0,
        ),
        // One polygon is as drawn, and lines are walls.
        (
            "GEOMETRYCOLLECTION (POLYGON ((0 0, 10 0, 10 5, 0 5, 0 0), (2 1, 5 1, 5 4, 2 4, 2 1)), LINESTRING (6 0, 6 3))",
            3,
            41.0,
            0,
        ),
        // A corner that is repeated, and one that is nearly so; a spike; a hole that is reached by a bridge.
        ("POLYGON ((0 0, 10 0, 10 0, 10 5, 10 5.0000001, 0 5, 0 0, 0 0))", 1, 50.0, 0),
        ("POLYGON ((0 0, 10 0, 12 0, 10 0, 10 5, 0 5, 0 0))", 1, 50.0, 0),
        ("POLYGON ((0 0, 10 0, 10 5, 0 5, 0 0, 2 1, 2 4, 5 4, 5 1, 2 1, 0 0))", 2, 41.0, 0),
    ] {
        let found = plan(Format::Wkt, text);
        let of = found.area().unwrap();
        assert!((of - area).abs() < 1e-5, "{text}: {of}");
        assert_eq!((found.walls.len(), found.within.len()), (walls, within), "{text}: {:?}", found.walls);
    }
    // What is said of it.
    let room = "POLYGON ((0 0, 10 0, 10 5, 0 5, 0 0))";
    let boxes = ["POLYGON ((9 4, 10 4, 10 5, 9 5, 9 4))", "POLYGON ((2 1, 5 1, 5 4, 2 4, 2 1))"];
    let said = |text: String| read_as(Format::Wkt, &text).unwrap().said("x");
    let find = |said: &[(&str, String)], key: &str| {
        said.iter().find(|(what, _)| *what == key).map(|(_, how)| how.clone()).unwrap()
    };
    let one = said(format!("GEOMETRYCOLLECTION ({room}, {})", boxes[0]));
    assert_eq!(
        find(&one, "warning"),
        "POLYGON 1 lies within another polygon and is counted as floor; if it is an obstacle, draw it as a hole"
    );
    assert_eq!(find(&one, "ground"), "50.000 m² of all areas, without obstacles");
    assert_eq!(find(&said(room.to_owned()), "ground"), "50.000 m² within the outline, without obstacles");
    let two = said(format!("GEOMETRYCOLLECTION ({room}, {}, {})", boxes[0], boxes[1]));
    assert!(
        find(&two, "warning").starts_with("POLYGON 1, POLYGON 2 lie within other polygons and are counted")
    );
    let said = read_as(Format::Wkt, "POLYGON ((0 0, 10 0, 0 5, 10 5, 0 0))").unwrap_err().to_string();
    assert_eq!(said, "POLYGON 0: its sides cross or touch each other");
}

fn feature(layer: &str, corners: &[Vec2]) -> String {
    let text = |at: &Vec2| format!("[{}, {}]", at.x, at.y);
    let corners: Vec<String> = corners.iter().chain(&corners[..1]).map(text).collect();
    format!(
        r#"{{"type": "Feature", "properties": {{"layer": "{layer}"}}, "geometry": {{"type": "Polygon", "coordinates": [[{}]]}}}}"#,
        corners.join(", ")
    )
}

fn collection(features: &[String]) -> String {
    format!(r#"{{"type": "FeatureCollection", "features": [{}]}}"#, features.join(", "))
}

/// Two rooms that share a part of a side, turned by each angle, in millimetres: the wall between them is open.
#[test]
fn areas_that_share_a_side_are_united_at_each_angle() {
    for degrees in 0..360 {
        let turn = lemons_core::plane::rotation(f64::from(degrees).to_radians());
        let room = |[x0, y0, x1, y1]: [f64; 4]| {
            let corners = [vec2(x0, y0), vec2(x1, y0), vec2(x1, y1), vec2(x0, y1)];
            corners.map(|at| (turn * at).map(|x| (x * 1e3).round() / 1e3))
        };
        let features =
            [[0.0, 0.0, 6.0, 4.0], [2.0, 4.0, 4.0, 9.0]].map(|sides| feature("walkablearea-0", &room(sides)));
        let found = plan(Format::GeoJson, &collection(&features));
        assert_eq!((found.walls.len(), found.walls[0].len() < 12), (1, true), "{degrees}: {:?}", found.walls);
        assert!((found.area().unwrap() - 34.0).abs() < 0.02, "{degrees}: {:?}", found.area());
        let (a, b) = (turn * vec2(3.0, 3.5), turn * vec2(3.0, 4.5));
        let shut =
            found.walls[0].windows(2).any(|side| lemons_core::plane::segments_touch(a, b, side[0], side[1]));
        assert!(!shut, "{degrees}");
    }
}

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
        plan(Format::Svg, &text).area().unwrap()
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
    let read = plan(Format::Svg, text);
    assert!(
        read.left_out.keys().any(|(_, kind)| kind.starts_with("<style> with fill-rule")),
        "{:?}",
        read.left_out
    );
    let wall = "<svg viewBox='0 0 9 9'><g id='A-WALL'><path d='M0,0 h9 v9 h-9 z'/></g></svg>";
    let drawing =
        Drawing::read(Format::Svg, wall.as_bytes(), &Reading { unit: Some(1.0), ..Reading::default() })
            .unwrap();
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
        let area = plan(Format::Svg, &text).area().unwrap();
        assert!((area - expected).abs() < 1e-6, "{group} {own}: {area}");
    }
}

/// An exit may be a line, also where nobody says that it is not filled.
#[test]
fn exits_are_not_closed_by_filling() {
    let text = "<svg viewBox='0 0 30 30'><rect id='walkablearea' width='30' height='30'/><path id='exits-a' d='M30,2 v1 v1'/></svg>";
    assert_eq!(plan(Format::Svg, text).exits[0].corners, [vec2(30.0, 28.0), vec2(30.0, 26.0)]);
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
        Drawing::read(Format::Svg, text.as_bytes(), &METRES)
    };
    let lines = of(&[nested(1, 900)]).unwrap().lines;
    assert_eq!((lines.len(), lines.iter().filter(|line| line.hole).count()), (901, 450));
    // Each hole follows the rim around it.
    let size = |line: &Line| area(line).abs().sqrt().round() as i64;
    assert!(lines[1..].chunks(2).all(|pair| pair[1].hole && size(&pair[0]) - size(&pair[1]) == 2));
    // 2500 squares have 10 000 corners; paths of one part are not counted.
    let mut paths: Vec<String> = (0..5).map(|k| nested(100 * k, 500)).collect();
    paths.push(ring(1));
    assert!(of(&paths).is_ok());
    paths.push(nested(1, 2));
    let said = of(&paths).unwrap_err().to_string();
    assert_eq!(
        said,
        "line 1: <path>: paths of several parts have 10008 corners so far; at most 10000 are allowed"
    );
}

/// Only the property `layer` may have something before a role: the others are free text.
#[test]
fn free_text_of_geojson_is_no_exit() {
    let of = |properties: &str| {
        let line = r#""geometry": {"type": "LineString", "coordinates": [[1, 1], [2, 1]]}"#;
        let wall = format!(r#"{{"type": "Feature", "properties": {properties}, {line}}}"#);
        let found = plan(
            Format::GeoJson,
            &collection(&[feature("A", &[vec2(0.0, 0.0), vec2(9.0, 0.0), vec2(9.0, 5.0)]), wall]),
        );
        (found.walls.len(), found.exits.len())
    };
    for properties in [
        r#"{"layer": "A-WALL", "name": "wall beside ramp - exit 2"}"#,
        r#"{"layer": "A-WALL", "name": "ramp/exit 2"}"#,
        r#"{"name": "0 - exits-0"}"#,
        r#"{"name": "hall|exits-0", "type": "stairs$0$exits"}"#,
        r#"{"layer": "ramp - exit 2"}"#,
    ] {
        assert_eq!(of(properties), (2, 0), "{properties}");
    }
    for properties in [
        r#"{"layer": "0 - exits-0"}"#,
        r#"{"layer": "plan|exits-0", "name": "north"}"#,
        r#"{"layer": "A-WALL", "name": "exit 2"}"#,
    ] {
        assert_eq!(of(properties), (1, 1), "{properties}");
    }
    // Nor is the id of a shape.
    let text = "<svg viewBox='0 0 9 9'><path d='M0,0 h9 v9 z'/><path id='ramp/exit 2' d='M1,1 h1'/></svg>";
    assert!(plan(Format::Svg, text).exits.is_empty());
}

/// The rectangle of each, as the standard says.
#[test]
fn symbols_and_inner_pictures_have_coordinates_of_their_own() {
    for (symbol, by, low, high) in [
        (
            "<symbol id='s' viewBox='0 0 10 10'>",
            "x='100' y='100' width='50' height='50'",
            [100.0, 100.0],
            [150.0, 150.0],
        ),
        (
            "<symbol id='s' viewBox='0 0 10 10' width='50' height='50'>",
            "x='100' y='100'",
            [100.0, 100.0],
            [150.0, 150.0],
        ),
        (
            "<symbol id='s' viewBox='0 0 10 10'>",
            "x='100' width='80' height='20'",
            [130.0, 0.0],
            [150.0, 20.0],
        ),
        (
            "<symbol id='s' viewBox='0 0 10 10' preserveAspectRatio='none'>",
            "x='100' width='80' height='20'",
            [100.0, 0.0],
            [180.0, 20.0],
        ),
        (
            "<symbol id='s' viewBox='0 0 10 10' preserveAspectRatio='xMaxYMin meet'>",
            "width='20' height='80'",
            [0.0, 0.0],
            [20.0, 20.0],
        ),
        (
            "<symbol id='s' viewBox='0 0 10 10' preserveAspectRatio='xMinYMax'>",
            "width='20' height='80'",
            [0.0, 60.0],
            [20.0, 80.0],
        ),
        (
            "<symbol id='s' viewBox='5 5 20 20'>",
            "x='100' width='40' height='40'",
            [90.0, -10.0],
            [110.0, 10.0],
        ),
        ("<symbol id='s' viewBox='0 0 10 10'>", "width='50%' height='25%'", [125.0, 0.0], [275.0, 150.0]),
        ("<symbol id='s' viewBox='0 0 10 10'>", "", [100.0, 0.0], [700.0, 600.0]),
        ("<symbol id='s'>", "x='7' width='50' height='50'", [7.0, 0.0], [17.0, 10.0]),
        (
            "<svg id='s' x='3' width='20' height='20' viewBox='0 0 10 10'>",
            "x='7' width='40' height='40'",
            [10.0, 0.0],
            [50.0, 40.0],
        ),
    ] {
        let end = if symbol.starts_with("<svg") { "</svg>" } else { "</symbol>" };
        let text = format!(
            "<svg viewBox='0 0 800 600'><defs>{symbol}<rect width='10' height='10'/>{end}</defs><use href='#s' {by}/></svg>"
        );
        let line = Drawing::read(Format::Svg, text.as_bytes(), &METRES).unwrap().lines.remove(0);
        let bounds = Bounds::of(line.corners.iter().copied()).unwrap();
        // y is upwards.
        let expected = Bounds { low: vec2(low[0], 600.0 - high[1]), high: vec2(high[0], 600.0 - low[1]) };
        assert!(
            near(bounds.low, expected.low) && near(bounds.high, expected.high),
            "{symbol} {by}: {bounds:?}"
        );
    }
    let text = "<svg viewBox='0 0 80 60'><svg x='10' y='10' width='20' height='20' viewBox='0 0 5 5'><rect width='5' height='5'/></svg></svg>";
    let line = Drawing::read(Format::Svg, text.as_bytes(), &METRES).unwrap().lines.remove(0);
    assert!(line.corners.iter().any(|at| near(*at, vec2(30.0, 30.0))), "{line:?}");
}

#[test]
fn what_is_in_other_files_or_cut_off_is_said() {
    let square = "0 LWPOLYLINE 8 A 70 1 10 0 20 0 10 8 20 0 10 8 20 6 10 0 20 6 ";
    let block = "0 BLOCK 2 XR 70 FLAGS 10 0 20 0 1 ../other.dwg 0 ENDBLK";
    let of = |flags: &str| {
        let text =
            dxf_of("", &block.replace("FLAGS", flags), &format!("{square} 0 INSERT 8 B 2 XR 10 0 20 0"));
        plan(Format::Dxf, &text).left_out.iter().map(left_out).collect::<Vec<_>>()
    };
    let expected = "1 INSERT of \"XR\": the file \"../other.dwg\" that it stands for is not read; bind it on layer \"B\"";
    // An external reference, one that is found, and one over another.
    assert_eq!(
        (of("4"), of("36"), of("12")),
        (vec![expected.into()], vec![expected.into()], vec![expected.into()])
    );
    assert!(of("0").is_empty());

    let whole = dxf_of("", "", square);
    let cut = |end: &str| Drawing::read(Format::Dxf, &whole.as_bytes()[..whole.find(end).unwrap()], &METRES);
    let error = cut("6\n0\nENDSEC\n0\nEOF").unwrap_err().to_string();
    assert!(error.ends_with("without its value"), "{error}");
    let error = cut("20\n6\n0\nENDSEC\n0\nEOF").unwrap_err().to_string();
    assert_eq!(error, "line 36: the file ends within section ENTITIES, without ENDSEC: it was cut off");
    assert!(cut("0\nENDSEC\n0\nEOF").unwrap_err().to_string().contains("cut off"));
    let ended: Vec<String> = cut("0\nEOF").unwrap().left_out.iter().map(left_out).collect();
    assert_eq!(ended, ["1 EOF, which is missing: the file may have been cut off"]);
}

#[test]
fn widths_of_polylines_are_said() {
    let of = |entity: &str| {
        let text = dxf_of("", "", entity);
        let reading = Reading { unit: Some(0.01), ..METRES };
        let drawing = Drawing::read(Format::Dxf, text.as_bytes(), &reading).unwrap();
        (drawing.lines[0].corners.len(), drawing.left_out.iter().map(left_out).collect::<Vec<_>>())
    };
    let said =
        |kind: &str| vec![format!("1 width of 0.240 m of a {kind}: its middle line is taken on layer \"A\"")];
    assert_eq!(of("0 LWPOLYLINE 8 A 43 24 10 0 20 0 10 900 20 0"), (2, said("LWPOLYLINE")));
    assert_eq!(of("0 LWPOLYLINE 8 A 10 0 20 0 40 24 41 12 10 900 20 0"), (2, said("LWPOLYLINE")));
    assert_eq!(
        of("0 POLYLINE 8 A 66 1 0 VERTEX 10 0 20 0 40 24 41 24 0 VERTEX 10 9 20 0 0 SEQEND"),
        (2, said("POLYLINE"))
    );
    assert_eq!(of("0 LWPOLYLINE 8 A 43 0 10 0 20 0 10 900 20 0").1, Vec::<String>::new());
}

#[test]
fn walls_on_layers_that_are_not_there_are_refused() {
    let text = dxf_of(
        "",
        "",
        "0 LINE 8 A-WALL 10 0 20 0 11 9 21 0 0 LINE 8 A-DOOR 10 0 20 1 11 9 21 1 0 TEXT 8 A-TEXT 1 x",
    );
    let of = |walls: &[&str]| {
        let walls = walls.iter().map(|wall| (*wall).to_owned()).collect();
        let drawing = Drawing::read(Format::Dxf, text.as_bytes(), &METRES).unwrap();
        Plan::of(drawing, &PlanSettings { walls, ..PlanSettings::default() })
    };
    let said = of(&["A-WALL", "A-WAL"]).unwrap_err().to_string();
    let expected =
        r#"there is no layer "A-WAL" for walls in this drawing; there are "A-DOOR", "A-TEXT", "A-WALL""#;
    assert_eq!(said, expected);
    // Names of layers are the same in upper and lower case.
    assert_eq!(of(&["a-wall"]).unwrap().walls.len(), 1);
}

#[test]
fn units_and_places_that_no_room_has_are_doubted() {
    let of = |unit: &str, [x, y]: [f64; 2]| {
        let (right, top) = (x + 8.0, y + 6.0);
        let square = format!(
            "0 LWPOLYLINE 8 walkablearea 70 1 10 {x} 20 {y} 10 {right} 20 {y} 10 {right} 20 {top} 10 {x} 20 {top}"
        );
        let text = dxf_of(&format!("9 $INSUNITS 70 {unit}"), "", &square);
        let reading = Reading::default();
        let read = Read::of(Format::Dxf, text.as_bytes(), &reading, &PlanSettings::default()).unwrap();
        let said = read.said("x");
        let find = |key: &str| said.iter().find(|(what, _)| *what == key).map(|(_, how)| how.clone());
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
        let read = read_as(Format::Wkt, &format!("POLYGON ((0 0, {x} 0, {x} {y}, 0 {y}, 0 0))")).unwrap();
        read.said("x").into_iter().find(|(what, _)| *what == "unit?").map(|(_, how)| how)
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
        let read =
            |settings: &PlanSettings| Read::of(Format::Dxf, text.as_bytes(), &METRES, settings).unwrap();
        let drawing = Drawing::read(Format::Dxf, text.as_bytes(), &METRES).unwrap();
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
    assert!(doubt.as_ref().is_some_and(|said| said.contains(&format!("{swing} 2.45,0:"))), "{doubt:?}");
    assert_eq!(doors, [([2450.0, 0.0], 900.0)]);
    let right = line((3.8, 0.0), (3.8, 0.9)) + &arc(3.8, 0.0, 0.9, 90, 180);
    let (doubt, doors) = of(&(room(3.8) + &left + &right));
    assert!(doubt.as_ref().is_some_and(|said| said.contains(swing)), "{doubt:?}");
    assert_eq!(doors, [([2900.0, 0.0], 1800.0)]);
    let round =
        chain(&[(5.0, 0.0), (0.0, 0.0), (0.0, 4.0), (6.0, 4.0), (6.0, 1.0)]) + &arc(5.0, 1.0, 1.0, 270, 360);
    let bar = room(2.0) + &chain(&[(3.0, 3.0), (3.0, 2.0), (4.0, 2.0)]) + &arc(3.0, 2.0, 1.0, 0, 90);
    for entities in [round, bar] {
        assert_eq!(of(&entities).0, None);
    }
}

/// The outside: by hand. A name that is in the file is one layer; others are parted at commas.
#[test]
fn names_of_layers_may_have_commas() {
    let square = |layer: &str, from: u32| {
        format!(
            r#"{{"type": "Feature", "properties": {{"layer": "{layer}"}}, "geometry": {{"type": "LineString",
            "coordinates": [[{from}, {from}], [9, {from}], [9, 9], [{from}, 9], [{from}, {from}]]}}}}"#
        )
    };
    let all = ["Wände, EG", "A", "B", "Kern, 1"].iter().zip(0..).map(|(layer, k)| square(layer, k));
    let text =
        format!(r#"{{"type": "FeatureCollection", "features": [{}]}}"#, all.collect::<Vec<_>>().join(", "));
    let of = |walls: &[&str]| {
        let walls: Vec<String> = walls.iter().map(|wall| (*wall).to_owned()).collect();
        let settings = PlanSettings { walls, ..PlanSettings::default() };
        let read = Read::of(Format::GeoJson, text.as_bytes(), &METRES, &settings);
        read.map(|read| read.plan.walls.len()).map_err(|error| error.to_string())
    };
    assert_eq!((of(&["Wände, EG"]), of(&["wände, eg", "A,B"]), of(&["A,B"])), (Ok(1), Ok(3), Ok(2)));
    assert!(of(&["Wände, OG"]).unwrap_err().contains("no layer \"Wände\""));
    // A proposal is repeated as it is.
    let drawing = Drawing::read(Format::GeoJson, text.as_bytes(), &METRES).unwrap();
    let given = Enclosing { obstacles: vec!["Kern, 1".to_owned()], ..Enclosing::default() };
    let walls = ["Wände, EG".to_owned(), "A,B".to_owned()];
    let found = Proposal::of(&drawing, &walls, None, Some(&given)).unwrap().unwrap();
    let expected = ["--walls", "Wände, EG", "--walls", "A", "--walls", "B", "--obstacles", "Kern, 1"];
    assert_eq!(found.options()[1..9], expected);
}

/// Of 30 000 lines on each other one wall is left: the engine compares all pairs of those.
#[test]
fn many_lines_on_one_line_are_one_wall() {
    let lines: String = (0..30_000)
        .map(|k| format!("0 LINE 8 W 10 0 20 0 11 {} 21 0 ", 100.0 - f64::from(k) * 1e-3))
        .collect();
    let found = plan(Format::Dxf, &dxf_of("", "", &lines));
    assert_eq!((found.walls.len(), found.doubles), (1, 29_999));
}
