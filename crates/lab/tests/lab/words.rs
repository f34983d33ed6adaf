//! Words of the page for what the engine says: lab/src/words/engine.de.json and engine.fr.json.

use crowd_mechanics::setup::reasons;
use lemons_core::rule::{Rule, parts};
use lemons_people::drawing::Sort;
use lemons_people::{BICYCLE_MEASURES, BodyMeasure, Kinds, PART_MATERIALS};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Ids of all sentences and names, with the English texts.
fn english() -> BTreeMap<String, String> {
    let of_rules = Rule::ALL.iter().flat_map(|rule| rule.row().sentences).chain(parts::ALL);
    let others = [lemons_people::SENTENCES, lemons_scenario::SENTENCES, lemons_decision::SENTENCES];
    let others = others.into_iter().chain([lemons_report::SENTENCES]);
    let all = of_rules.chain(others.flatten()).chain(lemons_lab::SENTENCES);
    let kinds = Kinds::built_in().unwrap();
    let things = kinds.iter().flat_map(|kind| &kind.parts).map(|part| &*part.name).chain(PART_MATERIALS);
    let measures = BodyMeasure::ALL.iter().map(|measure| measure.name());
    let sorts = Sort::ALL.iter().map(|sort| sort.name());
    let names = things.chain(measures).chain(sorts).chain(BICYCLE_MEASURES.iter().map(|of| of.0));
    let others = ["bicycle", "child", "mass of all", "desired speed", "door", "gap", "passage", "window"];
    let names: BTreeSet<&str> = names.chain(others).collect();
    let texts: Vec<(String, String)> = all
        .map(|sentence| (sentence.id.to_owned(), sentence.text.to_owned()))
        .chain(reasons().map(|(id, text)| (id, text.to_owned())))
        .chain(names.iter().map(|name| (format!("name.{name}"), (*name).to_owned())))
        .collect();
    let by_id: BTreeMap<String, String> = texts.iter().cloned().collect();
    assert_eq!(by_id.len(), texts.len(), "two have one id");
    by_id
}

/// Names of places.
fn places(text: &str) -> BTreeSet<&str> {
    let names = text.split('{').skip(1).filter_map(|rest| rest.split(['}', ':']).next());
    names.collect()
}

#[test]
fn what_the_engine_says_has_words_with_the_same_places() {
    let english = english();
    for language in ["de", "fr"] {
        let path =
            Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../lab/src/words/engine.{language}.json"));
        let text = std::fs::read_to_string(path).unwrap();
        let words: BTreeMap<String, String> = serde_json::from_str(&text).unwrap();
        let ids = |of: &BTreeMap<String, String>| of.keys().cloned().collect::<BTreeSet<_>>();
        let missing: Vec<_> = ids(&english).difference(&ids(&words)).cloned().collect();
        let unsaid: Vec<_> = ids(&words).difference(&ids(&english)).cloned().collect();
        assert!(
            missing.is_empty() && unsaid.is_empty(),
            "{language}: missing {missing:?}, unsaid {unsaid:?}"
        );
        for (id, text) in &english {
            assert_eq!(places(text), places(&words[id]), "{language}: {id}");
        }
        // In one order: of two changes of the same text there is one conflict.
        assert_eq!(
            text,
            serde_json::to_string_pretty(&words).unwrap().replace("  \"", "    \"") + "\n",
            "{language}"
        );
    }
}
