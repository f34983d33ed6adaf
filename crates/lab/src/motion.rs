//! The drive of people: as the Trial says, nothing, pushes, ways to walk, or exits and goals. Those who walk and are of a
//! kind have the desired speed of their kind.

use crate::base::Driven;
use crate::{Refused, require, within};
use lemons_core::plane::{Vec2, vec2};
use lemons_core::trial::{DRIVE_FILE, DriveTable, Pulse, Trial, drive_of_pulses};
use lemons_decision::rule::Waypoint;
use lemons_decision::{BalanceName, DecisionConfig, Person, Plan, plan};
use lemons_people::heading;
use serde::Deserialize;

/// The drive of people.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
#[allow(missing_docs)] // as said
pub enum Motion {
    /// The Trial's own files do.
    Own {},
    /// Nothing does.
    None {},
    /// Pulses do, and nothing else: whoever walks ahead is no part of a push.
    Push {
        pushes: Vec<Push>,
        /// Whether they have legs, and of which model.
        #[serde(default)]
        balance: BalanceName,
    },
    /// They walk (the paper's eq. 4) at a speed \[m/s\], everybody on the way whose first point is nearest; or on ways with
    /// shares, of which the seed chooses one for each.
    Walk {
        speed: f64,
        ways: Vec<Vec<Waypoint>>,
        #[serde(default)]
        shares: Option<Vec<f64>>,
        #[serde(default)]
        seed: u64,
    },
    /// They walk around walls, to the exits and goals of a decision.toml. Without exits, everybody goes to the nearest of
    /// several goals.
    Go { wishes: Box<DecisionConfig> },
}

/// A pulse on all whose centres lie in a circle at the start.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Push {
    /// \[m\] Middle of the circle.
    pub at: [f64; 2],
    /// \[m\]
    pub radius: f64,
    /// \[°\]
    pub direction: f64,
    /// \[N\] Greatest force on each.
    pub force: f64,
    /// \[s\]
    pub start: f64,
    /// \[s\]
    pub duration: f64,
}

/// Replaces what drives the people.
///
/// # Errors
/// A number is out of range, nobody is in a circle, or there is no way.
pub fn driven(mut driven: Driven, motion: &Motion) -> Result<Driven, Refused> {
    if !matches!(motion, Motion::Own {}) {
        driven = Driven::alone(driven.trial, driven.people);
        for here in &mut driven.trial.dynamics {
            (here.fp, here.mp) = (Vec2::zeros(), 0.0);
        }
    }
    match motion {
        Motion::Own {} => forget_deleted(&mut driven)?,
        Motion::None {} => {}
        Motion::Push { pushes, balance } => {
            driven.drive = drive(&driven.trial, pushes)?;
            if *balance != BalanceName::None {
                driven.wishes = DecisionConfig::standing(*balance).to_toml()?;
            }
        }
        Motion::Walk { speed, ways, shares, seed } => {
            let shares = shares.as_deref().map(|shares| (shares, *seed));
            driven.wishes =
                wishes(&driven.trial, *speed, ways, shares)?.with_speeds(own_speeds(&driven)).to_toml()?;
        }
        Motion::Go { wishes } => {
            let wishes = wishes.as_ref().clone().with_speeds(own_speeds(&driven));
            driven.wishes = plan::normalized(&driven.trial, &wishes).and_then(|all| all.to_toml())?;
        }
    }
    let Driven { trial, drive, wishes, .. } = &driven;
    let table = match drive.as_str() {
        "" => DriveTable::default(),
        text => DriveTable::from_csv(text.as_bytes())?,
    };
    let plan = (!wishes.is_empty()).then(|| Plan::of(trial, &DecisionConfig::from_toml(wishes)?));
    let plan = plan.transpose()?;
    Ok(Driven { table, plan, ..driven })
}

/// Tells that rows of a drive file between communication points have no effect.
pub fn missed(of: &Driven) -> Option<String> {
    let missed = of.table.missed(0.0, of.trial.parameters.time_step)?;
    Some(format!("{DRIVE_FILE}: {missed}"))
}

/// The files of a Trial must not name people who are not there any more.
fn forget_deleted(driven: &mut Driven) -> Result<(), Refused> {
    if driven.table.check_agents(Some(&driven.trial)).is_err() {
        driven.drive = driven.table.text_for(&driven.trial);
    }
    if !driven.wishes.is_empty() {
        let wishes = DecisionConfig::from_toml(&driven.wishes)?;
        if let Some(fewer) = wishes.without_others(&Person::all_of(&driven.trial)) {
            driven.wishes = fewer.to_toml()?;
        }
    }
    Ok(())
}

impl Push {
    fn pulse(&self) -> Result<Pulse, Refused> {
        let radius = within("radius of a push [m]", self.radius, [0.01, 1000.0])?;
        let force = within("force of a push [N]", self.force, [0.0, 1e5])?;
        let direction = within("direction of a push [°]", self.direction, [-360.0, 360.0])?;
        let start = within("start of a push [s]", self.start, [0.0, 1e4])?;
        let duration = within("duration of a push [s]", self.duration, [0.01, 1e4])?;
        let [x, y] = self.at;
        Ok(Pulse { at: vec2(x, y), radius, force: heading(direction) * force, start, duration })
    }
}

/// The drive of the pushes.
fn drive(trial: &Trial, pushes: &[Push]) -> Result<String, Refused> {
    let pulses = pushes.iter().map(Push::pulse).collect::<Result<Vec<_>, _>>()?;
    drive_of_pulses(trial, &pulses)
        .map_err(|lost| Refused(format!("push {}: nobody stands in its circle", lost + 1)))
}

/// Ids and desired speeds \[m/s\] of those who are of a kind, as `lemons crowd --leave` writes them.
fn own_speeds(of: &Driven) -> Vec<(String, f64)> {
    let people = of.people.iter().flatten().zip(&of.trial.agents);
    people.filter_map(|(agent, body)| Some((body.id.clone(), agent.member()?.speed))).collect()
}

/// decision.toml: the ways of everybody; with shares and their seed, if there are some.
fn wishes(
    trial: &Trial,
    speed: f64,
    ways: &[Vec<Waypoint>],
    shares: Option<(&[f64], u64)>,
) -> Result<DecisionConfig, Refused> {
    within("desired speed [m/s]", speed, [0.0, 20.0])?;
    for Waypoint { x, y, radius, .. } in ways.iter().flatten() {
        within("x of a way-point [m]", *x, [-1e4, 1e4])?;
        within("y of a way-point [m]", *y, [-1e4, 1e4])?;
        within("radius of a way-point [m]", *radius, [0.01, 1000.0])?;
    }
    if let Some((shares, seed)) = shares {
        require(shares.len() == ways.len(), || format!("{} shares of {} ways", shares.len(), ways.len()))?;
        return Ok(DecisionConfig::ways_by_shares(
            speed,
            ways.iter().cloned().zip(shares.iter().copied()),
            seed,
        ));
    }
    let wishes = DecisionConfig::nearest_of(&Person::all_of(trial), speed, ways);
    wishes.ok_or_else(|| Refused("nobody can walk: there is no way".into()))
}
