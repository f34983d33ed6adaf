//! A report as PDF: its blocks on A4 pages.

use crate::{Block, Report, Section};
use lemons_core::message::Message;
use lemons_picture::{A4, PdfPage, PdfText, PictureError, document, text_width};

/// \[pt\] Margins at the sides, above and below.
const MARGIN: f32 = 48.0;
const TOP: f32 = 52.0;
const BOTTOM: f32 = 56.0;
const WIDTH: f32 = A4[0] - 2.0 * MARGIN;
/// \[pt\] Size of text, and of what is in tables and below pictures.
const SIZE: f32 = 9.5;
const SMALL: f32 = 8.0;
/// Distance of lines over the size.
const LEAD: f32 = 1.35;
/// \[pt\] Between columns, and above and below a row.
const GAP: f32 = 10.0;
const PAD: f32 = 3.0;
/// \[pt\] Tallest picture.
const TALLEST: f32 = 285.0;
/// \[pt\] Between a picture and its caption.
const BELOW: f32 = 6.0;

/// Returns the report as PDF of A4 pages. Not divided are pictures with their captions, and rows that are not
/// taller than a page.
///
/// # Errors
/// A picture cannot be drawn.
pub fn pdf(report: &Report) -> Result<Vec<u8>, PictureError> {
    let mut out = Layout { pages: vec![PdfPage::default()], y: TOP };
    out.text(&report.title, [MARGIN, WIDTH], 20.0, Face::Bold);
    out.y += 6.0;
    for notice in &report.notices {
        out.text(notice, [MARGIN, WIDTH], SIZE, Face::Bold);
        out.y += 3.0;
    }
    for Section { heading, blocks } in &report.sections {
        out.y += 16.0;
        // Not alone at the end of a page.
        let first = match blocks.first() {
            Some(Block::Picture { caption, svg }) => sizes(caption, svg).1 + 30.0,
            _ => 110.0,
        };
        out.room(first);
        out.text(heading, [MARGIN, WIDTH], 13.0, Face::Bold);
        out.rule(2.0);
        out.y += 8.0;
        blocks.iter().for_each(|block| out.block(block));
    }
    let count = out.pages.len();
    for (k, page) in out.pages.iter_mut().enumerate() {
        let text = format!("{} – {} / {count}", report.title, k + 1);
        page.texts.push(PdfText {
            at: [MARGIN, A4[1] - 30.0],
            size: SMALL,
            soft: true,
            text,
            ..PdfText::default()
        });
    }
    document(&report.title, &out.pages)
}

#[derive(Clone, Copy, PartialEq)]
enum Face {
    Plain,
    Soft,
    Bold,
}

/// Pages that are being filled.
struct Layout {
    pages: Vec<PdfPage>,
    /// \[pt\] Upper end of what comes next.
    y: f32,
}

impl Layout {
    fn page(&mut self) -> &mut PdfPage {
        self.pages.last_mut().expect("there is one from the beginning")
    }

    /// Begins a page if there is not so much room. Returns whether it did.
    fn room(&mut self, height: f32) -> bool {
        let full = self.y + height > A4[1] - BOTTOM && self.y > TOP;
        if full {
            self.pages.push(PdfPage::default());
            self.y = TOP;
        }
        full
    }

    fn rule(&mut self, below: f32) {
        let y = self.y + below;
        self.page().lines.push([MARGIN, y, A4[0] - MARGIN]);
    }

    /// Writes a line whose upper end is at a height.
    fn line(&mut self, [x, top]: [f32; 2], size: f32, face: Face, text: String) {
        let (bold, soft) = (face == Face::Bold, face == Face::Soft);
        self.page().texts.push(PdfText { at: [x, top + size], size, bold, soft, text });
    }

    fn text(&mut self, text: &str, [left, width]: [f32; 2], size: f32, face: Face) {
        for line in wrapped(text, width, size, face == Face::Bold) {
            self.room(size * LEAD);
            self.line([left, self.y], size, face, line);
            self.y += size * LEAD;
        }
    }

