//! Code that the readers and writers of the Trial's files share.
//!
//! A reader that finds an error reports it and continues with a placeholder (NaN, an empty Id), so that one pass finds
//! all errors. A Trial with an error is never returned, so no placeholder is either.

use crate::files::source::Source;
use crate::files::{input, words};
use crate::plane::{Vec2, vec2};
use crate::trial::documents::Checked;
use crate::trial::problem::Problems;
use crate::trial::schema::{Schema, Value};
use crate::xml::{Document, Layout, Out, Problem, Severity, decimal, quoted};
use std::cell::{Cell, RefCell};
use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};
use std::hash::Hash;
use std::iter::repeat;
use std::path::Path;

/// Files of a Trial while they are read.
pub(crate) struct Reading<'a> {
    pub(crate) files: &'a dyn Source,
    problems: RefCell<Problems>,
    /// Names in the present file of which something was told, with their element's.
    told: RefCell<HashSet<(&'static str, String)>>,
    /// Number of names in the present file that are not read.
    unread: Cell<usize>,
}

impl Reading<'_> {
    /// Returns what `read` reads without errors, with the warnings; or all errors.
    pub(crate) fn of<T>(files: &dyn Source, read: impl FnOnce(&Reading<'_>) -> Option<T>) -> Checked<T> {
        let (problems, told, unread) = (RefCell::default(), RefCell::default(), Cell::default());
        let reading = Reading { files, problems, told, unread };
        let read = read(&reading);
        let problems = reading.problems.into_inner();
        match read {
            Some(read) if !problems.has_errors() => Ok((read, problems)),
            _ => Err(problems),
        }
    }

    /// Reads a file and hands its root element to `then`; `None` when it is missing, not XML or has another root.
    pub(crate) fn file<T>(
        &self,
        path: &Path,
        schema: &'static Schema,
        then: impl FnOnce(Element<'_>) -> T,
    ) -> Option<T> {
        let read = || {
            let bytes = self.files.read(path, input::LARGEST_TRIAL_FILE);
            let unreadable = |error| Problem::of_file(path, None, format!("cannot be read: {error}"));
            let bytes = bytes.map_err(unreadable)?;
            let document = Document::parse(path, &bytes, u32::MAX)?;
            let node = document.root(schema.name)?;
            self.told.borrow_mut().clear();
            self.unread.set(0);
            let element = Element { node, reading: self, schema };
            let read = then(element);
            element.warn_of_unread();
            Ok(read)
        };
        read().map_err(|problem: Box<Problem>| self.report(*problem)).ok()
    }

    pub(crate) fn report(&self, problem: Problem) {
        self.problems.borrow_mut().push(problem);
    }
}

/// \[m\] Places further from the origin along x or y are refused: up to there a micrometre is exact, and no square of a
/// distance overflows.
pub const FARTHEST: f64 = 1e9;

fn parse_vector(text: &str) -> Option<Vec2> {
    let (x, y) = text.split_once(',')?;
    Some(vec2(decimal(x)?, decimal(y)?))
}

/// An element of a file. The methods that read an attribute report what is wrong and return a placeholder then.
#[derive(Clone, Copy)]
pub(crate) struct Element<'a> {
    pub(crate) node: crate::xml::Element<'a>,
    reading: &'a Reading<'a>,
    schema: &'static Schema,
}

/// So many names that are not read say enough.
const REPORTED: usize = 20;

impl<'a> Element<'a> {
    pub(crate) fn line(self) -> u32 {
        self.node.line()
    }

