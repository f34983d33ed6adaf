//! One physics: a simulation in memory, FMUs of FMI 2.0 and 3.0 and the lab give the same bits.

use crate::{advance, ask, ok, opened, texts};
use crowd_mechanics::pack::FmuFormat;
use lemons_core::trial::{DriveChoice, Problems, Rule};
use lemons_decision::{DecisionConfig, pack};
use lemons_lab::Lab;
use lemons_lab::frame::{COLUMNS, frame};
use lemons_master::ssp::{Participant, write_archive};
use lemons_master::{
    DecisionChoice, PreparedSystem, RunSettings, TrialInput, binary_beside, documents_of, own_binary,
};
use lemons_people::zip_trial;
use lemons_results::Frame;
use lemons_results::columns::{Group, Groups, row_of};
use lemons_sim::lint::{self, Files};
use lemons_sim::{Algorithm, Clock, Documents, Simulation};
use lemons_testing::{repository, trial_push};
use std::fs::File;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// Numbers of everybody at each communication point; the pose of who has left does not count.
type Bits = Vec<Vec<[u64; 6]>>;

fn bits(frame: &Frame) -> Vec<[u64; 6]> {
    let of = |agent: usize| {
        let [x, y, vx, vy, theta, omega, ..] = row_of(frame, agent);
        let [x, y] = if frame.is_there(agent) { [x, y] } else { [f64::NAN; 2] };
        [x, y, vx, vy, theta, omega].map(f64::to_bits)
    };
    (0..frame.agents.len()).map(of).collect()
}

fn of_simulation(documents: &Documents, algorithm: Algorithm, clock: &Clock) -> Bits {
    let mut simulation = Simulation::new(documents.clone(), algorithm).unwrap();
    simulation.begin(0.0, None).unwrap();
    let mut all = vec![bits(&simulation.frame())];
    for time in clock.points(0) {
        simulation.step_to(time).unwrap();
        all.push(bits(&simulation.frame()));
    }
    all
}

/// The bits of the FMUs that `lemons pack`, `decide` and `connect` would make.
fn of_fmus(scene: &Scene, format: FmuFormat, algorithm: Algorithm, clock: &Clock) -> Bits {
    let directory = TempDir::new().unwrap();
    let crowd = directory.path().join("crowd.fmu");
    let given = TrialInput::open(&scene.directory).unwrap();
    let file = File::create(&crowd).unwrap();
    lemons_master::pack(&[given], vec![own_binary().unwrap()], format, None, &crowd, file).unwrap();
    let input = match &scene.documents.plan {
        None => crowd,
        Some(_) => coupled(directory.path(), &scene.documents, format, crowd),
    };
    let settings =
        RunSettings { until: Some(clock.until), step: Some(clock.step), algorithm, ..RunSettings::of(input) };
    let mut run = PreparedSystem::of(&settings).unwrap();
    let agents = scene.documents.trial.agents.len();
    let groups = Groups::default().with(Group::Active, true);
    let see = |run: &PreparedSystem| -> Vec<[u64; 6]> {
        let crowd = run.system.components.iter().find(|component| component.name == "crowd").unwrap();
        let names = groups.variables(agents).into_iter().map(|(name, _)| name);
        let values: Vec<f64> = crowd.instance.values(&crowd.instance.select(names).unwrap()).unwrap();
        bits(&groups.frame_of_values(0.0, agents, &values).unwrap())
    };
    let mut all = vec![see(&run)];
    for time in clock.points(0) {
        run.step_to(time).unwrap();
        all.push(see(&run));
    }
    all
}

fn coupled(directory: &Path, documents: &Documents, format: FmuFormat, crowd: PathBuf) -> PathBuf {
    let decision = directory.join("decision.fmu");
    let binary = binary_beside("lemons_decision_fmu").unwrap();
    pack::write_fmu(
        &documents.trial,
        documents.plan.as_ref().unwrap(),
        format,
        &[binary],
        File::create(&decision).unwrap(),
    )
    .unwrap();
    let files = [("decision", decision), ("crowd", crowd)];
    let files = files.map(|(name, path)| (name, format!("resources/{name}.fmu"), path));
    let interfaces = files.each_ref().map(|(.., path)| lemons_master::Fmu::open(path).unwrap().description);
    let participants = files.iter().zip(&interfaces).map(|((name, source, _), interface)| Participant {
        name: (*name).to_owned(),
        source: source.clone(),
        interface,
        terminals: Vec::new(),
    });
    let participants: Vec<_> = participants.collect();
    let connected = lemons_master::ssp::connect("coupled", &participants, &[]).unwrap();
    let files: Vec<_> = files.iter().map(|(_, source, path)| (source.clone(), path.as_path())).collect();
    let path = directory.join("coupled.ssp");
    write_archive(&path, &connected.structure, &files).unwrap();
    path
}

