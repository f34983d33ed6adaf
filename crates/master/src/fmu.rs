//! An FMU and its instances, by `fmi-rs`.

use crate::kind::Kind;
use crate::library::check_library;
use crate::unzip::{DESCRIPTION_FILE, unzip};
use anyhow::{Context, Result, anyhow, bail};
use crowd_mechanics::files::Scratch;
use crowd_mechanics::model_description::LARGEST_DESCRIPTION;
use crowd_mechanics::resources::{Resources, ResourcesError};
use crowd_mechanics::trial::Trial;
use fmi_rs::fmi2::log::Logger;
use fmi_rs::fmi2::types::fmi2Status;
use fmi_rs::fmi2::{CS, FMU2, PLATFORM};
use fmi_rs::model_description::fmi2::{ModelDescription, VariableType};
use lemons_files::{input, markup};
use lemons_ssp::{Allowance, Interface};
use std::collections::HashMap;
use std::path::Path;
use std::sync::{Arc, Mutex};

/// All agents, in the name of a variable.
const EVERY_AGENT: &str = "agent[*].";

/// The variables that a name means: `agent[*].Mass` those of all agents that are known, any other name itself.
pub fn named(name: &str, known: impl Fn(&str) -> bool) -> Vec<String> {
    let of_all = name.strip_prefix(EVERY_AGENT).map(|rest| {
        let names = (0..).map(|i| format!("agent[{i}].{rest}"));
        names.take_while(|name| known(name)).collect::<Vec<_>>()
    });
    of_all.filter(|all| !all.is_empty()).unwrap_or_else(|| vec![name.to_owned()])
}

/// An FMU, unzipped.
pub struct Fmu {
    directory: Scratch,
    /// What `modelDescription.xml` says.
    pub description: ModelDescription,
    /// Of the variables, by name.
    places: HashMap<String, usize>,
    /// Where it came from.
    shown: String,
    /// The Trial that was packed, by name, and where it lies.
    trial: Option<(String, String)>,
}

/// Temporary places, and what the user knows them by.
#[derive(Default, Clone)]
struct Names(Vec<(String, String)>);

impl Names {
    fn said(&self, text: &str) -> String {
        self.0.iter().fold(text.to_owned(), |text, (place, name)| text.replace(place, name))
    }
}

impl Fmu {
    /// Unzips an FMU and reads its description.
    ///
    /// # Errors
    /// No FMU there.
    pub fn open(path: &Path) -> Result<Fmu> {
        Kind::expect(path, &Kind::ARCHIVES, "an FMU")?;
        let mut allowance = Allowance::new(Allowance::FMUS);
        let fmu = Self::unzip(path, &mut allowance).with_context(|| path.display().to_string())?;
        Ok(fmu.shown_as(&path.display().to_string()))
    }

    /// Messages name its files as those of this path.
    #[must_use]
    pub fn shown_as(self, path: &str) -> Fmu {
        Fmu { shown: path.to_owned(), ..self }
    }

    /// Messages name the files of the Trial that was packed into it as those of this directory.
    #[must_use]
    pub fn of_trial(mut self, directory: &Path) -> Fmu {
        let resources = self.resources().ok();
        self.trial = resources.map(|packed| (packed.first().to_owned(), directory.display().to_string()));
        self
    }

    fn names(&self) -> Names {
        let unzipped = self.directory.path().display();
        let trial =
            self.trial.iter().map(|(name, path)| (format!("{unzipped}/resources/{name}"), path.clone()));
        Names(trial.chain([(unzipped.to_string(), self.shown.clone())]).collect())
    }

    /// As [`Fmu::open`], for a file whose name is of no interest to those who read messages.
    pub(crate) fn unzip(path: &Path, allowance: &mut Allowance) -> Result<Fmu> {
        let directory = Scratch::new().context("cannot make a temporary directory")?;
        unzip(path, directory.path(), allowance)?;
        let text = input::read_text(&directory.path().join(DESCRIPTION_FILE), LARGEST_DESCRIPTION)
            .context(DESCRIPTION_FILE)?;
        markup::check(&text).map_err(|refused| anyhow!("{DESCRIPTION_FILE}:{}: {refused}", refused.line))?;
        let description =
            ModelDescription::from_string(&text).map_err(|error| anyhow!("{DESCRIPTION_FILE}: {error}"))?;
        check_identifiers(&description).context(DESCRIPTION_FILE)?;
        check_own_library(&description, directory.path())?;
        let names = description.modelVariables.iter().enumerate();
        let places = names.map(|(place, variable)| (variable.name.clone(), place)).collect();
        Ok(Fmu { directory, description, places, shown: "FMU".into(), trial: None })
    }

