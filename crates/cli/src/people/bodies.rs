//! A crowd's bodies.

use crate::interrupt::Interrupt;
use anyhow::Result;
use lemons_core::plane::Pose;
use lemons_people::{Agent, Body3d, CrowdSection, MeshPart, section};
use std::io::Write;

/// The pedestrians' bodies, made one after the other: those of a large crowd would not go into memory together. Who
/// can have none was refused before.
pub struct Bodies<'a> {
    pub crowd: &'a [(Agent, Pose)],
    pub interrupt: &'a Interrupt,
}

impl Bodies<'_> {
    /// With the pedestrian's place in the crowd, until Ctrl-C.
    fn each(&self) -> impl Iterator<Item = (usize, Body3d, Pose)> {
        let wanted = self.crowd.iter().enumerate().take_while(|_| !self.interrupt.pressed());
        wanted
            .filter_map(|(place, (agent, pose))| Some((place, Body3d::of(&agent.pedestrian()?).ok()?, *pose)))
    }

    /// Cuts all bodies at each altitude \[m\]; bicycles have no outlines.
    pub fn sections(&self, altitudes: &[f64]) -> Vec<CrowdSection> {
        let empty = |&altitude: &f64| CrowdSection { altitude, bodies: vec![Vec::new(); self.crowd.len()] };
        let mut sections: Vec<CrowdSection> = altitudes.iter().map(empty).collect();
        for (place, body, pose) in self.each() {
            for all in &mut sections {
                let one = section(&[(&body, pose)], all.altitude);
                all.bodies[place] = one.bodies.into_iter().flatten().collect();
            }
        }
        sections
    }

    /// The parts of everybody's surface.
    pub fn parts(&self) -> impl Iterator<Item = MeshPart> {
        self.each().flat_map(|(place, body, pose)| body.surfaces(&place.to_string(), &pose))
    }

    /// The paper's comparison: what the shapes cover \[m²\] of the ground \[m²\], and what planes cut of the bodies.
    pub fn table(
        &self,
        out: &mut impl Write,
        sections: &[CrowdSection],
        shapes: f64,
        ground: f64,
    ) -> Result<()> {
        let all = self.crowd.len();
        let people = self.crowd.iter().filter(|(agent, _)| agent.pedestrian().is_some()).count();
        let share = |area: f64| 100.0 * area / ground;
        writeln!(out, "\naltitude      people cut     covered   of the ground")?;
        for section in sections {
            let (altitude, cut, covered) = (section.altitude, section.cut(), section.covered());
            let share = share(covered);
            writeln!(out, "{altitude:>6.3} m   {cut:>6} of {people:<6} {covered:>7.3} m² {share:>9.1} %")?;
        }
        writeln!(out, "2D shapes  {all:>6}           {shapes:>7.3} m² {:>9.1} %", share(shapes))?;
        if people < all {
            let bicycles = all - people;
            writeln!(out, "(the {bicycles} bicycles have no three-dimensional bodies)")?;
        }
        Ok(writeln!(out)?)
    }
}
