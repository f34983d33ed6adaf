//! Notes on a scene.

use crate::common::trial;
use lemons_picture::*;
use lemons_plane::{Vec2, vec2};
use roxmltree::{Document, Node};

/// A scene without bodies and walls, 1 m × 1 m on a page of 428 px: 400 px/m.
fn drawn(notes: Vec<Note>) -> String {
    let empty = trial(vec![], vec![]);
    let mut scene = Scene::at_start(&empty);
    scene.view = Some(View { low: vec2(0.0, 0.0), high: vec2(1.0, 1.0) });
    scene.notes = notes;
    svg(&scene, &Style { scale_bar: Visibility::Hidden, ..Style::default() })
}

fn paths<'a>(document: &'a Document<'a>, class: &str) -> Vec<Node<'a, 'a>> {
    document.descendants().filter(|n| n.attribute("class") == Some(class)).collect()
}

/// The points of a path that consists of lines, and of the ends of its arcs.
fn points(path: &Node) -> Vec<Vec2> {
    let d = path.attribute("d").unwrap();
    d.split(['M', 'L', 'A', 'Z'])
        .filter(|piece| !piece.is_empty())
        .map(|piece| {
            // An arc's flags touch its end.
            let spaced = piece.replace(" 0 00", " 0 0 0 ").replace(" 0 01", " 0 0 1 ").replace('-', " -");
            let numbers: Vec<f64> = spaced.split_whitespace().map(|n| n.parse().unwrap()).collect();
            let [.., x, y] = numbers[..] else { panic!("{piece}") };
            vec2(x, y)
        })
        .collect()
}

fn near(a: Vec2, b: Vec2) -> bool {
    (a - b).norm() < 2e-4
}

#[test]
fn an_arrow_ends_at_its_point() {
    let (from, to) = (vec2(0.1, 0.2), vec2(0.7, 0.2));
    let text = drawn(vec![Mark::Arrow { from, to }.note()]);
    let document = Document::parse(&text).unwrap();
    let shaft = points(&paths(&document, "arrow")[0]);
    let head = points(&paths(&document, "head")[0]);
    assert!(near(head[0], to) && near(shaft[0], from), "{text}");
    // The shaft ends in the middle of the head's back.
    assert!(near(shaft[1], (head[1] + head[2]) * 0.5) && shaft[1].x < to.x);
}

#[test]
fn a_short_length_has_its_heads_outside() {
    for (size, inside) in [(0.4, true), (0.02, false)] {
        let (from, to) = (vec2(0.3, 0.5), vec2(0.3 + size, 0.5));
        let text = drawn(vec![Mark::Length { from, to }.note()]);
        let document = Document::parse(&text).unwrap();
        let heads = points(&paths(&document, "head")[0]);
        assert!(near(heads[0], from) && near(heads[3], to), "{text}");
        assert_eq!(heads[1].x > from.x, inside);
        assert_eq!(heads[4].x < to.x, inside);
    }
}

#[test]
fn an_angle_goes_the_way_it_is_told() {
    for (to, above) in [(1.0, true), (-1.0, false)] {
        let angle = Mark::Angle { centre: vec2(0.5, 0.5), radius: 0.3, from: 0.0, to };
        let text = drawn(vec![angle.note()]);
        let document = Document::parse(&text).unwrap();
        let tip = points(&paths(&document, "head")[0])[0];
        assert!(near(tip, vec2(0.5 + 0.3 * 1f64.cos(), 0.5 + 0.3 * to.sin())), "{text}");
        let arc = points(&paths(&document, "angle")[0]);
        assert!(near(arc[0], vec2(0.8, 0.5)) && (arc[1].y > 0.5) == above, "{text}");
        // All of its points are on the circle.
        assert!(arc.iter().all(|p| ((*p - vec2(0.5, 0.5)).norm() - 0.3).abs() < 2e-4));
    }
}

