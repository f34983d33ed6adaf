//! Sequences of FMI calls, damaged states among them, of both versions of FMI: one driver over the table of functions.

mod arguments;

use crate::fuzz::models::{Fmu, FuzzedModel, OUTPUTS};
use crate::fuzz::show_panics;
use arbitrary::{Arbitrary, Unstructured};
use arguments::{Drawn, HEADER, MOST, Real};
use lemons_fmi::Status;
use lemons_fmi::testing::functions::Probe;
use lemons_fmi::testing::instance::Arguments;
use lemons_fmi::testing::{TestInstance, Version, fmi2, fmi3};
use std::cell::Cell;
use std::ffi::c_void;
use std::fmt::Debug;
use std::ptr::null_mut;
use std::rc::Rc;

/// Mechanical steps in one communication step, and in one run.
const STEP_WORK: f64 = 200.0;
const RUN_WORK: f64 = 1000.0;

/// Calls in one run.
const CALLS: usize = 100;

#[derive(Debug, Clone, Copy, Arbitrary)]
enum At {
    Now,
    Near(i8),
    Real(Real),
}

#[derive(Debug, Clone, Arbitrary)]
enum Call {
    /// The way of masters: into Initialization Mode, and perhaps out of it.
    Start(bool),
    /// Any function that returns a status, with arguments that may fit.
    Any(u8),
    /// One element of one variable, the others as they are: most arrays are refused for one of their elements.
    Set(u8, u8, Real),
    /// Some thousandths of a second from now.
    Step(u8),
    DoStep(At, Real),
}

/// Phase, time \[s\], experiment and sizes in a state.
type OfSlave = (u32, f64, Option<(f64, Option<f64>)>, Vec<u64>);

fn of_slave(bytes: &[u8]) -> OfSlave {
    postcard::take_from_bytes::<OfSlave>(&bytes[HEADER..]).expect("a state").0
}

/// An instance, its states and its importer.
struct Session {
    fmu: Fmu,
    instance: Rc<TestInstance>,
    /// States that it has given.
    slots: [*mut c_void; 3],
    /// State of an instance to which nothing has happened.
    pristine: Vec<u8>,
    /// True while refusals are told: `SetDebugLogging` has not been called.
    hears: bool,
    /// Number of times that the callback within steps ran.
    updates: Rc<Cell<usize>>,
    /// Mechanical steps that may still be made.
    work: f64,
}

impl Drop for Session {
    fn drop(&mut self) {
        for state in &mut self.slots {
            self.instance.free_state(state);
        }
    }
}

impl Session {
    fn new(subject: FuzzedModel, version: Version, early_return: bool) -> Session {
        show_panics();
        let fmu = Fmu::of(subject, version);
        let arguments = Arguments {
            early_return,
            updates: true,
            logging_on: false,
            ..Arguments::new(&fmu.token, &fmu.location)
        };
        let instance = Rc::new(TestInstance::new(&fmu.functions, &arguments).expect("an instance"));
        instance.take_messages();
        let updates = Rc::new(Cell::new(0));
        let (weak, count) = (Rc::downgrade(&instance), updates.clone());
        // Within a step, values can be read, and nothing else is allowed.
        instance.on_update(Box::new(move |time, can_return| {
            count.set(count.get() + 1);
            let instance = weak.upgrade().expect("it steps");
            let (status, values) = instance.get_real(&[0], 1);
            assert!(status == Status::Error || values[0].is_finite(), "{values:?}");
            let refused =
                [instance.set_real(&[0], &[1.0]), instance.get_state(&mut null_mut()), instance.reset()];
            assert_eq!(refused, [Status::Error; 3], "not within a step");
            instance.take_messages();
            (can_return && time.to_bits() & 64 == 0).then_some(time)
        }));
        let (pristine, slots) = (instance.bytes(), [null_mut(); 3]);
        Session { fmu, instance, slots, pristine, hears: true, updates, work: RUN_WORK }
    }

    fn version(&self) -> Version {
        self.instance.version()
    }

    /// Makes a call and holds its status against what all functions promise.
    fn status(&self, call: impl FnOnce(&TestInstance) -> Status) -> Status {
        let status = call(&self.instance);
        self.answered(status);
        status
    }

    fn answered(&self, status: Status) {
        let told = self.instance.take_messages();
        for message in &told {
            assert!(message.category.starts_with("log") && !message.text.is_empty(), "{message:?}");
        }
        let tells = |wanted| told.iter().any(|message| message.status == wanted);
        assert!(!matches!(status, Status::Fatal | Status::Pending), "{status:?}: {told:?}");
        assert!(status != Status::Error || tells(status) || !self.hears, "an error without a word");
        let silent = status == Status::Discard && self.version() == Version::V3 && !tells(status);
        assert!(!silent || !self.hears, "a refusal without a word");
        assert!(status != Status::Ok || !tells(Status::Error), "an error told, but returned Ok: {told:?}");
        assert!(!tells(Status::Fatal), "{told:?}");
    }

