//! A document that is written.

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, BytesText, Event};
use std::borrow::Cow;

/// `[("Id", …)]`; values are escaped.
pub type Attributes<'a> = &'a [(&'a str, &'a str)];

/// A text for what is put together by hand: markup is escaped.
pub fn escaped(text: &str) -> Cow<'_, str> {
    quick_xml::escape::escape(text)
}

/// Looks of documents of one kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    /// Name of the encoding, as the declaration spells it; the text is UTF-8.
    pub encoding: &'static str,
    /// Spaces before each level.
    pub indent: usize,
}

impl Layout {
    /// Layout of the paper's files.
    pub const PAPER: Layout = Layout { encoding: "utf-8", indent: 4 };
    /// Layout of the standards' files (FMI, SSP).
    pub const STANDARD: Layout = Layout { encoding: "UTF-8", indent: 2 };
}

/// A document that is being written. It is written into memory, which cannot fail: hence the dropped results.
pub struct XmlWriter(Writer<Vec<u8>>);

impl XmlWriter {
    /// A whole document, with a line end after it.
    pub fn document(
        layout: Layout,
        root: &str,
        attributes: Attributes<'_>,
        content: impl FnOnce(&mut XmlWriter),
    ) -> String {
        let mut out = XmlWriter(Writer::new_with_indent(Vec::new(), b' ', layout.indent));
        out.event(Event::Decl(BytesDecl::new("1.0", Some(layout.encoding), None)));
        out.element(root, attributes, content);
        let mut text = out.0.into_inner();
        text.push(b'\n');
        String::from_utf8(text).unwrap_or_default()
    }

    /// An element with what `content` writes in it.
    pub fn element(&mut self, name: &str, attributes: Attributes<'_>, content: impl FnOnce(&mut XmlWriter)) {
        self.event(Event::Start(start(name, attributes)));
        content(self);
        self.event(Event::End(BytesEnd::new(name)));
    }

    /// An element with nothing in it.
    pub fn empty(&mut self, name: &str, attributes: Attributes<'_>) {
        self.event(Event::Empty(start(name, attributes)));
    }

    /// An element with text in it, which is escaped.
    pub fn text(&mut self, name: &str, text: &str) {
        self.element(name, &[], |out| out.event(Event::Text(BytesText::new(text))));
    }

    fn event(&mut self, event: Event<'_>) {
        let _ = self.0.write_event(event);
    }
}

fn start<'a>(name: &'a str, attributes: Attributes<'a>) -> BytesStart<'a> {
    BytesStart::new(name).with_attributes(attributes.iter().copied())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_indented_and_escaped() {
        let write = |layout| {
            XmlWriter::document(layout, "A", &[("a", "<\"&'>")], |out| {
                out.element("B", &[], |out| out.empty("C", &[("x", "1"), ("y", "2")]));
                out.text("D", "<a & b>");
            })
        };
        assert_eq!(
            write(Layout::STANDARD),
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<A a=\"&lt;&quot;&amp;&apos;&gt;\">\n  <B>\n    \
             <C x=\"1\" y=\"2\"/>\n  </B>\n  <D>&lt;a &amp; b&gt;</D>\n</A>\n"
        );
        let paper = write(Layout::PAPER);
        assert!(paper.starts_with("<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<A"), "{paper}");
        assert!(paper.contains("\n    <B>\n        <C "), "{paper}");
    }
}
