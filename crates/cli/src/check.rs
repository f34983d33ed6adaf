//! `lemons check`: all that is wrong with a Trial at once.

use crate::error::{TrialHasErrors, full_message};
use crate::version::BUILD;
use anyhow::Result;
use lemons_core::files::words::shortened;
use lemons_core::message::Sentence;
use lemons_core::rule::{RuleRow, parts};
use lemons_core::trial::{DriveTable, Parameters, Problem, Problems, Rule};
use lemons_master::{TrialInput, plan_of};
use lemons_sim::Documents;
use lemons_sim::lint::{self, Files};
use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, utf8_percent_encode};
use serde_json::{Value, json};
use std::path::{MAIN_SEPARATOR_STR, Path, PathBuf};

#[derive(clap::Args)]
pub struct Arguments {
    /// Trials to check: directories, or zips of them
    #[arg(required = true, value_name = "TRIAL")]
    trials: Vec<PathBuf>,
    /// Print what is found as JSON, in the format SARIF 2.1.0: rules, levels, files and lines
    #[arg(long)]
    json: bool,
}

pub fn check(arguments: &Arguments) -> Result<()> {
    let (mut sound, mut found) = (true, Vec::new());
    for path in &arguments.trials {
        let (problems, summary) = match TrialInput::open(path) {
            Ok(given) => report(&given),
            Err(error) => {
                let message = full_message(&error.into());
                let problem = Problem::by(Rule::Invalid, Path::new(""), message);
                (problem.into(), None)
            }
        };
        sound &= !problems.has_errors();
        if arguments.json {
            found.extend(problems.iter().map(|problem| result(problem, path)));
            continue;
        }
        problems.iter().try_for_each(|problem| say!("{}", shortened(&problem.to_string())))?;
        if let Some(summary) = summary {
            say!("{}: {summary}", path.display())?;
        }
    }
    if arguments.json {
        say!("{:#}", sarif(&found))?;
    }
    if sound { Ok(()) } else { Err(TrialHasErrors.into()) }
}

/// Returns what is found in a Trial, and its summary.
fn report(given: &TrialInput) -> (Problems, Option<String>) {
    let files = Files::within(given.path());
    let errors_of = |problems: &Problems| Some(counted(problems.errors().count(), "error"));
    let (trial, mut problems) = match given.read() {
        Ok(read) => read,
        Err(problems) => {
            let errors = errors_of(&problems);
            return (problems, errors);
        }
    };
    let drive = given.drive(&trial).unwrap_or_else(|errors| {
        problems.extend(errors.iter().cloned());
        DriveTable::default()
    });
    let plan = given.decision_file().map(|file| plan_of(&trial, &file)).transpose();
    let plan = plan.unwrap_or_else(|error| {
        problems.push(Problem::by(Rule::Invalid, &files.decision, full_message(&error.into())));
        None
    });
    let documents = Documents::new(trial, drive, plan);
    let Parameters { time_step, time_step_mechanical, .. } = documents.trial.parameters;
    problems.extend(lint::of_documents(&documents, &files));
    problems.extend(lint::of_step(&documents, time_step, &files));
    if problems.has_errors() {
        let errors = errors_of(&problems);
        return (problems, errors);
    }
    problems.extend(lint::of_accuracy(&documents, given.path(), &files));
    let warnings = problems.warnings().count();
    let summary = format!(
        "{}, {}, TimeStep {time_step:?} s, TimeStepMechanical {time_step_mechanical:?} s: {}",
        counted(documents.trial.agents.len(), "agent"),
        counted(documents.trial.geometry.walls.len(), "wall"),
        if warnings == 0 { "no problem".to_owned() } else { counted(warnings, "warning") }
    );
    (problems, Some(summary))
}

fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// A result of SARIF; what is in no file is in the Trial at a path.
fn result(problem: &Problem, path: &Path) -> Value {
    let Problem { rule, file, line, element, attribute, .. } = problem;
    // All of it but the place.
    let text = Problem { file: PathBuf::new(), line: None, ..problem.clone() };
    let text = format!("{text:#}");
    let file = if file.as_os_str().is_empty() { path } else { file };
    let mut place = json!({ "artifactLocation": { "uri": uri(file) } });
    if let Some(line) = line {
        place["region"] = json!({ "startLine": line });
    }
    let mut location = json!({ "physicalLocation": place });
    if let Some(element) = element {
        let of = attribute.iter().map(|attribute| format!("{element}/@{attribute}")).next();
        location["logicalLocations"] = json!([{ "fullyQualifiedName": of.as_ref().unwrap_or(element) }]);
    }
    let mut message = json!({ "text": shortened(&text) });
    let said = &problem.message;
    let sentences = rule.row().sentences.iter().chain(parts::ALL);
    if let Some(sentence) = sentences.into_iter().find(|sentence| sentence.id == said.id) {
        let values = sentence.parts().filter_map(|(_, place)| said.values.get(place?.0));
        message["id"] = said.id.clone().into();
        message["arguments"] = values.map(|value| shortened(value)).collect();
    }
    let level = problem.severity().to_string();
    json!({ "ruleId": rule.row().id, "level": level, "message": message, "locations": [location] })
}

/// Characters that stand for themselves in the path of an URI.
const PLAIN: &AsciiSet = &NON_ALPHANUMERIC.remove(b'-').remove(b'.').remove(b'_').remove(b'~').remove(b'/');

/// The URI of a file; relative, as its path.
fn uri(file: &Path) -> String {
    let text = file.to_string_lossy().replace(MAIN_SEPARATOR_STR, "/");
    let text = utf8_percent_encode(&text, PLAIN);
    if file.is_absolute() { format!("file:///{text}").replacen("////", "///", 1) } else { text.to_string() }
}

/// Sentences as SARIF has them: places are numbered.
fn strings(sentences: &[Sentence]) -> Value {
    let text = |sentence: &Sentence| {
        let parts = sentence.parts().enumerate();
        parts
            .map(|(k, (before, place))| place.map_or(before.into(), |_| format!("{before}{{{k}}}")))
            .collect::<String>()
    };
    let all = sentences.iter().map(|sentence| (sentence.id.into(), json!({ "text": text(sentence) })));
    Value::Object(all.collect())
}

/// A log of SARIF 2.1.0 with these results.
fn sarif(results: &[Value]) -> Value {
    let rule = |rule: &Rule| {
        let RuleRow { id, severity, means, advice, sentences, .. } = rule.row();
        json!({
            "id": id,
            "shortDescription": { "text": means },
            "help": { "text": advice },
            "messageStrings": strings(sentences),
            "defaultConfiguration": { "level": severity.to_string() }
        })
    };
    let rules: Vec<Value> = Rule::ALL.iter().map(rule).collect();
    let driver = json!({
        "name": "lemons check",
        "version": BUILD.to_string(),
        "globalMessageStrings": strings(parts::ALL),
        "rules": rules
    });
    json!({
        "$schema": "https://json.schemastore.org/sarif-2.1.0.json",
        "version": "2.1.0",
        "runs": [{ "tool": { "driver": driver }, "results": results }]
    })
}
