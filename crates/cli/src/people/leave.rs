//! `--leave`: the `decision.toml` in which everybody leaves.

use crate::error::Misused;
use crate::numbers::array;
use anyhow::Result;
use lemons_core::plane::{Vec2, vec2};
use std::fmt::Write;

/// \[m/s\] Mean speed of pedestrians who walk freely (Weidmann 1993).
const SPEED: f64 = 1.34;

#[derive(clap::Args)]
#[command(next_help_heading = "Leaving (with -o or --zip)")]
pub struct LeaveArguments {
    /// Everybody leaves: write the Trial's decision.toml, in which people walk through the doors to a line
    /// 1 m behind them, or to an --exit; of several, to the quickest by distance and queue
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
    /// One of them is missing.
    pub fn check(&self, doors: usize, written: bool) -> Result<()> {
        let missing = match (self.leave, doors + self.exits.len()) {
            (true, 0) => "--leave: there is no way out: give --door X,Y,WIDTH, or --exit X1,Y1,X2,Y2",
            (true, _) if !written => {
                "--leave writes decision.toml into a Trial: give -o TRIAL or --zip FILE.zip"
            }
            _ => return Ok(()),
        };
        Err(Misused(missing.into()).into())
    }

    /// The text of `decision.toml`: people leave by doors, with these lines \[m\] behind them, and by the exits.
    /// Without a speed \[m/s\] it is a usual one. Of several exits, people choose by the expected time.
    pub fn text(&self, doors: &[[Vec2; 2]], speed: Option<f64>) -> String {
        let model = self.model.as_deref().unwrap_or("rotational");
        let speed = speed.unwrap_or(SPEED);
        let mut text = format!("model = {model:?}\ndesired_speed = {speed:?}          # [m/s]\n");
        if doors.len() + self.exits.len() > 1 {
            text += "exit_choice = \"time\"           # by distance and queue\n";
        }
        text += "exits = [\n";
        for (kind, lines) in [("door", doors), ("exit", &self.exits)] {
            for (k, [a, b]) in lines.iter().enumerate() {
                let line = format!("[[{:?}, {:?}], [{:?}, {:?}]]", a.x, a.y, b.x, b.y);
                // Writing to a string does not fail.
                let _ = writeln!(text, "  {{ name = \"{kind} {k}\", line = {line} }},   # [m]");
            }
        }
        text + "]\n"
    }
}
