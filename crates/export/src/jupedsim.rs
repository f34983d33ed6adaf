//! JuPedSim's trajectories: an SQLite database of version 2.

use crate::area::walkable_area;
use crate::error::ExportError;
use crate::run::Run;
use crowd_mechanics::files::{Staged, WriteError};
use crowd_mechanics::trial::Wall;
use rusqlite::{Connection, params};
use std::io;
use std::path::Path;

const TABLES: &str = "
    CREATE TABLE trajectory_data (
        frame INTEGER NOT NULL, id INTEGER NOT NULL, pos_x REAL NOT NULL, pos_y REAL NOT NULL,
        ori_x REAL NOT NULL, ori_y REAL NOT NULL);
    CREATE TABLE metadata (key TEXT NOT NULL UNIQUE PRIMARY KEY, value TEXT NOT NULL);
    CREATE TABLE geometry (hash INTEGER NOT NULL, wkt TEXT NOT NULL);
    CREATE UNIQUE INDEX geometry_hash ON geometry (hash);
    CREATE TABLE frame_data (frame INTEGER NOT NULL, geometry_hash INTEGER NOT NULL);
    CREATE INDEX frame_id_idx ON trajectory_data (frame, id);";

/// Writes a database that JuPedSim's viewer and PedPy read: positions \[m\], the direction of the gaze, the walkable
/// area from the walls. Answers what is to be said of that area.
///
/// # Errors
/// No constant frame rate, or the file cannot be written.
pub fn jupedsim(run: &Run, walls: &[Wall], path: &Path) -> Result<Vec<String>, ExportError> {
    let rate = run.frame_rate()?;
    let written = || {
        let mut staged = Staged::beside(path)?;
        let said = staged.fill(|file| fill(file, run, walls, rate).map_err(io::Error::other))?;
        staged.persist().map(|()| said)
    };
    Ok(written().map_err(WriteError::at(path))?)
}

fn fill(file: &Path, run: &Run, walls: &[Wall], rate: f64) -> rusqlite::Result<Vec<String>> {
    let area = walkable_area(walls, run.positions());
    let hash = hash(&area.wkt);
    let mut database = Connection::open(file)?;
    // No journal beside it: a file that is not complete is removed.
    database.pragma_update(None, "journal_mode", "OFF")?;
    database.execute_batch(TABLES)?;
    let transaction = database.transaction()?;
    {
        let mut metadata = transaction.prepare("INSERT INTO metadata VALUES (?, ?)")?;
        metadata.execute(["version", "2"])?;
        metadata.execute(["fps", &format!("{rate:?}")])?;
        let limits =
            [("xmin", area.low.x), ("xmax", area.high.x), ("ymin", area.low.y), ("ymax", area.high.y)];
        for (key, value) in limits {
            metadata.execute([key, &format!("{value:?}")])?;
        }
        transaction.execute("INSERT INTO geometry VALUES (?, ?)", params![hash, area.wkt])?;
        let mut rows = transaction.prepare("INSERT INTO trajectory_data VALUES (?, ?, ?, ?, ?, ?)")?;
        let mut frames = transaction.prepare("INSERT INTO frame_data VALUES (?, ?)")?;
        let numbers = run.names().numbers;
        for (at, frame) in run.frames.iter().enumerate() {
            let at = at as i64;
            frames.execute([at, hash])?;
            for (number, agent) in numbers.iter().zip(&frame.agents) {
                let (x, y) = (agent.position.x, agent.position.y);
                rows.execute(params![at, number, x, y, libm::cos(agent.theta), libm::sin(agent.theta)])?;
            }
        }
    }
    transaction.commit()?;
    database.close().map_err(|(_, error)| error)?;
    Ok(area.said)
}

/// FNV-1a: any number would do that tells geometries apart.
fn hash(text: &str) -> i64 {
    let sum = text
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325_u64, |sum, byte| (sum ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
    i64::from_ne_bytes(sum.to_ne_bytes())
}
