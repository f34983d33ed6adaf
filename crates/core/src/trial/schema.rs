//! What is read of the Trial's XML files: elements, and the table of their attributes. The readers check values by it, and
//! the tables of docs/reference/trial.md are made from it.

use crate::xml::Document;
use std::path::Path;

/// An element of a file: its name, its attributes, and the elements that are read in it.
pub(crate) struct Schema {
    pub(crate) name: &'static str,
    pub(crate) attributes: &'static [Attribute],
    pub(crate) children: &'static [&'static Schema],
}

/// An attribute that is read.
pub(crate) struct Attribute {
    pub(crate) name: &'static str,
    pub(crate) value: Value,
    unit: &'static str,
    /// Words for what is used if it is not there.
    missing: &'static str,
    meaning: &'static str,
}

/// The values of an attribute.
#[derive(Clone, Copy)]
pub(crate) enum Value {
    /// A finite number.
    Number,
    /// A finite number above 0.
    Positive,
    /// A finite number, 0 or above.
    NotNegative,
    /// A positive number, at most another attribute.
    UpTo(&'static str),
    /// Two numbers, not too far from the origin.
    Point,
    /// Two numbers.
    Vector,
    /// A text that is not blank.
    Text,
    /// This text only.
    Word(&'static str),
    /// A text that is unique in its file.
    Id,
    /// The Id of something else.
    IdOf(&'static str),
    /// A place in a list, from 0.
    Place,
}

/// Makes an attribute that is required.
pub(crate) const fn attribute(
    name: &'static str,
    value: Value,
    unit: &'static str,
    meaning: &'static str,
) -> Attribute {
    Attribute { name, value, unit, missing: "an error", meaning }
}

impl Attribute {
    /// Makes it optional.
    pub(crate) const fn or(self, missing: &'static str) -> Attribute {
        Attribute { missing, ..self }
    }

    /// A row of a table in Markdown; `example` is one value.
    fn row(&self, example: &str) -> String {
        let Attribute { name, unit, missing, meaning, .. } = self;
        let (kind, range) = match self.value {
            Value::Number => ("number", "any"),
            Value::Positive => ("number", "> 0"),
            Value::NotNegative => ("number", "≥ 0"),
            Value::UpTo(other) => ("number", &*format!("> 0, ≤ {other}")),
            Value::Point => ("point", "any"),
            Value::Vector => ("vector", "any"),
            Value::Text => ("text", "any"),
            Value::Word(word) => (&*format!("`{word}`"), ""),
            Value::Id => ("Id", "any"),
            Value::IdOf("agent") => ("Id of an agent", "any"),
            Value::IdOf(what) => (&*format!("Id of a {what}"), "any"),
            Value::Place => ("place", "any"),
        };
        let row = format!("| `{name}` | {kind} | {unit} | {range} | {missing} | `{example}` | {meaning} |\n");
        // Empty cells have one space.
        row.replace("|  |", "| |").replace("|  |", "| |")
    }
}

impl Schema {
    pub(crate) fn attribute(&self, name: &str) -> Option<&'static Attribute> {
        self.attributes.iter().find(|attribute| attribute.name == name)
    }

    /// The attributes with their values, which are in the order of the table; one without a value is not there.
    pub(crate) fn values<'a>(&self, values: &[Option<&'a str>]) -> Vec<(&'static str, &'a str)> {
        let all = self.attributes.iter().zip(values);
        all.filter_map(|(attribute, value)| Some((attribute.name, (*value)?))).collect()
    }

    pub(crate) fn child(&self, name: &str) -> Option<&'static Schema> {
        self.children.iter().find(|child| child.name == name).copied()
    }

    /// All elements below it that have attributes, in the order of the page, each with the way to it.
    pub(crate) fn below(&'static self, way: &[&'static str]) -> Vec<(Vec<&'static str>, &'static Schema)> {
        let mut all = Vec::new();
        for child in self.children {
            let way = [way, &[child.name]].concat();
            let below = child.below(&way);
            all.extend((!child.attributes.is_empty()).then_some((way, *child)).into_iter().chain(below));
        }
        all
    }
}

const HEADER: &str = "| attribute | type | unit | range | if missing | example | meaning |\n\
                      |---|---|---|---|---|---|---|\n";

/// Returns the page docs/reference/trial.md with the tables of attributes as they are read today. Its chapters are those
/// of the files; the examples in the tables are those of each chapter.
///
/// # Errors
/// A chapter has no example, or another number of tables than its file has elements with attributes.
pub fn reference_page(page: &str) -> Result<String, String> {
    let mut chapters = page.split("\n## ");
    let mut out = chapters.next().unwrap_or_default().to_owned();
    for (root, chapter) in crate::trial::documents::SCHEMAS.into_iter().zip(chapters) {
        let example = chapter.split("```").nth(1).and_then(|block| block.strip_prefix("xml\n"));
        let example = example.ok_or_else(|| format!("<{}> has no example", root.name))?;
        let document = Document::parse(Path::new(""), example.as_bytes(), u32::MAX);
        let document = document.map_err(|problem| problem.to_string())?;
        let mut parts = chapter.split(HEADER);
        out += "\n## ";
        out += parts.next().unwrap_or_default();
        for (way, schema) in root.below(&[]) {
            let part = parts.next().ok_or_else(|| format!("<{}> has no table", schema.name))?;
            let mut element = Some(document.any_root());
            way.iter().for_each(|name| element = element.and_then(|element| element.child(name)));
            out += HEADER;
            for attribute in schema.attributes {
                let example = element.and_then(|element| element.optional(attribute.name));
                out += &attribute.row(example.unwrap_or_default());
            }
            let rows = part.lines().take_while(|line| line.starts_with('|'));
            out += &part[rows.map(|row| row.len() + 1).sum::<usize>().min(part.len())..];
        }
        if parts.next().is_some() {
            return Err(format!("the chapter of <{}> has too many tables", root.name));
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_is_what_is_read() {
        let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference/trial.md");
        let page = std::fs::read_to_string(page).unwrap();
        let made = reference_page(&page).unwrap();
        let again = "cargo run -p lemons-cli --example reference -- trial docs/reference/trial.md";
        made.lines().zip(page.lines()).for_each(|(made, page)| assert_eq!(made, page, "{again}"));
        assert_eq!(made.len(), page.len(), "{again}");
        assert_eq!(page.matches(HEADER).count(), 16);
    }
}
