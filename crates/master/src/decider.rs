//! What moves the people of a Trial: its `decision.toml` becomes a Decision FMU.

use crate::error::{Error, Place, Result};
use crate::fmu::Fmu;
use crate::given::Given;
use crate::own::binary_beside;
use lemons_decision::decision::PLAN_FILE;
use lemons_decision::{Plan, WISHES_FILE, Wishes, pack};
use lemons_files::input;
use lemons_trial::Trial;
use std::fs::File;
use std::path::{Path, PathBuf};

/// The shared library of the Decision FMU.
const LIBRARY: &str = "lemons_decision_fmu";

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

/// What the people of a Trial do by the wishes in a file (`decision.toml`). The messages do not name the file.
///
/// # Errors
/// It cannot be read, it is not such a file, or it names people who are not in the Trial.
pub fn plan_of(trial: &Trial, path: &Path) -> Result<Plan> {
    // What lies in the Trial is not a pipe on purpose.
    let text = input::read_text(path, input::LARGEST_SETTINGS).place(|| "cannot be read".to_owned())?;
    let wishes = Wishes::from_toml(&text)?;
    Ok(Plan::of(trial, &wishes)?)
}

/// The plan in a Decision FMU of ours; `None` of other FMUs.
pub fn plan_in(fmu: &Fmu) -> Option<Plan> {
    let path = fmu.directory().join("resources").join(PLAN_FILE);
    Plan::from_toml(&input::read_text(&path, input::LARGEST_SETTINGS).ok()?).ok()
}

/// The Decision FMU of a Trial's people, as `lemons decide` makes it, written to a file; and the file that says where
/// they walk, as the user knows it. `None` if nobody walks.
///
/// # Errors
/// As [`plan_of`], with the file; the Trial has errors; or the library was not built with this program.
pub(crate) fn decider(given: &Given, choice: &PlanChoice, to: &Path) -> Result<Option<(Fmu, PathBuf)>> {
    let (path, known) = match choice {
        PlanChoice::None => return Ok(None),
        PlanChoice::File(path) => (path.clone(), path.clone()),
        PlanChoice::Own => match given.wishes() {
            Some(path) => (path, given.path().join(WISHES_FILE)),
            None => return Ok(None),
        },
    };
    let broken = |problems| Error::Broken { path: given.path().to_owned(), problems };
    let (trial, _) = given.read().map_err(broken)?;
    let shown = known.display().to_string();
    let plan = plan_of(&trial, &path).place(|| shown.clone())?;
    let file = File::create(to).map_err(Error::io("cannot make a temporary file"))?;
    pack::write_fmu(&plan, Default::default(), &[binary_beside(LIBRARY)?], file).place(|| shown.clone())?;
    Ok(Some((Fmu::open(to)?.shown_as(&shown), known)))
}
