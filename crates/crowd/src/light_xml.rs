//! The light XML file of a mixed crowd (the paper, "Extension to arbitrary shapes"): pedestrians and bicycles in
//! absolute coordinates, for a look at them rather than for the mechanics.
//!
//! ```xml
//! <Agents>
//!     <Agent>
//!         <type>pedestrian</type>
//!         <Id>0</Id>
//!         <MomentOfInertia>1.8</MomentOfInertia>
//!         <FloorDamping>4.5</FloorDamping>
//!         <AngularDamping>4.5</AngularDamping>
//!         <Shapes>
//!             <disk0>
//!                 <type>disk</type>
//!                 <radius>0.095</radius>
//!                 <material>human_naked</material>
//!                 <x>0.1</x>
//!                 <y>0.2</y>
//!             </disk0>
//!         </Shapes>
//!     </Agent>
//! </Agents>
//! ```
//!
//! The `Shapes` of a `bike` are `bike` and `rider`, each with `type` (rectangle), `material`, `min_x`, `min_y`,
//! `max_x`, `max_y`. The paper prints no example: a reader takes each value as an element or as an attribute, whatever
//! the case and the underscores of its name.

use crate::bicycle::Bicycle;
use crate::disk::Disk;
use crate::shape::Shape;
use crowd_mechanics::engine::{Vec2, vec2};
use lemons_files::markup::{self, Refused};
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, BytesText, Event};
use roxmltree::{Document, Node};
use std::collections::BTreeSet;
use thiserror::Error;

/// An agent of the light file.
#[derive(Debug, Clone, PartialEq)]
pub struct LightAgent {
    /// Unique in the file.
    pub id: u64,
    /// \[kg m²\] about its centre of mass.
    pub moment_of_inertia: f64,
    /// \[1/s\] inverse time of translational friction.
    pub floor_damping: f64,
    /// \[1/s\] inverse time of rotational damping.
    pub angular_damping: f64,
    /// What it is made of.
    pub shapes: LightShapes,
}

/// What a [`LightAgent`] is made of; it tells the kinds apart.
#[derive(Debug, Clone, PartialEq)]
pub enum LightShapes {
    /// `disk0`, `disk1`, … from the left shoulder to the right one.
    Pedestrian(Vec<LightDisk>),
    /// A bicycle.
    Bicycle {
        /// Over its wheels.
        bike: LightRectangle,
        /// The rider with the handlebar.
        rider: LightRectangle,
    },
}

/// A disk in absolute coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct LightDisk {
    /// Its radius and centre \[m\].
    pub disk: Disk,
    /// Name of its material.
    pub material: String,
}

/// A rectangle along the axes, in absolute coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct LightRectangle {
    /// \[m\] the corner with the smaller coordinates.
    pub min: Vec2,
    /// \[m\] the corner with the larger coordinates.
    pub max: Vec2,
    /// Name of its material.
    pub material: String,
}

/// Rates of friction on the floor, and what agents are made of.
#[derive(Debug, Clone, PartialEq)]
pub struct LightSettings {
    /// \[1/s\] inverse time of translational friction.
    pub floor_damping: f64,
    /// \[1/s\] inverse time of rotational damping.
    pub angular_damping: f64,
    /// Of pedestrians.
    pub pedestrian: String,
    /// Of bicycles.
    pub bike: String,
    /// Of their riders.
    pub rider: String,
}

impl Default for LightSettings {
    /// The dampings and the pedestrians' material of the paper's App. C; iron and clothes as its section on other
    /// shapes says.
    fn default() -> LightSettings {
        LightSettings {
            floor_damping: 4.5,
            angular_damping: 4.5,
            pedestrian: "human_naked".into(),
            bike: "iron".into(),
            rider: "human_clothes".into(),
        }
    }
}

/// Which way a bicycle heads: its rectangles must stand along the axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Along {
    /// Along or against +x.
    X,
    /// Along or against +y.
    Y,
}

