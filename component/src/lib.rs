//! The crowd as a component of FMI-LS-WASM: the functions of FMI 3.0, with lists instead of pointers.
//!
//! A component has neither a disk nor threads. Its Trials are those that were built into it, or else
//! the importer reads them (`resource-dir-callbacks`). No intermediate updates are made: while a
//! component runs, its importer cannot call it, so that no values could be read.

mod resources;

use crowd_mechanics::model::CrowdModel;
use exports::fmi::fmi3::co_simulation::{self, DoStepResult, GuestCoSimulationInstance};
use exports::fmi::fmi3::common;
use fmi::fmi3::callbacks::log_message;
use fmi::fmi3::types::{
    DependencyKind, DiscreteStatesInfo, IntervalFraction, IntervalQualifier, Status, VariableDependency,
};
use lemons_fmi::boundary::Log;
use lemons_fmi::lifecycle::{Function, Phase};
use lemons_fmi::location::Location;
use lemons_fmi::variables::{BaseType, Number};
use lemons_fmi::{Answer, Model, Refusal, Slave, Version, refuse};
use std::cell::RefCell;

wit_bindgen::generate!({ world: "co-simulation-fmu", path: "wit" });
export!(Fmu);

struct Fmu;

impl common::Guest for Fmu {
    fn get_version() -> String {
        "3.0".to_owned()
    }
}

impl co_simulation::Guest for Fmu {
    type CoSimulationInstance = Instance;
}

struct Instance(RefCell<Content>);

struct Content {
    slave: Slave<CrowdModel>,
    log: Log,
}

impl Instance {
    /// Runs a call, and tells why it was refused or what it warns of.
    fn call<T>(
        &self,
        function: &str,
        body: impl FnOnce(&mut Slave<CrowdModel>) -> Answer<T>,
    ) -> Result<T, Status> {
        let Content { slave, log } = &mut *self.0.borrow_mut();
        match body(slave) {
            Ok(value) => {
                tell_warnings(slave, log);
                Ok(value)
            }
            Err(refusal) => Err(tell(log, function, &refusal)),
        }
    }

    /// The same, of a call that returns nothing.
    fn done(&self, function: &str, body: impl FnOnce(&mut Slave<CrowdModel>) -> Answer<()>) -> Status {
        self.call(function, body).map_or_else(|status| status, |()| Status::Ok)
    }

    fn get<N: Number>(&self, function: &str, references: &[u32]) -> Result<Vec<N>, Status> {
        self.call(function, |slave| {
            let mut values = vec![N::of(0.0); slave.count(references, N::TYPE)?];
            slave.get(references, &mut values).map(|()| values)
        })
    }

    fn set<N: Number>(&self, function: &str, references: &[u32], values: &[N]) -> Status {
        self.done(function, |slave| slave.set(references, values))
    }

    fn not_offered<T>(&self, function: &str) -> Result<T, Status> {
        self.call(function, |slave| slave.not_offered())
    }
}

fn tell_warnings(slave: &mut Slave<CrowdModel>, log: &Log) {
    for warning in slave.take_warnings() {
        log.write(lemons_fmi::Status::Warning, &warning);
    }
}

fn tell(log: &Log, function: &str, refusal: &Refusal) -> Status {
    log.write(refusal.status, &format!("{function}: {refusal}"));
    status(refusal.status)
}

fn status(status: lemons_fmi::Status) -> Status {
    match status {
        lemons_fmi::Status::Ok => Status::Ok,
        lemons_fmi::Status::Warning => Status::Warning,
        lemons_fmi::Status::Discard => Status::Discard,
        lemons_fmi::Status::Error | lemons_fmi::Status::Pending => Status::Error,
        lemons_fmi::Status::Fatal => Status::Fatal,
    }
}

/// Value references and orders, apart.
fn unzip(requests: Vec<(u32, u32)>) -> (Vec<u32>, Vec<i32>) {
    let order = |order| i32::try_from(order).unwrap_or(i32::MAX);
    requests.into_iter().map(|(reference, of)| (reference, order(of))).unzip()
}

/// The functions for types that no variable has.
macro_rules! without_variables {
    ($($get:ident $set:ident $type:ty, $name:literal;)*) => { $(
        fn $get(&self, references: Vec<u32>) -> Result<Vec<$type>, Status> {
            self.call(concat!("fmi3Get", $name), |slave| {
                slave.no_variables(Function::Get, $name, &references).map(|()| Vec::new())
            })
        }

        fn $set(&self, references: Vec<u32>, _values: Vec<$type>) -> Status {
            self.done(concat!("fmi3Set", $name), |slave| {
                slave.no_variables(Function::Set, $name, &references)
            })
        }
    )* };
}

