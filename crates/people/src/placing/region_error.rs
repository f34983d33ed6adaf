//! Why there is no region.

/// \[m\] Corners further from the origin are refused: up to there a millimetre is exact.
pub(super) const FARTHEST: f64 = 1e6;
/// \[m²\] Smallest allowed area of a polygon or hole.
pub(super) const SMALLEST_AREA: f64 = 1e-6;
/// Largest number of corners of all rings together: all pairs of edges are compared.
pub(super) const MOST_CORNERS: usize = 10_000;

/// Why a polygon cannot be a region.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RegionError {
    /// A corner that is not finite or too far out.
    #[error("{ring}: corner {corner} at ({x:?}, {y:?}) m is not within {FARTHEST} m of the origin")]
    Corner {
        /// Name of the polygon.
        ring: String,
        /// Index of the corner.
        corner: usize,
        /// \[m\] x of the corner.
        x: f64,
        /// \[m\] y of the corner.
        y: f64,
    },
    /// A polygon with fewer than three different corners.
    #[error("{ring}: has {corners} different corners; at least 3 are needed")]
    TooFewCorners {
        /// Name of the polygon.
        ring: String,
        /// Number of corners that differ from the one before.
        corners: usize,
    },
    /// Too many corners.
    #[error("{corners} corners; at most {MOST_CORNERS} are allowed")]
    TooManyCorners {
        /// Number of corners of all polygons together.
        corners: usize,
    },
    /// A polygon without an inside.
    #[error("{ring}: its area is {area} m²; at least {SMALLEST_AREA} m² is needed")]
    NoArea {
        /// Name of the polygon.
        ring: String,
        /// \[m²\] Its area.
        area: f64,
    },
    /// Two edges cross or touch.
    #[error("{first} and {second} cross or touch near ({x}, {y}) m")]
    Crossing {
        /// Name of an edge.
        first: String,
        /// Name of the other edge.
        second: String,
        /// \[m\] x of the place.
        x: f64,
        /// \[m\] y of the place.
        y: f64,
    },
    /// A hole outside the outer polygon or in another hole.
    #[error("{ring} does not lie inside the outer polygon and outside the other holes")]
    HoleOutside {
        /// Name of the hole.
        ring: String,
    },
    /// A wall of a Trial that does not end at its first corner.
    #[error(
        "wall {id} is not closed: its first corner is {first:?}, its last corner {last:?} (repeat the first one at the end)"
    )]
    OpenWall {
        /// Id of the wall.
        id: String,
        /// \[m\] first corner.
        first: (f64, f64),
        /// \[m\] last corner.
        last: (f64, f64),
    },
    /// A part that is not inside the whole.
    #[error("it goes beyond the room or over an obstacle")]
    Beyond,
    /// A polygon of which walls and earlier regions leave nothing.
    #[error("{}", nothing_left(obstacles))]
    NothingLeft {
        /// Ids of the closed walls that were taken for obstacles.
        obstacles: Vec<String>,
    },
    /// A Trial without walls.
    #[error("no walls: nothing bounds the region")]
    NoWalls,
}

fn nothing_left(obstacles: &[String]) -> String {
    let why = match obstacles {
        [] => "earlier regions cover it".to_owned(),
        [one] => format!("the closed wall {one} is an obstacle"),
        many => format!("the closed walls {} are obstacles", many.join(", ")),
    };
    format!("no ground is left: {why} (a closed wall is a room where it holds more than half of the region)")
}
