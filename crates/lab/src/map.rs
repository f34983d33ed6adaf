//! Density and squeeze by place, over frames of a run.

use crate::frame::numbers;
use crate::loaded::LoadedTrial;
use crate::{Refused, Reply, require};
use lemons_core::plane::{Bounds, InPlane, Vec2, vec2};
use lemons_picture::{DENSITY_KERNEL, DensityMap};
use lemons_results::measure::SqueezeMap;
use serde::{Deserialize, Serialize};

/// \[m\] What is shown around walls, exits, goals, ways, and people at the start.
const AROUND: f64 = 1.0;
/// Numbers of a person in a frame: x, y \[m\], squeeze \[N\].
const ROW: usize = 3;

/// Quantity of a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS), ts(rename = "Quantity"))]
#[serde(rename_all = "kebab-case")]
pub enum MapQuantity {
    /// People per m².
    Density,
    /// Mean and greatest squeeze.
    Squeeze,
}

/// A map under way.
#[derive(Debug, Clone, PartialEq)]
pub enum Map {
    /// Of density.
    Density(DensityMap),
    /// Of squeeze.
    Squeeze(SqueezeMap),
}

impl Map {
    fn quantity(&self) -> MapQuantity {
        match self {
            Map::Density(_) => MapQuantity::Density,
            Map::Squeeze(_) => MapQuantity::Squeeze,
        }
    }

    fn of(quantity: MapQuantity, loaded: &LoadedTrial) -> Map {
        let view = extent(loaded);
        match quantity {
            MapQuantity::Density => {
                Map::Density(DensityMap::new(view, DENSITY_KERNEL, &loaded.trial.geometry.walls))
            }
            MapQuantity::Squeeze => Map::Squeeze(SqueezeMap::new(view)),
        }
    }
}

/// The part of the plane that maps show, in whole quarters of a metre: so cells of two runs in a room are the same.
fn extent(loaded: &LoadedTrial) -> Bounds {
    let LoadedTrial { trial, plan, .. } = loaded;
    let corners = trial.geometry.walls.iter().flat_map(|wall| wall.corners.iter().copied());
    let people = trial.dynamics.iter().map(|here| here.position);
    let targets = plan.iter().flat_map(|plan| &plan.targets).flat_map(|target| &target.corners);
    let ways = plan.iter().flat_map(|plan| plan.ways_of_points(100)).flatten();
    let points = corners
        .chain(people)
        .chain(targets.map(|corner| Vec2::from(*corner)))
        .chain(ways.map(|point| vec2(point.x, point.y)));
    let Bounds { low, high } = Bounds::of(points).unwrap_or(Bounds::UNIT).grown(AROUND);
    let round = |v: f64, to: fn(f64) -> f64| to(v / SqueezeMap::CELL) * SqueezeMap::CELL;
    Bounds {
        low: vec2(round(low.x, f64::floor), round(low.y, f64::floor)),
        high: vec2(round(high.x, f64::ceil), round(high.y, f64::ceil)),
    }
}

/// The cells of a map \[m\].
#[derive(Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub(crate) struct Grid {
    /// The middle of the lowest cell on the left.
    low: [f64; 2],
    cell: [f64; 2],
    columns: usize,
    rows: usize,
}

/// Adds frames to the run's map of a quantity, or to a new one. The bytes have `ROW` doubles for each person of each frame;
/// who has left has no numbers there. The answer: the middle of the lowest left cell, the size of a cell, how many there are
/// along x and y, and how many frames; its bytes: of each cell the density, or the mean and the greatest squeeze and the number
/// of values \[N, N, 1\], one quantity after the other, row by row from the lowest.
///
/// # Errors
/// The bytes are no frames, or they should be added to a map of another quantity.
pub fn add(
    of: &mut Option<Map>,
    loaded: &LoadedTrial,
    quantity: MapQuantity,
    fresh: bool,
    bytes: &[u8],
) -> Result<Reply, Refused> {
    let people = loaded.trial.agents.len();
    require(bytes.len().is_multiple_of(8 * ROW * people), || {
        format!("{} bytes are not frames of {people} people", bytes.len())
    })?;
    // Its sums would have none of the frames before.
    let others = of.as_ref().is_some_and(|map| map.quantity() != quantity);
    require(fresh || !others, || "the run's map is of another quantity: begin a new one".to_owned())?;
    let kept = of.take().filter(|_| !fresh);
    let mut map = kept.unwrap_or_else(|| Map::of(quantity, loaded));
    let numbers = numbers(bytes);
    let (rows, _) = numbers.as_chunks::<ROW>();
    for frame in rows.chunks(people) {
        let there =
            frame.iter().map(|&[x, y, squeeze]| (vec2(x, y), squeeze)).filter(|(at, _)| at.is_finite());
        match &mut map {
            Map::Density(map) => map.add(there.map(|(at, _)| at)),
            Map::Squeeze(map) => there.for_each(|(at, squeeze)| map.add(at, squeeze)),
        }
    }
    let (view, cell, (columns, rows), values) = match &map {
        Map::Density(map) => (map.view(), map.cell(), map.cells(), map.values()),
        Map::Squeeze(map) => {
            (map.view(), map.cell(), map.cells(), [map.means(), map.greatest(), map.counts()].concat())
        }
    };
    let low = view.low + cell * 0.5;
    let grid = Grid { low: low.into(), cell: cell.into(), columns, rows };
    *of = Some(map);
    Reply::with(grid, values.into_iter().flat_map(f64::to_le_bytes).collect())
}
