//! What is simulated: the FMU of a Trial, alone or with the one that decides where its people walk; or an FMU.

use crate::assemble::couple;
use crate::decider::{PlanChoice, decider};
use crate::error::{Error, Result};
use crate::fmu::Fmu;
use crate::given::{Given, pack};
use crate::own::own_binary;
use crate::refusal::{PrepareError, Warning};
use crate::system::{Algorithm, PLAY_DRIVE, System};
use crowd_mechanics::pack::{Binary, Format};
use lemons_files::Scratch;
use lemons_ssp::Single;
use lemons_trial::{DRIVE_FILE, DriveChoice, DriveTable, Trial};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Name of the component that is a Trial's crowd.
const CROWD: &str = "crowd";
/// Name of the component that decides where its people walk.
const DECISION: &str = "decision";

/// Loaded FMUs, from which any number of systems can be made, in any thread. The files of a Trial's FMUs exist as long as
/// this does: a Trial is packed first, and runs as everybody's FMU of it would.
pub struct Model {
    /// First who decides: the Gauss-Seidel algorithm steps them in this order. Last the crowd.
    parts: Vec<Part>,
    /// The file that says where people walk, as the user knows it.
    plan: Option<PathBuf>,
    /// Whether the Trial has a drive file.
    has_drive: bool,
    packed: Option<Scratch>,
}

/// One of them.
pub struct Part {
    /// Of the component.
    pub name: &'static str,
    /// Unzipped.
    pub fmu: Arc<Fmu>,
    /// The FMU's file.
    pub file: PathBuf,
}

impl Model {
    /// Packs a Trial with this library of the crowd, by default [`own_binary`], and its plan, if its people walk; anything
    /// else may be an FMU.
    ///
    /// # Errors
    /// The Trial or its plan has errors, there is no FMU, or a plan is given for an FMU.
    pub fn of(input: &Path, plan: &PlanChoice, binary: Option<&Binary>) -> Result<Model, PrepareError> {
        let Some(given) = Given::find(input)? else {
            if matches!(plan, PlanChoice::File(_)) {
                return Err(PrepareError::PlanWithoutTrial);
            }
            let part = Part { name: CROWD, fmu: Arc::new(Fmu::open(input)?), file: input.to_owned() };
            return Ok(Model { parts: vec![part], plan: None, has_drive: false, packed: None });
        };
        let scratch = Scratch::new().map_err(Error::io("cannot make a temporary directory"))?;
        let mut parts = Vec::new();
        let file = scratch.path().join("decision.fmu");
        let decided = decider(&given, plan, &file)?;
        let plan = decided.map(|(fmu, plan)| {
            parts.push(Part { name: DECISION, fmu: Arc::new(fmu), file });
            plan
        });
        let has_drive = given.directory().join(DRIVE_FILE).exists();
        let file = scratch.path().join("crowd.fmu");
        let binary = binary.cloned().map_or_else(own_binary, Ok)?;
        pack(&[given], vec![binary], Format::default(), None, false, &file)?;
        parts.push(Part { name: CROWD, fmu: Arc::new(Fmu::open(&file)?.of_trial(input)), file });
        Ok(Model { parts, plan, has_drive, packed: Some(scratch) })
    }

    /// In the order of the systems that are made of them; the crowd is the last.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// The FMU of the crowd, or the only one.
    pub fn crowd(&self) -> &Fmu {
        &self.parts[self.parts.len() - 1].fmu
    }

    /// The file that says where people walk, as the user knows it; `None` if no FMUs are coupled.
    pub fn plan(&self) -> Option<&Path> {
        self.plan.as_deref()
    }

