//! Limits for XML texts. Parsers compare each attribute with all others of its element, and copy the namespaces in
//! scope: many of them take quadratic time. Here they are counted in one pass before parsing.

use crate::xml::problem::{Problem, Result};
use std::path::Path;

/// Largest number of attributes of one element. Elements that we read have about ten.
pub const MOST_ATTRIBUTES: usize = 256;
/// Largest number of namespace declarations (`xmlns`, `xmlns:…`) in scope at one place.
pub const MOST_NAMESPACES: usize = 256;

/// Refuses a text that would take a parser more than linear time.
///
/// # Errors
/// The first element with too many attributes or namespace declarations in scope; a document type.
pub(crate) fn check(file: &Path, text: &str) -> Result<()> {
    let mut depth = 0_usize;
    // Depth and number of declarations of the enclosing elements that have any.
    let mut declared: Vec<(usize, usize)> = Vec::new();
    let mut at = 0;
    while let Some(begin) = text[at..].find('<').map(|found| at + found) {
        let rest = &text[begin..];
        let skipped = [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>")];
        if let Some((open, close)) = skipped.iter().find(|(open, _)| rest.starts_with(open)) {
            let Some(end) = rest[open.len()..].find(close) else { break };
            at = begin + open.len() + end + close.len();
            continue;
        }
        let refused = |element: String, what: String| {
            let line = 1 + text[..begin].bytes().filter(|&byte| byte == b'\n').count();
            let problem = Problem::of_file(file, u32::try_from(line).ok(), what);
            Err(Problem { element: Some(element), ..problem }.into())
        };
        if rest.starts_with("<!") {
            // A document type may define entities that contain elements.
            return refused("!DOCTYPE".into(), "document types are not allowed".into());
        }
        let tag = tag(text, begin);
        at = tag.end;
        if rest.starts_with("</") {
            declared.pop_if(|(at, _)| *at == depth);
            depth = depth.saturating_sub(1);
            continue;
        }
        let namespaces = tag.namespaces + declared.iter().map(|(_, count)| count).sum::<usize>();
        let too_many = if tag.attributes > MOST_ATTRIBUTES {
            format!("has {} attributes; at most {MOST_ATTRIBUTES} are allowed", tag.attributes)
        } else if namespaces > MOST_NAMESPACES {
            format!("{namespaces} namespaces are in scope; at most {MOST_NAMESPACES} are allowed")
        } else {
            if !tag.empty {
                depth += 1;
                declared.extend((tag.namespaces > 0).then_some((depth, tag.namespaces)));
            }
            continue;
        };
        let name = rest[1..].split(|c: char| c.is_ascii_whitespace() || "/>=\"'".contains(c)).next();
        return refused(name.unwrap_or_default().chars().take(80).collect(), too_many);
    }
    Ok(())
}

struct Tag {
    /// Position after the tag.
    end: usize,
    attributes: usize,
    /// Number of attributes that declare a namespace.
    namespaces: usize,
    empty: bool,
}

/// Reads the tag whose `<` is at `begin`. Each attribute has one `=` outside of quotes. A tag that does not end is
/// counted to the end of the text, because a parser reads that far.
fn tag(text: &str, begin: usize) -> Tag {
    let bytes = text.as_bytes();
    let mut tag = Tag { end: bytes.len(), attributes: 0, namespaces: 0, empty: false };
    let mut quote = None;
    for (place, &byte) in bytes.iter().enumerate().skip(begin + 1) {
        match (quote, byte) {
            (Some(end), _) if byte == end => quote = None,
            (Some(_), _) => {}
            (None, b'"' | b'\'') => quote = Some(byte),
            (None, b'=') => {
                let before = text[begin..place].trim_end();
                let name = before.rsplit(|c: char| c.is_ascii_whitespace() || "=\"'".contains(c)).next();
                tag.attributes += 1;
                tag.namespaces += usize::from(name.is_some_and(|name| name.starts_with("xmlns")));
            }
            (None, b'>') => return Tag { end: place + 1, empty: bytes[place - 1] == b'/', ..tag },
            _ => {}
        }
    }
    tag
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(text: &str) -> String {
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
        assert_eq!(said(&without), "");
        for text in [&hidden, &many, &format!("{many}/>"), &format!("\n\n{many}>")] {
            let line = 1 + text.bytes().filter(|&byte| byte == b'\n').count();
            let expected = format!("line {line}: <A>: has 300000 attributes; at most 256 are allowed");
            assert_eq!(said(text), expected);
        }
        assert_eq!(said(&format!("{}/>", element(MOST_ATTRIBUTES, ""))), "");
        assert_ne!(said(&format!("{}/>", element(MOST_ATTRIBUTES + 1, ""))), "");
        let entity = format!("<?xml version='1.0'?>\n<!DOCTYPE A [<!ENTITY e '{many}/>'>]><A>&e;</A>");
        assert_eq!(said(&entity), "line 2: <!DOCTYPE>: document types are not allowed");
    }

    #[test]
    fn namespaces_are_counted_as_far_as_they_hold() {
        let beside: String = (0..1000).map(|k| format!("<A xmlns:a{k}=''><B/></A><A xmlns=''/>")).collect();
        assert_eq!(said(&format!("<R>{beside}</R>")), "");
        let nested = format!("{}>", element(100, "xmlns:")).repeat(3000);
        assert_eq!(said(&nested), "line 1: <A>: 300 namespaces are in scope; at most 256 are allowed");
    }
}
