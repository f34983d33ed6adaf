//! Runs from settings, as any program makes them, against loops written out here.

use crowd_mechanics::pack::{Binary, Package};
use lemons_files::Staged;
use lemons_master::{
    Error, Fmu, Kept, Observer, PrepareError, Prepared, Progress, Reached, Settings, System, Warning,
    own_binary,
};
use lemons_trial::DriveChoice;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

fn trial() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../resources/Trial_push")
}

const AGENTS: usize = 5;
const POSE: [&str; 3] = ["Position.x", "Position.y", "Theta"];

fn names() -> Vec<String> {
    (0..AGENTS).flat_map(|i| POSE.map(|name| format!("agent[{i}].{name}"))).collect()
}

/// Bits of a time, and of all poses then.
type Row = (u64, Vec<u64>);

fn row(system: &System, time: f64) -> Result<Row, Error> {
    let instance = &system.components()[0].instance;
    let selection = instance.select(names())?;
    let mut values = vec![0.0; selection.len()];
    instance.get_real(&selection, &mut values)?;
    Ok((time.to_bits(), values.iter().map(|value| value.to_bits()).collect()))
}

/// Notes poses; ends the run after so many steps.
struct Poses {
    rows: Vec<Row>,
    most: u64,
}

impl Observer<System> for Poses {
    type Error = Error;

    fn goes_on(&mut self, _: &System) -> bool {
        (self.rows.len() as u64) < self.most
    }

    fn look(&mut self, system: &mut System, reached: Reached) -> Result<(), Error> {
        self.rows.push(row(system, reached.time)?);
        Ok(())
    }
}

fn poses(settings: &Settings, most: u64) -> (Prepared, Vec<Row>) {
    let mut run = Prepared::of(settings).unwrap();
    let mut poses = Poses { rows: Vec::new(), most };
    let ended = run.simulate(&mut poses).unwrap();
    assert_eq!(ended.is_break(), poses.rows.len() as u64 == most);
    (run, poses.rows)
}

const PUSH: &str = "t,agent,Fp.x,Fp.y,Mp\n0,0,900,0,0\n0.7,0,900,0,0\n";

/// Agent 0 is pushed with 900 N until 0.7 s; everybody has 80 kg.
fn by_hand(directory: &Path, step: f64, steps: u32) -> Vec<Row> {
    let path = directory.join("by_hand.fmu");
    let (trials, binaries) = (vec![trial()], vec![own_binary().unwrap()]);
    Package { trials, binaries, ..Package::default() }.write(&path).unwrap();
    let fmu = Fmu::open(&path).unwrap();
    let instance = fmu.instantiate("by_hand").unwrap();
    let masses = instance.select((0..AGENTS).map(|i| format!("agent[{i}].Mass"))).unwrap();
    instance.set_real(&masses, &[80.0; AGENTS]).unwrap();
    instance.set_real(&instance.select(["TimeStepMechanical"]).unwrap(), &[1e-5]).unwrap();
    instance.initialize().unwrap();
    let (poses, force_x) = (instance.select(names()).unwrap(), instance.select(["agent[0].Fp.x"]).unwrap());
    let rows = (0..steps).map(|k| {
        let (from, to) = (f64::from(k) * step, f64::from(k + 1) * step);
        let force = if from <= 0.7 { 900.0 } else { 0.0 };
        instance.set_real(&force_x, &[force]).unwrap();
        instance.step(from, to - from).unwrap();
        let mut values = [0.0; 3 * AGENTS];
        instance.get_real(&poses, &mut values).unwrap();
        (to.to_bits(), values.iter().map(|value| value.to_bits()).collect())
    });
    rows.collect()
}

fn pushed(directory: &Path) -> Settings {
    let drive = directory.join("push.csv");
    std::fs::write(&drive, PUSH).unwrap();
    let parameters = [("agent[*].Mass", "80"), ("TimeStepMechanical", "1e-5")];
    Settings {
        parameters: parameters.map(|(name, value)| (name.to_owned(), value.to_owned())).to_vec(),
        until: Some(2.0),
        drive: DriveChoice::File(drive),
        ..Settings::of(trial())
    }
}

