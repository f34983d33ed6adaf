//! An FMI 2.0 master on `fmi-rs`: knows of the FMU what its model description says.

use anyhow::{Context, Result, anyhow, bail};
use crowd_mechanics::resources::Resources;
use fmi_rs::fmi2::log::Logger;
use fmi_rs::fmi2::types::fmi2Status;
use fmi_rs::fmi2::{CS, FMU2};
use fmi_rs::model_description::fmi2::{ModelDescription, VariableType};
use fmi_rs::zip::extract_zip_archive;
use std::collections::HashMap;
use std::path::Path;
use std::sync::{Arc, Mutex};
use tempfile::TempDir;

/// An FMU, unzipped.
pub struct Fmu {
    directory: TempDir,
    pub description: ModelDescription,
}

impl Fmu {
    pub fn open(path: &Path) -> Result<Fmu> {
        let directory = TempDir::with_prefix("lemons-").context("cannot make a temporary directory")?;
        extract_zip_archive(path, directory.path())
            .map_err(|error| anyhow!("{}: {}", path.display(), root_cause(&error)))?;
        let description = ModelDescription::from_path(&directory.path().join("modelDescription.xml"))
            .map_err(|error| anyhow!("{}: modelDescription.xml: {error}", path.display()))?;
        Ok(Fmu { directory, description })
    }

    /// The Trials that are packed in it.
    pub fn resources(&self) -> Result<Resources> {
        let path = self.directory.path().join("resources");
        let path = path.to_str().ok_or_else(|| anyhow!("{} is not UTF-8", path.display()))?;
        Ok(Resources::from_uri(path)?)
    }

    /// A new instance.
    pub fn instantiate(&self, name: &str) -> Result<Instance> {
        let co_simulation = self
            .description
            .coSimulation
            .as_ref()
            .ok_or_else(|| anyhow!("the FMU is not for co-simulation"))?;
        let messages = Arc::new(Messages::default());
        let fmu = FMU2::<CS>::new(
            self.directory.path(),
            &co_simulation.modelIdentifier,
            name,
            &self.description.guid,
            false,
            false,
            false,
            messages.clone(),
            !co_simulation.canNotUseMemoryManagementFunctions,
        )
        .map_err(|error| messages.explain(anyhow!("cannot instantiate the FMU: {error}")))?;
        let references =
            self.description.modelVariables.iter().map(|v| (v.name.clone(), v.valueReference)).collect();
        Ok(Instance { fmu, messages, references })
    }

    /// The type of a variable.
    pub fn kind(&self, name: &str) -> Option<&VariableType> {
        self.description.modelVariables.iter().find(|v| v.name == name).map(|v| &v.variableType)
    }
}

fn root_cause(error: &dyn std::error::Error) -> String {
    let mut cause = error;
    while let Some(source) = cause.source() {
        cause = source;
    }
    cause.to_string()
}

/// What the FMU logs. Errors become the run's error; warnings are kept for the end.
#[derive(Default)]
struct Messages {
    errors: Mutex<Vec<String>>,
    warnings: Mutex<Vec<String>>,
}

impl Logger for Messages {
    fn log_call(&self, _: fmi2Status, _: &str) {}

    fn log_message(&self, status: fmi2Status, _: &str, message: &str) {
        let list = match status {
            fmi2Status::Ok => return,
            fmi2Status::Warning | fmi2Status::Discard => &self.warnings,
            _ => &self.errors,
        };
        if let Ok(mut list) = list.lock() {
            list.push(message.to_owned());
        }
    }
}

impl Messages {
    fn explain(&self, error: anyhow::Error) -> anyhow::Error {
        let said = self.errors.lock().map(|mut list| std::mem::take(&mut *list)).unwrap_or_default();
        if said.is_empty() { error } else { anyhow!("{}", said.join("\n")) }
    }
}

/// An instance of an FMU.
pub struct Instance {
    fmu: Arc<FMU2<CS>>,
    messages: Arc<Messages>,
    references: HashMap<String, u32>,
}

impl Instance {
    pub fn reference(&self, name: &str) -> Result<u32> {
        self.references.get(name).copied().ok_or_else(|| anyhow!("the FMU has no variable {name:?}"))
    }

    fn done(&self, status: fmi2Status, what: &str) -> Result<()> {
        match status {
            fmi2Status::Ok | fmi2Status::Warning => Ok(()),
            other => Err(self.messages.explain(anyhow!("{what} answered {other:?}"))),
        }
    }

    /// Sets a parameter from its text.
    pub fn set(&self, kind: &VariableType, name: &str, text: &str) -> Result<()> {
        let reference = [self.reference(name)?];
        let number_wanted = || format!("{name}={text}: not a number");
        let status = match kind {
            VariableType::Real { .. } => {
                self.fmu.setReal(&reference, &[text.parse().with_context(number_wanted)?])
            }
            VariableType::Integer { .. } => {
                self.fmu.setInteger(&reference, &[text.parse().with_context(number_wanted)?])
            }
            VariableType::String { .. } => self.fmu.setString(&reference, &[text]),
            other => bail!("{name}: variables of type {} cannot be set here", other.name()),
        };
        self.done(status, "fmi2Set")
    }

    pub fn initialize(&self) -> Result<()> {
        self.done(self.fmu.setupExperiment(None, 0.0, None), "fmi2SetupExperiment")?;
        self.done(self.fmu.enterInitializationMode(), "fmi2EnterInitializationMode")?;
        self.done(self.fmu.exitInitializationMode(), "fmi2ExitInitializationMode")
    }

    pub fn set_real(&self, references: &[u32], values: &[f64]) -> Result<()> {
        self.done(self.fmu.setReal(references, values), "fmi2SetReal")
    }

    pub fn get_real(&self, references: &[u32], values: &mut [f64]) -> Result<()> {
        self.done(self.fmu.getReal(references, values), "fmi2GetReal")
    }

    pub fn get_integer(&self, references: &[u32], values: &mut [i32]) -> Result<()> {
        self.done(self.fmu.getInteger(references, values), "fmi2GetInteger")
    }

    pub fn step(&self, time: f64, step: f64) -> Result<()> {
        self.done(self.fmu.doStep(time, step, 1), "fmi2DoStep")
    }

    pub fn terminate(&self) -> Result<()> {
        self.done(self.fmu.terminate(), "fmi2Terminate")
    }

    pub fn warnings(&self) -> Vec<String> {
        self.messages.warnings.lock().map(|mut list| std::mem::take(&mut *list)).unwrap_or_default()
    }
}
