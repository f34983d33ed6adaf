//! Messages that an FMU logs.

use crate::error::{Error, Result};
use crate::ssp::Fmi;
use lemons_fmi::Status;
use std::sync::Mutex;

/// Where an FMU is unpacked, and what the user knows it by.
#[derive(Default)]
pub(crate) struct Names {
    pub unpacked: String,
    pub shown: String,
}

impl Names {
    pub fn said(&self, text: &str) -> String {
        if self.unpacked.is_empty() { text.to_owned() } else { text.replace(&self.unpacked, &self.shown) }
    }
}

/// Messages of one kind that are kept; further ones are counted.
const MOST_MESSAGES: usize = 1000;

/// The first messages of a kind, and how many there were.
#[derive(Default)]
struct Heard {
    first: Vec<String>,
    more: u64,
}

impl Heard {
    fn push(&mut self, message: String) {
        if self.first.len() < MOST_MESSAGES { self.first.push(message) } else { self.more += 1 }
    }

    /// All of them since the last call.
    fn take(&mut self) -> Vec<String> {
        let Heard { mut first, more } = std::mem::take(self);
        if more > 0 {
            first.push(format!("and {more} more"));
        }
        first
    }
}

/// Messages of an FMU. Errors become the run's error; warnings are kept for the end.
#[derive(Default)]
pub(crate) struct Messages {
    errors: Mutex<Heard>,
    warnings: Mutex<Heard>,
    /// Steps that returned the status Warning: where the first of them began \[s\], and their number.
    warned: Mutex<Option<(f64, u64, Fmi)>>,
    names: Names,
}

impl Messages {
    /// None yet; `names` are for those that are told.
    pub fn with(names: Names) -> Messages {
        Messages { names, ..Messages::default() }
    }

    pub fn hear(&self, status: Option<Status>, message: &str) {
        let list = match status {
            Some(Status::Ok) => return,
            Some(Status::Warning | Status::Discard) => &self.warnings,
            _ => &self.errors,
        };
        if let Ok(mut list) = list.lock() {
            list.push(message.to_owned());
        }
    }

    /// Returns the status of a call, or as an error what the FMU has logged about its refusal.
    pub fn done(&self, fmi: Fmi, call: &str, code: i32) -> Result<Status> {
        // What was logged as an error in a call that succeeded is not the reason of a later refusal.
        let said = self.errors();
        Err(Error::new(match fmi.status(code) {
            Some(status @ (Status::Ok | Status::Warning)) => return Ok(status),
            _ if !said.is_empty() => said.join("\n"),
            Some(status) => format!("{call} returned {status:?}"),
            None => format!("{call} returned {code}, which is no status of FMI"),
        }))
    }

    /// Notes a step from a time \[s\] that returned the status Warning.
    pub fn warned(&self, time: f64, fmi: Fmi) {
        if let Ok(mut warned) = self.warned.lock() {
            let (first, steps, _) = warned.unwrap_or((time, 0, fmi));
            *warned = Some((first, steps + 1, fmi));
        }
    }

    /// The warnings since the last call.
    pub fn warnings(&self) -> Vec<String> {
        let said = self.warnings.lock().map(|mut list| list.take()).unwrap_or_default();
        let mut said: Vec<String> = said.iter().map(|message| self.names.said(message)).collect();
        if let Some((time, steps, fmi)) = self.warned.lock().ok().and_then(|mut warned| warned.take()) {
            let more = match steps - 1 {
                0 => String::new(),
                1 => ", and 1 later step".to_owned(),
                more => format!(", and {more} later steps"),
            };
            let status = format!("{}Warning{more}", fmi.prefix());
            said.push(format!("warning: the step from t = {time:?} s returned the status {status}"));
        }
        said
    }

    /// The errors since the last call.
    pub fn errors(&self) -> Vec<String> {
        let said = self.errors.lock().map(|mut list| list.take()).unwrap_or_default();
        said.iter().map(|message| self.names.said(message)).collect()
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
        [0.5, 0.6, 0.7].into_iter().for_each(|time| messages.warned(time, Fmi::V2));
        let said = "warning: the step from t = 0.5 s returned the status fmi2Warning, and 2 later steps";
        assert_eq!(messages.warnings(), [said]);
    }

    fn unknown(code: i32) -> String {
        format!("fmi3DoStep returned {code}, which is no status of FMI")
    }

    #[test]
    fn an_error_that_was_logged_in_a_good_call_is_not_the_reason_of_a_later_refusal() {
        let messages = Messages::default();
        messages.hear(Some(Status::Error), "harmless");
        messages.hear(Some(Status::Warning), "to be looked at");
        messages.done(Fmi::V2, "fmi2SetReal", Status::Ok as i32).unwrap();
        messages.hear(Some(Status::Error), "the reason");
        let said = |code| messages.done(Fmi::V3, "fmi3DoStep", code).unwrap_err().to_string();
        assert_eq!(said(Status::Error as i32), "the reason");
        assert_eq!(messages.warnings(), ["to be looked at"]);
        assert_eq!(said(Status::Error as i32), "fmi3DoStep returned Error");
        // `Pending` is of FMI 2.0 only.
        assert_eq!((said(5), said(-1)), (unknown(5), unknown(-1)));
        assert_eq!(Fmi::V2.status(5), Some(Status::Pending));
    }
}
