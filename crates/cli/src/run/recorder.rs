//! The record of a crowd in a run: its table or frames in memory, its extremes.

use super::model::CrowdInfo;
use super::outputs::{About, TableFile, persist};
use crate::files;
use anyhow::{Result, bail};
use lemons_core::files::Staged;
use lemons_core::plane::Pose;
use lemons_core::trial::Agent;
use lemons_master::{CrowdRecord, SavedRun};
use lemons_results::columns::Group;
use lemons_results::{Frame, FrameWriter, KeptFrames, Recorder, Run, TableContent, TableFormat};
use lemons_sim::lint::RunEnd;
use lemons_sim::{ExposureSum, Extremes, Greatest, PointKind};
use std::path::{Path, PathBuf};

/// Where the rows of a crowd go.
#[derive(Clone)]
pub enum RowTarget {
    Table(TableFile),
    /// Those that are wanted.
    Memory(KeptFrames),
}

impl RowTarget {
    /// The same for one of several crowds: `dir/file.csv` -> `dir/file_name.csv`.
    pub fn named(&self, name: &str) -> Result<RowTarget> {
        let RowTarget::Table(TableFile { path, format }) = self else { return Ok(self.clone()) };
        if files::is_standard_output(path) {
            bail!("-o -: several crowds do not go to standard output together: -o FILE");
        }
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let end = path.extension().map(|end| format!(".{}", end.to_string_lossy())).unwrap_or_default();
        let path = path.with_file_name(format!("{stem}_{name}{end}"));
        Ok(RowTarget::Table(TableFile { path, format: *format }))
    }
}

/// The poses of a crowd at each communication point.
#[derive(Default)]
pub struct Poses {
    /// Times \[s\], each with the poses of all agents.
    pub points: Vec<(f64, Vec<Pose>)>,
    /// Ids of the agents.
    pub ids: Vec<String>,
    /// \[m\] From the centre of mass to the rim, by agent; `None`: shapes are not known.
    pub rims: Option<Vec<f64>>,
}

impl Poses {
    /// Adds a communication point.
    fn add(&mut self, frame: &Frame) {
        self.points.push((frame.time, frame.agents.iter().map(|motion| motion.pose).collect()));
    }
}

enum Rows {
    Table(Box<FrameWriter<Staged>>, PathBuf),
    Memory(Recorder),
}

/// The record of a crowd.
pub struct CrowdRecorder {
    pub crowd: CrowdInfo,
    rows: Rows,
    extremes: Extremes,
    /// Exposure in the steps since the last rows.
    exposure: ExposureSum,
    /// True if the greatest peak was since then.
    peak_passed: bool,
    /// If they are kept.
    poses: Option<Poses>,
    /// Since the run began or went on.
    pub end: RunEnd,
}

/// The result of recording.
#[derive(Default)]
pub struct Recorded {
    /// Lines of the summary.
    pub lines: Vec<String>,
    /// If it was to be kept in memory.
    pub run: Option<Run>,
    /// Poses, if they were kept.
    pub poses: Option<Poses>,
}

impl CrowdRecorder {
    pub fn create(
        crowd: CrowdInfo,
        to: RowTarget,
        about: &About,
        before: Option<&SavedRun>,
        keeps_poses: bool,
    ) -> Result<CrowdRecorder> {
        let CrowdInfo { ids, component, groups, .. } = &crowd;
        let record =
            before.and_then(|saved| saved.crowd.iter().find(|record| record.component == *component));
        let (extremes, exposure) = match record {
            Some(record) => (record.extremes, record.since.clone()),
            None if before.is_some() => {
                bail!("the saved run is damaged: it has no entry for the crowd {component:?}")
            }
            None => Default::default(),
        };
        let among = [extremes.mean_squeeze, extremes.peak_squeeze].iter().all(|most| most.agent < ids.len());
        if !among || !(exposure.is_empty() || exposure.agents() == ids.len()) {
            bail!("the saved run is damaged: it contains other agents than component {component:?} has");
        }
        let rows = match to {
            RowTarget::Table(place) => {
                let own = [
                    ("component", component.clone()),
                    ("model_name", crowd.model_name.clone()),
                    ("guid", crowd.guid.clone()),
                ];
                let trial = crowd.trial.iter().map(|trial| ("trial", trial.name.clone()));
                let lines = about.lines.iter().cloned().chain(trial).chain(own).collect();
                let content = TableContent { columns: crowd.columns.clone(), about: lines };
                let table = place.begin(&content, about)?;
                Rows::Table(Box::new(FrameWriter::new(table, ids.clone(), *groups)), place.path)
            }
            RowTarget::Memory(wanted) => Rows::Memory(Recorder::new(wanted)),
        };
        let rim = |agent: &Agent| {
            agent.shapes.iter().map(|shape| shape.position.norm() + shape.radius).fold(0.0, f64::max)
        };
        let rims = crowd.trial.as_ref().map(|trial| trial.agents.iter().map(rim).collect());
        Ok(CrowdRecorder {
            poses: keeps_poses.then(|| Poses { ids: ids.clone(), rims, points: Vec::new() }),
            crowd,
            rows,
            extremes,
            exposure,
            peak_passed: false,
            end: RunEnd::default(),
        })
    }

