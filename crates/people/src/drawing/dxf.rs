//! DXF as text -> lines. The file is a list of pairs, each a group code and a value on a line of its own.

mod file;

use super::curve::{Affine, Arc, Spline, sweep};
use super::{DrawnLine, LayerRole, MOST_LETTERS, Reading, Tracer, UnitFrom, check_name};
use crate::error::{PeopleError, Result, require};
use file::{Entity, File, decoded, metres, pairs};
use lemons_core::plane::{InPlane, Vec2, vec2};

/// More blocks within each other are a circle.
const DEEPEST: usize = 16;

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
        let role = LayerRole::of(&layer);
        self.tracer.take(DrawnLine {
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
