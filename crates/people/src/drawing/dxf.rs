//! DXF as text -> lines. The file is a list of pairs, each a group code and a value on a line of its own.

use super::curve::{Affine, Arc, Spline, sweep};
use super::{Line, MOST_LETTERS, Reading, Role, Tracer, UnitFrom, check_name};
use crate::error::{PeopleError, Result, require};
use lemons_core::plane::{InPlane, Vec2, vec2};
use std::borrow::Cow;
use std::collections::{HashMap, HashSet};

/// More pairs are a mistake: each takes 32 bytes of memory.
const MOST_PAIRS: usize = 8_000_000;
/// More blocks within each other are a circle.
const DEEPEST: usize = 16;
/// Flags of a block that is an external reference, or lies over one.
const EXTERNAL: i64 = 4 | 8;

/// A group code with its value.
struct Pair<'a> {
    code: i32,
    value: &'a str,
    /// Of the value.
    line: u32,
}

/// Pairs that begin with one of code 0.
#[derive(Clone, Copy)]
struct Entity<'a>(&'a [Pair<'a>]);

#[derive(Default)]
struct Block<'a> {
    base: Vec2,
    entities: Vec<Entity<'a>>,
    /// The file that it stands for, if it is an external reference.
    external: Option<&'a str>,
}

#[derive(Default)]
struct File<'a> {
    /// The last one, with its variables.
    header: Option<Entity<'a>>,
    /// In upper case, as names are compared.
    blocks: HashMap<String, Block<'a>>,
    /// Layers that are switched off or frozen, in upper case.
    hidden: HashSet<String>,
    entities: Vec<Entity<'a>>,
}

pub(super) fn read(bytes: &[u8], reading: &Reading) -> Result<Tracer> {
    let text = decoded(bytes)?;
    let (pairs, ended) = pairs(&text)?;
    let file = File::of(&pairs)?;
    // What the file says is not looked at if the user says it.
    let header = file.header.filter(|_| reading.unit.is_none());
    let code = header.map(Entity::header_unit).transpose()?.flatten();
    let own = code.map(metres).transpose()?.flatten().map(|unit| (unit, UnitFrom::File));
    let mut tracer = Tracer::new(Tracer::unit_of(reading, own), reading);
    if !ended {
        tracer.leave_out("", "EOF, which is missing: the file may have been cut off");
    }
    let scale = tracer.scale();
    Walk { file: &file, tracer: &mut tracer }.all(&file.entities, &scale, None, 0)?;
    Ok(tracer)
}

/// Decodes UTF-8, else Latin-1: text that is not ASCII is only in names.
fn decoded(bytes: &[u8]) -> Result<Cow<'_, str>> {
    require(!bytes.starts_with(b"AutoCAD Binary DXF"), || {
        "is a binary DXF: save it as a DXF in text form (ASCII)".to_owned()
    })?;
    require(!bytes.starts_with(b"AC10"), || "is a DWG: save it as a DXF".to_owned())?;
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    Ok(match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => Cow::Owned(bytes.iter().map(|byte| char::from(*byte)).collect()),
    })
}

/// Returns the pairs, and whether EOF is at their end.
fn pairs(text: &str) -> Result<(Vec<Pair<'_>>, bool)> {
    let mut pairs = Vec::new();
    let mut lines = text.lines().zip(1u32..);
    while let Some((code, line)) = lines.next() {
        if code.trim().is_empty() && lines.clone().all(|(rest, _)| rest.trim().is_empty()) {
            break;
        }
        let shown: String = code.chars().take(40).collect();
        let code: Option<i32> = code.trim().parse().ok();
        let code = code.ok_or_else(|| {
            PeopleError::new(format!("line {line}: {shown:?}: must be a group code, a whole number"))
        })?;
        let value = lines.next().map(|(value, _)| value.trim());
        let value = value.ok_or_else(|| {
            PeopleError::new(format!("line {line}: the file ends after group code {code}, without its value"))
        })?;
        if code == 0 && value == "EOF" {
            return Ok((pairs, true));
        }
        require(pairs.len() < MOST_PAIRS, || {
            format!("line {line}: there are more than {MOST_PAIRS} pairs: too many")
        })?;
        // Comments are between any others.
        if code != 999 {
            pairs.push(Pair { code, value, line: line + 1 });
        }
    }
    Ok((pairs, false))
}

