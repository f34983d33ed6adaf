//! Code that the readers and writers of the Trial's files share.
//!
//! A reader that finds an error reports it and continues with a placeholder (NaN, an empty Id), so that one pass finds
//! all errors. A Trial with an error is never returned, so no placeholder is either.

use crate::files::source::Source;
use crate::files::{input, words};
use crate::plane::{Vec2, vec2};
use crate::trial::problem::Problems;
use crate::trial::schema::{Range, Schema, Value};
use crate::xml::{Attribute, Document, Layout, Out, Problem, Severity, decimal, quoted};
use std::cell::RefCell;
use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};
use std::iter::repeat;
use std::path::Path;

/// What is remembered of a file while it is read.
#[derive(Default)]
struct Notes {
    problems: RefCell<Problems>,
    /// Names that were told as those that may have been meant, with their element's.
    told: RefCell<HashSet<(&'static str, String)>>,
    /// Where elements begin of which nobody knows what is in them.
    foreign: RefCell<HashSet<usize>>,
}

/// Reads a file and hands its root element to `then`; `None` when it is missing, not XML or has another root.
pub(crate) fn read_file<T>(
    files: &dyn Source,
    path: &Path,
    root: &'static Schema,
    problems: &mut Problems,
    then: impl FnOnce(Element<'_>) -> T,
) -> Option<T> {
    match files.read(path, input::LARGEST_TRIAL_FILE) {
        Ok(bytes) => read_bytes(path, &bytes, root, problems, then),
        Err(error) => {
            problems.push(Problem::of_file(path, None, format!("cannot be read: {error}")));
            None
        }
    }
}

/// What was read without errors, with the warnings; or all errors.
pub(crate) fn checked<T>(read: impl FnOnce(&mut Problems) -> Option<T>) -> Result<(T, Problems), Problems> {
    let mut problems = Problems::default();
    match read(&mut problems) {
        Some(read) if !problems.has_errors() => Ok((read, problems)),
        _ => Err(problems),
    }
}

/// As [`read_file`], of the file's content.
pub(crate) fn read_bytes<T>(
    path: &Path,
    bytes: &[u8],
    root: &'static Schema,
    problems: &mut Problems,
    then: impl FnOnce(Element<'_>) -> T,
) -> Option<T> {
    let document = problems.or_push(Document::parse(path, bytes, u32::MAX))?;
    let inner = problems.or_push(document.root(root.name))?;
    let notes = Notes::default();
    let element = Element { inner, notes: &notes, schema: root };
    let read = then(element);
    element.warn_of_unread();
    problems.append(notes.problems.into_inner());
    Some(read)
}

/// Letters of a name that somebody else has given; the rest is not told.
const LONGEST_NAME: usize = 80;

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
    inner: crate::xml::Element<'a>,
    notes: &'a Notes,
    schema: &'static Schema,
}

/// What nobody reads.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Unread {
    Attribute,
    Element,
    Text,
}

/// What nobody reads of elements of one kind, where it was first seen, and how often.
struct Seen<'a> {
    what: Unread,
    schema: &'static Schema,
    /// Of the attribute or element; empty of a text.
    name: &'a str,
    value: Option<&'a str>,
    line: u32,
    count: usize,
}