    fn block(&mut self, block: &Block) {
        match block {
            Block::Text { text } => self.text(text, [MARGIN, WIDTH], SIZE, Face::Plain),
            Block::List { items } => {
                for item in items {
                    let lines = wrapped(item, WIDTH - 12.0, SIZE, false).len() as f32;
                    self.room(lines * SIZE * LEAD);
                    self.line([MARGIN, self.y], SIZE, Face::Plain, "•".to_owned());
                    self.text(item, [MARGIN + 12.0, WIDTH - 12.0], SIZE, Face::Plain);
                    self.y += 2.0;
                }
            }
            Block::Table { caption, head, rows, numbers } => self.table(caption, head, rows, numbers),
            Block::Picture { caption, svg } => self.picture(caption, svg),
        }
        self.y += 8.0;
    }

    fn picture(&mut self, caption: &Message, svg: &str) {
        let ([width, height], whole) = sizes(caption, svg);
        self.room(whole);
        let top = self.y;
        self.page().pictures.push(([MARGIN, top, width], svg.to_owned()));
        self.y += height + BELOW;
        self.text(caption, [MARGIN, WIDTH], SMALL, Face::Soft);
    }

    fn table(&mut self, caption: &Message, head: &[Message], rows: &[Vec<Message>], numbers: &[bool]) {
        self.room(6.0 * SMALL * LEAD);
        self.text(caption, [MARGIN, WIDTH], SMALL, Face::Soft);
        let widths = widths(head, rows, numbers);
        let mut heads = (!head.is_empty()).then_some(head);
        let cells = |row: &[Message], bold: bool| -> Vec<Vec<String>> {
            row.iter().zip(&widths).map(|(cell, width)| wrapped(cell, *width, SMALL, bold)).collect()
        };
        let lines = |cells: &[Vec<String>]| cells.iter().map(Vec::len).max().unwrap_or(1);
        let height = |cells: &[Vec<String>]| lines(cells) as f32 * SMALL * LEAD + 2.0 * PAD;
        let page = A4[1] - TOP - BOTTOM - heads.map_or(0.0, |head| height(&cells(head, true)));
        // A row that is taller than a page goes on on the next one.
        let most = ((page - 2.0 * PAD) / (SMALL * LEAD)).max(1.0) as usize;
        let parts = rows.iter().map(|row| cells(row, false)).flat_map(|whole| {
            let part = |cell: &Vec<String>, k| cell.chunks(most).nth(k).unwrap_or_default().to_vec();
            let all = 0..lines(&whole).div_ceil(most);
            all.map(|k| whole.iter().map(|cell| part(cell, k)).collect()).collect::<Vec<Vec<_>>>()
        });
        for own in parts {
            let above = heads.map(|head| cells(head, true));
            let needed = height(&own) + above.as_ref().map_or(0.0, |cells| height(cells));
            if self.room(needed) {
                heads = (!head.is_empty()).then_some(head);
            }
            let above = heads.take().map(|head| (cells(head, true), Face::Bold));
            for (cells, face) in above.into_iter().chain([(own, Face::Plain)]) {
                let mut x = MARGIN;
                for (k, lines) in cells.iter().enumerate() {
                    for (n, line) in lines.iter().enumerate() {
                        let bold = face == Face::Bold;
                        let free = if numbers[k] { widths[k] - text_width(line, SMALL, bold) } else { 0.0 };
                        let top = self.y + PAD + n as f32 * SMALL * LEAD;
                        self.line([x + free.max(0.0), top], SMALL, face, line.clone());
                    }
                    x += widths[k] + GAP;
                }
                self.y += height(&cells);
                self.rule(0.0);
            }
        }
    }
}

/// Returns width and height of a picture on the page, and the height with its caption \[pt\].
fn sizes(caption: &Message, svg: &str) -> ([f32; 2], f32) {
    let side = |name: &str| -> Option<f32> {
        svg.split_once(name)?.1.split_once('"')?.0.parse().ok().filter(|side| *side > 0.0)
    };
    let aspect = side("height=\"").zip(side("width=\"")).map_or(1.0, |(height, width)| height / width);
    let width = WIDTH.min(TALLEST / aspect);
    let below = wrapped(caption, WIDTH, SMALL, false).len() as f32 * SMALL * LEAD;
    ([width, width * aspect], width * aspect + BELOW + below)
}

