//! Sorts of the lines of a layer: by the layer's name, else by how they lie.

use super::DrawnLine;
use super::bands::{self, THICKNESS};
use super::pieces::{Grid, Piece, mended, pieces_of};
use super::swings::Swing;
use crate::error::Result;
use lemons_core::plane::overlay;
use lemons_core::plane::{Bounds, Vec2};
use std::collections::{BTreeMap, BTreeSet};

/// Sort of the lines of a layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Sort {
    /// Walls.
    Wall,
    /// Leaves and swings.
    Door,
    /// Windows: they shut a gap.
    Window,
    /// Columns.
    Column,
    /// Furniture.
    Furniture,
    /// Stairs, lifts.
    Stairs,
    /// Axes of the building.
    Grid,
    /// Texts, dimensions, hatches.
    Note,
    /// Nothing says what.
    Unclear,
}

impl Sort {
    /// All of them.
    pub const ALL: [Sort; 9] = [
        Sort::Wall,
        Sort::Door,
        Sort::Window,
        Sort::Column,
        Sort::Furniture,
        Sort::Stairs,
        Sort::Grid,
        Sort::Note,
        Sort::Unclear,
    ];

    /// Returns what messages call it.
    pub fn name(self) -> &'static str {
        match self {
            Sort::Wall => "walls",
            Sort::Door => "doors",
            Sort::Window => "windows",
            Sort::Column => "columns",
            Sort::Furniture => "furniture",
            Sort::Stairs => "stairs",
            Sort::Grid => "grid lines",
            Sort::Note => "texts, dimensions or hatches",
            Sort::Unclear => "not clear",
        }
    }

    /// Returns whether its closed lines stand in the way.
    pub fn is_obstacle(self) -> bool {
        matches!(self, Sort::Column | Sort::Furniture)
    }
}

/// Words in names of layers, in English, German, French, Spanish and Italian. Those with a `-` are only beginnings of words.
const WORDS: [(Sort, &[&str]); 9] = [
    (
        Sort::Note,
        &[
            "hatch",
            "schraff",
            "hachure",
            "-patt",
            "anno",
            "-text",
            "beschrift",
            "-dim",
            "bemass",
            "massk",
            "-cot",
            "note",
            "defpoints",
            "-symb",
            "titel",
            "title",
            "-cart",
            "-leg",
            "viewport",
            "rahmen",
        ],
    ),
    (Sort::Door, &["door", "tuer", "porte", "puerta", "-porta"]),
    (
        Sort::Window,
        &["window", "-wind", "glaz", "fenster", "fenetre", "ventana", "finestr", "-vitr", "-baie"],
    ),
    (
        Sort::Stairs,
        &[
            "stair", "-strs", "trepp", "escalier", "-escal", "-scal", "-lift", "elevator", "-aufzug",
            "ascens", "ramp",
        ],
    ),
    (
        Sort::Column,
        &["-col", "column", "pillar", "stuetz", "saeule", "pfeiler", "poteau", "pilier", "-pilar", "colonn"],
    ),
    (
        Sort::Furniture,
        &[
            "furn", "moebel", "mobil", "meuble", "einricht", "theke", "tresen", "tisch", "-bar", "comptoir",
            "table", "-stuhl", "chair", "chaise", "equip", "-eqpm", "-fixt", "sanit", "counter", "ausstatt",
            "-mueb", "arred",
        ],
    ),
    (Sort::Grid, &["grid", "achse", "raster", "-axe", "-axis", "-trame", "-axen", "-eje", "-assi"]),
    (
        Sort::Wall,
        &["wall", "wand", "waende", "mauer", "-mur", "cloison", "-pared", "parete", "partition", "-porteur"],
    ),
    // Of sheets: doors and windows have some, too.
    (Sort::Note, &["-frame", "-border", "-cadre", "-marco", "-cornic"]),
];

/// Returns what the name of a layer says.
pub(super) fn of_name(layer: &str) -> Option<Sort> {
    let plain: String = layer
        .to_lowercase()
        .chars()
        .flat_map(|letter| without_accent(letter).chars().collect::<Vec<_>>())
        .collect();
    let parts: Vec<&str> =
        plain.split(|c: char| !c.is_alphanumeric()).filter(|part| !part.is_empty()).collect();
    let says = |word: &str| match word.strip_prefix('-') {
        Some(begin) => parts.iter().any(|part| part.starts_with(begin)),
        None => plain.contains(word),
    };
    WORDS.iter().find(|(_, words)| words.iter().any(|word| says(word))).map(|(sort, _)| *sort)
}

