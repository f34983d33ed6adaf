//! The command as its users meet it: exit codes, messages, files.

use crate::common::{assert_code, default_trial, done, lemons};
use lemons_master::{Observer, Prepared, Reached, Settings, System};
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
    fs::write(from.join("crowd"), [lemons_testing::pe(), b"CrowdMechanics".to_vec()].concat()).unwrap();
    fs::write(from.join("decision"), [lemons_testing::pe(), b"decision.toml".to_vec()].concat()).unwrap();
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

/// The poses of a run, in bits.
struct Poses(Vec<[u64; 4]>);

impl Observer<System> for Poses {
    type Error = lemons_master::Error;

    fn look(&mut self, system: &mut System, reached: Reached) -> Result<(), Self::Error> {
        let crowd = &system.components()[0].instance;
        for i in 0..5 {
            let mut pose = [0.0; 3];
            let names = ["Position.x", "Position.y", "Theta"].map(|name| format!("agent[{i}].{name}"));
            crowd.get_real(&crowd.select(names)?, &mut pose)?;
            self.0.push([reached.time, pose[0], pose[1], pose[2]].map(f64::to_bits));
        }
        Ok(())
    }
}

/// A program that has no command line gets what the command writes.
#[test]
fn settings_give_the_bits_that_the_command_writes() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let good = default_trial();
    let parameter = "contact.human_naked.human_naked.KineticFriction";
    let set = format!("{parameter}=0.2");
    assert_code(
        &lemons(at, &["run", good.to_str().unwrap(), "--until", "1.2", "--set", &set, "-o", "t.csv"]),
        0,
    );
    let table = fs::read_to_string(at.join("t.csv")).unwrap();
    let rows = table.lines().filter(|line| line.starts_with(|first: char| first.is_ascii_digit()));
    let header: Vec<&str> = table.lines().find(|line| line.contains(",x")).unwrap().split(',').collect();
    let columns = ["t", "x", "y", "theta"].map(|name| {
        // Perhaps with its unit.
        let named = |column: &&str| column.split_whitespace().next() == Some(name);
        header.iter().position(named).unwrap_or_else(|| panic!("{name}: {header:?}"))
    });
    let rows = rows.map(|row| {
        let cells: Vec<&str> = row.split(',').collect();
        columns.map(|place| cells[place].parse::<f64>().unwrap().to_bits())
    });
    // The first rows are those of the start.
    let written: Vec<[u64; 4]> = rows.skip(5).collect();
    let parameters = vec![(parameter.to_owned(), "0.2".to_owned())];
    let settings = Settings { parameters, until: Some(1.2), ..Settings::of(good) };
    let mut run = Prepared::of(&settings).unwrap();
    let mut poses = Poses(Vec::new());
    let _ = run.simulate(&mut poses).unwrap();
    assert_eq!(written.len(), 5 * 24);
    assert!(written == poses.0, "other bits");
}