/// Returns the length of a unit of `$INSUNITS` \[m\]; none where it says that there is none.
fn metres(code: i64) -> Result<Option<f64>> {
    Ok(Some(match code {
        0 => return Ok(None),
        1 => 0.0254,
        2 => 0.3048,
        3 => 1609.344,
        4 => 0.001,
        5 => 0.01,
        6 => 1.0,
        7 => 1000.0,
        10 => 0.9144,
        14 => 0.1,
        15 => 10.0,
        16 => 100.0,
        21 => 1200.0 / 3937.0,
        other => {
            return Err(PeopleError::new(format!(
                "$INSUNITS = {other}: must be 1 (in), 2 (ft), 4 (mm), 5 (cm), 6 (m), or another length of buildings"
            )));
        }
    }))
}

impl<'a> File<'a> {
    fn of(pairs: &'a [Pair<'a>]) -> Result<File<'a>> {
        let mut file = File::default();
        let mut section = "";
        let mut block: Option<(String, Block<'a>)> = None;
        for entity in entities(pairs) {
            match (entity.kind(), section) {
                ("SECTION", _) => {
                    section = entity.text(2).unwrap_or("");
                    if section == "HEADER" {
                        file.header = Some(entity);
                    }
                }
                ("ENDSEC", _) => section = "",
                ("LAYER", "TABLES") => {
                    let off = entity.whole(62)?.unwrap_or(0) < 0;
                    if off || entity.whole(70)?.unwrap_or(0) & 1 == 1 {
                        file.hidden.insert(entity.layer_named(2).to_uppercase());
                    }
                }
                ("BLOCK", "BLOCKS") => {
                    let base = entity.point(10)?.unwrap_or(Vec2::zeros());
                    let name = entity.text(2).unwrap_or("").to_uppercase();
                    let is_external = entity.whole(70)?.unwrap_or(0) & EXTERNAL != 0;
                    let external = is_external.then(|| entity.text(1).unwrap_or(""));
                    block = Some((name, Block { base, entities: Vec::new(), external }));
                }
                ("ENDBLK", "BLOCKS") => file.blocks.extend(block.take()),
                (_, "BLOCKS") => {
                    if let Some((_, block)) = &mut block {
                        block.entities.push(entity);
                    }
                }
                (_, "ENTITIES") => file.entities.push(entity),
                _ => (),
            }
        }
        require(section.is_empty(), || {
            let (section, last): (String, _) = (section.chars().take(40).collect(), pairs.last());
            let line = last.map_or(0, |pair| pair.line);
            format!("line {line}: the file ends within section {section}, without ENDSEC: it was cut off")
        })?;
        Ok(file)
    }
}

