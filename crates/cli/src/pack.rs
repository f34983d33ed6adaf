//! `lemons pack`: Trials -> FMU.

use crate::binary::{CROWD, Library, SUMMARY};
use crate::error::Misused;
use crate::files::{self, ForceOption};
use crate::measure::options::{Labelled, measuring_area, name_all};
use crate::values::{duration, positive};
use crate::version::BUILD;
use anyhow::{Context, Result, bail};
use clap::builder::PossibleValuesParser;
use crowd_mechanics::pack::{Binary, FmuFormat, Naming, platforms};
use lemons_core::files::Staged;
use lemons_core::trial::{DriveChoice, Trial};
use lemons_decision::DECISION_FILE;
use lemons_master::{DecisionChoice, Experiment, TrialInput, add_reference, binaries_beside};
use lemons_picture::{Fill, PictureScene, Style, png, svg};
use lemons_results::measure::MeasuringArea;
use lemons_sim::Documents;
use lemons_sim::lint::{self, Files};
use lemons_summary::{AreaConfig, SummaryConfig};
use std::io;
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub struct Arguments {
    /// Trials to pack: directories, or zips of them. The first is the default of the parameter Trial. In FMI
    /// 2.0 all Trials share the FMU's variables (agent[0].Mass, …): they need the same number of agents with
    /// the same Ids, and the same materials
    // The help shows it as it is.
    #[allow(rustdoc::broken_intra_doc_links)]
    #[arg(required = true, value_name = "TRIAL")]
    trials: Vec<PathBuf>,
    /// The FMU to write
    #[arg(short, long, value_name = "FILE.fmu")]
    output: PathBuf,
    #[command(flatten)]
    fmi: Fmi,
    #[command(flatten)]
    interface: Interface,
    #[command(flatten)]
    fmu: FmuArguments,
    #[command(flatten)]
    reference: Reference,
    #[command(flatten)]
    _force: ForceOption,
}

/// What an FMU offers.
#[derive(clap::Args)]
pub struct Interface {
    /// What the FMU offers: agents (places, drives and forces of each person, of the crowd alone) or summary (at most
    /// fifty plain scalars of exits, doors, areas and barriers, with the people of decision.toml inside; docs/summary.md)
    #[arg(long = "interface", value_name = "WHAT", default_value = "agents", value_parser = ["agents", "summary"])]
    what: String,
    /// With summary: measure density and squeeze in this area, as in lemons measure. Can be given several times
    #[arg(long = "area", value_name = "[NAME=]X0,Y0,X1,Y1,…", value_parser = measuring_area, allow_hyphen_values = true)]
    areas: Vec<Labelled<MeasuringArea>>,
    /// With summary: count people whose squeeze is above this, in newtons. Default: 623
    #[arg(long, value_name = "N", value_parser = positive)]
    above: Option<f64>,
    /// With summary: the exit that becomes exit1, then that of exit2, and so on. Default: all
    #[arg(long = "exit", value_name = "NAME")]
    exits: Vec<String>,
    /// With summary: the same of walls that open and close, by their Ids. Default: all
    #[arg(long = "door", value_name = "ID")]
    doors: Vec<String>,
    /// With summary: the same of panels of walls, numbered as in barrier[0].Load. Default: all
    #[arg(long = "panel", value_name = "NUMBER")]
    panels: Vec<usize>,
}

impl Interface {
    /// Returns what of a Trial is in the slots of a summary; `None` if the FMU has all of each person.
    pub fn summary(&self) -> Result<Option<SummaryConfig>> {
        let Interface { what, areas, above, exits, doors, panels } = self;
        let mut areas = areas.clone();
        name_all("--area", &mut areas)?;
        let area =
            |Labelled { name, what }: Labelled<MeasuringArea>| AreaConfig { name, corners: what.numbers() };
        let config = SummaryConfig {
            limit: *above,
            exits: exits.clone(),
            doors: doors.clone(),
            panels: panels.clone(),
            areas: areas.into_iter().map(area).collect(),
        };
        match &**what {
            "summary" => Ok(Some(config)),
            _ if config == SummaryConfig::default() => Ok(None),
            _ => {
                bail!(Misused("--area, --above, --exit, --door, --panel are for --interface summary".into()))
            }
        }
    }
}

