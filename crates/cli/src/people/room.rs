//! `lemons room`: a room from a drawing; and what `lemons crowd` takes from one.

use super::outputs::{Outputs, PICTURE_WIDTH};
use super::regions::door;
use crate::error::and_then;
use crate::files::ForceOption;
use crate::interrupt::Interrupt;
use crate::print;
use crate::values::positive;
use anyhow::{Context, Result, anyhow, bail};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use lemons_core::files::input;
use lemons_core::trial::{Geometry, Trial, Wall};
use lemons_people::PeopleError;
use lemons_people::drawing::{
    Drawing, DrawingFormat, FloorPlan, Gap, LARGEST_DRAWING, NamedPlace, Proposal, Read, Reading, UNITS,
    sizes, write_plan,
};
use lemons_people::{TrialSettings, crowd_trial};
use lemons_picture::{MarkKind, PictureScene, PlaceMark, Style};
use lemons_scenario::{DoorForm, DrawingForm, WALLS};
use std::io::Write;
use std::path::{Path, PathBuf};

pub const ROOM_HELP: &str = include_str!("../help/room.txt");

#[derive(clap::Args)]
#[command(after_help = ROOM_HELP)]
pub struct Arguments {
    /// Drawing: .dxf, .geojson, .wkt or .svg
    #[arg(value_name = "FILE")]
    drawing: PathBuf,
    /// Write the walls as Geometry.xml (.xml), or walls, exits, distributions and way-points as a drawing in
    /// metres (.geojson, .dxf; .wkt: walls only)
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    reading: DrawingArguments,
    /// Print what each layer seems to be, gaps in walls, questions, and the command that would take it, and
    /// change nothing: for plans of architects
    #[arg(long, conflicts_with_all = ["output", "doors"])]
    propose: bool,
    /// A door in the nearest closed wall, in m: an exit of the room that is written, as --door of lemons
    /// crowd. Can be given several times
    #[arg(long = "door", value_name = "X,Y,WIDTH", value_parser = door, allow_hyphen_values = true)]
    doors: Vec<DoorForm>,
    /// Draw what was understood as SVG
    #[arg(long, value_name = "FILE.svg")]
    svg: Option<PathBuf>,
    /// Draw what was understood as PDF
    #[arg(long, value_name = "FILE.pdf")]
    pdf: Option<PathBuf>,
    /// Draw what was understood as PNG, 1200 pixels wide
    #[arg(long, value_name = "FILE.png")]
    png: Option<PathBuf>,
    #[command(flatten)]
    _force: ForceOption,
}

#[derive(clap::Args)]
#[command(next_help_heading = "Drawings (DXF, GeoJSON, well-known text, SVG)")]
pub struct DrawingArguments {
    /// Unit of the drawing. Default: that in the file ($INSUNITS of DXF); GeoJSON and well-known text
    /// are in m
    #[arg(long, value_parser = unit(), conflicts_with = "scale")]
    unit: Option<f64>,
    /// Metres of a unit of the drawing, for example 0.05
    #[arg(long, value_name = "METRES", value_parser = positive)]
    scale: Option<f64>,
    /// Join ends of lines that are at most so far apart, for example 5cm
    #[arg(long, value_name = "LENGTH", value_parser = length)]
    close: Option<f64>,
    /// Largest distance of the straight pieces of a curve from it. Default: 1cm
    #[arg(long, value_name = "LENGTH", value_parser = length)]
    deviation: Option<f64>,
    /// Move the lower left corner of all walls to 0,0
    #[arg(long)]
    origin: bool,
    /// Only these layers are walls, if no layer is a walkable area or an obstacle. Commas part names. For a
    /// name with a comma, give the option once for each layer
    #[arg(long, value_name = "LAYERS")]
    walls: Vec<String>,
    /// The room is what the walls enclose: two lines side by side (5 to 40 cm) are one wall, and gaps to
    /// the outside are closed, as for --door. lemons room --propose lists them
    #[arg(long)]
    enclosed: bool,
    /// Closed lines on these layers are obstacles, with --enclosed. Names as for --walls
    #[arg(long, value_name = "LAYERS", requires = "enclosed")]
    obstacles: Vec<String>,
    /// Widest gap of a wall that is closed, with --enclosed. Default: 3m
    #[arg(long, value_name = "LENGTH", value_parser = length, requires = "enclosed")]
    widest: Option<f64>,
}

