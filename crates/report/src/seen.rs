//! A run, reduced as it comes.

use crate::ReportError;
use lemons_core::message::Message;
use lemons_core::plane::{Bounds, Pose, Vec2, vec2};
use lemons_core::trial::{PanelChoice, Trial, Wall};
use lemons_decision::Plan;
use lemons_decision::target::nearest_exit;
use lemons_picture::{DENSITY_KERNEL, DensityMap, MarkKind, PictureScene, PlaceMark};
use lemons_results::Frame;
use lemons_results::measure::{
    BalanceOverTime, By, Exposed, Leaving, LoadsOverTime, MovingMeans, Over, SqueezeOverTime, WallLoads,
    squeeze,
};
use lemons_sim::lint::RunEnd;
use lemons_sim::{
    Algorithm, Clock, Documents, PointKind, SimError, Simulation, Stepper, StopCondition, Until,
};
use std::ops::ControlFlow;

/// \[s\] Density is looked at so often.
pub(crate) const SAMPLE: f64 = 1.0;
/// Times are sums of steps.
const ROUNDING: f64 = 1e-9;

/// Pose of who is not there.
const NOWHERE: Pose = Pose { position: vec2(f64::NAN, f64::NAN), orientation: 0.0 };

/// How runs are made and measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// When they end.
    pub until: Until,
    /// \[N\] and \[s\] Limit of the squeeze, and of means over which time it is.
    pub limit: (f64, f64),
}

/// A moment of a run.
#[derive(Debug, Clone, Default)]
pub struct Moment {
    /// \[s\]
    pub time: f64,
    /// The greatest value: a squeeze \[N\], or a density \[1/m²\].
    pub value: f64,
    /// Place of the person of whom it is; for a squeeze only.
    pub who: usize,
    /// \[N\] Part of it by walls.
    pub by_walls: f64,
    /// Everybody's pose; not finite of those who are not there.
    pub poses: Vec<Pose>,
    /// \[N\] Everybody's mean squeeze; for a squeeze only.
    pub values: Vec<f64>,
}

/// What is left of a run.
pub struct RunSeen {
    /// Its seed; `None`: it has none.
    pub seed: Option<u64>,
    /// Trial and plan, as at the start.
    pub trial: Trial,
    /// Where people walk, if they do.
    pub plan: Option<Plan>,
    /// How it was made.
    pub settings: Settings,
    /// \[s\] When it ended.
    pub end: f64,
    /// Who was to leave, and has; `None`: nobody was.
    pub leaving: Option<Leaving>,
    /// \[s\] Of each departure, in the order of time, and the place of the exit among the targets.
    pub departures: Vec<(f64, Option<usize>)>,
    /// Everybody's exposure to squeeze; `None`: it is not known.
    pub exposure: Option<Vec<Exposed>>,
    /// The moment of the greatest mean squeeze over the time of the limit; `None`: nobody was squeezed, or the run is
    /// shorter.
    pub pressed: Option<Moment>,
    /// The moment of the greatest density, of those that were looked at.
    pub dense: Option<Moment>,
    /// Density over the run.
    pub density: DensityMap,
    /// Loads on walls; `None` without walls.
    pub loads: Option<WallLoads>,
    /// \[m\] Deepest overlap.
    pub overlap: f64,
    /// How many people with legs fell; `None`: they have none.
    pub fallen: Option<usize>,
    /// Findings of the rules at its end.
    pub findings: Vec<Message>,
}

/// Returns exits and goals for pictures.
fn marks(plan: Option<&Plan>) -> Vec<PlaceMark> {
    let targets = plan.iter().flat_map(|plan| &plan.targets);
    let mark = |target: &lemons_decision::target::Target| PlaceMark {
        kind: if target.stay { MarkKind::Waypoint } else { MarkKind::Exit },
        name: target.name.clone(),
        corners: target.corners.iter().map(|corner| Vec2::from(*corner)).collect(),
    };
    targets.map(mark).collect()
}

impl RunSeen {
    /// Returns whether people were to leave, and all have.
    pub(crate) fn all_left(&self) -> bool {
        self.leaving.as_ref().is_some_and(|leaving| leaving.over() == Some(Over::Left))
    }

    /// Returns the Ids of those who have not left and were to.
    pub(crate) fn stay(&self) -> Vec<String> {
        let stay = self.leaving.iter().flat_map(Leaving::stay);
        stay.map(|agent| self.trial.agents[agent].id.clone()).collect()
    }