/// Which version of FMI.
#[derive(clap::Args)]
pub struct Fmi {
    /// Version of FMI: 2 (a variable for each number; all tools) or 3 (arrays; small for large crowds)
    #[arg(long = "fmi", value_name = "VERSION", default_value = "2", value_parser = ["2", "3"])]
    version: String,
}

impl Fmi {
    pub fn format(&self, naming: Naming) -> FmuFormat {
        if self.version == "3" { FmuFormat::Fmi3 } else { FmuFormat::Fmi2(naming) }
    }
}

/// Options of every FMU that is made here.
#[derive(clap::Args)]
pub struct FmuArguments {
    /// Add the shared library of a platform: linux64=FILE, win64=FILE, …; a WebAssembly component (FMI 3.0):
    /// wasm32-wasip2=FILE. Default: those of all platforms that were installed with this program
    #[arg(long = "binary", value_name = "PLATFORM=FILE", value_parser = parse_binary)]
    binaries: Vec<Binary>,
    /// Of the libraries that were installed with this program, only that of this platform: linux64, win64,
    /// aarch64-linux, darwin64. Can be given several times
    #[arg(long = "platform", value_name = "PLATFORM", conflicts_with = "binaries", hide_possible_values = true, value_parser = PossibleValuesParser::new(platforms()))]
    platforms: Vec<String>,
    /// Declare the variable names as flat instead of structured (FMI 2.0); some tools are slow to check
    /// structured names
    #[arg(long)]
    flat_names: bool,
}

impl FmuArguments {
    pub fn naming(&self) -> Naming {
        if self.flat_names { Naming::Flat } else { Naming::Structured }
    }

    /// Those that were given, checked, else the libraries built with this program.
    pub fn binaries(&self, library: &Library) -> Result<Vec<Binary>> {
        if self.binaries.is_empty() {
            let binaries = binaries_beside(library.name, &self.platforms)?;
            binaries.iter().for_each(|binary| files::reads(&binary.path, library.name));
            return Ok(binaries);
        }
        self.binaries.iter().try_for_each(|binary| library.check(binary))?;
        Ok(self.binaries.clone())
    }
}

/// Reference results in the FMU.
#[derive(clap::Args)]
pub struct Reference {
    /// Run the FMU, and put inputs and outputs of this run into it (FMI-LS-REF): lemons replay and other tools
    /// compare theirs with them. The inputs are those of lemons run TRIAL; of several Trials the first counts. The FMU
    /// needs a library for this machine
    #[arg(long)]
    reference: bool,
    /// End of the run for --reference, in seconds. Default: that of the FMU's DefaultExperiment
    #[arg(long, value_name = "SECONDS", value_parser = duration, requires = "reference")]
    until: Option<f64>,
    /// Communication step of the run for --reference, in seconds. Default: the Trial's TimeStep
    #[arg(long, value_name = "SECONDS", value_parser = duration, requires = "reference")]
    step: Option<f64>,
    /// Tolerance of the run for --reference, which the FMU gets from whoever runs it again: for a crowd, an accuracy in
    /// metres (docs/step.md)
    #[arg(long, value_name = "NUMBER", value_parser = positive, requires = "reference")]
    tolerance: Option<f64>,
}

impl Reference {
    /// Adds it to an FMU that was written into a file, if it is wanted. `documents` are those from which the FMU is.
    pub fn add(
        &self,
        file: &mut Staged,
        shown: &Path,
        documents: impl FnOnce() -> Result<Documents>,
    ) -> Result<()> {
        if !self.reference {
            return Ok(());
        }
        let Reference { until, step, tolerance, .. } = *self;
        let (experiment, documents) = (Experiment { until, step, tolerance }, documents()?);
        let add = |path: &Path| add_reference(path, shown, documents, &experiment).map_err(io::Error::other);
        file.fill(add).context("--reference")
    }
}

