//! References in FMUs: what was packed is found again, what was changed is found, what is broken is said.

use crate::packed;
use crowd_mechanics::pack::{FmuFormat, Naming};
use lemons_core::trial::DriveChoice;
use lemons_master::{DecisionChoice, Experiment, ReplayedExperiment, TrialInput, add_reference, replay};
use std::fs::File;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

const PLACE: &str = "extra/org.fmi-standard.fmi-ls-ref";

/// The FMU of the paper's push with a reference of half a second.
fn referenced(directory: &Path, format: FmuFormat) -> PathBuf {
    let path = packed(directory, format);
    let trial = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../resources/Trial_push");
    let trial = TrialInput::open(&trial).unwrap();
    let (documents, ..) = trial.documents(&DriveChoice::Own, &DecisionChoice::Own).unwrap();
    let experiment = Experiment { until: Some(0.5), ..Experiment::default() };
    add_reference(&path, &path, documents, &experiment).unwrap();
    path
}

/// A copy in which the content of a file is another one, or in which it is missing.
fn changed(fmu: &Path, name: &str, change: impl Fn(&str) -> Option<Vec<u8>>) -> PathBuf {
    let path = fmu.with_file_name("changed.fmu");
    let mut from = ZipArchive::new(File::open(fmu).unwrap()).unwrap();
    let mut to = ZipWriter::new(File::create(&path).unwrap());
    let mut found = false;
    for k in 0..from.len() {
        let mut entry = from.by_index(k).unwrap();
        let own = entry.name().unwrap().into_owned();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).unwrap();
        if own == name {
            found = true;
            let Some(new) = change(&String::from_utf8(bytes).unwrap()) else { continue };
            bytes = new;
        }
        to.start_file(own, SimpleFileOptions::default().compression_method(CompressionMethod::Stored))
            .unwrap();
        to.write_all(&bytes).unwrap();
    }
    to.finish().unwrap();
    assert!(found, "{name}");
    path
}

fn replaced(fmu: &Path, name: &str, old: &str, new: &str) -> PathBuf {
    changed(fmu, name, |text| {
        assert!(text.contains(old), "{name}: {old}");
        Some(text.replacen(old, new, 1).into_bytes())
    })
}

fn one(path: &Path, tolerance: Option<f64>) -> ReplayedExperiment {
    let mut all = replay(path, tolerance).unwrap();
    assert_eq!(all.len(), 1);
    all.remove(0)
}

#[test]
fn what_was_packed_has_the_same_bits_and_what_was_changed_is_found() {
    for format in [FmuFormat::Fmi2(Naming::Structured), FmuFormat::Fmi3] {
        let directory = TempDir::new().unwrap();
        let fmu = referenced(directory.path(), format);
        let own = one(&fmu, None);
        assert_eq!((own.different, &own.first, &own.largest), (0, &None, &None));
        assert_eq!((own.rows, own.name.as_str(), own.clock.until), (11, "Trial_push", 0.5));
        assert!(own.width > 50, "{}", own.width);

        // A parameter of the Trial in it.
        let heavier =
            replaced(&fmu, "resources/Trial_push/static/Agents.xml", "Mass=\"89.0\"", "Mass=\"89.01\"");
        let other = one(&heavier, None);
        let (first, largest) = (other.first.unwrap(), other.largest.unwrap());
        assert!(other.different > 20 && first.time == 0.1 && largest.time > 0.1, "{first:?} {largest:?}");
        assert!(first.name.starts_with("agent[0]."), "{}", first.name);
        let by = (largest.value - largest.reference).abs() / largest.reference.abs().max(1.0);
        assert_eq!(one(&heavier, Some(1.01 * by.max(1.0))).different, 0);
        assert!(one(&heavier, Some(1e-12)).different > 0);

        // A number of the reference.
        let column = if format == FmuFormat::Fmi3 { "\"Position\"" } else { "\"agent[0].Position.x\"" };
        let forged = changed(&fmu, &format!("{PLACE}/outputs.csv"), |text| {
            let mut rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
            let place = rows[0].iter().position(|name| *name == column).unwrap();
            let row = rows.iter_mut().find(|row| row[0] == "0.45").unwrap();
            let (first, others) = row[place].split_once(' ').unwrap_or((row[place], ""));
            let cell = format!("{:?} {others}", first.parse::<f64>().unwrap() + 0.25);
            row[place] = &cell;
            let lines: Vec<String> = rows.iter().map(|row| row.join(",") + "\n").collect();
            Some(lines.concat().into_bytes())
        });
        let forged = one(&forged, None);
        let found = forged.first.unwrap();
        assert_eq!((forged.different, found.time, forged.largest.as_ref()), (1, 0.45, Some(&found)));
        assert_eq!(found.name, "agent[0].Position.x");
        assert!((found.reference - found.value - 0.25).abs() < 1e-12, "{found:?}");

        // A push that is another one.
        let inputs = format!("{PLACE}/inputs.csv");
        let weaker = replaced(&fmu, &inputs, "\n0.1,600.0", "\n0.1,599.0");
        assert_eq!(one(&weaker, None).first.unwrap().time, 0.15000000000000002);
    }
}

