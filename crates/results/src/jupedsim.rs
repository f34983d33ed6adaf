//! JuPedSim's trajectories: an SQLite database of version 2, which its releases and PedPy read. (DESIGN.md says what
//! version 3 is.)

use crate::area::Area;
use crate::error::RecordError;
use crate::record::Record;
use crate::run::Frame;
use lemons_core::files::{Staged, WriteError};
use lemons_core::plane::{Bounds, Pose};
use rusqlite::{Connection, OpenFlags, params};
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

/// Hash of the geometry: any number that tells those of a database apart, and there is only one.
const GEOMETRY: i64 = 1;

/// Writes a database that JuPedSim and PedPy read, with positions \[m\], the direction of the gaze as a unit vector, and
/// the walkable area. The metadata say what the area was made of.
///
/// # Errors
/// The run has no constant frame rate, or the file cannot be written.
pub fn jupedsim(record: &Record, area: &Area, path: &Path) -> Result<(), RecordError> {
    let rate = record.frame_rate()?;
    let mut staged = Staged::beside(path).map_err(WriteError::at(path))?;
    let filled = staged.fill(|file| Ok(fill(file, record, area, rate, path)));
    filled.map_err(WriteError::at(path))??;
    Ok(staged.persist().map_err(WriteError::at(path))?)
}

/// Fills a database; messages call it `path`.
fn fill(file: &Path, record: &Record, area: &Area, rate: f64, path: &Path) -> Result<(), RecordError> {
    let cannot = |error: rusqlite::Error| RecordError::from(WriteError::at(path)(io::Error::other(error)));
    // The file is there. One that was taken away as the program ends is not made anew.
    let flags = OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let mut database = Connection::open_with_flags(file, flags).map_err(cannot)?;
    // No journal beside it: a file that is not complete is removed.
    database.pragma_update(None, "journal_mode", "OFF").map_err(cannot)?;
    database.execute_batch(TABLES).map_err(cannot)?;
    let transaction = database.transaction().map_err(cannot)?;
    head(&transaction, area, rate).map_err(cannot)?;
    let (first, numbers) = (record.first_number(), record.numbers());
    record.each(|at, frame| insert(&transaction, first + at as i64, &frame, &numbers).map_err(cannot))?;
    transaction.commit().map_err(cannot)?;
    database.close().map_err(|(_, error)| cannot(error))
}

/// Writes a frame with the rows of those who are there.
fn insert(database: &Connection, at: i64, frame: &Frame, numbers: &[i64]) -> rusqlite::Result<()> {
    database.prepare_cached("INSERT INTO frame_data VALUES (?, ?)")?.execute([at, GEOMETRY])?;
    let mut rows = database.prepare_cached("INSERT INTO trajectory_data VALUES (?, ?, ?, ?, ?, ?)")?;
    for (place, agent) in frame.present() {
        let (number, Pose { position, orientation }) = (numbers[place], agent.pose);
        // No direction where none is known.
        let known = orientation.is_finite();
        let (sin, cos) = if known { (libm::sin(orientation), libm::cos(orientation)) } else { (0.0, 0.0) };
        rows.execute(params![at, number, position.x, position.y, cos, sin])?;
    }
    Ok(())
}

/// Writes what stands before the rows.
fn head(database: &Connection, area: &Area, rate: f64) -> rusqlite::Result<()> {
    let Bounds { low, high } = area.polygon.outer.bounds();
    let mut metadata = database.prepare("INSERT INTO metadata VALUES (?, ?)")?;
    metadata.execute(["version", "2"])?;
    let numbers = [("fps", rate), ("xmin", low.x), ("xmax", high.x), ("ymin", low.y), ("ymax", high.y)];
    for (key, value) in numbers {
        metadata.execute([key, &format!("{value:?}")])?;
    }
    metadata.execute(["walkable_area", &area.messages.join("; ")])?;
    database.execute("INSERT INTO geometry VALUES (?, ?)", params![GEOMETRY, area.polygon.to_wkt()])?;
    Ok(())
}
