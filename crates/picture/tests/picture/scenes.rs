//! Forces, trails, density and sheets in the SVG.

use crate::common::{class, extent, labels, number, pedestrian, trial};
use lemons_core::plane::{Vec2, vec2};
use lemons_core::trial::Trial;
use lemons_picture::*;
use roxmltree::{Document, Node};

fn row(n: usize) -> Trial {
    let people = (0..n).map(|k| (pedestrian(&k.to_string()), vec2(k as f64, 0.0), 0.0)).collect();
    trial(people, vec![vec![vec2(-1.0, -1.0), vec2(n as f64, -1.0)]])
}

fn force(from: f64, to: f64, normal_force: f64) -> Force {
    Force { from: vec2(from, 0.0), to: vec2(to, 0.0), normal_force }
}

#[test]
fn a_line_is_as_wide_as_its_force() {
    let t = row(4);
    let mut scene = Scene::at_start(&t);
    assert!(!svg(&scene, &Style::default()).contains("forces"));
    scene.forces = vec![
        force(0.0, 1.0, 2400.0),
        force(1.0, 2.0, 600.0),
        force(2.0, 3.0, f64::NAN),
        force(0.0, 3.0, -5.0),
        force(f64::INFINITY, 0.0, 10.0),
    ];
    let text = svg(&scene, &Style::default());
    let document = Document::parse(&text).unwrap();
    let [group] = class(&document, "forces")[..] else { panic!("one group") };
    let lines: Vec<Node> = group.children().filter(Node::is_element).collect();
    // The weak one first, so that it does not cross the strong one.
    assert_eq!(lines.iter().map(|l| l.attribute("d").unwrap()).collect::<Vec<_>>(), ["M1 0L2 0", "M0 0L1 0"]);
    let widths: Vec<f64> = lines.iter().map(|l| number(*l, "stroke-width")).collect();
    assert!((widths[1] / widths[0] - 4.0).abs() < 1e-3, "{widths:?}");
    // Bodies, then halos, then lines.
    let at = |name: &str| text.find(&format!("class=\"{name}\"")).unwrap();
    assert!(at("bodies") < at("force-halos") && at("force-halos") < at("forces"));
    // The legend's line has the width of its force at the picture's scale.
    assert_eq!(labels(&document, "entry"), ["2 kN"]);
    let matrix = text.split("matrix(").nth(1).unwrap().split(' ').next().unwrap().parse::<f64>().unwrap();
    let [sample] = class(&document, "force")[..] else { panic!("one sample") };
    assert!((number(sample, "stroke-width") - widths[1] * matrix * 2000.0 / 2400.0).abs() < 2e-3);

    // A movie's scale stays, and so does its legend.
    let fixed = Style { forces: Some(4800.0), ..Style::default() };
    let half = svg(&scene, &fixed);
    let document = Document::parse(&half).unwrap();
    let strongest = class(&document, "forces")[0].children().rfind(Node::is_element).unwrap();
    assert!((number(strongest, "stroke-width") - 0.5 * widths[1]).abs() < 2e-6);
    scene.forces.clear();
    let none = svg(&scene, &fixed);
    assert_eq!(labels(&Document::parse(&none).unwrap(), "entry"), ["2 kN"]);
}

fn trail(measured: bool, points: &[(f64, f64)]) -> Trail {
    Trail { agent: 0, measured, points: points.iter().map(|(x, y)| vec2(*x, *y)).collect() }
}

