//! `JuPedSim`'s trajectories: an SQLite database of version 1 or 2.

use super::{Found, FrameNumbers, LAST_FRAME, Rows, Told, gcd, rate_of};
use crate::error::RecordError;
use lemons_core::plane::vec2;
use rusqlite::config::DbConfig;
use rusqlite::limits::Limit;
use rusqlite::types::ValueRef;
use rusqlite::{Connection, ErrorCode, OpenFlags};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Versions that are read. `JuPedSim` and `PedPy` read no others.
const VERSIONS: [&str; 2] = ["1", "2"];
/// \[bytes\] Largest text in a database.
const LARGEST_TEXT: i32 = 16 << 20;
/// Largest number of geometries.
const MOST_GEOMETRIES: usize = 1000;
/// \[bytes\] Largest sum of their texts.
const LARGEST_GEOMETRIES: usize = 64 << 20;
/// Largest number of operations of SQLite: as many rows as may be need less than half of them. Pages of a database may
/// name each other so that its tables have no end.
const MOST_OPERATIONS: i32 = 500_000_000;
/// Number of operations after which it is asked whether to go on.
const OPERATIONS: i32 = 100;
/// Longest time: an operation may take long where a row pretends to be large.
const LONGEST: Duration = Duration::from_secs(600);

/// Columns of the table, in the order in which they are read.
const COLUMNS: [&str; 6] = ["frame", "id", "pos_x", "pos_y", "ori_x", "ori_y"];

pub(super) fn read(path: &Path, held: &Path, told: &Told) -> Result<Found, RecordError> {
    read_within(path, held, told, MOST_OPERATIONS)
}

/// Reads it with at most so many operations.
fn read_within(path: &Path, held: &Path, told: &Told, operations: i32) -> Result<Found, RecordError> {
    let wrong = |message: String| RecordError::wrong(path, message);
    let broken = |error: rusqlite::Error| match error.sqlite_error_code() {
        Some(ErrorCode::OperationInterrupted) => wrong(format!(
            "to read its tables takes more than {operations} operations of SQLite, or {} s: too many",
            LONGEST.as_secs()
        )),
        _ => wrong(format!("is no sound database: {error}")),
    };
    // What is not yet in the file itself would be missing.
    for end in ["-wal", "-journal"] {
        let mut beside = held.as_os_str().to_owned();
        beside.push(end);
        if PathBuf::from(beside).metadata().is_ok_and(|there| there.len() > 0) {
            return Err(wrong(format!(
                "there is a file {end} beside it: a program writes to the database, or did not end in order"
            )));
        }
    }
    let database = open(held, operations).map_err(broken)?;
    let tables = tables(&database).map_err(broken)?;
    let table = |name: &str| tables.iter().any(|table| table == name);
    for name in ["trajectory_data", "metadata"] {
        if !table(name) {
            return Err(wrong(format!("is a database, but not of JuPedSim: it has no table {name:?}")));
        }
    }
    let version = metadata(&database, "version").map_err(broken)?;
    match version.as_deref() {
        Some(known) if VERSIONS.contains(&known) => {}
        Some(other) => {
            return Err(wrong(format!("metadata: version is {other:?}: versions 1 and 2 are read")));
        }
        None => return Err(wrong("metadata: there is no version".into())),
    }
    let rate = metadata(&database, "fps").map_err(broken)?.map(|text| {
        text.trim().parse().map_err(|_| wrong(format!("metadata: fps is {text:?}, which is not a number")))
    });
    let rate = rate_of(path, rate.transpose()?, told.rate)?;
    if told.per_metre.is_some_and(|units| units != 1.0) {
        return Err(wrong("a database is in m: --unit is for texts".into()));
    }
    let geometry = if table("geometry") { geometries(&database).map_err(broken)? } else { Vec::new() };
    if geometry.len() > MOST_GEOMETRIES
        || geometry.iter().map(String::len).sum::<usize>() > LARGEST_GEOMETRIES
    {
        return Err(wrong(format!(
            "has more than {MOST_GEOMETRIES} geometries, or their texts are larger than {LARGEST_GEOMETRIES} bytes"
        )));
    }
    // Frames without anybody are only there.
    let frames = if table("frame_data") { frames(&database).map_err(broken)? } else { None };
    if let Some(FrameNumbers { first, last, .. }) =
        frames.as_ref().filter(|all| all.first < 0 || all.last > LAST_FRAME)
    {
        return Err(wrong(format!(
            "frame_data: column frame: from {first} to {last}: must be from 0 to {LAST_FRAME:e}"
        )));
    }
    let (rows, oriented) = rows(&database, path, broken)?;
    let what = rows.what;
    Ok(Found { what, rows: rows.rows, rate, frames, oriented, geometry, names: None, notes: Vec::new() })
}

