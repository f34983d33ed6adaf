//! SVG -> lines. Groups are layers; the y axis is turned upwards, the lower left corner of the page is the origin.

use super::curve::{Affine, Arc};
use super::filled::parts_of;
use super::role::LayerRole;
use super::trace::Trace;
use super::{DrawnLine, Reading, Tracer, check_name};
use crate::error::{PeopleError, Result, require};
use lemons_core::plane::{Vec2, is_closed, vec2};
use lemons_core::xml::{Document, Element};
use std::collections::HashMap;
use std::path::Path;
use svgtypes::{
    Align, AspectRatio, Length, LengthUnit, PathParser, PathSegment, PointsParser, Transform, ViewBox,
};

const LARGEST: usize = 16_000_000;
const MOST_NODES: u32 = 1_000_000;
/// More elements within each other are a mistake.
const DEEPEST: usize = 100;
/// Properties of style sheets that decide which areas and holes there are.
const STYLES: [&str; 2] = ["fill-rule", "display"];
/// Elements that draw nothing where they stand.
const SILENT: [&str; 15] = [
    "defs",
    "symbol",
    "clipPath",
    "mask",
    "pattern",
    "marker",
    "metadata",
    "namedview",
    "style",
    "title",
    "desc",
    "script",
    "linearGradient",
    "radialGradient",
    "filter",
];

pub(super) fn read(bytes: &[u8], reading: &Reading) -> Result<Tracer> {
    require(bytes.len() <= LARGEST, || {
        format!("is larger than {} MB, the limit of SVG", LARGEST / 1_000_000)
    })?;
    let document = Document::parse(Path::new(""), bytes, MOST_NODES).map_err(from_error)?;
    let root = document.root("svg").map_err(from_error)?;
    let mut tracer = Tracer::new(Tracer::unit_of(reading, None), reading);
    let into = tracer.scale().after(&upright(root)?);
    let mut by_id = HashMap::new();
    let mut below = vec![root];
    while let Some(element) = below.pop() {
        below.extend(element.elements());
        if let Some(id) = element.optional("id") {
            by_id.insert(id, element);
        }
    }
    let viewport = match view_box(root)? {
        Some(ViewBox { w, h, .. }) => Some(vec2(w, h)),
        None => {
            let side = |attribute: &str| extent(root, attribute, None).ok().flatten();
            side("width").zip(side("height")).map(|(w, h)| vec2(w, h))
        }
    };
    let mut walk = Walk { tracer: &mut tracer, by_id, viewport, of_parts: 0 };
    for element in root.elements() {
        walk.element(element, &into, Layer { name: "", role: None, filled: Filled::BLACK }, 0)?;
    }
    Ok(tracer)
}

fn from_error(error: impl ToString) -> PeopleError {
    PeopleError::new(error.to_string())
}

/// Returns the map from the page's coordinates to those with y upwards.
fn upright(root: Element) -> Result<Affine> {
    let (x, low) = match view_box(root)? {
        Some(ViewBox { x, y, h, .. }) => (x, y + h),
        None if root.optional("height").is_some_and(|height| !height.contains('%')) => {
            (0.0, length(root, "height", 0.0)?)
        }
        None => (0.0, 0.0),
    };
    Ok(Affine::new([1.0, 0.0, 0.0, -1.0, -x, low]))
}

fn view_box(element: Element) -> Result<Option<ViewBox>> {
    let Some(text) = element.optional("viewBox") else { return Ok(None) };
    let words = text.split(|c: char| c.is_whitespace() || c == ',').filter(|word| !word.is_empty());
    let all: Option<Vec<f64>> = words.map(|word| word.parse().ok().filter(|x: &f64| x.is_finite())).collect();
    match all.as_deref() {
        Some(&[x, y, w, h]) => Ok(Some(ViewBox { x, y, w, h })),
        _ => Err(from_error(element.wrong("viewBox", "must be four numbers"))),
    }
}

/// Returns a length in user units, also of the share of a whole; none where the element does not say it.
fn extent(element: Element, attribute: &str, whole: Option<f64>) -> Result<Option<f64>> {
    match element.optional(attribute).map(str::trim) {
        None | Some("auto") => Ok(None),
        Some(text) => match text.strip_suffix('%') {
            Some(share) => {
                let share: Option<f64> = share.parse().ok().filter(|share: &f64| share.is_finite());
                let share = share.ok_or_else(|| from_error(element.wrong(attribute, "must be a length")))?;
                Ok(whole.map(|whole| whole * share / 100.0))
            }
            None => Ok(Some(length(element, attribute, 0.0)?)),
        },
    }
}

