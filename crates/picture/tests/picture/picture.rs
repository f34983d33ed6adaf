//! Elements of the pictures.

use crate::common::{agent, disk, pedestrian, trial};
use lemons_core::plane::{Vec2, rotation, vec2};
use lemons_picture::{Bounds, Colour, Fill, PictureScene, Pixels, Style, Theme, pixels, png, svg};
use std::f64::consts::{FRAC_PI_2, PI};

/// Bodies without a mark of their direction.
fn plain() -> Style {
    Style { orientation: false, ..Style::default() }
}

fn colour_at(pixels: &Pixels, x: f64, y: f64) -> Colour {
    let k = 4 * (y as usize * pixels.width as usize + x as usize);
    Colour(pixels.rgba[k], pixels.rgba[k + 1], pixels.rgba[k + 2])
}

fn box_of(low: f64, high: f64) -> Vec<Vec2> {
    vec![vec2(low, low), vec2(high, low), vec2(high, high), vec2(low, high), vec2(low, low)]
}

/// `style.width` 428 and a 4 m view: 100 px per metre, the view's upper left corner at (14, 14) · 1.07.
fn on_page(pixels: &Pixels, p: Vec2) -> Colour {
    let margin = 14.0 * 1.07;
    let scale = (428.0 - 2.0 * margin) / 4.0;
    colour_at(pixels, margin + scale * (p.x + 2.0), margin + scale * (2.0 - p.y))
}

#[test]
fn the_right_elements() {
    let wall = vec![vec2(3.0, 0.0), vec2(3.0, 1.0), vec2(4.0, 1.0)];
    let t = trial(
        vec![(pedestrian("0"), Vec2::zeros(), 0.0), (pedestrian("<&\"\u{1}>"), vec2(1.0, 0.0), 1.0)],
        vec![box_of(-2.0, 2.0), wall],
    );
    let style = Style { ids: true, time: Some(1.5), fill: Fill::BodyArea, ..Style::default() };
    let text = svg(&PictureScene::at_start(&t), &style);
    let document = roxmltree::Document::parse(&text).unwrap();
    let group = |name: &str| document.descendants().find(|n| n.attribute("class") == Some(name)).unwrap();
    let children = |name: &str| group(name).children().filter(|n| n.is_element()).count();
    assert_eq!(children("walls"), 2);
    assert_eq!(children("bodies"), 2);
    assert_eq!(children("ids"), 2);
    assert!(text.contains("M-2-2L2-2L2 2L-2 2Z") && text.contains("M3 0L3 1L4 1\""));
    assert!(text.contains("<title>&lt;&amp;&quot;\u{fffd}&gt;</title>"));
    assert_eq!(group("time").attribute("aria-label"), Some("t = 1.50 s"));
    assert_eq!(group("label").attribute("aria-label"), Some("body area (m²)"));
    assert_eq!(group("scale").attribute("aria-label"), Some("1 m"));
    assert_eq!(text, svg(&PictureScene::at_start(&t), &style));
    // One outline per body, in ten or so arcs, not five circles.
    let outline =
        group("bodies").descendants().find(|n| n.has_tag_name("path")).unwrap().attribute("d").unwrap();
    assert_eq!(outline.matches('M').count(), 1);
    png(&text, 400).unwrap();
}

#[test]
fn size_and_colours() {
    let (red, night) = (Colour(0xdd, 0x33, 0x22), Colour(0x12, 0x16, 0x1d));
    let t = trial(vec![(pedestrian("0"), vec2(1.0, 1.0), 0.0)], vec![box_of(-2.0, 2.0)]);
    let style = Style { width: 428.0, fill: Fill::Single(red), ..plain() };
    let text = svg(&PictureScene::at_start(&t), &style);
    let light = pixels(&text, 428, 1).unwrap();
    // The PNG has the same colours.
    let file = png(&text, 428).unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut bytes).unwrap();
    assert!(bytes.chunks_exact(3).eq(light.rgba.chunks_exact(4).map(|pixel| &pixel[..3])));
    // Below the view are a gap and the scale bar: 19.5 px of a page of 400.
    assert_eq!((light.width, light.height), (428, 449));
    assert_eq!(on_page(&light, vec2(1.0, 1.0)), red);
    assert_eq!(on_page(&light, vec2(1.0, -1.0)), Colour(255, 255, 255));
    assert_eq!(on_page(&light, vec2(-2.0, 0.0)), Colour(0x2a, 0x30, 0x3a));
    let dark =
        pixels(&svg(&PictureScene::at_start(&t), &Style { theme: Theme::Dark, ..style }), 428, 1).unwrap();
    assert_eq!(on_page(&dark, vec2(1.0, -1.0)), night);
    let wide = pixels(&svg(&PictureScene::at_start(&t), &plain()), 1000, 1).unwrap();
    assert_eq!((wide.width, wide.height), (1000, 1050));
    assert!(png("<svg", 10).is_err() && png(&svg(&PictureScene::at_start(&t), &plain()), 0).is_err());
    assert!(png(&svg(&PictureScene::at_start(&t), &plain()), 60_000).is_err());
}

#[test]
fn theta_turns_the_shoulders() {
    // Left shoulder small, right one large: at θ = 0 the left one is at +y. The offsets are written at
    // three different orientations: the picture must not depend on it.
    for own in [0.0, 1.0, PI] {
        let at = |y: f64| rotation(own) * vec2(0.0, y);
        let lopsided = agent("0", vec![disk(0.2, at(1.0)), disk(0.5, at(-1.0))]);
        for (theta, left) in [(0.0, vec2(0.0, 1.0)), (FRAC_PI_2, vec2(-1.0, 0.0)), (PI, vec2(0.0, -1.0))] {
            let t = trial(vec![(lopsided.clone(), Vec2::zeros(), theta)], vec![box_of(-2.0, 2.0)]);
            let text = svg(&PictureScene::at_start(&t), &Style { width: 428.0, ..plain() });
            let picture = pixels(&text, 428, 1).unwrap();
            let seen = |p: Vec2| on_page(&picture, p) == Colour::BODY;
            assert!(seen(left) && seen(-left));
            assert!(!seen(left * 1.35) && seen(-left * 1.35), "own {own}, theta {theta}");
        }
    }
}

#[test]
fn what_leaves_a_fixed_view_is_cut() {
    let t = trial((0..50).map(|k| (pedestrian("0"), vec2(f64::from(k), 0.0), 0.0)).collect(), vec![]);
    let view = Some(Bounds { low: vec2(-2.0, -2.0), high: vec2(2.0, 2.0) });
    let mut scene = PictureScene::at_start(&t);
    scene.view = view;
    let text = svg(&scene, &plain());
    png(&text, 100).unwrap();
    assert_eq!(text.matches("rotate(").count(), 3);
    assert_eq!(text.matches("<svg").count(), 2);

    // Who stands outside of the view and reaches into it is drawn: of disks of 0.5 m beside it, the one at x = 2.4 m.
    let beside = |x: f64| (agent("0", vec![disk(0.5, Vec2::zeros())]), vec2(x, 0.0), 0.0);
    let t = trial(vec![beside(0.0), beside(2.4), beside(3.6)], vec![]);
    let mut scene = PictureScene::at_start(&t);
    scene.view = view;
    let text = svg(&scene, &plain());
    assert_eq!(text.matches("rotate(").count(), 2);
}