    /// Returns walls, exits and people at poses, in the same view for all.
    pub(crate) fn scene(&self, poses: Option<Vec<Pose>>) -> PictureScene<'_> {
        let mut scene = PictureScene::at_start(&self.trial);
        scene.marks = marks(self.plan.as_ref());
        scene.view = Some(self.density.view());
        scene.poses = poses.unwrap_or(scene.poses);
        scene
    }

    /// Makes a run of documents. `watch` is told how far it is \[s\], and may break it off: then there is none.
    ///
    /// # Errors
    /// It cannot be made.
    pub fn run(
        mut documents: Documents,
        seed: Option<u64>,
        settings: Settings,
        watch: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Result<Option<RunSeen>, ReportError> {
        documents.trial.geometry.divide(PanelChoice::Missing).map_err(ReportError::Panels)?;
        let (trial, plan) = (documents.trial.clone(), documents.plan.clone());
        let who = documents.leaving();
        let leaves = who.contains(&true);
        // Also a run up to a time is over when all have left.
        let end = if leaves && settings.until.time().is_some() {
            Some(StopCondition::Left(Leaving::of(who).without_standstill()))
        } else {
            settings.until.condition(documents.drive.end(), || who)?
        };
        let clock = Clock::new(0.0, trial.parameters.time_step, settings.until.latest())?;
        let mut simulation = Simulation::new(documents, Algorithm::default())?;
        simulation.begin(0.0, None)?;
        let mut seeing = Seeing::of(&trial, plan.as_ref(), settings);
        let mut broken = false;
        let mut see = |_: &Stepper, simulation: &mut Simulation, frames: Vec<Frame>, _: PointKind| {
            seeing.overlap =
                simulation.world().map_or(0.0, |world| world.largest_overlap()).max(seeing.overlap);
            for frame in frames {
                broken |= watch(frame.time).is_break();
                seeing.see(frame);
            }
            Ok::<_, SimError>(if broken { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
        };
        let mut run = Stepper::new(clock, 1, end);
        run.run(&mut simulation, &mut see, PointKind::Start)?;
        if broken {
            return Ok(None);
        }
        let Seeing { people, exposure, pressed, dense, density, loads, overlap, balance, end, .. } = seeing;
        let forces: Option<Vec<Vec2>> =
            simulation.world().map(|world| world.drive.iter().map(|drive| drive.force).collect());
        let findings = plan.iter().flat_map(|plan| end.findings(plan, forces.as_deref(), true));
        let exit = |at: Vec2| nearest_exit(&plan.as_ref()?.targets, at);
        Ok(Some(RunSeen {
            seed,
            settings,
            end: simulation.time(),
            leaving: run.leaving().cloned(),
            departures: end.departures.iter().map(|(time, at)| (*time, exit(*at))).collect(),
            exposure: exposure.finish().ok(),
            pressed,
            dense,
            density,
            loads: loads.finish().filter(|loads| !loads.panels.is_empty()),
            overlap,
            fallen: balance
                .finish()
                .map(|kept| kept.iter().filter(|one| one.falls > 0).count())
                .filter(|_| people > 0),
            findings: findings.map(|found| found.told()).collect(),
            trial,
            plan,
        }))
    }
}

/// A run that is being seen.
struct Seeing {
    people: usize,
    exposure: SqueezeOverTime,
    /// Means over the time of the limit, in all and by walls.
    means: [MovingMeans; 2],
    pressed: Option<Moment>,
    dense: Option<Moment>,
    /// \[s\] When density is looked at next.
    next: f64,
    view: Bounds,
    density: DensityMap,
    loads: LoadsOverTime,
    overlap: f64,
    balance: BalanceOverTime,
    end: RunEnd,
    walls: Vec<Wall>,
}

impl Seeing {
    fn of(trial: &Trial, plan: Option<&Plan>, settings: Settings) -> Seeing {
        /// \[m\] Around walls, people and exits.
        const AROUND: f64 = 0.5;
        let people = trial.agents.len();
        let own = trial.dynamics.iter().map(|own| own.motion().pose);
        let mut scene = PictureScene::new(trial, own.collect());
        scene.marks = marks(plan);
        let view = scene.extent().grown(AROUND);
        let (limit, over) = settings.limit;
        Seeing {
            people,
            exposure: SqueezeOverTime::new(people, &[limit], Some(over)),
            means: [MovingMeans::over(over), MovingMeans::over(over)],
            pressed: None,
            dense: None,
            next: 0.0,
            view,
            density: DensityMap::new(view, DENSITY_KERNEL, &trial.geometry.walls),
            loads: LoadsOverTime::of(&trial.geometry),
            overlap: 0.0,
            balance: BalanceOverTime::of(people),
            end: RunEnd::default(),
            walls: trial.geometry.walls.clone(),
        }
    }

    fn see(&mut self, frame: Frame) {
        let there = |agent: usize| frame.is_there(agent);
        let poses = || -> Vec<Pose> {
            let pose = |agent: usize| if there(agent) { frame.agents[agent].pose } else { NOWHERE };
            (0..frame.agents.len()).map(pose).collect()
        };
        self.exposure.see(&frame, None);
        self.loads.add(&frame);
        self.balance.add(&frame);
        let mut mean = |k: usize, by| {
            let of_step = |agent| squeeze(&frame, agent, by).map(|(mean, _)| mean);
            self.means[k].add(frame.time, (0..self.people).map(of_step))
        };
        if let (Some(means), Some(walls)) = (mean(0, None), mean(1, Some(By::Walls))) {
            let most =
                (0..self.people).filter(|agent| there(*agent)).max_by(|a, b| means[*a].total_cmp(&means[*b]));
            let before = self.pressed.as_ref().map_or(0.0, |moment| moment.value);
            if let Some(who) = most.filter(|who| means[*who] > before) {
                let (value, by_walls, time) = (means[who], walls[who], frame.time);
                self.pressed = Some(Moment { time, value, who, by_walls, poses: poses(), values: means });
            }
        }
        if frame.time >= self.next - ROUNDING {
            self.next = frame.time + SAMPLE;
            let mut now = DensityMap::new(self.view, DENSITY_KERNEL, &self.walls);
            now.add(frame.present().map(|(_, agent)| agent.pose.position));
            let value = now.values().into_iter().fold(0.0, f64::max);
            if self.dense.as_ref().is_none_or(|moment| value > moment.value) {
                self.dense = Some(Moment { time: frame.time, value, poses: poses(), ..Moment::default() });
            }
            self.density.join(&now);
        }
        self.end.see(frame);
    }
}
