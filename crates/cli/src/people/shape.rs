//! `lemons shape`: a drawn outline as the disks of a body.

use super::room::DrawingArguments;
use crate::print;
use anyhow::{Context, Result};
use lemons_core::plane::{Disk, Moments, Ring, union};
use lemons_core::xml::number;
use lemons_people::{Cover, MOST_COVERING, cover};
use lemons_scenario::WALLS;
use std::io::Write;
use std::path::PathBuf;

#[derive(clap::Args)]
pub struct Arguments {
    /// Drawing with a closed line: .dxf, .geojson, .wkt or .svg. The gaze is along x; the largest line
    /// counts
    #[arg(value_name = "FILE")]
    drawing: PathBuf,
    /// Number of disks
    #[arg(short, long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=MOST_COVERING as i64))]
    disks: u32,
    /// Print the disks as elements Shape of Agents.xml, of this material. Default: as `disks` of a part of a
    /// kind (docs/people.md)
    #[arg(long, value_name = "MATERIAL", value_parser = material)]
    xml: Option<String>,
    #[command(flatten)]
    reading: DrawingArguments,
}

/// An Id that needs no escapes in XML.
fn material(text: &str) -> Result<String, String> {
    let good = !text.is_empty() && text.chars().all(|c| c.is_alphanumeric() || "_-.".contains(c));
    good.then(|| text.to_owned()).ok_or_else(|| "must be letters, digits, _, - or .".into())
}

pub fn shape(arguments: &Arguments) -> Result<()> {
    let path = &arguments.drawing;
    let geometry = arguments.reading.read(path)?.plan.geometry(WALLS);
    let rings = geometry.walls.into_iter().filter(|wall| wall.corners.first() == wall.corners.last());
    let rings = rings.filter_map(|wall| Ring::through(wall.corners));
    let outline = rings.max_by(|a, b| a.area().total_cmp(&b.area()));
    let outline = outline.with_context(|| format!("{}: there is no closed line in it", path.display()))?;
    let found = cover(&outline, arguments.disks as usize).with_context(|| path.display().to_string())?;
    let mut out = print::out();
    match &arguments.xml {
        Some(material) => write!(out, "{}", elements(&found, material))?,
        None => write!(out, "# {}\n{}", remarks(&found).join("\n# "), rows(&found.disks))?,
    }
    Ok(out.flush()?)
}

/// The error of the cover.
fn remarks(found: &Cover) -> Vec<String> {
    let Cover { disks, areas: [outline, covered], gap, beyond, opposite } = found;
    let more = 100.0 * (covered / outline - 1.0);
    let mut remarks = vec![
        format!("{} disks: {covered:.4} m², of the outline {outline:.4} m² ({more:+.1} %)", disks.len()),
        format!(
            "the outline is at most {:.1} cm outside of them; they reach at most {:.1} cm beyond it",
            100.0 * gap,
            100.0 * beyond
        ),
    ];
    if !opposite {
        remarks.push("no two disks are opposite, so that a body of these alone does not look along x".into());
    }
    remarks
}

fn rows(disks: &[Disk]) -> String {
    let row =
        |Disk { radius, centre }: &Disk| format!("  [{:.4}, {:.4}, {radius:.4}],\n", centre.x, centre.y);
    format!("disks = [   # m: ahead, to the left, radius\n{}]\n", disks.iter().map(row).collect::<String>())
}

/// Elements of Agents.xml: offsets are from the centre of mass, of a body of uniform density.
fn elements(found: &Cover, material: &str) -> String {
    let Moments { area, centroid, polar } = union(&found.disks);
    let inertia = format!("moment of inertia: the mass times {:.5} m²", polar / area);
    let comments = remarks(found).into_iter().chain([inertia]).map(|line| format!("<!-- {line} -->\n"));
    let element = |Disk { radius, centre }: &Disk| {
        let at = *centre - centroid;
        let [x, y, radius] = [at.x, at.y, *radius].map(|value| number((1e4 * value).round() / 1e4));
        format!("<Shape Type=\"disk\" Radius=\"{radius}\" MaterialId=\"{material}\" Position=\"{x},{y}\"/>\n")
    };
    comments.chain(found.disks.iter().map(element)).collect()
}
