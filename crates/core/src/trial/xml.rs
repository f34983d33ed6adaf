//! Code that the readers and writers of the Trial's files share.
//!
//! A reader that finds an error reports it and continues with a placeholder (NaN, an empty Id), so that one pass finds
//! all errors. A Trial with an error is never returned, so no placeholder is either.

use crate::files::source::FileSource;
use crate::files::{input, words};
use crate::message::{Message, message};
use crate::plane::{Vec2, vec2};
use crate::rule::Rule;
use crate::rule::sentences::*;
use crate::trial::opening::OpeningTimes;
use crate::trial::problem::Problems;
use crate::trial::schema::{AttributeValue, Schema};
use crate::xml::{Document, Layout, Problem, XmlWriter, decimal};
use std::cell::RefCell;
use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};
use std::hash::Hash;
use std::iter::repeat;
use std::mem;
use std::path::Path;

/// A document with the warnings, or all that is wrong.
pub type Checked<T> = Result<(T, Problems), Problems>;

/// Files of a Trial while they are read.
pub(crate) struct Reading<'a> {
    pub(crate) files: &'a dyn FileSource,
    problems: RefCell<Problems>,
    /// Names in the present file that were told as those that may have been meant, with their element's.
    told: RefCell<HashSet<(&'static str, String)>>,
}