impl LightAgent {
    /// A pedestrian of a mass \[kg\] with its centre of mass at `position` \[m\] and its gaze at `angle` \[rad\].
    pub fn pedestrian(
        id: u64,
        shape: &Shape,
        mass: f64,
        position: Vec2,
        angle: f64,
        settings: &LightSettings,
    ) -> LightAgent {
        let material = &settings.pedestrian;
        let disks = shape.placed(position, angle);
        let disks = disks.into_iter().map(|disk| LightDisk { disk, material: material.clone() });
        LightAgent {
            id,
            moment_of_inertia: shape.inertia(mass),
            floor_damping: settings.floor_damping,
            angular_damping: settings.angular_damping,
            shapes: LightShapes::Pedestrian(disks.collect()),
        }
    }

    /// A bicycle with its centre at `position` \[m\].
    pub fn bicycle(
        id: u64,
        bicycle: &Bicycle,
        position: Vec2,
        along: Along,
        settings: &LightSettings,
    ) -> LightAgent {
        let rectangle = |(length, breadth): (f64, f64), material: &str| {
            let half = match along {
                Along::X => vec2(0.5 * length, 0.5 * breadth),
                Along::Y => vec2(0.5 * breadth, 0.5 * length),
            };
            LightRectangle { min: position - half, max: position + half, material: material.into() }
        };
        let [bike, rider] = bicycle.rectangles();
        let shapes = LightShapes::Bicycle {
            bike: rectangle(bike, &settings.bike),
            rider: rectangle(rider, &settings.rider),
        };
        LightAgent {
            id,
            moment_of_inertia: bicycle.inertia(),
            floor_damping: settings.floor_damping,
            angular_damping: settings.angular_damping,
            shapes,
        }
    }
}

