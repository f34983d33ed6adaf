//! `JuPedSim`'s trajectories: an SQLite database of version 1 or 2.

use super::{Found, LAST_FRAME, Rows, Told, rate_of};
use crate::error::RecordError;
use lemons_core::plane::vec2;
use rusqlite::config::DbConfig;
use rusqlite::limits::Limit;
use rusqlite::types::ValueRef;
use rusqlite::{Connection, OpenFlags};
use std::path::{Path, PathBuf};

/// Versions that are read. `JuPedSim` and `PedPy` read no others.
const VERSIONS: [&str; 2] = ["1", "2"];
/// \[bytes\] Largest text in a database.
const LARGEST_TEXT: i32 = 16 << 20;
/// Largest number of geometries.
const MOST_GEOMETRIES: usize = 1000;

/// Columns of the table, in the order in which they are read.
const COLUMNS: [&str; 6] = ["frame", "id", "pos_x", "pos_y", "ori_x", "ori_y"];

pub(super) fn read(path: &Path, told: &Told) -> Result<Found, RecordError> {
    let wrong = |message: String| RecordError::wrong(path, message);
    let broken = |error: rusqlite::Error| wrong(format!("is no sound database: {error}"));
    // What is not yet in the file itself would be missing.
    for end in ["-wal", "-journal"] {
        let mut beside = path.as_os_str().to_owned();
        beside.push(end);
        if PathBuf::from(beside).metadata().is_ok_and(|there| there.len() > 0) {
            return Err(wrong(format!(
                "there is a file {end} beside it: a program writes to the database, or did not end in order"
            )));
        }
    }
    let database = open(path).map_err(broken)?;
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
    if geometry.len() > MOST_GEOMETRIES {
        return Err(wrong(format!("has more than {MOST_GEOMETRIES} geometries")));
    }
    // Frames without anybody are only there.
    let frames = if table("frame_data") { frames(&database).map_err(broken)? } else { None };
    if let Some((first, last)) = frames.filter(|(first, last)| *first < 0 || *last > LAST_FRAME) {
        return Err(wrong(format!(
            "frame_data: column frame: from {first} to {last}: must be from 0 to {LAST_FRAME:e}"
        )));
    }
    let (rows, oriented) = rows(&database, path, broken)?;
    let what = rows.what;
    Ok(Found { what, rows: rows.rows, rate, frames, oriented, geometry })
}

/// Opens a database that is only read, and nothing written beside it.
fn open(path: &Path) -> rusqlite::Result<Connection> {
    // As a URI, in which all else is escaped. `immutable`: no locks, no files beside it.
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let text = absolute.to_string_lossy().replace('\\', "/");
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"/-_.~".contains(&byte);
    let escaped = |byte: u8| if plain(byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") };
    let uri: String = text.trim_start_matches('/').bytes().map(escaped).collect();
    let flags =
        OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX | OpenFlags::SQLITE_OPEN_URI;
    let database = Connection::open_with_flags(format!("file:///{uri}?immutable=1"), flags)?;
    // Nothing that a schema of others defines is run.
    database.set_db_config(DbConfig::SQLITE_DBCONFIG_DEFENSIVE, true)?;
    database.set_db_config(DbConfig::SQLITE_DBCONFIG_TRUSTED_SCHEMA, false)?;
    database.set_db_config(DbConfig::SQLITE_DBCONFIG_ENABLE_VIEW, false)?;
    database.set_limit(Limit::SQLITE_LIMIT_LENGTH, LARGEST_TEXT)?;
    database.pragma_update(None, "cell_size_check", "ON")?;
    Ok(database)
}

/// Returns the names of tables that have rows of their own: no views and no virtual tables.
fn tables(database: &Connection) -> rusqlite::Result<Vec<String>> {
    let mut tables =
        database.prepare("SELECT name FROM sqlite_schema WHERE type = 'table' AND rootpage > 0")?;
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
    let mut rows = found.query([])?;
    while let Some(row) = rows.next()?.filter(|_| all.len() <= MOST_GEOMETRIES) {
        let wkt: String = row.get(0)?;
        if !all.contains(&wkt) {
            all.push(wkt);
        }
    }
    Ok(all)
}

/// Returns the first and the last frame that the database names.
fn frames(database: &Connection) -> rusqlite::Result<Option<(i64, i64)>> {
    let row = database.query_row("SELECT min(frame), max(frame) FROM frame_data", [], |row| {
        Ok((row.get::<_, Option<i64>>(0)?, row.get::<_, Option<i64>>(1)?))
    })?;
    Ok(row.0.zip(row.1))
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
                    return Err(rows.wrong(n, format!("column {name}: {} is not {must}", shown(other))));
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
fn shown(value: ValueRef<'_>) -> String {
    match value {
        ValueRef::Null => "NULL".into(),
        ValueRef::Integer(value) => value.to_string(),
        ValueRef::Real(value) => format!("{value:?}"),
        ValueRef::Text(text) => format!("{:?}", String::from_utf8_lossy(&text[..text.len().min(40)])),
        ValueRef::Blob(_) => "a BLOB".into(),
    }
}
