//! Curves over time.
//!
//! They are drawn here and not by a plotting library: with the same stroked letters as scenes. So the bytes are the
//! same on every machine, and rasterizing needs no font.

use crate::colour::{Colour, Palette, Theme};
use crate::curve::{Piece, Range, apart, extremes, listed, shared, thinned};
use crate::glyphs::{self, END, MIDDLE, START, TextPlace};
use crate::page::{
    CAP_HEIGHT, CASING, Entry, Header, MARGIN, NOMINAL_WIDTH, Page, dashes, page_width, path, shrunk,
};
use crate::text::{PX, escaped, pair, text_of};
use std::collections::{BTreeMap, BTreeSet};

/// Size of letters and lines, relative to a scene's page.
const FINER: f64 = 0.85;
/// A chart with more lines shows a crowd: only the median and the highest line have a colour and a name.
const MOST_NAMED: usize = 8;
/// \[px\] Width of a line with a name, and of one in a crowd.
const STROKE: f64 = 1.6;
const THIN: f64 = 0.7;
/// \[px\] Distance between stepped lines that are equal.
const ASIDE: f64 = 1.7;
/// \[px\] Length of a dash of each colour where curves are equal.
const TURN: f64 = 7.0;
/// \[px\] Distance between two panels, below the tick labels of the upper one.
const PANEL_GAP: f64 = 13.0;
/// \[px\] Distance between an axis and its numbers.
const TICK_GAP: f64 = 5.0;
/// \[px\] Smallest distance between grid lines.
const GRID: (f64, f64) = (62.0, 24.0);
/// \[px\] Largest error of a drawn curve.
const TOLERANCE: f64 = 0.12;

/// A chart: panels above each other that share the x axis.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Chart {
    /// Name and unit of the x axis, such as "time (s)": below all panels.
    pub x: String,
    /// The panels, from the top down.
    pub panels: Vec<ChartPanel>,
    /// Name of what each line is of, such as "agent". It precedes the name of a line; before several names it gets an s.
    pub noun: String,
}

/// A panel with lines.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ChartPanel {
    /// Name and unit of the y axis: above the panel.
    pub y: String,
    /// Lines, in the order in which they are drawn.
    pub lines: Vec<Curve>,
    /// Whether a value holds until the next point (steps), as for counts.
    pub steps: bool,
}

/// A curve.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Curve {
    /// Name, written at its end after the chart's noun, such as an agent's Id.
    pub name: String,
    /// x and y, x increasing. Values that are not finite interrupt the curve.
    pub points: Vec<(f64, f64)>,
    /// Lines of one group have the same colour and name in all panels, such as the simulated and the measured values of
    /// an agent.
    pub group: usize,
    /// Whether the line is dashed, as for measured values; simulated values are solid.
    pub dashed: bool,
}

/// Settings of a chart. Lines and letters scale with the width.
#[derive(Debug, Clone, PartialEq)]
pub struct ChartStyle {
    /// \[px\] Width. The height follows from the panels.
    pub width: f64,
    /// Colours.
    pub theme: Theme,
    /// Height of a panel / width; `None`: chosen by the number of panels.
    pub aspect: Option<f64>,
}

impl Default for ChartStyle {
    fn default() -> ChartStyle {
        ChartStyle { width: 400.0, theme: Theme::Light, aspect: None }
    }
}

