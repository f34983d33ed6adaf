//! FCD of SUMO: `<fcd-export>` with a `<timestep time>` for each frame, and in it each `<person id x y angle>`. Vehicles and
//! containers are no people.

use super::columns::from_north;
use super::text::LARGEST;
use super::timed::{Timed, excerpt};
use super::{Found, Told};
use crate::error::RecordError;
use lemons_core::files::input::Bounded;
use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

/// \[bytes\] The longest tag, text or comment. A comment at the begin has the options of the run.
const LONGEST: usize = 1 << 20;
/// The largest number of elements in each other; files of SUMO have three.
const DEEPEST: usize = 16;
/// Attributes of an element that are read.
type Attributes = [(&'static str, Option<String>); 4];

/// Reads so many bytes until it is told to go on.
struct Counted<R> {
    inner: BufReader<R>,
    left: usize,
    line: u64,
}

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.fill_buf()?.read(buffer)?;
        self.consume(read);
        Ok(read)
    }
}

impl<R: Read> BufRead for Counted<R> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.left == 0 {
            let message = format!("a tag, text or comment is longer than {LONGEST} bytes");
            return Err(io::Error::new(io::ErrorKind::InvalidData, message));
        }
        self.inner.fill_buf()
    }

    fn consume(&mut self, amount: usize) {
        self.line += self.inner.buffer()[..amount].iter().filter(|byte| **byte == b'\n').count() as u64;
        self.left = self.left.saturating_sub(amount);
        self.inner.consume(amount);
    }
}

pub(super) fn read(path: &Path, file: File, told: &Told) -> Result<Found, RecordError> {
    let mut timed = Timed::new(path);
    if told.per_metre.is_some_and(|units| units != 1.0) {
        return Err(RecordError::wrong(
            path,
            "FCD of SUMO is in m: --unit is for texts with lines id frame x y z",
        ));
    }
    let inner = BufReader::new(Bounded::new(file, LARGEST));
    let mut reader = Reader::from_reader(Counted { inner, left: LONGEST, line: 1 });
    let (mut bytes, mut open, mut time) = (Vec::new(), 0, None);
    let mut ended = false;
    loop {
        bytes.clear();
        reader.get_mut().left = LONGEST;
        let event = reader.read_event_into(&mut bytes);
        let n = reader.get_ref().line;
        let event = event.map_err(|error| timed.rows.wrong(n, format!("cannot be read as XML: {error}")))?;
        let (tag, opens) = match event {
            Event::Start(tag) => (tag, true),
            Event::Empty(tag) => (tag, false),
            Event::End(_) => {
                open -= 1;
                ended |= open == 0;
                continue;
            }
            Event::Comment(text) if text.contains("<fcd-output.geo value=\"true\"/>") => {
                let message = "x and y are degrees of longitude and latitude (fcd-output.geo): must be in m";
                return Err(timed.rows.wrong(n, message));
            }
            // It may define entities.
            Event::DocType(_) => {
                return Err(timed.rows.wrong(n, "<!DOCTYPE>: document types are not allowed"));
            }
            Event::Eof if ended => break,
            Event::Eof => return Err(timed.rows.wrong(n, "the file ends before </fcd-export>")),
            _ => continue,
        };
        let name = tag.name();
        match (open, name.as_ref()) {
            (0, "fcd-export") => {}
            (0, other) => {
                return Err(timed.rows.wrong(n, format!("<{}>: must be <fcd-export>", cut(other))));
            }
            (1, "timestep") => {
                let [(_, own), ..] = attributes(&timed, n, &tag, ["time", "", "", ""])?;
                let own = timed.time(n, "time", own.as_deref().unwrap_or_default())?;
                if time.is_some_and(|before| own <= before) {
                    let message =
                        format!("<timestep>: time: {own:?} s is not after {:?} s", time.unwrap_or(own));
                    return Err(timed.rows.wrong(n, message));
                }
                timed.frame(n, own)?;
                time = Some(own);
            }
            (2.., "person") => {
                let [(_, id), (_, x), (_, y), (_, angle)] =
                    attributes(&timed, n, &tag, ["id", "x", "y", "angle"])?;
                let [id, x, y] = [id, x, y].map(Option::unwrap_or_default);
                let person = timed.person(n, "id", &id)?;
                let position = timed.position(n, ["x", "y"], [&x, &y])?;
                let orientation = match angle {
                    Some(angle) => from_north(timed.number(n, "angle", &angle)?),
                    None => f64::NAN,
                };
                let Some(time) = time else {
                    return Err(timed.rows.wrong(n, "<person>: is in no <timestep>"));
                };
                timed.add(n, person, time, position, orientation)?;
            }
            _ => {}
        }
        open += usize::from(opens);
        ended |= open == 0;
        if open > DEEPEST {
            return Err(timed.rows.wrong(n, format!("more than {DEEPEST} elements are in each other")));
        }
    }
    timed.finish(told.rate, false)
}

/// Returns the values of attributes.
fn attributes(
    timed: &Timed<'_>,
    n: u64,
    tag: &BytesStart<'_>,
    names: [&'static str; 4],
) -> Result<Attributes, RecordError> {
    let mut found = names.map(|name| (name, None));
    let name = tag.name();
    let wrong = |message: String| timed.rows.wrong(n, format!("<{}>: {message}", cut(name.as_ref())));
    // Checks compare each with all others.
    for attribute in tag.attributes().with_checks(false) {
        let attribute = attribute.map_err(|error| wrong(error.to_string()))?;
        let Some((name, value)) = found.iter_mut().find(|(name, _)| *name == attribute.key.as_ref()) else {
            continue;
        };
        let own = attribute
            .normalized_value(XmlVersion::Implicit1_0)
            .map_err(|error| wrong(format!("{name}: {}: {error}", excerpt(&attribute.value))))?;
        if value.replace(own.into_owned()).is_some() {
            return Err(wrong(format!("{name}: stands twice")));
        }
    }
    Ok(found)
}

fn cut(name: &str) -> String {
    name.chars().take(80).collect()
}
