//! An FMU: its files, its description, what its names stand for.

use crate::bundled_library::host;
use crate::calls::FmuInstance;
use crate::error::{ErrorPlace, MasterError, Result, require, scratch};
use crate::file_type::FileType;
use crate::instance::number;
use crate::messages::Messages;
use crate::ssp::{Allowance, Causality, FmiType, Interface, LARGEST_TERMINALS, TERMINALS_FILE, Terminal};
use crate::unzip::{DESCRIPTION_FILE, renamed, unzip};
use crowd_mechanics::model_description::LARGEST_DESCRIPTION;
use crowd_mechanics::pack::host_directory;
use crowd_mechanics::quantities;
use crowd_mechanics::resources::{Resources, ResourcesError};
use lemons_core::files::source::{FileSource, LocalFiles};
use lemons_core::files::{Scratch, input};
use lemons_core::trial::{Agent, DriveChoice, DriveTable, Problems, Trial};
use lemons_fmi::Version;
use lemons_fmi::location::Location;
use lemons_sim::settings::{expanded, meant};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, OnceLock};

/// The parameter of a crowd that chooses among its packed Trials.
const TRIAL: &str = "Trial";

/// An FMU, unzipped.
pub struct Fmu {
    directory: Scratch,
    /// The content of `modelDescription.xml`; with the sizes of arrays that were chosen by [`Fmu::configure`].
    pub description: Arc<Interface>,
    /// The structural parameters that were chosen, by name.
    sizes: BTreeMap<String, u64>,
    /// Where it came from.
    shown: String,
    /// The packed Trial that was chosen, if that is known.
    chosen: Option<String>,
    /// The Trial that was chosen, once names of materials were asked for.
    materials: OnceLock<Option<Trial>>,
}

impl Fmu {
    /// Unzips an FMU and reads its description.
    ///
    /// # Errors
    /// There is no FMU.
    pub fn open(path: &Path) -> Result<Fmu> {
        FileType::expect(path, &FileType::ARCHIVES, "an FMU")?;
        let mut allowance = Allowance::new(Allowance::FMUS);
        let fmu = Self::unzip(path, &mut allowance).place(|| path.display().to_string())?;
        Ok(fmu.shown_as(&path.display().to_string()))
    }

    /// In messages, its files get this path.
    #[must_use]
    pub fn shown_as(self, path: &str) -> Fmu {
        Fmu { shown: path.to_owned(), ..self }
    }

    /// Name under which the user knows it.
    pub(crate) fn label(&self) -> &str {
        &self.shown
    }

    /// Where it is unpacked, and what the user knows it by.
    fn names(&self) -> [String; 2] {
        [self.directory.path().display().to_string(), self.shown.clone()]
    }

    /// Returns a text with the name that the user knows.
    fn known(&self, text: &str) -> String {
        let [unpacked, shown] = self.names();
        text.replace(&unpacked, &shown)
    }

    /// Like [`Fmu::open`], for a file whose name does not matter in messages.
    pub(crate) fn unzip(path: &Path, allowance: &mut Allowance) -> Result<Fmu> {
        let directory = scratch()?;
        unzip(path, directory.path(), allowance)?;
        let bytes = input::read(&directory.path().join(DESCRIPTION_FILE), LARGEST_DESCRIPTION)
            .place(|| DESCRIPTION_FILE.to_owned())?;
        let description = Arc::new(Interface::read(&bytes)?);
        Ok(Fmu {
            directory,
            description,
            sizes: BTreeMap::new(),
            shown: "FMU".into(),
            chosen: None,
            materials: OnceLock::new(),
        })
    }

    /// Reads its terminals: none without such a file.
    ///
    /// # Errors
    /// The file is broken.
    pub fn terminals(&self) -> Result<Vec<Terminal>> {
        let path = self.directory().join(TERMINALS_FILE);
        if LocalFiles.lacks(&path) {
            return Ok(Vec::new());
        }
        let bytes = input::read(&path, LARGEST_TERMINALS).place(|| TERMINALS_FILE.to_owned());
        let read = bytes.and_then(|bytes| Terminal::read(&bytes));
        read.place(|| self.shown.clone())
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
        let path = path.to_str().ok_or_else(|| format!("{} is not UTF-8", path.display()))?;
        Resources::at(Location::Path(path)).map_err(|error| match error {
            ResourcesError::NoTrial { .. } => MasterError::new("holds no Trial: it is not an FMU of a crowd"),
            error => MasterError::new(self.known(&error.to_string())),
        })
    }