/// Returns the chart as SVG: a group `chart-panel` for each panel with its `grid` and `lines`, then `legend`.
///
/// Up to eight lines have different colours, and their names at their ends. More lines show a crowd: thin grey lines,
/// with the median of all and the line with the highest value on top. Where curves are equal, dashes of all their
/// colours alternate; those that are equal everywhere share one name. Stepped lines are drawn slightly above each other
/// instead. Measured lines are drawn last, with a border in the colour of the paper. Curves with more points than
/// pixels keep all extremes.
pub fn chart_svg(chart: &Chart, style: &ChartStyle) -> String {
    let palette = Palette::of(style.theme);
    let width = page_width(style.width);
    let unit = width / NOMINAL_WIDTH * FINER;
    let (margin, cap) = (MARGIN * unit, CAP_HEIGHT * unit);
    let lines = || chart.panels.iter().flat_map(|p| &p.lines).filter(|l| l.points.iter().any(drawable));
    let x = Range::around(lines().flat_map(|l| &l.points).filter(|p| drawable(p)).map(|p| p.0), false);

    let compared = lines().any(|l| l.dashed) && lines().any(|l| !l.dashed);
    let legend = compared.then(|| Entry::simulated_and_measured(&palette, STROKE * unit));
    let header = Header::new("", legend.into_iter().flatten().collect(), unit, width);

    let aspect = style.aspect.filter(|a| a.is_finite() && *a > 0.0).map(|a| a.clamp(0.02, 10.0));
    let tall = aspect.unwrap_or(if chart.panels.len() > 1 { 0.25 } else { 0.5 }) * width;
    let panels: Vec<PanelLayout> =
        chart.panels.iter().map(|p| PanelLayout::new(p, &chart.noun, tall, unit, &palette)).collect();
    let numbers = panels.iter().flat_map(|p| &p.ticks).map(|(_, text)| glyphs::width(text, cap));
    let left = margin + numbers.fold(0.0, f64::max) + TICK_GAP * unit;
    let names = panels.iter().flat_map(|p| &p.strokes).filter_map(|s| s.name.as_ref());
    let named = names.map(|(n, _)| glyphs::width(n, cap) + 1.3 * TICK_GAP * unit).fold(0.0, f64::max);
    // Very long names leave half of the page to the curves.
    let right = (width - margin - named).max(0.5 * width).max(left + unit);
    let x_ticks = x.ticks(((right - left) / (GRID.0 * unit)).max(1.0), false);

    let pitch = cap + 6.0 * unit + tall + PANEL_GAP * unit;
    let top = margin + header.height;
    let below = (2.0 * (CAP_HEIGHT + TICK_GAP) + 3.0) * unit;
    let count = panels.len().max(1) as f64;
    let height = (top + count * pitch - PANEL_GAP * unit + below + margin - 1e-6).ceil();

    let mut page = Page::begin(&chart.x, style.theme, unit, width, height);
    let across = |v: f64| left + x.part(v) * (right - left);
    let [left_px, right_px, hair] = [left, right, 0.8 * unit].map(|v| text_of(v, PX));
    for (k, (panel, layout)) in chart.panels.iter().zip(&panels).enumerate() {
        let above = top + k as f64 * pitch + cap + 6.0 * unit;
        let bottom = above + tall;
        let up = |v: f64| bottom - layout.y.part(v) * tall;
        page.out += "<g class=\"chart-panel\">\n";
        let rows = layout.ticks.iter().map(|(v, _)| format!("M{left_px} {}H{right_px}", text_of(up(*v), PX)));
        let [above_px, bottom_px] = [above, bottom].map(|v| text_of(v, PX));
        let column = |(v, _): &(f64, String)| format!("M{} {above_px}V{bottom_px}", text_of(across(*v), PX));
        let d: String = rows.chain(x_ticks.iter().map(column)).collect();
        page.line("grid", palette.faint, &hair, "", &d);
        let base = text_of(if layout.y.low < 0.0 && layout.y.high > 0.0 { up(0.0) } else { bottom }, PX);
        let d = format!("M{left_px} {base}H{right_px}");
        page.line("axis", palette.ink.mixed(palette.paper, 0.35), &hair, "", &d);
        for (v, text) in &layout.ticks {
            let place = page.place(left - TICK_GAP * unit, up(*v) + 0.5 * cap, END);
            page.text("tick", text, place);
        }
        let place = page.place(margin, above - 6.0 * unit, START);
        fitting(&mut page, "label", &panel.y, place, width - 2.0 * margin, palette.ink);
        page.out += "<g class=\"lines\" fill=\"none\" stroke-linejoin=\"round\">\n";
        for stroke in &layout.strokes {
            stroke.draw(&mut page, panel.steps, across, |v| up(v) - stroke.aside);
        }
        page.out += "</g>\n";
        layout.names(&mut page, (above, bottom), right, (width - margin - right).max(unit), up);
        page.out += "</g>\n";
    }
    let bottom = height - margin - below;
    for (v, text) in &x_ticks {
        page.text("tick", text, page.place(across(*v), bottom + TICK_GAP * unit + cap, MIDDLE));
    }
    let place = page.place(0.5 * (left + right), height - margin, MIDDLE);
    fitting(&mut page, "label", &chart.x, place, width - 2.0 * margin, palette.ink);
    header.draw(&mut page);
    page.end()
}

