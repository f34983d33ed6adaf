//! An FMU and its instances.

use crate::calls::{Answer, Calls, Made};
use crate::drive::{DriveChoice, DriveTable, own_drive};
use crate::error::{Cause, Error, Place, Result};
use crate::kind::Kind;
use crate::library::check_library;
use crate::unzip::{DESCRIPTION_FILE, unzip};
use crowd_mechanics::model_description::LARGEST_DESCRIPTION;
use crowd_mechanics::pack::host_platform;
use crowd_mechanics::resources::{Resources, ResourcesError};
use lemons_files::{Scratch, input};
use lemons_fmi::Status;
use lemons_fmi::location::Location;
use lemons_ssp::{Allowance, Interface, Type};
use lemons_trial::Trial;
use std::collections::HashMap;
use std::path::Path;
use std::rc::Rc;
use std::str::FromStr;
use std::sync::{Arc, Mutex};

/// Stands for all agents in the name of a variable.
const EVERY_AGENT: &str = "agent[*].";

/// The variables that a name stands for: `agent[*].Mass` stands for those of all known agents, any other name for itself.
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
    /// The content of `modelDescription.xml`.
    pub description: Interface,
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
    /// There is no FMU.
    pub fn open(path: &Path) -> Result<Fmu> {
        Kind::expect(path, &Kind::ARCHIVES, "an FMU")?;
        let mut allowance = Allowance::new(Allowance::FMUS);
        let fmu = Self::unzip(path, &mut allowance).place(|| path.display().to_string())?;
        Ok(fmu.shown_as(&path.display().to_string()))
    }

    /// In messages, its files get this path.
    #[must_use]
    pub fn shown_as(self, path: &str) -> Fmu {
        Fmu { shown: path.to_owned(), ..self }
    }

    /// In messages, the files of the Trial that was packed into it get the path of this directory.
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

    /// Like [`Fmu::open`], for a file whose name does not matter in messages.
    pub(crate) fn unzip(path: &Path, allowance: &mut Allowance) -> Result<Fmu> {
        let directory = Scratch::new().map_err(Error::io("cannot make a temporary directory"))?;
        unzip(path, directory.path(), allowance)?;
        let bytes = input::read(&directory.path().join(DESCRIPTION_FILE), LARGEST_DESCRIPTION)
            .place(|| DESCRIPTION_FILE.to_owned())?;
        let description = Interface::read(&bytes)?;
        check_identifiers(&description).place(|| DESCRIPTION_FILE.to_owned())?;
        check_own_library(&description, directory.path())?;
        Ok(Fmu { directory, description, shown: "FMU".into(), trial: None })
    }

    /// The directory into which it is unzipped; it exists until the FMU is dropped.
    pub fn directory(&self) -> &Path {
        self.directory.path()
    }

    /// The Trials that are packed in it.
    ///
    /// # Errors
    /// There are none.
    pub fn resources(&self) -> Result<Resources> {
        let path = self.directory.path().join("resources");
        let path = path.to_str().ok_or_else(|| Error::Trial(format!("{} is not UTF-8", path.display())))?;
        Resources::at(Location::Path(path)).map_err(|error| match error {
            ResourcesError::NoTrial { .. } => Error::NoTrial,
            error => Error::Trial(self.names().said(&error.to_string())),
        })
    }

    /// One of these Trials.
    ///
    /// # Errors
    /// All errors in its files.
    pub fn trial(&self, name: Option<&str>) -> Result<Trial> {
        let packed = self.resources()?;
        let read = packed.load(name.unwrap_or(packed.first()));
        Ok(read.map_err(|error| Error::Trial(self.names().said(&error.to_string())))?.0)
    }

    /// What drives a Trial of this FMU.
    ///
    /// # Errors
    /// The drive file has errors: [`Error::Broken`] if it is that of a Trial that was given, else [`Error::Drive`].
    /// Files have the names that the user knows.
    pub fn drive(&self, trial: Option<&Trial>, choice: &DriveChoice) -> Result<DriveTable> {
        DriveTable::of(trial, choice).map_err(|error| {
            let own = trial.filter(|_| *choice == DriveChoice::Own);
            let Some(trial) = own else { return Error::Drive(error) };
            let error = error.of_file(Path::new(&self.names().said(&own_drive(trial).to_string_lossy())));
            match &self.trial {
                Some((_, path)) => Error::Broken { path: path.into(), problems: error.0 },
                None => Error::Drive(error),
            }
        })
    }

    /// A new instance.
    ///
    /// # Errors
    /// The FMU cannot be instantiated; the error contains its messages.
    pub fn instantiate(&self, name: &str) -> Result<Instance> {
        let own = self.description.co_simulation.as_ref();
        let own = own.ok_or(Error::NotCoSimulation)?;
        let platform = host_platform().ok_or(Error::NoPlatform)?;
        let library = self.directory.path().join(library_of(&own.identifier, platform));
        if !library.exists() {
            return Err(self.no_binary(&own.identifier, platform)).place(|| self.shown.clone());
        }
        let messages = Arc::new(Messages { names: self.names(), ..Messages::default() });
        let made = Made {
            library: &library,
            resources: &self.directory.path().join("resources"),
            name,
            guid: &self.description.guid,
            memory_functions: !own.cannot_use_memory_functions,
        };
        let told = messages.clone();
        let calls = Calls::new(&made, Box::new(move |status, text| told.hear(status, text)));
        let calls = calls.map_err(|error| {
            let prefix = format!("{}/", self.directory.path().display());
            let why = Error::from(error).whole().replace(&prefix, "");
            let mut place = self.shown.clone();
            if !self.directory.path().join("resources").is_dir() {
                place += ": has no directory resources, which it may need";
            }
            Error::In { place, source: Box::new(Error::Instantiate { why, said: messages.errors() }) }
        })?;
        let variables = self.description.variables.iter();
        let references = variables.map(|variable| (variable.name.clone(), variable.reference)).collect();
        Ok(Instance { calls: Rc::new(calls), messages, references })
    }

    /// It has no library for a platform, but perhaps for others.
    fn no_binary(&self, identifier: &str, platform: &'static str) -> Error {
        let files = |directory: &Path| directory.read_dir().into_iter().flatten().flatten();
        let has_library = |platform: &Path| {
            files(platform).any(|file| Path::new(&file.file_name()).file_stem() == Some(identifier.as_ref()))
        };
        let platforms =
            files(&self.directory.path().join("binaries")).filter(|entry| has_library(&entry.path()));
        let mut others: Vec<String> =
            platforms.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        others.sort();
        Error::NoBinary { name: library_of(identifier, platform), others }
    }

    /// The variables that a name stands for; see [`named`].
    pub fn named(&self, name: &str) -> Vec<String> {
        named(name, |name| self.description.variable(name).is_some())
    }

    /// The type of a variable.
    pub fn kind(&self, name: &str) -> Option<&Type> {
        self.description.variable(name).map(|variable| &variable.of)
    }
}

