//! The files of FMI-LS-REF 1.0.0-beta.1 (<https://github.com/modelica/fmi-ls-ref>), a layered standard for FMI 2.0 and 3.0:
//! the manifest, and the experiments that it names in the format of MA-HS-Experiments
//! (<https://github.com/modelica/ma-hs-experiments>).

use super::Experiment;
use crate::error::{ErrorPlace, Result, require};
use crate::fmu::Fmu;
use crate::ssp::Interface;
use lemons_core::files::input;
use lemons_core::xml::{Document, Element, Layout, XmlWriter, number};
use lemons_sim::Clock;
use percent_encoding::percent_decode_str;
use std::path::{Path, PathBuf};

/// The directory of the layered standard in an FMU; its name is that of the standard.
pub(super) const DIRECTORY: &str = "extra/org.fmi-standard.fmi-ls-ref";
const NAME: &str = "org.fmi-standard.fmi-ls-ref";
const NAMESPACE: &str = "http://fmi-standard.org/fmi-ls-manifest";
pub(super) const MANIFEST: &str = "fmi-ls-manifest.xml";
pub(super) const EXPERIMENTS: &str = "experiments.exp";
pub(super) const STIMULI: &str = "inputs.csv";
pub(super) const RESULTS: &str = "outputs.csv";
const EXPERIMENTS_TYPE: &str = "application/x-ma-hs-experiments";
const CSV: &str = "text/csv";

/// \[byte\] Of a manifest or of experiments.
const LARGEST: u64 = 1_000_000;
/// Elements and texts of one of them.
const NODES: u32 = 20_000;

/// An experiment of an FMU: its files are in the unpacked archive.
pub(super) struct Described {
    pub name: String,
    pub clock: Clock,
    pub tolerance: Option<f64>,
    pub stimuli: Option<Inside>,
    pub references: Inside,
}

/// A file of an FMU: where it is unpacked, and what the user knows it by.
pub(super) struct Inside {
    pub path: PathBuf,
    pub shown: PathBuf,
}

/// Returns the text of the manifest.
pub(super) fn manifest(stimuli: bool) -> String {
    let attributes = [
        ("xmlns:fmi-ls", NAMESPACE),
        ("fmi-ls:fmi-ls-name", NAME),
        ("fmi-ls:fmi-ls-version", "1.0.0-beta.1"),
        // The standard wants these words.
        (
            "fmi-ls:fmi-ls-description",
            "Layered Standard providing information on related files included in an FMU.",
        ),
    ];
    let related = [
        (EXPERIMENTS_TYPE, EXPERIMENTS, "experiment/smoke-test", "The run that gave the results"),
        (CSV, STIMULI, "other", "Inputs of this run"),
        (CSV, RESULTS, "result", "Outputs of this run"),
    ];
    XmlWriter::document(Layout::STANDARD, "fmiReferences", &attributes, |out| {
        for (of, source, role, description) in related.into_iter().filter(|it| stimuli || it.1 != STIMULI) {
            let own = [("type", of), ("source", source), ("role", role), ("description", description)];
            out.empty("Related", &own);
        }
    })
}

/// Returns the text of the file of an experiment.
pub(super) fn experiments(name: &str, clock: Clock, experiment: &Experiment, stimuli: bool) -> String {
    let [start, stop, step] = [clock.start, clock.until, clock.step].map(number);
    let tolerance = experiment.tolerance.map(number);
    let own: Vec<_> =
        [("name", name)].into_iter().chain(tolerance.iter().map(|it| ("tolerance", &it[..]))).collect();
    XmlWriter::document(Layout::STANDARD, "Experiments", &[("name", "reference")], |out| {
        out.element("Experiment", &own, |out| {
            let times = [("startTime", &start[..]), ("stopTime", &stop), ("stepSize", &step)];
            out.empty("TransientSimulation", &times);
            if stimuli {
                out.empty("Stimuli", &[("source", STIMULI)]);
            }
            out.empty("References", &[("source", RESULTS)]);
        });
    })
}

