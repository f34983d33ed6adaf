//! The file by which the people of a Trial move: its `decision.toml`.

use crate::error::{Place, Result};
use crate::fmu::Fmu;
use lemons_core::files::input;
use lemons_core::trial::Trial;
use lemons_decision::decision::PLAN_FILE;
use lemons_decision::{DecisionConfig, Plan};
use std::path::{Path, PathBuf};

/// Which file says where the people of a Trial walk.
#[derive(Debug, Clone, Default, PartialEq, Eq, Hash)]
pub enum PlanChoice {
    /// The Trial's `decision.toml`, if it has one.
    #[default]
    Own,
    /// None: nobody walks.
    None,
    /// This one, in the format of `decision.toml`.
    File(PathBuf),
}

/// Reads what the people of a Trial do by the wishes in a file (`decision.toml`). The messages do not name the file.
///
/// # Errors
/// It cannot be read, it is not such a file, or it names people who are not in the Trial.
pub fn plan_of(trial: &Trial, path: &Path) -> Result<Plan> {
    // What lies in the Trial is not a pipe on purpose.
    let text = input::read_text(path, input::LARGEST_SETTINGS).place(|| "cannot be read".to_owned())?;
    let wishes = DecisionConfig::from_toml(&text)?;
    Ok(Plan::of(trial, &wishes)?)
}

/// The plan in a Decision FMU of ours; `None` of other FMUs.
pub fn plan_in(fmu: &Fmu) -> Option<Plan> {
    let path = fmu.directory().join("resources").join(PLAN_FILE);
    Plan::from_toml(&input::read_text(&path, input::LARGEST_SETTINGS).ok()?).ok()
}
