//! Where a crowd stands: the region, the placer, its progress.

use super::ranged;
use super::regions::{door, region};
use super::room::{self, DrawingArguments};
use crate::interrupt::Interrupt;
use crate::print;
use crate::values::parser_of;
use anyhow::Result;
use lemons_core::plane::{Vec2, vec2};
use lemons_people::drawing::Read;
use lemons_people::placing::{Method, Orientation, PlacingProgress, Stage};
use lemons_scenario::{
    Crowd, DoorForm, DrawingForm, OrientationName, Ready, RegionForm, Scenario, ScenarioError, TwoNumbers,
};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Duration;

#[derive(clap::Args)]
#[command(next_help_heading = "Region and packing")]
pub struct PlacingArguments {
    /// Place people in a box with walls, in m, for example 4.56x4.56; its lower left corner is the
    /// origin
    #[arg(long = "box", value_name = "LXxLY", value_parser = sides, allow_hyphen_values = true, group = "region")]
    sides: Option<Vec2>,
    /// Place people inside the closed walls of this Geometry.xml, or of a drawing (.dxf, .geojson, .wkt,
    /// .svg: see lemons room): the largest wall is the outline, the others are holes. With --region, its
    /// walls may have openings. Without --region, people stand on the distributions of a drawing
    #[arg(long, value_name = "FILE", group = "region")]
    geometry: Option<PathBuf>,
    /// Place people in the open, without walls (default)
    #[arg(long, group = "region")]
    open: bool,
    /// Place people on this part of the ground, in m: two opposite corners of a box, as in 0,0,8,6, or the
    /// corners of a polygon, as in "0,0 8,0 8,6". Can be given several times, each with its own number or
    /// density, as in "0,0,4,6; number=40" and "4,0,8,6; density=3"; see below
    #[arg(long = "region", value_name = "REGION", value_parser = region, allow_hyphen_values = true)]
    regions: Vec<RegionForm>,
    /// Cut a door into the nearest closed wall: a gap of this width, in m, whose middle is the wall's
    /// nearest point. People are placed before. A door in an obstacle is refused: nobody stands inside it.
    /// Can be given several times. With times in s it is a door that opens and closes, as in 8,3,1,20,60;
    /// without the last time it stays open, as in 8,3,1,20
    #[arg(long = "door", value_name = "X,Y,WIDTH[,FROM,TO...]", value_parser = door, allow_hyphen_values = true)]
    doors: Vec<DoorForm>,
    /// Packing algorithm. dense: our own, without overlap (default); paper: that of the paper's appendix D;
    /// grid: rows
    #[arg(long, value_parser = parser_of(&Method::ALL, Method::name))]
    packing: Option<Method>,
    /// Which way people face. free: any way; fixed: exactly along --direction; towards: first along
    /// --direction, then turned by their neighbours. Default: towards if --direction is given, free if not;
    /// fixed where --light-xml has bicycles
    #[arg(long, value_parser = parser_of(&OrientationName::ALL, OrientationName::name))]
    orientation: Option<OrientationName>,
    /// Direction people face, in degrees counter-clockwise from the x axis. Default: 0
    #[arg(long, value_name = "DEGREES", value_parser = ranged("direction", " (degrees)"))]
    direction: Option<f64>,
    /// Write the crowd even if some people overlap
    #[arg(long)]
    allow_overlap: bool,
    #[command(flatten)]
    drawing: DrawingArguments,
}

fn sides(text: &str) -> Result<Vec2, String> {
    let side = |text: &str| ranged("box", "")(text).ok();
    let sides = text.split_once(['x', 'X', '×']).and_then(|(along, across)| side(along).zip(side(across)));
    let must = "must be two lengths in m with an x between them, as in 4.56x4.56, each from 0.1 to 10000";
    sides.map(|(along, across)| vec2(along, across)).ok_or_else(|| must.into())
}

impl PlacingArguments {
    /// Fills in what is given.
    pub fn fill(&self, scenario: &mut Scenario) {
        if self.sides.is_some() || self.geometry.is_some() || self.open {
            (scenario.sides, scenario.geometry, scenario.room) = (None, None, None);
            scenario.drawing = DrawingForm::default();
        }
        scenario.sides = self.sides.map(|sides| TwoNumbers(sides.into())).or(scenario.sides);
        scenario.geometry = self.geometry.clone().or(scenario.geometry.take());
        let drawing = self.drawing.form();
        if drawing != DrawingForm::default() {
            scenario.drawing = drawing;
        }
        if !self.doors.is_empty() {
            scenario.doors.clone_from(&self.doors);
        }
        if !self.regions.is_empty() {
            scenario.regions.clone_from(&self.regions);
        }
        scenario.packing = self.packing.unwrap_or(scenario.packing);
        scenario.orientation = self.orientation.or(scenario.orientation);
        scenario.direction = self.direction.or(scenario.direction);
        scenario.allow_overlap |= self.allow_overlap;
    }
}

/// Prints what was understood of a drawing; of what was left out, how much.
pub fn say_drawn(read: &Read, path: &Path) {
    let messages = room::messages(read, path);
    let (left_out, messages): (Vec<_>, Vec<_>) =
        messages.into_iter().partition(|(what, _)| *what == "left out");
    messages.iter().for_each(|(what, how)| note!("{what}: {how}"));
    if !left_out.is_empty() {
        let path = path.display();
        note!(
            "left out: {} kinds of lines, texts and others (lemons room {path} lists them)",
            left_out.len()
        );
    }
}

/// In words, for the summary.
pub fn manner(scenario: &Scenario) -> String {
    let direction = scenario.direction.unwrap_or(0.0);
    let way = match scenario.orientation() {
        Orientation::Free => "facing any way".to_owned(),
        Orientation::Fixed(_) => format!("facing {direction}°"),
        Orientation::Towards(_) => format!("turned from {direction}°"),
    };
    format!("{}, {way}", scenario.packing.name())
}

/// Places people, and shows how far it is: on a terminal, once it takes a moment.
pub fn placed(ready: &Ready, interrupt: &Interrupt) -> Result<Result<Crowd, ScenarioError>> {
    let bar = print::bar(0, "{spinner} {elapsed:>4}  {msg}")?;
    bar.enable_steady_tick(Duration::from_millis(100));
    let crowd = ready.crowd(&mut |progress| {
        bar.set_message(described_progress(progress));
        if interrupt.pressed() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    bar.finish_and_clear();
    Ok(crowd)
}

fn described_progress(
    PlacingProgress { stage, iteration, density, overlap, .. }: &PlacingProgress,
) -> String {
    let stage = match stage {
        Stage::Growing => "growing",
        Stage::Spreading => "spreading",
        Stage::Shaking => "shaking",
        Stage::Pressing => "pressing",
        Stage::Thinning => "too many: thinning",
    };
    let overlap = 1e3 * overlap;
    format!("{stage}: {density:.2} /m², overlap {overlap:.2} mm, iteration {iteration} (Ctrl-C gives up)")
}