impl Reading<'_> {
    /// Returns what `read` reads without errors, with the warnings; or all errors.
    pub(crate) fn of<T>(files: &dyn FileSource, read: impl FnOnce(&Reading<'_>) -> Option<T>) -> Checked<T> {
        let reading = Reading { files, problems: RefCell::default(), told: RefCell::default() };
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

/// Reads one file of a Trial.
pub(crate) fn read_alone<T>(
    files: &dyn FileSource,
    path: &Path,
    schema: &'static Schema,
    read: impl FnOnce(Element<'_>) -> T,
) -> Checked<T> {
    Reading::of(files, |reading| reading.file(path, schema, read))
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

/// Something in a file that is not read.
#[derive(Clone, Copy)]
enum Unread<'a> {
    Attribute(roxmltree::Attribute<'a, 'a>),
    Element(crate::xml::Element<'a>),
    /// With its place in the file.
    Text(&'a str, usize),
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
            AttributeValue::Word(word) => self.node.optional(name).is_some_and(|text| text != *word),
            _ => false,
        })
    }

    /// Warns of what is in the file and is not read: each name in elements of one kind once, at its first place.
    fn warn_of_unread(self) {
        let key = |parent: Element<'_>, name, unread| (parent.schema.name, mem::discriminant(&unread), name);
        let mut counts = HashMap::new();
        self.each_unread(&mut |parent, name, unread| {
            *counts.entry(key(parent, name, unread)).or_insert(0) += 1;
        });
        let told = self.reading.told.borrow();
        counts.retain(|&(parent, _, name), _| !told.contains(&(parent, name.to_owned())));
        let (all, mut left) = (counts.len(), REPORTED);
        self.each_unread(&mut |parent, name, unread| {
            if left > 0
                && let Some(count) = counts.remove(&key(parent, name, unread))
            {
                left -= 1;
                self.report(parent.warning(name, unread, count));
            }
        });
        if all > REPORTED {
            let message = message!(MORE_NOT_READ, count = REPORTED);
            self.report(Problem::by(Rule::NotRead, self.node.file(), message));
        }
    }

    /// Shows what is in it and is not read, in the order of the file: the element around it, its name, itself.
    fn each_unread(self, see: &mut dyn FnMut(Element<'a>, &'a str, Unread<'a>)) {
        if self.is_foreign() {
            return;
        }
        self.unread_attributes().for_each(|own| see(self, own.name(), Unread::Attribute(own)));
        self.unread_elements().for_each(|node| see(self, node.name(), Unread::Element(node)));
        let texts = self.node.texts().filter(|(text, _)| !text.trim().is_empty());
        texts.for_each(|(text, offset)| see(self, "", Unread::Text(text, offset)));
        for node in self.node.elements() {
            if let Some(schema) = self.schema.child(node.name()) {
                Element { node, schema, ..self }.each_unread(see);
            }
        }
    }

    /// Says of something in it that it is not read, and how often it is there.
    fn warning(self, name: &str, unread: Unread<'_>, count: usize) -> Problem {
        let Schema { name: own, attributes, children } = self.schema;
        let times = (count > 1).then(|| message!(TIMES, count));
        let meant = |word: String| message!(MEANT, word);
        let warning = |offset, message: Message| Problem {
            line: Some(self.node.document().line(offset)),
            element: Some((*own).to_owned()),
            ..Problem::by(Rule::NotRead, self.node.file(), message)
        };
        match unread {
            Unread::Attribute(attribute) => {
                let word = words::meant(name, attributes.iter().map(|attribute| attribute.0));
                let meant = word.map(|word| meant(word.to_owned()));
                Problem {
                    attribute: Some(short(name)),
                    value: Some(attribute.value().to_owned()),
                    ..warning(attribute.range().start, message!(NOT_READ, times, meant))
                }
            }
            Unread::Element(node) => {
                let word = words::meant(name, children.iter().map(|child| child.name));
                let meant = word.map(|word| meant(format!("<{word}>")));
                let message = message!(NOT_READ_IN, within = *own, times, meant);
                Problem { element: Some(short(name)), ..warning(node.offset(), message) }
            }
            Unread::Text(text, offset) => warning(offset, message!(TEXT_NOT_READ, times, text = text.trim())),
        }
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

    fn value(self, attribute: &str) -> Option<AttributeValue> {
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
        } else if let Some(AttributeValue::Word(word)) = self.value(attribute)
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
        let fault = match (decimal(text), value) {
            (None, _) => "must be a finite decimal number",
            (Some(..=0.0), Some(AttributeValue::Positive)) => "must be positive",
            (Some(..0.0), Some(AttributeValue::NotNegative)) => "must not be negative",
            (Some(number), Some(AttributeValue::Share)) if !(0.0..=1.0).contains(&number) => {
                "must be from 0 to 1"
            }
            (Some(number), _) => return number,
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
        if far && matches!(self.value(attribute), Some(AttributeValue::Point)) {
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
        if let Some(AttributeValue::IdOf(what)) = self.value(attribute)
            && ids.is_some()
            && place.is_none()
            && !id.trim().is_empty()
        {
            self.wrong(attribute, format!("there is no such {what}"));
        }
        (id, place)
    }

    /// Returns the times of an attribute that may be left out.
    pub(crate) fn times(self, attribute: &str) -> Option<OpeningTimes> {
        let text = self.node.has(attribute).then(|| self.required(attribute))??;
        let times = OpeningTimes::parse(text);
        if times.is_none() {
            self.wrong(attribute, format!("must be {}: \"20,60 90,1e9\"", OpeningTimes::RULE));
        }
        times
    }

    /// Adds a problem to those of the file.
    pub(crate) fn report(self, problem: Problem) {
        self.reading.report(problem);
    }

    /// Reports an error about the element.
    pub(crate) fn error(self, message: impl Into<Message>) {
        self.report(self.node.problem(message));
    }

    /// Reports an error about an attribute, there or missing.
    pub(crate) fn wrong(self, attribute: &str, message: impl Into<Message>) {
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
pub(crate) fn document(root: &str, content: impl FnOnce(&mut XmlWriter)) -> String {
    XmlWriter::document(Layout::PAPER, root, &[], content)
}

/// Writes an element without children: the values of its attributes, in the order of its table.
pub(crate) fn empty(out: &mut XmlWriter, schema: &Schema, values: &[&str]) {
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

    const NUMBERS: [(&str, AttributeValue); 3] =
        [("X", AttributeValue::Positive), ("Y", AttributeValue::Positive), ("Z", AttributeValue::Positive)];
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