#[test]
fn measured_is_dashed_and_simulated_solid() {
    let t = row(2);
    let mut scene = Scene::at_start(&t);
    let nan = f64::NAN;
    scene.trails = vec![
        trail(false, &[(0.0, 0.5), (1.0, 0.5), (nan, 0.5), (1.5, 0.5), (2.0, 3.0)]),
        trail(true, &[(0.0, 0.7), (1.0, 0.7)]),
    ];
    let text = svg(&scene, &Style::default());
    let document = Document::parse(&text).unwrap();
    let group = class(&document, "trails")[0];
    let of = |name: &str| {
        let found = group.children().find(|n| n.attribute("class") == Some(name)).unwrap();
        (found.attribute("d").unwrap(), found.attribute("stroke-dasharray"), found.attribute("stroke"))
    };
    assert_eq!(of("simulated"), ("M0 .5L1 .5M1.5 .5L2 3", None, Some("#0072b2")));
    let (d, dashes, colour) = of("measured");
    assert_eq!((d, colour), ("M0 .7L1 .7", Some("#0072b2")));
    assert!(dashes.is_some());
    assert_eq!(labels(&document, "entry"), ["simulated", "measured"]);
    assert_eq!(scene.extent().high.y, 3.0);

    // Alone, the simulated ones fade with age and need no legend.
    scene.trails = vec![Trail {
        agent: 0,
        measured: false,
        points: (0..100).map(|k| vec2(f64::from(k) * 0.02, 0.5)).collect(),
    }];
    let text = svg(&scene, &Style::default());
    let document = Document::parse(&text).unwrap();
    let opacities: Vec<f64> =
        class(&document, "simulated").iter().map(|n| number(*n, "stroke-opacity")).collect();
    assert!(opacities.len() > 4 && opacities.is_sorted() && opacities[0] < 0.3, "{opacities:?}");
    assert!(class(&document, "legend").is_empty());
    // The bodies are over them: the lines hid their fill.
    assert!(text.find("class=\"trails\"") < text.find("class=\"bodies\""));
    // Each piece begins where the one before ends.
    let ends: Vec<&str> = class(&document, "simulated").iter().map(|n| n.attribute("d").unwrap()).collect();
    for pair in ends.windows(2) {
        let last = pair[0].rsplit(['M', 'L']).next().unwrap();
        assert_eq!(pair[1][1..].split('L').next().unwrap(), last);
    }
}

#[test]
fn nothing_overlaps_above_a_scene() {
    // Time and legend on one page: none begins before the other ends.
    let t = row(5);
    let mut scene = Scene::at_start(&t);
    scene.forces = vec![force(0.0, 1.0, 120.0)];
    scene.trails = vec![trail(false, &[(0.0, 0.5), (1.0, 0.5)]), trail(true, &[(0.0, 0.5), (1.0, 0.5)])];
    for time in [0.0, 1234567.0, 1e15, 1e40] {
        let text = svg(&scene, &Style { time: Some(time), ..Style::default() });
        let document = Document::parse(&text).unwrap();
        let mut boxes: Vec<(f64, f64, f64, f64)> = Vec::new();
        for node in class(&document, "time").into_iter().chain(class(&document, "entry")) {
            boxes.push(extent(node.attribute("d").unwrap()));
        }
        assert_eq!(boxes.len(), 4);
        for (k, a) in boxes.iter().enumerate() {
            assert!(a.0 >= 13.0 && (a.1 <= 387.0 || time > 1e20), "{time}: {a:?}");
            for b in &boxes[..k] {
                let apart = a.0 > b.1 + 3.0 || b.0 > a.1 + 3.0 || a.2 > b.3 + 3.0 || b.2 > a.3 + 3.0;
                assert!(apart, "{time}: {a:?} {b:?}");
            }
        }
    }
}

#[test]
fn the_integral_of_density_is_the_number_of_people() {
    let view = Bounds { low: vec2(-4.0, -3.0), high: vec2(9.0, 5.0) };
    let frames = [vec![vec2(0.0, 0.0), vec2(0.3, 1.0), vec2(5.123, 2.0)], vec![vec2(1.0, 1.0)], vec![]];
    for kernel in [0.05, DENSITY_KERNEL, 0.37] {
        let mut map = DensityMap::new(view, kernel, &[]);
        assert!(map.values().iter().all(|v| *v == 0.0));
        for frame in &frames {
            map.add(frame.iter().copied().chain([vec2(f64::NAN, 0.0)]));
        }
        let people: f64 = map.values().iter().sum::<f64>() * map.cell().x * map.cell().y;
        assert!((people - 4.0 / 3.0).abs() < 1e-6, "{kernel}: {people}");
    }
    // A person alone: the Gaussian's own peak, and half a person where the map ends at them.
    let mut map = DensityMap::new(Bounds { low: vec2(-3.0, -3.0), high: vec2(3.0, 3.0) }, 0.5, &[]);
    map.add([Vec2::ZERO]);
    let peak = map.values().into_iter().fold(0.0, f64::max);
    let expected = 1.0 / (std::f64::consts::TAU * 0.25);
    // A corner of four cells stands at the peak itself.
    assert!((peak / expected - 1.0).abs() < 0.03, "{peak}");
    let mut map = DensityMap::new(Bounds { low: vec2(0.0, -3.0), high: vec2(3.0, 3.0) }, 0.5, &[]);
    map.add([Vec2::ZERO]);
    let people: f64 = map.values().iter().sum::<f64>() * map.cell().x * map.cell().y;
    assert!((people - 0.5).abs() < 1e-6, "{people}");
}