fn without_accent(letter: char) -> String {
    match letter {
        'ä' => "ae".into(),
        'ö' => "oe".into(),
        'ü' => "ue".into(),
        'ß' => "ss".into(),
        'à' | 'â' | 'á' => "a".into(),
        'é' | 'è' | 'ê' | 'ë' => "e".into(),
        'î' | 'ï' | 'í' => "i".into(),
        'ô' | 'ó' => "o".into(),
        'û' | 'ù' | 'ú' => "u".into(),
        'ç' => "c".into(),
        other => other.to_string(),
    }
}

/// A layer, and what it seems to be.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// Its name in the drawing.
    pub name: String,
    /// Sort of its lines.
    pub sort: Sort,
    /// Whether its name says so; else how its lines lie.
    pub by_name: bool,
    /// Number of its lines.
    pub lines: usize,
    /// \[m\] Where they are.
    pub bounds: Bounds,
}

/// Sorts of each line and each layer.
pub(super) struct Sorted {
    pub layers: Vec<Layer>,
    /// Numbers of lines that are swings, stairs or axes, on whatever layer they are.
    pub aside: BTreeMap<usize, Sort>,
    /// Flights of stairs: \[m\] where they are, and the number of steps.
    pub flights: Vec<Flight>,
}

/// Parallel lines with equal distances.
#[derive(Debug, Clone, PartialEq)]
pub struct Flight {
    /// \[m\]
    pub middle: Vec2,
    /// \[m\] From line to line.
    pub tread: f64,
    /// Which lines of the drawing.
    pub lines: Vec<usize>,
}

/// \[m\] Distances of the lines of stairs.
const TREAD: [f64; 2] = [0.2, 0.45];
/// Fewer parallel lines are no stairs.
const FEWEST_STEPS: usize = 4;

/// Says what lines and layers of a drawing are. Those that have a role are not asked for.
pub(super) fn sorted(lines: &[DrawnLine], swings: &[Swing], all: &[Piece]) -> Result<Sorted> {
    let mut of_layer: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (k, line) in lines.iter().enumerate().filter(|(_, line)| line.corners.len() > 1) {
        of_layer.entry(&line.layer).or_default().push(k);
    }
    let mut aside: BTreeMap<usize, Sort> = BTreeMap::new();
    for k in swings.iter().flat_map(|swing| &swing.lines) {
        aside.insert(*k, Sort::Door);
    }
    let flights = flights_of(lines);
    for k in flights.iter().flat_map(|flight| &flight.lines) {
        aside.entry(*k).or_insert(Sort::Stairs);
    }
    for k in through(lines, all, &aside) {
        aside.entry(k).or_insert(Sort::Grid);
    }
    let mut layers = Vec::new();
    for (name, own) in of_layer {
        let by_name = of_name(name);
        let sort = match by_name {
            Some(sort) => sort,
            None => by_shape(lines, &own, &aside)?,
        };
        let corners = own.iter().flat_map(|k| lines[*k].corners.iter().copied());
        let bounds = Bounds::of(corners).unwrap_or(Bounds::UNIT);
        layers.push(Layer {
            name: name.to_owned(),
            sort,
            by_name: by_name.is_some(),
            lines: own.len(),
            bounds,
        });
    }
    // Where nothing says what walls are, they are what encloses most; a room of single lines, too.
    if !layers.iter().any(|layer| layer.sort == Sort::Wall) {
        let size = |layer: &&mut Layer| layer.bounds.size().norm();
        let unclear = layers.iter_mut().filter(|layer| layer.sort == Sort::Unclear);
        if let Some(largest) = unclear.max_by(|a, b| size(a).total_cmp(&size(b))) {
            largest.sort = Sort::Wall;
        }
    }
    Ok(Sorted { layers, aside, flights })
}

fn by_shape(lines: &[DrawnLine], own: &[usize], aside: &BTreeMap<usize, Sort>) -> Result<Sort> {
    let mut counts: BTreeMap<Sort, usize> = BTreeMap::new();
    for sort in own.iter().filter_map(|k| aside.get(k)) {
        *counts.entry(*sort).or_default() += 1;
    }
    if let Some((sort, _)) = counts.iter().find(|(_, count)| 2 * **count > own.len()) {
        return Ok(*sort);
    }
    let rest = own.iter().filter(|k| !aside.contains_key(k)).map(|k| (*k, &lines[*k]));
    let pieces = pieces_of(rest)?;
    let length: f64 = pieces.iter().map(Piece::length).sum();
    let mended = mended(pieces, 0.0);
    let blobs = bands::blobs(&mended);
    let rings: Vec<_> = blobs.iter().filter_map(overlay::ring).collect();
    let size = |ring: &lemons_core::plane::Ring| ring.bounds().size();
    let round = |size: Vec2| size.max() <= 1.2 && size.min() >= 0.15 && size.max() < 2.0 * size.min();
    // Columns are small, closed, and several alike.
    if rings.len() >= 2 && rings.iter().all(|ring| round(size(ring))) && mended.loose.is_empty() {
        return Ok(Sort::Column);
    }
    // Of both lines.
    let double: f64 =
        bands::thicknesses(&mended.pieces, THICKNESS).iter().map(|(_, length)| 2.0 * length).sum();
    let is_large =
        rings.iter().any(|ring| size(ring).max() > 10.0 * THICKNESS[1]) || !mended.loose.is_empty();
    Ok(if double > 0.5 * length && length > 4.0 && is_large { Sort::Wall } else { Sort::Unclear })
}

