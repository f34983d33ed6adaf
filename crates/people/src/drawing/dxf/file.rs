//! A file of DXF: pairs of group codes and values, entities of such pairs, blocks of entities.

use super::super::MOST_LETTERS;
use super::super::curve::Affine;
use crate::error::{PeopleError, Result, require};
use lemons_core::plane::{Vec2, vec2};
use std::borrow::Cow;
use std::collections::{HashMap, HashSet};

/// More pairs are a mistake: each takes 32 bytes of memory.
const MOST_PAIRS: usize = 8_000_000;

/// Flags of a block that is an external reference, or lies over one.
const EXTERNAL: i64 = 4 | 8;

/// A group code with its value.
pub(super) struct Pair<'a> {
    pub code: i32,
    pub value: &'a str,
    /// Of the value.
    pub line: u32,
}

/// Pairs that begin with one of code 0.
#[derive(Clone, Copy)]
pub(super) struct Entity<'a>(&'a [Pair<'a>]);

#[derive(Default)]
pub(super) struct Block<'a> {
    pub base: Vec2,
    pub entities: Vec<Entity<'a>>,
    /// The file that it stands for, if it is an external reference.
    pub external: Option<&'a str>,
}

#[derive(Default)]
pub(super) struct File<'a> {
    /// The last one, with its variables.
    pub header: Option<Entity<'a>>,
    /// In upper case, as names are compared.
    pub blocks: HashMap<String, Block<'a>>,
    /// Layers that are switched off or frozen, in upper case.
    pub hidden: HashSet<String>,
    pub entities: Vec<Entity<'a>>,
}

/// Decodes UTF-8, else Latin-1: text that is not ASCII is only in names.
pub(super) fn decoded(bytes: &[u8]) -> Result<Cow<'_, str>> {
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
pub(super) fn pairs(text: &str) -> Result<(Vec<Pair<'_>>, bool)> {
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
pub(super) fn metres(code: i64) -> Result<Option<f64>> {
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
    pub(super) fn of(pairs: &'a [Pair<'a>]) -> Result<File<'a>> {
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

pub(super) fn entities<'a>(pairs: &'a [Pair<'a>]) -> impl Iterator<Item = Entity<'a>> {
    pairs.chunk_by(|_, next| next.code != 0).filter(|pairs| pairs[0].code == 0).map(Entity)
}

impl<'a> Entity<'a> {
    pub(super) fn kind(self) -> &'a str {
        self.0[0].value
    }

    pub(super) fn line(self) -> u32 {
        self.0[0].line
    }

    /// Returns the number of its pairs, long values counted as more.
    pub(super) fn size(self) -> usize {
        self.0.iter().map(|pair| 1 + pair.value.len() / 32).sum()
    }

    /// Values of a group code, in their order. What programs append (1000 and above) and what 102 encloses have codes of
    /// their own.
    pub(super) fn all(self, code: i32) -> impl Iterator<Item = &'a Pair<'a>> {
        self.0.iter().filter(move |pair| pair.code == code)
    }

    pub(super) fn text(self, code: i32) -> Option<&'a str> {
        self.all(code).next().map(|pair| pair.value)
    }

    pub(super) fn layer(self) -> String {
        self.layer_named(8)
    }

    pub(super) fn layer_named(self, code: i32) -> String {
        unescaped(self.text(code).unwrap_or("0"))
    }

    pub(super) fn wrong(self, Pair { code, value, line }: &Pair, must: &str) -> PeopleError {
        let (kind, layer) = self.called();
        let value: String = value.chars().take(40).collect();
        PeopleError::new(format!(
            "line {line}: {kind} on layer {layer:?}: group code {code} = {value:?}: must be {must}"
        ))
    }

    /// Returns its kind and its layer for a message, neither of them endless.
    pub(super) fn called(self) -> (String, String) {
        let short = |text: &str| text.chars().take(MOST_LETTERS).collect();
        (short(self.kind()), short(&self.layer()))
    }

    pub(super) fn number_of(self, pair: &Pair) -> Result<f64> {
        let number = pair.value.parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| self.wrong(pair, "a finite number"))
    }

    pub(super) fn number(self, code: i32) -> Result<Option<f64>> {
        self.all(code).next().map(|pair| self.number_of(pair)).transpose()
    }

    pub(super) fn needed(self, code: i32) -> Result<f64> {
        self.number(code)?.ok_or_else(|| self.lacks(code))
    }

    pub(super) fn lacks(self, code: i32) -> PeopleError {
        self.about(&format!("has no group code {code}"))
    }

    pub(super) fn about(self, what: &str) -> PeopleError {
        let (kind, layer) = self.called();
        PeopleError::new(format!("line {}: {kind} on layer {layer:?}: {what}", self.line()))
    }

    pub(super) fn numbers(self, code: i32) -> Result<Vec<f64>> {
        self.all(code).map(|pair| self.number_of(pair)).collect()
    }

    pub(super) fn whole(self, code: i32) -> Result<Option<i64>> {
        let whole = |pair: &Pair| pair.value.parse().map_err(|_| self.wrong(pair, "a whole number"));
        self.all(code).next().map(whole).transpose()
    }

    pub(super) fn point(self, x: i32) -> Result<Option<Vec2>> {
        let (Some(x), y) = (self.number(x)?, self.number(x + 10)?) else { return Ok(None) };
        Ok(Some(vec2(x, y.unwrap_or(0.0))))
    }

    pub(super) fn needed_point(self, x: i32) -> Result<Vec2> {
        Ok(vec2(self.needed(x)?, self.needed(x + 10)?))
    }

    pub(super) fn header_unit(self) -> Result<Option<i64>> {
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
    pub(super) fn seen_from(self) -> Result<Option<Affine>> {
        let normal = [self.number(210)?.unwrap_or(0.0), self.number(220)?.unwrap_or(0.0)];
        let up = self.number(230)?.unwrap_or(1.0);
        if normal.iter().any(|part| part.abs() > 1e-6 * up.abs()) || up == 0.0 {
            return Ok(None);
        }
        Ok(Some(Affine::new([up.signum(), 0.0, 0.0, 1.0, 0.0, 0.0])))
    }

    /// Returns the largest width of a polyline and its vertices, if it has any.
    pub(super) fn widest(self, parts: &[Entity]) -> Result<Option<f64>> {
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
    pub(super) fn vertices(self) -> Result<Vec<(Vec2, f64)>> {
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
pub(super) fn unescaped(text: &str) -> String {
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