/// Two rooms beside each other, people in the left one only, some of them at the wall between.
#[test]
fn density_does_not_go_through_walls() {
    let rooms = [
        vec![vec2(0.0, 0.0), vec2(8.0, 0.0), vec2(8.0, 3.0), vec2(0.0, 3.0), vec2(0.0, 0.0)],
        vec![vec2(4.0, 3.0), vec2(4.0, 1.5), vec2(4.0, 0.0)],
    ];
    let t = trial(vec![], rooms.to_vec());
    let people = [vec2(3.9, 1.5), vec2(3.8, 2.9), vec2(0.15, 0.15), vec2(2.0, 1.0), vec2(3.85, 0.7)];
    let view = Bounds { low: vec2(-2.0, -2.0), high: vec2(10.0, 5.0) };
    for kernel in [0.1, DENSITY_KERNEL, 1.0] {
        let mut map = DensityMap::new(view, kernel, &t.geometry.walls);
        map.add(people);
        let (cell, (columns, _)) = (map.cell(), map.cells());
        let mut all = 0.0;
        for (k, value) in map.values().into_iter().enumerate() {
            let x = view.low.x + ((k % columns) as f64 + 0.5) * cell.x;
            let y = view.low.y + ((k / columns) as f64 + 0.5) * cell.y;
            let inside = x > 0.0 && x < 4.0 && y > 0.0 && y < 3.0;
            assert!(inside || value == 0.0, "{kernel}: {value} at {x}, {y}");
            all += value * cell.x * cell.y;
        }
        assert!((all - 5.0).abs() < 1e-6, "{kernel}: {all}");
    }
    // A door in it: something comes through, and only where it can be seen from the person.
    let door =
        trial(vec![], vec![vec![vec2(4.0, -9.0), vec2(4.0, 1.0)], vec![vec2(4.0, 2.0), vec2(4.0, 9.0)]]);
    let mut map = DensityMap::new(view, 0.5, &door.geometry.walls);
    map.add([vec2(3.5, 1.5)]);
    let (cell, (columns, _)) = (map.cell(), map.cells());
    let at = |x: f64, y: f64| {
        let (column, row) = ((x - view.low.x) / cell.x, (y - view.low.y) / cell.y);
        map.values()[row as usize * columns + column as usize]
    };
    assert!(at(4.2, 1.5) > 0.1 && at(4.2, 2.0) > 0.0 && at(4.2, 2.4) == 0.0 && at(4.05, 0.9) == 0.0);
    let all: f64 = map.values().iter().sum::<f64>() * cell.x * cell.y;
    assert!((all - 1.0).abs() < 1e-6, "{all}");
}

#[test]
fn the_map_is_below_the_outlines() {
    let t = row(3);
    let mut scene = Scene::at_start(&t);
    scene.view = Some(Bounds { low: vec2(-2.0, -2.0), high: vec2(4.0, 2.0) });
    let mut map = DensityMap::new(scene.view.unwrap(), 0.3, &[]);
    map.add(t.dynamics.iter().map(|d| d.position));
    scene.density = Some(map);
    let text = svg(&scene, &Style::default());
    let document = Document::parse(&text).unwrap();
    assert_eq!(labels(&document, "label"), ["density (1/m²)"]);
    assert_eq!(class(&document, "bodies")[0].attribute("fill"), Some("none"));
    assert!(text.find("density").unwrap() < text.find("class=\"walls\"").unwrap());
    assert!(text.len() < 60_000, "{}", text.len());
    let levels = class(&document, "density")[0].children().filter(Node::is_element).count();
    assert!((20..=24).contains(&levels), "{levels}");
    // Nobody far off: the dark end; everybody in the middle: the bright one.
    let picture = pixels(&text, 400, 1).unwrap();
    let scale = 372.0 / 6.0;
    let on = |p: Vec2| {
        let k = 4 * ((14.0 + scale * (2.0 - p.y)) as usize * 400 + (14.0 + scale * (p.x + 2.0)) as usize);
        Colour(picture.rgba[k], picture.rgba[k + 1], picture.rgba[k + 2])
    };
    assert_eq!(on(vec2(1.0, 1.9)), Colour(69, 9, 92));
    assert_eq!(on(vec2(1.0, 0.0)), Colour(240, 229, 34));
}