    /// Sees the frame of a communication point: extremes, and rows if they are wanted.
    pub fn see(&mut self, mut frame: Frame, kind: PointKind) -> Result<()> {
        if let Some(poses) = &mut self.poses {
            poses.add(&frame);
        }
        let since = self.end.last.time;
        self.end.see(frame.clone());
        if kind == PointKind::Resumed {
            return Ok(());
        }
        let length = if kind == PointKind::Start { 0.0 } else { frame.time - since };
        let before = self.extremes.peak_squeeze.force;
        self.extremes.see(&frame, kind == PointKind::Start);
        self.peak_passed =
            kind == PointKind::Passed && (self.peak_passed || self.extremes.peak_squeeze.force > before);
        self.exposure.add(length, &frame);
        if kind == PointKind::Passed {
            return Ok(());
        }
        self.exposure.finish(&mut frame);
        match &mut self.rows {
            Rows::Table(writer, _) => writer.frame(&frame)?,
            Rows::Memory(recorder) => recorder.add(frame),
        }
        Ok(())
    }

    /// Returns what a saved run keeps of it.
    pub fn record(&self) -> CrowdRecord {
        let (component, since) = (self.crowd.component.clone(), self.exposure.clone());
        CrowdRecord { component, extremes: self.extremes, since }
    }

    /// Puts the table in its place.
    pub fn finish(self) -> (Recorded, Result<()>) {
        let CrowdInfo { ids, groups, .. } = self.crowd;
        let Extremes { largest_overlap, mean_squeeze, peak_squeeze } = self.extremes;
        let squeeze = |what: &str, Greatest { force, agent, time }: Greatest, when: &str| {
            let line = format!("{what:<18} {force:>10.1} N");
            if force > 0.0 {
                format!("{line}   (squeeze of agent {}, {when} {time:.3} s)", ids[agent])
            } else {
                line
            }
        };
        let mut lines = Vec::new();
        if groups.has(Group::Active) {
            let outside = self.end.last.outside.iter().filter(|outside| **outside).count();
            let left = (0..ids.len()).filter(|agent| !self.end.last.is_there(*agent)).count() - outside;
            let last = self
                .end
                .departures
                .last()
                .map_or(String::new(), |(time, _)| format!("; the last at {time:.3} s"));
            lines.push(format!("left               {left:>10}     (of {} people{last})", ids.len()));
            if outside > 0 {
                lines.push(format!("not come yet       {outside:>10}"));
            }
        }
        if groups.has(Group::OfStep) {
            lines.push(format!("largest overlap    {:>10.3} mm", 1e3 * largest_overlap));
            lines.push(squeeze("greatest step mean", mean_squeeze, "step to"));
            lines.push(squeeze("greatest peak", peak_squeeze, "step to"));
            if self.peak_passed && matches!(self.rows, Rows::Table(..)) {
                let remark = "(not in the table, whose last rows are before this step: --every)";
                lines.push(format!("{:33}{remark}", ""));
            }
        } else {
            lines.push(squeeze("greatest squeeze", mean_squeeze, "communication point"));
        }
        let (mut run, mut done) = (None, Ok(()));
        match self.rows {
            Rows::Table(writer, path) => {
                done = persist(writer.finish(), &path);
                lines.extend(
                    done.is_ok().then(|| format!("trajectories       {}{}", path.display(), large(&path))),
                );
            }
            Rows::Memory(recorder) => match recorder.finish(Path::new(""), ids) {
                Ok(made) => run = Some(made),
                Err(error) => done = Err(error.into()),
            },
        }
        (Recorded { lines, run, poses: self.poses }, done)
    }
}

/// \[byte\] Larger text is worth a remark.
const LARGE: u64 = 5_000_000;

/// A remark on a large table of text.
fn large(path: &Path) -> String {
    match path.metadata() {
        Ok(file) if file.len() > LARGE && TableFormat::of(path) == Some(TableFormat::Csv) => {
            format!("   ({} MB; smaller with --format parquet, or --every)", file.len() / 1_000_000)
        }
        _ => String::new(),
    }
}