/// Finds flights of stairs: at least four straight lines of about one length, side by side at equal distances.
fn flights_of(lines: &[DrawnLine]) -> Vec<Flight> {
    let straight = |line: &DrawnLine| match line.corners[..] {
        [a, b] if !line.closed => Some(Piece { a, b, line: 0 }),
        _ => None,
    };
    // Those of one layer, length and direction are neighbours in this order.
    type Key = (String, i64, i64);
    let mut groups: BTreeMap<Key, Vec<(usize, Piece)>> = BTreeMap::new();
    for (k, line) in lines.iter().enumerate() {
        let Some(piece) = straight(line) else { continue };
        let Some(way) = piece.direction().filter(|_| (0.5..=6.0).contains(&piece.length())) else { continue };
        let angle = libm::atan2(way.y, way.x).rem_euclid(std::f64::consts::PI) / 0.02;
        let key = (line.layer.clone(), (piece.length() / 0.02).round() as i64, angle.round() as i64);
        groups.entry(key).or_default().push((k, piece));
    }
    let mut flights = Vec::new();
    for group in groups.into_values().filter(|group| group.len() >= FEWEST_STEPS) {
        let Some(way) = group[0].1.direction() else { continue };
        let middle = |piece: &Piece| (piece.a + piece.b) * 0.5;
        let mut places: Vec<(f64, f64, usize)> =
            group.iter().map(|(k, piece)| (way.perp(&middle(piece)), way.dot(&middle(piece)), *k)).collect();
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut from = 0;
        while from + 1 < places.len() {
            let tread = places[from + 1].0 - places[from].0;
            let goes_on = |pair: &[(f64, f64, usize)]| {
                (pair[1].0 - pair[0].0 - tread).abs() <= 0.02 && (pair[1].1 - pair[0].1).abs() <= 0.1
            };
            let count = 1 + places[from..].windows(2).take_while(|pair| goes_on(pair)).count();
            if count >= FEWEST_STEPS && (TREAD[0]..=TREAD[1]).contains(&tread) {
                let own = &places[from..from + count];
                let lines_of: Vec<usize> = own.iter().map(|(.., k)| *k).collect();
                let middle = Bounds::of(lines_of.iter().flat_map(|k| lines[*k].corners.iter().copied()));
                let middle = middle.map_or(Vec2::zeros(), |bounds| (bounds.low + bounds.high) * 0.5);
                flights.push(Flight { middle, tread, lines: lines_of });
                from += count;
            } else {
                from += 1;
            }
        }
    }
    flights
}

/// Finds axes: straight lines whose ends meet nothing, and that run through the plan to beyond it on both sides.
fn through(lines: &[DrawnLine], all: &[Piece], aside: &BTreeMap<usize, Sort>) -> BTreeSet<usize> {
    let mut free = vec![0; all.len()];
    for end in mended(all.to_vec(), 0.0).loose {
        free[end.piece] += 1;
    }
    let is_free = |k: usize| {
        let line = &lines[all[k].line];
        free[k] == 2 && line.corners.len() == 2 && !line.closed && !aside.contains_key(&all[k].line)
    };
    let grid = Grid::of(all);
    let runs_through = |piece: &Piece| {
        let Some(way) = piece.direction() else { return false };
        let length = piece.length();
        let near = grid.around((piece.a + piece.b) * 0.5, 0.5 * length).filter(|k| !is_free(*k));
        let places = near.filter_map(|k| all[k].met_by(piece.a, way)).filter(|t| (0.0..=length).contains(t));
        let (low, high) =
            places.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), t| (low.min(t), high.max(t)));
        high - low > 2.0 * THICKNESS[1] && low > 0.3 && high < length - 0.3
    };
    let axes = (0..all.len()).filter(|k| all[*k].length() > 3.0 && is_free(*k) && runs_through(&all[*k]));
    axes.map(|k| all[k].line).collect()
}