#[test]
fn a_sheet_has_one_of_everything() {
    let t = row(3);
    let scenes: Vec<Scene> = (0..5)
        .map(|k| {
            let pose = |x: f64| Pose { position: vec2(x + f64::from(k), 0.0), orientation: 0.0 };
            let mut scene = Scene::new(&t, vec![pose(0.0), pose(1.0), pose(2.0)]);
            scene.forces = vec![force(0.0, 1.0, 100.0 * f64::from(k))];
            scene
        })
        .collect();
    let styles: Vec<Style> = (0..5)
        .map(|k| {
            let fill = Fill::Values(Values::of(vec![f64::from(k), 1.0, 2.0], "speed", "m/s"));
            Style { time: Some(0.5 * f64::from(k)), fill, ..Style::default() }
        })
        .collect();
    let panels: Vec<(&Scene, &Style)> = scenes.iter().zip(&styles).collect();
    let text = sheet(&panels, 2);
    let document = Document::parse(&text).unwrap();
    assert_eq!(class(&document, "panel").len(), 5);
    for once in ["colour-bar", "scale-bar", "legend"] {
        assert_eq!(class(&document, once).len(), 1, "{once}");
    }
    assert_eq!(text.matches("id=").count(), 1);
    assert!(!text.contains("<image"));
    let times = labels(&document, "time");
    assert_eq!((times.len(), &times[0][..], &times[4][..]), (5, "(a) t = 0.00 s", "(e) t = 2.00 s"));
    assert_eq!((labels(&document, "low")[0].as_str(), labels(&document, "high")[0].as_str()), ("0", "4"));
    // One scale, and one view: the same row of panels has the same heights.
    let scales: Vec<&str> = text.split("matrix(").skip(1).map(|m| m.split(" 0 0").next().unwrap()).collect();
    assert!(scales.len() == 5 && scales.iter().all(|s| *s == scales[0]));
    // The same force is as wide in each; the greatest of all is the widest.
    let widths: Vec<f64> = class(&document, "forces")
        .iter()
        .filter_map(|g| g.first_element_child().map(|l| number(l, "stroke-width")))
        .collect();
    assert_eq!(widths.len(), 4);
    assert!((widths[3] / widths[0] - 4.0).abs() < 1e-3);
    assert_eq!(sheet(&panels[1..2], 7), svg(panels[1].0, panels[1].1));
    assert!(sheet(&[], 0).is_empty());
}

/// Contours between the centres of cells on both sides of a wall went through it by up to a cell.
#[test]
fn no_colour_of_density_beyond_a_wall() {
    let wall = 0.013;
    let people = (0..6).map(|k| (pedestrian(&k.to_string()), vec2(0.1 * f64::from(k) - 0.3, -0.15), 0.0));
    for upright in [false, true] {
        let turned = |p: Vec2| if upright { vec2(p.y, p.x) } else { p };
        let t =
            trial(people.clone().collect(), vec![vec![turned(vec2(-3.0, wall)), turned(vec2(3.0, wall))]]);
        let mut scene = Scene::at_start(&t);
        let view = Bounds { low: vec2(-0.5, -0.5), high: vec2(0.5, 0.5) };
        let mut map = DensityMap::new(view, 0.3, &t.geometry.walls);
        map.add(scene.poses.iter().map(|pose| turned(pose.position)));
        (scene.view, scene.density) = (Some(view), Some(map));
        let text = svg(&scene, &Style::default());
        let document = Document::parse(&text).unwrap();
        let contours = class(&document, "density")[0].children().filter_map(|n| n.attribute("d"));
        let mut furthest = f64::NEG_INFINITY;
        for d in contours {
            for corner in d.replace('-', " -").split(['M', 'L', 'Z']).filter(|corner| !corner.is_empty()) {
                let numbers: Vec<f64> = corner.split_whitespace().map(|n| n.parse().unwrap()).collect();
                furthest = furthest.max(if upright { numbers[0] } else { numbers[1] });
            }
        }
        assert!((furthest - wall).abs() < 1e-3, "to {furthest} m, the wall is at {wall} m");
    }
}

