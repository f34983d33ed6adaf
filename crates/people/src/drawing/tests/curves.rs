//! Curves against closed forms.

use super::*;

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
            Drawing::read(DrawingFormat::Dxf, text.as_bytes(), &reading).unwrap().lines.remove(0)
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
            Drawing::read(DrawingFormat::Svg, text.as_bytes(), &reading).unwrap().lines.remove(0)
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
