//! Which part of a run counts.

use lemons_results::measure::within;

/// A part of the time of a run.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Span {
    /// \[s\] From this communication point on; `None`: from the start.
    pub from: Option<f64>,
    /// \[s\] Up to this one; `None`: to the end.
    pub until: Option<f64>,
}

impl Span {
    /// Checks that it is a part.
    ///
    /// # Errors
    /// A sentence.
    pub(crate) fn check(&self) -> Result<(), String> {
        let wrong = |time: &f64| !(*time >= 0.0 && time.is_finite());
        if self.from.iter().chain(&self.until).any(wrong) {
            return Err("from and until must be finite numbers of seconds, not below 0".into());
        }
        match (self.from, self.until) {
            (Some(from), Some(until)) if from >= until => {
                Err(format!("from = {from:?}, until = {until:?}: the beginning is not before the end"))
            }
            _ => Ok(()),
        }
    }

    /// Whether a time \[s\] is in it.
    pub(crate) fn has(&self, time: f64) -> bool {
        within(time, self.from, self.until)
    }
}