/// The functions for types that variables have.
macro_rules! with_variables {
    ($($get:ident $set:ident $type:ty, $name:literal;)*) => { $(
        fn $get(&self, references: Vec<u32>) -> Result<Vec<$type>, Status> {
            self.get(concat!("fmi3Get", $name), &references)
        }

        fn $set(&self, references: Vec<u32>, values: Vec<$type>) -> Status {
            self.set(concat!("fmi3Set", $name), &references, &values)
        }
    )* };
}

/// The functions of FMI that are not offered.
macro_rules! not_offered {
    ($($function:ident($($argument:ident: $type:ty),*) -> $result:ty, $name:literal;)*) => { $(
        fn $function(&self, $($argument: $type),*) -> Result<$result, Status> {
            self.not_offered($name)
        }
    )* };
    (status $($function:ident($($argument:ident: $type:ty),*), $name:literal;)*) => { $(
        fn $function(&self, $($argument: $type),*) -> Status {
            self.not_offered::<()>($name).err().unwrap_or(Status::Error)
        }
    )* };
}

impl GuestCoSimulationInstance for Instance {
    fn instantiate_co_simulation(
        instance_name: String,
        token: String,
        _visible: bool,
        logging_on: bool,
        event_mode_used: bool,
        _early_return_allowed: bool,
        _required_intermediate_variables: Vec<u32>,
    ) -> Option<co_simulation::CoSimulationInstance> {
        let write =
            |name: &str, of, category: &str, text: &str| log_message(name, status(of), category, text);
        let log = Log::of_component(write, &instance_name, logging_on);
        let slave = || {
            if instance_name.trim().is_empty() {
                return refuse("instanceName is empty or blank");
            }
            if event_mode_used {
                return refuse("eventModeUsed: hasEventMode is false");
            }
            Slave::new(CrowdModel::load(Location::Files(resources::FILES))?, Version::V3, &token)
        };
        match slave() {
            Ok(mut slave) => {
                tell_warnings(&mut slave, &log);
                let instance = Instance(RefCell::new(Content { slave, log }));
                Some(co_simulation::CoSimulationInstance::new(instance))
            }
            Err(refusal) => {
                tell(&log, "fmi3InstantiateCoSimulation", &refusal);
                None
            }
        }
    }

    fn set_debug_logging(&self, on: bool, categories: Vec<String>) -> Status {
        let checked = self.done("fmi3SetDebugLogging", |slave| slave.check(Function::SetDebugLogging));
        if checked != Status::Ok {
            return checked;
        }
        let names: Vec<&str> = categories.iter().map(String::as_str).collect();
        let Content { log, .. } = &mut *self.0.borrow_mut();
        match log.choose(on, &names) {
            Ok(()) => Status::Ok,
            Err(refusal) => tell(log, "fmi3SetDebugLogging", &refusal),
        }
    }

    fn enter_initialization_mode(&self, tolerance: Option<f64>, start: f64, stop: Option<f64>) -> Status {
        self.done("fmi3EnterInitializationMode", |slave| {
            slave.setup_experiment(start, stop, tolerance)?;
            slave.enter_initialization()
        })
    }

    fn exit_initialization_mode(&self) -> Status {
        self.done("fmi3ExitInitializationMode", Slave::exit_initialization)
    }

    fn terminate(&self) -> Status {
        self.done("fmi3Terminate", |slave| slave.change_phase(Function::Terminate, Phase::Terminated))
    }

    fn reset(&self) -> Status {
        self.done("fmi3Reset", Slave::reset)
    }

    fn enter_configuration_mode(&self) -> Status {
        self.done("fmi3EnterConfigurationMode", |slave| {
            slave.change_phase(Function::EnterConfigurationMode, Phase::Configuration)
        })
    }

    fn exit_configuration_mode(&self) -> Status {
        self.done("fmi3ExitConfigurationMode", |slave| {
            slave.change_phase(Function::ExitConfigurationMode, Phase::Instantiated)
        })
    }

    with_variables! {
        get_float64 set_float64 f64, "Float64";
        get_int32 set_int32 i32, "Int32";
        get_uint64 set_uint64 u64, "UInt64";
        get_boolean set_boolean bool, "Boolean";
    }

    without_variables! {
        get_float32 set_float32 f32, "Float32";
        get_int8 set_int8 i8, "Int8";
        get_int16 set_int16 i16, "Int16";
        get_int64 set_int64 i64, "Int64";
        get_uint8 set_uint8 u8, "UInt8";
        get_uint16 set_uint16 u16, "UInt16";
        get_uint32 set_uint32 u32, "UInt32";
        get_binary set_binary Vec<u8>, "Binary";
        get_clock set_clock bool, "Clock";
    }