/// \[byte\] Of a modelIdentifier: with a platform's suffix it is the name of a file.
const LONGEST_IDENTIFIER: usize = 200;

/// That each modelIdentifier is what FMI wants, an identifier of C: it is a part of the path of a library that is loaded.
fn check_identifiers(description: &Interface) -> Result<()> {
    let exchange = description.model_exchange.as_ref();
    let simulation = description.co_simulation.as_ref().map(|own| &own.identifier);
    for (element, identifier) in [("ModelExchange", exchange), ("CoSimulation", simulation)] {
        let Some(identifier) = identifier else { continue };
        if identifier.len() > LONGEST_IDENTIFIER {
            let length = identifier.len();
            let why = format!(": has {length} bytes: must have at most {LONGEST_IDENTIFIER}");
            return Err(Error::Identifier { element, why });
        }
        let letters = identifier.bytes().all(|byte| byte == b'_' || byte.is_ascii_alphanumeric());
        if !letters || identifier.is_empty() || identifier.starts_with(|first: char| first.is_ascii_digit()) {
            let why = format!(
                "={identifier:?}: must be a name in C: letters from A to Z, digits and _, without a digit at the \
                 beginning"
            );
            return Err(Error::Identifier { element, why });
        }
    }
    Ok(())
}

/// Where an FMU has the library for a platform.
fn library_of(identifier: &str, platform: &str) -> String {
    format!("binaries/{platform}/{identifier}{}", std::env::consts::DLL_SUFFIX)
}

