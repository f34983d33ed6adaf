//! Files that are no drawing, damaged, or too large.

use super::*;

fn refused(format: DrawingFormat, text: &str) -> String {
    drawing(format, text).unwrap_err().to_string()
}

#[test]
fn what_is_wrong_is_said_with_line_entity_layer_and_value() {
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
        let message = refused(DrawingFormat::Dxf, &dxf_of("", "", entities));
        assert!(message.starts_with(expected), "{entities}: {message}");
    }
    for (format, text, expected) in [
        (DrawingFormat::Dxf, "AutoCAD Binary DXF\r\n", "is a binary DXF"),
        (DrawingFormat::Dxf, "AC1032\0\0", "is a DWG"),
        (
            DrawingFormat::GeoJson,
            "{\"type\": \"Polygon\", \"coordinates\": [[[0, 0], [1, 0], [1, \"a\"], [0, 0]]]}",
            "coordinates[0][2] = [1,\"a\"]: must be numbers",
        ),
        (
            DrawingFormat::GeoJson,
            "{\"type\": \"Polygon\", \"coordinates\": [[[0, 0], [1, 0], [1, 1]]]}",
            "coordinates[0]: the ring is not closed",
        ),
        (DrawingFormat::GeoJson, "{\"type\": \"Circle\"}", "coordinates: type = \"Circle\": must be one of"),
        (DrawingFormat::GeoJson, "{", "EOF while parsing an object at line 1 column 1"),
        (
            DrawingFormat::GeoJson,
            "{\"crs\": {\"properties\": {\"name\": \"urn:ogc:def:crs:OGC:1.3:CRS84\"}}}",
            "crs: ",
        ),
        (DrawingFormat::Wkt, "POLYGON ((0 0, 1 0, 1 1))", "the ring that ends at 1 1 is not closed"),
        (DrawingFormat::Wkt, "CIRCLE (0 0)", "\"CIRCLE (0 0)\" is not a POLYGON or another geometry"),
        (
            DrawingFormat::Svg,
            "<svg>\n<path d='M 0 0 L 1 x'/></svg>",
            "line 2: <path> d=\"M 0 0 L 1 x\": is not a path",
        ),
        (
            DrawingFormat::Svg,
            "<svg><line x1='50%'/></svg>",
            "line 1: <line> x1=\"50%\": must be a number, or a length",
        ),
        (DrawingFormat::Svg, "<svg><text>a</text></svg>", "there are no lines in this SVG: 1 <text>"),
    ] {
        let message = refused(format, text);
        assert!(message.starts_with(expected), "{text}: {message}");
    }
}

#[test]
fn large_entities_that_are_repeated_are_refused() {
    let check = |format: DrawingFormat, text: &str| {
        let error = refused(format, text);
        assert!(error.contains("have more than 100000000 parts"), "{error}");
    };
    // A text of 20 000 pairs in a block, 10 000 times.
    let block = format!("0 BLOCK 2 B 0 TEXT 8 A {} 0 ENDBLK", "1 x ".repeat(20_000));
    check(DrawingFormat::Dxf, &dxf_of("", &block, "0 INSERT 8 A 2 B 10 0 20 0 70 100 71 100"));
    let style = format!("<path id='p' style='{}' d='M0 0 H1'/>", " ".repeat(100_000));
    let uses = "<use href='#p'/>".repeat(1001);
    check(DrawingFormat::Svg, &format!("<svg viewBox='0 0 9 9'>{style}{uses}</svg>"));
}

#[test]
fn long_names_are_refused() {
    let check = |format: DrawingFormat, text: &str| {
        let error = refused(format, text);
        assert!(error.contains("has more than 255 characters"), "{error}");
    };
    let (long, fits) = ("ä".repeat(256), "ä".repeat(255));
    check(DrawingFormat::Dxf, &dxf_of("", "", &format!("0 LINE 8 {long} 10 0 20 0 11 1 21 0")));
    check(DrawingFormat::Dxf, &dxf_of("", "", &format!("0 INSERT 8 A 2 {long} 10 0 20 0")));
    assert_eq!(lines_of(&format!("0 LINE 8 {fits} 10 0 20 0 11 1 21 0"))[0].layer, fits);
    for key in ["layer", "name"] {
        let geometry = r#"{"type": "LineString", "coordinates": [[0, 0], [1, 0]]}"#;
        let text =
            format!(r#"{{"type": "Feature", "geometry": {geometry}, "properties": {{"{key}": "{long}"}}}}"#);
        check(DrawingFormat::GeoJson, &text);
    }
    for inner in
        [format!("<g id='{long}'><path d='M0 0 H1'/></g>"), format!("<path id='{long}' d='M0 0 H1'/>")]
    {
        check(DrawingFormat::Svg, &format!("<svg viewBox='0 0 9 9'>{inner}</svg>"));
    }
}

#[test]
fn blocks_that_grow_without_end_are_refused() {
    let read = |blocks: &str, entities: &str| refused(DrawingFormat::Dxf, &dxf_of("", blocks, entities));
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
    let svg = refused(DrawingFormat::Svg, &format!("<svg>{uses}</svg>"));
    assert!(svg.contains("more than"), "{svg}");
}

/// Numbers that repeat.
fn next(state: &mut u64) -> usize {
    *state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
    (*state >> 33) as usize
}

/// Cuts, doubles and changes lines and bytes: an error or a drawing, never a panic.
#[test]
fn damaged_files_do_no_harm() {
    let geojson = b"{\"type\": \"FeatureCollection\", \"features\": [{\"type\": \"Feature\", \"properties\": {\"layer\": \"exits\"},\
        \"geometry\": {\"type\": \"MultiPolygon\", \"coordinates\": [[[[0, 0], [4, 0], [4, 3], [0, 0]]]]}}]}";
    let wkt = b"GEOMETRYCOLLECTION (POLYGON ((0 0, 4 0, 4 3, 0 0), (1 1, 2 1, 2 2, 1 1)), MULTIPOINT ((1 2), (3 4)), LINESTRING Z (0 0 1, 1 1 1))";
    let all = [
        (DrawingFormat::Dxf, example("hall.dxf")),
        (DrawingFormat::Dxf, example("office.dxf")),
        (DrawingFormat::Svg, example("platform.svg")),
        (DrawingFormat::GeoJson, geojson.to_vec()),
        (DrawingFormat::Wkt, wkt.to_vec()),
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
                if let Ok(plan) = FloorPlan::of(drawing, &settings) {
                    let _ = (plan.area(), plan.doors(), plan.way());
                    let _ = written_formats().map(|format| write_plan(&plan, format));
                }
            }
        }
    }
    assert!(read > 100, "{read} were read: most damage is too great to test much");
}

/// Of 30 000 lines on each other one wall is left: the engine compares all pairs of those.
#[test]
fn many_lines_on_one_line_are_one_wall() {
    let lines: String = (0..30_000)
        .map(|k| format!("0 LINE 8 W 10 0 20 0 11 {} 21 0 ", 100.0 - f64::from(k) * 1e-3))
        .collect();
    let found = plan_of_dxf(&lines);
    assert_eq!((found.walls.len(), found.doubles), (1, 29_999));
}
