//! Limits for XML texts. Parsers compare each attribute with all others of its element, and copy the namespaces in
//! scope: many of them take quadratic time. Here they are counted in one pass before parsing.

use crate::xml::problem::{Problem, Result};
use quick_xml::events::Event;
use quick_xml::reader::Reader;
use std::path::Path;

/// Largest number of attributes of one element. Elements that we read have about ten.
pub const MOST_ATTRIBUTES: usize = 256;
/// Largest number of namespace declarations (`xmlns`, `xmlns:…`) in scope at one place.
pub const MOST_NAMESPACES: usize = 256;

/// Refuses a text that would take a parser more than linear time.
///
/// # Errors
/// The first element with too many attributes or namespace declarations in scope; a document type; a text that cannot be
/// cut into tags.
pub(crate) fn check(file: &Path, text: &str) -> Result<()> {
    let at = |position: u64, message: String| {
        let before = text.bytes().take(usize::try_from(position).unwrap_or(usize::MAX));
        let line = 1 + before.filter(|&byte| byte == b'\n').count();
        Problem::of_file(file, u32::try_from(line).ok(), message)
    };
    let mut reader = Reader::from_str(text);
    // The parser says it better.
    reader.config_mut().check_end_names = false;
    reader.config_mut().allow_unmatched_ends = true;
    // Number of declarations in scope in each open element.
    let mut in_scope: Vec<usize> = Vec::new();
    loop {
        let begin = reader.buffer_position();
        let event = reader.read_event();
        let event =
            event.map_err(|error| at(reader.error_position(), format!("is not well-formed XML: {error}")))?;
        let (tag, message) = match &event {
            Event::Eof => return Ok(()),
            Event::End(_) => {
                in_scope.pop();
                continue;
            }
            Event::Start(tag) | Event::Empty(tag) => {
                let (mut attributes, mut namespaces) = (0, in_scope.last().copied().unwrap_or(0));
                // The parser stops at one that is malformed.
                for attribute in tag.attributes().with_checks(false).flatten() {
                    attributes += 1;
                    namespaces += usize::from(attribute.key.as_ref().starts_with("xmlns"));
                }
                if matches!(event, Event::Start(_)) {
                    in_scope.push(namespaces);
                }
                let message = if attributes > MOST_ATTRIBUTES {
                    format!("has {attributes} attributes; at most {MOST_ATTRIBUTES} are allowed")
                } else if namespaces > MOST_NAMESPACES {
                    format!("{namespaces} namespaces are in scope; at most {MOST_NAMESPACES} are allowed")
                } else {
                    continue;
                };
                (tag.name().as_ref().chars().take(80).collect(), message)
            }
            // It may define entities that contain elements.
            Event::DocType(_) => ("!DOCTYPE".to_owned(), "document types are not allowed".to_owned()),
            _ => continue,
        };
        return Err(Problem { element: Some(tag), ..at(begin, message) }.into());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(text: &str) -> String {
        check(Path::new(""), text).map_or_else(|problem| problem.to_string(), |()| String::new())
    }

    fn element(attributes: usize, prefix: &str) -> String {
        let all: String = (0..attributes).map(|k| format!(" {prefix}a{k} = '='")).collect();
        format!("<A{all}")
    }

    #[test]
    fn attributes_are_counted_where_a_parser_sees_them() {
        let many = element(300_000, "");
        let hidden = format!("<R x='<' y=\"'\"><!-- {many}> --><![CDATA[{many}>]]><?p {many}?>{many}</R>");
        let without = hidden.replace(&format!("?>{many}"), "?>");
        assert_eq!(message(&without), "");
        for text in [&hidden, &format!("{many}/>"), &format!("\n\n{many}>")] {
            let line = 1 + text.bytes().filter(|&byte| byte == b'\n').count();
            let expected = format!("line {line}: <A>: has 300000 attributes; at most 256 are allowed");
            assert_eq!(message(text), expected);
        }
        assert!(message(&many).starts_with("line 1: is not well-formed XML: "));
        assert_eq!(message(&format!("{}/>", element(MOST_ATTRIBUTES, ""))), "");
        assert_ne!(message(&format!("{}/>", element(MOST_ATTRIBUTES + 1, ""))), "");
        let entity = format!("<?xml version='1.0'?>\n<!DOCTYPE A [<!ENTITY e '{many}/>'>]><A>&e;</A>");
        assert_eq!(message(&entity), "line 2: <!DOCTYPE>: document types are not allowed");
    }

    #[test]
    fn namespaces_are_counted_as_far_as_they_hold() {
        let beside: String = (0..1000).map(|k| format!("<A xmlns:a{k}=''><B/></A><A xmlns=''/>")).collect();
        assert_eq!(message(&format!("<R>{beside}</R>")), "");
        let nested = format!("{}>", element(100, "xmlns:")).repeat(3000);
        assert_eq!(message(&nested), "line 1: <A>: 300 namespaces are in scope; at most 256 are allowed");
    }
}
