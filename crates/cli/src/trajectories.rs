//! Trajectories of experiments and of other simulators in the place of a run's results: what the user tells of them, and
//! the walls and bodies that they are shown with.

use crate::error::Misused;
use crate::record::trial_of;
use crate::values::{positive, within};
use anyhow::{Context, Result, bail};
use lemons_core::files::input;
use lemons_core::plane::Vec2;
use lemons_core::trial::{
    Agent, AgentDynamics, Geometry, Interactions, Materials, Parameters, ShapeElement, Trial,
};
use lemons_master::TrialInput;
use lemons_people::PeopleError;
use lemons_people::drawing::{Drawing, DrawingFormat, FloorPlan, LARGEST_DRAWING, PlanSettings, Reading};
use lemons_results::{READ, Record, Told, VELOCITY_OVER, holds_trajectories};
use lemons_scenario::WALLS;
use std::path::{Path, PathBuf};

/// \[m\] Radius of a body that is not known: that of an agent of `JuPedSim`'s models, if nothing else is said there.
const RADIUS: f64 = 0.2;

// Not that of a struct, under which options of the commands would come, too.
const HEADING: &str = "Trajectories of experiments and of other simulators";

/// How a file of trajectories is read.
#[derive(clap::Args)]
pub struct ReadingArguments {
    /// Unit of a text that does not say it
    #[arg(long, help_heading = HEADING, value_name = "m or cm", value_parser = ["m", "cm"])]
    unit: Option<String>,
    /// Frames per second of a text that does not say it, or of Vadere's steps (default 25)
    #[arg(long, help_heading = HEADING, value_name = "NUMBER", value_parser = positive)]
    fps: Option<f64>,
    /// Walls: a drawing in metres (.wkt, .geojson, .dxf, .svg), or a Trial or an FMU, of which only the walls
    /// are taken. Default: the walkable area in the file, if it has one
    #[arg(long, help_heading = HEADING, value_name = "DRAWING, TRIAL or FILE.fmu")]
    geometry: Option<PathBuf>,
    /// A database that is read in the place of the file, which messages name.
    #[arg(skip)]
    pub database: Option<PathBuf>,
}

/// How trajectories are shown and measured, too.
#[derive(clap::Args)]
pub struct TrajectoryArguments {
    #[command(flatten)]
    pub reading: ReadingArguments,
    /// Velocity: difference of two positions that are so many seconds apart, rounded to an even number of frames.
    /// Default: 0.4
    #[arg(long, help_heading = HEADING, value_name = "SECONDS", value_parser = within(1e-6, 1e6, " (s)"))]
    velocity_over: Option<f64>,
    /// Radius of the circles that are drawn for people, in metres. Default: 0.2
    #[arg(long, help_heading = HEADING, value_name = "METRES", value_parser = within(0.01, 10.0, " (m)"))]
    radius: Option<f64>,
}

impl ReadingArguments {
    /// Checks that options are given for trajectories only, and returns whether the file holds some.
    pub fn is_for(&self, path: &Path) -> Result<bool> {
        let given = [
            ("--unit", self.unit.is_some()),
            ("--fps", self.fps.is_some()),
            ("--geometry", self.geometry.is_some()),
        ];
        self.holds(path, &given)
    }

    /// Returns whether a file holds trajectories.
    ///
    /// # Errors
    /// It does not, and one of these options is given; or it cannot be read.
    fn holds(&self, path: &Path, given: &[(&str, bool)]) -> Result<bool> {
        let holds = self.database.is_some() || path.is_file() && holds_trajectories(path)?;
        match given.iter().find(|(_, given)| *given && !holds) {
            Some((option, _)) => bail!(Misused(format!(
                "{option}: {} holds no trajectories of experiments or of other simulators ({})",
                path.display(),
                *READ
            ))),
            None => Ok(holds),
        }
    }

    /// Opens trajectories.
    pub fn open(&self, path: &Path, velocity_over: f64) -> Result<Record> {
        let unit = self.unit.as_deref().map(|unit| if unit == "cm" { 100.0 } else { 1.0 });
        let held = self.database.as_deref().unwrap_or(path);
        let told = Told { per_metre: unit, rate: self.fps, velocity_over };
        let record = Record::of_others_in(path, held, &told)?;
        for line in record.trajectories().iter().flat_map(|trajectories| &trajectories.notes) {
            note!("{}: {line}", path.display());
        }
        Ok(record)
    }