/// Returns the map from a view box into a rectangle at the origin of this size.
fn fitted(element: Element, view: ViewBox, size: Vec2) -> Result<Affine> {
    let how = element.optional("preserveAspectRatio").unwrap_or("xMidYMid");
    let AspectRatio { align, slice, .. } = how
        .parse()
        .map_err(|_| from_error(element.wrong("preserveAspectRatio", "must be as xMidYMid meet")))?;
    let each = vec2(size.x / view.w, size.y / view.h);
    let both = if slice { each.x.max(each.y) } else { each.x.min(each.y) };
    let (scale, [x, y]) = match align {
        Align::None => (each, [0.0, 0.0]),
        Align::XMinYMin => (vec2(both, both), [0.0, 0.0]),
        Align::XMidYMin => (vec2(both, both), [0.5, 0.0]),
        Align::XMaxYMin => (vec2(both, both), [1.0, 0.0]),
        Align::XMinYMid => (vec2(both, both), [0.0, 0.5]),
        Align::XMidYMid => (vec2(both, both), [0.5, 0.5]),
        Align::XMaxYMid => (vec2(both, both), [1.0, 0.5]),
        Align::XMinYMax => (vec2(both, both), [0.0, 1.0]),
        Align::XMidYMax => (vec2(both, both), [0.5, 1.0]),
        Align::XMaxYMax => (vec2(both, both), [1.0, 1.0]),
    };
    let shift = vec2(
        (size.x - scale.x * view.w) * x - scale.x * view.x,
        (size.y - scale.y * view.h) * y - scale.y * view.y,
    );
    Ok(Affine::new([scale.x, 0.0, 0.0, scale.y, shift.x, shift.y]))
}

/// Returns a length in user units: 96 of them are an inch.
fn length(element: Element, attribute: &str, otherwise: f64) -> Result<f64> {
    let Some(text) = element.optional(attribute) else { return Ok(otherwise) };
    let wrong = |must: &str| from_error(element.wrong(attribute, must));
    let Length { number, unit } = text.trim().parse().map_err(|_| wrong("must be a length"))?;
    let scale = match unit {
        LengthUnit::None | LengthUnit::Px => 1.0,
        LengthUnit::In => 96.0,
        LengthUnit::Cm => 96.0 / 2.54,
        LengthUnit::Mm => 96.0 / 25.4,
        LengthUnit::Pt => 96.0 / 72.0,
        LengthUnit::Pc => 16.0,
        LengthUnit::Em | LengthUnit::Ex | LengthUnit::Percent => {
            return Err(wrong("must be a number, or a length in px, mm, cm, in, pt or pc"));
        }
    };
    if number.is_finite() { Ok(number * scale) } else { Err(wrong("must be finite")) }
}

/// Names of an element, or of groups around it.
#[derive(Clone, Copy)]
struct Layer<'a> {
    name: &'a str,
    /// Role by its name.
    role: Option<LayerRole>,
    filled: Filled,
}

/// How what is inside of a path is drawn. Groups say each by itself.
#[derive(Clone, Copy)]
struct Filled {
    none: bool,
    /// Whether parts of a path within its parts are holes, wherever they go round.
    even_odd: bool,
}

impl Filled {
    const BLACK: Filled = Filled { none: false, even_odd: false };

    /// As an element in this one says it.
    fn within(self, element: Element) -> Filled {
        let style = element.optional("style").unwrap_or("");
        let styled = |name: &str| {
            let mut parts = style.rsplit(';').filter_map(|part| part.split_once(':'));
            let (_, value) = parts.find(|(key, _)| key.trim() == name)?;
            Some(value.trim().trim_end_matches("!important").trim_end())
        };
        let style = |name: &str| styled(name).or(element.optional(name).map(str::trim));
        let none = match style("fill") {
            None | Some("inherit") => self.none,
            Some(paint) => paint == "none",
        };
        let even_odd = match style("fill-rule") {
            Some("evenodd") => true,
            Some("nonzero") => false,
            _ => self.even_odd,
        };
        Filled { none, even_odd }
    }

    /// Of what is not filled, all lines are seen.
    fn has_holes(self) -> bool {
        self.none || self.even_odd
    }
}