fn drawable(p: &(f64, f64)) -> bool {
    p.0.is_finite() && p.1.is_finite()
}

/// Draws text, smaller if it is longer than `room`.
fn fitting(page: &mut Page, class: &str, text: &str, place: TextPlace, room: f64, colour: Colour) {
    if !text.is_empty() {
        let shrink = shrunk(glyphs::width(text, place.cap_height), room);
        let place = TextPlace { cap_height: place.cap_height * shrink, ..place };
        page.text_of_colour(class, text, place, colour);
    }
}

/// A curve to be drawn.
struct Stroke {
    class: &'static str,
    points: Vec<(f64, f64)>,
    /// Pieces drawn in dashes with others, and pieces drawn alone; if empty, the whole curve is drawn alone.
    pieces: Vec<Piece>,
    colour: Colour,
    /// \[px\] width.
    width: f64,
    /// \[px\] Distance by which it is drawn above its place.
    aside: f64,
    opacity: f64,
    dashed: bool,
    /// Name at its end, and its colour.
    name: Option<(String, Colour)>,
    title: String,
}

/// A panel, laid out except for its place on the page.
struct PanelLayout {
    y: Range,
    ticks: Vec<(f64, String)>,
    strokes: Vec<Stroke>,
}

impl PanelLayout {
    fn new(panel: &ChartPanel, noun: &str, tall: f64, unit: f64, palette: &Palette) -> PanelLayout {
        let lines: Vec<&Curve> = panel.lines.iter().filter(|l| l.points.iter().any(drawable)).collect();
        let values = lines.iter().flat_map(|l| &l.points).filter(|p| drawable(p)).map(|p| p.1);
        let y = Range::around(values, true).airy();
        let ticks = y.ticks((tall / (GRID.1 * unit)).max(1.0), panel.steps);
        let groups: BTreeSet<usize> = lines.iter().map(|l| l.group).collect();
        let few = groups.len() <= MOST_NAMED;
        let mut strokes = if few {
            labelled(&lines, noun, unit, palette)
        } else {
            crowd(panel.steps, noun, &lines, unit, palette)
        };
        if panel.steps {
            step_aside(&mut strokes, &lines, &groups, tall / (y.high - y.low), unit);
        } else if few {
            // Curves closer than half a line's width count as equal.
            let near = 0.5 * STROKE * unit * (y.high - y.low) / tall;
            take_turns(&mut strokes, &lines, noun, near, palette);
        }
        if few {
            // Draw dashed lines last, so that solid lines do not hide them.
            strokes.sort_by_key(|stroke| stroke.dashed);
        }
        PanelLayout { y, ticks, strokes }
    }

    /// Places the names beside the ends of their curves without overlap.
    fn names<'s>(
        &'s self,
        page: &mut Page,
        (above, bottom): (f64, f64),
        right: f64,
        room: f64,
        up: impl Fn(f64) -> f64,
    ) {
        let (cap, gap) = (CAP_HEIGHT * page.unit, 1.3 * TICK_GAP * page.unit);
        let named = |s: &'s Stroke| {
            let (_, y) = s.points.iter().rev().find(|p| drawable(p))?;
            Some((up(*y) - s.aside, s.name.as_ref().filter(|(name, _)| !name.is_empty())?))
        };
        let mut names: Vec<(f64, &(String, Colour))> = self.strokes.iter().filter_map(named).collect();
        names.sort_by(|a, b| a.0.total_cmp(&b.0));
        let places: Vec<f64> = names.iter().map(|n| n.0).collect();
        let places = apart(&places, 1.5 * cap, above + 0.5 * cap, bottom - 0.5 * cap);
        for ((_, (name, colour)), y) in names.iter().zip(places) {
            let place = page.place(right + gap, y + 0.5 * cap, START);
            fitting(page, "name", name, place, (room - gap).max(page.unit), *colour);
        }
    }
}

