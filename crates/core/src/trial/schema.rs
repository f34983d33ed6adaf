//! Elements and attributes that are read of the Trial's XML files. The readers check values by it;
//! docs/reference/trial.md says the same, with units and meanings.

/// An element of a file: its name, its attributes, and the elements that are read in it.
pub(crate) struct Schema {
    pub(crate) name: &'static str,
    /// Names and values, in the order in which they are written.
    pub(crate) attributes: &'static [(&'static str, AttributeValue)],
    pub(crate) children: &'static [&'static Schema],
}

/// The values of an attribute.
#[derive(Clone, Copy)]
pub(crate) enum AttributeValue {
    /// A finite number.
    Number,
    /// A finite number above 0.
    Positive,
    /// A finite number, 0 or above.
    NotNegative,
    /// A number from 0 to 1.
    Share,
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
    /// Pairs of times.
    Times,
}

impl Schema {
    /// The values of an attribute, if it is read.
    pub(crate) fn value(&self, name: &str) -> Option<AttributeValue> {
        self.attributes.iter().find(|attribute| attribute.0 == name).map(|attribute| attribute.1)
    }

    /// The attributes with their values, which are in the order of the table; one without a value is not there.
    pub(crate) fn values<'a>(&self, values: &[Option<&'a str>]) -> Vec<(&'static str, &'a str)> {
        let all = self.attributes.iter().zip(values);
        all.filter_map(|((name, _), value)| Some((*name, (*value)?))).collect()
    }

    pub(crate) fn child(&self, name: &str) -> Option<&'static Schema> {
        self.children.iter().find(|child| child.name == name).copied()
    }

    /// All elements below it that have attributes, in the order of the page.
    pub(crate) fn below(&self) -> Vec<&'static Schema> {
        let with_attributes = |child: &'static Schema| (!child.attributes.is_empty()).then_some(child);
        let all =
            self.children.iter().flat_map(|child| with_attributes(child).into_iter().chain(child.below()));
        all.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial::documents::SCHEMAS;
    use std::path::Path;

    const HEADER: &str = "| attribute | type | unit | range | if missing | example | meaning |\n";

    /// Type and range, as the page names them.
    fn type_and_range(value: AttributeValue) -> (String, String) {
        let (kind, range) = match value {
            AttributeValue::Number => ("number", "any"),
            AttributeValue::Positive => ("number", "> 0"),
            AttributeValue::NotNegative => ("number", "≥ 0"),
            AttributeValue::Share => ("number", "0 to 1"),
            AttributeValue::Point => ("point", "any"),
            AttributeValue::Vector => ("vector", "any"),
            AttributeValue::Text => ("text", "any"),
            AttributeValue::Word(word) => (&*format!("`{word}`"), ""),
            AttributeValue::Id => ("Id", "any"),
            AttributeValue::IdOf("agent") => ("Id of an agent", "any"),
            AttributeValue::IdOf(what) => (&*format!("Id of a {what}"), "any"),
            AttributeValue::Place => ("place", "any"),
            AttributeValue::Times => ("times", "0 to 1e9"),
        };
        (kind.to_owned(), range.to_owned())
    }

    #[test]
    fn the_page_is_what_is_read() {
        let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference/trial.md");
        let page = std::fs::read_to_string(page).unwrap();
        for (root, chapter) in SCHEMAS.into_iter().zip(page.split("\n## ").skip(1)) {
            let schemas = root.below();
            assert_eq!(chapter.matches(HEADER).count(), schemas.len(), "<{}>", root.name);
            for (schema, table) in schemas.into_iter().zip(chapter.split(HEADER).skip(1)) {
                let rows = table.lines().skip(1).take_while(|line| line.starts_with('|'));
                let rows: Vec<Vec<&str>> = rows.map(|row| row.split('|').map(str::trim).collect()).collect();
                assert_eq!(rows.len(), schema.attributes.len(), "<{}>", schema.name);
                for (row, (name, value)) in rows.iter().zip(schema.attributes) {
                    // After a comma stands what is checked against another attribute.
                    let range = row[4].split(',').next().unwrap();
                    let stated = (row[2].to_owned(), range.to_owned());
                    assert_eq!(
                        (row[1], stated),
                        (&*format!("`{name}`"), type_and_range(*value)),
                        "<{}>",
                        schema.name
                    );
                    let example = format!("{name}=\"{}\"", row[6].trim_matches('`'));
                    assert!(chapter.contains(&example), "{example}");
                }
            }
        }
    }
}
