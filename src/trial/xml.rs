//! What the readers and writers of the Trial's files share.
//!
//! A reader that meets a mistake reports it and goes on with a placeholder (NaN, an empty Id), so that one
//! reading finds every mistake; a Trial with an error is never handed out, so no placeholder is either.

use super::problem::{Problem, Problems, Severity};
use crate::engine::{Vec2, vec2};
use lemons_files::{input, markup};
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, Event};
use roxmltree::{Document, Node};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::Path;

/// A well-formed file.
pub(super) struct File<'a> {
    path: &'a Path,
    document: Document<'a>,
    /// Offsets of the line ends: `Document::text_pos_at` reads the text from its start for each question.
    line_ends: Vec<usize>,
}

impl File<'_> {
    fn line(&self, offset: usize) -> u32 {
        let before = self.line_ends.partition_point(|&end| end < offset);
        u32::try_from(before + 1).unwrap_or(u32::MAX)
    }
}

/// A problem with a whole file.
pub(super) fn file_problem(path: &Path, line: Option<u32>, message: String) -> Problem {
    Problem {
        severity: Severity::Error,
        file: path.to_owned(),
        line,
        element: None,
        attribute: None,
        value: None,
        message,
    }
}

/// Reads a file and hands its root element to `then`; `None` when it is missing, not XML or has another root.
pub(super) fn read_file<T>(
    path: &Path,
    root: &str,
    problems: &mut Problems,
    then: impl FnOnce(Element<'_>, &mut Problems) -> T,
) -> Option<T> {
    match input::read(path, input::LARGEST_TRIAL_FILE) {
        Ok(bytes) => read_bytes(path, &bytes, root, problems, then),
        Err(error) => {
            problems.push(file_problem(path, None, format!("cannot be read: {error}")));
            None
        }
    }
}

/// As [`read_file`], of the file's content.
pub(super) fn read_bytes<T>(
    path: &Path,
    bytes: &[u8],
    root: &str,
    problems: &mut Problems,
    then: impl FnOnce(Element<'_>, &mut Problems) -> T,
) -> Option<T> {
    let text = match std::str::from_utf8(bytes) {
        Ok(text) => text.strip_prefix('\u{feff}').unwrap_or(text),
        Err(error) => {
            let before = bytes[..error.valid_up_to()].iter().filter(|&&byte| byte == b'\n').count();
            let line = u32::try_from(before + 1).ok();
            problems.push(file_problem(path, line, "is not UTF-8 text".into()));
            return None;
        }
    };
    if let Err(refused) = markup::check(text) {
        let element = Some(refused.element);
        problems.push(Problem { element, ..file_problem(path, Some(refused.line), refused.what) });
        return None;
    }
    // Document types stay off, the default: no entities, hence no entity bombs.
    let document = match Document::parse(text) {
        Ok(document) => document,
        Err(error) => {
            let message = format!("is not well-formed XML: {error}");
            problems.push(file_problem(path, Some(error.pos().row), message));
            return None;
        }
    };
    let line_ends =
        text.bytes().enumerate().filter(|&(_, byte)| byte == b'\n').map(|(offset, _)| offset).collect();
    let file = File { path, document, line_ends };
    let element = Element { node: file.document.root_element(), file: &file };
    if element.name() != root {
        problems.push(element.problem(format!("the root element must be <{root}>")));
        return None;
    }
    Some(then(element, problems))
}

/// What a number may be, apart from finite.
#[derive(Clone, Copy)]
pub(super) enum Bound {
    None,
    Positive,
    NotNegative,
}

/// A finite decimal number, white space around it allowed. Rust's own parser takes "inf" and "nan" as well.
fn parse_number(text: &str) -> Option<f64> {
    let text = text.trim();
    let decimal = text.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'+' | b'-' | b'.' | b'e' | b'E'));
    text.parse().ok().filter(|value: &f64| decimal && value.is_finite())
}

fn parse_vector(text: &str) -> Option<Vec2> {
    let (x, y) = text.split_once(',')?;
    Some(vec2(parse_number(x)?, parse_number(y)?))
}

/// An element of a file. The methods that read an attribute report what is wrong and return a placeholder then.
#[derive(Clone, Copy)]
pub(super) struct Element<'a> {
    node: Node<'a, 'a>,
    file: &'a File<'a>,
}

