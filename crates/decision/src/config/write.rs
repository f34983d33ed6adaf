//! `decision.toml` as it is written: a key on a line, with its unit; an exit, a goal, a way-point and a way on a line each.

use super::{DecisionConfig, TargetConfig};
use crate::exit_choice::ExitChoice;
use crate::rule::Waypoint;
use crate::spread::Spread;
use serde::Serialize;
use toml::ser::{Error, ValueSerializer};

/// Length, in m.
const METRES: &str = "[m]";

fn value<T: Serialize>(of: &T) -> Result<String, Error> {
    let (mut text, mut of) = (String::new(), toml::Value::try_from(of)?);
    tidy(&mut of);
    of.serialize(ValueSerializer::new(&mut text))?;
    Ok(text)
}

/// Removes `wait = 0.0` of way-points, which says nothing.
fn tidy(value: &mut toml::Value) {
    match value {
        toml::Value::Array(all) => all.iter_mut().for_each(tidy),
        toml::Value::Table(table) => {
            table.retain(|key, value| key != "wait" || value.as_float() != Some(0.0));
            table.iter_mut().for_each(|(_, value)| tidy(value));
        }
        _ => {}
    }
}

/// A text with keys, under construction.
#[derive(Default)]
struct Text(String);

impl Text {
    /// A key, its value if it has one, and what a reader should know.
    fn key<T: Serialize>(&mut self, key: &str, of: Option<&T>, comment: &str) -> Result<(), Error> {
        if let Some(of) = of {
            self.0 += &format!("{key} = {}{comment}\n", value(of)?);
        }
        Ok(())
    }

    /// A key with a list, an element on a line.
    fn list<T: Serialize>(
        &mut self,
        key: &str,
        of: Option<&Vec<T>>,
        unit: fn(&T) -> &'static str,
    ) -> Result<(), Error> {
        let Some(of) = of else { return Ok(()) };
        self.0 += &format!("{key} = [\n");
        for element in of {
            self.0 += &format!("  {},   # {}\n", value(element)?, unit(element));
        }
        self.0 += "]\n";
        Ok(())
    }

    /// A table of its own.
    fn section<T: Serialize>(&mut self, name: &str, of: Option<&T>) -> Result<(), Error> {
        let Some(of) = of else { return Ok(()) };
        self.0 += &format!("[{name}]\n");
        // Tables in it stay on their line.
        toml::Table::try_from(of)?.iter().try_for_each(|(key, of)| self.key(key, Some(of), ""))
    }
}

/// A name as a part of a key.
fn part(name: &str) -> String {
    let bare = |c: char| c.is_ascii_alphanumeric() || "-_".contains(c);
    let is_bare = !name.is_empty() && name.chars().all(bare);
    if is_bare { name.to_owned() } else { toml::Value::String(name.to_owned()).to_string() }
}

/// Returns the text of a file.
pub(super) fn text(config: &DecisionConfig) -> Result<String, Error> {
    let metres = |_: &Waypoint| METRES;
    let target = |of: &TargetConfig| if of.open.is_some() { "[m], [s]" } else { METRES };
    let drawn = matches!(config.start, Some(Spread::Drawn(_)));
    let mut text = Text::default();
    text.key("model", config.model.as_ref(), "")?;
    text.key("balance", config.balance.as_ref(), "")?;
    text.key("desired_speed", config.desired_speed.as_ref(), "          # [m/s]")?;
    text.key("push", config.push.as_ref(), "                 # [N]")?;
    text.key("push_sd", config.push_sd.as_ref(), "               # [N]")?;
    text.key("seed", config.seed.as_ref(), "")?;
    text.key("start", config.start.as_ref(), if drawn { "   # [s]" } else { "                # [s]" })?;
    text.key("groups", config.groups.as_ref(), "   # docs/walking.md")?;
    text.list("waypoints", config.waypoints.as_ref(), metres)?;
    text.list("ways", config.ways.as_ref(), |_| METRES)?;
    let queue =
        if config.exit_choice == Some(ExitChoice::Time) { "           # by distance and queue" } else { "" };
    text.key("exit_choice", config.exit_choice.as_ref(), queue)?;
    text.list("exits", config.exits.as_ref(), target)?;
    text.list("goals", config.goals.as_ref(), target)?;
    text.list("sources", Some(&config.sources).filter(|all| !all.is_empty()), |_| "[s]")?;
    text.list("motivation", Some(&config.motivation).filter(|all| !all.is_empty()), |_| "[s]")?;
    text.section("queue", config.queue.as_ref())?;
    config.constants().try_for_each(|of| text.section(of.name().name(), Some(&of)))?;
    text.section("pendulum", config.pendulum.as_ref())?;
    text.section("two-level", config.two_level.as_ref())?;
    let mut agents: Vec<_> = config.agents.iter().collect();
    // 2 before 10.
    agents.sort_by_cached_key(|(id, _)| (id.parse::<u64>().unwrap_or(u64::MAX), (*id).clone()));
    for (id, own) in agents {
        text.section(&format!("agents.{}", part(id)), Some(own))?;
    }
    Ok(text.0)
}
