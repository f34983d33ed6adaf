//! What is written beside the Trial of a crowd: tables, meshes, pictures.

use super::crowd_files::Bodies;
use crate::error::and_then;
use crate::interrupt::Interrupt;
use crate::output::Output;
use anyhow::Result;
use lemons_people::{Agent, Shape, TrialSettings, crowd_trial, write_geojson, write_wkt};
use lemons_picture::{Bicycle as Drawn, Colour, Fill, Scene, Style, pdf, png, svg};
use lemons_plane::Pose;
use lemons_trial::Geometry;
use std::io::{self, Write};
use std::path::Path;

/// \[px\]
const PICTURE_WIDTH: u32 = 1200;

/// Files that appear when all is done.
pub struct Outputs {
    pub population: Option<Output>,
    pub light_xml: Option<Output>,
    pub sections: Option<Output>,
    pub sections_wkt: Option<Output>,
    pub obj: Option<Output>,
    pub stl: Option<Output>,
    pub svg: Option<Output>,
    pub pdf: Option<Output>,
    pub png: Option<Output>,
}

impl Outputs {
    /// Writes sections at altitudes \[m\], and meshes. `covered` and `ground` \[m²\] are for the table of sections.
    pub fn write_bodies(
        &mut self,
        bodies: &Bodies,
        altitudes: Option<&[f64]>,
        [covered, ground]: [f64; 2],
        out: &mut Vec<u8>,
    ) -> Result<()> {
        if let Some(altitudes) = altitudes {
            let sections = bodies.sections(altitudes)?;
            bodies.table(out, &sections, covered, ground)?;
            if let Some(output) = &mut self.sections {
                output.fill(|file| write_geojson(&sections, file))?;
            }
            if let Some(output) = &mut self.sections_wkt {
                output.fill(|file| write_wkt(&sections, file))?;
            }
        }
        if let Some(output) = &mut self.obj {
            bodies.obj(output)?;
        }
        if let Some(output) = &mut self.stl {
            bodies.stl(output)?;
        }
        Ok(())
    }

    pub fn is_empty(&self) -> bool {
        let Outputs { population, light_xml, sections, sections_wkt, obj, stl, .. } = self;
        let others = [population, light_xml, sections, sections_wkt, obj, stl];
        others.iter().all(|file| file.is_none()) && !self.has_pictures()
    }

    fn has_pictures(&self) -> bool {
        [&self.svg, &self.pdf, &self.png].iter().any(|file| file.is_some())
    }

    /// Pedestrians as a Trial has them, bicycles beside them; all under their places in the crowd.
    pub fn draw_mixed(
        &mut self,
        agents: &[Agent],
        shapes: &[Shape],
        poses: &[Pose],
        geometry: Geometry,
        settings: &TrialSettings,
    ) -> Result<()> {
        let (mut people, mut bicycles) = ((Vec::new(), Vec::new(), Vec::new(), Vec::new()), Vec::new());
        for (place, ((agent, shape), pose)) in agents.iter().zip(shapes).zip(poses).enumerate() {
            match agent {
                Agent::Pedestrian(person) => {
                    people.extend([(*person, shape.clone(), *pose, place.to_string())]);
                }
                Agent::Bicycle(bicycle) => {
                    let [wheels, rider] = bicycle.rectangles();
                    bicycles.push(Drawn { id: place.to_string(), pose: *pose, wheels, rider });
                }
            }
        }
        let (people, shapes, poses, ids) = people;
        let mut trial = crowd_trial("crowd", &people, &shapes, &poses, geometry, settings)?;
        trial.agents.iter_mut().zip(ids).for_each(|(agent, id)| agent.id = id);
        let fill = if people.is_empty() { Fill::Single(Colour::BODY) } else { Fill::BodyArea };
        let mut scene = Scene::at_start(&trial);
        scene.bicycles = bicycles;
        self.draw(&scene, fill)
    }

    pub fn draw(&mut self, scene: &Scene, fill: Fill) -> Result<()> {
        if !self.has_pictures() {
            return Ok(());
        }
        let text = svg(scene, &Style { width: PICTURE_WIDTH.into(), fill, ..Style::default() });
        if let Some(output) = &mut self.svg {
            output.fill(|file| file.write_all(text.as_bytes()))?;
        }
        if let Some(output) = &mut self.pdf {
            let picture = pdf(&text)?;
            output.fill(|file| file.write_all(&picture))?;
        }
        if let Some(output) = &mut self.png {
            let picture = png(&text, PICTURE_WIDTH)?;
            output.fill(|file| file.write_all(&picture))?;
        }
        Ok(())
    }

    /// Puts each in its place, also when that of another cannot be taken.
    pub fn persist(self, interrupt: &Interrupt, out: &mut impl Write) -> Result<()> {
        let mut done = Ok(());
        let all = [
            ("population", self.population),
            ("light XML", self.light_xml),
            ("sections", self.sections),
            ("sections", self.sections_wkt),
            ("bodies", self.obj),
            ("bodies", self.stl),
            ("picture", self.svg),
            ("picture", self.pdf),
            ("picture", self.png),
        ];
        for (what, output) in all {
            let Some(output) = output else { continue };
            interrupt.check()?;
            let path = output.path().to_owned();
            let placed = output.persist().and_then(|()| Ok(say(out, what, &path)?));
            done = and_then(done, placed);
        }
        done
    }
}

/// Says what was written where.
pub fn say(out: &mut impl Write, what: &str, path: &Path) -> io::Result<()> {
    writeln!(out, "{what:<18} {}", path.display())
}