    /// The number of values of these variables.
    fn length(&self, references: &[u32], before: &[u8]) -> usize {
        match self.version() {
            Version::V2 => references.len(),
            Version::V3 => self.fmu.length(references, &of_slave(before).3),
        }
    }

    /// All Reals, bit for bit, with the status of the calls that return them.
    fn reals(&self, before: &[u8]) -> Vec<(Status, Vec<u64>)> {
        let of = |at: &u32| {
            let (status, values) = self.instance.get_real(&[*at], self.length(&[*at], before));
            (status, values.into_iter().map(f64::to_bits).collect())
        };
        let all = self.fmu.reals.iter().map(of).collect();
        self.instance.take_messages();
        all
    }

    /// All Reals, where they can be had, are finite.
    fn finite(&self, before: &[u8]) {
        let length = self.length(&self.fmu.reals, before);
        let (status, values) = self.instance.get_real(&self.fmu.reals, length);
        self.instance.take_messages();
        assert!(status != Status::Ok || values.iter().all(|value| value.is_finite()), "{values:?}");
    }

    /// Returns whether files would be written only where they may. Asked before every call that may write: a damaged state may
    /// name any directory.
    fn writes_in_its_place(&self) -> bool {
        let Some(output) = self.fmu.reference_of("OutputDirectory") else { return true };
        let (status, texts) = self.instance.get_string(&[output], 1);
        self.instance.take_messages();
        status != Status::Ok || self.fmu.texts[..OUTPUTS].contains(&texts[0])
    }

    /// The same of this instance and of the states that it may go to.
    fn all_in_their_place(&self) -> bool {
        let own = |state: *mut c_void| {
            let bytes = self.instance.bytes_of(state);
            (self.fmu.output_directory)(&bytes[HEADER..]).is_some_and(|name| self.is_ours(&name))
        };
        let mut states = self.slots.into_iter().filter(|state| !state.is_null());
        self.writes_in_its_place() && states.all(own)
    }

    /// Returns whether an OutputDirectory is none, or one of ours.
    fn is_ours(&self, name: &str) -> bool {
        self.fmu.texts[..OUTPUTS].iter().any(|own| own.as_bytes() == name.as_bytes())
    }

    /// Makes a call, and checks what a refusal promises: nothing has changed.
    fn make(&mut self, name: &dyn Debug, call: impl FnOnce(&mut Session, &[u8]) -> Status) -> Status {
        let before = self.instance.bytes();
        let status = call(self, &before);
        if matches!(status, Status::Error | Status::Discard) {
            self.unchanged(&format!("{name:?}"), &before);
        }
        status
    }

    /// The same bytes, or at least the same phase, time and values: a refused step or question may have computed what is
    /// not kept yet. A step that fails leads to the phase of errors, in FMI 3.0 to the end.
    fn unchanged(&self, call: &str, before: &[u8]) {
        let phase_of_failed = if self.version() == Version::V2 { 6 } else { 5 };
        let after = self.instance.bytes();
        if after == before {
            return;
        }
        let (was, is) = (of_slave(before), of_slave(&after));
        let failed = call.contains("Step(") && is.0 == phase_of_failed;
        if failed && self.version() == Version::V3 {
            return;
        }
        assert!(was.0 == is.0 || failed, "{call}: its phase");
        assert_eq!((was.1.to_bits(), was.3), (is.1.to_bits(), is.3), "{call}: its time and sizes");
        let now = self.reals(before);
        self.restore(before);
        let then = self.reals(before);
        self.restore(&after);
        assert_eq!(then, now, "a refused {call} has changed something");
    }

    fn restore(&self, bytes: &[u8]) {
        let status = self.instance.restore(bytes);
        assert_eq!(status, Status::Ok, "it was saved here: {:?}", self.instance.take_messages());
    }

