//! Files to keep: a Trial as a zip, as an FMU.

use crate::upload::Driven;
use crate::{Refused, Reply};
use crowd_mechanics::pack::{Binary, Format, Naming, Package};
use lemons_files::source::Memory;
use lemons_people::zip_trial;
use lemons_trial::DRIVE_FILE;
use serde::Deserialize;
use serde_json::json;
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// A file.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "file", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Wanted {
    /// The Trial's directory in a zip.
    Trial,
    /// An FMU. The bytes are its binaries, one after the other.
    Fmu {
        /// 2 or 3.
        version: u8,
        /// FMI's name of each binary's platform, and its length.
        binaries: Vec<(String, usize)>,
    },
}

/// Returns the file and its name.
///
/// # Errors
/// It cannot be made of this Trial, or the binaries are not as long as is said.
pub fn take(wanted: &Wanted, of: &Driven, bytes: &[u8]) -> Result<Reply, Refused> {
    let Driven { trial, text: drive, .. } = of;
    match wanted {
        Wanted::Trial => {
            let others: &[_] = if drive.is_empty() { &[] } else { &[(DRIVE_FILE, &drive[..])] };
            let zip = zip_trial(trial, others, Cursor::new(Vec::new())).map_err(Refused::of)?;
            Ok(Reply { value: json!({ "name": format!("{}.zip", trial.name) }), bytes: zip.into_inner() })
        }
        Wanted::Fmu { version, binaries } => {
            let format = match version {
                2 => Format::Fmi2(Naming::default()),
                3 => Format::Fmi3,
                _ => return Err(Refused(format!("FMI {version}: the versions are 2 and 3"))),
            };
            let mut files = Memory::default();
            for (path, text) in trial.texts(Path::new(&trial.name)) {
                files.put(&path, text.into_bytes());
            }
            if !drive.is_empty() {
                files.put(&Path::new(&trial.name).join(DRIVE_FILE), drive.clone().into_bytes());
            }
            let mut package =
                Package { trials: vec![PathBuf::from(&trial.name)], format, ..Package::default() };
            let mut rest = bytes;
            for (platform, length) in binaries {
                let Some((content, others)) = rest.split_at_checked(*length) else {
                    return Err(Refused("the binaries are shorter than is said".into()));
                };
                let path = PathBuf::from(format!("binary of {platform}"));
                files.put(&path, content.to_vec());
                package.binaries.push(Binary { platform: platform.clone(), path });
                rest = others;
            }
            let name = format!("{}.fmu", trial.name);
            let mut fmu = Cursor::new(Vec::new());
            package.write_to(&files, Path::new(&name), &mut fmu).map_err(Refused::of)?;
            Ok(Reply { value: json!({ "name": name }), bytes: fmu.into_inner() })
        }
    }
}