    /// Where it is unzipped, until it is dropped.
    pub fn directory(&self) -> &Path {
        self.directory.path()
    }

    /// The variables and units, as SSP sees them.
    ///
    /// # Errors
    /// The model description is broken.
    pub fn interface(&self) -> Result<Interface> {
        Interface::read(&input::read(&self.directory.path().join(DESCRIPTION_FILE), LARGEST_DESCRIPTION)?)
    }

    /// The Trials that are packed in it.
    ///
    /// # Errors
    /// There are none.
    pub fn resources(&self) -> Result<Resources> {
        let path = self.directory.path().join("resources");
        let path = path.to_str().ok_or_else(|| anyhow!("{} is not UTF-8", path.display()))?;
        Resources::from_uri(path).map_err(|error| match error {
            ResourcesError::NoTrial { .. } => anyhow!("holds no Trial: it is not an FMU of a crowd"),
            error => anyhow!("{}", self.names().said(&error.to_string())),
        })
    }

    /// One of these Trials.
    ///
    /// # Errors
    /// All that is wrong with it.
    pub fn trial(&self, name: Option<&str>) -> Result<Trial> {
        let packed = self.resources()?;
        let read = packed.load(name.unwrap_or(packed.first()));
        Ok(read.map_err(|error| anyhow!("{}", self.names().said(&error.to_string())))?.0)
    }

    /// A new instance.
    ///
    /// # Errors
    /// What the FMU says.
    pub fn instantiate(&self, name: &str) -> Result<Instance> {
        let co_simulation = self
            .description
            .coSimulation
            .as_ref()
            .ok_or_else(|| anyhow!("the FMU is not for co-simulation"))?;
        let messages = Arc::new(Messages { names: self.names(), ..Messages::default() });
        let prefix = format!("{}/", self.directory.path().display());
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
        .map_err(|error| {
            let text = format!("cannot instantiate the FMU: {error}: {}", root_cause(&error));
            let error = messages.explain(anyhow!("{}", text.replace(&prefix, "")));
            if self.directory.path().join("resources").is_dir() {
                error.context(self.shown.clone())
            } else {
                error.context(format!("{}: has no directory resources, which it may need", self.shown))
            }
        })?;
        let references =
            self.description.modelVariables.iter().map(|v| (v.name.clone(), v.valueReference)).collect();
        Ok(Instance { fmu, messages, references })
    }

    /// The variables that a name means; see [`named`].
    pub fn named(&self, name: &str) -> Vec<String> {
        named(name, |name| self.places.contains_key(name))
    }

    /// The type of a variable.
    pub fn kind(&self, name: &str) -> Option<&VariableType> {
        self.places.get(name).map(|&place| &self.description.modelVariables[place].variableType)
    }
}

/// \[byte\] Of a modelIdentifier: with a platform's suffix it is the name of a file.
const LONGEST_IDENTIFIER: usize = 200;

/// That each modelIdentifier is what FMI wants, an identifier of C: it is a part of the path of a library that is loaded.
fn check_identifiers(description: &ModelDescription) -> Result<()> {
    let exchange = description.modelExchange.as_ref().map(|element| &element.modelIdentifier);
    let simulation = description.coSimulation.as_ref().map(|element| &element.modelIdentifier);
    for (element, identifier) in [("ModelExchange", exchange), ("CoSimulation", simulation)] {
        let Some(identifier) = identifier else { continue };
        if identifier.len() > LONGEST_IDENTIFIER {
            let length = identifier.len();
            bail!("<{element}> modelIdentifier: has {length} bytes: must have at most {LONGEST_IDENTIFIER}");
        }
        let letters = identifier.bytes().all(|byte| byte == b'_' || byte.is_ascii_alphanumeric());
        if !letters || identifier.is_empty() || identifier.starts_with(|first: char| first.is_ascii_digit()) {
            bail!(
                "<{element}> modelIdentifier={identifier:?}: must be a name in C: letters from A to Z, digits and _, \
                 without a digit at the beginning"
            );
        }
    }
    Ok(())
}

