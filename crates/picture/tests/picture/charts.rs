//! Elements of the charts.

use crate::common::{self, extent, labels};
use lemons_picture::*;
use roxmltree::{Document, Node};

fn line(group: usize, dashed: bool, points: Vec<(f64, f64)>) -> Curve {
    Curve { name: group.to_string(), points, group, dashed }
}

fn one_panel(lines: Vec<Curve>, steps: bool) -> Chart {
    Chart {
        x: "time (s)".into(),
        panels: vec![ChartPanel { y: "speed (m/s)".into(), lines, steps }],
        noun: "agent".into(),
    }
}

fn drawn(chart: &Chart) -> String {
    chart_svg(chart, &ChartStyle::default())
}

fn paths<'a>(document: &'a Document<'a>, class: &str) -> Vec<Node<'a, 'a>> {
    let lines = common::class(document, "lines").into_iter().flat_map(|g| g.children());
    lines.filter(|n| n.attribute("class") == Some(class)).collect()
}

/// The corners of a path of M and L.
fn corners(path: Node) -> Vec<(f64, f64)> {
    let d = path.attribute("d").unwrap().replace('-', " -");
    let corner = |p: &str| {
        let n: Vec<f64> = p.split_whitespace().map(|n| n.parse().unwrap()).collect();
        (n[0], n[1])
    };
    d.split(['M', 'L']).skip(1).map(corner).collect()
}

#[test]
fn axes_lines_and_names() {
    let ramp = |k: f64| (0..=10).map(|t| (f64::from(t), k * f64::from(t) / 10.0)).collect();
    let text = drawn(&one_panel(
        vec![line(0, false, ramp(0.9)), line(0, true, ramp(1.0)), line(1, false, ramp(0.5))],
        false,
    ));
    let document = Document::parse(&text).unwrap();
    assert_eq!(labels(&document, "label"), ["speed (m/s)", "time (s)"]);
    assert_eq!(labels(&document, "entry"), ["simulated", "measured"]);
    assert_eq!(labels(&document, "name"), ["agent 0", "agent 1"]);
    let ticks = labels(&document, "tick");
    assert_eq!(ticks[..3], ["0", "0.2", "0.4"]);
    assert_eq!(ticks[ticks.len() - 3..], ["6", "8", "10"]);
    let (solid, dashed) = (paths(&document, "simulated"), paths(&document, "measured"));
    assert_eq!((solid.len(), dashed.len()), (2, 1));
    assert!(
        solid[0].attribute("stroke-dasharray").is_none() && dashed[0].attribute("stroke-dasharray").is_some()
    );
    assert_eq!(solid[0].attribute("stroke"), dashed[0].attribute("stroke"));
    assert_ne!(solid[0].attribute("stroke"), solid[1].attribute("stroke"));
    // A straight line is its two ends, whatever the number of points.
    assert_eq!(corners(solid[0]).len(), 2);
    png(&text, 400).unwrap();
}

#[test]
fn a_gap_and_steps() {
    let nan = f64::NAN;
    let points = vec![(0.0, 1.0), (1.0, 2.0), (2.0, nan), (3.0, 1.0), (4.0, 3.0)];
    let text = drawn(&one_panel(vec![line(0, false, points.clone())], false));
    let document = Document::parse(&text).unwrap();
    assert_eq!(paths(&document, "simulated")[0].attribute("d").unwrap().matches('M').count(), 2);
    let text = drawn(&one_panel(vec![line(0, false, points)], true));
    let document = Document::parse(&text).unwrap();
    let corners = corners(paths(&document, "simulated")[0]);
    assert_eq!(corners.len(), 6);
    assert!(corners[0].1 == corners[1].1 && corners[1].0 == corners[2].0 && corners[4].0 == corners[5].0);
    assert_eq!(labels(&document, "tick")[..4], ["0", "1", "2", "3"]);
}