#[test]
fn a_trial_runs_to_the_bits_of_a_loop_by_hand() {
    let directory = TempDir::new().unwrap();
    let settings = pushed(directory.path());
    let (run, rows) = poses(&settings, u64::MAX);
    assert_eq!(run.warnings, []);
    assert_eq!((run.progress.clock.step, run.progress.every, run.coupled), (0.05, 1, false));
    assert_eq!(run.trials[0].as_ref().unwrap().agents.len(), AGENTS);
    let expected = by_hand(directory.path(), 0.05, 40);
    assert_eq!(rows.len(), 40);
    assert!(rows == expected, "other bits");
    let moved = |i: usize| f64::from_bits(rows[39].1[3 * i]) - f64::from_bits(rows[0].1[3 * i]);
    assert!(moved(0) > 0.1 && moved(1) > 0.01, "one pushes the next: {} m, {} m", moved(0), moved(1));
    // With threads the results are the same.
    let (_, threads) = poses(&Settings { threads: Some(2), ..settings }, u64::MAX);
    assert!(threads == expected, "other bits");
}

/// The library of a program that runs crowds need not be beside it.
#[test]
fn a_trial_is_packed_with_the_library_that_is_given() {
    let directory = TempDir::new().unwrap();
    let Binary { platform, path } = own_binary().unwrap();
    let elsewhere = directory.path().join("elsewhere");
    std::fs::copy(path, &elsewhere).unwrap();
    let missing = Binary { platform: platform.clone(), path: directory.path().join("missing") };
    let settings = Settings { until: Some(0.1), binary: Some(missing), ..Settings::of(trial()) };
    assert!(matches!(Prepared::of(&settings), Err(PrepareError::Run(Error::Pack(_)))));
    let settings = Settings { binary: Some(Binary { platform, path: elsewhere }), ..settings };
    assert_eq!(poses(&settings, u64::MAX).1.len(), 2);
}

/// Saves the run where it is.
fn save(run: &mut Prepared, progress: &Progress, path: &Path) {
    let kept = Kept::of(&mut run.system, progress).unwrap();
    let (saved, states) = kept.saved(&run.system, progress, &run.pushes, "a test").unwrap();
    saved.write(&states, Staged::beside(path).unwrap()).unwrap();
}

#[test]
fn a_saved_run_goes_on_to_the_same_bits() {
    let directory = TempDir::new().unwrap();
    let settings = Settings { saves: true, ..pushed(directory.path()) };
    let (_, whole) = poses(&settings, u64::MAX);
    // In the middle of the push, with people in contact.
    let (mut run, begun) = poses(&settings, 9);
    let progress = Progress { index: 9, ..run.progress };
    let path = directory.path().join("half.run");
    save(&mut run, &progress, &path);
    drop(run);
    let on = Settings { parameters: Vec::new(), until: None, resume: Some(path), ..settings.clone() };
    let (run, rest) = poses(&on, u64::MAX);
    let before = run.before.as_ref().unwrap();
    assert_eq!((before.index, before.time, before.lemons.as_str()), (9, 0.45, "a test"));
    assert_eq!((begun.len(), rest.len()), (9, 31));
    assert!([begun, rest].concat() == whole, "other bits");

    let refused = |settings: Settings| Prepared::of(&settings).map(drop).unwrap_err();
    let mass = vec![("agent[0].Mass".to_owned(), "80".to_owned())];
    assert!(matches!(refused(Settings { parameters: mass, ..on.clone() }), PrepareError::Parameter { .. }));
    assert!(matches!(refused(Settings { threads: Some(2), ..on.clone() }), PrepareError::Threads(2)));
    let other = refused(Settings { step: Some(0.1), ..on.clone() });
    assert!(matches!(other, PrepareError::OtherStep { step: 0.1, saved: 0.05 }), "{other}");
    let other = refused(Settings { every: Some(2), ..on.clone() });
    assert!(matches!(other, PrepareError::OtherEvery { every: 2, saved: 1 }), "{other}");
    assert!(matches!(refused(Settings { drive: DriveChoice::None, ..on.clone() }), PrepareError::OtherDrive));
    let over = refused(Settings { until: Some(0.45), ..on.clone() });
    assert!(matches!(over, PrepareError::Nothing { resumed: true, .. }), "{over}");
    let not_saved = refused(Settings { resume: Some(trial().join("drive.csv")), ..on });
    assert!(matches!(not_saved, PrepareError::NotSaved(_)), "{not_saved}");
}

