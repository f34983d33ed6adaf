//! Reads `sweep.toml`.

use crate::error::{ErrorPlace, Result};
use crate::measure::Measure;
use crate::measure::places::Places;
use crate::models::{Models, SweepDecision, Template};
use crate::output::Stop;
use crate::points::{Axis, OUTPUT_DIRECTORY, Points};
use crate::population::Population;
use crate::table::{ERROR, POINT, STATUS};
use lemons_core::files::input;
use lemons_core::trial::DriveChoice;
use lemons_master::{DecisionChoice, FileType, require};
use lemons_sim::{Algorithm, Until};
use serde::{Deserialize, Deserializer};
use serde_json::{Map, Value};
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// Model, parameters and measures of a sweep. Relative paths are relative to the directory of the file.
#[derive(Debug, Clone)]
pub struct Spec {
    /// The model that is simulated at each point.
    pub(crate) models: Models,
    /// The people of the crowds that are the models, if these are made here.
    pub(crate) population: Option<Population>,
    /// True if each Trial must have a `decision.toml`.
    pub(crate) needs_decision: bool,
    /// When a point ends.
    pub until: Until,
    /// Condition that ends a point before.
    pub(crate) stop: Option<Stop>,
    /// \[s\] Communication step; `None`: that of the Trial.
    pub step: Option<f64>,
    /// The forces that drive people.
    pub(crate) drive: DriveChoice,
    /// In which order crowd and Decision exchange values.
    pub(crate) algorithm: Algorithm,
    /// The points that are simulated.
    pub points: Points,
    /// Names and measures, in the order of the file.
    pub(crate) measures: Vec<(String, Measure)>,
    /// Lines and areas of the measures.
    pub(crate) places: Places,
    /// The files that are read.
    pub inputs: Vec<PathBuf>,
    /// Part of the identity that the file itself says: it must be equal to go on.
    pub(crate) identity: Map<String, Value>,
}

/// The keys of the file that say where something is, or how it is set: what they mean is compared instead.
const ELSEWHERE: [&str; 10] =
    ["trial", "fmu", "step", "drive", "decision", "algorithm", "parameters", "table", "walkable", "scenario"];

/// When a point ends, as the file says it.
fn until<'de, D: Deserializer<'de>>(of: D) -> Result<Until, D::Error> {
    #[derive(Deserialize)]
    #[serde(rename_all = "snake_case")]
    enum Word {
        Left,
    }
    #[derive(Deserialize)]
    #[serde(untagged, expecting = "expected a number of seconds, or \"left\"")]
    enum End {
        Time(f64),
        Word(Word),
    }
    Ok(match End::deserialize(of)? {
        End::Time(time) => Until::Time(time),
        End::Word(Word::Left) => Until::Left,
    })
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    trial: Option<String>,
    fmu: Option<String>,
    population: Option<Population>,
    scenario: Option<PathBuf>,
    #[serde(deserialize_with = "until")]
    until: Until,
    stop: Option<Stop>,
    step: Option<f64>,
    drive: Option<FileText>,
    decision: Option<FileText>,
    #[serde(default)]
    algorithm: Algorithm,
    parameters: Option<toml::Table>,
    table: Option<PathBuf>,
    #[serde(default)]
    lines: toml::Table,
    #[serde(default)]
    areas: toml::Table,
    walkable: Option<PathBuf>,
    measures: toml::Table,
}

/// A file, or whether the Trial's own is used.
#[derive(Deserialize)]
#[serde(untagged)]
enum FileText {
    Switch(bool),
    File(String),
}

/// Names that the table uses itself.
const RESERVED: [&str; 4] = [POINT, STATUS, ERROR, ENDED];
/// The column of a sweep whose points may end by themselves: when they did \[s\].
pub const ENDED: &str = "ended";