    /// One of these Trials.
    ///
    /// # Errors
    /// All errors in its files.
    pub fn trial(&self, name: Option<&str>) -> Result<Trial> {
        let packed = self.resources()?;
        let read = packed.load(name.unwrap_or(packed.first()));
        Ok(read.map_err(|error| MasterError::new(self.known(&error.to_string())))?.0)
    }

    /// Reads the drive of a Trial of this FMU.
    ///
    /// # Errors
    /// The drive file has errors; files have the names that the user knows.
    pub fn drive(&self, trial: Option<&Trial>, choice: &DriveChoice) -> Result<DriveTable> {
        let known = |problems: Problems| renamed(&problems, self.directory(), Path::new(&self.shown));
        DriveTable::of(trial, choice).map_err(|problems| MasterError::Drive(known(problems)))
    }

    /// Returns whether a Trial of this FMU has a drive of its own for people whose Fp or Mp is fed by a connection, which
    /// replaces it. `feeds` says it of the names of variables.
    ///
    /// # Errors
    /// A Trial or its drive has errors.
    pub fn loses_drive(&self, feeds: impl Fn(&str) -> bool) -> Result<bool> {
        let Ok(packed) = self.resources() else { return Ok(false) };
        for name in packed.names() {
            let trial = self.trial(Some(name))?;
            let drive = self.drive(Some(&trial), &DriveChoice::Own)?;
            if agents_of_drive(&trial.agents, &drive)
                .any(|(_, inputs)| inputs.iter().any(|input| feeds(input)))
            {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// A new instance.
    ///
    /// # Errors
    /// The FMU cannot be instantiated; the error contains its messages.
    pub fn instantiate(&self, name: &str) -> Result<FmuInstance> {
        let own = self.description.co_simulation.as_ref();
        let own = own.ok_or("the FMU is not for co-simulation")?;
        let name_of_library = library_of(&own.identifier, self.description.fmi)?;
        let library = self.directory.path().join(&name_of_library);
        require(library.exists(), || {
            let others = match &self.platforms()[..] {
                [] => "no library for any platform".to_owned(),
                others => format!("{} only", others.join(", ")),
            };
            format!("{}: the FMU has no {name_of_library}: it has {others}", self.shown)
        })?;
        let messages = Arc::new(Messages::with(self.names()));
        let resources = self.directory.path().join("resources");
        let made = FmuInstance::new(self.description.clone(), &library, &resources, name, messages.clone());
        let instance = made.map_err(|error| {
            let prefix = format!("{}/", self.directory.path().display());
            let why = match &messages.errors()[..] {
                [] => format!("cannot instantiate the FMU: {}", error.whole().replace(&prefix, "")),
                messages => messages.join("\n"),
            };
            let lacks = ": has no directory resources, which it may need";
            let hint = if resources.is_dir() { "" } else { lacks };
            format!("{}{hint}: {why}", self.shown)
        })?;
        let size = |(name, size): (&String, &u64)| Some((self.description.variable(name)?.reference, *size));
        let (references, sizes): (Vec<u32>, Vec<u64>) = self.sizes.iter().filter_map(size).unzip();
        instance.configure(&references, &sizes).place(|| self.shown.clone())?;
        Ok(instance)
    }

    /// The names of the platforms for which it has a library of co-simulation: text from outside.
    pub fn platforms(&self) -> Vec<String> {
        let Some(own) = &self.description.co_simulation else { return Vec::new() };
        let files = |directory: &Path| directory.read_dir().into_iter().flatten().flatten();
        let is_library = |file: &Path| file.file_stem() == Some(own.identifier.as_ref());
        let mut platforms: Vec<_> = files(&self.directory.path().join("binaries")).collect();
        platforms.retain(|platform| files(&platform.path()).any(|file| is_library(&file.path())));
        let names = platforms.iter().map(|platform| platform.file_name().to_string_lossy().into_owned());
        let mut names: Vec<String> = names.collect();
        names.sort();
        names
    }

    /// The values that a name stands for: see [`expanded`]. In FMI 3.0, a quantity of materials also has its name of FMI
    /// 2.0, which contains their Ids.
    pub fn values_of(&self, name: &str) -> Vec<String> {
        let is_known = |name: &str| self.description.single(name).is_some();
        let found = if is_known(name) { Vec::new() } else { self.of_materials(name) };
        if found.is_empty() { expanded(name, is_known) } else { found }
    }

    /// The value that an unknown name most likely means.
    pub(crate) fn meant(&self, name: &str) -> Option<String> {
        meant(name, self.description.singles().map(|(name, _)| name))
    }

    /// The elements of arrays of materials that have a name in FMI 2.0.
    fn of_materials(&self, name: &str) -> Vec<String> {
        if !name.starts_with("material.") && !name.starts_with("contact.") {
            return Vec::new();
        }
        let trial = self.materials.get_or_init(|| self.trial(self.chosen.as_deref()).ok());
        let elements = trial.iter().flat_map(|trial| quantities::of_materials(trial, name));
        let elements = elements.filter_map(|(array, element)| {
            let variable = self.description.variable(array).filter(|array| element < array.count())?;
            Some(self.description.name_of(variable, element))
        });
        elements.collect()
    }

    /// The type of a value.
    pub fn kind(&self, name: &str) -> Option<FmiType> {
        self.description.single(name).map(|single| single.variable.of)
    }

    /// Chooses the sizes of arrays (FMI 3.0) of the next instances, from parameters of which some are structural. If the
    /// parameter `Trial` names a Trial that is packed in it, its sizes are those.
    ///
    /// # Errors
    /// A text is not a size, or the arrays become too large.
    pub fn configure<'a>(&mut self, parameters: impl Iterator<Item = (&'a str, &'a str)>) -> Result<()> {
        if self.description.fmi != Version::V3 {
            return Ok(());
        }
        for (name, text) in parameters {
            if name == TRIAL
                && let Ok(packed) = self.resources()
                && packed.names().iter().any(|known| known == text)
            {
                let trial = self.trial(Some(text))?;
                self.chosen = Some(text.to_owned());
                self.materials = OnceLock::new();
                // No size is 0 in FMI 3.0: arrays of what the Trial does not have keep theirs, and are 0.
                let sizes = quantities::SIZES.iter().zip(quantities::sizes(&trial));
                for (size, value) in sizes.filter(|(_, value)| *value > 0) {
                    self.resize(size.name, value)?;
                }
            } else if self.is_structural(name) {
                self.resize(name, number(text).place(|| format!("{name}={text}: not a size"))?)?;
            }
        }
        Ok(())
    }

    /// Chooses a size, if the FMU has this structural parameter.
    fn resize(&mut self, name: &str, size: u64) -> Result<()> {
        if self.is_structural(name) {
            Arc::make_mut(&mut self.description).resize(name, size).place(|| format!("{name}={size}"))?;
            self.sizes.insert(name.to_owned(), size);
        }
        Ok(())
    }

    /// Which of the flags `canGetAndSetFMUstate`, `canSerializeFMUstate` (FMI 3.0: `…State`) the FMU lacks to save its
    /// state.
    pub fn cannot_save(&self) -> Option<&'static str> {
        let v3 = self.description.fmi == Version::V3;
        let lacks = |lacks: bool, flags: [&'static str; 2]| lacks.then_some(flags[usize::from(v3)]);
        let Some(able) = &self.description.co_simulation else { return Some("co-simulation") };
        lacks(!able.can_get_and_set_state, ["canGetAndSetFMUstate", "canGetAndSetFMUState"])
            .or(lacks(!able.can_serialize_state, ["canSerializeFMUstate", "canSerializeFMUState"]))
    }

    /// Returns the choices of [`Fmu::configure`], by name: a saved run must choose it again.
    pub(crate) fn choices(&self) -> BTreeMap<String, String> {
        let sizes = self.sizes.iter().map(|(name, size)| (name.clone(), size.to_string()));
        sizes.chain(self.chosen.iter().map(|trial| (TRIAL.to_owned(), trial.clone()))).collect()
    }

    /// Returns whether a variable is a structural parameter, which is set by [`Fmu::configure`].
    pub fn is_structural(&self, name: &str) -> bool {
        let found = self.description.variable(name);
        found.is_some_and(|variable| variable.kind == Some(Causality::StructuralParameter))
    }
}

/// Returns the agents that a drive names, with the names of their inputs.
pub(crate) fn agents_of_drive<'a>(
    agents: &'a [Agent],
    drive: &'a DriveTable,
) -> impl Iterator<Item = (&'a Agent, [String; 3])> {
    let driven = agents.iter().enumerate().filter(|(_, agent)| drive.rows(&agent.id).is_some());
    driven.map(|(i, agent)| (agent, ["Fp.x", "Fp.y", "Mp"].map(|name| format!("agent[{i}].{name}"))))
}

/// Where an FMU has the library for this platform.
fn library_of(identifier: &str, version: Version) -> Result<String> {
    let host = host()?;
    let platform = if version == Version::V3 { host_directory().unwrap_or(host) } else { host };
    Ok(format!("binaries/{platform}/{identifier}{}", std::env::consts::DLL_SUFFIX))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn description(element: &str, identifier: &str) -> String {
        format!(
            "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"x\" guid=\"x\">\
             <{element} modelIdentifier=\"{identifier}\"/><ModelVariables/></fmiModelDescription>"
        )
    }

    #[test]
    fn an_fmu_for_other_platforms_says_which() {
        let directory = tempfile::TempDir::new().unwrap();
        let path = directory.path().join("x.fmu");
        let own = library_of("x", Version::V2).unwrap();
        let others = ["binaries/win16/x.dll", "binaries/linux8/x.so", "binaries/darwin8/other.dylib"];
        for (files, has) in
            [(&others[..], "linux8, win16 only"), (&["sources/x.c"], "no library for any platform")]
        {
            let mut zip = zip::ZipWriter::new(std::fs::File::create(&path).unwrap());
            for name in files.iter().chain(&[DESCRIPTION_FILE]) {
                zip.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap();
            }
            std::io::Write::write_all(&mut zip, description("CoSimulation", "x").as_bytes()).unwrap();
            zip.finish().unwrap();
            let made = Fmu::open(&path).unwrap().instantiate("x");
            let message = made.map_or_else(|error| error.whole(), |_| "made".into());
            assert!(message.ends_with(&format!("x.fmu: the FMU has no {own}: it has {has}")), "{message}");
        }
    }

    /// Each was handed to the loader: `../` led out of the FMU.
    #[test]
    fn a_model_identifier_is_a_name_in_c() {
        let long = "a".repeat(201);
        for element in ["CoSimulation", "ModelExchange"] {
            let message = |identifier: &str| {
                let read = Interface::read(description(element, identifier).as_bytes());
                read.map_or_else(|error| error.whole(), |_| "read".into())
            };
            for good in ["a", "_", "A_b9", &long[..200]] {
                assert_eq!(message(good), "read");
            }
            for bad in [
                "",
                "9a",
                "../a",
                "/tmp/a",
                "a\\b",
                ".",
                "C:a",
                "a b",
                "a-b",
                "\u{e4}",
                "a\u{202e}b",
                "a&#10;b",
            ] {
                let place = format!("modelDescription.xml:1: <{element}> modelIdentifier=\"");
                assert!(
                    message(bad).starts_with(&place) && message(bad).contains("must be a name in C"),
                    "{bad}"
                );
            }
            assert!(message(&long).ends_with(">: modelIdentifier has 201 bytes: must have at most 200"));
            // XML knows no NUL.
            assert!(message("a&#0;b").starts_with("modelDescription.xml:1: "));
        }
    }
}