/// What a program finds in errors and warnings, without reading their texts.
#[test]
fn what_is_wrong_is_said_as_data() {
    let directory = TempDir::new().unwrap();
    let refused = |settings: &Settings| Prepared::of(settings).map(drop).unwrap_err();

    let coarse = Settings { step: Some(0.9), ..pushed(directory.path()) };
    std::fs::write(
        directory.path().join("push.csv"),
        "t,agent,Fp.x,Fp.y,Mp\n0,0,0,0,0\n0.4,0,900,0,0\n0.5,0,0,0,0\n",
    )
    .unwrap();
    let run = Prepared::of(&coarse).unwrap();
    let [Warning::Missed(missed)] = &run.warnings[..] else { panic!("{:?}", run.warnings) };
    assert_eq!((missed.time, missed.push, missed.of), (0.4, 900.0, 3));
    for text in [run.warnings[0].to_string(), missed.to_string()] {
        assert!(!text.contains("--"), "options are the command's: {text}");
    }

    std::fs::write(directory.path().join("push.csv"), "t,agent,Fp.x,Fp.y,Mp\n0,9,0,0,0\n").unwrap();
    let PrepareError::Run(error) = refused(&coarse) else { panic!("of the drive") };
    let place = directory.path().join("push.csv");
    let text = format!("{}:2: there is no agent \"9\" in Agents.xml", place.display());
    assert!(matches!(error, Error::Drive(_)));
    assert_eq!(error.whole(), text);

    let unknown = Settings { parameters: vec![("Nothing".into(), "1".into())], ..Settings::of(trial()) };
    let error = refused(&unknown);
    assert!(matches!(&error, PrepareError::Run(Error::NoVariable(name)) if name == "Nothing"), "{error}");
    let text = Settings { parameters: vec![("Threads".into(), "many".into())], ..Settings::of(trial()) };
    let error = refused(&text);
    assert!(matches!(&error, PrepareError::Run(Error::Value { text, .. }) if text == "many"), "{error}");
    let negative =
        Settings { parameters: vec![("agent[0].Mass".into(), "-1".into())], ..Settings::of(trial()) };
    let PrepareError::Run(Error::Refused { answer, said }) = refused(&negative) else { panic!("by the FMU") };
    let call = answer.call();
    assert!(call == "fmi2SetReal" && said.iter().any(|said| said.contains("Mass")), "{call}: {said:?}");

    // A Trial with errors has all of them.
    let broken = directory.path().join("T");
    copy(&trial(), &broken);
    let agents = broken.join("static/Agents.xml");
    let text = std::fs::read_to_string(&agents).unwrap();
    std::fs::write(&agents, text.replace("Radius=\"", "Radius=\"-")).unwrap();
    let PrepareError::Run(Error::Broken { path, problems }) = refused(&Settings::of(&broken)) else {
        panic!("of the Trial")
    };
    assert_eq!(path, broken);
    assert!(
        problems.errors().count() > 1 && problems.errors().all(|problem| problem.file == agents),
        "{problems}"
    );
}

/// A step that is not a number gave one step in silence.
#[test]
fn settings_outside_of_their_domain_are_refused_by_value() {
    let said = |settings: Settings| {
        let error = Prepared::of(&settings).map(drop).unwrap_err();
        lemons_master::whole(&error).replace(&format!("{}: ", trial().display()), "")
    };
    let own = || Settings::of(trial());
    let step = |step| said(Settings { step: Some(step), ..own() });
    assert_eq!(step(f64::NAN), "communication step NaN s: not a finite number");
    assert_eq!(step(f64::INFINITY), "communication step inf s: not a finite number");
    assert_eq!(step(0.0), "a communication step of 0.0 s: it must be greater than 0");
    assert_eq!(step(-0.05), "a communication step of -0.05 s: it must be greater than 0");
    let until = said(Settings { until: Some(f64::NAN), ..own() });
    assert_eq!(until, "stop time NaN s: not a finite number");
    let every = said(Settings { every: Some(0), ..own() });
    assert_eq!(every, "one communication point in 0 cannot be recorded: the number must be at least 1");
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap().map(Result::unwrap) {
        let (from, to) = (entry.path(), to.join(entry.file_name()));
        if from.is_dir() {
            copy(&from, &to);
        } else {
            std::fs::copy(from, to).unwrap();
        }
    }
}
