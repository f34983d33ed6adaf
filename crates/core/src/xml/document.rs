//! A text from outside -> its elements and attributes, with their lines.

use crate::message::Message;
use crate::xml::check::check;
use crate::xml::problem::{Problem, Result};
use roxmltree::{Attribute, Node, ParsingOptions};
use std::cell::OnceCell;
use std::path::Path;
use std::str::FromStr;

/// A well-formed file.
pub struct Document<'a> {
    tree: roxmltree::Document<'a>,
    file: &'a Path,
    /// Offsets of the line ends, once somebody asks for a line: `roxmltree::Document::text_pos_at` reads the text from
    /// its start for each question.
    line_ends: OnceCell<Vec<usize>>,
}

impl<'a> Document<'a> {
    /// Parses the content of a file, whose name is in all problems; it may be empty. Elements and texts are at most so
    /// many: each takes some 100 bytes of memory.
    ///
    /// # Errors
    /// It is not UTF-8 text or not well-formed, has a document type, or more in it than is taken.
    pub fn parse(file: &'a Path, bytes: &'a [u8], most_nodes: u32) -> Result<Document<'a>> {
        let text = std::str::from_utf8(bytes).map_err(|error| {
            let before = bytes[..error.valid_up_to()].iter().filter(|&&byte| byte == b'\n').count();
            Problem::of_file(file, u32::try_from(before + 1).ok(), "is not UTF-8 text")
        })?;
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        check(file, text)?;
        // Document types stay off, the default: no entities, hence no entity bombs.
        let options = ParsingOptions { nodes_limit: most_nodes, ..ParsingOptions::default() };
        let tree = roxmltree::Document::parse_with_options(text, options).map_err(|error| {
            Problem::of_file(file, Some(error.pos().row), format!("is not well-formed XML: {error}"))
        })?;
        Ok(Document { tree, file, line_ends: OnceCell::new() })
    }

    /// Returns the root element.
    ///
    /// # Errors
    /// It has another name.
    pub fn root(&'a self, name: &str) -> Result<Element<'a>> {
        let root = self.any_root();
        if root.name() != name {
            return Err(root.problem(format!("the root element must be <{name}>")).into());
        }
        Ok(root)
    }

    /// Returns the root element, whatever its name.
    pub fn any_root(&'a self) -> Element<'a> {
        Element { node: self.tree.root_element(), document: self }
    }

    /// Returns the name that [`Document::parse`] was given.
    pub fn file(&self) -> &'a Path {
        self.file
    }

    /// Returns the line, from 1, in which a byte of the text is.
    pub fn line(&self, offset: usize) -> u32 {
        let text = self.tree.input_text();
        let line_ends = self.line_ends.get_or_init(|| text.match_indices('\n').map(|(end, _)| end).collect());
        let before = line_ends.partition_point(|&end| end < offset);
        u32::try_from(before + 1).unwrap_or(u32::MAX)
    }
}

/// An element of a document. Its name is the local one; attributes are found by names without a prefix.
#[derive(Clone, Copy)]
pub struct Element<'a> {
    node: Node<'a, 'a>,
    document: &'a Document<'a>,
}