#[test]
fn cut_panels_stand_apart() {
    let t = row(6);
    let view = Bounds { low: vec2(0.5, -0.5), high: vec2(2.5, 0.5) };
    let mut scene = Scene::at_start(&t);
    scene.view = Some(view);
    let text = sheet(&[(&scene, &Style::default()); 4], 2);
    let document = Document::parse(&text).unwrap();
    // Where each panel's clip is on the page.
    let clips: Vec<[f64; 4]> = document
        .descendants()
        .filter(|n| n.has_tag_name("svg") && n.attribute("x").is_some())
        .map(|n| ["x", "y", "width", "height"].map(|name| number(n, name)))
        .collect();
    assert_eq!(clips.len(), 4);
    let beside = clips[1][0] - (clips[0][0] + clips[0][2]);
    let below = clips[2][1] - (clips[0][1] + clips[0][3]);
    assert!(beside > 9.0 && below > 9.0, "{beside} px, {below} px");
}

#[test]
fn ids_are_of_one_size() {
    // Of one digit, of three, and one that no body has room for.
    let ids = ["1", "23", "456", "7", "the-last-one-of-the-row"];
    let people = ids.iter().enumerate().map(|(k, id)| (pedestrian(id), vec2(k as f64, 0.0), 0.0)).collect();
    let t = trial(people, vec![]);
    let mut scene = Scene::at_start(&t);
    let style = Style { ids: true, ..Style::default() };
    let sizes = |text: &str| -> Vec<String> {
        let document = Document::parse(text).unwrap();
        let [group] = class(&document, "ids")[..] else { panic!("one group") };
        let transforms = group.children().filter_map(|n| n.attribute("transform"));
        transforms.map(|t| t.split("scale(").nth(1).unwrap().to_owned()).collect()
    };
    let drawn = sizes(&svg(&scene, &style));
    assert_eq!(drawn.len(), 4);
    assert!(drawn.iter().all(|size| *size == drawn[0]), "{drawn:?}");
    assert_eq!(ids_without_room(&scene), [ids[4]]);
    // A frame of a movie in which the one that decides is not seen.
    scene.poses[2].position = vec2(f64::NAN, 0.0);
    assert_eq!(sizes(&svg(&scene, &style)), drawn[1..]);
}

#[test]
fn nothing_is_pale_and_a_clipped_scale_says_so() {
    let t = row(3);
    let scene = Scene::at_start(&t);
    let of = |of: Vec<f64>, range, quantile, theme| {
        let map = ColourMap::FromPaper;
        let fill = Fill::Values(Values { quantile, map, ..Values::of(of, "mean squeeze", "N") });
        svg(&scene, &Style { fill, range, theme, ..Style::default() })
    };
    let ends = |text: &str| {
        let document = Document::parse(text).unwrap();
        ["low", "high", "label"].map(|name| labels(&document, name).concat())
    };
    let fills = |text: &str| -> Vec<String> {
        let document = Document::parse(text).unwrap();
        let group = class(&document, "bodies")[0];
        let bodies = group.children().filter(|n| n.is_element());
        bodies.map(|n| n.attribute("fill").or(group.attribute("fill")).unwrap().to_owned()).collect()
    };
    let clipped = of(vec![0.0, 3200.0, 90_000.0], Some((0.0, 3200.0)), Some(0.98), Theme::Light);
    assert_eq!(ends(&clipped), ["0", "≥ 3200", "mean squeeze (N), to the 98 % quantile"]);
    assert_eq!(fills(&clipped), ["#fcfdbf", "#1a1042", "#1a1042"]);
    let whole = of(vec![0.0, 3200.0, f64::NAN], Some((0.0, 3200.0)), None, Theme::Dark);
    assert_eq!(ends(&whole), ["0", "3200", "mean squeeze (N)"]);
    assert_eq!(fills(&whole), ["#1a1042", "#fcfdbf", "#a8a8a8"]);
    let nobody = of(vec![0.0; 3], None, None, Theme::Light);
    assert!(fills(&nobody).iter().all(|fill| fill == "#fcfdbf"));
}