#[test]
fn what_is_broken_is_said_with_its_place() {
    let directory = TempDir::new().unwrap();
    let fmu = referenced(directory.path(), FmuFormat::default());
    let file = directory.path().join("changed.fmu");
    // Without compression it is read faster.
    std::fs::rename(replaced(&fmu, "modelDescription.xml", "", ""), &fmu).unwrap();
    let message = |name: &str, old: &str, new: &str| {
        let path = replaced(&fmu, &format!("{PLACE}/{name}"), old, new);
        let error = replay(&path, None).unwrap_err().whole();
        let prefix = format!("{}/{PLACE}/", file.display());
        error.strip_prefix(&prefix).unwrap_or(&error).to_owned()
    };
    for (name, old, new, expected) in [
        ("fmi-ls-manifest.xml", "</fmiReferences>", "", "fmi-ls-manifest.xml:1: is not well-formed XML: "),
        (
            "fmi-ls-manifest.xml",
            "fmi-ls-name=\"org.fmi-standard.fmi-ls-ref\"",
            "fmi-ls-name=\"x\"",
            "fmi-ls-manifest.xml:2: <fmiReferences>: fmi-ls-name must be \"org.fmi-standard.fmi-ls-ref\"",
        ),
        (
            "fmi-ls-manifest.xml",
            "x-ma-hs-experiments",
            "x",
            "fmi-ls-manifest.xml: no experiment (application/x-ma-hs-experiments) with reference results",
        ),
        (
            "fmi-ls-manifest.xml",
            "experiments.exp",
            "../../../x",
            "fmi-ls-manifest.xml:3: <Related> source=\"../../../x\": leads outside of the FMU",
        ),
        (
            "fmi-ls-manifest.xml",
            "experiments.exp",
            "/etc/passwd",
            "fmi-ls-manifest.xml:3: <Related> source=\"/etc/passwd\": must be relative, with forward slashes",
        ),
        (
            "fmi-ls-manifest.xml",
            "experiments.exp",
            "..",
            "fmi-ls-manifest.xml:3: <Related> source=\"..\": there is no such file in the FMU",
        ),
        (
            "experiments.exp",
            "<Experiments ",
            "<!DOCTYPE a><Experiments ",
            "experiments.exp:2: <!DOCTYPE>: document",
        ),
        (
            "experiments.exp",
            "stopTime=\"0.5\"",
            "stopTime=\"1e300\"",
            "experiments.exp:4: <TransientSimulation>: from 0.0 to 1e300 s there are 2.0000e301 communication steps",
        ),
        (
            "experiments.exp",
            "stepSize=\"0.05\"",
            "stepSize=\"x\"",
            "experiments.exp:4: <TransientSimulation> stepSize=\"x\": must be a number",
        ),
        (
            "experiments.exp",
            "<Stimuli ",
            "<Parameters source=\"x\"/><Stimuli ",
            "experiments.exp:5: <Parameters>: parameter sets are not served",
        ),
        (
            "experiments.exp",
            "<References ",
            "<References type=\"application/hdf5\" ",
            "experiments.exp:6: <References> type=\"application/hdf5\": only text/csv is served",
        ),
        ("outputs.csv", "\"time\"", "\"t\"", "outputs.csv:1: the first column must be \"time\""),
        (
            "outputs.csv",
            "agent[0].Theta",
            "agent[0].Mass",
            "outputs.csv:1: \"agent[0].Mass\": the FMU has no such output that is a number",
        ),
        (
            "outputs.csv",
            "agent[0].Theta",
            "agent[1].Theta",
            "outputs.csv:1: two columns are \"agent[1].Theta\"",
        ),
        ("outputs.csv", "\n0.05,", "\n0.05,1,", "outputs.csv:3: has 99 values instead of 98"),
        (
            "outputs.csv",
            "\n0.05,0",
            "\n0.05,inf",
            "outputs.csv:3: \"AgentContacts\": \"inf\": not a finite number",
        ),
        (
            "outputs.csv",
            "\n0.05,",
            "\n0.05,1 ",
            "outputs.csv:3: \"AgentContacts\": \"1 0\": has 2 numbers instead of 1",
        ),
        (
            "outputs.csv",
            "\n0.05,",
            "\n0,",
            "outputs.csv:3: \"time\": \"0\": does not come after the row before",
        ),
        ("outputs.csv", "\n0.05,", "\n0.06,", "outputs.csv: time 0.06 where the experiment is at 0.1"),
        ("outputs.csv", "\n0.5,", "\n0.51,", "outputs.csv: time 0.51 where the experiment is at 0.5"),
        ("outputs.csv", "\n0.0,", "\n-1,", "outputs.csv: time -1.0 where the experiment is at 0.0"),
        (
            "inputs.csv",
            "agent[0].Fp.x",
            "agent[0].Position.x",
            "inputs.csv:1: \"agent[0].Position.x\": the FMU has no such input that is a number",
        ),
    ] {
        let message = message(name, old, new);
        assert!(message.starts_with(expected), "{message}\ninstead of\n{expected}");
    }
    let error = |path: &Path| replay(path, None).unwrap_err().whole();
    let without = changed(&fmu, &format!("{PLACE}/outputs.csv"), |_| None);
    assert!(error(&without).ends_with("source=\"outputs.csv\": there is no such file in the FMU"));
    let without = changed(&fmu, &format!("{PLACE}/fmi-ls-manifest.xml"), |_| None);
    let none =
        format!("{}: it holds no reference ({PLACE}); lemons pack --reference adds one", without.display());
    assert_eq!(error(&without), none);
    let bytes =
        changed(&fmu, &format!("{PLACE}/outputs.csv"), |text| Some([text.as_bytes(), b"1,\xff\n"].concat()));
    assert!(error(&bytes).contains("outputs.csv: "), "{}", error(&bytes));
    // A small archive of a lot.
    let large = changed(&fmu, &format!("{PLACE}/outputs.csv"), |_| Some(vec![b'0'; 100_000_001]));
    assert!(error(&large).ends_with("outputs.csv: it is larger than 100 MB, the limit"), "{}", error(&large));
    let large = changed(&fmu, &format!("{PLACE}/fmi-ls-manifest.xml"), |_| Some(vec![b' '; 1_000_001]));
    assert!(
        error(&large).ends_with("fmi-ls-manifest.xml: it is larger than 1 MB, the limit"),
        "{}",
        error(&large)
    );
}

/// As the standard has it for files elsewhere, and as experiments were before they had kinds.
#[test]
fn experiments_elsewhere_and_of_the_first_draft_are_read() {
    let directory = TempDir::new().unwrap();
    let fmu = referenced(directory.path(), FmuFormat::default());
    let text = "<Experiments name='x'><Experiment name='none'/>\
                <Experiment name='of another tool' startTime='0' stopTime='0.5' stepSize='0.05'>\
                <Stimuli source='../extra/org.fmi-standard.fmi-ls-ref/inputs.csv'/>\
                <References source='../extra/org.fmi-standard.fmi-ls%2Dref/./outputs.csv'/></Experiment></Experiments>";
    let moved = changed(&fmu, "documentation/index.html", |_| Some(text.as_bytes().to_vec()));
    let path = directory.path().join("moved.fmu");
    std::fs::rename(moved, &path).unwrap();
    let manifest = format!("{PLACE}/fmi-ls-manifest.xml");
    let own = one(&replaced(&path, &manifest, "experiments.exp", "../../documentation/index.html"), None);
    assert_eq!((own.name.as_str(), own.different, own.rows), ("of another tool", 0, 11));
}