impl Spec {
    /// Reads a `sweep.toml`.
    ///
    /// # Errors
    /// A sentence with the key and what is wrong.
    pub fn read(path: &Path) -> Result<Spec> {
        FileType::expect(path, &[FileType::TEXT, FileType::STREAM], "a sweep.toml (lemons sweep --help)")?;
        let text = input::read_text(path, input::LARGEST_SETTINGS)
            .place(|| format!("cannot read {}", path.display()))?;
        let directory = path.parent().unwrap_or(Path::new(""));
        Self::from_toml(&text, directory).place(|| path.display().to_string())
    }

    /// Reads the text of a `sweep.toml` in a directory.
    ///
    /// # Errors
    /// A sentence with the key and what is wrong.
    pub fn from_toml(text: &str, directory: &Path) -> Result<Spec> {
        let document: Document = toml::from_str(text)?;
        let mut identity: Map<String, Value> = toml::from_str(text)?;
        identity.retain(|key, _| !ELSEWHERE.contains(&key.as_str()));
        let mut inputs = Vec::new();
        let population = match (document.population, document.scenario) {
            (given, None) => given.map(|given| given.within(directory)),
            (None, Some(path)) => {
                inputs.push(directory.join(path));
                Some(Population::read(&inputs[0]).place(|| "scenario".into())?)
            }
            (Some(_), Some(_)) => return Err("scenario: is another [population]: give one of them".into()),
        };
        let (key, model) = match (document.trial, document.fmu, &population) {
            (Some(path), None, None) => ("trial", path),
            (None, Some(path), None) => ("fmu", path),
            (None, None, Some(_)) => ("population", String::new()),
            _ => return Err("give one of the keys trial, fmu and scenario, or [population]".into()),
        };
        for (name, given) in [("decision", document.decision.is_some()), ("drive", document.drive.is_some())]
        {
            require(!given || population.is_none(), || format!("{name}: is not for a [population]"))?;
        }
        if let Some(population) = &population {
            population.check().place(|| "population".into())?;
        }
        let decision_of_fmu = key == "fmu" && document.decision.is_some();
        require(!decision_of_fmu, || "decision: is for a trial, and not for an fmu")?;
        for (key, value) in [("until", Some(document.until.latest())), ("step", document.step)] {
            let positive = value.is_none_or(|value| value > 0.0 && value.is_finite());
            require(positive, || format!("{key}: must be a positive number of seconds"))?;
        }
        let points = match (document.parameters, document.table) {
            (Some(axes), None) => {
                let mut all = Vec::new();
                for (name, value) in axes {
                    let place = || format!("parameters: {name}");
                    let values = value.try_into::<Axis>().place(place)?.values().place(place)?;
                    all.push((name, values));
                }
                Points::grid(all).place(|| "parameters".into())?
            }
            (None, Some(table)) => {
                let table = directory.join(table);
                inputs.push(table.clone());
                Points::read(&table)?
            }
            _ => return Err("give one of [parameters] and table".into()),
        };
        check_directories(&points)?;
        let mut measures = Vec::new();
        for (name, value) in document.measures {
            let measure = Measure::read(value).place(|| format!("measures: {name}"))?;
            measures.push((name, measure));
        }
        require(!measures.is_empty(), || "measures: must not be empty")?;
        let mut names = HashSet::from(RESERVED);
        let given = points.parameters.iter().map(|parameter| &parameter.name);
        for name in given.chain(measures.iter().map(|(name, _)| name)) {
            require(names.insert(name), || {
                format!("{name:?}: the table already has a column with this name")
            })?;
        }
        let walkable = document.walkable.map(|path| directory.join(path));
        let places = Places::read(document.lines, document.areas, walkable)?;
        inputs.extend(places.walkable.as_ref().map(|walkable| walkable.path.clone()));
        for (name, measure) in &measures {
            measure.check(&places, &points).place(|| format!("measures: {name}"))?;
        }
        let used = places.walkable.is_none() || !places.areas.is_empty();
        require(used, || "walkable: is for [areas], and there are none")?;
        if let Some(stop) = &document.stop {
            stop.check().place(|| "stop".into())?;
        }
        let template =
            |key: &str, text: &str| Template::read(text, directory, &points).place(|| key.to_owned());
        let chosen = population.as_ref().map(|population| population.choosers(&points));
        let chosen = chosen.transpose().place(|| "parameters".into())?;
        let model = template(key, &model)?;
        let needs_decision = matches!(document.decision, Some(FileText::Switch(true)));
        let decision = match &document.decision {
            None | Some(FileText::Switch(true)) => SweepDecision::Own,
            Some(FileText::Switch(false)) => SweepDecision::None,
            Some(FileText::File(text)) => SweepDecision::File(template("decision", text)?),
        };
        let drive = match document.drive {
            None | Some(FileText::Switch(true)) => DriveChoice::Own,
            Some(FileText::Switch(false)) => DriveChoice::None,
            Some(FileText::File(path)) => DriveChoice::File(directory.join(path)),
        };
        if let DriveChoice::File(path) = &drive {
            inputs.push(path.clone());
        }
        let Document { until, stop, step, algorithm, .. } = document;
        let models = match chosen {
            Some(chosen) => Models::of_crowds(&points, chosen)?,
            None => Models::of(&points, &model, &decision)?,
        };
        for (place, (name, _)) in models.all.iter().enumerate() {
            let Some(population) = &population else { break };
            let own = population.at(&points, models.first_point(place));
            let own = own.place(|| name.display().to_string()).place(|| "parameters".into())?;
            inputs.extend(own.files());
        }
        for (path, decision) in models.all.iter().filter(|_| population.is_none()) {
            inputs.push(path.clone());
            if let DecisionChoice::File(path) = decision {
                inputs.push(path.clone());
            }
        }
        Ok(Spec {
            models,
            population,
            needs_decision,
            until,
            stop,
            step,
            drive,
            algorithm,
            points,
            measures,
            places,
            inputs,
            identity,
        })
    }

