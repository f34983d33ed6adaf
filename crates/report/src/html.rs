//! A report as HTML: one file, without scripts.

use crate::{Block, Report, Section};
use lemons_core::message::Message;
use lemons_core::xml;

const STYLE: &str = include_str!("report.css");

/// Returns the report as a page that needs no other file.
pub fn html(report: &Report) -> String {
    let title = escaped(&report.title);
    let mut out = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <meta name=\"generator\" content=\"LEMONS\"/>\n<title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <main>\n<h1>{title}</h1>\n"
    );
    for notice in &report.notices {
        out += &format!("<p class=\"notice\">{}</p>\n", escaped(notice));
    }
    for Section { heading, blocks } in &report.sections {
        out += &format!("<section>\n<h2>{}</h2>\n", escaped(heading));
        blocks.iter().for_each(|of| block(&mut out, of));
        out += "</section>\n";
    }
    out + "</main>\n</body>\n</html>\n"
}

fn block(out: &mut String, block: &Block) {
    match block {
        Block::Text { text } => *out += &format!("<p>{}</p>\n", escaped(text)),
        Block::List { items } => {
            *out += "<ul>\n";
            items.iter().for_each(|item| *out += &format!("<li>{}</li>\n", escaped(item)));
            *out += "</ul>\n";
        }
        Block::Table { caption, head, rows, numbers } => {
            let facts = if head.is_empty() { " class=\"facts\"" } else { "" };
            *out += &format!("<table{facts}>\n<caption>{}</caption>\n", escaped(caption));
            let mut row = |cells: &[Message], heads: bool| {
                *out += "<tr>";
                for (k, cell) in cells.iter().enumerate() {
                    let class = if numbers[k] { " class=\"number\"" } else { "" };
                    let (begin, end) = match (heads, k) {
                        (true, _) => ("th scope=\"col\"", "th"),
                        (false, 0) => ("th scope=\"row\"", "th"),
                        _ => ("td", "td"),
                    };
                    *out += &format!("<{begin}{class}>{}</{end}>", escaped(cell));
                }
                *out += "</tr>\n";
            };
            if !head.is_empty() {
                row(head, true);
            }
            rows.iter().for_each(|cells| row(cells, false));
            *out += "</table>\n";
        }
        Block::Picture { caption, svg } => {
            let (caption, address) = (escaped(caption), address(svg));
            *out += &format!(
                "<figure>\n<img alt=\"{caption}\" src=\"{address}\"/>\n<figcaption>{caption}</figcaption>\n</figure>\n"
            );
        }
    }
}

/// Returns the address of a picture within the page. So Ids of pictures are apart.
fn address(svg: &str) -> String {
    format!("data:image/svg+xml;charset=utf-8,{}", escaped(&svg.replace('%', "%25").replace('#', "%23")))
}

/// Returns a text in which nothing is markup, or turns the direction of what follows.
fn escaped(text: &str) -> String {
    let turns = |c: char| matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    xml::escaped(&text.replace(|c: char| c.is_control() || turns(c), " ")).into_owned()
}
