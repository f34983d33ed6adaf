//! The text of a light file -> agents.

use super::{LightAgent, LightDisk, LightError, LightRectangle, LightShapes, UNIQUE, fault};
use lemons_core::plane::{Disk, vec2};
use lemons_core::xml::{Document, Problem, Result, decimal};
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::path::Path;

/// Returns a name without case and underscores, for comparison.
fn key(name: &str) -> String {
    name.chars().filter(|&c| c != '_').collect::<String>().to_ascii_lowercase()
}

/// An element whose values are read as the paper leaves them open.
#[derive(Clone, Copy)]
struct Element<'a>(lemons_core::xml::Element<'a>);

impl<'a> Element<'a> {
    fn children(self) -> impl Iterator<Item = Element<'a>> {
        self.0.elements().map(Element)
    }

    fn is(self, name: &str) -> bool {
        key(self.0.name()) == key(name)
    }

    /// An error about a value, which may be an attribute or an element.
    fn wrong(self, name: &str, message: impl Into<String>) -> Box<Problem> {
        Problem { attribute: Some(name.into()), ..self.0.problem(message) }.into()
    }

    fn only(self, name: &str) -> Result<Element<'a>> {
        let mut found = self.children().filter(|child| child.is(name));
        match (found.next(), found.next()) {
            (Some(child), None) => Ok(child),
            (None, _) => Err(self.wrong(name, "is missing")),
            (Some(_), Some(again)) => Err(again.0.problem("may appear only once").into()),
        }
    }

    /// The text of an attribute or a child element.
    fn text(self, name: &str) -> Result<Cow<'a, str>> {
        let mut attributes = self.0.attributes().filter(|attribute| key(attribute.name()) == key(name));
        let child = self.children().any(|child| child.is(name));
        match (attributes.next(), attributes.next()) {
            (Some(attribute), None) if !child => Ok(Cow::Borrowed(attribute.value().trim())),
            (None, _) => self.only(name)?.0.content(),
            _ => Err(self.wrong(name, "may appear only once")),
        }
    }

    fn number(self, name: &str) -> Result<f64> {
        let text = self.text(name)?;
        let wrong = || self.wrong(name, format!("{text:.60?} must be a finite decimal number"));
        decimal(&text).ok_or_else(wrong)
    }

    fn must_be(self, kind: &str) -> Result<()> {
        let text = self.text("type")?;
        if text == kind {
            return Ok(());
        }
        Err(self.wrong("type", format!("{text:.60?} must be {kind:?}")))
    }
}

/// Reads the agents of a light file, in its order.
///
/// # Errors
/// The first fault, with its line.
pub fn read_light_xml(text: &str) -> std::result::Result<Vec<LightAgent>, LightError> {
    read(text).map_err(LightError::Xml)
}

fn read(text: &str) -> Result<Vec<LightAgent>> {
    let document = Document::parse(Path::new(""), text.as_bytes(), u32::MAX)?;
    let root = Element(document.any_root());
    if !root.is("Agents") {
        return Err(root.0.problem("the root element must be <Agents>").into());
    }
    let mut ids = BTreeSet::new();
    let mut agents = Vec::new();
    for element in root.children().filter(|child| child.is("Agent")) {
        let agent = read_agent(element)?;
        if !ids.insert(agent.id) {
            return Err(element.wrong("Id", format!("{}: {UNIQUE}", agent.id)));
        }
        if let Some((name, value, fault)) = fault(&agent) {
            return Err(element.wrong(&name, format!("{value} {fault}")));
        }
        agents.push(agent);
    }
    Ok(agents)
}

fn read_agent(element: Element<'_>) -> Result<LightAgent> {
    let id = element.text("Id")?;
    let id = id.parse().map_err(|_| element.wrong("Id", format!("{id:.60?} must be a whole number")))?;
    let shapes = element.only("Shapes")?;
    let shapes = match &*element.text("type")? {
        "pedestrian" => LightShapes::Pedestrian(read_disks(shapes)?),
        "bike" => LightShapes::Bicycle {
            bike: read_rectangle(shapes.only("bike")?)?,
            rider: read_rectangle(shapes.only("rider")?)?,
        },
        other => {
            let fault = format!("{other:.60?} must be \"pedestrian\" or \"bike\"");
            return Err(element.wrong("type", fault));
        }
    };
    Ok(LightAgent {
        id,
        moment_of_inertia: element.number("MomentOfInertia")?,
        floor_damping: element.number("FloorDamping")?,
        angular_damping: element.number("AngularDamping")?,
        shapes,
    })
}

/// Reads `disk0`, `disk1`, …: ordered by their numbers, not by their places in the file.
fn read_disks(shapes: Element<'_>) -> Result<Vec<LightDisk>> {
    let count = shapes.children().count();
    let mut disks: Vec<Option<LightDisk>> = vec![None; count];
    for element in shapes.children() {
        let name = key(element.0.name());
        let place = name.strip_prefix("disk").and_then(|place| place.parse::<usize>().ok());
        let Some(slot) = place.and_then(|place| disks.get_mut(place)) else {
            let message = format!("a pedestrian has disk0 to disk{}", count - 1);
            return Err(element.0.problem(message).into());
        };
        if slot.is_some() {
            return Err(element.0.problem("may appear only once").into());
        }
        element.must_be("disk")?;
        let centre = vec2(element.number("x")?, element.number("y")?);
        let material = element.text("material")?.into_owned();
        *slot = Some(LightDisk { disk: Disk { radius: element.number("radius")?, centre }, material });
    }
    // There are as many slots as elements and no slot is used twice: all are filled.
    Ok(disks.into_iter().flatten().collect())
}

fn read_rectangle(element: Element<'_>) -> Result<LightRectangle> {
    element.must_be("rectangle")?;
    Ok(LightRectangle {
        min: vec2(element.number("min_x")?, element.number("min_y")?),
        max: vec2(element.number("max_x")?, element.number("max_y")?),
        material: element.text("material")?.into_owned(),
    })
}