fn entities<'a>(pairs: &'a [Pair<'a>]) -> impl Iterator<Item = Entity<'a>> {
    pairs.chunk_by(|_, next| next.code != 0).filter(|pairs| pairs[0].code == 0).map(Entity)
}

impl<'a> Entity<'a> {
    fn kind(self) -> &'a str {
        self.0[0].value
    }

    fn line(self) -> u32 {
        self.0[0].line
    }

    /// Returns the number of its pairs, long values counted as more.
    fn size(self) -> usize {
        self.0.iter().map(|pair| 1 + pair.value.len() / 32).sum()
    }

    /// Values of a group code, in their order. What programs append (1000 and above) and what 102 encloses have codes of
    /// their own.
    fn all(self, code: i32) -> impl Iterator<Item = &'a Pair<'a>> {
        self.0.iter().filter(move |pair| pair.code == code)
    }

    fn text(self, code: i32) -> Option<&'a str> {
        self.all(code).next().map(|pair| pair.value)
    }

    fn layer(self) -> String {
        self.layer_named(8)
    }

    fn layer_named(self, code: i32) -> String {
        unescaped(self.text(code).unwrap_or("0"))
    }

    fn wrong(self, Pair { code, value, line }: &Pair, must: &str) -> PeopleError {
        let (kind, layer) = self.called();
        let value: String = value.chars().take(40).collect();
        PeopleError::new(format!(
            "line {line}: {kind} on layer {layer:?}: group code {code} = {value:?}: must be {must}"
        ))
    }

    /// Returns its kind and its layer for a message, neither of them endless.
    fn called(self) -> (String, String) {
        let short = |text: &str| text.chars().take(MOST_LETTERS).collect();
        (short(self.kind()), short(&self.layer()))
    }

    fn number_of(self, pair: &Pair) -> Result<f64> {
        let number = pair.value.parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| self.wrong(pair, "a finite number"))
    }

    fn number(self, code: i32) -> Result<Option<f64>> {
        self.all(code).next().map(|pair| self.number_of(pair)).transpose()
    }

    fn needed(self, code: i32) -> Result<f64> {
        self.number(code)?.ok_or_else(|| self.lacks(code))
    }

    fn lacks(self, code: i32) -> PeopleError {
        self.about(&format!("has no group code {code}"))
    }

    fn about(self, what: &str) -> PeopleError {
        let (kind, layer) = self.called();
        PeopleError::new(format!("line {}: {kind} on layer {layer:?}: {what}", self.line()))
    }

    fn numbers(self, code: i32) -> Result<Vec<f64>> {
        self.all(code).map(|pair| self.number_of(pair)).collect()
    }

    fn whole(self, code: i32) -> Result<Option<i64>> {
        let whole = |pair: &Pair| pair.value.parse().map_err(|_| self.wrong(pair, "a whole number"));
        self.all(code).next().map(whole).transpose()
    }

    fn point(self, x: i32) -> Result<Option<Vec2>> {
        let (Some(x), y) = (self.number(x)?, self.number(x + 10)?) else { return Ok(None) };
        Ok(Some(vec2(x, y.unwrap_or(0.0))))
    }

    fn needed_point(self, x: i32) -> Result<Vec2> {
        Ok(vec2(self.needed(x)?, self.needed(x + 10)?))
    }

    fn header_unit(self) -> Result<Option<i64>> {
        let place = self.0.iter().position(|pair| pair.code == 9 && pair.value == "$INSUNITS");
        let Some(pair) = place.and_then(|place| self.0.get(place + 1)) else { return Ok(None) };
        let Pair { line, value, .. } = pair;
        let unit = value.parse().map_err(|_| {
            PeopleError::new(format!("line {line}: $INSUNITS = {value:?}: must be a whole number"))
        });
        unit.map(Some)
    }

    /// Returns the map from the entity's own coordinates to those of the drawing: mirrored if it is seen from below. `None`
    /// if it does not lie in the plane.
    fn seen_from(self) -> Result<Option<Affine>> {
        let normal = [self.number(210)?.unwrap_or(0.0), self.number(220)?.unwrap_or(0.0)];
        let up = self.number(230)?.unwrap_or(1.0);
        if normal.iter().any(|part| part.abs() > 1e-6 * up.abs()) || up == 0.0 {
            return Ok(None);
        }
        Ok(Some(Affine::new([up.signum(), 0.0, 0.0, 1.0, 0.0, 0.0])))
    }

    /// Returns the largest width of a polyline and its vertices, if it has any.
    fn widest(self, parts: &[Entity]) -> Result<Option<f64>> {
        let codes: &[i32] = match self.kind() {
            "LWPOLYLINE" => &[40, 41, 43],
            "POLYLINE" => &[40, 41],
            _ => &[],
        };
        let mut widest: f64 = 0.0;
        for entity in std::iter::once(&self).chain(parts) {
            for code in codes {
                widest = entity.numbers(*code)?.into_iter().fold(widest, f64::max);
            }
        }
        Ok((widest > 0.0).then_some(widest))
    }

    /// Returns corners with their bulges.
    fn vertices(self) -> Result<Vec<(Vec2, f64)>> {
        let mut vertices: Vec<(Vec2, f64)> = Vec::new();
        for pair in self.0 {
            match (pair.code, vertices.last_mut()) {
                (10, _) => vertices.push((vec2(self.number_of(pair)?, 0.0), 0.0)),
                (20, Some((at, _))) => at.y = self.number_of(pair)?,
                (42, Some((_, bulge))) => *bulge = self.number_of(pair)?,
                _ => (),
            }
        }
        Ok(vertices)
    }
}

