//! A Trial as users give it: its directory, or a zip of that, with the file by which its people move; and the FMU that it
//! becomes.

use crate::error::{ErrorPlace, MasterError, Result, require, scratch};
use crate::file_type::FileType;
use crate::fmu::Fmu;
use crate::unzip::{renamed, unzip_trial};
use crowd_mechanics::pack::{Binary, DrawTrial, FmuFormat, PackError, Package};
use crowd_mechanics::setup;
use lemons_core::files::source::LocalFiles;
use lemons_core::files::{Scratch, input};
use lemons_core::trial::{DriveChoice, DriveTable, Problem, Problems, Trial};
use lemons_decision::{DECISION_FILE, DecisionConfig, Plan};
use lemons_sim::Documents;
use std::io::{Seek, Write};
use std::path::{Component, Path, PathBuf};

/// A Trial as input: its directory, or a zip of that. A zip is unpacked into a directory that exists as long as this does.
pub struct TrialInput {
    /// As it was given.
    path: PathBuf,
    directory: PathBuf,
    unpacked: Option<Scratch>,
}

impl TrialInput {
    /// Finds a Trial; `None` where there is neither a directory nor the zip of a Trial: perhaps an FMU.
    ///
    /// # Errors
    /// The zip of a Trial cannot be unpacked.
    pub fn find(path: &Path) -> Result<Option<TrialInput>> {
        let given = path.to_owned();
        if path.is_dir() {
            return Ok(Some(TrialInput { directory: given.clone(), path: given, unpacked: None }));
        }
        if !path.is_file() {
            return Ok(None);
        }
        let unpacked = scratch()?;
        let found = unzip_trial(path, unpacked.path()).place(|| path.display().to_string())?;
        Ok(found.map(|directory| TrialInput { path: given, directory, unpacked: Some(unpacked) }))
    }

    /// Opens what must be a Trial.
    ///
    /// # Errors
    /// There is something else, or the zip of a Trial cannot be unpacked.
    pub fn open(path: &Path) -> Result<TrialInput> {
        FileType::expect(path, &[FileType::TRIAL, FileType::ARCHIVE], "a Trial directory or a zip of one")?;
        match TrialInput::find(path)? {
            Some(given) => Ok(given),
            // Why it cannot be read says the reader.
            None => Ok(TrialInput { path: path.to_owned(), directory: path.to_owned(), unpacked: None }),
        }
    }

    /// Returns its path as it was given.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the directory of its files.
    pub fn directory(&self) -> &Path {
        &self.directory
    }

    /// Returns its file that says where its people walk, if there is one: a link that leads nowhere, too, which is an error for
    /// whoever reads it, and must not mean that nobody walks.
    pub fn decision_file(&self) -> Option<PathBuf> {
        Some(self.directory.join(DECISION_FILE)).filter(|path| path.symlink_metadata().is_ok())
    }

    /// Reads the Trial with its warnings.
    ///
    /// # Errors
    /// All that is wrong with it, and the warnings; files have the names that the user knows.
    pub fn read(&self) -> Result<(Trial, Problems), Problems> {
        let (trial, warnings) = setup::read(&self.directory).map_err(|problems| self.renamed(&problems))?;
        let parameters = &trial.parameters;
        let leaves = |path: &&Path| {
            path.components().any(|part| !matches!(part, Component::Normal(_) | Component::CurDir))
        };
        let outside = [parameters.static_path(), parameters.dynamic_path()].into_iter().find(leaves);
        if let Some(outside) = outside.filter(|_| self.unpacked.is_some()) {
            let why = format!("{outside:?} leads outside of the zip");
            let mut problems = Problems::default();
            problems.push(Problem {
                element: Some("Directories".into()),
                ..Problem::of_file(&self.path.join("Parameters.xml"), None, why)
            });
            return Err(problems);
        }
        Ok((trial, self.renamed(&warnings)))
    }

    /// Reads the drive of the Trial that was read.
    ///
    /// # Errors
    /// All that is wrong with its `drive.csv`; the file has the name that the user knows.
    pub fn drive(&self, trial: &Trial) -> Result<DriveTable, Problems> {
        DriveTable::of(Some(trial), &DriveChoice::Own).map_err(|problems| self.renamed(&problems))
    }