/// Counts are often equal: each line is drawn slightly above the one before. The lines of a crowd make a band that is
/// darker where there are more of them. `tall` is one count in px.
fn step_aside(strokes: &mut [Stroke], lines: &[&Curve], groups: &BTreeSet<usize>, tall: f64, unit: f64) {
    let many = groups.len() > MOST_NAMED;
    let n = groups.len() as f64;
    let each = if many { 0.5 * tall / n } else { (ASIDE * unit).min(0.4 * tall / n) };
    for (stroke, line) in strokes.iter_mut().zip(lines) {
        let place = groups.range(..line.group).count() as f64;
        stroke.aside = each * if many { place - 0.5 * n } else { place };
    }
}

/// Where solid lines are equal, dashes of their colours alternate. Lines that are equal everywhere get one name.
fn take_turns(strokes: &mut [Stroke], lines: &[&Curve], noun: &str, near: f64, palette: &Palette) {
    let solid: Vec<usize> = (0..strokes.len()).filter(|k| !strokes[*k].dashed).collect();
    let points: Vec<&[(f64, f64)]> = solid.iter().map(|k| strokes[*k].points.as_slice()).collect();
    let (pieces, equal) = shared(&points, near);
    for (k, pieces) in solid.iter().zip(pieces) {
        strokes[*k].pieces = pieces;
    }
    for together in equal {
        let names: Vec<&str> = together.iter().map(|k| lines[solid[*k]].name.as_str()).collect();
        let name = called(noun, &names);
        let (first, rest) = (solid[together[0]], &together[1..]);
        strokes[first].name = Some((name, palette.ink));
        rest.iter().for_each(|k| strokes[solid[*k]].name = None);
    }
}

/// Such as "agent 3" or "agents 1, 2".
fn called(noun: &str, names: &[&str]) -> String {
    match (noun, names) {
        ("", _) => listed(names),
        (_, [name]) => format!("{noun} {name}"),
        _ => format!("{noun}s {}", listed(names)),
    }
}

/// Few lines: each has its colour, each group one name.
fn labelled(lines: &[&Curve], noun: &str, unit: f64, palette: &Palette) -> Vec<Stroke> {
    // A group is named beside its first solid line, if it has one.
    let is_named = |line: &Curve| {
        let first = lines.iter().filter(|l| l.group == line.group).min_by_key(|l| l.dashed);
        first.is_some_and(|first| std::ptr::eq(*first, line))
    };
    let stroke = |line: &&Curve| {
        let colour = palette.series(line.group);
        let name = is_named(line).then(|| (called(noun, &[&line.name]), colour));
        Stroke { name, ..Stroke::of(line, noun, colour, STROKE * unit) }
    };
    lines.iter().map(stroke).collect()
}

/// Many lines: all of them pale, their median, and the one with the highest value.
fn crowd(steps: bool, noun: &str, lines: &[&Curve], unit: f64, palette: &Palette) -> Vec<Stroke> {
    let opacity = (14.0 / lines.len() as f64).clamp(0.1, 0.5);
    let pale = |line: &&Curve| Stroke { opacity, ..Stroke::of(line, noun, palette.ink, THIN * unit) };
    let mut strokes: Vec<Stroke> = lines.iter().map(pale).collect();
    let all_dashed = lines.iter().all(|l| l.dashed);
    let solid: Vec<&&Curve> = lines.iter().filter(|l| all_dashed || !l.dashed).collect();
    let top = |line: &Curve| {
        let known = line.points.iter().filter(|p| drawable(p));
        known.fold(f64::NEG_INFINITY, |high, p| high.max(p.1))
    };
    let strong = |class, place, line: Curve| {
        let stroke = Stroke::of(&line, "", palette.series(place), STROKE * unit);
        Stroke { class, name: Some((line.name, stroke.colour)), dashed: false, ..stroke }
    };
    // The first of several with the same maximum.
    let highest = solid.iter().copied().reduce(|a, b| if top(b) > top(a) { b } else { a });
    if let Some(line) = highest {
        let name = format!("{} (max)", called(noun, &[&line.name]));
        strokes.push(strong("highest", 1, Curve { name, ..(**line).clone() }));
    }
    // Curves may have different x.
    let mut places: Vec<f64> = solid.iter().flat_map(|line| &line.points).map(|p| p.0).collect();
    places.sort_by(f64::total_cmp);
    places.dedup();
    let median = places.into_iter().map(|x| {
        let mut values: Vec<f64> = solid.iter().filter_map(|l| value_at(&l.points, x, steps)).collect();
        values.sort_by(f64::total_cmp);
        let middle = |half: usize| values.get(half).map_or(f64::NAN, |value| 0.5 * value);
        let upper = values.len() / 2;
        let lower = if steps { upper } else { values.len().saturating_sub(1) / 2 };
        (x, middle(lower) + middle(upper))
    });
    let median = Curve { name: "median".to_owned(), points: median.collect(), ..Curve::default() };
    strokes.push(strong("median", 0, median));
    strokes
}

