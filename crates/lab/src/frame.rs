//! Frames: what pages keep of a run, and send back to ask about.

use crate::Refused;
use lemons_core::plane::{Motion, Pose, Twist, vec2};

/// Numbers of an agent in a frame: x, y \[m\], orientation \[rad\], velocity along x and y \[m/s\], angular velocity
/// \[rad/s\], mean squeeze of the last communication step \[N\], number of contacts. The place of who has left is not a
/// number.
pub const COLUMNS: usize = 8;

/// Reads a frame of so many people.
///
/// # Errors
/// The bytes are of another length.
pub fn frame(bytes: &[u8], people: usize) -> Result<Vec<Motion>, Refused> {
    if bytes.len() != 8 * COLUMNS * people {
        return Err(Refused(format!("a frame of {people} people has not {} bytes", bytes.len())));
    }
    let (numbers, _) = bytes.as_chunks::<8>();
    let numbers: Vec<f64> = numbers.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
    let (rows, _) = numbers.as_chunks::<COLUMNS>();
    let motion = |&[x, y, orientation, vx, vy, angular_velocity, ..]: &[f64; COLUMNS]| Motion {
        pose: Pose { position: vec2(x, y), orientation },
        twist: Twist { velocity: vec2(vx, vy), angular_velocity },
    };
    Ok(rows.iter().map(motion).collect())
}
