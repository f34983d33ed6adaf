//! An importer that others wrote, fmi-rs, and our own: both read and run the crowd's FMU alike.

use crate::packed;
use crowd_mechanics::pack::Format;
use fmi_rs::fmi2::log::Logger;
use fmi_rs::fmi2::types::{fmi2FMUstate, fmi2Status};
use fmi_rs::fmi2::{CS, FMU2};
use fmi_rs::model_description::fmi2::{Causality, ModelDescription, VariableType};
use lemons_master::Fmu;
use lemons_master::ssp::{Address, Kind, Type};
use std::sync::Arc;
use tempfile::TempDir;

/// Nothing is to be said.
struct Silence;

impl Logger for Silence {
    fn log_call(&self, _: fmi2Status, _: &str) {}

    fn log_message(&self, status: fmi2Status, _: &str, message: &str) {
        panic!("{status:?}: {message}");
    }
}

#[test]
fn both_read_the_same_description() {
    let directory = TempDir::new().unwrap();
    let fmu = Fmu::open(&packed(directory.path(), Format::default())).unwrap();
    let (own, theirs) = (
        &fmu.description,
        ModelDescription::from_path(&fmu.directory().join("modelDescription.xml")).unwrap(),
    );
    assert_eq!(
        (&own.model_name, &own.guid, &own.version),
        (&theirs.modelName, &theirs.guid, &theirs.version)
    );
    let (able, other) = (own.co_simulation.as_ref().unwrap(), theirs.coSimulation.as_ref().unwrap());
    assert_eq!(able.identifier, other.modelIdentifier);
    assert_eq!(able.cannot_use_memory_functions, other.canNotUseMemoryManagementFunctions);
    assert_eq!(able.can_get_and_set_state, other.canGetAndSetFMUstate);
    assert_eq!(able.can_serialize_state, other.canSerializeFMUstate);
    assert_eq!(own.variables.len(), theirs.modelVariables.len());
    for (own, theirs) in own.variables.iter().zip(&theirs.modelVariables) {
        assert_eq!((&own.name, own.reference), (&theirs.name, theirs.valueReference));
        assert_eq!(
            (&own.description, own.start.first()),
            (&theirs.description, theirs.variableType.start().as_ref())
        );
        let kind = match theirs.causality {
            Causality::Input => Some(Kind::Input),
            Causality::Output => Some(Kind::Output),
            Causality::Parameter => Some(Kind::Parameter),
            Causality::CalculatedParameter => Some(Kind::CalculatedParameter),
            Causality::Local | Causality::Independent => None,
        };
        let (of, unit) = match &theirs.variableType {
            VariableType::Real { unit, .. } => (Type::Real, unit.as_ref()),
            VariableType::Integer { .. } => (Type::Integer, None),
            VariableType::Boolean { .. } => (Type::Boolean, None),
            VariableType::String { .. } => (Type::String, None),
            VariableType::Enumeration { .. } => (Type::Enumeration, None),
        };
        assert_eq!((own.kind, own.of, own.unit.as_ref()), (kind, of, unit), "{}", own.name);
    }
}

#[test]
fn both_run_to_the_same_bits() {
    const STEP: f64 = 0.01;
    const FORCE: f64 = 900.0;
    let directory = TempDir::new().unwrap();
    let fmu = Fmu::open(&packed(directory.path(), Format::default())).unwrap();
    let outputs = fmu.description.variables.iter();
    let outputs: Vec<u32> = outputs
        .filter(|variable| variable.kind == Some(Kind::Output) && variable.of == Type::Real)
        .map(|variable| variable.reference)
        .collect();
    let input = [fmu.description.variable("agent[0].Fp.x").unwrap().reference];
    let own = fmu.instantiate("own").unwrap();
    let select = |references: &[u32]| {
        let at = |reference: &u32| Address { of: Type::Real, reference: *reference, element: None };
        own.select_at(&references.iter().map(at).collect::<Vec<_>>()).unwrap()
    };
    let (own_input, own_outputs) = (select(&input), select(&outputs));
    let (identifier, guid) =
        (&fmu.description.co_simulation.as_ref().unwrap().identifier, &fmu.description.guid);
    let theirs = FMU2::<CS>::new(
        fmu.directory(),
        identifier,
        "theirs",
        guid,
        false,
        false,
        false,
        Arc::new(Silence),
        true,
    );
    let theirs = theirs.unwrap_or_else(|error| panic!("{error}"));
    own.initialize().unwrap();
    let done = [
        theirs.setupExperiment(None, 0.0, None),
        theirs.enterInitializationMode(),
        theirs.exitInitializationMode(),
    ];
    assert_eq!(done, [fmi2Status::Ok; 3]);
    let (mut ours, mut others) = (vec![0.0; outputs.len()], vec![0.0; outputs.len()]);
    let mut squeezed = false;
    for k in 0..60 {
        let time = f64::from(k) * STEP;
        own.set(&own_input, &[FORCE]).unwrap();
        own.step(time, STEP).unwrap();
        own.get(&own_outputs, &mut ours).unwrap();
        let done = [
            theirs.setReal(&input, &[FORCE]),
            theirs.doStep(time, STEP, 1),
            theirs.getReal(&outputs, &mut others),
        ];
        assert_eq!(done, [fmi2Status::Ok; 3]);
        let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert!(bits(&ours) == bits(&others), "step {k}");
        squeezed |= ours.iter().any(|value| *value > 100.0);
    }
    assert!(squeezed, "somebody is pushed");
    // A state crosses from one to the other, as bytes.
    let bytes = own.state().unwrap();
    let (mut state, mut size): (fmi2FMUstate, usize) = (std::ptr::null_mut(), 0);
    let done = [theirs.getFMUstate(&raw mut state), theirs.serializedFMUstateSize(state, &mut size)];
    assert_eq!((done, size), ([fmi2Status::Ok; 2], bytes.len()));
    let mut other = vec![0; size];
    assert_eq!(theirs.serializeFMUstate(state, &mut other), fmi2Status::Ok);
    assert_eq!(theirs.freeFMUstate(&raw mut state), fmi2Status::Ok);
    assert!(bytes == other, "the states are the same bytes");
    own.restore(&other).unwrap();
}