    fn get_string(&self, references: Vec<u32>) -> Result<Vec<String>, Status> {
        self.call("fmi3GetString", |slave| {
            let count = slave.count(&references, BaseType::String)?;
            slave.get_strings(&references, count)
        })
    }

    fn set_string(&self, references: Vec<u32>, values: Vec<String>) -> Status {
        let values: Vec<&str> = values.iter().map(String::as_str).collect();
        self.done("fmi3SetString", |slave| slave.set_strings(&references, &values))
    }

    fn get_number_of_variable_dependencies(&self, reference: u32) -> Result<u64, Status> {
        self.call("fmi3GetNumberOfVariableDependencies", |slave| {
            Ok(slave.dependencies(reference)?.len() as u64)
        })
    }

    fn get_variable_dependencies(&self, dependent: u32) -> Result<Vec<VariableDependency>, Status> {
        self.call("fmi3GetVariableDependencies", |slave| {
            let index = |index| u32::try_from(index).unwrap_or(u32::MAX);
            let of = |(element, independent, of)| VariableDependency {
                dependent_value_reference: dependent,
                element_index_of_dependent: index(element),
                independent_value_reference: independent,
                element_index_of_independent: index(of),
                kind: DependencyKind::Dependent,
            };
            Ok(slave.dependencies(dependent)?.into_iter().map(of).collect())
        })
    }

    fn get_fmu_state(&self) -> Result<Vec<u8>, Status> {
        self.call("fmi3GetFMUState", |slave| slave.serialize(&slave.snapshot()?))
    }

    fn set_fmu_state(&self, state: Vec<u8>) -> Status {
        self.done("fmi3SetFMUState", |slave| slave.restore(&slave.deserialize(&state)?))
    }

    fn get_directional_derivative(&self, _: Vec<u32>, _: Vec<u32>, _: Vec<f64>) -> Result<Vec<f64>, Status> {
        self.call("fmi3GetDirectionalDerivative", |slave| slave.no_directional_derivative())
    }

    fn get_adjoint_derivative(&self, _: Vec<u32>, _: Vec<u32>, _: Vec<f64>) -> Result<Vec<f64>, Status> {
        self.call("fmi3GetAdjointDerivative", |slave| slave.no_directional_derivative())
    }

    fn get_output_derivatives(&self, requests: Vec<(u32, u32)>) -> Result<Vec<f64>, Status> {
        let (references, orders) = unzip(requests);
        self.call("fmi3GetOutputDerivatives", |slave| {
            let mut values = vec![0.0; slave.count(&references, BaseType::Real)?];
            slave.get_output_derivatives(&references, &orders, &mut values).map(|()| values)
        })
    }

    fn do_step(&self, from: f64, length: f64, _no_set_state_before: bool) -> Result<DoStepResult, Status> {
        self.call("fmi3DoStep", |slave| {
            Ok(DoStepResult {
                last_successful_time: slave.step(from, length)?,
                event_handling_needed: false,
                terminate_simulation: false,
                early_return: false,
            })
        })
    }

    not_offered! {
        update_discrete_states() -> DiscreteStatesInfo, "fmi3UpdateDiscreteStates";
        get_interval_decimal(_references: Vec<u32>) -> Vec<(f64, IntervalQualifier)>, "fmi3GetIntervalDecimal";
        get_interval_fraction(_references: Vec<u32>) -> Vec<(IntervalFraction, IntervalQualifier)>,
            "fmi3GetIntervalFraction";
        get_shift_decimal(_references: Vec<u32>) -> Vec<f64>, "fmi3GetShiftDecimal";
        get_shift_fraction(_references: Vec<u32>) -> Vec<IntervalFraction>, "fmi3GetShiftFraction";
    }

    not_offered! { status
        enter_event_mode(), "fmi3EnterEventMode";
        enter_step_mode(), "fmi3EnterStepMode";
        evaluate_discrete_states(), "fmi3EvaluateDiscreteStates";
        set_interval_decimal(_references: Vec<u32>, _intervals: Vec<f64>), "fmi3SetIntervalDecimal";
        set_interval_fraction(_references: Vec<u32>, _intervals: Vec<IntervalFraction>),
            "fmi3SetIntervalFraction";
        set_shift_decimal(_references: Vec<u32>, _shifts: Vec<f64>), "fmi3SetShiftDecimal";
        set_shift_fraction(_references: Vec<u32>, _shifts: Vec<IntervalFraction>), "fmi3SetShiftFraction";
        set_input_derivatives(_requests: Vec<(u32, u32)>, _values: Vec<f64>), "fmi3SetInputDerivatives";
    }
}