fn unit() -> impl TypedValueParser<Value = f64> {
    let parser = PossibleValuesParser::new(UNITS.map(|(name, _)| name));
    parser.map(|text| UNITS.iter().find(|(name, _)| *name == text).map_or(1.0, |(_, metres)| *metres))
}

/// A positive length: 5cm, 0.05m, 0.05.
fn length(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let number = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let name = &text[number.len()..];
    let unit = UNITS.iter().find(|(unit, _)| *unit == name || name.is_empty());
    let value = unit.and_then(|(_, metres)| Some(number.trim().parse::<f64>().ok()? * metres));
    value
        .filter(|length| (1e-6..=100.0).contains(length))
        .ok_or_else(|| "must be a length up to 100 m, as in 5cm or 0.05".into())
}

fn format_of(path: &Path) -> Result<DrawingFormat> {
    DrawingFormat::of(path).with_context(|| {
        format!(
            "{}: is no drawing: its name must end in .dxf, .geojson, .json, .wkt, .txt or .svg",
            path.display()
        )
    })
}

impl DrawingArguments {
    /// Reads a drawing, and says what is in it.
    ///
    /// # Errors
    /// It cannot be read, or there are no walls in it. The message names the file.
    pub fn read(&self, path: &Path) -> Result<Read> {
        let (format, form) = (format_of(path)?, self.form());
        let read = input::read(path, LARGEST_DRAWING)
            .map_err(Into::into)
            .and_then(|bytes| Read::of(format, &bytes, &form.reading(), &form.settings()).map_err(explained));
        read.with_context(|| path.display().to_string())
    }

    /// Returns the keys of a scenario.
    pub fn form(&self) -> DrawingForm {
        DrawingForm {
            unit: self.unit.or(self.scale),
            close: self.close,
            deviation: self.deviation,
            origin: self.origin,
            walls: self.walls.clone(),
            enclosed: self.enclosed,
            obstacles: self.obstacles.clone(),
            widest: self.widest,
        }
    }

    /// The options that say how the drawing is read, as they were given.
    fn repeated(&self) -> Vec<String> {
        let unit = self.unit.and_then(|unit| UNITS.iter().find(|(_, metres)| *metres == unit));
        let mut options: Vec<String> = Vec::new();
        options.extend(unit.iter().flat_map(|(name, _)| ["--unit".to_owned(), (*name).to_owned()]));
        for (name, value) in [("--scale", self.scale), ("--deviation", self.deviation)] {
            options.extend(value.iter().flat_map(|value| [name.to_owned(), value.to_string()]));
        }
        options.extend(self.origin.then(|| "--origin".to_owned()));
        options
    }
}

/// Adds what to do where the unit is not known.
pub fn explained(error: PeopleError) -> anyhow::Error {
    let PeopleError::NoUnit { size, scale } = error else { return error.into() };
    let options = if scale {
        "a unit of SVG can be any length: give --unit m, cm, mm, in or ft, or --scale METRES"
    } else {
        "the drawing does not say what its unit is ($INSUNITS): give --unit m, cm, mm, in or ft"
    };
    let size = size.map(|size| format!("; {}", sizes(size)));
    anyhow!("{options}{}", size.unwrap_or_default())
}

/// Says what was understood, and with which option it would be otherwise.
pub fn messages(read: &Read, path: &Path) -> Vec<(&'static str, String)> {
    let mut messages = read.messages(&path.display().to_string());
    for (what, how) in &mut messages {
        *how += match *what {
            "moved" => " (--origin)",
            "far" => ": --origin moves the room there",
            "unit?" => ": give --unit",
            "gaps left" => ": --close joins them",
            "door" => ": lemons crowd cuts it",
            "in doubt" => ": lemons room FILE --propose shows what it may be",
            _ => "",
        };
    }
    messages
}

