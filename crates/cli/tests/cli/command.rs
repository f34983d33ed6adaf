//! The command as its users meet it: exit codes, messages, files.

use crate::common::{default_trial, done};
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// Releases have the file beside the libraries' directories.
#[test]
fn an_fmu_holds_the_licences_that_are_beside_its_library_or_above() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let release = at.join("releases/this");
    let from = release.join("win64");
    fs::create_dir_all(&from).unwrap();
    // Small ones: nobody loads them here.
    fs::write(from.join("crowd"), "MZ CrowdMechanics").unwrap();
    fs::write(from.join("decision"), "MZ decision.toml").unwrap();
    let push = default_trial();
    let door = push.with_file_name("Trial_door");
    // What an FMU holds of them, packed in this directory from a library in that one.
    let held = |working: &Path, place: &str, call: &str, fmi: &str| {
        let (trial, name) = if call == "pack" { (&push, "crowd") } else { (&door, "decision") };
        let binary = format!("win64={place}{name}");
        let fmu = at.join("x.fmu");
        let files = ["--binary", &binary, "--force", "-o", fmu.to_str().unwrap()];
        done(working, &[&[call, trial.to_str().unwrap(), "--fmi", fmi][..], &files].concat());
        let mut fmu = zip::ZipArchive::new(fs::File::open(fmu).unwrap()).unwrap();
        let mut text = String::new();
        let mut entry = fmu.by_name("documentation/licenses/THIRD-PARTY.txt").ok()?;
        std::io::Read::read_to_string(&mut entry, &mut text).unwrap();
        Some(text)
    };
    let each_holds = |expected: Option<&str>| {
        let absolute = from.to_str().unwrap().to_owned() + "/";
        for (working, place) in
            [(at, &*absolute), (&release, "win64/"), (&from, ""), (&from, "./"), (&from, "../win64/")]
        {
            for (call, fmi) in [("pack", "2"), ("pack", "3"), ("decide", "2"), ("decide", "3")] {
                let found = held(working, place, call, fmi);
                assert_eq!(found.as_deref(), expected, "{}, {place:?}, {call}, {fmi}", working.display());
            }
        }
    };
    fs::write(at.join("THIRD-PARTY.txt"), "somebody else's").unwrap();
    fs::write(at.join("releases/THIRD-PARTY.txt"), "of no release").unwrap();
    each_holds(None);
    fs::write(release.join("THIRD-PARTY.txt"), "of all platforms").unwrap();
    each_holds(Some("of all platforms"));
    fs::write(from.join("THIRD-PARTY.txt"), "of this one").unwrap();
    each_holds(Some("of this one"));
    fs::remove_file(release.join("THIRD-PARTY.txt")).unwrap();
    each_holds(Some("of this one"));
}
