//! A crowd's bodies.

use crate::interrupt::{Interrupt, Interrupted};
use crate::output::Output;
use anyhow::{Context, Result};
use lemons_core::plane::Pose;
use lemons_people::{Agent, Body3d, CrowdSection, MeshPart, section, write_obj, write_stl};
use std::io::Write;

/// The pedestrians' bodies, made one after the other: those of a large crowd would not go into memory together.
pub struct Bodies<'a> {
    pub agents: &'a [Agent],
    pub poses: &'a [Pose],
    pub interrupt: &'a Interrupt,
}

impl Bodies<'_> {
    /// With the pedestrian's place in the crowd.
    fn each(&self) -> impl Iterator<Item = Result<(usize, Body3d, Pose)>> {
        let placed = self.agents.iter().zip(self.poses).enumerate();
        placed.filter_map(|(place, (agent, pose))| match agent {
            Agent::Pedestrian(person) => Some(match self.interrupt.pressed() {
                true => Err(Interrupted::given_up().into()),
                false => Body3d::of(person)
                    .with_context(|| format!("agent {place}"))
                    .map(|body| (place, body, *pose)),
            }),
            Agent::Bicycle(_) => None,
        })
    }

    /// Of all at each altitude \[m\]; bicycles have no outlines.
    pub fn sections(&self, altitudes: &[f64]) -> Result<Vec<CrowdSection>> {
        let empty = |&altitude: &f64| CrowdSection { altitude, bodies: vec![Vec::new(); self.agents.len()] };
        let mut sections: Vec<CrowdSection> = altitudes.iter().map(empty).collect();
        for body in self.each() {
            let (place, body, pose) = body?;
            for all in &mut sections {
                let one = section(&[(&body, pose)], all.altitude);
                all.bodies[place] = one.bodies.into_iter().flatten().collect();
            }
        }
        Ok(sections)
    }

    pub fn obj(&self, output: &mut Output) -> Result<()> {
        let mut failed = None;
        let parts = self.parts(&mut failed);
        output.fill(|file| write_obj(parts, file))?;
        failed.map_or(Ok(()), Err)
    }

    /// STL begins with the number of triangles, so all are made first.
    pub fn stl(&self, output: &mut Output) -> Result<()> {
        let mut failed = None;
        let parts: Vec<MeshPart> = self.parts(&mut failed).collect();
        failed.map_or(Ok(()), Err)?;
        output.fill(|file| write_stl(&parts, file))
    }

    /// The parts of everybody's mesh; ends early where a body cannot be made, and says why.
    fn parts<'a>(&'a self, failed: &'a mut Option<anyhow::Error>) -> impl Iterator<Item = MeshPart> + 'a {
        let bodies = self.each().map_while(|body| match body {
            Ok(body) => Some(body),
            Err(error) => {
                *failed = Some(error);
                None
            }
        });
        bodies.flat_map(|(place, body, pose)| {
            let parts = body.mesh().at(&pose).parts;
            parts
                .into_iter()
                .map(move |part| MeshPart { name: format!("agent_{place}_{}", part.name), ..part })
        })
    }

    /// The paper's comparison: what the shapes cover \[m²\] of the ground \[m²\], and what planes cut of the bodies.
    pub fn table(
        &self,
        out: &mut impl Write,
        sections: &[CrowdSection],
        shapes: f64,
        ground: f64,
    ) -> Result<()> {
        let bicycles = self.agents.iter().filter(|agent| matches!(agent, Agent::Bicycle(_))).count();
        let people = self.agents.len() - bicycles;
        let share = |area: f64| 100.0 * area / ground;
        writeln!(out, "\naltitude      people cut     covered   of the ground")?;
        for section in sections {
            let (altitude, cut, covered) = (section.altitude, section.cut(), section.covered());
            let share = share(covered);
            writeln!(out, "{altitude:>6.3} m   {cut:>6} of {people:<6} {covered:>7.3} m² {share:>9.1} %")?;
        }
        let all = self.agents.len();
        writeln!(out, "2D shapes  {all:>6}           {shapes:>7.3} m² {:>9.1} %", share(shapes))?;
        if bicycles > 0 {
            writeln!(out, "(the {bicycles} bicycles have no three-dimensional bodies)")?;
        }
        Ok(writeln!(out)?)
    }
}
