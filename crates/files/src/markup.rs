//! What an XML text may hold. Parsers compare each attribute with all others of its element, and copy the namespaces
//! that are in scope: a file of many takes them quadratic time. Here they are counted in one pass, before.

use thiserror::Error;

/// Attributes of one element at most; those that are read have some ten.
pub const MOST_ATTRIBUTES: usize = 256;
/// Declarations of namespaces (`xmlns`, `xmlns:…`) at most that hold at one place.
pub const MOST_NAMESPACES: usize = 256;

/// Why a text is not handed to a parser.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("<{element}>: {what}")]
pub struct Refused {
    /// Of the element, counted from 1.
    pub line: u32,
    /// Its name, perhaps cut.
    pub element: String,
    /// What is wrong with it.
    pub what: String,
}

/// Refuses a text that takes a parser more than linear time.
///
/// # Errors
/// The first element that has too many attributes, or in which too many namespaces are declared; a document type.
pub fn check(text: &str) -> Result<(), Refused> {
    let mut depth = 0_usize;
    // Depth and count of the elements around that declare any.
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
            Err(Refused { line: u32::try_from(line).unwrap_or(u32::MAX), element, what })
        };
        if rest.starts_with("<!") {
            // Its entities may hold elements.
            return refused("!DOCTYPE".into(), "no document type is taken".into());
        }
        let tag = tag(text, begin);
        at = tag.end;
        if rest.starts_with("</") {
            declared.pop_if(|(at, _)| *at == depth);
            depth = depth.saturating_sub(1);
            continue;
        }
        let too_many = |what: String| {
            let name = rest[1..].split(|c: char| c.is_ascii_whitespace() || "/>=\"'".contains(c));
            refused(name.take(1).flat_map(|name| name.chars().take(80)).collect(), what)
        };
        if tag.attributes > MOST_ATTRIBUTES {
            return too_many(format!("has {} attributes; the most is {MOST_ATTRIBUTES}", tag.attributes));
        }
        let namespaces = tag.namespaces + declared.iter().map(|(_, count)| count).sum::<usize>();
        if namespaces > MOST_NAMESPACES {
            return too_many(format!(
                "{namespaces} namespaces are declared in it and around it; the most is {MOST_NAMESPACES}"
            ));
        }
        if !tag.empty {
            depth += 1;
            if tag.namespaces > 0 {
                declared.push((depth, tag.namespaces));
            }
        }
    }
    Ok(())
}

struct Tag {
    /// Behind it.
    end: usize,
    attributes: usize,
    /// Of them, those that declare one.
    namespaces: usize,
    empty: bool,
}

/// The tag whose `<` stands at `begin`. Each attribute has one `=` outside of quotes. A tag that does not end is counted
/// to the end of the text: a parser reads as far.
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

    fn element(attributes: usize, prefix: &str) -> String {
        let all: String = (0..attributes).map(|k| format!(" {prefix}a{k} = '='")).collect();
        format!("<A{all}")
    }

    #[test]
    fn attributes_are_counted_where_a_parser_sees_them() {
        let many = element(300_000, "");
        let hidden = format!("<R x='<' y=\"'\"><!-- {many}> --><![CDATA[{many}>]]><?p {many}?>{many}</R>");
        let without = hidden.replace(&format!("?>{many}"), "?>");
        assert_eq!(check(&without), Ok(()));
        let said = "<A>: has 300000 attributes; the most is 256";
        for text in [&hidden, &many, &format!("{many}/>"), &format!("\n\n{many}>")] {
            let line = 1 + text.bytes().filter(|&byte| byte == b'\n').count();
            let refused = check(text).unwrap_err();
            assert_eq!((refused.to_string().as_str(), refused.line as usize), (said, line));
        }
        assert_eq!(check(&format!("{}/>", element(MOST_ATTRIBUTES, ""))), Ok(()));
        assert!(check(&format!("{}/>", element(MOST_ATTRIBUTES + 1, ""))).is_err());
        let entity = format!("<?xml version='1.0'?>\n<!DOCTYPE A [<!ENTITY e '{many}/>'>]><A>&e;</A>");
        let refused = check(&entity).unwrap_err();
        assert_eq!(
            (refused.to_string().as_str(), refused.line),
            ("<!DOCTYPE>: no document type is taken", 2)
        );
    }

    #[test]
    fn namespaces_are_counted_as_far_as_they_hold() {
        let beside: String = (0..1000).map(|k| format!("<A xmlns:a{k}=''><B/></A><A xmlns=''/>")).collect();
        assert_eq!(check(&format!("<R>{beside}</R>")), Ok(()));
        let nested = format!("{}>", element(100, "xmlns:")).repeat(3000);
        let said = "<A>: 300 namespaces are declared in it and around it; the most is 256";
        assert_eq!(check(&nested).unwrap_err().to_string(), said);
    }
}
