//! When a point ends before its time.

use crate::output::Of;
use serde::Deserialize;

/// A condition that ends a point at the first communication point where it holds.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stop {
    /// The output.
    pub of: Of,
    /// The value is this or more.
    pub at_least: Option<f64>,
    /// The value is this or less.
    pub at_most: Option<f64>,
    /// Ids of agents in Agents.xml, for all of which it must hold; empty: all agents.
    #[serde(default)]
    pub agents: Vec<String>,
}

impl Stop {
    /// Checks that it is complete.
    ///
    /// # Errors
    /// A sentence that names what is missing.
    pub fn check(&self) -> Result<(), String> {
        self.of.check(&self.agents)?;
        match (self.at_least, self.at_most) {
            (Some(limit), None) | (None, Some(limit)) if limit.is_finite() => Ok(()),
            (Some(_), None) | (None, Some(_)) => Err("its limit must be a finite number".into()),
            _ => Err("it needs one of at_least and at_most".into()),
        }
    }

    /// Returns whether it holds for all these values. Those of agents who have left (`None`) do not count; for nobody it does not
    /// hold.
    pub(crate) fn holds(&self, values: &[Option<f64>]) -> bool {
        let beyond = |value: f64| {
            self.at_least.is_none_or(|least| value >= least) && self.at_most.is_none_or(|most| value <= most)
        };
        let mut there = values.iter().flatten().copied().peekable();
        there.peek().is_some() && there.all(beyond)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_holds_for_all_or_not_at_all() {
        let stop = |text: &str| toml::from_str::<Stop>(text).unwrap();
        let least = stop("of = 'x'\nat_least = 2");
        assert!(least.holds(&[2.0, 3.0].map(Some)) && !least.holds(&[2.0, 1.9].map(Some)));
        assert!(!least.holds(&[2.0, f64::NAN].map(Some)));
        assert!(least.holds(&[None, Some(2.0)]) && !least.holds(&[None, None]));
        let most = stop("of = 'decision.Left'\nat_most = 0");
        assert!(most.holds(&[0.0].map(Some)) && !most.holds(&[1.0].map(Some)));
        for (text, said) in [
            ("of = 'x'", "one of at_least and at_most"),
            ("of = 'x'\nat_least = 1\nat_most = 2", "one of at_least and at_most"),
            ("of = 'x'\nat_least = inf", "finite"),
            ("of = 'mood'\nat_least = 1", "mood"),
            ("of = 'decision.Arrived'\nat_least = 1\nagents = ['3']", "agents"),
        ] {
            let error = stop(text).check().unwrap_err();
            assert!(error.contains(said), "{error}");
        }
    }
}