    pub(crate) fn children(self, name: &'static str) -> impl Iterator<Item = Element<'a>> {
        let schema = self.schema.child(name);
        debug_assert!(schema.is_some(), "<{}> is said to hold no <{name}>", self.schema.name);
        let children =
            schema.into_iter().flat_map(move |schema| self.node.children(name).zip(repeat(schema)));
        children.map(move |(node, schema)| Element { node, schema, ..self })
    }

    /// Returns the attributes of this file's own words that are not read.
    fn unread_attributes(self) -> impl Iterator<Item = roxmltree::Attribute<'a, 'a>> {
        let own = self.node.attributes().filter(|attribute| attribute.namespace().is_none());
        own.filter(move |attribute| self.schema.value(attribute.name()).is_none())
    }

    /// Returns the elements in it that are not read; those of another namespace are for others.
    fn unread_elements(self) -> impl Iterator<Item = crate::xml::Element<'a>> {
        let own = self.node.elements().filter(move |node| {
            let space = node.namespace();
            space.is_none() || space == self.node.namespace()
        });
        own.filter(move |node| self.schema.child(node.name()).is_none())
    }

    /// Returns whether it is of another kind than those that are read: nobody knows what is in it then.
    fn is_foreign(self) -> bool {
        self.schema.attributes.iter().any(|(name, value)| match value {
            Value::Word(word) => self.node.optional(name).is_some_and(|text| text != *word),
            _ => false,
        })
    }

    /// Warns of what is in it and is not read, in the order of the file: each name in elements of one kind once.
    fn warn_of_unread(self) {
        if self.is_foreign() {
            return;
        }
        let Schema { name: own, attributes, children } = self.schema;
        for attribute in self.unread_attributes() {
            let name = attribute.name();
            self.warn(name, attribute.range().start, |warning| {
                let word = words::meant(name, attributes.iter().map(|attribute| attribute.0));
                let meant = word.map_or(String::new(), |word| format!("; is {word} meant?"));
                warning.message = format!("is not read{meant}");
                (warning.attribute, warning.value) = (Some(short(name)), Some(attribute.value().to_owned()));
            });
        }
        for node in self.unread_elements() {
            let name = node.name();
            self.warn(name, node.offset(), |warning| {
                let word = words::meant(name, children.iter().map(|child| child.name));
                let meant = word.map_or(String::new(), |word| format!("; is <{word}> meant?"));
                warning.message = format!("is not read in <{own}>{meant}");
                warning.element = Some(short(name));
            });
        }
        for (text, offset) in self.node.texts().filter(|(text, _)| !text.trim().is_empty()) {
            self.warn("", offset, |warning| {
                warning.message = format!("the text in it is not read: {}", quoted(text.trim()));
            });
        }
        for node in self.node.elements() {
            if let Some(schema) = self.schema.child(node.name()) {
                Element { node, schema, ..self }.warn_of_unread();
            }
        }
    }

    /// Warns of a name that is not read, unless it was told before. `complete` says more of it.
    fn warn(self, name: &str, offset: usize, complete: impl FnOnce(&mut Problem)) {
        let Reading { told, unread, .. } = self.reading;
        if unread.get() > REPORTED || !told.borrow_mut().insert((self.schema.name, name.to_owned())) {
            return;
        }
        unread.set(unread.get() + 1);
        let mut warning = Problem::of_file(self.node.file(), None, "");
        warning.severity = Severity::Warning;
        if unread.get() > REPORTED {
            warning.message = format!("more than {REPORTED} names of attributes and elements are not read");
        } else {
            warning.line = Some(self.node.document().line(offset));
            warning.element = Some(self.schema.name.to_owned());
            complete(&mut warning);
        }
        self.report(warning);
    }