/// Reads the experiments of an FMU that have reference results.
pub(super) fn read(fmu: &Fmu) -> Result<Vec<Described>> {
    let manifest = inside(fmu, &format!("{DIRECTORY}/{MANIFEST}"));
    require(manifest.path.is_file(), || {
        format!("{}: it holds no reference ({DIRECTORY}); lemons pack --reference adds one", fmu.label())
    })?;
    let bytes = manifest.bytes()?;
    let document = Document::parse(&manifest.shown, &bytes, NODES)?;
    let root = document.root("fmiReferences")?;
    let name =
        root.attributes().find(|own| own.namespace() == Some(NAMESPACE) && own.name() == "fmi-ls-name");
    if name.is_none_or(|name| name.value() != NAME) {
        return Err(root.problem(format!("fmi-ls-name must be {NAME:?}")).into());
    }
    let mut described = Vec::new();
    for related in root.children("Related") {
        let is_experiment = related.text("role")?.split('/').next() == Some("experiment");
        if is_experiment && related.optional("type") == Some(EXPERIMENTS_TYPE) {
            let file = source(fmu, related)?;
            let bytes = file.bytes()?;
            let document = Document::parse(&file.shown, &bytes, NODES)?;
            for experiment in document.root("Experiments")?.children("Experiment") {
                described.extend(read_one(fmu, experiment)?);
            }
        }
    }
    require(!described.is_empty(), || {
        format!("{}: no experiment ({EXPERIMENTS_TYPE}) with reference results", manifest.shown.display())
    })?;
    Ok(described)
}

/// Reads an experiment; `None` if it has no reference results.
fn read_one(fmu: &Fmu, experiment: Element<'_>) -> Result<Option<Described>> {
    let Some(references) = experiment.child("References") else { return Ok(None) };
    if let Some(parameters) = experiment.child("Parameters") {
        return Err(parameters.problem("parameter sets are not served").into());
    }
    // Before MA-HS-Experiments had kinds of experiments, these were attributes of the experiment.
    let times = experiment.child("TransientSimulation").unwrap_or(experiment);
    let Interface { start, stop, step, .. } = *fmu.description;
    let time = |name: &str, default: Option<f64>| -> Result<f64> {
        let missing = || times.problem(format!("has no {name}, and the FMU has no default of it"));
        Ok(times.number(name)?.or(default).ok_or_else(missing)?)
    };
    let [start, stop, step] =
        [time("startTime", start.or(Some(0.0)))?, time("stopTime", stop)?, time("stepSize", step)?];
    let clock = Clock::new(start, step, stop).map_err(|error| times.problem(error.to_string()))?;
    let tolerance = experiment.number("tolerance")?;
    if tolerance.is_some_and(|tolerance| tolerance <= 0.0) {
        return Err(experiment.wrong("tolerance", "must be positive").into());
    }
    Ok(Some(Described {
        name: experiment.text("name")?.to_owned(),
        clock,
        tolerance,
        stimuli: experiment.child("Stimuli").map(|it| series(fmu, it)).transpose()?,
        references: series(fmu, references)?,
    }))
}

/// Finds a table over time.
fn series(fmu: &Fmu, element: Element<'_>) -> Result<Inside> {
    if element.optional("type").is_some_and(|of| of != CSV) {
        return Err(element.wrong("type", format!("only {CSV} is served")).into());
    }
    source(fmu, element)
}

/// Finds the file that an element names by a URI relative to its own file.
fn source(fmu: &Fmu, element: Element<'_>) -> Result<Inside> {
    let wrong = |why: &str| element.wrong("source", why);
    let uri = percent_decode_str(element.text("source")?).decode_utf8_lossy();
    if uri.starts_with('/') || uri.contains([':', '\\']) {
        return Err(wrong("must be relative, with forward slashes").into());
    }
    let own = element.file().strip_prefix(fmu.label()).unwrap_or(Path::new("")).parent();
    let mut place = own.unwrap_or(Path::new("")).to_owned();
    for part in uri.split('/').filter(|part| !matches!(*part, "" | ".")) {
        match part {
            ".." if place.pop() => {}
            ".." => return Err(wrong("leads outside of the FMU").into()),
            part => place.push(part),
        }
    }
    let found = inside(fmu, &place.to_string_lossy());
    if !found.path.is_file() {
        return Err(wrong("there is no such file in the FMU").into());
    }
    Ok(found)
}

fn inside(fmu: &Fmu, place: &str) -> Inside {
    Inside { path: fmu.directory().join(place), shown: Path::new(fmu.label()).join(place) }
}

impl Inside {
    fn bytes(&self) -> Result<Vec<u8>> {
        input::read(&self.path, LARGEST).place(|| self.shown.display().to_string())
    }
}