/// That the library for this machine, if there is one, can be loaded.
fn check_own_library(description: &Interface, directory: &Path) -> Result<()> {
    let (Some(own), Some(platform)) = (&description.co_simulation, host_platform()) else { return Ok(()) };
    let name = library_of(&own.identifier, platform);
    let path = directory.join(&name);
    if path.is_file() { check_library(&path, platform).place(|| name) } else { Ok(()) }
}

/// Messages of one kind that are kept; further ones are counted.
const MOST_MESSAGES: usize = 1000;

/// The first messages of a kind, and how many there were.
#[derive(Default)]
struct Heard {
    first: Vec<String>,
    more: u64,
}

impl Heard {
    fn push(&mut self, message: String) {
        if self.first.len() < MOST_MESSAGES { self.first.push(message) } else { self.more += 1 }
    }

    /// All of them since the last call.
    fn take(&mut self) -> Vec<String> {
        let Heard { mut first, more } = std::mem::take(self);
        if more > 0 {
            first.push(format!("and {more} more"));
        }
        first
    }
}

/// What the FMU logs. Errors become the run's error; warnings are kept for the end.
#[derive(Default)]
pub(crate) struct Messages {
    errors: Mutex<Heard>,
    warnings: Mutex<Heard>,
    /// Steps that returned fmi2Warning: where the first of them began \[s\], and their number.
    warned: Mutex<Option<(f64, u64)>>,
    names: Names,
}

impl Messages {
    fn hear(&self, status: Option<Status>, message: &str) {
        let list = match status {
            Some(Status::Ok) => return,
            Some(Status::Warning | Status::Discard) => &self.warnings,
            _ => &self.errors,
        };
        if let Ok(mut list) = list.lock() {
            list.push(message.to_owned());
        }
    }

    /// What was logged as an error in a call that succeeded is not the reason of a later refusal.
    fn forget_errors(&self) {
        if let Ok(mut errors) = self.errors.lock() {
            *errors = Heard::default();
        }
    }

    /// Notes a step from a time \[s\] that returned fmi2Warning.
    fn warned(&self, time: f64) {
        if let Ok(mut warned) = self.warned.lock() {
            let (first, steps) = warned.unwrap_or((time, 0));
            *warned = Some((first, steps + 1));
        }
    }

    /// The warnings since the last call.
    fn warnings(&self) -> Vec<String> {
        let said = self.warnings.lock().map(|mut list| list.take()).unwrap_or_default();
        let mut said: Vec<String> = said.iter().map(|message| self.names.said(message)).collect();
        if let Some((time, steps)) = self.warned.lock().ok().and_then(|mut warned| warned.take()) {
            let more = match steps - 1 {
                0 => String::new(),
                1 => ", and 1 later step".to_owned(),
                more => format!(", and {more} later steps"),
            };
            said.push(format!("warning: the step from t = {time:?} s returned the status fmi2Warning{more}"));
        }
        said
    }

    /// The errors since the last call.
    fn errors(&self) -> Vec<String> {
        let said = self.errors.lock().map(|mut list| list.take()).unwrap_or_default();
        said.iter().map(|message| self.names.said(message)).collect()
    }
}

/// The result of a call; its error is what the FMU has logged about it.
pub(crate) fn done(messages: &Messages, answer: Answer, call: &'static str) -> Result<()> {
    match answer.status() {
        Some(Status::Ok | Status::Warning) => {
            messages.forget_errors();
            Ok(())
        }
        _ => Err(Error::Refused { call, answer, said: messages.errors() }),
    }
}

fn number<T: FromStr<Err: Into<Cause>>>(text: &str) -> Result<T, Cause> {
    text.parse().map_err(Into::into)
}

/// An instance of an FMU.
pub struct Instance {
    pub(crate) calls: Rc<Calls>,
    pub(crate) messages: Arc<Messages>,
    references: HashMap<String, u32>,
}

impl Instance {
    /// The value reference of a variable.
    ///
    /// # Errors
    /// There is no such variable.
    pub fn reference(&self, name: &str) -> Result<u32> {
        self.references.get(name).copied().ok_or_else(|| Error::NoVariable(name.to_owned()))
    }

    fn done(&self, answer: Answer, call: &'static str) -> Result<()> {
        done(&self.messages, answer, call)
    }

