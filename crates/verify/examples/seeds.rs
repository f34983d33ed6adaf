//! Writes the seeds that no editor writes: saved runs, into the directory of the corpora:
//! `cargo run -p lemons-verify --features fuzz --example seeds -- fuzz/corpus`.

use lemons_core::files::Staged;
use lemons_master::{ComponentRecord, CrowdRecord, Saved};
use lemons_sim::{ExposureSum, Extremes, Greatest};
use std::error::Error;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use zip::CompressionMethod::Stored;
use zip::DateTime;
use zip::write::SimpleFileOptions;

type Done = Result<(), Box<dyn Error>>;

fn main() -> Done {
    let corpora = PathBuf::from(std::env::args_os().nth(1).ok_or("which directory has the corpora?")?);
    runs(&corpora.join("run_file"))
}

/// The first byte says what the target makes of the others: 0 an archive, 1 its `run.toml`.
fn runs(directory: &Path) -> Done {
    fs::create_dir_all(directory)?;
    let component = |name: &str, place: usize, bytes| ComponentRecord {
        name: name.into(),
        model: "push".into(),
        guid: format!("{{{place}}}"),
        chosen: std::collections::BTreeMap::new(),
        state: format!("state-{place}"),
        bytes,
    };
    let squeeze = Greatest { force: 200.0, agent: 1, time: 0.1 };
    let crowd = CrowdRecord {
        since: ExposureSum::default(),
        component: "crowd".into(),
        extremes: Extremes { largest_overlap: 0.01, mean_squeeze: squeeze, peak_squeeze: squeeze },
    };
    let one = Saved {
        format: Saved::FORMAT,
        lemons: "0.2.0".into(),
        start: 0.0,
        step: 0.05,
        until: 2.0,
        index: 3,
        time: 3.0 * 0.05,
        every: 1,
        algorithm: "jacobi".into(),
        wiring: "0".repeat(32),
        drive: "0".repeat(32),
        component: vec![component("crowd", 0, 5)],
        crowd: vec![crowd],
    };
    let two = Saved { component: vec![component("crowd", 0, 5), component("other", 1, 0)], ..one.clone() };
    let mut twice = two.clone();
    twice.component[1] = ComponentRecord { name: "other".into(), ..component("", 0, 5) };
    let early = Saved { format: 1, ..one.clone() };
    // The state of the second component is `run.toml`, which is as long as it says.
    let mut itself = Saved { lemons: String::new(), ..two.clone() };
    itself.component[1] =
        ComponentRecord { state: "run.toml".into(), bytes: 100, ..component("other", 1, 0) };
    let length = toml::to_string(&itself)?.len();
    itself.component[1].bytes = length as u64;
    let paths = ["./run.toml", "RUN.TOML", "state-0/", ""];
    let named = |state: &str| {
        let mut other = two.clone();
        other.component[1].state = state.into();
        other
    };
    let [upwards, upper, inside, nameless] = paths.map(named);
    let states = [b"state".to_vec(), Vec::new()];

    let deflated = tempfile::tempdir()?;
    let path = deflated.path().join("x.run");
    two.write(&states, Staged::beside(&path)?)?;
    let mut seeds = vec![("deflated", 0, fs::read(&path)?), ("empty", 0, b"PK\x05\x06".to_vec())];
    seeds[1].2.resize(22, 0);
    let texts = [
        ("run", &one),
        ("two", &two),
        ("one_state_twice", &twice),
        ("format_1", &early),
        ("state_is_run_toml", &itself),
        ("state_is_dot_run_toml", &upwards),
        ("state_is_upper_case", &upper),
        ("state_is_a_directory", &inside),
        ("state_has_no_name", &nameless),
    ];
    for (name, saved) in texts {
        seeds.push((name, 1, toml::to_string(saved)?.into_bytes()));
    }
    let mut stored = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let options =
        SimpleFileOptions::default().last_modified_time(DateTime::default()).compression_method(Stored);
    for (name, content) in [("run.toml", toml::to_string(&one)?.into_bytes()), ("state-0", states[0].clone())]
    {
        stored.start_file(name, options)?;
        stored.write_all(&content)?;
    }
    seeds.push(("stored", 0, stored.finish()?.into_inner()));
    for (name, way, content) in seeds {
        fs::write(directory.join(name), [&[way], &content[..]].concat())?;
    }
    Ok(())
}
