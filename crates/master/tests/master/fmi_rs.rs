//! An importer that others wrote, fmi-rs, and our own: both run the crowd's FMUs of both versions alike.

use crate::packed;
use crowd_mechanics::pack::FmuFormat;
use fmi_rs::fmi2::types::{fmi2FMUstate, fmi2Status};
use fmi_rs::fmi2::{CS, FMU2, log::Logger as Logger2};
use fmi_rs::fmi3::native::{NativeLibrary, PLATFORM_TUPLE};
use fmi_rs::fmi3::types::fmi3Status;
use fmi_rs::fmi3::{FMU3, log::Logger as Logger3};
use fmi_rs::model_description::fmi3::{self, ModelDescription};
use lemons_core::trial::DriveChoice;
use lemons_master::ssp::{Causality, FmiType};
use lemons_master::{DecisionChoice, Fmu, TrialInput, binary_beside};
use lemons_summary::{AreaConfig, SummaryConfig};
use std::fs::File;
use std::path::Path;
use std::ptr::null_mut;
use std::sync::Arc;
use tempfile::TempDir;

const STEP: f64 = 0.01;
const STEPS: u32 = 60;
const AGENTS: usize = 5;

/// Nothing is to be said.
struct Silence;

impl Logger2 for Silence {
    fn log_call(&self, _: fmi2Status, _: &str) {}

    fn log_message(&self, status: fmi2Status, _: &str, message: &str) {
        panic!("{status:?}: {message}");
    }
}

impl Logger3 for Silence {
    fn log_call(&self, _: fmi3Status, _: &str) {}

    fn log_message(&self, status: fmi3Status, _: &str, message: &str) {
        panic!("{status:?}: {message}");
    }
}

/// The FMU 2.0 in fmi-rs; its initialization is over.
fn theirs_2(fmu: &Fmu) -> Arc<FMU2<CS>> {
    let own = fmu.description.co_simulation.as_ref().unwrap();
    let (directory, guid, silence) = (fmu.directory(), &fmu.description.guid, Arc::new(Silence));
    let made =
        FMU2::<CS>::new(directory, &own.identifier, "theirs", guid, false, false, false, silence, true);
    let made = made.unwrap_or_else(|error| panic!("{error}"));
    let begun = [made.setupExperiment(None, 0.0, None), made.enterInitializationMode()];
    assert_eq!((begun, made.exitInitializationMode()), ([fmi2Status::Ok; 2], fmi2Status::Ok));
    made
}

