//! `--leave` and the options that need it: the `decision.toml` of a crowd.

use super::placing::WayOut;
use crate::error::Misused;
use crate::numbers::{array, within};
use anyhow::{Result, bail};
use lemons_core::distribution::{Distribution, Range};
use lemons_core::plane::{Vec2, vec2};
use lemons_decision::Spread;
use lemons_decision::plan::FLAT_PUSH;
use lemons_people::drawing::{self, Read};
use std::fmt::Write;

#[derive(clap::Args)]
#[command(next_help_heading = "Leaving and standing (with -o or --zip)")]
pub struct LeaveArguments {
    /// Everybody leaves: write the Trial's decision.toml, in which people walk through the doors to a line
    /// 1 m behind them, to an --exit, or, without --exit, to the exits of the drawing (--geometry); of
    /// several, to the quickest by distance and queue
    #[arg(long)]
    pub leave: bool,
    /// A line where people have left, from X1,Y1 to X2,Y2, in m. Can be given several times
    #[arg(
        long = "exit",
        value_name = "X1,Y1,X2,Y2",
        value_parser = exit,
        allow_hyphen_values = true,
        requires = "leave"
    )]
    exits: Vec<[Vec2; 2]>,
    /// How people walk around others. straight: not at all. Default: rotational
    #[arg(
        long,
        value_parser = ["rotational", "collision-free-speed", "social-force", "straight"],
        requires = "leave"
    )]
    model: Option<String>,
    /// Greatest force with which people push ahead, in N: of everybody, or the mean and the standard
    /// deviation of a normal distribution, as in 150,50. With rotational, squeezes hardly grow with it above
    /// 150 N (docs/walking.md). Default: no limit
    #[arg(long, value_name = "FORCE[,SD]", value_parser = push, requires = "leave")]
    push: Option<[f64; 2]>,
    /// Part of the people who walk in groups of two to four, as families do (docs/walking.md), from 0 to 1
    #[arg(long, value_name = "SHARE", value_parser = within(0.0, 1.0, ""), requires = "leave")]
    groups: Option<f64>,
    /// When people start to walk, in s: all at a time, or each at a time of its own from FROM to TO, all as
    /// likely (premovement times). They stand before. Default: at once
    #[arg(long, value_name = "TIME|FROM,TO", value_parser = start, requires = "leave")]
    start: Option<Spread>,
    /// How people who stand keep their balance, when they are pushed (docs/balance.md). Without --leave:
    /// everybody stands
    #[arg(long, value_parser = ["pendulum", "two-level"])]
    balance: Option<String>,
}

fn push(text: &str) -> Result<[f64; 2], String> {
    let numbers = array(text).or_else(|| array(text).map(|[push]| [push, 0.0]));
    let good = |numbers: &[f64; 2]| numbers.iter().all(|number| (0.0..=1e6).contains(number));
    numbers.filter(good).ok_or_else(|| "must be one or two numbers from 0 to 1e6 N, as in 150,50".into())
}

fn start(text: &str) -> Result<Spread, String> {
    let drawn = || array(text).map(|[min, max]| Spread::Drawn(Distribution::Uniform(Range { min, max })));
    let spread = array(text).map(|[time]| Spread::Same(time)).or_else(drawn);
    let good = |spread: &Spread| spread.check("start").is_ok();
    spread
        .filter(good)
        .ok_or_else(|| "must be one time, or two, the first below the second, from 0 to 1e9 s".into())
}

fn exit(text: &str) -> Result<[Vec2; 2], String> {
    match array(text) {
        Some([a, b, c, d]) if (a, b) != (c, d) => Ok([vec2(a, b), vec2(c, d)]),
        _ => Err("must be two different points in m, as in 9,1.5,9,4.5".into()),
    }
}

impl LeaveArguments {
    /// Checks that there is a way out, and a place for the file.
    ///
    /// # Errors
    /// One of them is missing, or people who only stand have a speed.
    pub fn check(&self, doors: usize, written: bool, speed: bool) -> Result<()> {
        if speed && !self.leave && self.balance.is_some() {
            bail!(Misused(
                "--speed: with --balance and without --leave, people stand: leave out one of the two".into()
            ));
        }
        let missing = match (self.leave, doors + self.exits.len()) {
            (true, 0) => "--leave: there is no way out: give --door X,Y,WIDTH, or --exit X1,Y1,X2,Y2",
            _ if self.is_wanted() && !written => {
                "--leave and --balance write decision.toml into a Trial: give -o TRIAL or --zip FILE.zip"
            }
            _ => return Ok(()),
        };
        Err(Misused(missing.into()).into())
    }

    /// Returns whether `decision.toml` is wanted.
    pub fn is_wanted(&self) -> bool {
        self.leave || self.balance.is_some()
    }

