//! Sequences of FMI calls, damaged states among them, of both versions of FMI: one driver over the table of functions.

use crate::fuzz::models::{Fmu, FuzzedModel, OUTPUTS};
use crate::fuzz::show_panics;
use arbitrary::{Arbitrary, Unstructured};
use lemons_fmi::Status;
use lemons_fmi::testing::functions::{Probe, Source};
use lemons_fmi::testing::instance::Arguments;
use lemons_fmi::testing::{Instance, Version, fmi2, fmi3};
use std::any::TypeId;
use std::cell::Cell;
use std::ffi::{CString, c_char, c_void};
use std::fmt::Debug;
use std::ptr::{null, null_mut};
use std::rc::Rc;

/// Mechanical steps in one communication step, and in one run.
const STEP_WORK: f64 = 200.0;
const RUN_WORK: f64 = 1000.0;

/// Calls in one run.
const CALLS: usize = 100;

/// A number, often one of interest.
#[derive(Debug, Clone, Copy, Arbitrary)]
enum Real {
    Small(i16),
    Special(u8),
    Bits(u64),
}

impl Real {
    fn value(self) -> f64 {
        const INF: f64 = f64::INFINITY;
        const TINY: f64 = f64::MIN_POSITIVE;
        const SPECIAL: [f64; 12] =
            [0.0, -0.0, 1.0, -1.0, 1e-3, 1e-4, 5e-324, TINY, 1e160, 1e300, INF, f64::NAN];
        match self {
            Real::Small(n) => f64::from(n) / 256.0,
            Real::Special(k) => SPECIAL[usize::from(k) % SPECIAL.len()],
            Real::Bits(bits) => f64::from_bits(bits),
        }
    }
}

/// Largest number of variables in a call.
const MOST: usize = 12;
/// Largest number of elements in an array: see `models::LONGEST`.
const ROOM: usize = 4096;

/// A change to a serialised state, in its content unless said otherwise.
#[derive(Debug, Clone, Arbitrary)]
enum Edit {
    Byte(u16, u8),
    Real(u16, Real),
    Insert(u16, u8),
    Remove(u16, u8),
    Cut(u16),
    Whole(Vec<u8>),
    Header(u8, u8),
}

/// Choice whether a changed state gets the length and the checksum that belong to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Arbitrary)]
enum Seal {
    Good,
    Old,
}

/// Magic, version, GUID, length: see `lemons_fmi::slave`.
const HEADER: usize = 36;

fn edited(bytes: &[u8], edits: &[Edit], seal: Seal) -> Vec<u8> {
    let end = bytes.len().saturating_sub(4).max(HEADER);
    let (mut header, mut content) = (bytes[..HEADER].to_vec(), bytes[HEADER..end].to_vec());
    for edit in edits.iter().take(MOST) {
        let place = |at: u16| usize::from(at) % content.len().max(1);
        match *edit {
            Edit::Header(at, byte) => header[usize::from(at) % HEADER] = byte,
            Edit::Whole(ref whole) => content.clone_from(whole),
            Edit::Insert(at, byte) => content.insert(place(at).min(content.len()), byte),
            _ if content.is_empty() => {}
            Edit::Byte(at, byte) => {
                let at = place(at);
                content[at] = byte;
            }
            Edit::Real(at, real) => {
                let at = place(at);
                let to = content.len().min(at + 8);
                content[at..to].copy_from_slice(&real.value().to_le_bytes()[..to - at]);
            }
            Edit::Remove(at, count) => {
                let at = place(at);
                content.drain(at..content.len().min(at + usize::from(count)));
            }
            Edit::Cut(at) => content.truncate(place(at)),
        }
    }
    if seal == Seal::Good {
        header[28..36].copy_from_slice(&(content.len() as u64).to_le_bytes());
    }
    header.extend(content);
    let checksum = match seal {
        Seal::Good => crc32fast::hash(&header).to_le_bytes().to_vec(),
        Seal::Old => bytes[end..].to_vec(),
    };
    header.extend(checksum);
    header
}

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