/// Returns the widths of columns \[pt\]: as wide as what is in them, or the wider ones narrower if that is too much.
fn widths(head: &[Message], rows: &[Vec<Message>], numbers: &[bool]) -> Vec<f32> {
    let of = |head_width: &dyn Fn(&str) -> f32| -> Vec<f32> {
        let column = |k: usize| {
            let own = rows.iter().map(|row| text_width(&row[k], SMALL, false)).fold(0.0, f32::max);
            own.max(head.get(k).map_or(0.0, |head| head_width(head))) + 0.5
        };
        (0..numbers.len()).map(column).collect()
    };
    let room = WIDTH - GAP * (numbers.len().max(1) - 1) as f32;
    let mut widths = of(&|head| text_width(head, SMALL, true));
    // Headings are divided first.
    if widths.iter().sum::<f32>() > room {
        widths = of(&|head| head.split(' ').map(|word| text_width(word, SMALL, true)).fold(0.0, f32::max));
    }
    // The widest gives away until all fit.
    while widths.iter().sum::<f32>() > room {
        let over = widths.iter().sum::<f32>() - room;
        let texts = || (0..numbers.len()).filter(|k| !numbers[*k] && widths[*k] > 40.0);
        let all = || 0..numbers.len();
        let by = |a: &usize, b: &usize| widths[*a].total_cmp(&widths[*b]);
        let Some(widest) = texts().max_by(by).or_else(|| all().max_by(by)) else { break };
        widths[widest] -= over.min((widths[widest] * 0.05).max(1.0));
    }
    // A table of names and values is as wide as the page.
    if head.is_empty() && widths.len() == 2 {
        widths[0] = widths[0].clamp(0.3 * WIDTH, 0.45 * WIDTH);
        widths[1] = room - widths[0];
    }
    widths
}

/// Returns a text in lines of a width \[pt\].
fn wrapped(text: &str, width: f32, size: f32, bold: bool) -> Vec<String> {
    let fits = |line: &str| text_width(line, size, bold) <= width;
    let (mut lines, mut line) = (Vec::new(), String::new());
    for word in text.split(' ') {
        let longer = if line.is_empty() { word.to_owned() } else { format!("{line} {word}") };
        if fits(&longer) {
            line = longer;
            continue;
        }
        if !line.is_empty() {
            lines.push(std::mem::take(&mut line));
        }
        // A word that is too long is cut.
        for c in word.chars() {
            line.push(c);
            if !fits(&line) && line.chars().count() > 1 {
                line.pop();
                lines.push(std::mem::replace(&mut line, c.to_string()));
            }
        }
    }
    lines.push(line);
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The outside: the words in their order, and the margins of A4.
    #[test]
    fn a_row_that_is_taller_than_a_page_goes_on_on_the_next_one() {
        let words: Vec<String> = (0..6000).map(|k| format!("w{k}")).collect();
        for head in [vec![], vec!["name".into(), "value".into()]] {
            let mut out = Layout { pages: vec![PdfPage::default()], y: TOP };
            let row = |text: &str| vec!["a".into(), text.into()];
            out.table(
                &"caption".into(),
                &head,
                &[row("before"), row(&words.join(" ")), row("after")],
                &[false; 2],
            );
            let texts = || out.pages.iter().flat_map(|page| &page.texts);
            assert!(out.pages.len() > 2 && texts().all(|text| text.at[1] <= A4[1] - BOTTOM));
            let shown = texts()
                .flat_map(|text| text.text.split(' '))
                .filter(|word| words.iter().any(|own| own == word));
            assert!(shown.eq(&words));
            let heads = texts().filter(|text| text.text == "name").count();
            assert_eq!(heads, if head.is_empty() { 0 } else { out.pages.len() });
        }
    }
}