    /// Sets a variable from its text.
    ///
    /// # Errors
    /// A text that is no value of the type, or the FMU's refusal.
    pub fn set(&self, kind: &Type, name: &str, text: &str) -> Result<()> {
        let reference = [self.reference(name)?];
        let wrong = |why, source| Error::Value { name: name.to_owned(), text: text.to_owned(), why, source };
        let answer = match kind {
            Type::Real(_) => self
                .calls
                .set_real(&reference, &[number(text).map_err(|error| wrong("not a number", Some(error)))?]),
            Type::Integer => self.calls.set_integer(
                &reference,
                &[number(text).map_err(|error| wrong("not a number", Some(error)))?],
            ),
            Type::String => self.calls.set_string(&reference, &[text])?,
            Type::Boolean => match text {
                "true" | "1" => self.calls.set_boolean(&reference, &[1]),
                "false" | "0" => self.calls.set_boolean(&reference, &[0]),
                _ => return Err(wrong("neither true nor false", None)),
            },
            other => return Err(Error::Type { name: name.to_owned(), of: other.name() }),
        };
        self.done(answer, "fmi2Set")
    }

    /// From `fmi2SetupExperiment` to `fmi2ExitInitializationMode`, at time 0.
    ///
    /// # Errors
    /// The FMU refuses the call.
    pub fn initialize(&self) -> Result<()> {
        self.enter_initialization(0.0)?;
        self.exit_initialization()
    }

    /// `fmi2SetupExperiment` at a time \[s\] and `fmi2EnterInitializationMode`
    ///
    /// # Errors
    /// The FMU refuses the call.
    pub fn enter_initialization(&self, start: f64) -> Result<()> {
        self.done(self.calls.setup_experiment(start), "fmi2SetupExperiment")?;
        self.done(self.calls.enter_initialization(), "fmi2EnterInitializationMode")
    }

    /// `fmi2ExitInitializationMode`
    ///
    /// # Errors
    /// The FMU refuses the call.
    pub fn exit_initialization(&self) -> Result<()> {
        self.done(self.calls.exit_initialization(), "fmi2ExitInitializationMode")
    }

    /// `fmi2SetReal`
    ///
    /// # Errors
    /// The FMU refuses the call.
    pub fn set_real(&self, references: &[u32], values: &[f64]) -> Result<()> {
        self.done(self.calls.set_real(references, values), "fmi2SetReal")
    }

    /// `fmi2GetReal`
    ///
    /// # Errors
    /// The FMU refuses the call.
    pub fn get_real(&self, references: &[u32], values: &mut [f64]) -> Result<()> {
        self.done(self.calls.get_real(references, values), "fmi2GetReal")
    }

    /// `fmi2GetInteger`
    ///
    /// # Errors
    /// The FMU refuses the call.
    pub fn get_integer(&self, references: &[u32], values: &mut [i32]) -> Result<()> {
        self.done(self.calls.get_integer(references, values), "fmi2GetInteger")
    }

    /// `fmi2SetInteger`
    ///
    /// # Errors
    /// The FMU refuses the call.
    pub fn set_integer(&self, references: &[u32], values: &[i32]) -> Result<()> {
        self.done(self.calls.set_integer(references, values), "fmi2SetInteger")
    }

    /// `fmi2GetBoolean`; anything but 0 is true.
    ///
    /// # Errors
    /// The FMU refuses the call.
    pub fn get_boolean(&self, references: &[u32], values: &mut [i32]) -> Result<()> {
        self.done(self.calls.get_boolean(references, values), "fmi2GetBoolean")
    }

    /// `fmi2SetBoolean`
    ///
    /// # Errors
    /// The FMU refuses the call.
    pub fn set_boolean(&self, references: &[u32], values: &[i32]) -> Result<()> {
        self.done(self.calls.set_boolean(references, values), "fmi2SetBoolean")
    }

    /// `fmi2GetString`
    ///
    /// # Errors
    /// The FMU refuses the call.
    pub fn get_string(&self, references: &[u32], values: &mut [String]) -> Result<()> {
        self.done(self.calls.get_string(references, values), "fmi2GetString")
    }

    /// `fmi2SetString`
    ///
    /// # Errors
    /// The FMU refuses the call.
    pub fn set_string(&self, references: &[u32], values: &[&str]) -> Result<()> {
        self.done(self.calls.set_string(references, values)?, "fmi2SetString")
    }