fn of_lab(scene: &Scene, clock: &Clock) -> Bits {
    let others = ["decision.toml", "drive.csv"]
        .map(|name| (name, std::fs::read_to_string(scene.directory.join(name)).unwrap_or_default()));
    let others: Vec<(&str, &str)> =
        others.iter().filter(|(_, text)| !text.is_empty()).map(|(name, text)| (*name, &**text)).collect();
    let zip = zip_trial(&scene.documents.trial, &others, Cursor::new(Vec::new())).unwrap().into_inner();
    let mut lab = Lab::default();
    let (value, first) = ask(&mut lab, &opened("scene.zip", &zip), &zip);
    // What is found is said as by the command, whose files are elsewhere.
    let notes = texts(&value["ok"]["notes"]);
    let found: Vec<&str> = scene.problems.iter().map(|problem| &*problem.message).collect();
    assert!(notes.len() == found.len(), "{notes:?} {found:?}");
    assert!(notes.iter().zip(found).all(|(note, found)| note.ends_with(found)), "{notes:?}");
    let (_, frames) = ok(&mut lab, advance(1, clock.steps));
    let people = scene.documents.trial.agents.len();
    let of = |bytes: &[u8]| bits(&frame(bytes, people).unwrap());
    [first, frames].concat().chunks(8 * COLUMNS * people).map(of).collect()
}

struct Scene {
    directory: PathBuf,
    documents: Documents,
    problems: Problems,
}

impl Scene {
    fn of(directory: PathBuf) -> Scene {
        let (documents, mut problems, _) =
            documents_of(&directory, &DriveChoice::Own, &DecisionChoice::Own).unwrap();
        problems.extend(lint::of_documents(&documents, &Files::within(&directory)));
        Scene { directory, documents, problems }
    }

    fn check(&self, until: f64) {
        let clock = Clock::new(0.0, self.documents.trial.parameters.time_step, until).unwrap();
        for algorithm in [Algorithm::Jacobi, Algorithm::GaussSeidel] {
            let own = of_simulation(&self.documents, algorithm, &clock);
            assert_eq!(own.len() as u64, clock.steps + 1);
            let (first, last) = (&own[0], &own[own.len() - 1]);
            assert!(first.iter().zip(last).any(|(first, last)| first != last), "somebody moves");
            for format in [FmuFormat::default(), FmuFormat::Fmi3] {
                assert!(own == of_fmus(self, format, algorithm, &clock), "{algorithm} {format:?}");
            }
            if algorithm == Algorithm::Jacobi {
                assert!(own == of_lab(self, &clock), "the lab");
            }
        }
    }
}

#[test]
fn a_push_has_the_same_bits_everywhere() {
    Scene::of(trial_push()).check(1.0);
}

#[test]
fn people_who_walk_to_a_door_have_the_same_bits_everywhere() {
    Scene::of(repository().join("resources/Trial_door")).check(2.0);
}

/// People who keep distances, have patience with a seed of its own, and leave.
#[test]
fn people_who_leave_have_the_same_bits_everywhere() {
    let directory = TempDir::new().unwrap();
    let place = directory.path().join("scene");
    let (trial, _) = crowd_mechanics::setup::read(&repository().join("resources/Trial_door")).unwrap();
    trial.write(&place).unwrap();
    let exit = "exits = [{ name = \"door\", line = [[6.5, 1.0], [6.5, 4.0]] }]";
    let decision = format!("model = \"collision-free-speed\"\nseed = 7\n{exit}");
    DecisionConfig::from_toml(&decision).unwrap();
    std::fs::write(place.join("decision.toml"), decision).unwrap();
    let scene = Scene::of(place);
    assert!(scene.problems.iter().any(|problem| problem.rule == Rule::SpeedLeaves));
    scene.check(6.0);
    let clock = Clock::new(0.0, scene.documents.trial.parameters.time_step, 6.0).unwrap();
    let last = of_simulation(&scene.documents, Algorithm::Jacobi, &clock).pop().unwrap();
    let left = last.iter().filter(|row| f64::from_bits(row[0]).is_nan()).count();
    assert!(left > 0 && left < last.len(), "{left}");
}