impl<'a> Element<'a> {
    pub(super) fn name(self) -> &'a str {
        self.node.tag_name().name()
    }

    pub(super) fn path(self) -> &'a Path {
        self.file.path
    }

    pub(super) fn line(self) -> u32 {
        self.file.line(self.node.range().start)
    }

    pub(super) fn children(self, name: &'static str) -> impl Iterator<Item = Element<'a>> {
        let elements =
            self.node.children().filter(move |node| node.is_element() && node.tag_name().name() == name);
        elements.map(move |node| Element { node, ..self })
    }

    /// The only child of the name, `None` if there is none; a second one is an error.
    pub(super) fn at_most_one(self, name: &'static str, problems: &mut Problems) -> Option<Element<'a>> {
        let mut children = self.children(name);
        let first = children.next()?;
        for again in children {
            problems.push(
                again.problem(format!("may stand only once, and stands at line {} already", first.line())),
            );
        }
        Some(first)
    }

    /// The only child of the name; none or a second one is an error.
    pub(super) fn only(self, name: &'static str, problems: &mut Problems) -> Option<Element<'a>> {
        let child = self.at_most_one(name, problems);
        if child.is_none() {
            problems.push(self.problem(format!("has no <{name}>")));
        }
        child
    }

    pub(super) fn has(self, attribute: &str) -> bool {
        self.node.has_attribute(attribute)
    }

    pub(super) fn optional_text(self, attribute: &str) -> Option<&'a str> {
        self.node.attribute(attribute)
    }

    fn required(self, attribute: &str, problems: &mut Problems) -> Option<&'a str> {
        let text = self.node.attribute(attribute);
        if text.is_none() {
            problems.push(self.wrong(attribute, "is missing"));
        }
        text
    }

    /// A text that is not blank.
    pub(super) fn text(self, attribute: &str, problems: &mut Problems) -> String {
        let text = self.required(attribute, problems).unwrap_or_default();
        if text.trim().is_empty() && self.has(attribute) {
            problems.push(self.wrong(attribute, "must not be empty"));
        }
        text.to_owned()
    }

    pub(super) fn number(self, attribute: &str, bound: Bound, problems: &mut Problems) -> f64 {
        let Some(text) = self.required(attribute, problems) else {
            return f64::NAN;
        };
        let fault = match (parse_number(text), bound) {
            (None, _) => "must be a finite decimal number",
            (Some(value), Bound::Positive) if value <= 0.0 => "must be positive",
            (Some(value), Bound::NotNegative) if value < 0.0 => "must not be negative",
            (Some(value), _) => return value,
        };
        problems.push(self.wrong(attribute, fault));
        f64::NAN
    }

    pub(super) fn vector(self, attribute: &str, problems: &mut Problems) -> Vec2 {
        let vector = self.required(attribute, problems).map(parse_vector);
        if vector == Some(None) {
            problems.push(self.wrong(attribute, "must be two finite decimal numbers, \"x,y\""));
        }
        vector.flatten().unwrap_or(vec2(f64::NAN, f64::NAN))
    }

    /// A place, counted from 0, among `count` things.
    pub(super) fn place(
        self,
        attribute: &str,
        count: usize,
        of: &str,
        problems: &mut Problems,
    ) -> Option<usize> {
        let text = self.required(attribute, problems)?;
        let place = text.trim().parse().ok().filter(|&place| place < count);
        if place.is_none() {
            problems.push(
                self.wrong(attribute, &format!("must be the place of one of the {count} {of}, from 0")),
            );
        }
        place
    }

    /// An Id that stands in `ids`, with its place there; any Id where `ids` could not be read.
    pub(super) fn reference(
        self,
        attribute: &str,
        ids: Option<&Ids>,
        what: &str,
        problems: &mut Problems,
    ) -> (String, Option<usize>) {
        let id = self.text(attribute, problems);
        let place = ids.and_then(|ids| ids.place(&id));
        if ids.is_some() && place.is_none() && !id.trim().is_empty() {
            problems.push(self.wrong(attribute, &format!("there is no such {what}")));
        }
        (id, place)
    }

    /// An error about the element.
    pub(super) fn problem(self, message: impl Into<String>) -> Problem {
        Problem {
            element: Some(self.name().into()),
            ..file_problem(self.path(), Some(self.line()), message.into())
        }
    }

    /// An error about an attribute, there or missing.
    pub(super) fn wrong(self, attribute: &str, message: &str) -> Problem {
        let there = self.node.attribute_node(attribute);
        Problem {
            line: Some(there.map_or(self.line(), |there| self.file.line(there.range().start))),
            attribute: Some(attribute.into()),
            value: there.map(|there| there.value().into()),
            ..self.problem(message)
        }
    }
}

/// The Ids of one kind of element, which are unique, with their places in the file.
#[derive(Default)]
pub(super) struct Ids {
    places: HashMap<String, (usize, u32)>,
    count: usize,
}

