//! XML, read and written: the one place that parses it.
//!
//! - [`Document`]: a text from outside, parsed safely: UTF-8, no document type, so many attributes, namespaces and nodes
//! - [`Element`]: what is in it, with line numbers
//! - [`Problem`]: what is wrong, with file, line, element, attribute and value, on one line of text
//! - [`XmlWriter`]: a document that is written; [`decimal`], [`number`]: numbers read and written
//!
//! A reader that stops at the first problem returns it ([`Result`]); one that collects all of them pushes each.

mod check;
mod document;
mod number;
mod problem;
mod write;

pub use check::{MOST_ATTRIBUTES, MOST_NAMESPACES};
pub use document::{Document, Element};
pub use number::{decimal, number};
pub use problem::{Problem, Result, quoted};
pub use write::{Attributes, Layout, XmlWriter, escaped};