/// Opens a database that is only read, and nothing written beside it, for so many operations.
fn open(path: &Path, operations: i32) -> rusqlite::Result<Connection> {
    // As a URI, in which all else is escaped. `immutable`: no locks, no files beside it.
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let text = absolute.to_string_lossy().replace('\\', "/");
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"/-_.~".contains(&byte);
    let escaped = |byte: u8| if plain(byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") };
    let uri: String = text.trim_start_matches('/').bytes().map(escaped).collect();
    let flags =
        OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX | OpenFlags::SQLITE_OPEN_URI;
    let database = Connection::open_with_flags(format!("file:///{uri}?immutable=1"), flags)?;
    let (mut left, begin) = (operations / OPERATIONS, Instant::now());
    let stop = move || {
        left -= 1;
        left <= 0 || begin.elapsed() > LONGEST
    };
    database.progress_handler(OPERATIONS, Some(stop))?;
    // Nothing that a schema of others defines is run.
    database.set_db_config(DbConfig::SQLITE_DBCONFIG_DEFENSIVE, true)?;
    database.set_db_config(DbConfig::SQLITE_DBCONFIG_TRUSTED_SCHEMA, false)?;
    database.set_db_config(DbConfig::SQLITE_DBCONFIG_ENABLE_VIEW, false)?;
    database.set_limit(Limit::SQLITE_LIMIT_LENGTH, LARGEST_TEXT)?;
    database.pragma_update(None, "cell_size_check", "ON")?;
    Ok(database)
}

/// Returns the names of those tables that have rows of their own: no views and no virtual tables.
fn tables(database: &Connection) -> rusqlite::Result<Vec<String>> {
    let mut tables = database.prepare(
        "SELECT DISTINCT name FROM sqlite_schema WHERE type = 'table' AND rootpage > 0
         AND name IN ('trajectory_data', 'metadata', 'geometry', 'frame_data')",
    )?;
    tables.query_map([], |row| row.get(0))?.collect()
}

fn metadata(database: &Connection, key: &str) -> rusqlite::Result<Option<String>> {
    let mut found = database.prepare("SELECT CAST(value AS TEXT) FROM metadata WHERE key = ?")?;
    let mut rows = found.query([key])?;
    rows.next()?.map(|row| row.get(0)).transpose()
}

/// Returns the geometries that differ, in the order of the file; at most one more than may be.
fn geometries(database: &Connection) -> rusqlite::Result<Vec<String>> {
    let mut found = database.prepare("SELECT wkt FROM geometry")?;
    let mut all: Vec<String> = Vec::new();
    let mut bytes = 0;
    let mut rows = found.query([])?;
    while bytes <= LARGEST_GEOMETRIES
        && all.len() <= MOST_GEOMETRIES
        && let Some(row) = rows.next()?
    {
        let wkt: String = row.get(0)?;
        if !all.contains(&wkt) {
            bytes += wkt.len();
            all.push(wkt);
        }
    }
    Ok(all)
}

/// Returns the frames that the database names.
fn frames(database: &Connection) -> rusqlite::Result<Option<FrameNumbers>> {
    let mut found = database.prepare("SELECT frame FROM frame_data WHERE frame IS NOT NULL")?;
    let mut rows = found.query([])?;
    let mut all: Option<FrameNumbers> = None;
    while let Some(row) = rows.next()? {
        let frame = row.get(0)?;
        let FrameNumbers { first, last, step } =
            all.unwrap_or(FrameNumbers { first: frame, last: frame, step: 0 });
        // What cannot be is refused later.
        let apart = frame.checked_sub(first).and_then(i64::checked_abs).unwrap_or(1);
        all = Some(FrameNumbers { first: first.min(frame), last: last.max(frame), step: gcd(step, apart) });
    }
    Ok(all)
}

/// Reads the rows, and whether each has a direction.
fn rows<'a>(
    database: &Connection,
    path: &'a Path,
    broken: impl Fn(rusqlite::Error) -> RecordError,
) -> Result<(Rows<'a>, bool), RecordError> {
    let mut known =
        database.prepare("SELECT name FROM pragma_table_info('trajectory_data')").map_err(&broken)?;
    let known: rusqlite::Result<Vec<String>> =
        known.query_map([], |row| row.get(0)).and_then(Iterator::collect);
    let known = known.map_err(&broken)?;
    if let Some(missing) = COLUMNS.iter().find(|column| !known.iter().any(|name| name == *column)) {
        return Err(RecordError::wrong(path, format!("trajectory_data: there is no column {missing:?}")));
    }
    let select = format!("SELECT {} FROM trajectory_data", COLUMNS.join(", "));
    let mut found = database.prepare(&select).map_err(&broken)?;
    let mut found = found.query([]).map_err(&broken)?;
    let (mut rows, mut oriented) = (Rows::new(path, "trajectory_data: row"), true);
    let mut n = 0;
    while let Some(row) = found.next().map_err(&broken)? {
        n += 1;
        let mut whole = [0; 2];
        let mut numbers = [0.0; 4];
        for (k, name) in COLUMNS.iter().enumerate() {
            match (k, row.get_ref(k).map_err(&broken)?) {
                (0..2, ValueRef::Integer(value)) => whole[k] = value,
                (2.., ValueRef::Real(value)) => numbers[k - 2] = value,
                (2.., ValueRef::Integer(value)) => numbers[k - 2] = value as f64,
                (_, other) => {
                    let must = if k < 2 { "a whole number" } else { "a number" };
                    return Err(rows.wrong(n, format!("column {name}: {} is not {must}", excerpt(other))));
                }
            }
        }
        let ([frame, id], [x, y, ori_x, ori_y]) = (whole, numbers);
        // A direction of length 0 is none.
        let directed = ori_x.is_finite() && ori_y.is_finite() && (ori_x, ori_y) != (0.0, 0.0);
        oriented &= directed;
        let orientation = if directed { libm::atan2(ori_y, ori_x) } else { f64::NAN };
        rows.add(n, id, frame, vec2(x, y), orientation)?;
    }
    Ok((rows, oriented))
}