    fn perform(&mut self, call: &Call, before: &[u8], input: &mut Unstructured<'_>) -> Status {
        let fmu = &self.fmu;
        match call {
            Call::Start(exits) => {
                self.status(|instance| instance.enter(None, 0.0, None));
                if *exits && self.writes_in_its_place() {
                    self.status(TestInstance::exit);
                }
                Status::Ok
            }
            Call::Any(place) => {
                let (instance, place) = (self.instance.clone(), usize::from(*place));
                match instance.version() {
                    Version::V2 => self.any(fmi2::Functions::probes(), instance.v2(), place, before, input),
                    Version::V3 => self.any(fmi3::Functions::probes(), instance.v3(), place, before, input),
                }
            }
            Call::Set(variable, element, value) => {
                let reference = fmu.reals[usize::from(*variable) % fmu.reals.len()];
                let length = self.length(&[reference], before);
                let (status, mut values) = self.instance.get_real(&[reference], length);
                self.instance.take_messages();
                if status != Status::Ok {
                    values.fill(1.0);
                }
                if let Some(at) = usize::from(*element).checked_rem(length) {
                    values[at] = value.value();
                }
                self.status(|instance| instance.set_real(&[reference], &values))
            }
            Call::Step(thousandths) => self.step(At::Now, f64::from(*thousandths) * 1e-3, before),
            Call::DoStep(at, step) => self.step(*at, step.value(), before),
        }
    }

    /// Calls any function that returns a status, except those that step or hand out states.
    fn any<F>(
        &mut self,
        probes: Vec<Probe<F>>,
        functions: &F,
        place: usize,
        before: &[u8],
        input: &mut Unstructured<'_>,
    ) -> Status {
        let Probe { name, with, .. } = probes[place % probes.len()];
        let writes = name.ends_with("ExitInitializationMode") || name.to_lowercase().ends_with("setfmustate");
        if name.ends_with("DoStep") || writes && !self.all_in_their_place() {
            return Status::Ok;
        }
        let raw = self.instance.raw;
        let fmu = &self.fmu;
        let has = |words: &[&str]| words.iter().any(|word| name.ends_with(word));
        let fitting = match () {
            () if has(&["Integer", "Int32"]) => &fmu.integers,
            () if has(&["Boolean"]) => &fmu.booleans,
            () if has(&["String"]) => &fmu.strings,
            () if has(&["UInt64"]) => &fmu.sizes,
            () => &fmu.reals,
        };
        let (nulls, values) = input.arbitrary::<(u8, u8)>().unwrap_or_default();
        let mut drawn = Drawn {
            input,
            fmu,
            slots: &mut self.slots,
            sizes: &of_slave(before).3,
            saved: [&self.pristine, before],
            fitting,
            nulls: if nulls & 0xe0 == 0xe0 { nulls & 0x1f } else { 0 },
            pointers: 0,
            references: None,
            values: usize::from(values) % MOST,
            writes: false,
            texts: Vec::new(),
            rooms: Vec::new(),
            states: Vec::new(),
        };
        let Some(status) = with(functions, raw, &mut drawn) else { return Status::Ok };
        self.answered(status);
        match status {
            Status::Ok if name.ends_with("SetDebugLogging") => self.hears = false,
            Status::Ok => self.finite(before),
            _ => {}
        }
        if status == Status::Ok && name.to_lowercase().contains("deserialize") {
            // What was read is written as it was read.
            for state in self.slots.into_iter().filter(|state| !state.is_null()) {
                let (bytes, mut copy) = (self.instance.bytes_of(state), null_mut());
                assert_eq!(self.instance.deserialize(&bytes, &mut copy), Status::Ok);
                assert_eq!(self.instance.bytes_of(copy), bytes);
                self.instance.free(copy);
            }
        }
        if name.ends_with("Reset") {
            assert_eq!(status, Status::Ok, "allowed in every state");
            assert_eq!(self.instance.bytes(), self.pristine, "as after instantiation");
        }
        status
    }

    /// A step that makes at most some hundred mechanical steps, with their number.
    fn bounded(&self, step: f64) -> (f64, f64) {
        /// More are refused at once: see `engine::step_count`.
        const REFUSED: f64 = 2e12;
        let Some(reference) = self.fmu.reference_of("TimeStepMechanical") else { return (step, 0.0) };
        let (status, value) = self.instance.get_real(&[reference], 1);
        self.instance.take_messages();
        let steps = step / value[0];
        match status {
            Status::Ok if !(1.0..REFUSED).contains(&steps) => (step, 1.0),
            Status::Ok if steps > STEP_WORK => (value[0] * STEP_WORK, STEP_WORK),
            Status::Ok => (step, steps),
            _ => (step, 1.0),
        }
    }

