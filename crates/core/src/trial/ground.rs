//! `<Ground>`: parts of the plan that are slopes or stairs.

use crate::plane::{Ring, Vec2, rotation, vec2};
use crate::require;
use crate::trial::schema::{AttributeValue, Schema};
use crate::trial::xml::Element;
use crate::xml::quoted;

/// \[m/s²\] g
pub const GRAVITY: f64 = 9.81;
/// \[rad\] No slope is steeper.
const STEEPEST: f64 = 1.0;
/// \[m\] Half the length of the arrow downhill.
const ARROW: f64 = 0.4;
/// Most contour lines of a ground.
const MOST_CONTOURS: f64 = 1000.0;
/// Most corners of a ground.
const MOST_CORNERS: usize = 1000;
/// Most grounds of a Trial.
pub(crate) const MOST_GROUNDS: usize = 1000;

/// `<Ground>`: a slope or stairs. Lengths are those of the plan, not of the way up.
#[derive(Debug, Clone, PartialEq)]
pub struct Ground {
    /// Id, unique among the grounds.
    pub id: String,
    /// \[m\] Where it is. Where two overlap, the first one in the file counts.
    pub area: Ring,
    /// \[rad\] `Downhill`: direction in which it falls.
    pub downhill: f64,
    /// How it falls.
    pub incline: Incline,
    /// `SpeedDown` and `SpeedUp`: factors of the speeds of who walks straight down and up; `None` if they follow
    /// from the fall.
    pub speeds: [Option<f64>; 2],
}

/// How a ground falls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Incline {
    /// A slope, on which feet do not hold all.
    Slope {
        /// \[rad\] `Angle`
        angle: f64,
        /// `Held`: share from 0 to 1 of the downhill force that the feet of everybody hold.
        held: f64,
    },
    /// Stairs: who stands on a step stands on the level.
    Stairs {
        /// \[m\] `Riser`
        riser: f64,
        /// \[m\] `Tread`
        tread: f64,
    },
}

impl Ground {
    /// Checks its area and how steep it is.
    ///
    /// # Errors
    /// A sentence: what is wrong.
    pub fn check(&self) -> Result<(), String> {
        let count = self.area.corners().len();
        require(count <= MOST_CORNERS, || {
            format!("has {count} corners: at most {MOST_CORNERS} are allowed")
        })?;
        let is_area = count >= 3 && self.area.is_simple() && self.area.area() > 0.0;
        require(is_area, || "its rim meets itself, or it has no area".to_owned())?;
        require(self.downhill.is_finite(), || format!("downhill = {}: must be finite", self.downhill))?;
        let angle = match self.incline {
            Incline::Slope { angle, held } => {
                require((0.0..=1.0).contains(&held), || format!("held = {held}: must be from 0 to 1"))?;
                angle
            }
            Incline::Stairs { riser, tread } => {
                let positive = |length: f64| length > 0.0 && length.is_finite();
                require(positive(riser) && positive(tread), || {
                    "riser and tread must be positive and finite".to_owned()
                })?;
                libm::atan2(riser, tread)
            }
        };
        require((0.0..=STEEPEST).contains(&angle), || {
            format!("falls by an angle of {angle} rad: must be from 0 to {STEEPEST} rad")
        })?;
        let speeds = self.speeds.iter().flatten();
        require(speeds.clone().all(|factor| (0.01..=10.0).contains(factor)), || {
            "factors of speeds must be from 0.01 to 10".to_owned()
        })
    }

    /// Returns the unit vector downhill.
    pub fn downhill(&self) -> Vec2 {
        rotation(self.downhill) * vec2(1.0, 0.0)
    }

    /// Returns the lines \[m\] with which it is drawn: the rim, an arrow downhill, and contour lines: of stairs the edges of
    /// the steps, of a slope one each 0.1 m of height.
    pub fn lines(&self) -> Vec<Vec<Vec2>> {
        let distance = match self.incline {
            Incline::Slope { angle, .. } => (0.1 / libm::tan(angle)).clamp(0.2, 1e9),
            Incline::Stairs { tread, .. } => tread,
        };
        let (down, bounds) = (self.downhill(), self.area.bounds());
        let (across, half) = (vec2(-down.y, down.x), 0.5 * bounds.size().norm());
        let middle = (bounds.low + bounds.high) * 0.5;
        let count = (half / distance).min(0.5 * MOST_CONTOURS) as i32;
        let line = |k: i32| {
            let at = middle + down * (f64::from(k) * distance);
            let crossing = |(a, b): (Vec2, Vec2)| {
                let [before, behind] = [a, b].map(|end| down.dot(&(end - at)));
                ((before < 0.0) != (behind < 0.0)).then(|| a + (b - a) * (before / (before - behind)))
            };
            let mut crossings: Vec<Vec2> = self.area.sides().filter_map(crossing).collect();
            crossings.sort_by(|a, b| across.dot(a).total_cmp(&across.dot(b)));
            crossings.chunks_exact(2).map(<[Vec2]>::to_vec).collect::<Vec<_>>()
        };
        let (arrow, wide) = (down * ARROW, across * (0.5 * ARROW));
        let (tip, neck) = (middle + arrow, middle + arrow * 0.5);
        let arrow = [vec![middle - arrow, tip], vec![neck - wide, tip, neck + wide]];
        [self.area.closed().to_vec()]
            .into_iter()
            .chain(arrow)
            .chain((-count..=count).flat_map(line))
            .collect()
    }

