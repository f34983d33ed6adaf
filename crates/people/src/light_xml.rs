//! The light XML file of a mixed crowd (the paper, "Extension to arbitrary shapes"): pedestrians and bicycles in
//! absolute coordinates. It is meant for drawing; the mechanics does not read it.
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
//! The `Shapes` of an agent of type `bike` are `bike` and `rider`, each with `type` (rectangle), `material`, `min_x`,
//! `min_y`, `max_x`, `max_y`. The paper prints no example. So the reader accepts each value as an element or as an
//! attribute, and ignores case and underscores in names.
//!
//! - `read`, `write`: from the text and to it

mod read;
#[cfg(test)]
mod tests;
mod write;

pub use read::read_light_xml;
pub use write::light_xml;

use crate::bicycle::Bicycle;
use crate::shape::Shape;
use lemons_core::plane::{Disk, Vec2, vec2};
use lemons_core::xml::Problem;
use thiserror::Error;

/// An agent of a light file.
#[derive(Debug, Clone, PartialEq)]
pub struct LightAgent {
    /// Id, unique in the file.
    pub id: u64,
    /// \[kg m²\] moment of inertia about its centre of mass.
    pub moment_of_inertia: f64,
    /// \[1/s\] inverse time of translational friction on the floor.
    pub floor_damping: f64,
    /// \[1/s\] inverse time of rotational friction on the floor.
    pub angular_damping: f64,
    /// Its shapes.
    pub shapes: LightShapes,
}

/// The shapes of a [`LightAgent`]; they also tell its kind.
#[derive(Debug, Clone, PartialEq)]
pub enum LightShapes {
    /// Disks `disk0`, `disk1`, … from the left shoulder to the right one.
    Pedestrian(Vec<LightDisk>),
    /// A bicycle.
    Bicycle {
        /// The rectangle over its wheels.
        bike: LightRectangle,
        /// The rectangle of the rider with the handlebar.
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

/// A rectangle parallel to the axes, in absolute coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct LightRectangle {
    /// \[m\] the corner with the smaller coordinates.
    pub min: Vec2,
    /// \[m\] the corner with the larger coordinates.
    pub max: Vec2,
    /// Name of its material.
    pub material: String,
}

/// Friction on the floor, and the materials of the agents.
#[derive(Debug, Clone, PartialEq)]
pub struct LightSettings {
    /// \[1/s\] inverse time of translational friction.
    pub floor_damping: f64,
    /// \[1/s\] inverse time of rotational friction.
    pub angular_damping: f64,
    /// Material of pedestrians.
    pub pedestrian: String,
    /// Material of bicycles.
    pub bike: String,
    /// Material of riders of bicycles.
    pub rider: String,
}

impl Default for LightSettings {
    /// Damping and the pedestrians' material from the paper's App. C; iron and clothes as in its section on other
    /// shapes.
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

/// The axis along which a bicycle heads: its rectangles must be parallel to the axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Along {
    /// Along or against +x.
    X,
    /// Along or against +y.
    Y,
}

impl LightAgent {
    /// Makes a pedestrian of a mass \[kg\], with its centre of mass at `position` \[m\] and its gaze at `angle`
    /// \[rad\].
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

    /// Makes a bicycle with its centre at `position` \[m\].
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

/// What is wrong with a light file, or with the agents to be written to one.
#[derive(Debug, Clone, PartialEq, Error)]
#[allow(missing_docs)] // the messages say it
pub enum LightError {
    /// It names the line, the element and the value; the text has no file.
    #[error(transparent)]
    Xml(Box<Problem>),
    #[error("agent {id}: {name} = {value}: {fault}")]
    Agent { id: u64, name: String, value: String, fault: &'static str },
}

const POSITIVE: &str = "must be positive and finite";
const NOT_NEGATIVE: &str = "must be finite and not negative";
const FINITE: &str = "must be finite";
const MATERIAL: &str = "must be a name without control characters or blanks around it";
const ORDER: &str = "must be greater than min";
const UNIQUE: &str = "must be unique";

/// Returns the first fault of an agent: name, value as text, what is wrong. Reader and writer use it.
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
