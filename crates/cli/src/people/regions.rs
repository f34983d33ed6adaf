//! `--region` and `--door`: on which ground people stand, and how many on each.

use super::ranged;
use crate::values::{array, list};
use lemons_core::plane::vec2;
use lemons_people::placing::FreeSpace;
use lemons_scenario::{DoorForm, MOST_PEOPLE, RegionForm};

pub const REGION_HELP: &str = include_str!("../help/regions.txt");

/// Reads two corners, or a polygon, and perhaps how many people.
pub fn region(text: &str) -> Result<RegionForm, String> {
    let (corners, amount) = text.split_once(';').unwrap_or((text, ""));
    let (number, density) = match amount.trim().split_once('=') {
        None if amount.trim().is_empty() => (None, None),
        Some((key, value)) if key.trim() == "number" => {
            let number = value.trim().parse().ok().filter(|number| (1..=MOST_PEOPLE).contains(number));
            let must = || format!("number: must be a whole number from 1 to {MOST_PEOPLE}");
            (Some(number.ok_or_else(must)?), None)
        }
        Some((key, value)) if key.trim() == "density" => {
            let density = ranged("density", " (per m²)")(value);
            (None, Some(density.map_err(|must| format!("density: {must}"))?))
        }
        _ => return Err(format!("{:?}: after ; stands number=N or density=D", amount.trim())),
    };
    let places: Vec<&str> = corners.split_whitespace().collect();
    let place = |text: &&str| array(text).map(|[x, y]| vec2(x, y));
    let polygon = || (places.len() >= 3).then(|| places.iter().map(place).collect()).flatten();
    let corners = match array(corners) {
        Some([a, b, c, d]) => vec![vec2(a, b), vec2(c, b), vec2(c, d), vec2(a, d)],
        _ => polygon().ok_or(
            "must be two opposite corners in m, as in 0,0,8,6, or the corners of a polygon, as in \
             \"0,0 8,0 8,6\"",
        )?,
    };
    Ok(RegionForm { number, density, ..RegionForm::of(&corners) })
}

/// Reads x, y and width; then, perhaps, from and to when it is open. It need not close.
pub fn door(text: &str) -> Result<DoorForm, String> {
    DoorForm::of(&list(text).unwrap_or_default()).ok_or_else(DoorForm::rule)
}

/// Describes what walls make of a ground, for the summary.
pub fn described(FreeSpace { rooms, obstacles, walls, .. }: &FreeSpace) -> String {
    let named = |(what, ids): (&str, &Vec<String>)| {
        let s = if ids.len() == 1 { "" } else { "s" };
        let ids = if ids.len() > 2 { ids.len().to_string() } else { ids.join(", ") };
        format!("{what}{s} {ids}")
    };
    let all = [("inside wall", rooms), ("obstacle", obstacles), ("open wall", walls)].into_iter();
    all.filter(|(_, ids)| !ids.is_empty()).map(named).collect::<Vec<_>>().join(", ")
}