    /// Reads what the Trial is simulated with, what is probably not meant in the Trial's files, and the file that says where
    /// people walk, as the user knows it.
    ///
    /// # Errors
    /// The Trial, its drive or its `decision.toml` has errors: [`MasterError::Broken`] where these are files of the Trial.
    pub fn documents(
        &self,
        drive: &DriveChoice,
        decision: &DecisionChoice,
    ) -> Result<(Documents, Problems, Option<PathBuf>)> {
        let broken = |problems| MasterError::Broken { path: self.path.clone(), problems };
        let (trial, problems) = self.read().map_err(broken)?;
        let drive = match drive {
            DriveChoice::Own => self.drive(&trial).map_err(broken)?,
            other => DriveTable::of(Some(&trial), other).map_err(MasterError::Drive)?,
        };
        let decision = match decision {
            DecisionChoice::None => None,
            DecisionChoice::File(path) => Some((path.clone(), path.clone())),
            DecisionChoice::Own => self.decision_file().map(|path| (path, self.path.join(DECISION_FILE))),
        };
        let read = decision.as_ref();
        let read = read.map(|(path, known)| plan_of(&trial, path).place(|| known.display().to_string()));
        let plan = read.transpose()?;
        Ok((Documents::new(trial, drive, plan), problems, decision.map(|(_, known)| known)))
    }

    /// Returns a text in which the user's name for it replaces that of the place where it was unpacked.
    pub fn under_its_name(&self, text: &str) -> String {
        match self.unpacked {
            Some(_) => text.replace(&*self.directory.to_string_lossy(), &self.path.to_string_lossy()),
            None => text.to_owned(),
        }
    }

    /// Returns problems with the names of files within a zip instead of those where it was unpacked.
    fn renamed(&self, problems: &Problems) -> Problems {
        renamed(problems, &self.directory, &self.path)
    }
}

/// Reads what a Trial, or the Trial that an FMU contains, is simulated with: as [`TrialInput::documents`]. The mechanics are those of
/// this program, whichever has packed the FMU.
///
/// # Errors
/// As there, or the FMU contains no Trial, or people are to walk in it.
pub fn documents_of(
    path: &Path,
    drive: &DriveChoice,
    decision: &DecisionChoice,
) -> Result<(Documents, Problems, Option<PathBuf>)> {
    if let Some(given) = TrialInput::find(path)? {
        return given.documents(drive, decision);
    }
    let other = || format!("a file like {DECISION_FILE} is for a Trial, and not for an FMU");
    require(!matches!(decision, DecisionChoice::File(_)), other)?;
    let fmu = Fmu::open(path)?;
    let trial = fmu.trial(None)?;
    let drive = fmu.drive(Some(&trial), drive)?;
    Ok((Documents { trial, drive, plan: None }, Problems::default(), None))
}

/// Packs Trials into an FMU in a file that messages call `name`, and returns their warnings; `picture` draws its `model.png`. A
/// drive is read when it is used, and checked before.
///
/// # Errors
/// [`MasterError::Broken`] if a Trial has errors, with the names of files that the user knows; else [`PackError`].
pub fn pack(
    trials: &[TrialInput],
    binaries: Vec<Binary>,
    format: FmuFormat,
    picture: Option<DrawTrial>,
    name: &Path,
    file: impl Write + Seek,
) -> Result<Vec<String>> {
    let directories = trials.iter().map(|trial| trial.directory.clone()).collect();
    let check = |trial: &Trial| {
        DriveTable::of(Some(trial), &DriveChoice::Own)
            .map_or_else(|problems| problems, |_| Problems::default())
    };
    let package = Package { trials: directories, binaries, picture, check: Some(check), format };
    let packed = package.write_to(&LocalFiles, name, file).map_err(|error| match error {
        PackError::Broken { path, problems } => match trials.iter().find(|trial| trial.directory == path) {
            Some(trial) => {
                MasterError::Broken { path: trial.path.clone(), problems: trial.renamed(&problems) }
            }
            None => MasterError::Broken { path, problems },
        },
        error => error.into(),
    });
    let known = |text: String| trials.iter().fold(text, |text, trial| trial.under_its_name(&text));
    Ok(packed?.into_iter().map(known).collect())
}

/// Which file says where the people of a Trial walk.
#[derive(Debug, Clone, Default, PartialEq, Eq, Hash)]
pub enum DecisionChoice {
    /// The Trial's `decision.toml`, if it has one.
    #[default]
    Own,
    /// None: nobody walks.
    None,
    /// This one, in the format of `decision.toml`.
    File(PathBuf),
}

/// Reads what the people of a Trial do by a `decision.toml`. The messages do not name the file.
///
/// # Errors
/// It cannot be read, it is not such a file, or it names people who are not in the Trial.
pub fn plan_of(trial: &Trial, path: &Path) -> Result<Plan> {
    // What lies in the Trial is not a pipe on purpose.
    let text = input::read_text(path, input::LARGEST_SETTINGS).place(|| "cannot be read".to_owned())?;
    let config = DecisionConfig::from_toml(&text)?;
    Ok(Plan::of(trial, &config)?)
}

/// The plan in a Decision FMU of ours; `None` of other FMUs.
pub fn plan_in(fmu: &Fmu) -> Option<Plan> {
    Plan::read(&fmu.directory().join("resources")).ok()
}