fn parse_binary(text: &str) -> Result<Binary, String> {
    let (platform, path) = text.split_once('=').ok_or("expected PLATFORM=FILE")?;
    Ok(Binary { platform: platform.to_owned(), path: path.into() })
}

pub fn pack(arguments: &Arguments) -> Result<()> {
    if let Some(config) = arguments.interface.summary()? {
        return pack_summary(arguments, &config);
    }
    let binaries = arguments.fmu.binaries(&CROWD)?;
    files::claim_and_try(&arguments.output)?;
    let trials = arguments.trials.iter().map(|path| TrialInput::open(path)).collect::<Result<Vec<_>, _>>()?;
    let format = arguments.fmi.format(arguments.fmu.naming());
    let warnings = write_fmu(&trials, binaries, format, &arguments.output, Some(&arguments.reference))?;
    warnings.iter().for_each(|warning| note!("{warning}"));
    for trial in trials.iter().filter(|trial| trial.decision_file().is_some()) {
        let path = trial.path().display();
        note!(
            "note: {path}/{DECISION_FILE} is not in this FMU, which is the crowd alone: lemons decide {path} -o FILE.fmu makes \
             the FMU that says where people walk, and lemons connect couples both"
        );
    }
    say_size(&arguments.output)
}

fn pack_summary(arguments: &Arguments, config: &SummaryConfig) -> Result<()> {
    let Arguments { output, fmi, fmu, reference, .. } = arguments;
    let [trial] = &arguments.trials[..] else {
        bail!(Misused("--interface summary: is of one Trial".into()));
    };
    let binaries = fmu.binaries(&SUMMARY)?;
    let mut file = files::stage(output)?;
    let given = TrialInput::open(trial)?;
    let (documents, mut warnings, decision) = given.documents(&DriveChoice::Own, &DecisionChoice::Own)?;
    warnings.extend(lint::of_documents(
        &documents,
        &Files::chosen(given.path(), &DriveChoice::Own, decision.as_deref()),
    ));
    warnings.iter().for_each(|warning| note!("{warning}"));
    config.notes(&documents).iter().for_each(|note| note!("note: {note}"));
    let (format, picture) = (fmi.format(fmu.naming()), picture(&documents.trial));
    lemons_summary::pack::write_fmu(documents.clone(), config, format, &binaries, picture, &mut file)
        .with_context(|| trial.display().to_string())?;
    reference.add(&mut file, output, || Ok(documents))?;
    file.persist().with_context(|| format!("cannot write {}", output.display()))?;
    say_size(output)
}

pub fn say_size(output: &Path) -> Result<()> {
    let size = std::fs::metadata(output)?.len();
    say!("{}: {:.1} MB, by lemons {BUILD}", output.display(), size as f64 / 1e6)?;
    Ok(())
}

/// Packs Trials into a file that is claimed, and returns their warnings; errors of a Trial or of its drive are printed, one
/// line each.
pub fn write_fmu(
    trials: &[TrialInput],
    binaries: Vec<Binary>,
    format: FmuFormat,
    output: &Path,
    reference: Option<&Reference>,
) -> Result<Vec<String>> {
    let mut file = files::open(output)?;
    let warnings = lemons_master::pack(trials, binaries, format, Some(picture), output, &mut file)?;
    if let (Some(reference), Some(trial)) = (reference, trials.first()) {
        reference
            .add(&mut file, output, || Ok(trial.documents(&DriveChoice::Own, &DecisionChoice::Own)?.0))?;
    }
    file.persist().with_context(|| format!("cannot write {}", output.display()))?;
    Ok(warnings)
}

/// `model.png`; a Trial that cannot be drawn has none.
fn picture(trial: &Trial) -> Option<Vec<u8>> {
    let style = Style { width: 640.0, fill: Fill::BodyArea, ..Style::default() };
    png(&svg(&PictureScene::at_start(trial), &style), 640).ok()
}