/// Prints what a plan seems to be, and what would take it.
fn propose(arguments: &Arguments) -> Result<()> {
    let Arguments { drawing: path, reading, .. } = arguments;
    let mut outputs = pictures(arguments)?;
    let interrupt = Interrupt::watch();
    let format = format_of(path)?;
    let named = || path.display().to_string();
    let bytes = input::read(path, LARGEST_DRAWING)?;
    let drawing = Drawing::read(format, &bytes, &reading.form().reading())
        .map_err(|error| match error {
            PeopleError::NoUnit { .. } => {
                let units = units(format, &bytes, reading);
                let units = if units.is_empty() { units } else { format!("; walls would be {units}") };
                anyhow!("{}{units}", explained(error))
            }
            error => error.into(),
        })
        .with_context(named)?;
    let given = reading.form().settings().enclosing;
    let found = Proposal::of(&drawing, &reading.walls, reading.close, given.as_ref()).with_context(named)?;
    let Some(mut found) = found else {
        bail!(
            "{}: its layers say what is a walkable area or an obstacle: there is nothing to propose (lemons room {0})",
            named()
        )
    };
    if reading.origin {
        found = found.at_origin();
    }
    let mut out = Vec::new();
    writeln!(out, "{:<18} {}: {}, unit {} m", "drawing", named(), drawing.format.name(), drawing.unit)?;
    for (what, how) in found.messages() {
        writeln!(out, "{what:<18} {how}")?;
    }
    if !found.ground.is_empty() {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let words = ["lemons".to_owned(), "room".to_owned(), named()].into_iter().chain(reading.repeated());
        let room = [format!("{stem}.geojson"), format!("{stem}_room.geojson")];
        let room = room.into_iter().find(|name| Path::new(name) != path).unwrap_or_default();
        let words = words.chain(found.options()).chain(["-o".to_owned(), room]);
        let words: Vec<String> = words.map(|word| quoted(&word)).collect();
        writeln!(out, "{:<18} {}", "command", words.join(" "))?;
    }
    let geometry = walls_of(&found);
    let trial = bare(path, &geometry)?;
    let mut scene = PictureScene::at_start(&trial);
    let wide = found.wide.iter().map(|ends| PlaceMark {
        kind: MarkKind::Waypoint,
        name: format!("gap: {:.2} m", (ends[1] - ends[0]).norm()),
        corners: ends.to_vec(),
    });
    scene.marks = found.gaps.iter().enumerate().map(|(k, gap)| gap_mark(k, gap)).chain(wide).collect();
    outputs.draw(&scene, &style())?;
    let done = outputs.persist(|| interrupt.check(), &mut out);
    let told = print::out().write_all(&out);
    and_then(done, told.map_err(Into::into))
}

/// In which units two lines side by side would be walls, and how thick.
fn units(format: DrawingFormat, bytes: &[u8], reading: &DrawingArguments) -> String {
    let in_unit = |(name, metres): (&str, f64)| {
        let how = Reading { unit: Some(metres), ..reading.form().reading() };
        let found =
            Proposal::of(&Drawing::read(format, bytes, &how).ok()?, &reading.walls, None, None).ok()??;
        let (thickness, _) = *found.thicknesses.first()?;
        let area = found.areas[0];
        (area >= 4.0).then(|| format!("{:.0} cm thick in {name}, around {area:.0} m²", 100.0 * thickness))
    };
    let all: Vec<String> = UNITS.into_iter().filter_map(in_unit).collect();
    all.join("; or ")
}

/// The rims of the ground and what stands in it, as walls; where there is none, walls as they are drawn.
fn walls_of(found: &Proposal) -> Geometry {
    let rims = found.ground.iter().map(|rim| rim.iter().chain(rim.first()).copied().collect());
    let open = if found.ground.is_empty() { &found.drawn } else { &found.open };
    let all = rims.chain(open.iter().map(|ends| ends.to_vec()));
    let walls = all.enumerate().map(|(id, corners)| Wall::new(id.to_string(), WALLS, corners)).collect();
    Geometry { walls, ..Geometry::default() }
}

/// A gap, for the picture: red as an exit if it is a door.
fn gap_mark(number: usize, gap: &Gap) -> PlaceMark {
    let kind = if gap.kind() == "door" { MarkKind::Exit } else { MarkKind::Distribution };
    PlaceMark {
        kind,
        name: format!("{} {number}: {:.2} m", gap.kind(), gap.width()),
        corners: gap.ends.to_vec(),
    }
}

