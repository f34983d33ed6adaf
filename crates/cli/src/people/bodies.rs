//! The files of a crowd's bodies, and the table of their sections.

use super::outputs::Outputs;
use crate::interrupt::Interrupt;
use anyhow::Result;
use lemons_core::plane::{Pose, Vec2, rotation};
use lemons_people::{
    Body3d, CrowdMember, CrowdSection, Figure, Person, section, write_geojson, write_obj, write_stl,
    write_wkt,
};
use std::io::Write;

/// Writes sections at altitudes \[m\], if they are wanted, and meshes, until Ctrl-C. The shapes cover `covered` \[m²\] of the
/// ground \[m²\]. Bodies are made one after the other: those of a large crowd would not go into memory together. Who can
/// have none was refused before.
pub fn write(
    crowd: &[(CrowdMember, Pose)],
    altitudes: Option<&[f64]>,
    [covered, ground]: [f64; 2],
    outputs: &mut Outputs,
    interrupt: &Interrupt,
    out: &mut Vec<u8>,
) -> Result<()> {
    let bodies = || {
        let wanted = crowd.iter().enumerate().take_while(|_| !interrupt.pressed());
        wanted.flat_map(|(place, (agent, pose))| {
            let placed = move |(person, at): (Person, Vec2)| {
                let turned = rotation(pose.orientation) * at;
                let pose = Pose { position: pose.position + turned, ..*pose };
                Some((place, Body3d::similar(&person).ok()?, pose))
            };
            agent.people().into_iter().filter_map(placed)
        })
    };
    if let Some(altitudes) = altitudes {
        // People who sit have no outlines.
        let empty = |&altitude: &f64| CrowdSection { altitude, bodies: vec![Vec::new(); crowd.len()] };
        let mut sections: Vec<CrowdSection> = altitudes.iter().map(empty).collect();
        for (place, body, pose) in bodies() {
            for all in &mut sections {
                let one = section(&[(&body, pose)], all.altitude);
                all.bodies[place].extend(one.bodies.into_iter().flatten());
            }
        }
        interrupt.check()?;
        // The paper's comparison: what the shapes of all cover, and what planes cut of the bodies of people.
        let (all, people) =
            (crowd.len(), crowd.iter().filter(|(agent, _)| !agent.people().is_empty()).count());
        let share = |area: f64| 100.0 * area / ground;
        writeln!(out, "\naltitude      people cut     covered   of the ground")?;
        for section in &sections {
            let (altitude, cut, area) = (section.altitude, section.cut(), section.covered());
            let share = share(area);
            writeln!(out, "{altitude:>6.3} m   {cut:>6} of {people:<6} {area:>7.3} m² {share:>9.1} %")?;
        }
        writeln!(out, "2D shapes  {all:>6}           {covered:>7.3} m² {:>9.1} %", share(covered))?;
        if people < all {
            writeln!(
                out,
                "(the {} people on bicycles and in wheelchairs have no sections, and things have none)",
                all - people
            )?;
        }
        writeln!(out)?;
        outputs.fill("--sections-geojson", |file| write_geojson(&sections, file))?;
        outputs.fill("--sections-wkt", |file| write_wkt(&sections, file))?;
    }
    let parts = || {
        let wanted = crowd.iter().enumerate().take_while(|_| !interrupt.pressed());
        wanted.flat_map(|(place, (agent, pose))| {
            Figure::of(agent).into_iter().flat_map(move |figure| figure.surfaces(&place.to_string(), pose))
        })
    };
    outputs.fill("--obj", |file| write_obj(parts(), file))?;
    // STL begins with the number of triangles, so all are made first.
    outputs.fill("--stl", |file| write_stl(&parts().collect::<Vec<_>>(), file))?;
    interrupt.check()
}