    /// Returns the only child of the name, `None` if there is none; a second one is an error.
    pub(crate) fn at_most_one(self, name: &'static str) -> Option<Element<'a>> {
        let mut children = self.children(name);
        let first = children.next()?;
        for again in children {
            let line = first.line();
            again.error(format!("duplicate element, first used at line {line}; it may appear only once"));
        }
        Some(first)
    }

    /// Returns the only child of the name; none or a second one is an error.
    pub(crate) fn only(self, name: &'static str) -> Option<Element<'a>> {
        let child = self.at_most_one(name);
        if child.is_none() {
            self.error(self.has_no(name));
        }
        child
    }

    /// Says that no element of the name is in it; perhaps one of a name like it.
    pub(crate) fn has_no(self, name: &'static str) -> String {
        let there = self.unread_elements().map(|node| node.name());
        format!("has no <{name}>{}", self.misspelt(name, there, |there| format!("<{there}>")))
    }

    /// Says which of the names that are there may be a misspelt one.
    fn misspelt(
        self,
        name: &str,
        there: impl Iterator<Item = &'a str>,
        shown: impl Fn(&str) -> String,
    ) -> String {
        let Some(there) = words::meant(name, there) else { return String::new() };
        self.reading.told.borrow_mut().insert((self.schema.name, there.to_owned()));
        format!("; there is {}: is it misspelt?", shown(there))
    }

    fn value(self, attribute: &str) -> Option<Value> {
        let value = self.schema.value(attribute);
        debug_assert!(value.is_some(), "{attribute} is not said to be read");
        value
    }

    fn required(self, attribute: &str) -> Option<&'a str> {
        let text = self.node.optional(attribute);
        if text.is_none() {
            let there = self.unread_attributes().map(|attribute| attribute.name());
            let misspelt = self.misspelt(attribute, there, |there| format!("{there:?}"));
            self.wrong(attribute, format!("is missing{misspelt}"));
        }
        text
    }

    /// Returns a text that is not blank; if there is only one possible text, this one.
    pub(crate) fn text(self, attribute: &str) -> String {
        let text = self.required(attribute).unwrap_or_default();
        if text.trim().is_empty() && self.node.has(attribute) {
            self.wrong(attribute, "must not be empty");
        } else if let Some(Value::Word(word)) = self.value(attribute)
            && text != word
            && self.node.has(attribute)
        {
            self.wrong(attribute, format!("must be {word:?}"));
        }
        text.to_owned()
    }

    pub(crate) fn number(self, attribute: &str) -> f64 {
        let value = self.value(attribute);
        let Some(text) = self.required(attribute) else {
            return f64::NAN;
        };
        let most = match value {
            Some(Value::UpTo(other)) => self.node.optional(other).and_then(decimal).zip(Some(other)),
            _ => None,
        };
        let fault = match (decimal(text), value) {
            (None, _) => "must be a finite decimal number".to_owned(),
            (Some(..=0.0), Some(Value::Positive | Value::UpTo(_))) => "must be positive".to_owned(),
            (Some(number), Some(Value::NotNegative)) if number < 0.0 => "must not be negative".to_owned(),
            (Some(number), _) => match most.filter(|(most, _)| number > *most) {
                Some((most, other)) => format!("must be at most {other}, {most:?}"),
                None => return number,
            },
        };
        self.wrong(attribute, fault);
        f64::NAN
    }

    /// Returns two numbers; of a point of the plane \[m\], not too far from the origin.
    pub(crate) fn vector(self, attribute: &str) -> Vec2 {
        let vector = self.required(attribute).map(parse_vector);
        if vector == Some(None) {
            self.wrong(attribute, "must be two finite decimal numbers, \"x,y\"");
        }
        let vector = vector.flatten().unwrap_or(vec2(f64::NAN, f64::NAN));
        let far = vector.x.abs() > FARTHEST || vector.y.abs() > FARTHEST;
        if far && matches!(self.value(attribute), Some(Value::Point)) {
            self.wrong(attribute, format!("x and y must be from -{FARTHEST:e} to {FARTHEST:e} m"));
        }
        vector
    }

    /// Returns a place, counted from 0, among `count` things.
    pub(crate) fn place(self, attribute: &str, count: usize, of: &str) -> Option<usize> {
        let text = self.required(attribute)?;
        let place = text.trim().parse().ok().filter(|&place| place < count);
        if place.is_none() {
            self.wrong(attribute, format!("must be the place of one of the {count} {of}, from 0"));
        }
        place
    }

    /// Returns an Id that stands in `ids`, with its place there; any Id where `ids` could not be read.
    pub(crate) fn reference(self, attribute: &str, ids: Option<&Ids<'_>>) -> (String, Option<usize>) {
        let id = self.text(attribute);
        let place = ids.and_then(|ids| ids.get(&*id).copied());
        if let Some(Value::IdOf(what)) = self.value(attribute)
            && ids.is_some()
            && place.is_none()
            && !id.trim().is_empty()
        {
            self.wrong(attribute, format!("there is no such {what}"));
        }
        (id, place)
    }

    /// Adds a problem to those of the file.
    pub(crate) fn report(self, problem: Problem) {
        self.reading.report(problem);
    }

    /// Reports an error about the element.
    pub(crate) fn error(self, message: impl Into<String>) {
        self.report(self.node.problem(message));
    }

    /// Reports an error about an attribute, there or missing.
    pub(crate) fn wrong(self, attribute: &str, message: impl Into<String>) {
        self.report(self.node.wrong(attribute, message));
    }
}

/// A name that somebody else has given; the rest of its letters is not told.
fn short(name: &str) -> String {
    const LONGEST: usize = 80;
    name.chars().take(LONGEST).collect()
}

/// Places of elements of one kind by their Ids.
pub(crate) type Ids<'a> = HashMap<&'a str, usize>;

/// Returns the places of elements by their Ids; of equal ones the first.
pub(crate) fn ids_of<'a>(ids: impl Iterator<Item = &'a String>) -> Ids<'a> {
    let mut places = Ids::new();
    for (place, id) in ids.enumerate().filter(|(_, id)| !id.trim().is_empty()) {
        places.entry(id).or_insert(place);
    }
    places
}

