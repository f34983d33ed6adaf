//! `lemons person`: one person's shape, and the files of the body.

use super::outputs::Outputs;
use super::{line, measure};
use crate::error::Misused;
use crate::files::ForceOption;
use crate::print;
use crate::values::{parser_of, within};
use anyhow::Result;
use lemons_core::plane::Pose;
use lemons_core::trial::Geometry;
use lemons_people::{
    Body3d, BodyMeasure, CrowdMember, Sex, Shape, TrialSettings, crowd_trial, section, write_geojson,
    write_obj, write_stl, write_wkt,
};
use lemons_picture::{PictureScene, Style};
use std::io::Write;
use std::path::PathBuf;

#[derive(clap::Args)]
#[command(override_usage = "lemons person --breadth CM --depth CM --stature M --mass KG [OPTIONS]")]
pub struct Arguments {
    /// Shoulder breadth (bideltoid), in cm
    #[arg(long, value_name = "CM", value_parser = measure(BodyMeasure::Breadth))]
    breadth: f64,
    /// Chest depth, in cm
    #[arg(long, value_name = "CM", value_parser = measure(BodyMeasure::Depth))]
    depth: f64,
    /// Stature: body height without shoes, in m
    #[arg(long, value_name = "M", value_parser = measure(BodyMeasure::Stature))]
    stature: f64,
    /// Mass, in kg
    #[arg(long, value_name = "KG", value_parser = measure(BodyMeasure::Mass))]
    mass: f64,
    /// Sex of the three-dimensional body
    #[arg(long, value_parser = parser_of(&Sex::ALL, Sex::name), default_value = "male")]
    sex: Sex,
    /// Write the body's surface as Wavefront OBJ
    #[arg(long, value_name = "FILE.obj")]
    obj: Option<PathBuf>,
    /// Write the body's surface as binary STL
    #[arg(long, value_name = "FILE.stl")]
    stl: Option<PathBuf>,
    /// Write the body's horizontal slices as GeoJSON, in m
    #[arg(long, value_name = "FILE.geojson")]
    geojson: Option<PathBuf>,
    /// Write the body's horizontal slices as well-known text (WKT), a MULTIPOLYGON Z for each
    #[arg(long, value_name = "FILE.wkt")]
    wkt: Option<PathBuf>,
    /// Height of a slice, in cm
    #[arg(long, value_name = "CM", default_value = "2", value_parser = within(0.1, 100.0, " (cm)"))]
    slice_height: f64,
    /// Draw the shape from above as SVG
    #[arg(long, value_name = "FILE.svg")]
    svg: Option<PathBuf>,
    /// Draw the shape from above as PDF
    #[arg(long, value_name = "FILE.pdf")]
    pdf: Option<PathBuf>,
    #[command(flatten)]
    _force: ForceOption,
}

pub fn person(arguments: &Arguments) -> Result<()> {
    let Arguments { breadth, depth, stature, mass, .. } = *arguments;
    let person = super::person(arguments.sex, [breadth, depth, stature, mass])
        .map_err(|fault| Misused(format!("--depth {depth} --breadth {breadth}: {fault}")))?;
    let shape = Shape::of(&person)?;
    let moments = shape.moments();
    // Printed when all is written: who closes the pipe early has the files nevertheless.
    let mut out = Vec::new();
    writeln!(out, "disk    radius      ahead       left   (cm, about the centre of mass)")?;
    for (place, disk) in shape.disks.iter().enumerate() {
        let [radius, ahead, left] = [disk.radius, disk.centre.x, disk.centre.y].map(|length| 100.0 * length);
        writeln!(out, "{place:>4} {radius:>9.4} {ahead:>10.4} {left:>10.4}")?;
    }
    writeln!(out, "{}", line("breadth", 100.0 * shape.breadth(), "cm"))?;
    writeln!(out, "{}", line("depth", 100.0 * shape.depth(), "cm"))?;
    writeln!(out, "{}", line("area", 1e4 * moments.area, "cm²   (union of the disks)"))?;
    // Rounding may leave it on either side of the origin.
    let [ahead, left] =
        [moments.centroid.x, moments.centroid.y].map(|length| (1e5 * length).round().abs() / 1e3);
    writeln!(out, "centroid           {ahead:>10.3} cm ahead, {left:.3} cm left")?;
    let inertia = shape.inertia(person.mass);
    writeln!(out, "{}", line("moment of inertia", inertia, "kg m²   (about the centroid)"))?;

    let mut outputs = Outputs::open(&[
        ("--obj", "", &arguments.obj),
        ("--stl", "", &arguments.stl),
        ("--geojson", "", &arguments.geojson),
        ("--wkt", "", &arguments.wkt),
        ("--svg", "", &arguments.svg),
        ("--pdf", "", &arguments.pdf),
    ])?;
    if outputs.have_any(&["--obj", "--stl", "--geojson", "--wkt"]) {
        let body = Body3d::of(&person)?;
        writeln!(out, "{}", line("volume of the body", 1e3 * body.volume(), "l"))?;
        let mesh = body.mesh();
        outputs.fill("--stl", |file| write_stl(&mesh, file))?;
        outputs.fill("--obj", |file| write_obj(mesh, file))?;
        let placed = [(&body, Pose::default())];
        let layers = body.layers(arguments.slice_height / 100.0);
        let sections: Vec<_> = layers.map(|altitude| section(&placed, altitude)).collect();
        outputs.fill("--geojson", |file| write_geojson(&sections, file))?;
        outputs.fill("--wkt", |file| write_wkt(&sections, file))?;
    }
    let open = Geometry::default();
    let alone = [(CrowdMember::Pedestrian(person), Pose::default())];
    let trial = crowd_trial("person", &alone, open, &TrialSettings::default())?;
    outputs.draw(&PictureScene::at_start(&trial), &Style::default())?;
    let done = outputs.persist(|| Ok(()), &mut out);
    let printed = print::out().write_all(&out);
    done.and(Ok(printed?))
}
