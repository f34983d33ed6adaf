//! `--leave` and the options that need it: the `decision.toml` of a crowd.

use super::ranged;
use crate::error::Misused;
use crate::values::{array, parser_of};
use anyhow::{Result, bail};
use lemons_core::distribution::{Distribution, Range};
use lemons_core::plane::{Vec2, vec2};
use lemons_decision::{BalanceName, GroupsConfig, Spread, TargetConfig, WalkingModelName};
use lemons_scenario::Scenario;

const BALANCES: [BalanceName; 2] = [BalanceName::Pendulum, BalanceName::TwoLevel];

#[derive(clap::Args)]
#[command(next_help_heading = "Leaving and standing (with -o or --zip)")]
pub struct LeaveArguments {
    /// Everybody leaves: write the Trial's decision.toml, in which people walk through the doors to a line
    /// 1 m behind them, to an --exit, or, without --exit, to the exits of the drawing (--geometry); of
    /// several, to the quickest by distance and queue
    #[arg(long)]
    pub leave: bool,
    /// A line where people have left, from X1,Y1 to X2,Y2, in m. Can be given several times
    #[arg(long = "exit", value_name = "X1,Y1,X2,Y2", value_parser = exit, allow_hyphen_values = true)]
    exits: Vec<[Vec2; 2]>,
    /// How people walk around others. straight: not at all. Default: rotational
    #[arg(long, value_parser = parser_of(WalkingModelName::ALL, WalkingModelName::name))]
    model: Option<WalkingModelName>,
    /// Greatest force with which people push ahead, in N: of everybody, or the mean and the standard
    /// deviation of a normal distribution, as in 150,50. With rotational, squeezes hardly grow with it above
    /// 150 N (docs/walking.md). Default: no limit
    #[arg(long, value_name = "FORCE[,SD]", value_parser = push)]
    push: Option<[f64; 2]>,
    /// Part of the people who walk in groups of two to four, as families do (docs/walking.md), from 0 to 1
    #[arg(long, value_name = "SHARE", value_parser = ranged("groups", ""))]
    groups: Option<f64>,
    /// When people start to walk, in s: all at a time, or each at a time of its own from FROM to TO, all as
    /// likely (premovement times). They stand before. Default: at once
    #[arg(long, value_name = "TIME|FROM,TO", value_parser = start)]
    start: Option<Spread>,
    /// How people who stand keep their balance, when they are pushed (docs/balance.md). Without --leave:
    /// everybody stands
    #[arg(long, value_parser = parser_of(&BALANCES, BalanceName::name))]
    balance: Option<BalanceName>,
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
    /// Returns whether an option asks for a decision.toml.
    pub fn is_wanted(&self) -> bool {
        self.leave || self.balance.is_some()
    }

    /// Fills in what is given.
    ///
    /// # Errors
    /// There are exits, and nobody leaves.
    pub fn fill(&self, scenario: &mut Scenario) -> Result<()> {
        scenario.leave |= self.leave;
        if !scenario.leave && !self.exits.is_empty() {
            bail!(Misused("--exit: nobody walks without --leave".into()));
        }
        let decision = &mut scenario.decision;
        if !self.exits.is_empty() {
            let exit = |(k, line): (usize, &[Vec2; 2])| TargetConfig {
                name: Some(format!("exit {k}")),
                line: Some(line.map(Into::into)),
                ..TargetConfig::default()
            };
            decision.exits = Some(self.exits.iter().enumerate().map(exit).collect());
        }
        decision.model = self.model.or(decision.model);
        if let Some([push, deviation]) = self.push {
            decision.push = Some(push);
            decision.push_sd = (deviation > 0.0).then_some(deviation);
        }
        if let Some(share) = self.groups {
            decision.groups = Some(GroupsConfig { share: Some(share), ..GroupsConfig::default() });
        }
        decision.start = self.start.or(decision.start);
        decision.balance = self.balance.or(decision.balance);
        Ok(())
    }
}