/// A word of a shell.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./,:=+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// Opens what the options name.
fn pictures(Arguments { output, svg, pdf, png, .. }: &Arguments) -> Result<Outputs> {
    Outputs::open(&[
        ("-o", "room", output),
        ("--svg", "picture", svg),
        ("--pdf", "picture", pdf),
        ("--png", "picture", png),
    ])
}

pub fn room(arguments: &Arguments) -> Result<()> {
    if arguments.propose {
        return propose(arguments);
    }
    let Arguments { drawing, output, reading, .. } = arguments;
    let kind = output.as_deref().map(written).transpose()?;
    let mut outputs = pictures(arguments)?;
    let interrupt = Interrupt::watch();
    let mut read = reading.read(drawing)?;
    for DoorForm(door) in &arguments.doors {
        let named = || format!("{}: --door", drawing.display());
        if door.open.is_some() {
            bail!(crate::error::Misused(format!(
                "--door {},{},{}: a door of a drawing has no times: give them to lemons crowd",
                door.at.x, door.at.y, door.width
            )));
        }
        read.plan.add_door(door).with_context(named)?;
    }
    let geometry = read.plan.geometry(WALLS);
    let trial = bare(drawing, &geometry)?;
    let mut scene = PictureScene::at_start(&trial);
    scene.marks = marks(&read.plan);
    outputs.draw(&scene, &style())?;
    let mut out = Vec::new();
    for (what, how) in messages(&read, drawing) {
        writeln!(out, "{what:<18} {how}")?;
    }
    if let Some(kind) = kind {
        let text = kind.map_or_else(|| Some(geometry.to_xml()), |format| write_plan(&read.plan, format));
        let text = text.unwrap_or_default();
        outputs.fill("-o", |file| file.write_all(text.as_bytes()))?;
        not_written(&read.plan, kind);
    }
    if outputs.is_empty() {
        writeln!(out, "nothing was written: give -o FILE, --svg, --pdf or --png (lemons room --help)")?;
    }
    let done = outputs.persist(|| interrupt.check(), &mut out);
    let told = print::out().write_all(&out);
    and_then(done, told.map_err(Into::into))
}

/// Walls and nobody, for the picture.
fn bare(path: &Path, geometry: &Geometry) -> Result<Trial> {
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    Ok(crowd_trial(&name, &[], geometry.clone(), &TrialSettings::default())?)
}

fn style() -> Style {
    Style { width: PICTURE_WIDTH.into(), ..Style::default() }
}

/// Exits, distributions and way-points, for the picture.
pub fn marks(plan: &FloorPlan) -> Vec<PlaceMark> {
    let kinds = [
        (MarkKind::Exit, &plan.exits),
        (MarkKind::Distribution, &plan.distributions),
        (MarkKind::Waypoint, &plan.waypoints),
    ];
    let mark = |kind, place: &NamedPlace| PlaceMark {
        kind,
        name: place.name.clone(),
        corners: place.corners.clone(),
    };
    kinds.into_iter().flat_map(|(kind, places)| places.iter().map(move |place| mark(kind, place))).collect()
}

/// The format of an output; `None` is Geometry.xml.
fn written(path: &Path) -> Result<Option<DrawingFormat>> {
    let is_xml = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("xml"));
    match DrawingFormat::of(path) {
        _ if is_xml => Ok(None),
        Some(format) if format != DrawingFormat::Svg => Ok(Some(format)),
        _ => bail!(crate::error::Misused(format!(
            "-o {}: its name must end in .xml, .geojson, .wkt or .dxf (a Trial needs people: lemons crowd --geometry FILE \
             makes one of a drawing)",
            path.display()
        ))),
    }
}

fn not_written(plan: &FloorPlan, kind: Option<DrawingFormat>) {
    let places = plan.exits.len() + plan.distributions.len() + plan.waypoints.len();
    if places > 0 && matches!(kind, None | Some(DrawingFormat::Wkt)) {
        note!(
            "note: exits, distributions and way-points are not in this file: lemons crowd --geometry takes them from the \
             drawing, or from a .geojson or .dxf that is written here"
        );
    }
}