/// Returns y of a curve at x, if it is known there.
fn value_at(points: &[(f64, f64)], x: f64, steps: bool) -> Option<f64> {
    let next = points.partition_point(|p| p.0 <= x || p.0.is_nan());
    let (after, before) = (points.get(next), points[..next].last().filter(|p| drawable(p))?);
    if before.0 == x || steps {
        return (before.0 == x || after.is_some()).then_some(before.1);
    }
    let after = after.filter(|p| drawable(p))?;
    let part = (x - before.0) / (after.0 - before.0);
    Some(before.1 * (1.0 - part) + after.1 * part)
}

impl Stroke {
    /// Makes a stroke without a name.
    fn of(line: &Curve, noun: &str, colour: Colour, width: f64) -> Stroke {
        let (points, dashed) = (line.points.clone(), line.dashed);
        let class = if dashed { "measured" } else { "simulated" };
        let (pieces, aside, opacity, name) = (Vec::new(), 0.0, 1.0, None);
        let title = called(noun, &[&line.name]);
        Stroke { class, points, pieces, colour, width, aside, opacity, dashed, name, title }
    }

    fn draw(&self, page: &mut Page, steps: bool, across: impl Fn(f64) -> f64, up: impl Fn(f64) -> f64) {
        let unit = page.unit;
        let curve = |d: &mut String, points: &[(f64, f64)]| {
            for piece in points.split(|p| !drawable(p)) {
                let mut on_page: Vec<(f64, f64)> = Vec::with_capacity(piece.len());
                for p in piece {
                    let (x, y) = (across(p.0), up(p.1));
                    if steps && let Some(last) = on_page.last() {
                        on_page.push((x, last.1));
                    }
                    on_page.push((x, y));
                }
                let mut kept = thinned(&extremes(&on_page, 0.5 * unit), TOLERANCE * unit);
                if let [only] = on_page[..] {
                    // A single point between gaps is a dot.
                    kept.push(only);
                }
                for (k, p) in kept.into_iter().enumerate() {
                    d.push(if k == 0 { 'M' } else { 'L' });
                    pair(d, p, PX);
                }
            }
        };
        // Pieces with the same dashes become one path.
        let mut paths: BTreeMap<(usize, usize), String> = BTreeMap::new();
        if self.pieces.is_empty() {
            curve(paths.entry((0, 1)).or_default(), &self.points);
        }
        for piece in &self.pieces {
            curve(paths.entry(piece.turn).or_default(), &piece.points);
        }
        let Stroke { class, colour, .. } = self;
        let (title, paper) = (escaped(&self.title), page.palette.paper);
        let [width, cased] = [0.0, 2.0].map(|borders| text_of(self.width + borders * CASING * unit, PX));
        let [casing, dash] = dashes(unit);
        let pale = self.opacity < 1.0;
        let opacity = format!(" stroke-opacity=\"{}\"", text_of(self.opacity, 2));
        for ((turn, of), d) in paths.iter().filter(|(_, d)| !d.is_empty()) {
            let more = if self.dashed {
                if !pale {
                    path(&mut page.out, "casing", paper, &cased, &casing, d);
                }
                dash.clone()
            } else if *of > 1 {
                let length = TURN * unit;
                let [length, rest, offset] =
                    [length, length * (of - 1) as f64, length * (of - turn) as f64].map(|v| text_of(v, PX));
                format!(" stroke-dasharray=\"{length} {rest}\" stroke-dashoffset=\"{offset}\"")
            } else {
                " stroke-linecap=\"round\"".to_owned()
            };
            let opacity = if pale { &opacity } else { "" };
            page.out += &format!(
                "<path class=\"{class}\" stroke=\"{colour}\" stroke-width=\"{width}\"{opacity}{more} d=\"{d}\"><title>{title}</title></path>\n"
            );
        }
    }
}