impl<'a> Layer<'a> {
    fn within(self, element: Element<'a>) -> Layer<'a> {
        let label =
            element.attributes().find(|attribute| attribute.name() == "label").map(|label| label.value());
        let names = label.into_iter().chain(element.optional("id"));
        let mut names = names.chain(element.optional("class").into_iter().flat_map(str::split_whitespace));
        let filled = self.filled.within(element);
        let with_role = names.clone().find_map(|name| Some((name, LayerRole::of_name(name)?.0)));
        if let Some((name, role)) = with_role {
            return Layer { name, role: Some(role), filled };
        }
        let is_group = element.name() == "g";
        match names.next() {
            Some(name) if is_group && self.role.is_none() => Layer { name, role: None, filled },
            _ => Layer { filled, ..self },
        }
    }

    /// Whether filling closes what is not closed. Exits may be lines, though nobody says that they are not filled.
    fn closes(self) -> bool {
        !self.filled.none
            && matches!(
                self.role,
                Some(LayerRole::WalkableArea | LayerRole::Obstacle | LayerRole::Distribution)
            )
    }
}

struct Walk<'a, 't> {
    tracer: &'t mut Tracer,
    by_id: HashMap<&'a str, Element<'a>>,
    /// Width and height in user units, where they are known: what per cent are of.
    viewport: Option<Vec2>,
    /// Number of corners of paths of several parts.
    of_parts: usize,
}

impl<'a> Walk<'a, '_> {
    fn element(&mut self, element: Element<'a>, into: &Affine, layer: Layer<'a>, depth: usize) -> Result<()> {
        self.tracer.look(element.attributes().map(|attribute| 1 + attribute.value().len()).sum())?;
        let kind = element.name();
        require(depth < DEEPEST, || {
            format!("line {}: <{kind}> is within more than {DEEPEST} elements", element.line())
        })?;
        if kind == "style" && element.texts().any(|(text, _)| STYLES.iter().any(|name| text.contains(name))) {
            self.tracer.leave_out("", "<style> with fill-rule or display (not read)");
        }
        if SILENT.contains(&kind) {
            return Ok(());
        }
        let layer = layer.within(element);
        let names = [kind, layer.name, element.optional("id").unwrap_or("")];
        names.iter().try_for_each(|name| check_name(name)).map_err(|error| placed(element, error))?;
        let style: String = element.optional("style").unwrap_or("").split_whitespace().collect();
        if element.optional("display") == Some("none") || style.split(';').any(|part| part == "display:none")
        {
            self.tracer.leave_out(layer.name, &format!("<{kind}> (hidden)"));
            return Ok(());
        }
        let into = match element.optional("transform") {
            Some(text) => into.after(&transform(text).ok_or_else(|| {
                from_error(element.wrong("transform", "must be a list of finite transforms"))
            })?),
            None => *into,
        };
        match kind {
            "g" | "a" | "switch" => {
                element.elements().try_for_each(|inner| self.element(inner, &into, layer, depth + 1))
            }
            "use" => self.again(element, &into, layer, depth),
            "svg" => self.framed([element, element], &into, layer, depth),
            _ => self.shape(element, &into, layer),
        }
    }

    /// Takes what a `<use>` draws again.
    fn again(&mut self, element: Element<'a>, into: &Affine, layer: Layer<'a>, depth: usize) -> Result<()> {
        let href =
            element.attributes().find(|attribute| attribute.name() == "href").map_or("", |href| href.value());
        let Some(of) = href.strip_prefix('#').and_then(|id| self.by_id.get(id)).copied() else {
            self.tracer.leave_out(layer.name, "<use> of what is not in the file");
            return Ok(());
        };
        let into = into.after(&Affine::shift(vec2(length(element, "x", 0.0)?, length(element, "y", 0.0)?)));
        if matches!(of.name(), "symbol" | "svg") {
            return self.framed([element, of], &into, layer.within(of), depth);
        }
        self.element(of, &into, layer, depth + 1)
    }

