//! The controller FMU of the coupling tests, compiled and packed; shared by the tests of several crates.

use crowd_mechanics::pack::host_platform;
use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::process::Command;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// Of the controller; tests put other texts into it.
pub const DESCRIPTION: &str = include_str!("modelDescription.xml");

/// Writes an FMU of the controller with a model description; `binary` is false where nobody runs it.
pub fn write_controller(path: &Path, description: &str, binary: bool) {
    let mut files = vec![("modelDescription.xml".to_owned(), description.as_bytes().to_vec())];
    if binary {
        let name =
            format!("binaries/{}/controller{}", host_platform().unwrap(), std::env::consts::DLL_SUFFIX);
        files.push((name, compiled(path, "controller.c", &[])));
    }
    let files: Vec<(&str, &[u8])> =
        files.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice())).collect();
    write_zip(path, &files);
}

/// The library that a C file of this directory becomes; it is written beside a path.
pub fn compiled(path: &Path, file: &str, flags: &[&str]) -> Vec<u8> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/coupling").join(file);
    let library = path.with_extension("compiled");
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".into());
    let mut command = Command::new(compiler);
    command
        .args(["-shared", "-fPIC", "-O1", "-ffp-contract=off"])
        .args(flags)
        .arg("-o")
        .arg(&library)
        .arg(source);
    assert!(command.status().unwrap().success());
    std::fs::read(library).unwrap()
}

/// Writes a zip of these files.
pub fn write_zip(path: &Path, files: &[(&str, &[u8])]) {
    let mut zip = ZipWriter::new(File::create(path).unwrap());
    for (name, bytes) in files {
        zip.start_file(*name, SimpleFileOptions::default()).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap();
}