/// What is wrong with a light file or the agents for one.
#[derive(Debug, Clone, PartialEq, Error)]
#[allow(missing_docs)] // the messages say it
pub enum LightError {
    #[error("is not well-formed XML: {0}")]
    Xml(#[from] roxmltree::Error),
    #[error("line {line}: <{element}> {name}: {fault}")]
    Value { line: u32, element: String, name: String, fault: String },
    #[error("line {line}: <{element}>: {fault}")]
    Element { line: u32, element: String, fault: String },
    #[error("agent {id}: {name} = {value}: {fault}")]
    Agent { id: u64, name: String, value: String, fault: &'static str },
}

const POSITIVE: &str = "must be positive and finite";
const NOT_NEGATIVE: &str = "must be finite and not negative";
const FINITE: &str = "must be finite";
const MATERIAL: &str = "must be a name without control characters or blanks around it";
const ORDER: &str = "must exceed its min";
const UNIQUE: &str = "must be unique";

/// The first fault of an agent: name, value as text, what is wrong. Shared by reader and writer.
fn fault(agent: &LightAgent) -> Option<(String, String, &'static str)> {
    let number = |name: String, value: f64, right: bool, fault| {
        (!(right && value.is_finite())).then(|| (name, format!("{value:?}"), fault))
    };
    let material = |part: &str, name: &str| {
        let wrong = name.is_empty() || name.trim() != name || name.chars().any(char::is_control);
        wrong.then(|| (format!("{part} material"), format!("{name:.60?}"), MATERIAL))
    };
    let inertia = agent.moment_of_inertia;
    let own = number("MomentOfInertia".into(), inertia, inertia > 0.0, POSITIVE).or_else(|| {
        [("FloorDamping", agent.floor_damping), ("AngularDamping", agent.angular_damping)]
            .into_iter()
            .find_map(|(name, value)| number(name.into(), value, value >= 0.0, NOT_NEGATIVE))
    });
    own.or_else(|| match &agent.shapes {
        LightShapes::Pedestrian(disks) if disks.is_empty() => {
            Some(("Shapes".into(), "none".into(), "must have at least one disk"))
        }
        LightShapes::Pedestrian(disks) => disks.iter().enumerate().find_map(|(place, light)| {
            let Disk { radius, centre } = light.disk;
            number(format!("disk{place} radius"), radius, radius > 0.0, POSITIVE)
                .or_else(|| number(format!("disk{place} x"), centre.x, true, FINITE))
                .or_else(|| number(format!("disk{place} y"), centre.y, true, FINITE))
                .or_else(|| material(&format!("disk{place}"), &light.material))
        }),
        LightShapes::Bicycle { bike, rider } => {
            [("bike", bike), ("rider", rider)].into_iter().find_map(|(part, rectangle)| {
                let LightRectangle { min, max, material: name } = rectangle;
                number(format!("{part} min_x"), min.x, true, FINITE)
                    .or_else(|| number(format!("{part} min_y"), min.y, true, FINITE))
                    .or_else(|| number(format!("{part} max_x"), max.x, max.x > min.x, ORDER))
                    .or_else(|| number(format!("{part} max_y"), max.y, max.y > min.y, ORDER))
                    .or_else(|| material(part, name))
            })
        }
    })
}

/// The text of the file. Numbers are the shortest decimals that read back to the same doubles.
///
/// # Errors
/// An agent whose numbers are impossible, a material that is no name, an Id that stands twice.
pub fn light_xml(agents: &[LightAgent]) -> Result<String, LightError> {
    let mut ids = BTreeSet::new();
    for agent in agents {
        let id = agent.id;
        if !ids.insert(id) {
            return Err(LightError::Agent { id, name: "Id".into(), value: id.to_string(), fault: UNIQUE });
        }
        if let Some((name, value, fault)) = fault(agent) {
            return Err(LightError::Agent { id, name, value, fault });
        }
    }
    let mut out = Out(Writer::new_with_indent(Vec::new(), b' ', 4));
    out.event(Event::Decl(BytesDecl::new("1.0", Some("utf-8"), None)));
    out.element("Agents", |out| {
        for agent in agents {
            out.element("Agent", |out| write_agent(out, agent));
        }
    });
    let mut text = out.0.into_inner();
    text.push(b'\n');
    Ok(String::from_utf8(text).unwrap_or_default())
}

/// It writes into memory, which cannot fail: hence the dropped results.
struct Out(Writer<Vec<u8>>);

impl Out {
    fn event(&mut self, event: Event<'_>) {
        let _ = self.0.write_event(event);
    }

    fn element(&mut self, name: &str, content: impl FnOnce(&mut Out)) {
        self.event(Event::Start(BytesStart::new(name)));
        content(self);
        self.event(Event::End(BytesEnd::new(name)));
    }

    fn text(&mut self, name: &str, value: &str) {
        self.element(name, |out| out.event(Event::Text(BytesText::new(value))));
    }

    fn number(&mut self, name: &str, value: f64) {
        self.text(name, &format!("{value:?}"));
    }
}

fn write_agent(out: &mut Out, agent: &LightAgent) {
    let kind = match agent.shapes {
        LightShapes::Pedestrian(_) => "pedestrian",
        LightShapes::Bicycle { .. } => "bike",
    };
    out.text("type", kind);
    out.text("Id", &agent.id.to_string());
    out.number("MomentOfInertia", agent.moment_of_inertia);
    out.number("FloorDamping", agent.floor_damping);
    out.number("AngularDamping", agent.angular_damping);
    out.element("Shapes", |out| match &agent.shapes {
        LightShapes::Pedestrian(disks) => {
            for (place, LightDisk { disk, material }) in disks.iter().enumerate() {
                out.element(&format!("disk{place}"), |out| {
                    out.text("type", "disk");
                    out.number("radius", disk.radius);
                    out.text("material", material);
                    out.number("x", disk.centre.x);
                    out.number("y", disk.centre.y);
                });
            }
        }
        LightShapes::Bicycle { bike, rider } => {
            for (name, rectangle) in [("bike", bike), ("rider", rider)] {
                out.element(name, |out| {
                    out.text("type", "rectangle");
                    out.text("material", &rectangle.material);
                    out.number("min_x", rectangle.min.x);
                    out.number("min_y", rectangle.min.y);
                    out.number("max_x", rectangle.max.x);
                    out.number("max_y", rectangle.max.y);
                });
            }
        }
    });
}

/// A name as it is compared: without case and underscores.
fn key(name: &str) -> String {
    name.chars().filter(|&c| c != '_').collect::<String>().to_ascii_lowercase()
}

/// An element with the line ends of its file: asking the document for a line reads the text from its start.
#[derive(Clone, Copy)]
struct Element<'a> {
    node: Node<'a, 'a>,
    line_ends: &'a [usize],
}

impl<'a> Element<'a> {
    fn line(self) -> u32 {
        let start = self.node.range().start;
        u32::try_from(self.line_ends.partition_point(|&end| end < start) + 1).unwrap_or(u32::MAX)
    }

