//! The lab: what a page asks for, computed where the page is.
//!
//! The page sends a [`Request`] and, with some, bytes (a zip). It gets a [`Reply`]: a JSON value and bytes (poses, a
//! file). [`boundary`] carries both through the memory of WebAssembly; a worker of the page calls it. All lengths are in
//! m, masses in kg, angles in rad, times in s.
//!
//! - [`person`]: four measures -> five disks, and where the person stands in the survey
//! - [`crowd`]: how many, of whom, in which room -> a Trial
//! - [`upload`]: a zip -> a Trial
//! - [`scene`]: what a page draws of a Trial
//! - [`run`]: a Trial, moving
//! - [`take`]: files to keep

pub mod boundary;
pub mod crowd;
pub mod person;
pub mod run;
pub mod scene;
pub mod take;
pub mod upload;

use lemons_people::placing::Watch;
use lemons_trial::DriveTable;
use serde::Deserialize;
use serde_json::{Value, json};

/// What a page may ask for.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "ask", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Request {
    /// A person's shape.
    Person(person::Wanted),
    /// A crowd in a room, as the present Trial.
    Crowd(crowd::Wanted),
    /// A Trial that comes with the lab, as the present one.
    Example {
        /// One of [`upload::EXAMPLES`].
        name: String,
    },
    /// The Trial in a zip (the bytes), as the present one.
    Open {
        /// The zip's name, for messages.
        name: String,
    },
    /// Further communication steps of a run.
    Advance {
        /// The run's number. A page may still ask for steps of a run that another one has replaced.
        run: u32,
        /// How many, at most [`run::MOST_STEPS`].
        steps: u32,
    },
    /// A file of a run's Trial.
    Take {
        /// The run's number.
        run: u32,
        /// Which file.
        wanted: take::Wanted,
    },
}

/// An answer.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Reply {
    /// What the request says of it.
    pub value: Value,
    /// Numbers or a file.
    pub bytes: Vec<u8>,
}

/// Why there is no answer, for the person before the page.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct Refused(pub String);

impl Refused {
    fn of(error: impl std::fmt::Display) -> Refused {
        Refused(error.to_string())
    }
}

/// The lab of one page.
#[derive(Debug, Default)]
pub struct Lab {
    open: Option<run::Run>,
    /// How many runs there were: the number of the present one.
    runs: u32,
}

impl Lab {
    /// Answers a request. `watch` gets the progress of placing people.
    ///
    /// # Errors
    /// What was asked for is impossible; the lab is unchanged.
    pub fn answer(&mut self, request: &Request, bytes: &[u8], watch: &mut Watch) -> Result<Reply, Refused> {
        match request {
            Request::Person(wanted) => person::person(wanted),
            Request::Crowd(wanted) => {
                let crowd::Made { trial, mut value } = crowd::crowd(wanted, watch)?;
                let shown =
                    self.open(upload::Driven { trial, text: String::new(), drive: DriveTable::default() })?;
                value["scene"] = shown.value;
                Ok(Reply { value, bytes: shown.bytes })
            }
            Request::Example { name } => {
                let read = upload::example(name)?;
                self.open_noted(read)
            }
            Request::Open { name } => {
                let read = upload::open(name, bytes)?;
                self.open_noted(read)
            }
            Request::Advance { run, .. } | Request::Take { run, .. } if *run != self.runs => {
                Err(Refused(format!("run {run} is over: the present one is {}", self.runs)))
            }
            Request::Advance { steps, .. } => self.present()?.advance(*steps),
            Request::Take { wanted, .. } => take::take(wanted, self.present()?.driven(), bytes),
        }
    }

    fn present(&mut self) -> Result<&mut run::Run, Refused> {
        self.open.as_mut().ok_or_else(|| Refused("there is no Trial yet: make a crowd or open one".into()))
    }

    fn open_noted(&mut self, upload::Read { driven, notes }: upload::Read) -> Result<Reply, Refused> {
        let Reply { value, bytes } = self.open(driven)?;
        Ok(Reply { value: json!({ "scene": value, "notes": notes }), bytes })
    }

    /// Makes it the present Trial. Returns its scene and its first frame.
    fn open(&mut self, driven: upload::Driven) -> Result<Reply, Refused> {
        let run = run::Run::begin(driven)?;
        let (mut value, bytes) = (scene::of(&run.driven().trial), run.frame());
        self.open = Some(run);
        self.runs += 1;
        value["run"] = self.runs.into();
        Ok(Reply { value, bytes })
    }
}
