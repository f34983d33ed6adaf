//! Builds in the Trial of the environment variable `TRIAL`, if there is one: all files of its directory.

use std::error::Error;
use std::fmt::Write;
use std::path::{Path, PathBuf};

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-env-changed=TRIAL");
    println!("cargo::rustc-check-cfg=cfg(built_in)");
    let output = PathBuf::from(std::env::var("OUT_DIR")?).join("built_in.rs");
    let Some(trial) = std::env::var_os("TRIAL").filter(|trial| !trial.is_empty()) else {
        return Ok(std::fs::write(output, "")?);
    };
    let trial = std::fs::canonicalize(trial)?;
    let name = trial.file_name().and_then(|name| name.to_str()).ok_or("TRIAL has no name")?;
    println!("cargo::rustc-cfg=built_in");
    println!("cargo::rerun-if-changed={}", trial.display());
    let mut code = format!("const BUILT_IN: &[(&str, &[u8])] = &[({:?}, b{:?}),", "trials.txt", name);
    add(&mut code, &trial, name)?;
    code.push_str("];");
    Ok(std::fs::write(output, code)?)
}

/// Adds the files of a directory, in order.
fn add(code: &mut String, directory: &Path, name: &str) -> Result<(), Box<dyn Error>> {
    let mut paths = std::fs::read_dir(directory)?
        .map(|entry| Ok(entry?.path()))
        .collect::<Result<Vec<_>, std::io::Error>>()?;
    paths.sort();
    for path in paths {
        let part = path.file_name().and_then(|part| part.to_str()).ok_or("a name is not UTF-8 text")?;
        let name = format!("{name}/{part}");
        if path.is_dir() {
            add(code, &path, &name)?;
        } else {
            write!(
                code,
                "({name:?}, include_bytes!({:?})),",
                path.to_str().ok_or("a path is not UTF-8 text")?
            )?;
        }
    }
    Ok(())
}