impl<'a> Element<'a> {
    /// Returns its name without the prefix.
    pub fn name(self) -> &'a str {
        self.node.tag_name().name()
    }

    /// Returns its namespace; `None` if it is in none.
    pub fn namespace(self) -> Option<&'a str> {
        self.node.tag_name().namespace()
    }

    /// Returns the document that it is in.
    pub fn document(self) -> &'a Document<'a> {
        self.document
    }

    /// Returns the name of the document's file.
    pub fn file(self) -> &'a Path {
        self.document.file()
    }

    /// Returns where it begins in the document's text \[byte\]; no other element begins there.
    pub fn offset(self) -> usize {
        self.node.range().start
    }

    /// Returns the line in which it begins, from 1.
    pub fn line(self) -> u32 {
        self.document.line(self.offset())
    }

    /// Returns the elements in it.
    pub fn elements(self) -> impl Iterator<Item = Element<'a>> {
        let elements = self.node.children().filter(Node::is_element);
        elements.map(move |node| Element { node, ..self })
    }

    /// Returns the elements in it that have this name.
    pub fn children(self, name: &str) -> impl Iterator<Item = Element<'a>> {
        self.elements().filter(move |element| element.name() == name)
    }

    /// Returns the first element in it that has this name.
    pub fn child(self, name: &str) -> Option<Element<'a>> {
        self.children(name).next()
    }

    /// Returns the texts in it, each with the place where it begins \[byte\]; comments and elements are between them.
    pub fn texts(self) -> impl Iterator<Item = (&'a str, usize)> {
        self.node.children().filter(Node::is_text).filter_map(|node| Some((node.text()?, node.range().start)))
    }

    /// Returns its attributes, without the declarations of namespaces.
    pub fn attributes(self) -> impl Iterator<Item = Attribute<'a, 'a>> {
        self.node.attributes()
    }

    /// Returns whether it has an attribute of this name.
    pub fn has(self, attribute: &str) -> bool {
        self.node.has_attribute(attribute)
    }

    /// Returns the value of an attribute; `None` if there is none.
    pub fn optional(self, attribute: &str) -> Option<&'a str> {
        self.node.attribute(attribute)
    }

    /// Returns the value of an attribute.
    ///
    /// # Errors
    /// There is no such attribute.
    pub fn text(self, attribute: &str) -> Result<&'a str> {
        self.optional(attribute).ok_or_else(|| self.problem(format!("has no {attribute}")).into())
    }

    /// Returns the value of an attribute, read as a type that `what` describes; `None` if there is no such attribute.
    ///
    /// # Errors
    /// It is not of the type.
    pub fn parsed<T: FromStr>(self, attribute: &str, what: &str) -> Result<Option<T>> {
        let Some(text) = self.optional(attribute) else { return Ok(None) };
        let value = text.trim().parse().map_err(|_| self.wrong(attribute, format!("must be {what}")))?;
        Ok(Some(value))
    }

    /// Reads a finite number; `None` if there is no such attribute.
    ///
    /// # Errors
    /// It is not a finite number.
    pub fn number(self, attribute: &str) -> Result<Option<f64>> {
        match self.parsed(attribute, "a number")? {
            Some(value) if !f64::is_finite(value) => Err(self.wrong(attribute, "must be finite").into()),
            value => Ok(value),
        }
    }

    /// Reads XML Schema's booleans; `None` if there is no such attribute.
    ///
    /// # Errors
    /// It is neither true nor false.
    pub fn boolean(self, attribute: &str) -> Result<Option<bool>> {
        match self.optional(attribute).map(str::trim) {
            None => Ok(None),
            Some("true" | "1") => Ok(Some(true)),
            Some("false" | "0") => Ok(Some(false)),
            Some(_) => Err(self.wrong(attribute, "must be true or false").into()),
        }
    }

    /// Makes an error about the element.
    pub fn problem(self, message: impl Into<Message>) -> Problem {
        Problem {
            element: Some(self.name().into()),
            ..Problem::of_file(self.file(), Some(self.line()), message)
        }
    }

    /// Makes an error about an attribute, there or missing.
    pub fn wrong(self, attribute: &str, message: impl Into<Message>) -> Problem {
        let there = self.node.attribute_node(attribute);
        Problem {
            line: Some(there.map_or(self.line(), |there| self.document.line(there.range().start))),
            attribute: Some(attribute.into()),
            value: there.map(|there| there.value().into()),
            ..self.problem(message)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(bytes: &[u8]) -> String {
        let read = Document::parse(Path::new("f.xml"), bytes, 5);
        let name = read.and_then(|document| document.root("A").map(|root| root.name().to_owned()));
        name.unwrap_or_else(|problem| problem.to_string())
    }

    #[test]
    fn what_is_no_document_is_refused_with_its_line() {
        for (text, expected) in [
            ("\u{feff}<?xml version='1.0'?>\n<A/>", "A"),
            ("<A><b/><b/><b/></A>", "A"),
            ("<B/>", "f.xml:1: <B>: the root element must be <A>"),
            (
                "\n<!DOCTYPE A [<!ENTITY e 'e'>]><A>&e;</A>",
                "f.xml:2: <!DOCTYPE>: document types are not allowed",
            ),
            ("<A>\n\n</B>", "f.xml:3: is not well-formed XML: "),
            ("", "f.xml:1: is not well-formed XML: "),
            ("<A/>\n&e;", "f.xml:2: is not well-formed XML: "),
        ] {
            assert!(message(text.as_bytes()).starts_with(expected), "{text}: {}", message(text.as_bytes()));
        }
        assert_eq!(message(b"<A>\n\xff</A>"), "f.xml:2: is not UTF-8 text");
        assert!(message(b"<A><b/><b/><b/><b/></A>").contains("limit"));
    }

    const TEXT: &str =
        "<A xmlns:o='other'>\n <B x=' 2 ' o:x='5'\n  y='inf' z='yes'/>text<!-- -->s\n <C/><B t='0'/>\n</A>";

    #[test]
    fn what_is_wrong_has_the_line_of_its_attribute() {
        let document = Document::parse(Path::new("f.xml"), TEXT.as_bytes(), u32::MAX).unwrap();
        let root = document.root("A").unwrap();
        let b = root.child("B").unwrap();
        assert_eq!((root.line(), b.line(), root.child("C").unwrap().line()), (1, 2, 4));
        assert_eq!(
            (b.number("x"), b.number("none"), b.optional("x")),
            (Ok(Some(2.0)), Ok(None), Some(" 2 "))
        );
        let message = |result: Result<Option<f64>>| result.unwrap_err().to_string();
        assert_eq!(message(b.number("y")), "f.xml:3: <B> y=\"inf\": must be finite");
        assert_eq!(message(b.number("z")), "f.xml:3: <B> z=\"yes\": must be a number");
        assert_eq!(b.text("none").unwrap_err().to_string(), "f.xml:2: <B>: has no none");
        assert_eq!(b.wrong("none", "is missing").to_string(), "f.xml:2: <B> none: is missing");
        assert_eq!(b.boolean("z").unwrap_err().to_string(), "f.xml:3: <B> z=\"yes\": must be true or false");
        assert_eq!(root.children("B").nth(1).unwrap().boolean("t"), Ok(Some(false)));
        let names: Vec<_> =
            b.attributes().map(|attribute| (attribute.name(), attribute.namespace())).collect();
        assert_eq!(names, [("x", None), ("x", Some("other")), ("y", None), ("z", None)]);
    }

    #[test]
    fn texts_have_their_lines() {
        let document = Document::parse(Path::new(""), TEXT.as_bytes(), u32::MAX).unwrap();
        let texts = document.any_root().texts().filter(|(text, _)| !text.trim().is_empty());
        let texts: Vec<_> = texts.map(|(text, at)| (text.trim(), document.line(at))).collect();
        assert_eq!(texts, [("text", 3), ("s", 3)]);
    }
}
