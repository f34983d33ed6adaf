//! fmi-rs reads and runs the crowd's FMI 3.0 FMU, and gets the bits of our own master, which runs that and the FMI 2.0 FMU.

use crate::packed;
use crowd_mechanics::pack::Format;
use fmi_rs::fmi3::FMU3;
use fmi_rs::fmi3::log::Logger;
use fmi_rs::fmi3::native::{NativeLibrary, PLATFORM_TUPLE};
use fmi_rs::fmi3::types::{fmi3FMUState, fmi3Status};
use fmi_rs::model_description::fmi3::{Causality, ModelDescription};
use lemons_master::Fmu;
use std::fs::File;
use std::path::Path;
use std::sync::Arc;
use tempfile::TempDir;

const STEP: f64 = 0.01;
const STEPS: u32 = 60;
const FORCE: f64 = 900.0;
const AGENTS: usize = 5;

/// Nothing is to be said.
struct Silence;

impl Logger for Silence {
    fn log_call(&self, _: fmi3Status, _: &str) {}

    fn log_message(&self, status: fmi3Status, _: &str, message: &str) {
        panic!("{status:?}: {message}");
    }
}

/// The description, and an instance whose initialization is over.
fn instance(unpacked: &Path) -> (ModelDescription, Arc<FMU3>) {
    let description = ModelDescription::from_path(&unpacked.join("modelDescription.xml")).unwrap();
    let identifier = &description.coSimulation.as_ref().unwrap().modelIdentifier;
    let library = format!("binaries/{PLATFORM_TUPLE}/{identifier}{}", std::env::consts::DLL_SUFFIX);
    let instance = FMU3::instantiateCoSimulation(
        Box::new(NativeLibrary::load(unpacked.join(library)).unwrap()),
        Some(&unpacked.join("resources")),
        "theirs",
        &description.instantiationToken,
        false,
        true,
        false,
        false,
        Arc::new(Silence),
        false,
        None,
    );
    let instance = instance.unwrap_or_else(|error| panic!("{error}"));
    let done = [instance.enterInitializationMode(None, 0.0, None), instance.exitInitializationMode()];
    assert_eq!(done, [fmi3Status::Ok; 2]);
    (description, instance)
}

#[test]
fn fmi_rs_runs_arrays_to_the_bits_of_scalars() {
    let directory = TempDir::new().unwrap();
    let unpacked = directory.path().join("unpacked");
    let path = packed(directory.path(), Format::Fmi3);
    zip::ZipArchive::new(File::open(path).unwrap()).unwrap().extract(&unpacked).unwrap();
    let (description, theirs) = instance(&unpacked);
    let size = |name: &str| {
        let variable = description.variable_by_name(name).unwrap();
        let sizes = description.initial_size(variable).unwrap();
        (variable.valueReference, sizes.iter().product::<usize>())
    };
    assert_eq!(description.modelVariables.len(), 39);
    assert_eq!(description.outputs.len(), 15);
    let inputs = description.modelVariables.iter().filter(|it| it.causality == Causality::Input);
    assert_eq!(inputs.map(|it| &it.name[..]).collect::<Vec<_>>(), ["Fp", "Mp", "Active"]);

    // Our own master, with both versions.
    let fmus = [Format::default(), Format::Fmi3].map(|format| {
        let directory = TempDir::new().unwrap();
        let fmu = Fmu::open(&packed(directory.path(), format)).unwrap();
        let own = fmu.instantiate("own").unwrap();
        own.initialize().unwrap();
        (own, fmu)
    });
    let drives: Vec<String> =
        (0..AGENTS).flat_map(|i| ["x", "y"].map(|axis| format!("agent[{i}].Fp.{axis}"))).collect();
    let outputs: Vec<String> = [
        ["Position.x", "Position.y"].as_slice(),
        &["Theta"],
        &["Velocity.x", "Velocity.y"],
        &["Omega"],
        &["MeanNormalForce"],
        &["PeakNormalForce"],
    ]
    .into_iter()
    .flat_map(|names| {
        (0..AGENTS).flat_map(move |i| names.iter().map(move |name| format!("agent[{i}].{name}")))
    })
    .collect();
    let selected =
        fmus.each_ref().map(|(own, _)| (own.select(&drives).unwrap(), own.select(&outputs).unwrap()));

    let (fp, length) = size("Fp");
    assert_eq!(length, 2 * AGENTS);
    let arrays = ["Position", "Theta", "Velocity", "Omega", "MeanNormalForce", "PeakNormalForce"].map(size);
    let references = arrays.map(|(reference, _)| reference);
    let mut others = vec![f64::NAN; arrays.iter().map(|(_, length)| length).sum()];
    let mut ours = vec![f64::NAN; outputs.len()];
    let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
    let mut force = vec![0.0; length];
    force[0] = FORCE;
    let step = |k: u32, others: &mut [f64]| {
        let time = f64::from(k) * STEP;
        let (mut no, mut reached) = ([true; 3], f64::NAN);
        let [event, terminate, early] = &mut no;
        let done = [
            theirs.setFloat64(&[fp], &force),
            theirs.doStep(time, STEP, true, event, terminate, early, &mut reached),
            theirs.getFloat64(&references, others),
        ];
        assert_eq!((done, no, reached), ([fmi3Status::Ok; 3], [false; 3], time + STEP));
    };
    let (mut squeezed, mut state) = (0.0_f64, std::ptr::null_mut() as fmi3FMUState);
    for k in 0..STEPS {
        if k == STEPS / 2 {
            assert_eq!(theirs.getFMUState(&mut state), fmi3Status::Ok);
        }
        step(k, &mut others);
        for ((own, _), (drives, outputs)) in fmus.iter().zip(&selected) {
            own.set(drives, &force).unwrap();
            own.step(f64::from(k) * STEP, STEP).unwrap();
            own.get(outputs, &mut ours).unwrap();
            assert_eq!(bits(&ours), bits(&others), "step {k}");
        }
        squeezed = squeezed.max(others[others.len() - AGENTS]);
    }
    assert!(squeezed > 100.0, "they touch");

    // By way of bytes, in the middle of the push.
    let mut size = 0;
    assert_eq!(theirs.serializedFMUStateSize(state, &mut size), fmi3Status::Ok);
    let mut bytes = vec![0; size];
    let mut again = std::ptr::null_mut() as fmi3FMUState;
    let done = [
        theirs.serializeFMUState(state, &mut bytes),
        theirs.freeFMUState(&mut state),
        theirs.deserializeFMUState(&bytes, &mut again),
        theirs.setFMUState(again),
        theirs.freeFMUState(&mut again),
    ];
    assert_eq!(done, [fmi3Status::Ok; 5]);
    (STEPS / 2..STEPS).for_each(|k| step(k, &mut others));
    assert_eq!(bits(&ours), bits(&others));
    assert_eq!(theirs.terminate(), fmi3Status::Ok);
}