/// Returns a value as messages show it.
fn excerpt(value: ValueRef<'_>) -> String {
    match value {
        ValueRef::Null => "NULL".into(),
        ValueRef::Integer(value) => value.to_string(),
        ValueRef::Real(value) => format!("{value:?}"),
        ValueRef::Text(text) => format!("{:?}", String::from_utf8_lossy(&text[..text.len().min(40)])),
        ValueRef::Blob(_) => "a BLOB".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_without_an_end_is_not_read_on_and_on() {
        let at = tempfile::tempdir().unwrap();
        let path = at.path().join("walk.sqlite");
        let database = Connection::open(&path).unwrap();
        let tables = "CREATE TABLE trajectory_data (frame INTEGER, id INTEGER, pos_x REAL, pos_y REAL, ori_x REAL, ori_y REAL);
            INSERT INTO trajectory_data VALUES (0, 1, 0.0, 0.0, 1.0, 0.0);
            CREATE TABLE metadata (key TEXT, value TEXT);
            INSERT INTO metadata VALUES ('version', '2'), ('fps', '10');
            CREATE TABLE frame_data (frame INTEGER, geometry_hash INTEGER);
            WITH RECURSIVE n(k) AS (SELECT 0 UNION ALL SELECT k + 1 FROM n WHERE k < 9999) INSERT INTO frame_data SELECT k, 1 FROM n;";
        database.execute_batch(tables).unwrap();
        let read = |operations| read_within(&path, &path, &Told::default(), operations);
        assert_eq!(
            read(100_000).unwrap().frames.map(|all| (all.first, all.last, all.step)),
            Some((0, 9999, 1))
        );
        let message = read(20_000).err().unwrap().to_string();
        assert!(
            message.contains("walk.sqlite: to read its tables takes more than 20000 operations"),
            "{message}"
        );
    }
}
