//! A report as HTML: one file, without scripts.

use crate::{Block, Report, Section};
use lemons_core::message::Message;
use std::fmt::Write;

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
            let cell = |k: usize, cell: &Message, heading: &str| {
                let class = if numbers[k] { " class=\"number\"" } else { "" };
                let (name, scope) = if heading.is_empty() { ("td", "") } else { ("th", heading) };
                format!("<{name}{scope}{class}>{}</{name}>", escaped(cell))
            };
            let mut row = |cells: &[Message], heads: bool| {
                *out += "<tr>";
                for (k, of) in cells.iter().enumerate() {
                    let heading = if heads {
                        " scope=\"col\""
                    } else if k == 0 {
                        " scope=\"row\""
                    } else {
                        ""
                    };
                    *out += &cell(k, of, heading);
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
    let mut out = "data:image/svg+xml;charset=utf-8,".to_owned();
    for c in svg.chars() {
        match c {
            '"' => out.push('\''),
            '%' | '#' | '<' | '>' | '&' | '\'' | '{' | '}' | '|' | '\\' | '^' | '`' => {
                let _ = write!(out, "%{:02X}", c as u32);
            }
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

/// Returns a text in which nothing is markup.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            '\'' => out += "&#39;",
            '\n' | '\t' => out.push(' '),
            // Neither XML nor a reader knows others.
            c if c.is_control()
                || ('\u{202a}'..='\u{202e}').contains(&c)
                || c == '\u{fffe}'
                || c == '\u{ffff}' =>
            {
                out.push('\u{fffd}');
            }
            c => out.push(c),
        }
    }
    out
}