/// Arguments from the fuzzer's bytes, such as a function of this name expects.
struct Drawn<'a, 'b> {
    input: &'a mut Unstructured<'b>,
    fmu: &'a Fmu,
    slots: &'a mut [*mut c_void; 3],
    sizes: &'a [u64],
    /// Serialised states.
    saved: [&'a [u8]; 2],
    /// Variables of the type that the function is about.
    fitting: &'a [u32],
    /// Which pointers are NULL, one bit each; mostly none.
    nulls: u8,
    pointers: u32,
    /// The variables that the function gets, until it gets their number.
    references: Option<Vec<u32>>,
    /// The number of their values.
    values: usize,
    /// True if a text may be a directory into which files are written.
    writes: bool,
    texts: Vec<CString>,
    rooms: Vec<Vec<u64>>,
    states: Vec<Vec<u8>>,
}

impl Drawn<'_, '_> {
    fn draw<T: for<'c> Arbitrary<'c> + Default>(&mut self) -> T {
        self.input.arbitrary().unwrap_or_default()
    }

    fn real(&mut self) -> u64 {
        self.input.arbitrary::<Real>().map_or(1.0, Real::value).to_bits()
    }

    fn reference(&mut self) -> u32 {
        let (way, k) = self.draw::<(u8, u8)>();
        match way {
            0..160 => {
                self.fitting.get(usize::from(k) % self.fitting.len().max(1)).copied().unwrap_or(k.into())
            }
            160..240 => u32::from(k) % (self.fmu.count + 2),
            _ => self.draw(),
        }
    }

    /// Some values, drawn by a function.
    fn some<T>(&mut self, value: impl Fn(&mut Self) -> T) -> Vec<T> {
        let count = 1 + usize::from(self.draw::<u8>()) % MOST;
        (0..count).map(|_| value(self)).collect()
    }

    /// An array of these values again and again.
    fn array<T: Copy>(&mut self, values: &[T]) -> *mut c_void {
        self.rooms.push(vec![0; ROOM]);
        let room = self.rooms.last_mut().expect("it was pushed").as_mut_ptr().cast::<T>();
        for (k, value) in values.iter().cycle().take(ROOM).enumerate() {
            // SAFETY: the room has ROOM elements of eight bytes, and no type here is longer.
            #[allow(unsafe_code)]
            unsafe {
                room.add(k).write(*value);
            }
        }
        room.cast()
    }

    /// A text, or NULL. Files are written into OutputDirectory: it is one of ours.
    fn text(&mut self) -> *const c_char {
        let known = if self.writes { &self.fmu.texts[..OUTPUTS] } else { &self.fmu.texts };
        let (way, k) = self.draw::<(u8, u8)>();
        let text = match way {
            0..160 => known[usize::from(k) % known.len()].clone(),
            160..220 if !self.writes => {
                let bytes: Vec<u8> = self.some(|drawn| drawn.draw::<u8>().max(1));
                CString::new(bytes).unwrap_or_default()
            }
            _ => return null(),
        };
        self.texts.push(text);
        self.texts.last().map_or(null(), |text| text.as_ptr())
    }
}

impl Source for Drawn<'_, '_> {
    fn number(&mut self, of: TypeId) -> u64 {
        if of == TypeId::of::<f64>() {
            return self.real();
        }
        if of == TypeId::of::<u32>() {
            return self.reference().into();
        }
        let byte: u8 = self.draw();
        if of != TypeId::of::<usize>() {
            return i64::from(byte as i8).rem_euclid(3) as u64;
        }
        let Some(references) = self.references.take() else {
            // The number of values; sometimes more or less.
            let more = if byte < 200 { 0 } else { isize::from(byte % 8) - 3 };
            return self.values.saturating_add_signed(more) as u64;
        };
        let count = usize::from(byte) % (MOST + 1);
        self.values = self.fmu.length(&references[..count], self.sizes);
        count as u64
    }

