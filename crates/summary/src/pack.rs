//! Writes an `.fmu` from documents, what is in which slot, and binaries.

use crate::Summary;
use crate::config::{SUMMARY_FILE, SummaryConfig, SummaryError};
use lemons_core::files::source::LocalFiles;
use lemons_core::trial::DRIVE_FILE;
use lemons_decision::{DECISION_FILE, PlanError};
use lemons_fmi::archive::{ArchiveError, Binary, FmuContent, FmuPicture, FmuWriter};
use lemons_fmi::description::{Packed, model_description, packed_description, terminals_xml};
use lemons_fmi::documentation::documentation;
use lemons_fmi::{FmuFormat, fingerprint};
use lemons_sim::Documents;
use std::io::{Seek, Write};
use std::path::Path;
use thiserror::Error;

/// Why an FMU could not be written.
#[derive(Debug, Error)]
#[allow(missing_docs)] // the messages say it
pub enum SummaryPackError {
    #[error(transparent)]
    Archive(#[from] ArchiveError),
    #[error(transparent)]
    Plan(#[from] PlanError),
    #[error(transparent)]
    Summary(#[from] SummaryError),
    #[error("{0}")]
    Start(String),
}

/// Returns the model description of the FMU.
///
/// # Errors
/// As [`write_fmu`], without binaries.
pub fn description(
    documents: Documents,
    config: &SummaryConfig,
    format: FmuFormat,
) -> Result<String, SummaryPackError> {
    let mut model = Summary::new(documents, config)?;
    model_description(&mut model, format).map_err(|refusal| SummaryPackError::Start(refusal.message))
}

/// Writes the FMU; `picture` is its `model.png`.
///
/// # Errors
/// More is there than fits into the slots, what was chosen is not there, a binary cannot be read, or the FMU cannot be
/// written.
pub fn write_fmu(
    documents: Documents,
    config: &SummaryConfig,
    format: FmuFormat,
    binaries: &[Binary],
    picture: Option<Vec<u8>>,
    file: impl Write + Seek,
) -> Result<(), SummaryPackError> {
    let Documents { trial, drive, plan } = &documents;
    let text = |path: &Path| path.iter().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/");
    let files = trial.texts(Path::new("resources")).into_iter();
    let mut files: Vec<(String, String)> = files.map(|(path, content)| (text(&path), content)).collect();
    let more = [
        (DRIVE_FILE, Some(drive.text_for(trial)).filter(|drive| !drive.is_empty())),
        (DECISION_FILE, plan.as_ref().map(|plan| plan.config.to_toml()).transpose()?),
        (SUMMARY_FILE, Some(config.to_toml()?)),
    ];
    let more = more.into_iter().filter_map(|(name, content)| Some((format!("resources/{name}"), content?)));
    files.extend(more);
    let all: Vec<String> =
        files.iter().map(|(name, content)| format!("{name} {}\n{content}", content.len())).collect();
    let packed = Packed { name: trial.name.clone(), fingerprint: fingerprint(all.concat().as_bytes()) };
    let people = trial.agents.len();
    let mut model = Summary::new(documents, config)?;
    let description = packed_description(&mut model, format, &[packed]);
    let content = FmuContent {
        version: format.version(),
        description: &description.map_err(|refusal| SummaryPackError::Start(refusal.message))?,
        documentation: &documentation(&model, format.version(), include_str!("documentation.html"), people),
        binaries,
        terminals: terminals_xml(&model, format.version(), "", &[]),
        icon: FmuPicture {
            svg: include_str!("../../../src/icon.svg"),
            png: include_bytes!("../../../src/icon.png"),
        },
        diagram: FmuPicture { svg: include_str!("diagram.svg"), png: include_bytes!("diagram.png") },
        picture,
    };
    let mut archive = FmuWriter::begin::<Summary>(file, &LocalFiles, &content)?;
    files.iter().try_for_each(|(name, content)| archive.add(name, content.as_bytes()))?;
    Ok(archive.finish()?)
}