/// Decodes letters that are written as numbers: `\U+00E4` is ä.
fn unescaped(text: &str) -> String {
    let mut parts = text.split("\\U+");
    let mut all = parts.next().unwrap_or("").to_owned();
    for part in parts {
        let letter = part.get(..4).and_then(|code| char::from_u32(u32::from_str_radix(code, 16).ok()?));
        match letter {
            Some(letter) => all.extend([&*letter.to_string(), &part[4..]]),
            None => all.extend(["\\U+", part]),
        }
    }
    all
}

/// Goes through entities, and the blocks that they insert.
struct Walk<'f, 't> {
    file: &'f File<'f>,
    tracer: &'t mut Tracer,
}

impl<'f> Walk<'f, '_> {
    /// Takes entities. `into` leads to metres; `layer` is that of the block, which those on layer 0 take.
    fn all(
        &mut self,
        entities: &[Entity<'f>],
        into: &Affine,
        layer: Option<&str>,
        depth: usize,
    ) -> Result<()> {
        let mut rest = entities;
        while let Some((entity, others)) = rest.split_first() {
            self.tracer.look(entity.size())?;
            // Those that belong to it follow, up to SEQEND.
            let parts = match entity.kind() {
                "POLYLINE" => others.iter().position(|part| part.kind() != "VERTEX").unwrap_or(others.len()),
                _ => 0,
            };
            rest = &others[parts..];
            others[..parts].iter().try_for_each(|part| self.tracer.look(part.size()))?;
            self.one(*entity, &others[..parts], into, layer, depth)?;
        }
        Ok(())
    }

    fn one(
        &mut self,
        entity: Entity<'f>,
        parts: &[Entity<'f>],
        into: &Affine,
        of_block: Option<&str>,
        depth: usize,
    ) -> Result<()> {
        let own = entity.layer();
        let layer = of_block.filter(|_| own == "0").map_or(own, str::to_owned);
        let kind = entity.kind();
        let names = [kind, &layer, entity.text(2).filter(|_| kind == "INSERT").unwrap_or("")];
        names.iter().try_for_each(|name| check_name(name)).map_err(|error| entity.placed(error))?;
        if kind == "SEQEND" || kind == "VIEWPORT" {
            return Ok(());
        }
        let hidden = match () {
            () if entity.whole(67)?.unwrap_or(0) == 1 => Some("in paper space"),
            () if entity.whole(60)?.unwrap_or(0) == 1 => Some("invisible"),
            () if self.file.hidden.contains(&layer.to_uppercase()) => Some("switched off or frozen"),
            () => None,
        };
        if let Some(why) = hidden {
            self.tracer.leave_out(&layer, &format!("{kind} ({why})"));
            return Ok(());
        }
        let in_space = matches!(kind, "LINE" | "3DLINE" | "POINT" | "SPLINE" | "ELLIPSE");
        let (Some(seen), true) = (entity.seen_from()?, known(kind)) else {
            let why = if known(kind) { " (not in the plane)" } else { "" };
            self.tracer.leave_out(&layer, &format!("{kind}{why}"));
            return Ok(());
        };
        let into = if in_space { *into } else { into.after(&seen) };
        if kind == "INSERT" {
            return self.insert(entity, &into, &layer, depth);
        }
        let (deviation, mut corners) = (self.tracer.deviation, Vec::new());
        let is_up = seen.linear.m11 > 0.0;
        let Some((closed, curved)) = trace(entity, parts, &into, is_up, deviation, &mut corners)
            .map_err(|error| entity.placed(error))?
        else {
            self.tracer.leave_out(&layer, &format!("{kind} ({})", unused(kind)));
            return Ok(());
        };
        self.tracer.curves += usize::from(curved);
        if let Some(width) = entity.widest(parts)? {
            let width = width * into.linear.determinant().abs().sqrt();
            self.tracer
                .leave_out(&layer, &format!("width of {width:.3} m of a {kind}: its middle line is taken"));
        }
        let entity = format!("{kind} in line {}", entity.line());
        let role = Role::of(&layer);
        self.tracer.take(Line {
            layer,
            role,
            name: None,
            entity,
            corners,
            closed,
            hole: false,
            ground: false,
        })
    }

    fn insert(&mut self, entity: Entity<'f>, into: &Affine, layer: &str, depth: usize) -> Result<()> {
        let name = entity.text(2).unwrap_or("");
        let Some(block) = self.file.blocks.get(&name.to_uppercase()) else {
            self.tracer.leave_out(layer, &format!("INSERT of {name:?}, which is not in the file"));
            return Ok(());
        };
        if let Some(file) = block.external.filter(|_| block.entities.is_empty()) {
            let file: String = file.chars().take(MOST_LETTERS).collect();
            let what =
                format!("INSERT of {name:?}: the file {file:?} that it stands for is not read; bind it");
            self.tracer.leave_out(layer, &what);
            return Ok(());
        }
        require(depth < DEEPEST, || {
            entity
                .about(&format!(
                    "more than {DEEPEST} blocks are within each other; does {name:?} contain itself?"
                ))
                .to_string()
        })?;
        let number = |code, otherwise| Ok::<f64, PeopleError>(entity.number(code)?.unwrap_or(otherwise));
        let place = Affine::shift(entity.needed_point(10)?).after(&Affine::turn(number(50, 0.0)?));
        let scale = Affine::new([number(41, 1.0)?, 0.0, 0.0, number(42, 1.0)?, 0.0, 0.0]);
        let own = scale.after(&Affine::shift(block.base * -1.0));
        let many = |code| Ok::<i64, PeopleError>(entity.whole(code)?.unwrap_or(1).max(1));
        let (columns, rows) = (many(70)?, many(71)?);
        let (dx, dy) = (number(44, 0.0)?, number(45, 0.0)?);
        for row in 0..rows {
            for column in 0..columns {
                self.tracer.look(1)?;
                let step = Affine::shift(vec2(dx * column as f64, dy * row as f64));
                let into = into.after(&place).after(&step).after(&own);
                self.all(&block.entities, &into, Some(layer), depth + 1)?;
            }
        }
        Ok(())
    }
}

impl Entity<'_> {
    /// Puts before the message which entity it is about.
    fn placed(self, error: PeopleError) -> PeopleError {
        let text = error.to_string();
        if text.starts_with("line ") { error } else { self.about(&text) }
    }
}