/// Where nobody was touched, a bar from 0 to 1 N stood below.
#[test]
fn words_stand_where_a_colour_bar_would_have_nothing_to_show() {
    let t = row(3);
    let scene = Scene::at_start(&t);
    let style = |of: Vec<f64>, unit: &str, range, map| {
        let fill = Fill::Values(Values { map, ..Values::of(of, "mean squeeze", unit) });
        Style { fill, range, ..Style::default() }
    };
    let shown = |text: &str| {
        let document = Document::parse(text).unwrap();
        let bar = class(&document, "colour-bar").len();
        (bar, ["low", "high", "label"].map(|name| labels(&document, name).concat()).join("|"))
    };
    for map in [ColourMap::FromPaper, ColourMap::Viridis] {
        for (values, unit, range, expected) in [
            (vec![0.0; 3], "N", None, (0, "||mean squeeze: 0 N everywhere")),
            (vec![0.0; 3], "", None, (0, "||mean squeeze: 0 everywhere")),
            (vec![f64::NAN; 3], "N", None, (0, "||mean squeeze: not known")),
            (vec![0.0, 0.5, 0.0], "N", None, (1, "0|0.5|mean squeeze (N)")),
            // A bar that was asked for.
            (vec![0.0; 3], "N", Some((0.0, 2.0)), (1, "0|2|mean squeeze (N)")),
        ] {
            let (bar, words) = shown(&svg(&scene, &style(values, unit, range, map)));
            assert_eq!((bar, words.as_str()), expected);
        }
    }
    // Beside a panel that has something to show, one without does not make its bar longer.
    let panels = |values: [f64; 2]| {
        let styles = values.map(|value| style(vec![value; 3], "N", None, ColourMap::FromPaper));
        shown(&sheet(&[(&scene, &styles[0]), (&scene, &styles[1])], 2))
    };
    assert_eq!(panels([0.0, 0.25]), (1, "0|0.25|mean squeeze (N)".into()));
    assert_eq!(panels([0.0, 0.0]), (0, "||mean squeeze: 0 N everywhere".into()));
}

#[test]
fn nothing_panics() {
    let odd = [f64::NAN, f64::NEG_INFINITY, 1e300, f64::MIN_POSITIVE, 0.0, 1e6];
    let t = row(2);
    for v in odd {
        for w in odd {
            let mut scene = Scene::at_start(&t);
            scene.forces = vec![
                Force { from: vec2(v, 0.0), to: vec2(w, 0.0), normal_force: 1.0 },
                Force { from: Vec2::ZERO, to: Vec2::ZERO, normal_force: v },
                Force { from: Vec2::ZERO, to: vec2(1.0, 0.0), normal_force: w },
            ];
            let points = vec![vec2(v, w), Vec2::ZERO, vec2(w, 1.0), vec2(0.1, v), vec2(0.2, 0.2)];
            for measured in [false, true] {
                scene.trails.push(Trail { agent: usize::MAX, measured, points: points.clone() });
                scene.trails.push(Trail { agent: 0, measured, points: vec![] });
                let style = Style { forces: Some(v), ids: true, time: Some(w), ..Style::default() };
                let text = svg(&scene, &style);
                Document::parse(&text).unwrap();
                png(&text, 64).unwrap();
            }
        }
        densities(&t, v);
    }
}

fn densities(t: &Trial, v: f64) {
    let mut scene = Scene::at_start(t);
    let view = Bounds { low: vec2(v, -1.0), high: vec2(1.0, v) };
    for view in [view, scene.extent(), Bounds { low: vec2(1.0, 1.0), high: vec2(-1.0, -1.0) }] {
        let mut map = DensityMap::new(view, v, &t.geometry.walls);
        map.add([vec2(0.5, v), Vec2::ZERO]);
        scene.density = Some(map);
        let style = |time| Style { width: v, time, range: Some((v, 1.0)), ..Style::default() };
        let text = sheet(&[(&scene, &style(Some(v))), (&scene, &style(None))], usize::MAX);
        Document::parse(&text).unwrap();
        png(&text, 64).unwrap();
    }
}