    /// Takes what is in a `<symbol>` or an inner `<svg>`, which has coordinates of its own. The first of both elements
    /// that says its width, or its height, gives the size.
    fn framed(&mut self, by: [Element<'a>; 2], into: &Affine, layer: Layer<'a>, depth: usize) -> Result<()> {
        let [first, of] = by;
        let whole = self.viewport;
        let size = |attribute: &str, whole: Option<f64>| -> Result<Option<f64>> {
            let own = extent(first, attribute, whole)?;
            Ok(if own.is_some() { own } else { extent(of, attribute, whole)? }.or(whole))
        };
        let width = size("width", whole.map(|whole| whole.x))?;
        let height = size("height", whole.map(|whole| whole.y))?;
        let place = match of.name() {
            "svg" => vec2(length(of, "x", 0.0)?, length(of, "y", 0.0)?),
            _ => Vec2::zeros(),
        };
        let mut into = into.after(&Affine::shift(place));
        let size = width.zip(height).map(|(width, height)| vec2(width, height));
        if size.is_some_and(|size| size.x <= 0.0 || size.y <= 0.0) {
            return Ok(());
        }
        let view = view_box(of)?;
        if let Some(view) = view {
            if view.w <= 0.0 || view.h <= 0.0 {
                return Ok(());
            }
            into = into.after(&fitted(of, view, size.unwrap_or(vec2(view.w, view.h)))?);
        }
        let inner = view.map(|view| vec2(view.w, view.h)).or(size);
        let before = std::mem::replace(&mut self.viewport, inner);
        let done = of.elements().try_for_each(|inner| self.element(inner, &into, layer, depth + 1));
        self.viewport = before;
        done
    }

    fn shape(&mut self, element: Element<'a>, into: &Affine, layer: Layer<'a>) -> Result<()> {
        let mut trace = Trace {
            into,
            deviation: self.tracer.deviation,
            lines: Vec::new(),
            last: Vec2::zeros(),
            curved: false,
            corners: 0,
        };
        let kind = element.name();
        let number = |attribute: &str| length(element, attribute, 0.0);
        match kind {
            "line" => {
                trace.begin(vec2(number("x1")?, number("y1")?));
                trace.to(vec2(number("x2")?, number("y2")?))?;
            }
            "polyline" | "polygon" => points(element, &mut trace)?,
            "rect" => rectangle(element, &mut trace)?,
            "circle" | "ellipse" => {
                let centre = vec2(number("cx")?, number("cy")?);
                let r = length(element, "r", 0.0)?;
                let radii = vec2(length(element, "rx", r)?, length(element, "ry", r)?);
                let arc = Arc { u: vec2(radii.x, 0.0), v: vec2(0.0, radii.y), ..Arc::circle(centre, 1.0) };
                trace.begin(centre + arc.u);
                trace.arc(&arc).map_err(|error| placed(element, error))?;
                trace.close();
            }
            "path" => path(element, &mut trace)?,
            _ => {
                self.tracer.leave_out(layer.name, &format!("<{kind}>"));
                return Ok(());
            }
        }
        let Trace { lines, curved, .. } = trace;
        self.tracer.curves += usize::from(curved);
        let lines = lines.into_iter().filter(|(corners, _)| corners.len() > 1);
        let lines = lines.map(|(corners, closed)| {
            let returns = || layer.role.is_some() && is_closed(&corners);
            let closed = closed || layer.closes() && corners.len() > 2 || returns();
            (corners, closed)
        });
        let lines: Vec<(Vec<Vec2>, bool, bool)> = if kind == "path" && layer.role.is_some() {
            parts_of(lines.collect(), layer.filled.has_holes(), &mut self.of_parts)
                .map_err(|error| placed(element, error))?
        } else {
            lines.map(|(corners, closed)| (corners, closed, false)).collect()
        };
        for (corners, closed, hole) in lines {
            let id = element.optional("id").map(str::to_owned);
            let entity = format!("<{kind}> in line {}", element.line());
            let layer = layer.name.to_owned();
            let role = LayerRole::of_name(&layer);
            let name = id.filter(|id| *id != layer && layer.is_empty());
            let line = DrawnLine { layer, role, name, entity, corners, closed, hole, ground: false };
            self.tracer.take(line)?;
        }
        Ok(())
    }
}

fn placed(element: Element, error: PeopleError) -> PeopleError {
    from_error(element.problem(error.to_string()))
}

fn transform(text: &str) -> Option<Affine> {
    let Transform { a, b, c, d, e, f } = text.parse().ok()?;
    let numbers = [a, b, c, d, e, f];
    numbers.iter().all(|number| number.is_finite()).then(|| Affine::new(numbers))
}

fn points(element: Element, trace: &mut Trace) -> Result<()> {
    let text = element.optional("points").unwrap_or("");
    let mut points = PointsParser::from(text).map(|(x, y)| vec2(x, y));
    let Some(first) = points.next() else { return Ok(()) };
    trace.begin(first);
    points.try_for_each(|point| trace.to(point)).map_err(|error| placed(element, error))?;
    if element.name() == "polygon" {
        trace.close();
    }
    Ok(())
}

fn rectangle(element: Element, trace: &mut Trace) -> Result<()> {
    let number = |attribute: &str| length(element, attribute, 0.0);
    let (low, size) = (vec2(number("x")?, number("y")?), vec2(number("width")?, number("height")?));
    if size.x <= 0.0 || size.y <= 0.0 {
        return Ok(());
    }
    let rx = length(element, "rx", length(element, "ry", 0.0)?)?.clamp(0.0, 0.5 * size.x);
    let ry = length(element, "ry", rx)?.clamp(0.0, 0.5 * size.y);
    let high = low + size;
    trace.begin(vec2(low.x + rx, low.y));
    let corner = |trace: &mut Trace, from: Vec2, to: Vec2| {
        let arc = trace.to(from).and_then(|()| trace.by_ends(to, vec2(rx, ry), 0.0, false, true));
        arc.map_err(|error| placed(element, error))
    };
    corner(trace, vec2(high.x - rx, low.y), vec2(high.x, low.y + ry))?;
    corner(trace, vec2(high.x, high.y - ry), vec2(high.x - rx, high.y))?;
    corner(trace, vec2(low.x + rx, high.y), vec2(low.x, high.y - ry))?;
    corner(trace, vec2(low.x, low.y + ry), vec2(low.x + rx, low.y))?;
    trace.close();
    Ok(())
}

fn path(element: Element, trace: &mut Trace) -> Result<()> {
    use PathSegment::*;
    let (mut at, mut begin) = (Vec2::zeros(), Vec2::zeros());
    // What smooth curves continue: the control point before, of a cubic or of a quadratic one.
    let (mut cubic, mut quadratic) = (None, None);
    let mut is_open = false;
    for segment in PathParser::from(element.optional("d").unwrap_or("")) {
        let segment =
            segment.map_err(|error| from_error(element.wrong("d", format!("is not a path: {error}"))))?;
        let origin = if segment.is_abs() { Vec2::zeros() } else { at };
        let place = |x: f64, y: f64| origin + vec2(x, y);
        if !is_open && !matches!(segment, MoveTo { .. } | ClosePath { .. }) {
            trace.begin(at);
            (begin, is_open) = (at, true);
        }
        let (before_cubic, before_quadratic) = (std::mem::take(&mut cubic), std::mem::take(&mut quadratic));
        let mirrored = |control: Option<Vec2>| control.map_or(at, |control| at * 2.0 - control);
        let traced = match segment {
            MoveTo { x, y, .. } => {
                at = place(x, y);
                trace.begin(at);
                (begin, is_open) = (at, true);
                continue;
            }
            ClosePath { .. } => {
                if is_open {
                    trace.close();
                }
                (at, is_open) = (begin, false);
                continue;
            }
            LineTo { x, y, .. } => trace.line(&mut at, place(x, y)),
            HorizontalLineTo { x, .. } => {
                let to = vec2(origin.x + x, at.y);
                trace.line(&mut at, to)
            }
            VerticalLineTo { y, .. } => {
                let to = vec2(at.x, origin.y + y);
                trace.line(&mut at, to)
            }
            CurveTo { x1, y1, x2, y2, x, y, .. } => {
                cubic = Some(place(x2, y2));
                trace.bezier(&mut at, &[place(x1, y1), place(x2, y2), place(x, y)])
            }
            SmoothCurveTo { x2, y2, x, y, .. } => {
                cubic = Some(place(x2, y2));
                let first = mirrored(before_cubic);
                trace.bezier(&mut at, &[first, place(x2, y2), place(x, y)])
            }
            Quadratic { x1, y1, x, y, .. } => {
                quadratic = Some(place(x1, y1));
                trace.bezier(&mut at, &[place(x1, y1), place(x, y)])
            }
            SmoothQuadratic { x, y, .. } => {
                let control = mirrored(before_quadratic);
                quadratic = Some(control);
                trace.bezier(&mut at, &[control, place(x, y)])
            }
            EllipticalArc { rx, ry, x_axis_rotation, large_arc, sweep, x, y, .. } => {
                at = place(x, y);
                trace.by_ends(at, vec2(rx, ry), x_axis_rotation, large_arc, sweep)
            }
        };
        traced.map_err(|error| placed(element, error))?;
    }
    Ok(())
}