fn known(kind: &str) -> bool {
    matches!(
        kind,
        "LINE"
            | "3DLINE"
            | "POINT"
            | "LWPOLYLINE"
            | "POLYLINE"
            | "ARC"
            | "CIRCLE"
            | "ELLIPSE"
            | "SPLINE"
            | "SOLID"
            | "TRACE"
            | "INSERT"
    )
}

/// Says why [`trace`] took nothing.
fn unused(kind: &str) -> &'static str {
    match kind {
        "SPLINE" => "it has fit points only",
        "POLYLINE" => "a mesh",
        _ => "it has no corners",
    }
}

/// Appends the corners of an entity \[m\]. Returns whether it is closed, and whether it was a curve; `None`: it cannot be
/// taken.
fn trace(
    entity: Entity,
    parts: &[Entity],
    into: &Affine,
    is_up: bool,
    deviation: f64,
    to: &mut Vec<Vec2>,
) -> Result<Option<(bool, bool)>> {
    let arc = |from: f64, sweep: f64| -> Result<Arc> {
        let arc = Arc::circle(entity.needed_point(10)?, entity.needed(40)?);
        Ok(Arc { from, to: from + sweep, ..arc }.mapped(into))
    };
    Ok(Some(match entity.kind() {
        "POINT" => {
            to.push(into.of(entity.needed_point(10)?));
            (false, false)
        }
        "LINE" | "3DLINE" => {
            to.extend([into.of(entity.needed_point(10)?), into.of(entity.needed_point(11)?)]);
            (false, false)
        }
        "SOLID" | "TRACE" => {
            let mut corners = [10, 11, 12, 13].map(|code| entity.point(code));
            corners.swap(2, 3);
            for corner in corners {
                to.extend(corner?.map(|corner| into.of(corner)));
            }
            (true, false)
        }
        "CIRCLE" => {
            arc(0.0, std::f64::consts::TAU)?.trace(deviation, to)?;
            (true, true)
        }
        "ARC" => {
            let [from, until] = sweep(entity.needed(50)?.to_radians(), entity.needed(51)?.to_radians());
            open(arc(from, until - from)?, deviation, to)?;
            (false, true)
        }
        "ELLIPSE" => ellipse(entity, into, is_up, deviation, to)?,
        "LWPOLYLINE" => {
            let closed = entity.whole(70)?.unwrap_or(0) & 1 == 1;
            return polyline(&entity.vertices()?, closed, into, deviation, to);
        }
        "POLYLINE" => {
            let flags = entity.whole(70)?.unwrap_or(0);
            if flags & (16 | 64) != 0 {
                return Ok(None);
            }
            let mut vertices = Vec::new();
            for part in parts {
                // What steers a spline is no part of it.
                if part.whole(70)?.unwrap_or(0) & 16 == 0 {
                    vertices.push((part.needed_point(10)?, part.number(42)?.unwrap_or(0.0)));
                }
            }
            return polyline(&vertices, flags & 1 == 1, into, deviation, to);
        }
        "SPLINE" => return spline(entity, into, deviation, to),
        _ => return Ok(None),
    }))
}