    /// `fmi2DoStep` from a time over a step, both \[s\].
    ///
    /// # Errors
    /// The FMU refuses the step or fails.
    pub fn step(&self, time: f64, step: f64) -> Result<()> {
        let answer = self.calls.do_step(time, step);
        if answer.status() == Some(Status::Warning) {
            self.messages.warned(time);
        }
        self.done(answer, "fmi2DoStep")
    }

    /// `fmi2Reset`
    ///
    /// # Errors
    /// The FMU refuses the call.
    pub fn reset(&self) -> Result<()> {
        self.done(self.calls.reset(), "fmi2Reset")
    }

    /// `fmi2Terminate`
    ///
    /// # Errors
    /// The FMU refuses the call.
    pub fn terminate(&self) -> Result<()> {
        self.done(self.calls.terminate(), "fmi2Terminate")
    }

    /// The warnings of the FMU since the last call: the first 1000, the number of further ones, and the time \[s\] of
    /// the first step that returned fmi2Warning.
    pub fn warnings(&self) -> Vec<String> {
        self.messages.warnings()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_without_end_are_counted() {
        let messages = Messages::default();
        let numbers = |list: &[String]| (list.len(), list[999].clone(), list.last().cloned());
        (0..1012).for_each(|k| messages.hear(Some(Status::Warning), &k.to_string()));
        (0..1001).for_each(|k| messages.hear(Some(Status::Error), &k.to_string()));
        assert_eq!(numbers(&messages.warnings()), (1001, "999".into(), Some("and 12 more".into())));
        assert_eq!(numbers(&messages.errors()), (1001, "999".into(), Some("and 1 more".into())));
        assert!(messages.warnings().is_empty() && messages.errors().is_empty());
        // A step that returns fmi2Warning in silence.
        [0.5, 0.6, 0.7].into_iter().for_each(|time| messages.warned(time));
        let said = "warning: the step from t = 0.5 s returned the status fmi2Warning, and 2 later steps";
        assert_eq!(messages.warnings(), [said]);
    }

    #[test]
    fn an_error_that_was_logged_in_a_good_call_is_not_the_reason_of_a_later_refusal() {
        let messages = Messages::default();
        messages.hear(Some(Status::Error), "harmless");
        messages.hear(Some(Status::Warning), "to be looked at");
        done(&messages, Answer(Status::Ok as i32), "fmi2SetReal").unwrap();
        messages.hear(Some(Status::Error), "the reason");
        let error = done(&messages, Answer(Status::Error as i32), "fmi2DoStep").unwrap_err();
        assert_eq!(error.to_string(), "the reason");
        assert_eq!(messages.warnings(), ["to be looked at"]);
    }

    #[test]
    fn an_fmu_for_other_platforms_says_which() {
        let said = |files: &[&str]| {
            let directory = tempfile::TempDir::new().unwrap();
            let path = directory.path().join("x.fmu");
            let mut zip = zip::ZipWriter::new(std::fs::File::create(&path).unwrap());
            let text = "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"x\" guid=\"x\">\
                        <CoSimulation modelIdentifier=\"x\"/><ModelVariables/></fmiModelDescription>";
            for name in files.iter().chain(&[DESCRIPTION_FILE]) {
                zip.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap();
                std::io::Write::write_all(&mut zip, text.as_bytes()).unwrap();
            }
            zip.finish().unwrap();
            Fmu::open(&path).unwrap().instantiate("x").map_or_else(|error| error.whole(), |_| "made".into())
        };
        let own = library_of("x", host_platform().unwrap());
        let two = said(&["binaries/win16/x.dll", "binaries/linux8/x.so", "binaries/darwin8/other.dylib"]);
        assert!(two.ends_with(&format!("x.fmu: the FMU has no {own}: it has linux8, win16 only")), "{two}");
        let none = said(&["sources/x.c"]);
        assert!(
            none.ends_with(&format!("the FMU has no {own}: it has no library for any platform")),
            "{none}"
        );
    }

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
            Fmu::open(&path).map_or_else(|error| error.whole(), |_| "taken".to_owned())
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
            assert!(said("a&#0;b", element).contains("x.fmu: modelDescription.xml:1: "));
        }
    }
}