    /// As [`Fmu::configure`], of the crowd; before the first system is made.
    ///
    /// # Errors
    /// As there.
    pub fn configure<'a>(&mut self, parameters: impl Iterator<Item = (&'a str, &'a str)>) -> Result<()> {
        let own = |name: &'a str| name.strip_prefix("crowd.").unwrap_or(name);
        let main = self.parts.len() - 1;
        match Arc::get_mut(&mut self.parts[main].fmu) {
            Some(fmu) => fmu.configure(parameters.map(|(name, value)| (own(name), value))),
            None => Ok(()),
        }
    }

    /// A system that is not initialized yet.
    ///
    /// # Errors
    /// An FMU cannot be instantiated or connected.
    pub fn system(&self, algorithm: Algorithm) -> Result<System> {
        match &self.parts[..] {
            [one] => System::of_one(one.name, one.fmu.clone(), algorithm),
            all => couple(all.iter().map(|part| (part.name, part.fmu.clone())).collect(), algorithm),
        }
    }

    /// The place of the component, and the variable, that a name means: without a component, that of the crowd.
    pub fn find<'a>(&self, name: &'a str) -> (usize, &'a str) {
        let main = self.parts.len() - 1;
        // Another program's FMU may have such a variable itself.
        if main == 0 && self.has(0, name) {
            return (0, name);
        }
        let inside = |part: &Part| name.strip_prefix(part.name)?.strip_prefix('.');
        let found = self.parts.iter().enumerate().find_map(|(place, part)| Some((place, inside(part)?)));
        found.unwrap_or((main, name))
    }

    /// The components, the one that is meant first, and the variable that a value with this name sets. Without a
    /// component, a parameter of people is set of all components that have it: mass and damping are those of the same
    /// people.
    pub fn set_by<'a>(&self, name: &'a str) -> (Vec<usize>, &'a str) {
        let (main, variable) = self.find(name);
        let shared = |place: &usize| {
            let (of, fmu) = (variable.starts_with("agent["), &self.parts[*place].fmu);
            let parameter = |name: &String| fmu.description.single(name).is_some_and(Single::is_parameter);
            of && variable == name && *place != main && fmu.named(variable).iter().all(parameter)
        };
        let others = (0..self.parts.len()).filter(shared);
        (std::iter::once(main).chain(others).collect(), variable)
    }

    /// What a name may mean that no component has: the same with the component that has it, or one that is spelt alike.
    pub fn meant(&self, name: &str) -> Option<String> {
        let (place, variable) = self.find(name);
        if self.has(place, variable) {
            return None;
        }
        match (0..self.parts.len()).find(|other| self.has(*other, variable)) {
            Some(other) => Some(format!("{}.{variable}", self.parts[other].name)),
            None => Some(name.strip_suffix(variable)?.to_owned() + &self.parts[place].fmu.meant(variable)?),
        }
    }

    fn has(&self, place: usize, variable: &str) -> bool {
        let fmu = &self.parts[place].fmu;
        fmu.named(variable).iter().all(|name| fmu.kind(name).is_some())
    }

    /// \[s\] The communication step that the Trial, or the smallest that an FMU asks for.
    ///
    /// # Errors
    /// A Trial in an FMU cannot be read.
    pub fn step(&self) -> Result<Option<f64>> {
        let mut smallest: Option<f64> = None;
        for Part { fmu, .. } in &self.parts {
            let packed = fmu.resources().is_ok() && fmu.kind("Trial").is_some();
            let step =
                if packed { Some(fmu.trial(None)?.parameters.time_step) } else { fmu.description.step };
            let step = step.filter(|step| *step > 0.0 && step.is_finite());
            smallest = smallest.into_iter().chain(step).reduce(f64::min);
        }
        Ok(smallest)
    }

    /// What drives a Trial of the crowd; if people walk, this is added.
    ///
    /// # Errors
    /// As [`Fmu::drive`].
    pub fn drive(&self, trial: Option<&Trial>, choice: &DriveChoice) -> Result<DriveTable> {
        self.crowd().drive(trial, choice)
    }

    /// Whether, with this choice, the crowd plays its packed drive itself; FMUs of earlier versions cannot.
    pub fn plays(&self, choice: &DriveChoice) -> bool {
        *choice == DriveChoice::Own && self.plan.is_none() && self.has(self.parts.len() - 1, PLAY_DRIVE)
    }

    /// What is probably not meant, with this choice of a drive.
    pub fn warning(&self, choice: &DriveChoice) -> Option<Warning> {
        let plan = self.plan.clone().filter(|_| self.has_drive && *choice == DriveChoice::Own)?;
        Some(Warning::DriveOfWalkers { plan })
    }

    /// Removes the files, which nobody removes later when the program ends while systems are in use.
    pub fn remove_files(&self) {
        let unzipped = self.parts.iter().map(|part| part.fmu.directory());
        for directory in unzipped.chain(self.packed.as_ref().map(Scratch::path)) {
            let _ = std::fs::remove_dir_all(directory);
        }
    }
}