impl<'a> Element<'a> {
    pub(crate) fn path(self) -> &'a Path {
        self.inner.file()
    }

    pub(crate) fn line(self) -> u32 {
        self.inner.line()
    }

    pub(crate) fn children(self, name: &'static str) -> impl Iterator<Item = Element<'a>> {
        let schema = self.schema.child(name);
        debug_assert!(schema.is_some(), "<{}> is said to hold no <{name}>", self.schema.name);
        let children =
            schema.into_iter().flat_map(move |schema| self.inner.children(name).zip(repeat(schema)));
        children.map(move |(inner, schema)| Element { inner, schema, ..self })
    }

    /// What is in it is another reader's.
    pub(crate) fn leave(self) {
        self.notes.foreign.borrow_mut().insert(self.inner.offset());
    }

    /// Attributes of this file's own words that are not read.
    fn unread_attributes(self) -> impl Iterator<Item = Attribute<'a>> {
        let own = self.inner.attributes().filter(|attribute| attribute.namespace().is_none());
        own.filter(move |attribute| self.schema.attribute(attribute.name()).is_none())
    }

    /// Elements in it that are not read; those of another namespace are for others.
    fn unread_elements(self) -> impl Iterator<Item = crate::xml::Element<'a>> {
        let own = self.inner.elements().filter(move |inner| {
            let space = inner.namespace();
            space.is_none() || space == self.inner.namespace()
        });
        own.filter(move |inner| self.schema.child(inner.name()).is_none())
    }

    /// Warns of what is in the file and is not read, each name once.
    fn warn_of_unread(self) {
        /// So many names say enough.
        const REPORTED: usize = 20;
        let mut places: HashMap<(*const Schema, Unread, &str), usize> = HashMap::new();
        let mut unread: Vec<Seen<'a>> = Vec::new();
        let mut more = false;
        let mut left = vec![self];
        while let Some(element) = left.pop() {
            if self.notes.foreign.borrow().contains(&element.inner.offset()) {
                continue;
            }
            let schema = element.schema;
            let attributes = element.unread_attributes().map(|attribute| {
                (Unread::Attribute, attribute.name(), Some(attribute.value()), attribute.offset())
            });
            let elements =
                element.unread_elements().map(|inner| (Unread::Element, inner.name(), None, inner.offset()));
            let texts = element.inner.texts().filter_map(|(text, offset)| {
                let text = text.trim();
                (!text.is_empty()).then_some((Unread::Text, "", Some(text), offset))
            });
            for (what, name, value, offset) in attributes.chain(elements).chain(texts) {
                match places.get(&(std::ptr::from_ref(schema), what, name)) {
                    Some(&place) => unread[place].count += 1,
                    None if unread.len() == REPORTED => more = true,
                    None => {
                        places.insert((schema, what, name), unread.len());
                        let line = self.inner.document().line(offset);
                        unread.push(Seen { what, schema, name, value, line, count: 1 });
                    }
                }
            }
            // In the order of the file: the first of a name is the one that is told.
            let before = left.len();
            left.extend(element.inner.elements().filter_map(|inner| {
                let schema = schema.child(inner.name())?;
                Some(Element { inner, schema, ..self })
            }));
            left[before..].reverse();
        }
        let told = self.notes.told.borrow();
        let untold = unread.iter().filter(|seen| !told.contains(&(seen.schema.name, seen.name.to_owned())));
        untold.for_each(|seen| self.report(seen.warning(self.path())));
        if more {
            let message = format!("more than {REPORTED} names of attributes and elements are not read");
            let warning = Problem::of_file(self.path(), None, message);
            self.report(Problem { severity: Severity::Warning, ..warning });
        }
    }

    /// The only child of the name, `None` if there is none; a second one is an error.
    pub(crate) fn at_most_one(self, name: &'static str) -> Option<Element<'a>> {
        let mut children = self.children(name);
        let first = children.next()?;
        for again in children {
            let message =
                format!("duplicate element, first used at line {}; it may appear only once", first.line());
            again.report(again.problem(message));
        }
        Some(first)
    }

    /// The only child of the name; none or a second one is an error.
    pub(crate) fn only(self, name: &'static str) -> Option<Element<'a>> {
        let child = self.at_most_one(name);
        if child.is_none() {
            self.report(self.has_no(name));
        }
        child
    }

    /// An error: no element of the name is in it; perhaps one of a name like it.
    pub(crate) fn has_no(self, name: &'static str) -> Problem {
        let meant = words::meant(name, self.unread_elements().map(|inner| inner.name()));
        let meant = meant.map_or(String::new(), |there| {
            self.notes.told.borrow_mut().insert((self.schema.name, there.to_owned()));
            format!("; there is <{there}>: is it misspelt?")
        });
        self.problem(format!("has no <{name}>{meant}"))
    }

    pub(crate) fn has(self, attribute: &str) -> bool {
        self.inner.has(attribute)
    }

    pub(crate) fn optional_text(self, attribute: &str) -> Option<&'a str> {
        self.inner.optional(attribute)
    }

    fn value(self, attribute: &str) -> Option<Value> {
        let value = self.schema.attribute(attribute).map(|attribute| attribute.value);
        debug_assert!(value.is_some(), "{attribute} is not said to be read");
        value
    }

    fn required(self, attribute: &str) -> Option<&'a str> {
        let text = self.inner.optional(attribute);
        if text.is_none() {
            let there = self.unread_attributes().map(|attribute| attribute.name());
            let meant = words::meant(attribute, there).map_or(String::new(), |there| {
                self.notes.told.borrow_mut().insert((self.schema.name, there.to_owned()));
                format!("; there is {there:?}: is it misspelt?")
            });
            self.wrong(attribute, &format!("is missing{meant}"));
        }
        text
    }

    /// A text that is not blank; if there is only one possible text, this one.
    pub(crate) fn text(self, attribute: &str) -> String {
        let text = self.required(attribute).unwrap_or_default();
        if text.trim().is_empty() && self.has(attribute) {
            self.wrong(attribute, "must not be empty");
        } else if let Some(Value::Word(word)) = self.value(attribute)
            && text != word
            && self.has(attribute)
        {
            self.wrong(attribute, &format!("must be {word:?}"));
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
            (Some(number), Some(Value::Number(Range::Positive | Range::UpTo(_)))) if number <= 0.0 => {
                "must be positive"
            }
            (Some(number), Some(Value::Number(Range::NotNegative))) if number < 0.0 => "must not be negative",
            (Some(number), _) => return number,
        };
        self.wrong(attribute, fault);
        f64::NAN
    }

    /// Two numbers; of a point of the plane \[m\], not too far from the origin.
    pub(crate) fn vector(self, attribute: &str) -> Vec2 {
        let vector = self.required(attribute).map(parse_vector);
        if vector == Some(None) {
            self.wrong(attribute, "must be two finite decimal numbers, \"x,y\"");
        }
        let vector = vector.flatten().unwrap_or(vec2(f64::NAN, f64::NAN));
        let far = vector.x.abs() > FARTHEST || vector.y.abs() > FARTHEST;
        if far && matches!(self.value(attribute), Some(Value::Point)) {
            self.wrong(attribute, &format!("x and y must be from -{FARTHEST:e} to {FARTHEST:e} m"));
        }
        vector
    }

    /// A place, counted from 0, among `count` things.
    pub(crate) fn place(self, attribute: &str, count: usize, of: &str) -> Option<usize> {
        let text = self.required(attribute)?;
        let place = text.trim().parse().ok().filter(|&place| place < count);
        if place.is_none() {
            self.wrong(attribute, &format!("must be the place of one of the {count} {of}, from 0"));
        }
        place
    }

    /// An Id that stands in `ids`, with its place there; any Id where `ids` could not be read.
    pub(crate) fn reference(self, attribute: &str, ids: Option<&Ids>) -> (String, Option<usize>) {
        let id = self.text(attribute);
        let place = ids.and_then(|ids| ids.place(&id));
        if let Some(Value::IdOf(what)) = self.value(attribute)
            && ids.is_some()
            && place.is_none()
            && !id.trim().is_empty()
        {
            self.wrong(attribute, &format!("there is no such {what}"));
        }
        (id, place)
    }

    /// An error about the element.
    pub(crate) fn problem(self, message: impl Into<String>) -> Problem {
        self.inner.problem(message)
    }

    /// Adds a problem to those of the file.
    pub(crate) fn report(self, problem: Problem) {
        self.notes.problems.borrow_mut().push(problem);
    }

    /// Reports an error about an attribute, there or missing.
    pub(crate) fn wrong(self, attribute: &str, message: &str) {
        self.report(self.inner.wrong(attribute, message));
    }
}