/// That the library for this machine, if there is one, can be loaded.
fn check_own_library(description: &ModelDescription, directory: &Path) -> Result<()> {
    let Some(simulation) = &description.coSimulation else { return Ok(()) };
    let name = format!("binaries/{PLATFORM}/{}{}", simulation.modelIdentifier, std::env::consts::DLL_SUFFIX);
    let path = directory.join(&name);
    if path.is_file() { check_library(&path, PLATFORM).context(name) } else { Ok(()) }
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
pub(crate) struct Messages {
    errors: Mutex<Vec<String>>,
    warnings: Mutex<Vec<String>>,
    names: Names,
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
        if said.is_empty() { error } else { anyhow!("{}", self.names.said(&said.join("\n"))) }
    }
}

/// What a call answered; its error is what the FMU has said of it.
pub(crate) fn done(messages: &Messages, status: fmi2Status, what: &str) -> Result<()> {
    match status {
        fmi2Status::Ok | fmi2Status::Warning => Ok(()),
        other => Err(messages.explain(anyhow!("{what} answered {other:?}"))),
    }
}

/// An instance of an FMU.
pub struct Instance {
    pub(crate) fmu: Arc<FMU2<CS>>,
    pub(crate) messages: Arc<Messages>,
    references: HashMap<String, u32>,
}

impl Instance {
    /// The value reference of a variable.
    ///
    /// # Errors
    /// There is no such variable.
    pub fn reference(&self, name: &str) -> Result<u32> {
        self.references.get(name).copied().ok_or_else(|| anyhow!("the FMU has no variable {name:?}"))
    }

    fn done(&self, status: fmi2Status, what: &str) -> Result<()> {
        done(&self.messages, status, what)
    }