    fn pointer(&mut self, of: TypeId) -> *mut c_void {
        let null = self.nulls >> self.pointers.min(7) & 1 == 1;
        self.pointers += 1;
        let array = if of == TypeId::of::<*const u32>() {
            let references: Vec<u32> = (0..MOST).map(|_| self.reference()).collect();
            let output = self.fmu.named("OutputDirectory");
            self.writes |= references.iter().any(|reference| Some(*reference) == output);
            let array = self.array(&references);
            self.references = Some(references);
            array
        } else if of == TypeId::of::<*const f64>() {
            let values = self.some(Drawn::real);
            self.array(&values)
        } else if of == TypeId::of::<*const i32>() {
            let values = self.some(|drawn| match drawn.draw::<u8>() {
                0..128 => 1,
                128..240 => i32::from(drawn.draw::<i8>()),
                _ => drawn.draw(),
            });
            self.array(&values)
        } else if of == TypeId::of::<*const u64>() {
            let values = self.some(|drawn| match drawn.draw::<u8>() {
                byte @ 0..240 => u64::from(byte % 4),
                _ => drawn.draw(),
            });
            self.array(&values)
        } else if of == TypeId::of::<*const bool>() {
            let values = self.some(Drawn::draw::<bool>);
            self.array(&values)
        } else if of == TypeId::of::<*const *const c_char>() {
            let texts = self.some(Drawn::text);
            self.array(&texts)
        } else if of == TypeId::of::<*mut c_void>() {
            self.slots[usize::from(self.draw::<u8>()) % 3]
        } else if of == TypeId::of::<*mut *mut c_void>() {
            let slot = usize::from(self.draw::<u8>()) % 3;
            (&raw mut self.slots[slot]).cast()
        } else if of == TypeId::of::<*const u8>() {
            let (second, edits) = self.input.arbitrary::<(bool, Vec<Edit>)>().unwrap_or_default();
            let seal = if self.draw() { Seal::Good } else { Seal::Old };
            let saved = self.saved[usize::from(second)];
            let bytes = edited(saved, &edits, seal);
            self.values = bytes.len();
            self.states.push(bytes);
            self.states.last_mut().map_or(null_mut(), |bytes| bytes.as_mut_ptr().cast())
        } else {
            let array = self.array(&[0_u64]);
            if of == TypeId::of::<*mut u8>() {
                self.values = 8 * ROOM - 8;
            }
            array
        };
        if null { null_mut() } else { array }
    }
}

/// Phase, time \[s\], experiment and sizes in a state.
type OfSlave = (u32, f64, Option<(f64, Option<f64>)>, Vec<u64>);

fn of_slave(bytes: &[u8]) -> OfSlave {
    postcard::take_from_bytes::<OfSlave>(&bytes[HEADER..]).expect("a state").0
}

/// An instance, its states and its importer.
struct Session {
    fmu: Fmu,
    instance: Rc<Instance>,
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
        let instance = Rc::new(Instance::new(&fmu.functions, &arguments).expect("an instance"));
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
    fn status(&self, call: impl FnOnce(&Instance) -> Status) -> Status {
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
        let Some(output) = self.fmu.named("OutputDirectory") else { return true };
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
                    self.status(Instance::exit);
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
        let Some(reference) = self.fmu.named("TimeStepMechanical") else { return (step, 0.0) };
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
    use super::*;

    impl Session {
        /// Makes a call that takes nothing from the fuzzer's bytes.
        fn call(&mut self, call: &Call) -> Status {
            self.make(call, |session, before| session.perform(call, before, &mut Unstructured::new(&[])))
        }

        /// Makes a call by a method of the instance.
        fn by(&mut self, name: &str, call: impl FnOnce(&Instance) -> Status) -> Status {
            self.make(&name, |session, _| session.status(call))
        }
    }

    /// The calls do what they are named for: else the fuzzers would only look at refusals.
    #[test]
    fn a_session_runs_saves_and_goes_back() {
        for version in Version::BOTH {
            let mut session = Session::new(FuzzedModel::Crowd, version, false);
            if let Some(parts) = session.fmu.named("IntermediateSteps") {
                assert_eq!(session.by("parts", |instance| instance.set_integer(&[parts], &[4])), Status::Ok);
            }
            let push = session.fmu.named(if version == Version::V2 { "agent[0].Fp.x" } else { "Fp" });
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
            assert_eq!(session.by("reset", Instance::reset), Status::Ok);
            assert_eq!(session.instance.bytes(), session.pristine);
        }
    }

    /// Else no restored state would be looked at, or directories be made anywhere.
    #[test]
    fn the_output_directory_of_a_state_is_found() {
        let session = Session::new(FuzzedModel::Crowd, Version::V2, false);
        let (output, own) = (session.fmu.named("OutputDirectory").unwrap(), &*session.fmu.texts[1]);
        assert_eq!(session.instance.set_string(&[output], &[Some(own)]), Status::Ok);
        for (bytes, place) in [(&session.pristine, 0), (&session.instance.bytes(), 1)] {
            let found = (session.fmu.output_directory)(&bytes[HEADER..]).unwrap();
            assert_eq!(found.as_bytes(), session.fmu.texts[place].as_bytes());
        }
    }
}