/// The extent of stroked words.
fn extent(text: &str, side: Side) -> (Vec2, Vec2) {
    let svg = drawn(vec![Mark::words(vec2(0.5, 0.5), side, text).note()]);
    let document = Document::parse(&svg).unwrap();
    let words = &paths(&document, "words")[0];
    assert_eq!(words.attribute("aria-label"), Some(&*text.replace('\n', " ")));
    let d = words.attribute("d").unwrap();
    let spaced: String = d
        .chars()
        .map(|c| if c.is_ascii_alphabetic() { ' ' } else { c })
        .collect::<String>()
        .replace('-', " -");
    let numbers: Vec<f64> = spaced.split_whitespace().map(|n| n.parse().unwrap()).collect();
    let over = |of: usize, best: fn(f64, f64) -> f64, from: f64| {
        numbers.iter().skip(of).step_by(2).copied().fold(from, best)
    };
    let low = vec2(over(0, f64::min, f64::INFINITY), over(1, f64::min, f64::INFINITY));
    (low, vec2(over(0, f64::max, f64::NEG_INFINITY), over(1, f64::max, f64::NEG_INFINITY)))
}

#[test]
fn words_are_on_their_side() {
    let (low, high) = extent("HH", Side::Right);
    assert!(low.x > 0.5 && near((low + high) * 0.5, vec2(0.5 * (low.x + high.x), 0.5)));
    assert!(extent("HH", Side::Left).1.x < 0.5);
    assert!(extent("HH\nHH", Side::Above).0.y > 0.5);
    assert!(extent("HH\nHH", Side::Below).1.y < 0.5);
    let (low, high) = extent("HH\nHH", Side::On);
    assert!(near((low + high) * 0.5, vec2(0.5, 0.5)), "{low:?} {high:?}");
}

#[test]
fn an_index_is_smaller_and_lower() {
    let plain = extent("HH", Side::Right);
    let one = extent("H_H", Side::Right);
    let braced = extent("H_{HH}", Side::Right);
    assert!(one.0.y < plain.0.y && one.1.x < plain.1.x && braced.1.x > one.1.x);
    // What looks like an index and is none.
    for text in ["_", "H_", "_{", "H_{H", "", "__"] {
        drawn(vec![Mark::words(vec2(0.5, 0.5), Side::Right, text).note()]);
    }
}

#[test]
fn what_cannot_be_drawn_is_left_out() {
    let far = vec2(f64::NAN, 0.0);
    let notes = vec![
        Mark::Line(vec![]).note(),
        Mark::Dot(far).note(),
        Mark::Dot(vec2(1e9, 0.0)).note(),
        Mark::Circle { centre: Vec2::ZERO, radius: -1.0 }.note(),
        Mark::Circle { centre: Vec2::ZERO, radius: f64::INFINITY }.note(),
        Mark::Angle { centre: Vec2::ZERO, radius: 1.0, from: 0.0, to: f64::NAN }.note(),
        Mark::Arrow { from: far, to: Vec2::ZERO }.note(),
        Mark::Arrow { from: Vec2::ZERO, to: Vec2::ZERO }.note(),
        Mark::Length { from: Vec2::ZERO, to: Vec2::ZERO }.note(),
        Mark::words(far, Side::On, "far").note(),
    ];
    let text = drawn(notes);
    let document = Document::parse(&text).unwrap();
    let group = paths(&document, "notes")[0];
    assert_eq!(group.children().filter(Node::is_element).count(), 0, "{text}");
    pdf(&drawn(vec![Mark::Dot(vec2(0.5, 0.5)).note().in_series(1).dashed()])).unwrap();
}

#[test]
fn a_scene_is_large_enough_for_its_notes() {
    let empty = trial(vec![], vec![]);
    let mut scene = Scene::at_start(&empty);
    scene.notes = vec![
        Mark::Circle { centre: vec2(1.0, 2.0), radius: 0.5 }.note(),
        Mark::Arrow { from: vec2(0.0, 0.0), to: vec2(3.0, -1.0) }.note(),
    ];
    assert_eq!(scene.extent(), View { low: vec2(0.0, -1.0), high: vec2(3.0, 2.5) });
}
