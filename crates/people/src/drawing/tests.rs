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
    assert!(united.united && united.walls.len() == 1);
    // Where nothing meets, walls are as drawn.
    let apart = of(&[
        ("walkablearea", [0.0, 0.0, 4.0, 3.0]),
        ("obstacles", [1.0, 1.0, 2.0, 2.0]),
        ("furniture", [0.5, 0.5, 0.7, 0.7]),
    ]);
    assert!(!apart.united && apart.walls.len() == 2 && apart.area() == Some(11.0));
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
    let ::wkt::Wkt::GeometryCollection(all) = text.trim().parse::<::wkt::Wkt<f64>>().unwrap() else {
        panic!("no collection")
    };
    for (read, wall) in all.geometries().iter().zip(&hall.walls) {
        let ::wkt::Wkt::Polygon(polygon) = read else { panic!("{read:?}") };
        let corners: Vec<Vec2> = polygon.rings()[0].coords().iter().map(|c| vec2(c.x, c.y)).collect();
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