impl Ids {
    /// Of elements that were read before.
    pub(super) fn of<'a>(ids: impl Iterator<Item = &'a str>) -> Ids {
        let places: HashMap<_, _> = ids.enumerate().map(|(place, id)| (id.to_owned(), (place, 0))).collect();
        Ids { count: places.len(), places }
    }

    /// Reads the Id of the next element of the kind.
    pub(super) fn take(&mut self, element: Element<'_>, problems: &mut Problems) -> String {
        let id = element.text("Id", problems);
        if !id.trim().is_empty() {
            match self.places.entry(id.clone()) {
                Entry::Occupied(first) => {
                    let message = format!("stands at line {} already; an Id must be unique", first.get().1);
                    problems.push(element.wrong("Id", &message));
                }
                Entry::Vacant(free) => {
                    free.insert((self.count, element.line()));
                }
            }
        }
        self.count += 1;
        id
    }

    pub(super) fn place(&self, id: &str) -> Option<usize> {
        self.places.get(id).map(|&(place, _)| place)
    }
}

/// `[("Id", …)]`
pub(super) type Attributes<'a> = &'a [(&'a str, &'a str)];

/// Text of a document being written. It writes into memory, which cannot fail: hence the dropped results.
pub(super) struct Out(Writer<Vec<u8>>);

impl Out {
    /// A whole document.
    pub(super) fn document(root: &str, content: impl FnOnce(&mut Out)) -> String {
        let mut out = Out(Writer::new_with_indent(Vec::new(), b' ', 4));
        let _ = out.0.write_event(Event::Decl(BytesDecl::new("1.0", Some("utf-8"), None)));
        out.element(root, &[], content);
        let mut text = out.0.into_inner();
        text.push(b'\n');
        String::from_utf8(text).unwrap_or_default()
    }

    pub(super) fn element(&mut self, name: &str, attributes: Attributes<'_>, content: impl FnOnce(&mut Out)) {
        let _ = self.0.write_event(Event::Start(start(name, attributes)));
        content(self);
        let _ = self.0.write_event(Event::End(BytesEnd::new(name)));
    }

    pub(super) fn empty(&mut self, name: &str, attributes: Attributes<'_>) {
        let _ = self.0.write_event(Event::Empty(start(name, attributes)));
    }
}

fn start<'a>(name: &'a str, attributes: Attributes<'a>) -> BytesStart<'a> {
    BytesStart::new(name).with_attributes(attributes.iter().copied())
}

/// The shortest decimal that reads back to the same double.
pub(super) fn number(value: f64) -> String {
    format!("{value:?}")
}

pub(super) fn vector(value: Vec2) -> String {
    format!("{:?},{:?}", value.x, value.y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    #[test]
    fn numbers_are_finite_decimals() {
        for (text, value) in [("1", 1.0), (" -2.5e-3\t", -2.5e-3), ("+.5", 0.5), ("1.", 1.0), ("2E+06", 2e6)]
        {
            assert_eq!(parse_number(text), Some(value), "{text:?}");
        }
        let bad = [
            "", " ", "nan", "NaN", "inf", "-inf", "infinity", "1e999", "0x10", "1_000", "1,5", "1 2", "٣",
            "--1",
        ];
        for text in bad {
            assert_eq!(parse_number(text), None, "{text:?}");
        }
        assert_eq!(parse_vector(" 1 , -2 "), Some(vec2(1.0, -2.0)));
        for text in ["1", "1,", ",1", "1,2,3", "1;2", "(1,2)"] {
            assert_eq!(parse_vector(text), None, "{text:?}");
        }
    }

    #[test]
    fn an_attribute_has_its_own_line() {
        let text = b"<A>\n <B\n  X='1'\n  Y='no'/>\n</A>";
        let mut problems = Problems::default();
        read_bytes(Path::new("f.xml"), text, "A", &mut problems, |root, problems| {
            let element = root.only("B", problems).unwrap();
            assert_eq!(element.line(), 2);
            element.number("X", Bound::Positive, problems);
            element.number("Y", Bound::Positive, problems);
            element.number("Z", Bound::Positive, problems);
        });
        let expected = "f.xml:4: <B> Y=\"no\": must be a finite decimal number\nf.xml:2: <B> Z: is missing";
        assert_eq!(problems.to_string(), expected);
    }

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: RngSeed::Fixed(7), ..ProptestConfig::default() })]

        #[test]
        fn a_number_reads_back_to_the_same_bits(bits: u64) {
            let value = f64::from_bits(bits);
            let back = parse_number(&number(value)).map(f64::to_bits);
            prop_assert_eq!(back, value.is_finite().then_some(bits));
        }

        #[test]
        fn any_bytes_are_read_without_a_panic(bytes: Vec<u8>, text in "[<>/=\"'&;#x! a\\n\\[\\]-]{0,60}") {
            let mut problems = Problems::default();
            for content in [&bytes[..], text.as_bytes()] {
                read_bytes(Path::new("f"), content, "A", &mut problems, |_, _| ());
            }
        }
    }
}