    /// Returns the names of what is measured, in the order of the table's columns.
    pub fn measured(&self) -> Vec<String> {
        let ended = self.may_end().then(|| ENDED.to_owned());
        self.measures.iter().map(|(name, _)| name.clone()).chain(ended).collect()
    }

    /// Returns whether points may end by themselves, before their latest end. The table then has the column `ended`.
    pub fn may_end(&self) -> bool {
        self.until == Until::Left || self.stop.is_some()
    }
}

/// Checks that no two points have the same OutputDirectory, where they would overwrite each other's files.
fn check_directories(points: &Points) -> Result<()> {
    let mut seen = HashSet::new();
    for (_, directory) in points.output_directories() {
        require(seen.insert(directory), || {
            format!(
                "{OUTPUT_DIRECTORY} = {directory:?}: two points have it, and would overwrite each other's files; with \
                 a table of points, each can have its own"
            )
        })?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = r#"
        trial = "push"
        until = 2
        drive = false
        [parameters]
        "agent[*].Mass" = { from = 50, to = 200, count = 3, spacing = "logarithmic" }
        "contact.a.a.KineticFriction" = [0, 0.5]
        [lines]
        a = [0, 0, 0, 2]
        [measures]
        reach = { of = "x", take = "reach", agents = ["4"] }
    "#;

    fn read(text: &str) -> Result<Spec, String> {
        Spec::from_toml(text, Path::new("in")).map_err(|error| error.whole())
    }

    #[test]
    fn a_crowd_is_checked_with_all_its_values() {
        let text = |keys: &str| {
            format!(
                "until = 2\n[population]\nnumber = 9\nbox = [5, 5]\nmix = {{ adult = \"rest\", child = 60 }}\n[parameters]\n\
                 {keys}\n[measures]\nreach = {{ of = \"x\", take = \"reach\", agents = [\"4\"] }}"
            )
        };
        let (child, chairs) = ("\"population.mix.child\" = [10]", "\"population.mix.wheelchair\" = [80]");
        for keys in [format!("{child}\n{chairs}"), format!("{chairs}\n{child}")] {
            assert_eq!(read(&text(&keys)).unwrap().models.all.len(), 1);
            let wrong = keys.replace("[80]", "[80, 95]");
            let error = read(&text(&wrong)).unwrap_err();
            assert!(error.contains("population.mix.wheelchair = 95"), "{error}");
            assert!(
                error.ends_with(
                    "`mix`: the others have 105 together: nothing of 100 is left for the \"rest\""
                ),
                "{error}"
            );
        }
    }

    #[test]
    fn a_grid() {
        let spec = read(GOOD).unwrap();
        let model = &spec.models.all[0].0;
        assert_eq!((model, spec.until, spec.points.count), (&PathBuf::from("in/push"), Until::Time(2.0), 6));
        let mass = &spec.points.parameters[0];
        assert_eq!((mass.name.as_str(), mass.at(0), mass.at(5)), ("agent[*].Mass", "50.0", "200.0"));
        assert!((mass.at(2).parse::<f64>().unwrap() - 100.0).abs() < 1e-12);
        assert_eq!(spec.drive, DriveChoice::None);
        // A width is a number or a parameter.
        for width in ["1.5", "'agent[*].Mass'"] {
            let text = format!("[measures]\nflow = {{ {FLOW}, width = {width} }}");
            assert_eq!(read(&GOOD.replace("[measures]", &text)).unwrap().measures.len(), 2);
        }
    }

    const FLOW: &str = "line = 'a', direction = 'left', number = 'specific_flow'";

    #[test]
    fn mistakes_name_the_key() {
        let measure = "of = \"x\", take = \"reach\", agents = [\"4\"]";
        let flow = |width: &str| format!("{FLOW}, width = {width}");
        let (zero, none, friction) = (flow("0"), flow("'Mass'"), flow("'contact.a.a.KineticFriction'"));
        // What replaces a part of the good text, and what is said.
        for (part, to, expected) in [
            ("trial = \"push\"", "", "trial, fmu and scenario"),
            ("trial = \"push\"", "fmu = \"push.fmu\"\ndecision = false", "decision: is for a trial"),
            ("\"push\"", "\"push_{seed}\"", "trial: push_{seed}: there is no parameter \"seed\""),
            ("drive = false", "decision = 5", "decision"),
            ("drive = false", "algorithm = \"euler\"", "gauss-seidel"),
            ("until = 2", "until = 2\nstop = { of = \"x\" }", "stop: it needs one of at_least and at_most"),
            ("until = 2", "until = -2", "until: must be a positive"),
            ("until = 2", "until = \"soon\"", "expected a number of seconds, or \"left\""),
            ("until = 2", "until = 2\nwalkable = \"none.wkt\"", "walkable: in/none.wkt"),
            ("until = 2", "untill = 2", "untill"),
            ("count = 3, spacing", "spacing", "count: is missing"),
            ("count = 3", "count = 1", "agent[*].Mass: count = 1"),
            ("from = 50", "from = 0", "must be positive"),
            ("from = 50", "from = -inf", "agent[*].Mass: from and to must be finite"),
            ("[0, 0.5]", "[]", "KineticFriction: no values"),
            ("[0, 0.5]", "true", "KineticFriction: expected a list"),
            ("[0, 0.5]", "[0.5, nan]", "KineticFriction: NaN: must be a finite number"),
            ("[0, 0.5]", "{ from = 1.5, to = 3 }", "count"),
            ("[0, 0.5]", "{ from = 3, to = 1 }", "from = 3, to = 1"),
            ("[measures]", "b = [1, 2, 1, 2]\n[measures]", "lines: b: must be two different points"),
            ("[measures]", "b = [1, 2, 1, nan]\n[measures]", "lines: b: must be two different"),
            ("[measures]", "[areas]\nf = [1, 2, 0, 3]\n[measures]", "areas: f: must be the lower left"),
            ("[measures]", "[areas]\nf = [0, 0, 1, 1, 1, 0, 0, 1]\n[measures]", "areas: f: must be the"),
            ("reach = {", "status = {", "\"status\": the table already has a column"),
            ("of = \"x\"", "of = \"mood\"", "measures: reach"),
            (measure, "line = 'a', of = 'x'", "one of the keys of, line, area, squeeze, balance"),
            (
                measure,
                "line = 'b', direction = 'left', number = 'flow'",
                "line = \"b\": there is none in [lines]",
            ),
            (measure, "line = 'a', direction = 'up', number = 'flow'", "unknown variant `up`"),
            (measure, &zero, "width: 0.0 is not a positive number"),
            (measure, &none, "width = \"Mass\": there is no such parameter"),
            (measure, &friction, "width: 0.0 is not a positive"),
            (measure, "area = 'b', number = 'people', take = 'max'", "area = \"b\": the file has no [areas]"),
            (
                measure,
                "squeeze = 'peak', from = 2, until = 1",
                "until = 1.0: the beginning is not before the",
            ),
            (measure, "squeeze = 'peak', from = '2'", "in `from`"),
            (measure, "squeeze = 'time_above'", "squeeze = \"time_above\" needs a level"),
            (measure, "balance = 'mood'", "must be one of falls, lean, steps, time_unbalanced"),
        ] {
            assert!(GOOD.contains(part));
            let message = read(&GOOD.replace(part, to)).unwrap_err();
            assert!(message.contains(expected), "{to}: {message}");
        }
    }

    /// Five widths of a door, each with its own crowds.
    #[test]
    fn parameters_choose_trials_and_decisions() {
        let text = GOOD
            .replace("\"push\"", "\"door_{width}_{seed}\"\ndecision = \"{width}.toml\"")
            .replace("[0, 0.5]", "[0.4]\nwidth = [0.8, 1.0]\nseed = { from = 1, to = 3 }");
        let spec = read(&text).unwrap();
        assert_eq!(spec.points.parameters[3].values(), ["1", "2", "3"]);
        let models = &spec.models;
        assert_eq!((spec.points.count, models.all.len(), spec.inputs.len()), (18, 6, 12));
        let decision = |name: &str| DecisionChoice::File(PathBuf::from(name));
        assert_eq!(models.all[models.place(4)], (PathBuf::from("in/door_1.0_2"), decision("in/1.0.toml")));
        assert_eq!(models.place(4), models.place(10));
        assert_eq!([0, 1, 2, 3].map(|column| models.only_chooses(column)), [false, false, true, true]);
        let error = read(&text.replace("to = 3 }", "to = 20000 }")).unwrap_err();
        assert_eq!(error, "there are more than 10000 crowds, Trials, FMUs or files like decision.toml");
    }

    /// They overflowed to infinities and to NaN, which were simulated.
    #[test]
    fn a_wide_range_has_finite_values() {
        for (from, to, spacing, middle) in [
            (-1e308, 1.7e308, "linear", 0.35e308),
            (1.7e308, -1.7e308, "linear", 0.0),
            (1e-300, 1e300, "logarithmic", 1.0),
            (1e300, 1e-300, "logarithmic", 1.0),
            (5e-324, f64::MAX, "logarithmic", 2f64.powi(-25)),
        ] {
            let text = format!("{{ from = {from:e}, to = {to:e}, count = 101, spacing = {spacing:?} }}");
            let points = read(&GOOD.replace("[0, 0.5]", &text)).unwrap().points;
            let values = points.parameters[1].values().iter();
            let values: Vec<f64> = values.map(|text| text.parse().unwrap()).collect();
            let rising = |pair: &[f64]| if from < to { pair[0] < pair[1] } else { pair[0] > pair[1] };
            assert!(values.windows(2).all(rising) && values.iter().all(|value| value.is_finite()));
            assert_eq!((values[0], values[100]), (from, to));
            assert!((values[50] - middle).abs() <= 1e-2 * f64::abs(middle), "{text}: {}", values[50]);
        }
    }
}