    /// A step. If it is made, its outputs are finite, and made again from the state before it ends in the same one.
    fn step(&mut self, at: At, step: f64, before: &[u8]) -> Status {
        let (step, steps) = self.bounded(step);
        if self.work < steps || !self.writes_in_its_place() {
            return Status::Ok;
        }
        self.work -= steps;
        let now = of_slave(before).1;
        let from = match at {
            At::Now => now,
            At::Near(ulps) => f64::from_bits(now.to_bits().saturating_add_signed(ulps.into())),
            At::Real(real) => real.value(),
        };
        let updates = self.updates.get();
        let step_once = |session: &Session| {
            let done = session.instance.do_step(from, step);
            session.answered(done.status);
            done
        };
        let done = step_once(self);
        let status = done.status;
        if status == Status::Ok {
            let instance = &self.instance;
            assert!(!done.early || self.updates.get() > updates, "only the callback asks for it");
            let after = instance.bytes();
            let reached = of_slave(&after).1;
            let told = done.time.to_bits() == reached.to_bits();
            assert!(self.version() == Version::V2 || told, "the time reached");
            self.finite(before);
            self.restore(before);
            let again = step_once(self);
            assert_eq!((again.status, again.early), (Status::Ok, done.early), "as before");
            assert_eq!(self.instance.bytes(), after, "the same step from the same state");
        }
        status
    }
}

/// FMI calls on a small FMU; the first byte says which, and of which version.
pub fn calls(data: &[u8]) {
    let mut input = Unstructured::new(data);
    let Ok(way) = u8::arbitrary(&mut input) else { return };
    let subject = if way & 1 == 0 { FuzzedModel::Crowd } else { FuzzedModel::Decision };
    let version = if way & 2 == 0 { Version::V2 } else { Version::V3 };
    let mut session = Session::new(subject, version, way & 4 != 0);
    for _ in 0..CALLS {
        let (false, Ok(any)) = (input.is_empty(), bool::arbitrary(&mut input)) else { break };
        let call = if any { u8::arbitrary(&mut input).map(Call::Any) } else { Call::arbitrary(&mut input) };
        let Ok(call) = call else { break };
        session.make(&call, |session, before| session.perform(&call, before, &mut input));
    }
}

#[cfg(test)]
mod tests {
    use super::arguments::{Seal, edited};
    use super::*;

    impl Session {
        /// Makes a call that takes nothing from the fuzzer's bytes.
        fn call(&mut self, call: &Call) -> Status {
            self.make(call, |session, before| session.perform(call, before, &mut Unstructured::new(&[])))
        }

        /// Makes a call by a method of the instance.
        fn by(&mut self, name: &str, call: impl FnOnce(&TestInstance) -> Status) -> Status {
            self.make(&name, |session, _| session.status(call))
        }
    }

    /// The calls do what they are named for: else the fuzzers would only look at refusals.
    #[test]
    fn a_session_runs_saves_and_goes_back() {
        for version in Version::BOTH {
            let mut session = Session::new(FuzzedModel::Crowd, version, false);
            if let Some(parts) = session.fmu.reference_of("IntermediateSteps") {
                assert_eq!(session.by("parts", |instance| instance.set_integer(&[parts], &[4])), Status::Ok);
            }
            let push = session.fmu.reference_of(if version == Version::V2 { "agent[0].Fp.x" } else { "Fp" });
            let push = session.fmu.reals.iter().position(|reference| Some(*reference) == push).unwrap() as u8;
            let mut ok = |call: Call| {
                assert_eq!(session.call(&call), Status::Ok, "{call:?}");
                (session.instance.bytes(), session.updates.get())
            };
            ok(Call::Start(true));
            ok(Call::Set(push, 0, Real::Small(i16::MAX)));
            let (touching, updates) = ok(Call::Step(1));
            // Ten mechanical steps, made twice: callbacks after four and eight.
            assert_eq!(updates, if version == Version::V3 { 4 } else { 0 });
            assert_eq!(of_slave(&touching).1, 0.001);
            assert_ne!(ok(Call::Step(10)).0, touching);
            assert_eq!(session.by("restore", |instance| instance.restore(&touching)), Status::Ok);
            assert_eq!(session.instance.bytes(), touching);
            assert_eq!(edited(&touching, &[], Seal::Good), touching, "the length and the checksum are those");
            assert_eq!(session.by("reset", TestInstance::reset), Status::Ok);
            assert_eq!(session.instance.bytes(), session.pristine);
        }
    }

    /// Else no restored state would be looked at, or directories be made anywhere.
    #[test]
    fn the_output_directory_of_a_state_is_found() {
        let session = Session::new(FuzzedModel::Crowd, Version::V2, false);
        let (output, own) = (session.fmu.reference_of("OutputDirectory").unwrap(), &*session.fmu.texts[1]);
        assert_eq!(session.instance.set_string(&[output], &[Some(own)]), Status::Ok);
        for (bytes, place) in [(&session.pristine, 0), (&session.instance.bytes(), 1)] {
            let found = (session.fmu.output_directory)(&bytes[HEADER..]).unwrap();
            assert_eq!(found.as_bytes(), session.fmu.texts[place].as_bytes());
        }
    }
}
