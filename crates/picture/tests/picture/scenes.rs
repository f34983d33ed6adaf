//! Forces, trails, density and sheets in the SVG.

use crate::common::{agent, class, disk, extent, labels, number, pedestrian, row, trial};
use lemons_core::plane::{Vec2, vec2};
use lemons_core::trial::Heights;
use lemons_picture::*;
use roxmltree::{Document, Node};

fn force(from: f64, to: f64, normal_force: f64) -> DrawnForce {
    DrawnForce { from: vec2(from, 0.0), to: vec2(to, 0.0), normal_force }
}

#[test]
fn a_line_is_as_wide_as_its_force() {
    let t = row(0..4);
    let mut scene = PictureScene::at_start(&t);
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
    // The border of halos is as wide around strong forces as around weak ones.
    let halos = class(&document, "force-halos")[0].children().filter(Node::is_element);
    let borders: Vec<f64> = halos.zip(&widths).map(|(h, width)| number(h, "stroke-width") - width).collect();
    assert!(borders[0] > 0.0 && (borders[1] - borders[0]).abs() < 2e-6, "{borders:?}");
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

#[test]
fn each_kind_has_a_colour_and_a_legend() {
    let mut t = row(0..3);
    for (agent, kind) in t.agents.iter_mut().zip(["wheelchair", "child"]) {
        agent.kind = Some(kind.into());
    }
    let text =
        svg(&PictureScene::at_start(&t), &Style { fill: Fill::Kind, orientation: false, ..Style::default() });
    let document = Document::parse(&text).unwrap();
    assert_eq!(labels(&document, "entry"), ["child", "wheelchair"]);
    let samples = class(&document, "kind");
    let colours: Vec<&str> = samples.iter().map(|line| line.attribute("stroke").unwrap()).collect();
    let [bodies] = class(&document, "bodies")[..] else { panic!("one group") };
    let fills: Vec<&str> = bodies.descendants().filter_map(|body| body.attribute("fill")).collect();
    // Grey is the group's: the third one's kind is not known.
    assert_eq!(fills, ["#a8a8a8", colours[1], colours[0]]);
    assert_ne!(colours[0], colours[1]);
}

fn trail(measured: bool, points: &[(f64, f64)]) -> Trail {
    Trail { agent: 0, measured, points: points.iter().map(|(x, y)| vec2(*x, *y)).collect() }
}

#[test]
fn measured_is_dashed_and_simulated_solid() {
    let t = row(0..2);
    let mut scene = PictureScene::at_start(&t);
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
fn feet_are_seen_through_the_bodies_and_joined_to_them() {
    let t = row(0..3);
    let mut scene = PictureScene::at_start(&t);
    assert!(!svg(&scene, &Style::default()).contains("feet"));
    let high = scene.extent().high;
    // One leans far, one not at all; one is not there.
    scene.feet = vec![vec2(-0.5, 2.0), vec2(1.0, 0.0), vec2(2.0, 0.5)];
    scene.poses[0].orientation = std::f64::consts::FRAC_PI_2;
    scene.poses[2].position.x = f64::NAN;
    let text = svg(&scene, &Style::default());
    let document = Document::parse(&text).unwrap();
    // In the direction of the gaze.
    let feet = class(&document, "feet")[0].children().filter(Node::is_element);
    let places: Vec<&str> = feet.map(|one| one.attribute("transform").unwrap()).collect();
    assert_eq!(places, ["translate(-.5 2)rotate(90)", "translate(1 0)rotate(0)"]);
    assert_eq!(class(&document, "lean")[0].attribute("d"), Some("M-.5 2L0 0"));
    let at = |name: &str| text.find(&format!("class=\"{name}\"")).unwrap();
    assert!(at("bodies") < at("feet") && at("feet") < at("leans"));
    assert!(scene.extent().high.y == 2.0 && high.y < 1.0);
    // In a PDF, too.
    assert!(pdf(&text).is_ok());
}

#[test]
fn nothing_overlaps_above_a_scene() {
    // Time and legend on one page: none begins before the other ends.
    let t = row(0..5);
    let mut scene = PictureScene::at_start(&t);
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
    // Half a person where the map ends at them, and there the peak of the Gaussian.
    let mut map = DensityMap::new(Bounds { low: vec2(0.0, -3.0), high: vec2(3.0, 3.0) }, 0.5, &[]);
    map.add([Vec2::zeros()]);
    let peak = map.values().into_iter().fold(0.0, f64::max);
    assert!((peak * std::f64::consts::TAU * 0.25 - 1.0).abs() < 0.03, "{peak}");
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
    let t = row(0..3);
    let mut scene = PictureScene::at_start(&t);
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
    let t = row(0..3);
    let scenes: Vec<PictureScene> = (0..5)
        .map(|k| {
            let pose = |x: f64| Pose { position: vec2(x + f64::from(k), 0.0), orientation: 0.0 };
            let mut scene = PictureScene::new(&t, vec![pose(0.0), pose(1.0), pose(2.0)]);
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
    let panels: Vec<(&PictureScene, &Style)> = scenes.iter().zip(&styles).collect();
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
        let mut scene = PictureScene::at_start(&t);
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
    let t = row(0..6);
    let view = Bounds { low: vec2(0.5, -0.5), high: vec2(2.5, 0.5) };
    let mut scene = PictureScene::at_start(&t);
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
    let t = row(ids);
    let mut scene = PictureScene::at_start(&t);
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
fn a_clipped_scale_says_so_and_words_replace_a_bar_without_values() {
    let t = row(0..3);
    let scene = PictureScene::at_start(&t);
    let style = |values: Vec<f64>, unit: &str, range, quantile, map, theme| {
        let fill = Fill::Values(Values { quantile, map, ..Values::of(values, "mean squeeze", unit) });
        Style { fill, range, theme, ..Style::default() }
    };
    let shown = |text: &str| {
        let document = Document::parse(text).unwrap();
        let bar = class(&document, "colour-bar").len();
        let group = class(&document, "bodies")[0];
        let bodies = group.children().filter(|n| n.is_element());
        let fills = bodies.map(|n| n.attribute("fill").or(group.attribute("fill")).unwrap().to_owned());
        let words = ["low", "high", "label"].map(|name| labels(&document, name).concat()).join("|");
        (bar, words, fills.collect::<Vec<_>>())
    };
    let (low, high, missing) = ("#fcfdbf", "#1a1042", "#a8a8a8");
    let range = Some((0.0, 3200.0));
    for (values, unit, range, quantile, theme, expected) in [
        (
            vec![0.0, 3200.0, 90_000.0],
            "N",
            range,
            Some(0.98),
            Theme::Light,
            (1, "0|≥ 3200|mean squeeze (N), to the 98 % quantile", [low, high, high]),
        ),
        (
            vec![0.0, 3200.0, f64::NAN],
            "N",
            range,
            None,
            Theme::Dark,
            (1, "0|3200|mean squeeze (N)", [high, low, missing]),
        ),
        (vec![0.0; 3], "N", None, None, Theme::Light, (0, "||mean squeeze: 0 N everywhere", [low; 3])),
        (vec![0.0; 3], "", None, None, Theme::Light, (0, "||mean squeeze: 0 everywhere", [low; 3])),
        (vec![f64::NAN; 3], "N", None, None, Theme::Light, (0, "||mean squeeze: not known", [missing; 3])),
        // A bar that was asked for.
        (vec![0.0; 3], "N", range, None, Theme::Light, (1, "0|3200|mean squeeze (N)", [low; 3])),
    ] {
        for map in [ColourMap::FromPaper, ColourMap::Viridis] {
            let style = style(values.clone(), unit, range, quantile, map, theme);
            let (bar, words, fills) = shown(&svg(&scene, &style));
            assert_eq!((bar, words.as_str()), (expected.0, expected.1));
            assert!(map == ColourMap::Viridis || fills == expected.2, "{fills:?}");
        }
    }
    // All panels have one scale.
    let panels = |values: [f64; 2]| {
        let of = |value| style(vec![value; 3], "N", None, None, ColourMap::FromPaper, Theme::Light);
        let styles = values.map(of);
        shown(&sheet(&[(&scene, &styles[0]), (&scene, &styles[1])], 2))
    };
    assert_eq!(panels([0.0, 0.25]).1, "0|0.25|mean squeeze (N)");
    assert_eq!(panels([0.0, 0.0]).1, "||mean squeeze: 0 N everywhere");
}

#[test]
fn nothing_panics() {
    let odd = [f64::NAN, f64::NEG_INFINITY, 1e300, f64::MIN_POSITIVE, 0.0, 1e6];
    for (v, w) in odd.into_iter().flat_map(|v| odd.map(|w| (v, w))) {
        let wall = vec![vec![vec2(v, 0.0), Vec2::zeros()], vec![]];
        let people = [agent("", vec![disk(v, vec2(v, w))]), pedestrian("1"), pedestrian("é\u{0}<")];
        let t = trial(people.map(|agent| (agent, Vec2::zeros(), w)).to_vec(), wall);
        let mut scene = PictureScene::at_start(&t);
        let view = Bounds { low: vec2(v, -1.0), high: vec2(1.0, w) };
        let all = [view, scene.extent(), Bounds { low: vec2(1.0, 1.0), high: vec2(-1.0, -1.0) }];
        scene.poses[1] = Pose { position: vec2(v, w), orientation: v };
        scene.forces = vec![
            DrawnForce { from: vec2(v, 0.0), to: vec2(w, 0.0), normal_force: 1.0 },
            DrawnForce { from: Vec2::zeros(), to: Vec2::zeros(), normal_force: v },
        ];
        let points = vec![vec2(v, w), Vec2::zeros(), vec2(w, 1.0), vec2(0.1, v), vec2(0.2, 0.2)];
        for (k, view) in all.into_iter().enumerate() {
            scene.trails.push(Trail { agent: usize::MAX, measured: k == 1, points: points.clone() });
            scene.trails.push(Trail { agent: 0, measured: k == 2, points: vec![] });
            for (dense, range) in [(false, None), (true, Some((v, 1.0))), (false, Some((-1e308, w)))] {
                let mut map = DensityMap::new(view, v, &t.geometry.walls);
                map.add([vec2(0.5, v), Vec2::zeros()]);
                (scene.view, scene.density) = ((k != 1).then_some(view), dense.then_some(map));
                let fill = Fill::Values(Values::of(vec![v, w], "é\u{0}", "<"));
                let style = Style { width: v, ids: true, time: Some(w), fill, range, ..Style::default() };
                let others = Style { forces: Some(v), fill: Fill::BodyArea, width: 400.0, ..style.clone() };
                let text = sheet(&[(&scene, &style), (&scene, &others)], usize::MAX);
                Document::parse(&text).unwrap();
                let text = svg(&scene, &others);
                Document::parse(&text).unwrap();
                if k == 1 {
                    png(&text, 64).unwrap();
                }
            }
        }
    }
    png(&svg(&PictureScene::at_start(&trial(vec![], vec![])), &Style::default()), 64).unwrap();
}

#[test]
fn at_a_height_is_drawn_what_is_there() {
    let mut t = row(0..2);
    for shape in &mut t.agents[0].shapes {
        shape.heights = Heights { bottom: 0.5, top: 1.0 };
    }
    t.geometry.walls[0].heights.top = 1.1;
    for (height, bodies, walls) in [(None, 2, 1), (Some(0.7), 2, 1), (Some(1.05), 1, 1), (Some(1.2), 1, 0)] {
        let text = svg(&PictureScene::at_start(&t).at_height(height), &Style::default());
        let document = Document::parse(&text).unwrap();
        let drawn = |name: &str| {
            let groups = class(&document, name);
            groups.iter().flat_map(|group| group.children().filter(Node::is_element)).count()
        };
        assert_eq!((drawn("bodies"), drawn("walls")), (bodies, walls), "{height:?}");
    }
}