impl Seen<'_> {
    fn warning(&self, path: &Path) -> Problem {
        let Seen { what, schema, name, value, line, count } = *self;
        let times = if count > 1 { format!(" ({count} times)") } else { String::new() };
        let short = |name: &str| name.chars().take(LONGEST_NAME).collect::<String>();
        let (element, attribute, message) = match what {
            Unread::Attribute => {
                let meant = words::meant(name, schema.attributes.iter().map(|attribute| attribute.name));
                let meant = meant.map_or(String::new(), |word| format!("; is {word} meant?"));
                (schema.name, Some(short(name)), format!("is not read{times}{meant}"))
            }
            Unread::Element => {
                let meant = words::meant(name, schema.children.iter().map(|child| child.name));
                let meant = meant.map_or(String::new(), |word| format!("; is <{word}> meant?"));
                (name, None, format!("is not read in <{}>{times}{meant}", schema.name))
            }
            Unread::Text => {
                let text = quoted(value.unwrap_or_default());
                (schema.name, None, format!("the text in it is not read{times}: {text}"))
            }
        };
        Problem {
            severity: Severity::Warning,
            element: Some(short(element)),
            value: value.filter(|_| attribute.is_some()).map(str::to_owned),
            attribute,
            ..Problem::of_file(path, Some(line), message)
        }
    }
}