    /// The text of `decision.toml`: people leave by doors, with these lines \[m\] behind them, and by the exits.
    /// The seed chooses who starts when and who is in a group. Without a speed \[m/s\] it is a usual one, but for those
    /// who have one of their own. Of several exits, people choose by the expected time.
    pub fn text(
        &self,
        doors: &[WayOut],
        drawn: Option<&Read>,
        speed: Option<f64>,
        seed: u64,
        own: impl Iterator<Item = Option<f64>>,
    ) -> String {
        let balance = self.balance.iter().map(|model| format!("balance = {model:?}\n")).collect::<String>();
        if !self.leave {
            return balance;
        }
        if self.balance.is_some() {
            note!(
                "note: --balance: legs act on those who stand, before they start or at a goal; who walks cannot fall"
            );
        }
        let model = self.model.as_deref().unwrap_or("rotational");
        let speed = speed.unwrap_or(lemons_decision::DEFAULT_SPEED);
        let mut text = format!("model = {model:?}\n{balance}desired_speed = {speed:?}          # [m/s]\n");
        if let Some([push, deviation]) = self.push {
            if model == "rotational" {
                note!("note: --push: {FLAT_PUSH}");
            }
            let _ = writeln!(text, "push = {push:?}                 # [N]");
            if deviation > 0.0 {
                let _ = writeln!(text, "push_sd = {deviation:?}               # [N]");
            }
        }
        if self.start.is_some() || self.groups.is_some() {
            let _ = writeln!(text, "seed = {seed}");
        }
        match self.start {
            Some(Spread::Drawn(Distribution::Uniform(Range { min, max }))) => {
                let _ = writeln!(text, "start = {{ min = {min:?}, max = {max:?} }}   # [s]");
            }
            Some(Spread::Same(start)) => {
                let _ = writeln!(text, "start = {start:?}                # [s]");
            }
            _ => {}
        }
        if let Some(share) = self.groups {
            let _ = writeln!(text, "groups = {{ share = {share:?} }}   # docs/walking.md");
        }
        let drawn = drawn.map(|read| &read.plan);
        text += &drawn.map_or(String::new(), way);
        let drawn = drawn.filter(|_| self.exits.is_empty()).map_or(&[][..], |plan| &plan.exits);
        if doors.len() + self.exits.len() + drawn.len() > 1 {
            text += "exit_choice = \"time\"           # by distance and queue\n";
        }
        text += "exits = [\n";
        let exits: Vec<WayOut> = self.exits.iter().map(|line| (*line, Vec::new())).collect();
        for (kind, lines) in [("door", doors), ("exit", &exits)] {
            for (k, ([a, b], open)) in lines.iter().enumerate() {
                let line = format!("[[{:?}, {:?}], [{:?}, {:?}]]", a.x, a.y, b.x, b.y);
                let times = if open.is_empty() { String::new() } else { format!(", open = {open:?}") };
                let units = if open.is_empty() { "[m]" } else { "[m], [s]" };
                // Writing to a string does not fail.
                let _ = writeln!(text, "  {{ name = \"{kind} {k}\", line = {line}{times} }},   # {units}");
            }
        }
        drawn.iter().for_each(|place| text += &drawn_exit(place));
        text += "]\n";
        for (id, speed) in own.enumerate().filter_map(|(id, own)| Some((id, own?))) {
            let _ = writeln!(text, "[agents.{id}]\ndesired_speed = {speed:?}");
        }
        text
    }
}

/// A name as TOML has it.
fn quoted(name: &str) -> toml::Value {
    toml::Value::String(name.to_owned())
}

fn drawn_exit(drawing::Place { name, corners }: &drawing::Place) -> String {
    let corners: Vec<String> =
        corners.iter().map(|corner| format!("[{:?}, {:?}]", corner.x, corner.y)).collect();
    let shape = if corners.len() == 2 { "line" } else { "polygon" };
    format!("  {{ name = {}, {shape} = [{}] }},   # [m]\n", quoted(name), corners.join(", "))
}

/// The way-points of a drawing, if their names say their order.
fn way(plan: &drawing::Plan) -> String {
    let Some(way) = plan.way() else {
        if !plan.waypoints.is_empty() {
            note!(
                "note: way-points of the drawing are not used: their names end in no numbers that say an order"
            );
        }
        return String::new();
    };
    let mut text = String::from("waypoints = [\n");
    for place in &way {
        let (middle, radius) = place.middle();
        let radius = radius.map_or(String::new(), |radius| format!(", radius = {radius:?}"));
        let _ = writeln!(
            text,
            "  {{ x = {:?}, y = {:?}{radius} }},   # [m] {}",
            middle.x,
            middle.y,
            comment(&place.name)
        );
    }
    note!("note: everybody goes to the {} way-points of the drawing first", way.len());
    text + "]\n"
}

/// A name without what could end a comment.
fn comment(name: &str) -> String {
    name.chars().filter(|c| !c.is_control()).collect()
}
