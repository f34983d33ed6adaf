//! Blocks, units, and what is left out of DXF.

use super::*;

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
        let drawing =
            Drawing::read(DrawingFormat::Dxf, text.as_bytes(), &Reading { unit, deviation: DEVIATION });
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
        Drawing::read(DrawingFormat::Dxf, text.as_bytes(), &Reading { unit, ..METRES })
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
fn what_is_in_other_files_or_cut_off_is_said() {
    let square = &rectangle("A", [0.0, 0.0, 8.0, 6.0]);
    let block = "0 BLOCK 2 XR 70 FLAGS 10 0 20 0 1 ../other.dwg 0 ENDBLK";
    let of = |flags: &str| {
        let text =
            dxf_of("", &block.replace("FLAGS", flags), &format!("{square} 0 INSERT 8 B 2 XR 10 0 20 0"));
        left_out_of(&plan(DrawingFormat::Dxf, &text))
    };
    let expected = "1 INSERT of \"XR\": the file \"../other.dwg\" that it stands for is not read; bind it on layer \"B\"";
    // An external reference, one that is found, and one over another.
    assert_eq!(
        (of("4"), of("36"), of("12")),
        (vec![expected.into()], vec![expected.into()], vec![expected.into()])
    );
    assert!(of("0").is_empty());

    let whole = dxf_of("", "", square);
    let cut =
        |end: &str| Drawing::read(DrawingFormat::Dxf, &whole.as_bytes()[..whole.find(end).unwrap()], &METRES);
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
        let drawing = Drawing::read(DrawingFormat::Dxf, text.as_bytes(), &reading).unwrap();
        (drawing.lines[0].corners.len(), drawing.left_out.iter().map(left_out).collect::<Vec<_>>())
    };
    let message =
        |kind: &str| vec![format!("1 width of 0.240 m of a {kind}: its middle line is taken on layer \"A\"")];
    assert_eq!(of("0 LWPOLYLINE 8 A 43 24 10 0 20 0 10 900 20 0"), (2, message("LWPOLYLINE")));
    assert_eq!(of("0 LWPOLYLINE 8 A 10 0 20 0 40 24 41 12 10 900 20 0"), (2, message("LWPOLYLINE")));
    assert_eq!(
        of("0 POLYLINE 8 A 66 1 0 VERTEX 10 0 20 0 40 24 41 24 0 VERTEX 10 9 20 0 0 SEQEND"),
        (2, message("POLYLINE"))
    );
    assert_eq!(of("0 LWPOLYLINE 8 A 43 0 10 0 20 0 10 900 20 0").1, Vec::<String>::new());
}
