//! Messages that an FMU logs.

use crate::error::{MasterError, Result};
use lemons_fmi::{Status, Version};
use std::sync::Mutex;

/// Returns what the names of the functions of a version begin with.
pub(crate) fn prefix(version: Version) -> &'static str {
    if version == Version::V2 { "fmi2" } else { "fmi3" }
}

/// Returns the status with this number, if this version has it.
pub(crate) fn status_of(version: Version, code: i32) -> Option<Status> {
    use Status::{Discard, Error, Fatal, Ok, Pending, Warning};
    let known = [Ok, Warning, Discard, Error, Fatal].into_iter();
    known.chain((version == Version::V2).then_some(Pending)).find(|status| *status as i32 == code)
}

/// Messages of one kind that are kept; further ones are counted.
const MOST_MESSAGES: usize = 1000;

/// The first messages of a kind, and how many further ones there were.
#[derive(Default)]
struct Heard(Mutex<(Vec<String>, u64)>);

impl Heard {
    fn push(&self, message: String) {
        if let Ok(mut heard) = self.0.lock() {
            if heard.0.len() < MOST_MESSAGES { heard.0.push(message) } else { heard.1 += 1 }
        }
    }

    /// All of them since the last call.
    fn take(&self) -> Vec<String> {
        let (mut first, more) =
            self.0.lock().map(|mut heard| std::mem::take(&mut *heard)).unwrap_or_default();
        if more > 0 {
            first.push(format!("and {more} more"));
        }
        first
    }
}

/// Messages of an FMU. Errors become the run's error; warnings are kept for the end.
#[derive(Default)]
pub(crate) struct Messages {
    errors: Heard,
    warnings: Heard,
    /// Steps that returned the status Warning: where the first of them began \[s\], and their number.
    warned: Mutex<Option<(f64, u64, Version)>>,
    /// Where the FMU is unpacked, and what the user knows it by.
    names: [String; 2],
}

impl Messages {
    /// None yet. In those that are told, the second of these names stands for the first one.
    pub fn with(names: [String; 2]) -> Messages {
        Messages { names, ..Messages::default() }
    }

    pub fn hear(&self, status: Option<Status>, message: &str) {
        let [unpacked, shown] = &self.names;
        let message = if unpacked.is_empty() { message.to_owned() } else { message.replace(unpacked, shown) };
        match status {
            Some(Status::Ok) => {}
            Some(Status::Warning) => self.warnings.push(message),
            // Also Discard: the reason why a value or a step is refused.
            _ => self.errors.push(message),
        }
    }

    /// Returns the status of a call, or as an error what the FMU has logged about its refusal.
    pub fn done(&self, version: Version, call: &str, code: i32) -> Result<Status> {
        // What was logged as an error in a call that succeeded is not the reason of a later refusal.
        let errors = self.errors();
        Err(MasterError::new(match status_of(version, code) {
            Some(status @ (Status::Ok | Status::Warning)) => return Ok(status),
            _ if !errors.is_empty() => errors.join("\n"),
            Some(status) => format!("{call} returned {status:?}"),
            None => format!("{call} returned {code}, which is no status of FMI"),
        }))
    }

    /// Notes a step from a time \[s\] that returned the status Warning.
    pub fn warned(&self, time: f64, version: Version) {
        if let Ok(mut warned) = self.warned.lock() {
            warned.get_or_insert((time, 0, version)).1 += 1;
        }
    }

    /// The warnings since the last call.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = self.warnings.take();
        if let Some((time, steps, version)) = self.warned.lock().ok().and_then(|mut warned| warned.take()) {
            let more = match steps - 1 {
                0 => String::new(),
                1 => ", and 1 later step".to_owned(),
                more => format!(", and {more} later steps"),
            };
            let status = format!("{}Warning{more}", prefix(version));
            warnings.push(format!("warning: the step from t = {time:?} s returned the status {status}"));
        }
        warnings
    }

    /// The errors since the last call.
    pub fn errors(&self) -> Vec<String> {
        self.errors.take()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_without_end_are_counted() {
        let messages = Messages::default();
        let numbers = |list: &[String]| (list.len(), list[999].clone(), list.last().cloned());
        (0..1012).for_each(|k| messages.hear(Some(Status::Warning), &k.to_string()));
        (0..1001).for_each(|k| messages.hear(Some(Status::Error), &k.to_string()));
        assert_eq!(numbers(&messages.warnings()), (1001, "999".into(), Some("and 12 more".into())));
        assert_eq!(numbers(&messages.errors()), (1001, "999".into(), Some("and 1 more".into())));
        assert!(messages.warnings().is_empty() && messages.errors().is_empty());
        // A step that returns fmi2Warning in silence.
        [0.5, 0.6, 0.7].into_iter().for_each(|time| messages.warned(time, Version::V2));
        let message = "warning: the step from t = 0.5 s returned the status fmi2Warning, and 2 later steps";
        assert_eq!(messages.warnings(), [message]);
    }

    #[test]
    fn an_error_that_was_logged_in_a_good_call_is_not_the_reason_of_a_later_refusal() {
        let messages = Messages::default();
        messages.hear(Some(Status::Error), "harmless");
        messages.hear(Some(Status::Warning), "to be looked at");
        messages.done(Version::V2, "fmi2SetReal", Status::Ok as i32).unwrap();
        messages.hear(Some(Status::Error), "the reason");
        let message = |code| messages.done(Version::V3, "fmi3DoStep", code).unwrap_err().to_string();
        assert_eq!(message(Status::Error as i32), "the reason");
        assert_eq!(messages.warnings(), ["to be looked at"]);
        assert_eq!(message(Status::Error as i32), "fmi3DoStep returned Error");
        // `Pending` is of FMI 2.0 only.
        assert_eq!(message(5), "fmi3DoStep returned 5, which is no status of FMI");
        assert_eq!(status_of(Version::V2, 5), Some(Status::Pending));
    }
}