#[test]
fn no_extreme_is_lost() {
    // A million points, two of them far out for one sample each.
    let mut points: Vec<(f64, f64)> =
        (0..1_000_000).map(|k| (f64::from(k) * 1e-5, (f64::from(k) * 0.01).sin() * 0.1)).collect();
    points[333_333].1 = 5.0;
    points[777_777].1 = -3.0;
    let text = drawn(&one_panel(vec![line(0, false, points)], false));
    assert!(text.len() < 80_000, "{}", text.len());
    let document = Document::parse(&text).unwrap();
    let kept = corners(paths(&document, "simulated")[0]);
    let high = kept.iter().copied().reduce(|a, b| if b.1 < a.1 { b } else { a }).unwrap();
    let low = kept.iter().copied().reduce(|a, b| if b.1 > a.1 { b } else { a }).unwrap();
    let (first, last) = (kept[0], kept[kept.len() - 1]);
    let part = |x: f64| (x - first.0) / (last.0 - first.0);
    assert!((part(high.0) - 0.3333).abs() < 0.002 && (part(low.0) - 0.7778).abs() < 0.002);
    // 8 of the axis from 5 to −3: the panel is half as high as it is wide, with 5 % of air above and below.
    let expected = 0.5 * 400.0 * 8.0 / (1.1 * 8.0);
    assert!((low.1 - high.1 - expected).abs() < 0.5, "{} {expected}", low.1 - high.1);
}

#[test]
fn a_crowd_has_a_median_and_a_highest() {
    // Lines k·t of 101 agents: the median is 50·t, the highest 100·t.
    let of = |k: usize| line(k, false, (0..=20).map(|t| (f64::from(t), k as f64 * f64::from(t))).collect());
    let text = drawn(&one_panel((0..101).map(of).collect(), false));
    let document = Document::parse(&text).unwrap();
    assert_eq!(paths(&document, "simulated").len(), 101);
    assert_eq!(labels(&document, "name"), ["agent 100 (max)", "median"]);
    let height = |class: &str| {
        let c = corners(paths(&document, class)[0]);
        c[0].1 - c[c.len() - 1].1
    };
    assert!((height("median") / height("highest") - 0.5).abs() < 0.01);
    // The same lines at x of their own.
    let own = |k: usize| {
        let x = [0.0, 1.0 + 0.1 * k as f64, 20.0];
        line(k, false, x.map(|x| (x, k as f64 * x)).to_vec())
    };
    let text = drawn(&one_panel((0..101).map(own).collect(), false));
    let points = corners(paths(&Document::parse(&text).unwrap(), "median")[0]);
    assert_eq!(points.len(), 2, "{points:?}");
    let opacity: f64 = paths(&document, "simulated")[0].attribute("stroke-opacity").unwrap().parse().unwrap();
    assert!(opacity < 0.3);
    // Eight still have names.
    let text = drawn(&one_panel((0..8).map(of).collect(), false));
    assert_eq!(labels(&Document::parse(&text).unwrap(), "name").len(), 8);
}

#[test]
fn names_stand_apart() {
    let flat = |k: usize| line(k, false, vec![(0.0, 1.0), (1.0, 1.0 + 0.001 * k as f64)]);
    for n in 2..=8 {
        let text = drawn(&one_panel((0..n).map(flat).collect(), false));
        let document = Document::parse(&text).unwrap();
        let names: Vec<_> =
            common::class(&document, "name").into_iter().map(|n| extent(n.attribute("d").unwrap())).collect();
        assert_eq!(names.len(), n);
        assert!(names.windows(2).all(|w| w[1].2 > w[0].3), "{names:?}");
    }
}

#[test]
fn a_long_name_leaves_the_margin_free() {
    let long = Curve { name: "wide ".repeat(40), ..line(0, false, vec![(0.0, 0.0), (1.0, 1.0)]) };
    let text = drawn(&one_panel(vec![long], false));
    let document = Document::parse(&text).unwrap();
    let of = |class: &str| extent(common::class(&document, class)[0].attribute("d").unwrap());
    let page = common::number(document.root_element(), "width");
    // That on the left, where the label of the panel begins; letters have space before and after them.
    assert!((page - of("name").1 - of("label").0).abs() < 1.5, "{page} {:?} {:?}", of("name"), of("label"));
}

