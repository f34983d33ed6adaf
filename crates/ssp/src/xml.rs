//! What the readers of `.ssd`, `.ssv` and `modelDescription.xml` share: elements whose errors name file, line,
//! element, attribute and value.

use anyhow::{Result, anyhow};
use lemons_files::markup;
use roxmltree::{Node, ParsingOptions};
use std::fmt::Display;
use std::str::FromStr;

/// The most elements and texts of a file: each takes some 100 bytes of memory. A model description of 10 000
/// agents has half as many.
const NODES: u32 = 4_000_000;

/// A well-formed file.
pub(crate) struct Document<'a> {
    tree: roxmltree::Document<'a>,
    file: &'a str,
    /// Offsets of the line ends: `roxmltree::Document::text_pos_at` reads the text from its start each time.
    line_ends: Vec<usize>,
}

impl<'a> Document<'a> {
    pub(crate) fn parse(file: &'a str, bytes: &'a [u8]) -> Result<Document<'a>> {
        let text = std::str::from_utf8(bytes).map_err(|_| anyhow!("{file}: is not UTF-8 text"))?;
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        markup::check(text).map_err(|refused| anyhow!("{file}:{}: {refused}", refused.line))?;
        let options = ParsingOptions { nodes_limit: NODES, ..ParsingOptions::default() };
        // Document types stay off, the default: no entities, hence no entity bombs.
        let tree = roxmltree::Document::parse_with_options(text, options)
            .map_err(|error| anyhow!("{file}:{}: is not well-formed XML: {error}", error.pos().row))?;
        let line_ends =
            text.bytes().enumerate().filter(|&(_, byte)| byte == b'\n').map(|(offset, _)| offset).collect();
        Ok(Document { tree, file, line_ends })
    }

    /// The root element, which must have this name.
    pub(crate) fn root(&'a self, name: &str) -> Result<Element<'a>> {
        let root = Element { node: self.tree.root_element(), document: self };
        if root.name() != name {
            return Err(root.problem(format!("the root element must be <{name}>")));
        }
        Ok(root)
    }
}

/// An element of a file. Prefixes and namespaces are not looked at: SSP 1.0 has no two elements of one name.
#[derive(Clone, Copy)]
pub(crate) struct Element<'a> {
    node: Node<'a, 'a>,
    document: &'a Document<'a>,
}

impl<'a> Element<'a> {
    pub(crate) fn name(self) -> &'a str {
        self.node.tag_name().name()
    }

    pub(crate) fn file(self) -> &'a str {
        self.document.file
    }

    pub(crate) fn line(self) -> u32 {
        let start = self.node.range().start;
        let before = self.document.line_ends.partition_point(|&end| end < start);
        u32::try_from(before + 1).unwrap_or(u32::MAX)
    }

    pub(crate) fn elements(self) -> impl Iterator<Item = Element<'a>> {
        let elements = self.node.children().filter(Node::is_element);
        elements.map(move |node| Element { node, ..self })
    }

    pub(crate) fn children(self, name: &'static str) -> impl Iterator<Item = Element<'a>> {
        self.elements().filter(move |element| element.name() == name)
    }

    pub(crate) fn child(self, name: &'static str) -> Option<Element<'a>> {
        self.children(name).next()
    }

    pub(crate) fn optional(self, attribute: &str) -> Option<&'a str> {
        self.node.attribute(attribute)
    }

    pub(crate) fn text(self, attribute: &str) -> Result<&'a str> {
        self.optional(attribute).ok_or_else(|| self.problem(format!("has no {attribute}")))
    }

    /// A number of the type; `None` if there is no such attribute.
    pub(crate) fn parsed<T: FromStr>(self, attribute: &str, what: &str) -> Result<Option<T>> {
        let Some(text) = self.optional(attribute) else { return Ok(None) };
        let value = text.trim().parse().map_err(|_| self.wrong(attribute, format!("must be {what}")))?;
        Ok(Some(value))
    }

    /// A finite number; `None` if there is no such attribute.
    pub(crate) fn number(self, attribute: &str) -> Result<Option<f64>> {
        match self.parsed(attribute, "a number")? {
            Some(value) if !f64::is_finite(value) => Err(self.wrong(attribute, "must be finite")),
            value => Ok(value),
        }
    }

    /// XML Schema's booleans; `None` if there is no such attribute.
    pub(crate) fn boolean(self, attribute: &str) -> Result<Option<bool>> {
        match self.optional(attribute).map(str::trim) {
            None => Ok(None),
            Some("true" | "1") => Ok(Some(true)),
            Some("false" | "0") => Ok(Some(false)),
            Some(_) => Err(self.wrong(attribute, "must be true or false")),
        }
    }

    /// An error about the element.
    pub(crate) fn problem(self, message: impl Display) -> anyhow::Error {
        anyhow!("{}:{}: <{}>: {message}", self.document.file, self.line(), self.name())
    }

    /// An error about an attribute that is there.
    pub(crate) fn wrong(self, attribute: &str, message: impl Display) -> anyhow::Error {
        let value = self.optional(attribute).unwrap_or_default();
        let (file, line, name) = (self.document.file, self.line(), self.name());
        anyhow!("{file}:{line}: <{name}> {attribute}={}: {message}", quoted(value))
    }
}

/// In quotes, on one line, cut to a length that a reader takes in.
fn quoted(text: &str) -> String {
    const LONGEST: usize = 80;
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{:?}…", &text[..end]),
        None => format!("{text:?}"),
    }
}