    fn name(self) -> &'a str {
        self.node.tag_name().name()
    }

    fn children(self) -> impl Iterator<Item = Element<'a>> {
        let elements = self.node.children().filter(Node::is_element);
        elements.map(move |node| Element { node, ..self })
    }

    fn wrong(self, fault: impl Into<String>) -> LightError {
        LightError::Element { line: self.line(), element: self.name().into(), fault: fault.into() }
    }

    fn wrong_value(self, name: &str, fault: impl Into<String>) -> LightError {
        LightError::Value {
            line: self.line(),
            element: self.name().into(),
            name: name.into(),
            fault: fault.into(),
        }
    }

    fn only(self, name: &str) -> Result<Element<'a>, LightError> {
        let mut found = self.children().filter(|child| key(child.name()) == key(name));
        match (found.next(), found.next()) {
            (Some(child), None) => Ok(child),
            (None, _) => Err(self.wrong_value(name, "is missing")),
            (Some(_), Some(again)) => Err(again.wrong("may stand only once")),
        }
    }

    /// Of an attribute or a child element.
    fn text(self, name: &str) -> Result<&'a str, LightError> {
        let mut attributes = self.node.attributes().filter(|attribute| key(attribute.name()) == key(name));
        let child = self.children().any(|child| key(child.name()) == key(name));
        match (attributes.next(), attributes.next()) {
            (Some(attribute), None) if !child => Ok(attribute.value().trim()),
            (None, _) => Ok(self.only(name)?.node.text().unwrap_or_default().trim()),
            _ => Err(self.wrong_value(name, "may stand only once")),
        }
    }

    fn number(self, name: &str) -> Result<f64, LightError> {
        let text = self.text(name)?;
        // Rust's own parser takes "inf" and "nan" as well.
        let plain = text.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'+' | b'-' | b'.' | b'e' | b'E'));
        let number = text.parse().ok().filter(|value: &f64| plain && value.is_finite());
        number.ok_or_else(|| self.wrong_value(name, format!("{text:.60?} must be a finite decimal number")))
    }

    fn must_be(self, kind: &str) -> Result<(), LightError> {
        let text = self.text("type")?;
        if text == kind {
            return Ok(());
        }
        Err(self.wrong_value("type", format!("{text:.60?} must be {kind:?}")))
    }
}

/// The agents of a light file, in its order.
///
/// # Errors
/// The first thing that is wrong, with its line.
pub fn read_light_xml(text: &str) -> Result<Vec<LightAgent>, LightError> {
    if let Err(Refused { line, element, what }) = markup::check(text) {
        return Err(LightError::Element { line, element, fault: what });
    }
    // Document types stay off, the default: no entities, hence no entity bombs.
    let document = Document::parse(text.strip_prefix('\u{feff}').unwrap_or(text))?;
    let line_ends: Vec<usize> = document.input_text().match_indices('\n').map(|(end, _)| end).collect();
    let root = Element { node: document.root_element(), line_ends: &line_ends };
    if key(root.name()) != "agents" {
        return Err(root.wrong("the root element must be <Agents>"));
    }
    let mut ids = BTreeSet::new();
    let mut agents = Vec::new();
    for element in root.children().filter(|child| key(child.name()) == "agent") {
        let agent = read_agent(element)?;
        if !ids.insert(agent.id) {
            return Err(element.wrong_value("Id", format!("{}: {UNIQUE}", agent.id)));
        }
        if let Some((name, value, fault)) = fault(&agent) {
            return Err(element.wrong_value(&name, format!("{value} {fault}")));
        }
        agents.push(agent);
    }
    Ok(agents)
}