fn open(arc: Arc, deviation: f64, to: &mut Vec<Vec2>) -> Result<()> {
    to.push(arc.centre + arc.u * libm::cos(arc.from) + arc.v * libm::sin(arc.from));
    arc.trace(deviation, to)
}

fn ellipse(
    entity: Entity,
    into: &Affine,
    is_up: bool,
    deviation: f64,
    to: &mut Vec<Vec2>,
) -> Result<(bool, bool)> {
    let u = entity.needed_point(11)?;
    let v = u.left() * (entity.needed(40)? * if is_up { 1.0 } else { -1.0 });
    let ends = [entity.number(41)?.unwrap_or(0.0), entity.number(42)?.unwrap_or(std::f64::consts::TAU)];
    let whole = ends[1] - ends[0] >= std::f64::consts::TAU - 1e-9;
    let [from, until] = if whole { [0.0, std::f64::consts::TAU] } else { sweep(ends[0], ends[1]) };
    let arc = Arc { centre: entity.needed_point(10)?, u, v, from, to: until }.mapped(into);
    if whole {
        arc.trace(deviation, to)?
    } else {
        open(arc, deviation, to)?
    }
    Ok((whole, true))
}

fn polyline(
    vertices: &[(Vec2, f64)],
    closed: bool,
    into: &Affine,
    deviation: f64,
    to: &mut Vec<Vec2>,
) -> Result<Option<(bool, bool)>> {
    let Some((first, _)) = vertices.first() else { return Ok(None) };
    to.push(into.of(*first));
    let ends = vertices.iter().skip(1).chain(closed.then_some(&vertices[0]));
    for (&(from, bulge), &(next, _)) in vertices.iter().zip(ends) {
        // How far the arc is from its chord; without a unit, only what is next to nothing is straight.
        let height = (into.linear * (next - from).left() * (0.5 * bulge)).norm();
        let chord = (into.linear * (next - from)).norm();
        let straight = if deviation.is_finite() { deviation } else { 1e-6 * chord };
        if from != next && height > straight {
            Arc::bulge(from, next, bulge).mapped(into).trace(deviation, to)?;
            // Exactly there.
            to.pop();
        }
        to.push(into.of(next));
    }
    let curved = vertices.iter().any(|(_, bulge)| *bulge != 0.0);
    Ok(Some((closed, curved)))
}

fn spline(entity: Entity, into: &Affine, deviation: f64, to: &mut Vec<Vec2>) -> Result<Option<(bool, bool)>> {
    let (x, y) = (entity.numbers(10)?, entity.numbers(20)?);
    if x.is_empty() {
        return Ok(None);
    }
    let control: Vec<Vec2> = x.iter().zip(&y).map(|(x, y)| into.of(vec2(*x, *y))).collect();
    let degree = usize::try_from(entity.whole(71)?.unwrap_or(3)).unwrap_or(0);
    let spline = Spline { degree, knots: entity.numbers(40)?, control, weights: entity.numbers(41)? };
    spline.check()?;
    spline.trace(deviation, to)?;
    let (first, last) = (to[0], to[to.len() - 1]);
    Ok(Some(((last - first).norm() <= 1e-9, spline.degree > 1)))
}