#[test]
fn equal_curves_have_one_name_and_show_all_their_colours() {
    let ramp = |k: f64| (0..=100).map(|t| (f64::from(t), k * f64::from(t))).collect::<Vec<_>>();
    // 1 and 2 are equal, 4 is until half of the time.
    let half = |t: f64| if t <= 50.0 { t } else { 150.0 - t };
    let lines = vec![
        line(0, false, ramp(0.5)),
        line(1, false, ramp(1.0)),
        line(2, false, ramp(1.0)),
        line(4, false, (0..=100).map(|t| (f64::from(t), half(f64::from(t)))).collect()),
    ];
    let text = drawn(&one_panel(lines, false));
    let document = Document::parse(&text).unwrap();
    let mut names = labels(&document, "name");
    names.sort_unstable();
    assert_eq!(names, ["agent 0", "agent 4", "agents 1, 2"], "equal in part is not equal");
    // Of three, then of two that are equal.
    let of = |group: usize| {
        let title = |n: &Node| n.children().any(|title| title.text() == Some(&format!("agent {group}")));
        paths(&document, "simulated").into_iter().filter(title).collect::<Vec<_>>()
    };
    let dashes = |n: &Node| {
        let number = |name| n.attribute(name).unwrap().split(' ').next().unwrap().parse::<f64>().unwrap();
        (number("stroke-dasharray"), number("stroke-dashoffset"))
    };
    let (one, two) = (of(1), of(2));
    assert_eq!((of(0).len(), one.len(), two.len(), of(4).len()), (1, 2, 2, 2));
    assert!(of(0)[0].attribute("stroke-dasharray").is_none());
    for (a, b) in one.iter().zip(&two) {
        let ([length, from], [same, to]) = (<[f64; 2]>::from(dashes(a)), <[f64; 2]>::from(dashes(b)));
        assert!(length == same && (from - to - length).abs() < 0.02, "{from} {to} {length}");
        assert_eq!(a.attribute("d"), b.attribute("d"));
        assert_ne!(a.attribute("stroke"), b.attribute("stroke"));
    }
    // Many are a range.
    let all = (0..6).map(|k| line(k, false, ramp(1.0))).collect();
    let text = drawn(&one_panel(all, false));
    assert_eq!(labels(&Document::parse(&text).unwrap(), "name"), ["agents 0–5"]);
}

#[test]
fn curves_of_different_lengths_are_drawn_whole() {
    let ramp = |last: i32| (0..=last).map(|t| (f64::from(t), f64::from(t))).collect();
    let text = drawn(&one_panel(vec![line(0, false, ramp(3)), line(1, false, ramp(10))], false));
    let document = Document::parse(&text).unwrap();
    let ends: Vec<f64> =
        paths(&document, "simulated").into_iter().map(|path| corners(path).last().unwrap().0).collect();
    assert_eq!(ends.len(), 2);
    assert!(ends[0] < 0.5 * ends[1], "{ends:?}");
}

#[test]
fn what_is_measured_is_seen_on_an_equal_simulated_curve() {
    let ramp: Vec<_> = (0..=10).map(|t| (f64::from(t), f64::from(t))).collect();
    let lines = vec![line(0, true, ramp.clone()), line(0, false, ramp.clone()), line(1, false, ramp)];
    let text = drawn(&one_panel(lines, false));
    let document = Document::parse(&text).unwrap();
    let lines = common::class(&document, "lines")[0].children().filter(|n| n.has_tag_name("path"));
    let lines: Vec<_> = lines.collect();
    assert_eq!(
        lines.iter().map(|n| n.attribute("class").unwrap()).collect::<Vec<_>>(),
        ["simulated", "simulated", "casing", "measured"]
    );
    // Beside the dashes there is paper, and the solid line between.
    assert_eq!(lines[2].attribute("stroke"), Some("#ffffff"));
    let dashes = |n: &Node| -> (f64, f64) {
        let (dash, gap) = n.attribute("stroke-dasharray").unwrap().split_once(' ').unwrap();
        (dash.parse().unwrap(), gap.parse().unwrap())
    };
    let (around, own) = (dashes(&lines[2]), dashes(&lines[3]));
    assert!(around.0 > own.0 + 1.0 && around.1 > 1.0 && (around.0 + around.1 - own.0 - own.1).abs() < 0.02);
}

#[test]
fn nothing_panics() {
    let odd = [f64::NAN, f64::INFINITY, -1e308, 1e-308, 0.0, 1e16 + 2.0];
    for a in odd {
        for b in odd {
            for steps in [false, true] {
                for n in [0, 1, 12] {
                    let of = |k: usize| {
                        line(k, k % 2 == 1, vec![(0.0, a), (a, b), (b, 1.0), (2.0, 0.0), (1.0, b)])
                    };
                    let mut chart = one_panel((0..n).map(of).collect(), steps);
                    chart.panels.push(ChartPanel::default());
                    chart.panels[0].y = "é\u{0}<".repeat(40);
                    let style = ChartStyle { width: a, theme: Theme::Dark, aspect: Some(b) };
                    let text = chart_svg(&chart, &style);
                    Document::parse(&text).unwrap();
                    let bad = text.find("NaN").or_else(|| text.find("inf"));
                    assert!(bad.is_none(), "{a:e} {b:e} {n}: {}", &text[bad.unwrap()..][..200]);
                    if n == 12 {
                        png(&text, 48).unwrap();
                    }
                }
            }
        }
    }
    png(&drawn(&Chart::default()), 64).unwrap();
}