/// The FMU 3.0 in fmi-rs, and its description.
fn theirs_3(fmu: &Fmu) -> (ModelDescription, Arc<FMU3>) {
    let description = ModelDescription::from_path(&fmu.directory().join("modelDescription.xml")).unwrap();
    let identifier = &description.coSimulation.as_ref().unwrap().modelIdentifier;
    let library = format!("binaries/{PLATFORM_TUPLE}/{identifier}{}", std::env::consts::DLL_SUFFIX);
    let library = Box::new(NativeLibrary::load(fmu.directory().join(library)).unwrap());
    let (token, resources) = (&description.instantiationToken, fmu.directory().join("resources"));
    let made = FMU3::instantiateCoSimulation(
        library,
        Some(&resources),
        "theirs",
        token,
        false,
        true,
        false,
        false,
        Arc::new(Silence),
        false,
        None,
    );
    let made = made.unwrap_or_else(|error| panic!("{error}"));
    let begun = [made.enterInitializationMode(None, 0.0, None), made.exitInitializationMode()];
    assert_eq!(begun, [fmi3Status::Ok; 2]);
    (description, made)
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

#[test]
fn both_run_both_versions_to_the_same_bits() {
    let directories = [TempDir::new().unwrap(), TempDir::new().unwrap()];
    let [fmu_2, fmu_3] = [(0, FmuFormat::default()), (1, FmuFormat::Fmi3)]
        .map(|(place, format)| Fmu::open(&packed(directories[place].path(), format)).unwrap());
    let [own_2, own_3] = [&fmu_2, &fmu_3].map(|fmu| {
        let own = fmu.instantiate("own").unwrap();
        own.initialize().unwrap();
        own
    });
    let (other_2, (description, other_3)) = (theirs_2(&fmu_2), theirs_3(&fmu_3));
    assert_eq!((description.modelVariables.len(), description.outputs.len()), (46, 21));
    let inputs = description.modelVariables.iter().filter(|it| it.causality == fmi3::Causality::Input);
    assert_eq!(inputs.map(|it| &it.name[..]).collect::<Vec<_>>(), ["Fp", "Mp", "Active"]);

    // All Reals of FMI 2.0, by their references.
    let outputs = fmu_2.description.variables.iter();
    let outputs =
        outputs.filter(|variable| variable.kind == Some(Causality::Output) && variable.of == FmiType::Real);
    let (names, outputs): (Vec<&str>, Vec<u32>) =
        outputs.map(|variable| (variable.name.as_str(), variable.reference)).unzip();
    let own_outputs = own_2.select(names).unwrap();
    // Arrays of FMI 3.0, and their elements by name.
    let size = |name: &str| {
        let variable = description.variable_by_name(name).unwrap();
        let sizes = description.initial_size(variable).unwrap();
        (variable.valueReference, sizes.iter().product::<usize>())
    };
    let quantities = ["Position", "Theta", "Velocity", "Omega", "MeanNormalForce", "PeakNormalForce"];
    let (references, lengths): (Vec<u32>, Vec<usize>) = quantities.map(size).into_iter().unzip();
    let elements = quantities.iter().flat_map(|name| {
        let axes = if ["Position", "Velocity"].contains(name) { &[".x", ".y"][..] } else { &[""] };
        (0..AGENTS).flat_map(move |i| axes.iter().map(move |axis| format!("agent[{i}].{name}{axis}")))
    });
    let elements: Vec<String> = elements.collect();
    let drives = (0..AGENTS).flat_map(|i| ["x", "y"].map(|axis| format!("agent[{i}].Fp.{axis}")));
    let drives: Vec<String> = drives.collect();
    let reference = |name: &String| fmu_2.description.variable(name).unwrap().reference;
    let (drives_2, (fp, length)) = (drives.iter().map(reference).collect::<Vec<_>>(), size("Fp"));
    assert_eq!(length, 2 * AGENTS);
    let own = [&own_2, &own_3].map(|own| (own, own.select(&drives).unwrap(), own.select(&elements).unwrap()));

    let mut force = vec![0.0; length];
    force[0] = 900.0;
    let step_3 = |k: u32| {
        let (time, mut no, mut reached) = (f64::from(k) * STEP, [true; 3], f64::NAN);
        let mut values = vec![f64::NAN; lengths.iter().sum()];
        let [event, terminate, early] = &mut no;
        let done = [
            other_3.setFloat64(&[fp], &force),
            other_3.doStep(time, STEP, true, event, terminate, early, &mut reached),
            other_3.getFloat64(&references, &mut values),
        ];
        assert_eq!((done, no, reached), ([fmi3Status::Ok; 3], [false; 3], time + STEP));
        values
    };
    let mut squeezed = 0.0_f64;
    for k in 0..STEPS {
        let last = step_3(k);
        for (own, drives, elements) in &own {
            own.set(drives, &force).unwrap();
            own.step(f64::from(k) * STEP, STEP).unwrap();
            assert_eq!(bits(&own.values(elements).unwrap()), bits(&last), "step {k}");
        }
        let mut others = vec![f64::NAN; outputs.len()];
        let done = [
            other_2.setReal(&drives_2, &force),
            other_2.doStep(f64::from(k) * STEP, STEP, 1),
            other_2.getReal(&outputs, &mut others),
        ];
        assert_eq!(done, [fmi2Status::Ok; 3]);
        assert_eq!(bits(&own_2.values(&own_outputs).unwrap()), bits(&others), "step {k}");
        squeezed = squeezed.max(last[last.len() - AGENTS]);
    }
    assert!(squeezed > 100.0, "they touch");

    // A state crosses from one to the other, as bytes.
    let bytes = own_2.state().unwrap();
    let (mut state, mut size): (fmi2FMUstate, usize) = (null_mut(), 0);
    let done = [other_2.getFMUstate(&raw mut state), other_2.serializedFMUstateSize(state, &mut size)];
    assert_eq!((done, size), ([fmi2Status::Ok; 2], bytes.len()));
    let mut other = vec![0; size];
    assert_eq!(other_2.serializeFMUstate(state, &mut other), fmi2Status::Ok);
    assert_eq!(other_2.freeFMUstate(&raw mut state), fmi2Status::Ok);
    assert!(bytes == other, "the states are the same bytes");
    own_2.restore(&other).unwrap();
    assert_eq!(other_3.terminate(), fmi3Status::Ok);
}

/// Of a room with a door, with who walks there inside: both importers and both versions, and an input.
#[test]
fn both_run_a_summary_of_both_versions_to_the_same_bits() {
    let room = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../resources/Trial_door");
    let (documents, ..) =
        TrialInput::open(&room).unwrap().documents(&DriveChoice::Own, &DecisionChoice::Own).unwrap();
    let areas = vec![AreaConfig { name: "door".into(), corners: vec![2.0, 1.0, 5.0, 4.0] }];
    let config = SummaryConfig { areas, ..SummaryConfig::default() };
    let directory = TempDir::new().unwrap();
    let [fmu_2, fmu_3] = [FmuFormat::default(), FmuFormat::Fmi3].map(|format| {
        let path = directory.path().join("summary.fmu");
        let (library, file) = (binary_beside("lemons_summary_fmu").unwrap(), File::create(&path).unwrap());
        lemons_summary::pack::write_fmu(documents.clone(), &config, format, &[library], None, file).unwrap();
        Fmu::open(&path).unwrap()
    });
    let names = ["area1_density", "area1_squeeze_mean", "area1_squeeze_95", "area1_squeeze_max"];
    let own = [&fmu_2, &fmu_3].map(|fmu| fmu.instantiate("own").unwrap());
    own.iter().for_each(|own| own.initialize().unwrap());
    let (other_2, (description, other_3)) = (theirs_2(&fmu_2), theirs_3(&fmu_3));
    let of_2 = |name: &&str| fmu_2.description.variable(name).unwrap().reference;
    let of_3 = |name: &&str| description.variable_by_name(name).unwrap().valueReference;
    let (references_2, references_3) = (names.each_ref().map(of_2), names.each_ref().map(of_3));
    let mut greatest = 0.0_f64;
    for k in 0..40_u32 {
        let (time, step, push) = (f64::from(k) / 16.0, 1.0 / 16.0, if k < 20 { 0.0 } else { 150.0 });
        let (mut no, mut reached, mut seen) = ([true; 3], f64::NAN, [[f64::NAN; 4]; 2]);
        let [event, terminate, early] = &mut no;
        let done = [
            other_3.setFloat64(&[of_3(&"push")], &[push]),
            other_3.doStep(time, step, true, event, terminate, early, &mut reached),
            other_3.getFloat64(&references_3, &mut seen[0]),
        ];
        assert_eq!(done, [fmi3Status::Ok; 3]);
        let done = [
            other_2.setReal(&[of_2(&"push")], &[push]),
            other_2.doStep(time, step, 1),
            other_2.getReal(&references_2, &mut seen[1]),
        ];
        assert_eq!(done, [fmi2Status::Ok; 3]);
        assert_eq!(bits(&seen[0]), bits(&seen[1]), "step {k}");
        for own in &own {
            own.set(&own.select(["push"]).unwrap(), &[push]).unwrap();
            own.step(time, step).unwrap();
            let values = own.values::<f64>(&own.select(names).unwrap()).unwrap();
            assert_eq!(bits(&values), bits(&seen[0]), "step {k}");
        }
        greatest = greatest.max(seen[0][3]);
    }
    assert!(greatest > 100.0, "they touch");
    assert_eq!(other_3.terminate(), fmi3Status::Ok);
}