    /// Returns a Trial with the walls and, for each person, a body of one disk: nobody knows more.
    pub fn assumed_trial(&self, record: &Record, radius: f64) -> Result<Trial> {
        let geometry = self.walls(record)?;
        let heights = Default::default();
        let shape = ShapeElement { radius, material_id: WALLS.into(), position: Vec2::zeros(), heights };
        let agent = |id: &String| Agent { id: id.clone(), shapes: vec![shape.clone()], ..Agent::default() };
        Ok(Trial {
            name: record.source().display().to_string(),
            directory: PathBuf::new(),
            parameters: Parameters::default(),
            materials: Materials::default(),
            geometry,
            agents: record.ids().iter().map(agent).collect(),
            dynamics: record.first().iter().map(AgentDynamics::of).collect(),
            interactions: Interactions::default(),
        })
    }

    /// Returns whether walls are given.
    pub fn has_walls(&self) -> bool {
        self.geometry.is_some()
    }

    /// Returns the walls around people: those that are given, or those of the file.
    pub fn walls(&self, record: &Record) -> Result<Geometry> {
        let Some(path) = &self.geometry else {
            let all = record.trajectories().map_or(&[][..], |trajectories| &trajectories.geometry);
            let source = record.source().display();
            let Some(wkt) = all.first() else { return Ok(Geometry::default()) };
            if all.len() > 1 {
                note!("{source}: its geometry changes: the first of {} is taken (--geometry)", all.len());
            }
            let plan = plan(DrawingFormat::Wkt, wkt.as_bytes());
            return Ok(plan.with_context(|| format!("{source}: geometry"))?.geometry(WALLS));
        };
        let named = || format!("--geometry {}", path.display());
        let model = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("fmu"));
        if model || TrialInput::find(path).with_context(named)?.is_some() {
            let trial = trial_of(record.source(), Some(path), None).with_context(named)?;
            return Ok(trial.with_context(named)?.geometry);
        }
        let format = DrawingFormat::of(path).with_context(|| {
            format!("{}: is neither a drawing (.wkt, .geojson, .dxf, .svg) nor a Trial or an FMU", named())
        })?;
        let bytes = input::read(path, LARGEST_DRAWING).with_context(named)?;
        Ok(plan(format, &bytes).with_context(named)?.geometry(WALLS))
    }
}

fn plan(format: DrawingFormat, bytes: &[u8]) -> Result<FloorPlan> {
    let drawing = match Drawing::read(format, bytes, &Reading::default()) {
        Err(PeopleError::NoUnit { .. }) => {
            bail!(
                "the drawing does not say its unit: lemons room --unit … -o room.geojson makes one in metres of it"
            )
        }
        drawing => drawing?,
    };
    Ok(FloorPlan::of(drawing, &PlanSettings::default())?)
}

impl TrajectoryArguments {
    /// Checks that options are given for trajectories only, and returns whether the file holds some.
    pub fn is_for(&self, path: &Path) -> Result<bool> {
        self.reading.holds(
            path,
            &[("--velocity-over", self.velocity_over.is_some()), ("--radius", self.radius.is_some())],
        )?;
        self.reading.is_for(path)
    }

    /// Opens trajectories, and says how velocities are calculated.
    pub fn open(&self, path: &Path) -> Result<Record> {
        let record = self.reading.open(path, self.velocity_over.unwrap_or(VELOCITY_OVER))?;
        if let Some(trajectories) = record.trajectories() {
            note!(
                "{}: trajectories without forces, {} frames per second; velocities: differences of positions {} s apart",
                path.display(),
                trajectories.rate,
                told(trajectories.velocity_over())
            );
        }
        Ok(record)
    }

    /// \[m\] Returns the radius of the circles that stand for bodies.
    pub fn radius(&self) -> f64 {
        self.radius.unwrap_or(RADIUS)
    }
}

/// \[s\] A time as it is told: without what rounding has added.
fn told(time: f64) -> f64 {
    (time * 1e6).round() / 1e6
}