    /// Sets a variable from its text.
    ///
    /// # Errors
    /// A text that is no value of the type, or the FMU's refusal.
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
            VariableType::Boolean { .. } => match text {
                "true" | "1" => self.fmu.setBoolean(&reference, &[1]),
                "false" | "0" => self.fmu.setBoolean(&reference, &[0]),
                _ => bail!("{name}={text}: neither true nor false"),
            },
            other => bail!("{name}: variables of type {} cannot be set here", other.name()),
        };
        self.done(status, "fmi2Set")
    }

    /// From `fmi2SetupExperiment` to `fmi2ExitInitializationMode`, at time 0.
    ///
    /// # Errors
    /// The FMU's refusal.
    pub fn initialize(&self) -> Result<()> {
        self.enter_initialization(0.0)?;
        self.exit_initialization()
    }

    /// `fmi2SetupExperiment` at a time \[s\] and `fmi2EnterInitializationMode`
    ///
    /// # Errors
    /// The FMU's refusal.
    pub fn enter_initialization(&self, start: f64) -> Result<()> {
        self.done(self.fmu.setupExperiment(None, start, None), "fmi2SetupExperiment")?;
        self.done(self.fmu.enterInitializationMode(), "fmi2EnterInitializationMode")
    }

    /// `fmi2ExitInitializationMode`
    ///
    /// # Errors
    /// The FMU's refusal.
    pub fn exit_initialization(&self) -> Result<()> {
        self.done(self.fmu.exitInitializationMode(), "fmi2ExitInitializationMode")
    }

    /// `fmi2SetReal`
    ///
    /// # Errors
    /// The FMU's refusal.
    pub fn set_real(&self, references: &[u32], values: &[f64]) -> Result<()> {
        self.done(self.fmu.setReal(references, values), "fmi2SetReal")
    }

    /// `fmi2GetReal`
    ///
    /// # Errors
    /// The FMU's refusal.
    pub fn get_real(&self, references: &[u32], values: &mut [f64]) -> Result<()> {
        self.done(self.fmu.getReal(references, values), "fmi2GetReal")
    }

    /// `fmi2GetInteger`
    ///
    /// # Errors
    /// The FMU's refusal.
    pub fn get_integer(&self, references: &[u32], values: &mut [i32]) -> Result<()> {
        self.done(self.fmu.getInteger(references, values), "fmi2GetInteger")
    }

    /// `fmi2SetInteger`
    ///
    /// # Errors
    /// The FMU's refusal.
    pub fn set_integer(&self, references: &[u32], values: &[i32]) -> Result<()> {
        self.done(self.fmu.setInteger(references, values), "fmi2SetInteger")
    }

    /// `fmi2GetBoolean`; anything but 0 is true.
    ///
    /// # Errors
    /// The FMU's refusal.
    pub fn get_boolean(&self, references: &[u32], values: &mut [i32]) -> Result<()> {
        self.done(self.fmu.getBoolean(references, values), "fmi2GetBoolean")
    }

    /// `fmi2SetBoolean`
    ///
    /// # Errors
    /// The FMU's refusal.
    pub fn set_boolean(&self, references: &[u32], values: &[i32]) -> Result<()> {
        self.done(self.fmu.setBoolean(references, values), "fmi2SetBoolean")
    }

    /// `fmi2GetString`
    ///
    /// # Errors
    /// The FMU's refusal.
    pub fn get_string(&self, references: &[u32], values: &mut [String]) -> Result<()> {
        self.done(self.fmu.getString(references, values), "fmi2GetString")
    }

    /// `fmi2SetString`
    ///
    /// # Errors
    /// The FMU's refusal.
    pub fn set_string(&self, references: &[u32], values: &[&str]) -> Result<()> {
        self.done(self.fmu.setString(references, values), "fmi2SetString")
    }

    /// `fmi2DoStep` from a time over a step, both \[s\].
    ///
    /// # Errors
    /// The FMU's refusal or failure.
    pub fn step(&self, time: f64, step: f64) -> Result<()> {
        self.done(self.fmu.doStep(time, step, 1), "fmi2DoStep")
    }

    /// `fmi2Reset`
    ///
    /// # Errors
    /// The FMU's refusal.
    pub fn reset(&self) -> Result<()> {
        self.done(self.fmu.reset(), "fmi2Reset")
    }

    /// `fmi2Terminate`
    ///
    /// # Errors
    /// The FMU's refusal.
    pub fn terminate(&self) -> Result<()> {
        self.done(self.fmu.terminate(), "fmi2Terminate")
    }

    /// What the FMU has warned of since the last call.
    pub fn warnings(&self) -> Vec<String> {
        let said =
            self.messages.warnings.lock().map(|mut list| std::mem::take(&mut *list)).unwrap_or_default();
        said.iter().map(|message| self.messages.names.said(message)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each was handed to the loader: `../` led out of the FMU.
    #[test]
    fn a_model_identifier_is_a_name_in_c() {
        let said = |identifier: &str, element: &str| {
            let directory = tempfile::TempDir::new().unwrap();
            let path = directory.path().join("x.fmu");
            let mut zip = zip::ZipWriter::new(std::fs::File::create(&path).unwrap());
            zip.start_file(DESCRIPTION_FILE, zip::write::SimpleFileOptions::default()).unwrap();
            let text = format!(
                "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"x\" guid=\"x\">\
                 <{element} modelIdentifier=\"{identifier}\"/><ModelVariables/><ModelStructure/>\
                 </fmiModelDescription>"
            );
            std::io::Write::write_all(&mut zip, text.as_bytes()).unwrap();
            zip.finish().unwrap();
            Fmu::open(&path).map_or_else(|error| format!("{error:#}"), |_| "taken".to_owned())
        };
        let long = "a".repeat(201);
        for element in ["CoSimulation", "ModelExchange"] {
            for good in ["a", "_", "A_b9", &long[..200]] {
                assert_eq!(said(good, element), "taken");
            }
            for bad in [
                "",
                "9a",
                "../a",
                "a/../../b",
                "/tmp/a",
                "a/b",
                "a\\b",
                "..",
                ".",
                "C:a",
                "a b",
                "a.b",
                "a-b",
                "\u{e4}",
                "a\u{202e}b",
                "a&#10;b",
            ] {
                let text = said(bad, element);
                let place = format!("x.fmu: modelDescription.xml: <{element}> modelIdentifier=\"");
                assert!(text.contains(&place) && text.contains("must be a name in C"), "{bad}: {text}");
            }
            let text = said(&long, element);
            assert!(text.contains("modelIdentifier: has 201 bytes: must have at most 200"), "{text}");
            // XML knows no NUL.
            assert!(said("a&#0;b", element).contains("x.fmu: modelDescription.xml: "));
        }
    }
}