/// Reads the Id of an element, which is the only one of its kind with it; `lines` are those of the elements before.
pub(crate) fn read_id(element: Element<'_>, lines: &mut HashMap<String, u32>) -> String {
    let id = element.text("Id");
    if id.trim().is_empty() {
        return id;
    }
    // Tables and drive.csv are read without it.
    if id.trim() != id {
        element.wrong("Id", "must not begin or end with white space");
    }
    if let Some(line) = given_before(lines, id.clone(), element) {
        element.wrong("Id", format!("duplicate Id, first used at line {line}"));
    }
    id
}

/// Returns the line at which a key was first given, if that was before, and keeps it.
pub(crate) fn given_before<K: Eq + Hash>(
    lines: &mut HashMap<K, u32>,
    key: K,
    element: Element<'_>,
) -> Option<u32> {
    match lines.entry(key) {
        Entry::Occupied(first) => Some(*first.get()),
        Entry::Vacant(free) => {
            free.insert(element.line());
            None
        }
    }
}

/// Writes a whole document of a Trial.
pub(crate) fn document(root: &str, content: impl FnOnce(&mut Out)) -> String {
    Out::document(Layout::PAPER, root, &[], content)
}

/// Writes an element without children: the values of its attributes, in the order of its table.
pub(crate) fn empty(out: &mut Out, schema: &Schema, values: &[&str]) {
    let values: Vec<Option<&str>> = values.iter().copied().map(Some).collect();
    out.empty(schema.name, &schema.values(&values));
}

pub(crate) fn vector(value: Vec2) -> String {
    format!("{:?},{:?}", value.x, value.y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::source::Memory;

    const NUMBERS: [(&str, Value); 3] =
        [("X", Value::Positive), ("Y", Value::Positive), ("Z", Value::Positive)];
    static B: Schema = Schema { name: "B", attributes: &NUMBERS, children: &[] };
    static A: Schema = Schema { name: "A", attributes: &[], children: &[&B] };

    #[test]
    fn an_attribute_has_its_own_line() {
        let mut files = Memory::default();
        files.put(Path::new("f.xml"), b"<A>\n <B\n  X='1'\n  Y='no'/>\n</A>".to_vec());
        let read = Reading::of(&files, |reading| {
            reading.file(Path::new("f.xml"), &A, |root| {
                let element = root.only("B").unwrap();
                assert_eq!(element.line(), 2);
                let [x, y, z] = ["X", "Y", "Z"].map(|attribute| element.number(attribute));
                assert!(x == 1.0 && y.is_nan() && z.is_nan());
            })
        });
        let expected = "f.xml:4: <B> Y=\"no\": must be a finite decimal number\nf.xml:2: <B> Z: is missing";
        assert_eq!(read.unwrap_err().to_string(), expected);
    }
}
