//! `--region` and `--door`: on which ground people stand, and how many on each.

use crate::error::Misused;
use crate::numbers::{array, list, within};
use anyhow::{Context, Result, bail};
use lemons_core::plane::{Vec2, vec2};
use lemons_core::trial::{FARTHEST, Geometry, TIMES};
use lemons_people::Door;
use lemons_people::placing::{FreeSpace, Region};

/// More are a mistake.
const MOST: f64 = 1e6;

pub const REGION_HELP: &str = include_str!("../help/regions.txt");

/// Number of people, or their density \[1/m²\]; neither: as --number and --density say.
pub type Amount = (Option<u32>, Option<f64>);

/// A value of `--region`.
#[derive(Debug, Clone)]
pub struct RegionArgument {
    /// \[m\]
    corners: Vec<Vec2>,
    amount: Amount,
}

impl RegionArgument {
    /// A polygon \[m\], with as many people as --number and --density say.
    pub fn of(corners: Vec<Vec2>) -> RegionArgument {
        RegionArgument { corners, amount: (None, None) }
    }
}

/// Where people stand together.
pub struct Ground {
    pub free: FreeSpace,
    /// As messages call it.
    pub name: String,
    pub amount: Amount,
}

/// Reads two corners, or a polygon, and perhaps how many people.
pub fn region(text: &str) -> Result<RegionArgument, String> {
    let (corners, amount) = text.split_once(';').unwrap_or((text, ""));
    let amount = match amount.trim().split_once('=') {
        None if amount.trim().is_empty() => (None, None),
        Some((key, value)) if key.trim() == "number" => {
            let number = value.trim().parse().ok().filter(|number| (1..=1_000_000).contains(number));
            (Some(number.ok_or("number: must be a whole number from 1 to 1000000")?), None)
        }
        Some((key, value)) if key.trim() == "density" => {
            let density = within(1e-6, 100.0, " (per m²)")(value);
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
    Ok(RegionArgument { corners, amount })
}

/// Reads x, y and width; then, perhaps, from and to when it is open. It need not close.
pub fn door(text: &str) -> Result<Door, String> {
    let numbers = list(text).unwrap_or_default();
    match numbers[..] {
        [x, y, width, ..]
            if [x, y].iter().all(|x| x.abs() <= FARTHEST) && (0.1..=1e3).contains(&width) =>
        {
            let wrong = || format!("after x, y and width, must be {TIMES}, as in 8,3,1,20,60; the last time may be left out");
            Door::of_numbers(&numbers).ok_or_else(wrong)
        }
        _ => Err("must be x, y and width in m, as in 8,3,1; the width is from 0.1 to 1000, x and y are from -1e9 to \
                  1e9"
            .into()),
    }
}

/// The ground of each region, in their order, among walls. `place` is as the user named the whole.
pub fn grounds(regions: &[RegionArgument], geometry: &Geometry, place: &str) -> Result<Vec<Ground>> {
    let mut drawn: Vec<Region> = Vec::new();
    let mut grounds = Vec::new();
    for (k, RegionArgument { corners, amount }) in regions.iter().enumerate() {
        let name = format!("region {k} of {place}");
        let free =
            Region::free_space(corners, geometry, &drawn).with_context(|| format!("--region: {name}"))?;
        drawn.push(Region::polygon(corners, &[]).context("--region")?);
        grounds.push(Ground { free, name, amount: *amount });
    }
    Ok(grounds)
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

/// The number of people on each ground, from what each says and from --number and --density for the others.
pub fn numbers(grounds: &[Ground], number: Option<u32>, density: Option<f64>) -> Result<Vec<usize>> {
    let open = grounds.iter().filter(|ground| ground.amount == (None, None));
    let open: f64 = open.map(|ground| ground.free.region.area()).sum();
    if open == 0.0
        && let Some(option) = number.map(|_| "--number").or(density.map(|_| "--density"))
    {
        bail!(Misused(format!("{option}: each --region says itself how many people it has")));
    }
    let mut before = 0.0;
    grounds
        .iter()
        .map(|Ground { free, name, amount }| {
            let area = free.region.area();
            let wanted = match (amount, number, density) {
                ((Some(number), _), ..) => f64::from(*number),
                ((None, Some(density)), ..) => (density * area).round(),
                (_, Some(_), Some(_)) => bail!(Misused(format!(
                    "--number and --density: one of them follows from the other in {name}"
                ))),
                (_, None, Some(density)) => (density * area).round(),
                (_, Some(number), None) => {
                    // Shares of the whole that add up to it.
                    let upto = |area: f64| (f64::from(number) * area / open).round();
                    let from = before;
                    before += area;
                    upto(before) - upto(from)
                }
                (_, None, None) => bail!(Misused(format!(
                    "the number of people is missing in {name}: give --number or --density, or ; number=N or \
                     ; density=D after the corners of a --region"
                ))),
            };
            if !(1.0..=MOST).contains(&wanted) {
                bail!("{name}: {wanted} people on its {area:.3} m²; there must be from 1 to {MOST}");
            }
            Ok(wanted as usize)
        })
        .collect()
}