/// The Ids of one kind of element, which are unique, with their places in the file.
#[derive(Default)]
pub(crate) struct Ids {
    places: HashMap<String, (usize, u32)>,
    count: usize,
}

impl Ids {
    /// Of elements that were read before.
    pub(crate) fn of<'a>(ids: impl Iterator<Item = &'a str>) -> Ids {
        let places: HashMap<_, _> = ids.enumerate().map(|(place, id)| (id.to_owned(), (place, 0))).collect();
        Ids { count: places.len(), places }
    }

    /// Reads the Id of the next element of the kind.
    pub(crate) fn take(&mut self, element: Element<'_>) -> String {
        let id = element.text("Id");
        // Tables and drive.csv are read without it.
        if id.trim() != id && !id.trim().is_empty() {
            element.wrong("Id", "must not begin or end with white space");
        }
        if !id.trim().is_empty() {
            match self.places.entry(id.clone()) {
                Entry::Occupied(first) => {
                    element.wrong("Id", &format!("duplicate Id, first used at line {}", first.get().1));
                }
                Entry::Vacant(free) => {
                    free.insert((self.count, element.line()));
                }
            }
        }
        self.count += 1;
        id
    }

    pub(crate) fn place(&self, id: &str) -> Option<usize> {
        self.places.get(id).map(|&(place, _)| place)
    }
}

/// A whole document of a Trial.
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
    use crate::trial::schema::{Attribute, attribute};

    #[test]
    fn a_vector_is_two_numbers() {
        assert_eq!(parse_vector(" 1 , -2 "), Some(vec2(1.0, -2.0)));
        for text in ["1", "1,", ",1", "1,2,3", "1;2", "(1,2)"] {
            assert_eq!(parse_vector(text), None, "{text:?}");
        }
    }

    const fn number(name: &'static str) -> Attribute {
        attribute(name, Value::Number(Range::Positive), "", "")
    }

    static B: Schema =
        Schema { name: "B", attributes: &[number("X"), number("Y"), number("Z")], children: &[] };
    static A: Schema = Schema { name: "A", attributes: &[], children: &[&B] };

    #[test]
    fn an_attribute_has_its_own_line() {
        let text = b"<A>\n <B\n  X='1'\n  Y='no'/>\n</A>";
        let mut problems = Problems::default();
        read_bytes(Path::new("f.xml"), text, &A, &mut problems, |root| {
            let element = root.only("B").unwrap();
            assert_eq!(element.line(), 2);
            element.number("X");
            element.number("Y");
            element.number("Z");
        });
        let expected = "f.xml:4: <B> Y=\"no\": must be a finite decimal number\nf.xml:2: <B> Z: is missing";
        assert_eq!(problems.to_string(), expected);
    }
}
