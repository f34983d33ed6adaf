//! How hard people press on walls: on panels, and on whole walls.

use crate::measure::{Exposed, SqueezeOverTime};
use crate::{Frame, OfWall};
use lemons_core::plane::Vec2;
use lemons_core::trial::Geometry;
use serde::Serialize;

/// A panel of a wall, or a straight piece of one without panels.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Panel {
    /// Its place among all panels, from 0, as in `barrier[k].Load`; of a wall without panels that of the straight piece, as in
    /// `wall[k].MeanNormalForce`.
    pub panel: usize,
    /// Id of the wall.
    pub wall: String,
    /// \[m\]
    pub x1: f64,
    /// \[m\]
    pub y1: f64,
    /// \[m\]
    pub x2: f64,
    /// \[m\]
    pub y2: f64,
}

impl Panel {
    /// Returns the ends \[m\].
    pub fn ends(&self) -> [Vec2; 2] {
        [Vec2::new(self.x1, self.y1), Vec2::new(self.x2, self.y2)]
    }

    /// Returns the length \[m\].
    pub fn length(&self) -> f64 {
        let [start, end] = self.ends();
        (end - start).norm()
    }
}

/// Load on a part of a wall: the normal forces of all people on it, over its length. A mean counts within the spans that
/// are measured; of the same mean the first one.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct WallLoad {
    /// \[m\]
    pub length: f64,
    /// \[N/m\] Greatest mean over a communication step.
    pub load_step: f64,
    /// \[N/m\] Greatest mean over 1 s; `None`: the record is shorter, or a communication step is longer.
    pub load_1: Option<f64>,
    /// \[s\] When this second ends.
    pub load_1_at: Option<f64>,
    /// \[N/m\] Greatest mean over 10 s.
    pub load_10: Option<f64>,
    /// \[s\] When these 10 s end.
    pub load_10_at: Option<f64>,
    /// \[N/m\] Greatest load at any instant; `None` of a wall in all, whose panels have theirs at different instants.
    pub load_peak: Option<f64>,
    /// \[s\] When the communication step ends in which it was.
    pub load_peak_at: Option<f64>,
    /// \[N s\] Integral of the force.
    pub impulse: f64,
}

impl WallLoad {
    fn of(seen: &Exposed, length: f64, whole: bool) -> WallLoad {
        let Exposed { largest_mean: [_, mean_1, mean_10], largest_mean_at: [_, at_1, at_10], .. } = *seen;
        let peak = (!whole).then_some(seen.peak);
        WallLoad {
            length,
            load_step: seen.largest_step / length,
            load_1: mean_1.map(|mean| mean / length),
            load_1_at: mean_1.map(|_| at_1),
            load_10: mean_10.map(|mean| mean / length),
            load_10_at: mean_10.map(|_| at_10),
            load_peak: peak.map(|peak| peak / length),
            load_peak_at: peak.filter(|peak| *peak > 0.0).map(|_| seen.peak_at),
            impulse: seen.impulse,
        }
    }
}

/// Sums up the loads on walls. It is given all communication points in the order of time.
#[derive(Debug, Clone)]
pub struct LoadsOverTime {
    panels: Vec<Panel>,
    /// Ids of the walls.
    walls: Vec<String>,
    /// Of each panel, the place of its wall, and whether it is a panel of the frames, or a straight piece.
    of: Vec<(usize, bool)>,
    of_panels: SqueezeOverTime,
    of_walls: SqueezeOverTime,
    /// Whether there was a frame that does not say.
    incomplete: bool,
}

impl LoadsOverTime {
    /// Begins, with the panels of walls; of a wall without panels, with its straight pieces.
    pub fn of(geometry: &Geometry) -> LoadsOverTime {
        let (mut panels, mut of, mut counts) = (Vec::new(), Vec::new(), [0, 0]);
        for (place, wall) in geometry.walls.iter().enumerate() {
            let divided = wall.panel_length.is_some();
            let own: Vec<[Vec2; 2]> = if divided { wall.panels().collect() } else { wall.sides().collect() };
            // Frames have all straight pieces, also of walls that are divided.
            let before = counts[usize::from(divided)];
            counts[1] += if divided { own.len() } else { 0 };
            counts[0] += wall.corners.len() - 1;
            of.resize(of.len() + own.len(), (place, divided));
            panels.extend(own.into_iter().enumerate().map(|(k, [start, end])| Panel {
                panel: before + k,
                wall: wall.id.clone(),
                x1: start.x,
                y1: start.y,
                x2: end.x,
                y2: end.y,
            }));
        }
        let walls: Vec<String> = geometry.walls.iter().map(|wall| wall.id.clone()).collect();
        let over_time = |count| SqueezeOverTime::new(count, &[], None);
        let (of_panels, of_walls) = (over_time(panels.len()), over_time(walls.len()));
        LoadsOverTime { panels, walls, of, of_panels, of_walls, incomplete: false }
    }

    /// Adds the next frame.
    pub fn add(&mut self, frame: &Frame) {
        let of_frame = |(panel, (_, divided)): (&Panel, &(usize, bool))| {
            let all = if *divided { &frame.panels } else { &frame.walls };
            all.as_ref()?.get(panel.panel).copied()
        };
        let forces: Option<Vec<OfWall>> = self.panels.iter().zip(&self.of).map(of_frame).collect();
        let Some(forces) = forces else {
            self.incomplete = true;
            return;
        };
        let mut sums = vec![0.0; self.walls.len()];
        for (force, (wall, _)) in forces.iter().zip(&self.of) {
            sums[*wall] += force.mean_normal_force;
        }
        let means = forces.iter().map(|of| Some((of.mean_normal_force, of.peak_normal_force)));
        self.of_panels.add(frame.time, means);
        self.of_walls.add(frame.time, sums.into_iter().map(|sum| Some((sum, sum))));
    }

    /// Returns the panels with their loads, and the walls with theirs, by Id; `None` if there was a frame that does not say.
    pub fn finish(self) -> Option<WallLoads> {
        if self.incomplete {
            return None;
        }
        let mut lengths = vec![0.0; self.walls.len()];
        for (panel, (wall, _)) in self.panels.iter().zip(&self.of) {
            lengths[*wall] += panel.length();
        }
        let of_panels = self.of_panels.so_far().into_iter().zip(self.panels);
        let panels = of_panels.map(|(seen, panel)| {
            let load = WallLoad::of(&seen, panel.length(), false);
            (panel, load)
        });
        let of_walls = self.of_walls.so_far().into_iter().zip(lengths).zip(self.walls);
        let walls = of_walls.map(|((seen, length), wall)| (wall, WallLoad::of(&seen, length, true)));
        Some(WallLoads { panels: panels.collect(), walls: walls.collect() })
    }
}

/// Loads on walls.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WallLoads {
    /// The panels, in the order of Geometry.xml.
    pub panels: Vec<(Panel, WallLoad)>,
    /// Ids of walls, in the same order.
    pub walls: Vec<(String, WallLoad)>,
}
