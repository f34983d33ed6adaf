//! The light XML file of a mixed crowd (the paper, "Extension to arbitrary shapes"): pedestrians and bicycles in
//! absolute coordinates. It is meant for drawing; nothing here reads it.
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
//! `min_y`, `max_x`, `max_y`. The paper prints no example.

use crate::error::Result;
use crate::population::CrowdMember;
use crate::shape::Shape;
use crate::trial::FLOOR_DAMPING;
use lemons_core::plane::{Disk, Pose, vec2};
use lemons_core::xml::{Layout, XmlWriter, number};

/// Returns the text of the file. Ids are places in the crowd; numbers are the shortest decimals that are read back as
/// the same doubles. Bicycles are drawn along the axis that is nearest to their direction.
///
/// # Errors
/// A person has no shape.
pub fn light_xml(crowd: &[(CrowdMember, Pose)]) -> Result<String> {
    let shapes = crowd.iter().map(|(agent, _)| agent.shape()).collect::<Result<Vec<_>>>()?;
    Ok(XmlWriter::document(Layout::PAPER, "Agents", &[], |out| {
        for (id, ((agent, pose), shape)) in crowd.iter().zip(&shapes).enumerate() {
            out.element("Agent", &[], |out| write_agent(out, id, agent, shape, pose));
        }
    }))
}

fn write_agent(out: &mut XmlWriter, id: usize, agent: &CrowdMember, shape: &Shape, pose: &Pose) {
    let inertia = match agent {
        CrowdMember::Pedestrian(person) => shape.inertia(person.mass),
        CrowdMember::Member(member) => member.inertia,
    };
    let bicycle = agent.member().and_then(|member| member.bicycle.as_ref());
    out.text("type", bicycle.map_or("pedestrian", |_| "bike"));
    out.text("Id", &id.to_string());
    out.text("MomentOfInertia", &number(inertia));
    out.text("FloorDamping", &number(FLOOR_DAMPING));
    out.text("AngularDamping", &number(FLOOR_DAMPING));
    out.element("Shapes", &[], |out| match bicycle {
        None => {
            let of_part = |place: usize| agent.member()?.disks[place].material.as_deref();
            for (place, Disk { radius, centre }) in shape.placed(pose).enumerate() {
                out.element(&format!("disk{place}"), &[], |out| {
                    out.text("type", "disk");
                    out.text("radius", &number(radius));
                    out.text("material", of_part(place).unwrap_or("human_naked"));
                    out.text("x", &number(centre.x));
                    out.text("y", &number(centre.y));
                });
            }
        }
        Some(bicycle) => {
            let parts = [("bike", "iron"), ("rider", "human_clothes")];
            for ((name, material), (length, breadth)) in parts.into_iter().zip(bicycle.rectangles()) {
                let along_y = pose.orientation.sin().abs() > pose.orientation.cos().abs();
                let half = if along_y { vec2(breadth, length) } else { vec2(length, breadth) } * 0.5;
                let (min, max) = (pose.position - half, pose.position + half);
                out.element(name, &[], |out| {
                    out.text("type", "rectangle");
                    out.text("material", material);
                    out.text("min_x", &number(min.x));
                    out.text("min_y", &number(min.y));
                    out.text("max_x", &number(max.x));
                    out.text("max_y", &number(max.y));
                });
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bicycle::Bicycle;
    use crate::kinds::Kinds;
    use crate::person::{Person, Sex};
    use crate::random::Random;

    #[test]
    fn the_tags_are_the_papers() {
        let person = Person { sex: Sex::Male, breadth: 0.5, depth: 0.25, stature: 1.75, mass: 80.0 };
        let bicycle = Bicycle { wheel_width: 0.5, length: 2.0, handlebar: 1.0, top_tube: 1.5, mass: 12.0 };
        let shape = Shape::of(&person).unwrap();
        let along_y = Pose { position: vec2(1.0, 10.0), orientation: -std::f64::consts::FRAC_PI_2 };
        let poses = [Pose { position: vec2(-3.0, 7.0), orientation: 0.1 }, along_y];
        let kinds = Kinds::built_in().unwrap();
        let rider = kinds.get("bicycle").unwrap().draw(person, None, Some(bicycle), &mut Random::new(1));
        let crowd =
            [(CrowdMember::Pedestrian(person), poses[0]), (CrowdMember::Member(Box::new(rider)), poses[1])];
        let text = light_xml(&crowd).unwrap();
        let disk = |(place, disk): (usize, Disk)| {
            format!(
                "<disk{place}> <type>disk</type> <radius>{:?}</radius> <material>human_naked</material> \
                 <x>{:?}</x> <y>{:?}</y> </disk{place}> ",
                disk.radius, disk.centre.x, disk.centre.y
            )
        };
        let disks: String = shape.placed(&poses[0]).enumerate().map(disk).collect();
        let (inertia, bicycle_inertia) = (shape.inertia(80.0), shape.inertia(80.0) + bicycle.inertia());
        let damping = "<FloorDamping>4.5</FloorDamping> <AngularDamping>4.5</AngularDamping>";
        let expected = format!(
            "<?xml version=\"1.0\" encoding=\"utf-8\"?> <Agents> <Agent> <type>pedestrian</type> <Id>0</Id> \
             <MomentOfInertia>{inertia:?}</MomentOfInertia> {damping} <Shapes> {disks}</Shapes> </Agent> \
             <Agent> <type>bike</type> <Id>1</Id> \
             <MomentOfInertia>{bicycle_inertia:?}</MomentOfInertia> {damping} <Shapes> \
             <bike> <type>rectangle</type> <material>iron</material> \
             <min_x>0.75</min_x> <min_y>9.0</min_y> <max_x>1.25</max_x> <max_y>11.0</max_y> </bike> \
             <rider> <type>rectangle</type> <material>human_clothes</material> \
             <min_x>0.5</min_x> <min_y>9.25</min_y> <max_x>1.5</max_x> <max_y>10.75</max_y> </rider> \
             </Shapes> </Agent> </Agents>"
        );
        assert_eq!(text.split_whitespace().collect::<Vec<_>>().join(" "), expected);
    }
}
