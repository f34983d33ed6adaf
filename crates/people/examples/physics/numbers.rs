//! The numbers of the page.

use crate::cases::*;
use crowd_mechanics::setup::Setup;
use lemons_people::{Shape, paper_materials};
use lemons_trial::stiffness;
use std::f64::consts::PI;
use std::fmt::Write;

/// Returns the numbers of the page as text.
pub fn text() -> Result<String> {
    let mut out = String::new();
    let person = person();
    let shape = Shape::of(&person)?;
    writeln!(out, "body of 49 cm × 25 cm, 80 kg")?;
    writeln!(out, "  area                          {:.4} m²", shape.moments().area)?;
    writeln!(out, "  moment of inertia             {:.3} kg m²", shape.inertia(person.mass))?;

    let materials = paper_materials();
    let skin = materials.intrinsic.iter().find(|m| m.id == "human_naked").ok_or("human_naked")?;
    let contact =
        materials.binary.iter().find(|c| c.id1 == skin.id && c.id2 == skin.id).ok_or("its contact")?;
    let (normal, tangential) = stiffness(skin, skin);
    writeln!(out, "two people, human_naked")?;
    let soft = (4.0 * skin.shear_modulus - skin.young_modulus) / (4.0 * skin.shear_modulus.powi(2));
    writeln!(out, "  (4G − E)/(4G²)                {soft:.3e} m/N")?;
    writeln!(out, "  k_n                           {:.3} MN/m", 1e-6 * normal)?;
    writeln!(out, "  k_t                           {:.3} MN/m", 1e-6 * tangential)?;
    let pressed = 200.0;
    let slips = contact.kinetic_friction * pressed;
    writeln!(out, "  pressed with 200 N: overlap   {:.3} mm", 1e3 * pressed / normal)?;
    writeln!(out, "    slips above                 {slips:.0} N")?;
    writeln!(out, "    elongation there            {:.3} mm", 1e3 * slips / tangential)?;

    let found = collision()?;
    let reduced = 0.5 * person.mass;
    let decay = contact.gamma_normal / (2.0 * reduced);
    let pulsation = (normal / reduced - decay * decay).sqrt();
    let duration = PI / pulsation;
    let undamped = CLOSING * (normal * reduced).sqrt();
    writeln!(out, "they collide at 1 m/s           formula     engine")?;
    let last = found.instants.last().ok_or("they never touched")?;
    writeln!(out, "  lasts [ms]                    {:<11.2} {:.2}", 1e3 * duration, 1e3 * last.time)?;
    let kept = (-decay * duration).exp();
    writeln!(out, "  parts at [m/s]                {kept:<11.3} {:.3}", found.parting)?;
    writeln!(out, "  greatest force [kN]           {:<11.2} {:.2}", 1e-3 * undamped, 1e-3 * found.peak)?;
    writeln!(
        out,
        "  deepest overlap [mm]          {:<11.2} {:.2}",
        1e3 * CLOSING * (reduced / normal).sqrt(),
        1e3 * found.deepest
    )?;

    let speeds = pushed()?;
    let at = |time: f64| speeds.iter().find(|(t, _)| (*t - time).abs() < 1e-6).map_or(f64::NAN, |p| p.1);
    let end = PUSH.0 / (person.mass * FLOOR);
    let after = |time: f64| end * (1.0 - (-FLOOR * time).exp());
    writeln!(out, "alone, pushed with 482.4 N      formula     engine")?;
    for time in [0.22, 0.5, 1.2] {
        writeln!(out, "  speed after {time:.2} s [m/s]      {:<11.3} {:.3}", after(time), at(time))?;
    }

    let passage = passage()?;
    let steps = Setup::of(&passage).steps().ok_or("nobody can touch anybody")?;
    let accurate = steps.accurate_to(1e-3).ok_or("no step is so accurate")?;
    writeln!(out, "mechanical step")?;
    writeln!(out, "  stable up to [s]              {:.1e}", steps.stable())?;
    writeln!(out, "  for an accuracy of 1 mm [s]   {accurate:.1e}")?;
    let walkers = walkers(&passage)?;
    let free = walkers.iter().filter(|walker| walker.free).count();
    writeln!(out, "in the passage                  {free} of {} people fly", walkers.len())?;
    Ok(out)
}