fn read_agent(element: Element<'_>) -> Result<LightAgent, LightError> {
    let id = element.text("Id")?;
    let id =
        id.parse().map_err(|_| element.wrong_value("Id", format!("{id:.60?} must be a whole number")))?;
    let shapes = element.only("Shapes")?;
    let shapes = match element.text("type")? {
        "pedestrian" => LightShapes::Pedestrian(read_disks(shapes)?),
        "bike" => LightShapes::Bicycle {
            bike: read_rectangle(shapes.only("bike")?)?,
            rider: read_rectangle(shapes.only("rider")?)?,
        },
        other => {
            let fault = format!("{other:.60?} must be \"pedestrian\" or \"bike\"");
            return Err(element.wrong_value("type", fault));
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

/// `disk0`, `disk1`, …: their numbers order them, not their places in the file.
fn read_disks(shapes: Element<'_>) -> Result<Vec<LightDisk>, LightError> {
    let count = shapes.children().count();
    let mut disks: Vec<Option<LightDisk>> = vec![None; count];
    for element in shapes.children() {
        let name = key(element.name());
        let place = name.strip_prefix("disk").and_then(|place| place.parse::<usize>().ok());
        let Some(slot) = place.and_then(|place| disks.get_mut(place)) else {
            return Err(element.wrong(format!("a pedestrian has disk0 to disk{}", count - 1)));
        };
        if slot.is_some() {
            return Err(element.wrong("may stand only once"));
        }
        element.must_be("disk")?;
        let centre = vec2(element.number("x")?, element.number("y")?);
        let material = element.text("material")?.to_owned();
        *slot = Some(LightDisk { disk: Disk { radius: element.number("radius")?, centre }, material });
    }
    // As many slots as elements and none taken twice: all are filled.
    Ok(disks.into_iter().flatten().collect())
}

fn read_rectangle(element: Element<'_>) -> Result<LightRectangle, LightError> {
    element.must_be("rectangle")?;
    Ok(LightRectangle {
        min: vec2(element.number("min_x")?, element.number("min_y")?),
        max: vec2(element.number("max_x")?, element.number("max_y")?),
        material: element.text("material")?.to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bicycle::BicycleStatistics;
    use crate::population::{Agent, Population, Proportions, Source};
    use crate::random::{generator, uniform};

    fn crowd(count: usize) -> Vec<LightAgent> {
        let proportions = Proportions { men: 0.5, pedestrians: 0.6 };
        let population = Population::new(Source::Ansur, proportions).unwrap();
        let rng = &mut generator(11);
        let settings = LightSettings::default();
        let mut agents = Vec::new();
        for (id, agent) in population.agents(12).take(count).enumerate() {
            let position = vec2(20.0 * uniform(rng) - 10.0, 20.0 * uniform(rng));
            let along = if uniform(rng) < 0.5 { Along::X } else { Along::Y };
            agents.push(match agent {
                Agent::Pedestrian(person) => {
                    let shape = Shape::of(&person).unwrap();
                    let angle = 7.0 * uniform(rng);
                    LightAgent::pedestrian(id as u64, &shape, person.mass, position, angle, &settings)
                }
                Agent::Bicycle(bicycle) => {
                    LightAgent::bicycle(id as u64, &bicycle, position, along, &settings)
                }
            });
        }
        agents
    }

    #[test]
    fn a_mixed_crowd_reads_back_to_the_same_doubles() {
        let agents = crowd(40);
        let bicycles = agents.iter().filter(|agent| matches!(agent.shapes, LightShapes::Bicycle { .. }));
        assert!((5..35).contains(&bicycles.count()));
        let text = light_xml(&agents).unwrap();
        assert_eq!(read_light_xml(&text).unwrap(), agents);
        assert_eq!(read_light_xml(&light_xml(&[]).unwrap()).unwrap(), []);
        let named = LightSettings { pedestrian: "<\"a\" & 'b'>".into(), ..LightSettings::default() };
        let shape = Shape::fit(0.5, 0.25).unwrap();
        let agents = [LightAgent::pedestrian(u64::MAX, &shape, 1e-300, vec2(-0.0, 1e300), 0.1, &named)];
        assert_eq!(read_light_xml(&light_xml(&agents).unwrap()).unwrap(), agents);
    }

    #[test]
    fn the_tags_are_the_papers() {
        let statistics = BicycleStatistics::default();
        let settings = LightSettings::default();
        let bicycle = Bicycle { wheel_width: 0.5, length: 2.0, handlebar: 1.0, top_tube: 1.5, mass: 12.0 };
        statistics.check().unwrap();
        let text =
            light_xml(&[LightAgent::bicycle(3, &bicycle, vec2(1.0, 10.0), Along::Y, &settings)]).unwrap();
        let inertia = bicycle.inertia();
        let words: Vec<&str> = text.split_whitespace().collect();
        let expected = format!(
            "<?xml version=\"1.0\" encoding=\"utf-8\"?> <Agents> <Agent> <type>bike</type> <Id>3</Id> \
             <MomentOfInertia>{inertia:?}</MomentOfInertia> <FloorDamping>4.5</FloorDamping> \
             <AngularDamping>4.5</AngularDamping> <Shapes> \
             <bike> <type>rectangle</type> <material>iron</material> \
             <min_x>0.75</min_x> <min_y>9.0</min_y> <max_x>1.25</max_x> <max_y>11.0</max_y> </bike> \
             <rider> <type>rectangle</type> <material>human_clothes</material> \
             <min_x>0.5</min_x> <min_y>9.25</min_y> <max_x>1.5</max_x> <max_y>10.75</max_y> </rider> \
             </Shapes> </Agent> </Agents>"
        );
        assert_eq!(words.join(" "), expected);
    }

    #[test]
    fn attributes_and_other_spellings_are_read() {
        let text = "<Agents><Agent Type='pedestrian' id='4' moment_of_inertia='1.5' FloorDamping='1' AngularDamping='2'>\
             <Shapes><disk1 type='disk' radius='0.2' material='skin' x='1' y='2'/>\
             <disk0 type='disk' radius='0.1' material='skin' x='1' y='3'/></Shapes></Agent><Other/></Agents>";
        let agents = read_light_xml(text).unwrap();
        let LightShapes::Pedestrian(disks) = &agents[0].shapes else { panic!("{agents:?}") };
        assert_eq!((agents[0].id, agents[0].moment_of_inertia), (4, 1.5));
        assert_eq!(disks.iter().map(|disk| disk.disk.radius).collect::<Vec<_>>(), [0.1, 0.2]);
    }

    #[test]
    fn bad_files_are_refused_by_line() {
        let good = light_xml(&crowd(8)).unwrap();
        let id = |k: u32| format!("<Id>{k}</Id>");
        let cases = [
            (good.replacen(&id(1), &id(0), 1), "Id: 0: must be unique"),
            (good.replacen(&id(1), "<Id>-1</Id>", 1), "Id: \"-1\" must be a whole number"),
            (
                good.replacen("<type>disk</type>", "<type>square</type>", 1),
                "type: \"square\" must be \"disk\"",
            ),
            (good.replacen("<radius>0.", "<radius>-0.", 1), "disk0 radius: -0."),
            (good.replacen("<x>", "<x>nan", 1), "must be a finite decimal number"),
            (good.replacen("<material>iron</material>", "", 1), "<bike> material: is missing"),
            (good.replacen("disk4>", "disk7>", 2), "a pedestrian has disk0 to disk4"),
            (good.replacen("disk4>", "disk3>", 2), "may stand only once"),
            (good.replacen("Agents>", "Crowd>", 2), "the root element must be <Agents>"),
            (good.replacen("</Agent>", "", 1), "is not well-formed XML"),
            (
                good.replacen("<type>bike</type>", "<type>tram</type>", 1),
                "must be \"pedestrian\" or \"bike\"",
            ),
            (good.replacen("<max_x>", "<max_x>-1e9</max_x><max_x>", 1), "<max_x>: may stand only once"),
            (
                good.replacen("<min_x>", "<min_x>9", 1).replacen("<min_x>9-", "<min_x>9", 1),
                "must exceed its min",
            ),
        ];
        for (text, fault) in cases {
            assert_ne!(text, good);
            let error = read_light_xml(&text).unwrap_err().to_string();
            assert!(error.contains(fault), "{fault}: {error}");
            assert!(error.len() < 300, "{error}");
        }
        let bomb = "<!DOCTYPE Agents [<!ENTITY a 'aaaa'>]><Agents>&a;</Agents>";
        assert_eq!(
            read_light_xml(bomb).unwrap_err().to_string(),
            "line 1: <!DOCTYPE>: no document type is taken"
        );
        let mut line = read_light_xml("<Agents>\n\n<Agent Id='1'\n/></Agents>").unwrap_err().to_string();
        assert_eq!(line, "line 3: <Agent> Shapes: is missing");
        line = read_light_xml("<Agents><Agent><Id/></Agent></Agents>").unwrap_err().to_string();
        assert_eq!(line, "line 1: <Agent> Id: \"\" must be a whole number");
    }

    /// 300 000 took over a minute.
    #[test]
    fn elements_with_many_attributes_are_refused_before_they_are_parsed() {
        for prefix in ["", "xmlns:"] {
            let many: String = (0..300_000).map(|k| format!(" {prefix}a{k}='{k}'")).collect();
            let said = read_light_xml(&format!("<Agents>\n<Agent{many}/></Agents>")).unwrap_err().to_string();
            assert_eq!(said, "line 2: <Agent>: has 300000 attributes; the most is 256");
        }
    }

    #[test]
    fn damaged_files_are_read_without_a_panic() {
        let good = light_xml(&crowd(3)).unwrap();
        let rng = &mut generator(13);
        let mut refused = 0;
        for _ in 0..3000 {
            let mut text: Vec<char> = good.chars().collect();
            let at = |rng: &mut _, length: usize| (uniform(rng) * length as f64) as usize;
            for _ in 0..1 + at(rng, 3) {
                let (from, to) = (at(rng, text.len()), at(rng, text.len()));
                match at(rng, 3) {
                    0 => text[from] = char::from(at(rng, 128) as u8),
                    1 => drop(text.drain(from.min(to)..from.max(to).min(from.min(to) + 40))),
                    _ => text.swap(from, to),
                }
            }
            let text: String = text.into_iter().collect();
            match read_light_xml(&text) {
                // Whatever is taken can be written, and reads back.
                Ok(agents) => assert_eq!(read_light_xml(&light_xml(&agents).unwrap()).unwrap(), agents),
                Err(error) => {
                    assert!(error.to_string().len() < 500, "{error}");
                    refused += 1;
                }
            }
        }
        assert!(refused > 2000, "{refused}");
    }

    #[test]
    fn what_cannot_be_read_back_is_not_written() {
        let good = crowd(1);
        let refuse = |change: &dyn Fn(&mut LightAgent)| {
            let mut agents = good.clone();
            change(&mut agents[0]);
            light_xml(&agents).unwrap_err().to_string()
        };
        assert_eq!(
            refuse(&|agent| agent.floor_damping = f64::NAN),
            "agent 0: FloorDamping = NaN: must be finite and not negative"
        );
        let shapes = |material: &str| {
            let disk = Disk { radius: 1.0, centre: Vec2::ZERO };
            LightShapes::Pedestrian(vec![LightDisk { disk, material: material.into() }])
        };
        for name in ["", "a\0b", " a", "a\nb"] {
            let message = refuse(&|agent| agent.shapes = shapes(name));
            assert!(message.contains("disk0 material") && message.contains(MATERIAL), "{message}");
        }
        let twice = [good[0].clone(), good[0].clone()];
        assert_eq!(light_xml(&twice).unwrap_err().to_string(), "agent 0: Id = 0: must be unique");
    }
}