    /// \[m/s²\] Returns the acceleration downhill of who is not held further: (1 − held) g sin α.
    pub fn pull(&self) -> Vec2 {
        match self.incline {
            Incline::Slope { angle, held } => self.downhill() * ((1.0 - held) * GRAVITY * libm::sin(angle)),
            Incline::Stairs { .. } => Vec2::zeros(),
        }
    }

    /// Returns whether it is stairs.
    pub fn is_stairs(&self) -> bool {
        matches!(self.incline, Incline::Stairs { .. })
    }

    /// Returns the factor of the speed in plan of who walks in a direction, a unit vector. Across, the ground is level.
    pub fn speed_factor(&self, direction: Vec2) -> f64 {
        let down = self.downhill().dot(&direction);
        let side = usize::from(down < 0.0);
        if let Some(own) = self.speeds[side] {
            return 1.0 + (own - 1.0) * down.abs();
        }
        match self.incline {
            Incline::Slope { angle, .. } => on_line(&UPHILL, -down * libm::tan(angle)),
            Incline::Stairs { riser, tread } => {
                let speeds = STAIRS.map(|(angle, speeds)| (angle, speeds[side]));
                let straight = on_line(&speeds, libm::atan2(riser, tread)) / LEVEL_SPEED;
                1.0 + (straight - 1.0) * down.abs()
            }
        }
    }
}

/// Gradients uphill, and factors of the speed: Fruin, *Pedestrian Planning and Design* (1971), p. 41. No number for
/// downhill is known to us: people walk as on the level.
const UPHILL: [(f64, f64); 3] = [(0.05, 1.0), (0.10, 0.885), (0.20, 0.75)];

/// Angles of stairs \[rad\], and horizontal speeds down and up \[m/s\]: means of the two stairs of Fruin's table 3-B, p. 56.
const STAIRS: [(f64, [f64; 2]); 2] = [(0.4636, [0.77, 0.57]), (0.5567, [0.67, 0.51])];
/// \[m/s\] Mean speed on the level, to which they are compared (Weidmann 1993).
const LEVEL_SPEED: f64 = 1.34;

/// Returns the value at x on a polyline; outside, that of its end.
fn on_line(points: &[(f64, f64)], x: f64) -> f64 {
    let after = points.partition_point(|point| point.0 < x);
    match (after.checked_sub(1).map(|before| points[before]), points.get(after)) {
        (Some((x0, y0)), Some(&(x1, y1))) => y0 + (y1 - y0) * (x - x0) / (x1 - x0),
        (Some((_, y)), None) | (None, Some(&(_, y))) => y,
        (None, None) => 1.0,
    }
}

pub(crate) static GROUND: Schema = Schema {
    name: "Ground",
    attributes: &[
        ("Id", AttributeValue::Id),
        ("Downhill", AttributeValue::Number),
        ("Angle", AttributeValue::NotNegative),
        ("Held", AttributeValue::Share),
        ("Riser", AttributeValue::Positive),
        ("Tread", AttributeValue::Positive),
        ("SpeedDown", AttributeValue::Positive),
        ("SpeedUp", AttributeValue::Positive),
    ],
    children: &[&super::geometry::CORNER],
};

/// Reads a ground with an Id and corners.
pub(crate) fn read(element: Element<'_>, id: String, corners: Vec<Vec2>) -> Option<Ground> {
    let given = |attribute: &str| element.node.has(attribute).then(|| element.number(attribute));
    let downhill = element.number("Downhill");
    let speeds = [given("SpeedDown"), given("SpeedUp")];
    let name = quoted(&id);
    let incline = match ["Angle", "Held", "Riser", "Tread"].map(given) {
        [Some(angle), Some(held), None, None] => Incline::Slope { angle, held },
        [None, None, Some(riser), Some(tread)] => Incline::Stairs { riser, tread },
        _ => {
            let needs = "needs Angle and Held, of a slope, or Riser and Tread, of stairs";
            element.error(format!("ground {name} {needs}"));
            return None;
        }
    };
    let ground = Ground { id, area: Ring::through(corners)?, downhill, incline, speeds };
    // What is no number was said.
    let said = values(&ground).iter().flatten().any(|value| value.is_nan());
    if let (false, Err(why)) = (said, ground.check()) {
        element.error(format!("ground {}: {why}", quoted(&ground.id)));
    }
    Some(ground)
}

pub(crate) fn values(ground: &Ground) -> [Option<f64>; 7] {
    let [down, up] = ground.speeds;
    let downhill = Some(ground.downhill);
    match ground.incline {
        Incline::Slope { angle, held } => [downhill, Some(angle), Some(held), None, None, down, up],
        Incline::Stairs { riser, tread } => [downhill, None, None, Some(riser), Some(tread), down, up],
    }
}
