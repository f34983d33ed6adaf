//! Sequences of FMI calls, and damaged states, of both versions of FMI.

use crate::fuzz::models::{Fmu, OUTPUTS, Subject};
use crate::fuzz::show_panics;
use crate::testing::instance::Arguments;
use crate::testing::{Instance, Version, fmi2, fmi3};
use arbitrary::{Arbitrary, Unstructured};
use lemons_fmi::Status;
use std::cell::Cell;
use std::ffi::{CStr, CString, c_void};
use std::ptr::null_mut;
use std::rc::Rc;
use std::sync::OnceLock;

/// Mechanical steps in one communication step, and in one run.
const STEP_WORK: f64 = 200.0;
const RUN_WORK: f64 = 1000.0;

/// Calls in one run.
const CALLS: usize = 100;

/// Whether calls, answers and messages are shown: see `examples/one.rs`.
fn telling() -> bool {
    static TELLING: OnceLock<bool> = OnceLock::new();
    *TELLING.get_or_init(|| std::env::var_os("FUZZ_TOLD").is_some())
}

/// A number, often one of interest.
#[derive(Debug, Clone, Copy, Arbitrary)]
enum Real {
    Small(i16),
    Special(u8),
    Bits(u64),
}

impl Real {
    fn value(self) -> f64 {
        const SPECIAL: [f64; 20] = [
            0.0,
            -0.0,
            1.0,
            -1.0,
            1e-3,
            1e-4,
            1e-2,
            5e-324,
            -5e-324,
            f64::MIN_POSITIVE,
            1e-160,
            1e160,
            1e300,
            f64::MAX,
            f64::MIN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::NAN,
            9_007_199_254_740_993.0,
            f64::EPSILON,
        ];
        match self {
            Real::Small(n) => f64::from(n) / 256.0,
            Real::Special(k) => SPECIAL[usize::from(k) % SPECIAL.len()],
            Real::Bits(bits) => f64::from_bits(bits),
        }
    }
}

/// A value reference.
#[derive(Debug, Clone, Copy, Arbitrary)]
enum Reference {
    /// Of the type that the call is about.
    Fitting(u8),
    Any(u8),
    Raw(u32),
}

/// At most this many elements in an array.
const MOST: usize = 12;

#[derive(Debug, Clone, Arbitrary)]
enum Text {
    Known(u8),
    Bytes(Vec<u8>),
    Null,
}

impl Text {
    fn choose(&self, known: &[CString]) -> Option<CString> {
        match self {
            Text::Known(k) => known.get(usize::from(*k) % known.len()).cloned(),
            Text::Bytes(bytes) => {
                CString::new(bytes.iter().copied().filter(|byte| *byte != 0).collect::<Vec<u8>>()).ok()
            }
            Text::Null => None,
        }
    }
}

fn pointers(texts: &[Option<CString>]) -> Vec<Option<&CStr>> {
    texts.iter().map(Option::as_deref).collect()
}

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

/// Whether a changed state gets the length and the checksum that belong to it.
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

/// Functions that take nothing but the instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Arbitrary)]
enum Plain {
    /// Of FMI 2.0; in FMI 3.0 it needs an experiment.
    EnterInitializationMode,
    ExitInitializationMode,
    EnterConfigurationMode,
    ExitConfigurationMode,
    Terminate,
    Reset,
}

/// What the importer's callback does within a step.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Arbitrary)]
struct Within {
    /// A variable that is read.
    reference: u8,
    /// Whether it wants the step to end there.
    returns: bool,
    /// Whether it calls what is not allowed there.
    disturbs: bool,
}

#[derive(Debug, Clone, Arbitrary)]
enum Call {
    /// As masters do: into Initialization Mode and out of it.
    Start,
    /// Into Initialization Mode.
    Prepare,
    /// Sizes and a Trial that belong together, or do not.
    Choose(u8, u8, u8),
    SetUp(Real, Real, Option<Real>),
    Enter(Real, Real, Option<Real>),
    Plain(Plain),
    Logging(bool, Vec<Text>),
    /// References, and how many values more than fit (in FMI 3.0).
    GetReal(Vec<Reference>, i8),
    GetInteger(Vec<Reference>, i8),
    GetBoolean(Vec<Reference>, i8),
    GetString(Vec<Reference>, i8),
    GetSize(Vec<Reference>, i8),
    /// One element of one variable, the others as they are: most arrays are refused for one of their elements.
    Set(u8, u8, Real),
    /// The values again and again.
    SetReal(Vec<Reference>, Vec<Real>, i8),
    SetInteger(Vec<Reference>, Vec<i32>, i8),
    SetBoolean(Vec<Reference>, Vec<i32>, i8),
    SetSize(Vec<(Reference, u64)>),
    SetString(Vec<(Reference, Text)>, i8),
    InputDerivatives(Vec<(Reference, Real, Option<i8>)>),
    OutputDerivatives(Vec<(Reference, Option<i8>)>, i8),
    Dependencies(Reference, u8),
    /// Any function, with arguments that mean nothing.
    Probe(u8, Option<u8>),
    Within(Within),
    /// Some thousandths of a second from now.
    Step(u8),
    DoStep(At, Real),
    GetState(u8),
    SetState(u8),
    FreeState(u8),
    Serialize(u8, i8),
    Deserialize(u8, u8, Vec<Edit>, Seal),
    Instantiate([Text; 3], i8, [bool; 4]),
    /// The calls that follow go to the other instance.
    Other,
}

/// Which pointers of a call are NULL, one bit each; mostly none.
#[derive(Debug, Clone, Copy, Arbitrary)]
struct Nulls(u8);

impl Nulls {
    const NONE: Nulls = Nulls(0);

    fn bits(self) -> u8 {
        if self.0 & 0xe0 == 0xe0 { self.0 & 0x1f } else { 0 }
    }

    fn any(self, places: u8) -> bool {
        self.bits() & ((1 << places) - 1) != 0
    }
}

/// A state pointer of the importer's.
struct Slot {
    state: *mut c_void,
    /// Whether the instance gave it, or another one of the same FMU.
    genuine: bool,
    /// Whether files would be written only where they may.
    in_its_place: bool,
}

/// An instance, its states and its importer.
struct Held {
    instance: Rc<Instance>,
    slots: [Slot; 3],
    /// Whether refusals and discards are told, as the last `SetDebugLogging` wanted it.
    hears: [bool; 2],
    within: Rc<Cell<Within>>,
    /// How many times the callback ran.
    updates: Rc<Cell<usize>>,
}

impl Held {
    fn new(fmu: &Fmu, early_return: bool) -> Held {
        let arguments = Arguments {
            early_return,
            updates: true,
            logging_on: false,
            ..Arguments::new(&fmu.token, &fmu.location)
        };
        let instance = Rc::new(Instance::new(&fmu.functions, &arguments).expect("an instance"));
        instance.take_messages();
        let (within, updates) = (Rc::new(Cell::new(Within::default())), Rc::new(Cell::new(0)));
        let (weak, seen, count) = (Rc::downgrade(&instance), within.clone(), updates.clone());
        instance.on_update(Box::new(move |time, can_return| {
            count.set(count.get() + 1);
            let instance = weak.upgrade().expect("it steps");
            let Within { reference, returns, disturbs } = seen.get();
            let (status, values) = instance.get_real(&[reference.into()], 4);
            assert!(status == Status::Error || values.iter().all(|value| value.is_finite()), "{values:?}");
            if disturbs {
                let refused = [
                    instance.set_real(&[reference.into()], &values),
                    instance.get_state(&mut null_mut()),
                    instance.reset(),
                    instance.terminate(),
                    instance.do_step(time, 0.1).status,
                ];
                assert_eq!(refused, [Status::Error; 5], "not within a step");
            }
            instance.take_messages();
            (can_return && returns).then_some(time)
        }));
        let slot = || Slot { state: null_mut(), genuine: false, in_its_place: true };
        Held { instance, slots: [(); 3].map(|()| slot()), hears: [true, false], within, updates }
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        for slot in &mut self.slots {
            self.instance.free_state(&mut slot.state);
        }
    }
}

/// Phase, time \[s\], experiment and sizes in a state.
type OfSlave = (u32, f64, Option<(f64, Option<f64>)>, Vec<u64>);

fn of_slave(bytes: &[u8]) -> OfSlave {
    postcard::take_from_bytes::<OfSlave>(&bytes[HEADER..]).expect("a state").0
}

struct Session {
    fmu: Fmu,
    /// Of an instance to which nothing has happened.
    pristine: Vec<u8>,
    held: Vec<Held>,
    at: usize,
    /// What was serialised.
    saved: Vec<Vec<u8>>,
    /// Mechanical steps that may still be made.
    work: f64,
    /// Of the present call.
    nulls: Nulls,
}

impl Session {
    fn new(subject: Subject, version: Version) -> Session {
        show_panics();
        let fmu = Fmu::of(subject, version);
        let first = Held::new(&fmu, false);
        let pristine = first.instance.bytes();
        let (held, saved) = (vec![first], vec![pristine.clone()]);
        Session { fmu, pristine, held, at: 0, saved, work: RUN_WORK, nulls: Nulls::NONE }
    }

    fn instance(&self) -> &Instance {
        &self.held[self.at].instance
    }

    fn version(&self) -> Version {
        self.instance().version()
    }

    /// Makes a call without some pointers, and holds its status against what all functions promise. NULL among the first
    /// `places` pointers is refused, unless they have no elements.
    fn ask<T>(&self, count: usize, places: u8, call: impl FnOnce(&Instance) -> (Status, T)) -> (Status, T) {
        let instance = self.instance();
        instance.nulls.set(self.nulls.bits());
        let answer = call(instance);
        instance.nulls.set(0);
        self.answered(answer.0);
        assert!(answer.0 != Status::Ok || count == 0 || !self.nulls.any(places), "NULL is refused");
        answer
    }

    fn answered(&self, status: Status) {
        let told = self.instance().take_messages();
        for message in &told {
            assert!(message.category.starts_with("log") && !message.text.is_empty(), "{message:?}");
        }
        if telling() && !told.is_empty() {
            eprintln!("    {told:?}");
        }
        let tells = |wanted| told.iter().any(|message| message.status == wanted);
        let hears = self.held[self.at].hears;
        assert!(!matches!(status, Status::Fatal | Status::Pending), "{status:?}: {told:?}");
        assert!(status != Status::Error || tells(status) || !hears[0], "an error without a word");
        assert!(status != Status::Discard || tells(status) || !hears[1], "a discard without a word");
        assert!(status != Status::Discard || self.version() == Version::V2, "FMI 3.0 has none here");
        assert!(status != Status::Ok || !tells(Status::Error), "an error told, but returned Ok: {told:?}");
        assert!(!tells(Status::Fatal), "{told:?}");
    }

    fn references(&self, wanted: impl Iterator<Item = Reference>, fitting: &[u32]) -> Vec<u32> {
        let choose = |reference| match reference {
            Reference::Fitting(k) => {
                fitting.get(usize::from(k) % fitting.len().max(1)).copied().unwrap_or(u32::from(k))
            }
            Reference::Any(k) => u32::from(k) % (self.fmu.count + 2),
            Reference::Raw(raw) => raw,
        };
        wanted.take(MOST).map(choose).collect()
    }

    /// The number of values of these variables; in FMI 3.0, sometimes more or less.
    fn length(&self, references: &[u32], more: i8, before: &[u8]) -> usize {
        if self.version() == Version::V2 {
            return references.len();
        }
        // Mostly the right one.
        let more = if more.unsigned_abs() < 96 { 0 } else { isize::from(more % 8) };
        self.fmu.length(references, &of_slave(before).3).saturating_add_signed(more)
    }

    /// All values, bit for bit, with the status of the calls that return them.
    fn everything(&self, before: &[u8]) -> impl PartialEq + std::fmt::Debug {
        let (instance, fmu) = (self.instance(), &self.fmu);
        let length = |at: u32| self.length(&[at], 0, before);
        let reals = fmu.reals.iter().map(|at| {
            let (status, values) = instance.get_real(&[*at], length(*at));
            (status, values.into_iter().map(f64::to_bits).collect::<Vec<_>>())
        });
        let reals: Vec<_> = reals.collect();
        let integers = fmu.integers.iter().map(|at| instance.get_integer(&[*at], length(*at)));
        let integers: Vec<_> = integers.collect();
        let booleans = fmu.booleans.iter().map(|at| instance.get_boolean(&[*at], length(*at)));
        let booleans: Vec<_> = booleans.collect();
        let strings: Vec<_> = fmu.strings.iter().map(|at| instance.get_string(&[*at], length(*at))).collect();
        instance.take_messages();
        (reals, integers, booleans, strings)
    }

    /// All Reals, where they can be had, are finite.
    fn finite(&self, before: &[u8]) {
        let length = self.length(&self.fmu.reals, 0, before);
        let (status, values) = self.instance().get_real(&self.fmu.reals, length);
        self.instance().take_messages();
        assert!(status != Status::Ok || values.iter().all(|value| value.is_finite()), "{values:?}");
    }

    /// Whether files would be written only where they may. Asked before every call that may write: a damaged state may
    /// name any directory.
    fn writes_in_its_place(&self) -> bool {
        let Some(output) = self.fmu.named("OutputDirectory") else { return true };
        let (status, texts) = self.instance().get_string(&[output], 1);
        self.instance().take_messages();
        status != Status::Ok || self.fmu.texts[..OUTPUTS].contains(&texts[0])
    }

    /// A call, and what a refusal promises: nothing has changed.
    fn make(&mut self, call: &Call, nulls: Nulls) {
        if let Call::Other = call {
            self.at = 1 - self.at;
            if self.held.len() == self.at {
                self.held.push(Held::new(&self.fmu, true));
            }
            return;
        }
        let before = self.instance().bytes();
        self.nulls = nulls;
        let status = self.perform(call, &before);
        self.nulls = Nulls::NONE;
        if telling() {
            eprintln!("{call:?}: {status:?}");
        }
        if matches!(status, Status::Error | Status::Discard) {
            self.unchanged(call, &before);
        }
    }

    /// The same bytes, or at least the same phase, time and values: a refused step or question may have computed what is
    /// not kept yet. A step that fails leads to the phase of errors, in FMI 3.0 perhaps after the first parts of it.
    fn unchanged(&self, call: &Call, before: &[u8]) {
        const FAILED: u32 = 6;
        let after = self.instance().bytes();
        if after == before {
            return;
        }
        let (was, is) = (of_slave(before), of_slave(&after));
        let failed = matches!(call, Call::Step(_) | Call::DoStep(..)) && is.0 == FAILED;
        if failed && self.version() == Version::V3 {
            return;
        }
        assert!(was.0 == is.0 || failed, "{call:?}: its phase");
        assert_eq!((was.1.to_bits(), was.3), (is.1.to_bits(), is.3), "{call:?}: its time and sizes");
        let now = self.everything(before);
        self.restore(before);
        let then = self.everything(before);
        self.restore(&after);
        assert_eq!(then, now, "a refused {call:?} has changed something");
    }

    fn restore(&self, bytes: &[u8]) {
        let status = self.instance().restore(bytes);
        assert_eq!(status, Status::Ok, "it was saved here: {:?}", self.instance().take_messages());
    }

    fn perform(&mut self, call: &Call, before: &[u8]) -> Status {
        let fmu = &self.fmu;
        let plain = |status| (status, ());
        match call {
            Call::Other => Status::Ok,
            Call::Prepare => {
                self.ask(0, 0, |instance| plain(instance.enter(None, 0.0, None)));
                Status::Ok
            }
            Call::Start => {
                self.perform(&Call::Prepare, before);
                self.plain(Plain::ExitInitializationMode);
                Status::Ok
            }
            Call::Choose(first, second, trial) => {
                if self.version() == Version::V3 {
                    let values = [*first, *second].map(|size| u64::from(size % 4));
                    self.plain(Plain::EnterConfigurationMode);
                    self.ask(1, 2, |instance| plain(instance.set_size(&fmu.sizes, &values)));
                    self.plain(Plain::ExitConfigurationMode);
                }
                let known = &fmu.texts[OUTPUTS..];
                if let Some(reference) = fmu.named("Trial") {
                    let text = &*known[usize::from(*trial) % known.len()];
                    self.ask(1, 2, |instance| plain(instance.set_string(&[reference], &[Some(text)])));
                }
                Status::Ok
            }
            Call::SetUp(tolerance, start, stop) => {
                let (tolerance, stop) = (tolerance.value(), stop.map(Real::value));
                let tolerance = (tolerance != 0.0).then_some(tolerance);
                self.ask(0, 0, |instance| plain(instance.set_up(tolerance, start.value(), stop))).0
            }
            Call::Enter(tolerance, start, stop) => {
                // In FMI 2.0 these are two calls.
                self.perform(&Call::SetUp(*tolerance, *start, *stop), before);
                if self.version() == Version::V2 {
                    self.plain(Plain::EnterInitializationMode);
                    return Status::Ok;
                }
                let (tolerance, stop) = (tolerance.value(), stop.map(Real::value));
                let tolerance = (tolerance != 0.0).then_some(tolerance);
                self.ask(0, 0, |instance| plain(instance.enter(tolerance, start.value(), stop))).0
            }
            Call::Plain(function) => self.plain(*function),
            Call::Logging(on, texts) => self.logging(*on, texts),
            Call::GetReal(references, more) => {
                let references = self.references(references.iter().copied(), &fmu.reals);
                let length = self.length(&references, *more, before);
                let (status, values) = self.ask(references.len(), 2, |i| i.get_real(&references, length));
                let finite = values.iter().all(|value| value.is_finite());
                assert!(status != Status::Ok || self.nulls.any(2) || finite, "{values:?}");
                status
            }
            Call::GetInteger(references, more) => {
                let references = self.references(references.iter().copied(), &fmu.integers);
                let length = self.length(&references, *more, before);
                self.ask(references.len(), 2, |instance| instance.get_integer(&references, length)).0
            }
            Call::GetBoolean(references, more) => {
                let references = self.references(references.iter().copied(), &fmu.booleans);
                let length = self.length(&references, *more, before);
                self.ask(references.len(), 2, |instance| instance.get_boolean(&references, length)).0
            }
            Call::GetString(references, more) => {
                let references = self.references(references.iter().copied(), &fmu.strings);
                let length = self.length(&references, *more, before);
                // No values of no variables: NULL would be no text.
                let length = if references.is_empty() { 0 } else { length };
                self.ask(references.len(), 2, |instance| instance.get_string(&references, length)).0
            }
            Call::GetSize(references, more) if self.version() == Version::V3 => {
                let references = self.references(references.iter().copied(), &fmu.sizes);
                let length = self.length(&references, *more, before);
                self.ask(references.len(), 2, |instance| instance.get_size(&references, length)).0
            }
            Call::Set(variable, element, value) => {
                let reference = fmu.reals[usize::from(*variable) % fmu.reals.len()];
                let length = self.length(&[reference], 0, before);
                let (status, mut values) = self.instance().get_real(&[reference], length);
                self.instance().take_messages();
                if status != Status::Ok {
                    values.fill(1.0);
                }
                if let Some(at) = usize::from(*element).checked_rem(length) {
                    values[at] = value.value();
                }
                self.ask(1, 2, |instance| plain(instance.set_real(&[reference], &values))).0
            }
            Call::SetReal(references, values, more) => {
                let references = self.references(references.iter().copied(), &fmu.reals);
                let length = self.length(&references, *more, before);
                let values = again(values.iter().map(|real| real.value()), 1.0, length);
                self.ask(references.len(), 2, |instance| plain(instance.set_real(&references, &values))).0
            }
            Call::SetInteger(references, values, more) => {
                let references = self.references(references.iter().copied(), &fmu.integers);
                let length = self.length(&references, *more, before);
                let values = again(values.iter().copied(), 1, length);
                self.ask(references.len(), 2, |instance| plain(instance.set_integer(&references, &values))).0
            }
            Call::SetBoolean(references, values, more) => {
                let references = self.references(references.iter().copied(), &fmu.booleans);
                let length = self.length(&references, *more, before);
                let values = again(values.iter().copied(), 1, length);
                self.ask(references.len(), 2, |instance| plain(instance.set_boolean(&references, &values))).0
            }
            Call::SetSize(settings) if self.version() == Version::V3 => {
                let references = self.references(settings.iter().map(|(at, _)| *at), &fmu.sizes);
                let values: Vec<u64> = settings.iter().take(MOST).map(|(_, value)| *value).collect();
                self.ask(references.len(), 2, |instance| plain(instance.set_size(&references, &values))).0
            }
            Call::SetString(settings, more) => self.set_string(settings, *more),
            Call::InputDerivatives(settings) if self.version() == Version::V2 => {
                let references = self.references(settings.iter().map(|(at, _, _)| *at), &fmu.reals);
                let (values, orders): (Vec<f64>, Vec<i32>) = settings
                    .iter()
                    .take(MOST)
                    .map(|(_, real, order)| (real.value(), order.map_or(1, i32::from)))
                    .unzip();
                let set = |instance: &Instance| instance.set_input_derivatives(&references, &orders, &values);
                self.ask(references.len(), 3, |instance| plain(set(instance))).0
            }
            Call::OutputDerivatives(wanted, more) => {
                let references = self.references(wanted.iter().map(|(at, _)| *at), &fmu.reals);
                let orders: Vec<i32> =
                    wanted.iter().take(MOST).map(|(_, order)| order.map_or(1, i32::from)).collect();
                let length = self.length(&references, *more, before);
                let get = |instance: &Instance| instance.output_derivatives(&references, &orders, length);
                let (status, values) = self.ask(references.len(), 3, get);
                assert!(status != Status::Ok || orders.iter().all(|order| *order == 1), "only order 1");
                assert!(values.iter().all(|value| value.is_finite()), "{values:?}");
                status
            }
            Call::Dependencies(reference, more) if self.version() == Version::V3 => {
                let reference = self.references([*reference].into_iter(), &fmu.reals)[0];
                let more = if *more < 240 { 0 } else { usize::from(more - 239) };
                self.dependencies(reference, more)
            }
            Call::Probe(place, null) => self.probe(usize::from(*place), null.map(usize::from)),
            Call::Within(within) => {
                self.held[self.at].within.set(*within);
                Status::Ok
            }
            Call::Step(thousandths) => self.step(At::Now, f64::from(*thousandths) * 1e-3, before),
            Call::DoStep(at, step) => self.step(*at, step.value(), before),
            Call::GetState(slot) => {
                let slot = usize::from(*slot) % 3;
                let mut state = self.held[self.at].slots[slot].state;
                let status = self.ask(1, 1, |instance| plain(instance.get_state(&mut state))).0;
                if status == Status::Ok {
                    self.held[self.at].slots[slot] = Slot { state, genuine: true, in_its_place: true };
                }
                status
            }
            Call::SetState(slot) => {
                let slot = &self.held[self.at].slots[usize::from(*slot) % 3];
                if !slot.in_its_place {
                    return Status::Ok;
                }
                let status = self.ask(0, 0, |instance| plain(instance.set_state(slot.state))).0;
                assert!(status != Status::Ok || !slot.state.is_null(), "NULL is no state");
                assert!(status == Status::Ok || slot.state.is_null() || !slot.genuine, "it was saved");
                status
            }
            Call::FreeState(slot) => {
                let slot = usize::from(*slot) % 3;
                let mut state = self.held[self.at].slots[slot].state;
                let status = self.ask(0, 0, |instance| plain(instance.free_state(&mut state))).0;
                assert!(
                    status != Status::Ok || self.nulls.any(1) || state.is_null(),
                    "it is NULL afterwards"
                );
                self.held[self.at].slots[slot].state = state;
                status
            }
            Call::Serialize(slot, surplus) => {
                let slot = &self.held[self.at].slots[usize::from(*slot) % 3];
                let (state, genuine) = (slot.state, slot.genuine);
                let (status, size) = self.ask(1, 1, |instance| instance.serialized_size(state));
                if status != Status::Ok {
                    return status;
                }
                let length = size.saturating_add_signed((*surplus).into());
                let (status, mut bytes) = self.ask(length, 1, |instance| instance.serialize(state, length));
                assert_eq!(status == Status::Ok, size <= length, "whether the buffer is too small");
                bytes.truncate(size);
                if status == Status::Ok && genuine && self.saved.len() < 8 {
                    self.saved.push(bytes);
                }
                status
            }
            Call::Deserialize(saved, slot, edits, seal) => {
                let saved = &self.saved[usize::from(*saved) % self.saved.len()];
                let bytes = if edits.is_empty() { saved.clone() } else { edited(saved, edits, *seal) };
                let slot = usize::from(*slot) % 3;
                let mut state = self.held[self.at].slots[slot].state;
                let status = self.ask(1, 2, |instance| plain(instance.deserialize(&bytes, &mut state))).0;
                if status == Status::Ok {
                    let directory = (fmu.output_directory)(bytes.get(HEADER..).unwrap_or_default());
                    let own = |name: String| {
                        fmu.texts[..OUTPUTS].iter().any(|own| own.as_bytes() == name.as_bytes())
                    };
                    let in_its_place = directory.is_some_and(own);
                    self.held[self.at].slots[slot] = Slot { state, genuine: edits.is_empty(), in_its_place };
                }
                status
            }
            Call::Instantiate(texts, kind, [logging_on, event_mode, early_return, updates]) => {
                let known = [&fmu.token, &fmu.location].map(Clone::clone);
                let texts = texts.each_ref().map(|text| text.choose(&known));
                let [name, token, location] = texts.each_ref().map(Option::as_deref);
                let arguments = Arguments {
                    name,
                    token,
                    location,
                    logging_on: *logging_on,
                    fmu_type: (*kind).into(),
                    event_mode: *event_mode,
                    early_return: *early_return,
                    updates: *updates,
                };
                match Instance::new(&fmu.functions, &arguments) {
                    Ok(instance) => {
                        assert_eq!(instance.bytes(), self.pristine);
                        assert!(!event_mode || self.version() == Version::V2, "an FMU without events");
                    }
                    Err(told) => {
                        assert!(told.iter().any(|message| message.status == Status::Error), "{told:?}");
                        assert!(told.iter().all(|message| message.status != Status::Fatal), "{told:?}");
                    }
                }
                Status::Ok
            }
            // Functions of the other version.
            Call::GetSize(..) | Call::SetSize(_) | Call::InputDerivatives(_) | Call::Dependencies(..) => {
                Status::Ok
            }
        }
    }

    fn plain(&self, function: Plain) -> Status {
        let v3 = self.version() == Version::V3;
        let foreign = match function {
            Plain::EnterInitializationMode => v3,
            Plain::EnterConfigurationMode | Plain::ExitConfigurationMode => !v3,
            _ => false,
        };
        if foreign || function == Plain::ExitInitializationMode && !self.writes_in_its_place() {
            return Status::Ok;
        }
        let call = |instance: &Instance| match function {
            // SAFETY: an instance.
            #[allow(unsafe_code)]
            Plain::EnterInitializationMode => unsafe {
                (instance.v2().fmi2EnterInitializationMode)(instance.raw)
            },
            Plain::ExitInitializationMode => instance.exit(),
            Plain::EnterConfigurationMode => instance.enter_configuration(),
            Plain::ExitConfigurationMode => instance.exit_configuration(),
            Plain::Terminate => instance.terminate(),
            Plain::Reset => instance.reset(),
        };
        let status = self.ask(0, 0, |instance| (call(instance), ())).0;
        if function == Plain::Reset {
            assert_eq!(status, Status::Ok, "allowed in every state");
            assert_eq!(self.instance().bytes(), self.pristine, "as after instantiation");
        }
        status
    }

    /// Any function that returns a status, with a pointer that may be NULL. States would be lost.
    fn probe(&self, place: usize, null: Option<usize>) -> Status {
        let instance = self.instance();
        let keeps = |name: &str, pointers: usize| pointers > 0 && !name.ends_with("GetFMUstate");
        let keeps = |name: &str, pointers: usize| keeps(name, pointers) && !name.ends_with("GetFMUState");
        let status = match self.version() {
            Version::V2 => {
                let probes = fmi2::Functions::probes();
                let probe = &probes[place % probes.len()];
                keeps(probe.name, probe.pointers).then(|| (probe.call)(instance.v2(), instance.raw, null))
            }
            Version::V3 => {
                let probes = fmi3::Functions::probes();
                let probe = &probes[place % probes.len()];
                keeps(probe.name, probe.pointers).then(|| (probe.call)(instance.v3(), instance.raw, null))
            }
        };
        let Some(status) = status.flatten() else { return Status::Ok };
        self.answered(status);
        status
    }

    fn logging(&mut self, on: bool, texts: &[Text]) -> Status {
        let known = [c"logStatusWarning", c"logStatusError", c"logStatusFatal", c"logAll", c"events"];
        let known = known.map(CStr::to_owned);
        let texts: Vec<_> = texts.iter().take(MOST).map(|text| text.choose(&known)).collect();
        let categories = pointers(&texts);
        let before = self.held[self.at].hears;
        // What this call tells is told by the new filter.
        let has = |wanted| categories.contains(&Some(wanted)) || categories.contains(&Some(c"logAll"));
        let all = categories.is_empty();
        let wanted = [!on || all || has(c"logStatusError"), on && (all || has(c"logStatusWarning"))];
        let status =
            self.ask(categories.len(), 1, |instance| (instance.debug_logging(on, &categories), ())).0;
        self.held[self.at].hears = if status == Status::Ok { wanted } else { before };
        status
    }

    fn set_string(&self, settings: &[(Reference, Text)], more: i8) -> Status {
        let fmu = &self.fmu;
        let output = fmu.named("OutputDirectory");
        let references = self.references(settings.iter().map(|(at, _)| *at), &fmu.strings);
        let texts = settings.iter().zip(&references).map(|((_, text), at)| match text {
            // Files are written there.
            Text::Bytes(_) if Some(*at) == output => Text::Known(1).choose(&fmu.texts[..OUTPUTS]),
            text if Some(*at) == output => text.choose(&fmu.texts[..OUTPUTS]),
            text => text.choose(&fmu.texts),
        });
        let mut texts: Vec<Option<CString>> = texts.collect();
        // Mostly as many as there are variables.
        if self.version() == Version::V3 && more > 120 {
            texts.push(None);
        } else if self.version() == Version::V3 && more < -120 {
            texts.pop();
        }
        let texts = pointers(&texts);
        let status =
            self.ask(references.len(), 2, |instance| (instance.set_string(&references, &texts), ())).0;
        assert!(status != Status::Ok || texts.iter().all(Option::is_some), "a NULL text is refused");
        status
    }

    /// Their number and, into arrays of that many and `more` elements, the dependencies.
    #[allow(unsafe_code)] // calls C functions
    fn dependencies(&self, reference: u32, more: usize) -> Status {
        let (mut count, null) = (0, self.nulls.any(1));
        let place = if null { null_mut() } else { &raw mut count };
        // SAFETY: NULL or the place of a number.
        let number = |instance: &Instance| unsafe {
            (instance.v3().fmi3GetNumberOfVariableDependencies)(instance.raw, reference, place)
        };
        let first = self.ask(1, 1, |instance| (number(instance), ())).0;
        if first != Status::Ok {
            return first;
        }
        let length = count + more;
        let (mut dependents, mut elements) = (vec![0; length], vec![0; length]);
        let (mut independents, mut kinds) = (vec![0; length], vec![0; length]);
        let (one, two, three, four) =
            (dependents.as_mut_ptr(), independents.as_mut_ptr(), elements.as_mut_ptr(), kinds.as_mut_ptr());
        // SAFETY: arrays as long as said.
        let all = |instance: &Instance| unsafe {
            let get = instance.v3().fmi3GetVariableDependencies;
            get(instance.raw, reference, one, two, three, four, length)
        };
        let status = self.ask(0, 0, |instance| (all(instance), ())).0;
        assert!(status != Status::Ok || more == 0, "another number than there are");
        assert!(status != Status::Ok || !dependents.contains(&0) && !elements.contains(&0), "from 1");
        status
    }

    /// A step that makes at most some hundred mechanical steps, with their number.
    fn bounded(&self, step: f64) -> (f64, f64) {
        /// More are refused at once: see `engine::step_count`.
        const REFUSED: f64 = 2e12;
        let Some(reference) = self.fmu.named("TimeStepMechanical") else { return (step, 0.0) };
        let (status, value) = self.instance().get_real(&[reference], 1);
        self.instance().take_messages();
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
        let updates = self.held[self.at].updates.get();
        let step_once = |instance: &Instance| {
            let done = instance.do_step(from, step);
            (done.status, done)
        };
        let (status, done) = self.ask(0, 0, step_once);
        if status == Status::Ok {
            let instance = self.instance();
            assert!(
                !done.early || self.held[self.at].updates.get() > updates,
                "only the callback asks for it"
            );
            let after = instance.bytes();
            let reached = of_slave(&after).1;
            let told = done.time.to_bits() == reached.to_bits();
            assert!(self.version() == Version::V2 || self.nulls.bits() & 8 != 0 || told, "the time reached");
            self.finite(before);
            self.restore(before);
            let (status, again) = self.ask(0, 0, step_once);
            assert_eq!((status, again.early), (Status::Ok, done.early), "as before");
            assert_eq!(self.instance().bytes(), after, "the same step from the same state");
        }
        status
    }
}

/// So many values, the given ones and another one again and again.
fn again<T: Copy>(values: impl Iterator<Item = T>, another: T, length: usize) -> Vec<T> {
    let values: Vec<T> = values.chain([another]).collect();
    values.into_iter().cycle().take(length).collect()
}

/// FMI calls on a small FMU.
pub(crate) fn calls(subject: Subject, version: Version, data: &[u8]) {
    let mut session = Session::new(subject, version);
    let mut input = Unstructured::new(data);
    for _ in 0..CALLS {
        let (false, Ok((call, nulls))) = (input.is_empty(), <(Call, Nulls)>::arbitrary(&mut input)) else {
            break;
        };
        session.make(&call, nulls);
    }
}

/// Where a state is saved that is then damaged.
#[derive(Debug, Clone, Copy, Arbitrary)]
enum Saved {
    Instantiated,
    Configuration,
    Initialization,
    Running,
    /// In FMI 2.0: with a drive and its rate.
    Driven,
    /// In FMI 3.0: after a step in parts.
    Parts,
    /// Of a Trial of another size; in FMI 2.0, of another Trial.
    Other,
    Terminated,
}

/// A state saved somewhere, damaged, restored and run on.
#[derive(Debug, Clone, Arbitrary)]
struct Damaged {
    saved: Saved,
    seal: Seal,
    edits: Vec<Edit>,
}

/// Damaged states: refused, or restored and run on.
pub(crate) fn states(version: Version, data: &[u8]) {
    let Some((&model, data)) = data.split_first() else { return };
    let Ok(damaged) = Damaged::arbitrary_take_rest(Unstructured::new(data)) else { return };
    let subject = if model % 4 == 3 { Subject::Decision } else { Subject::Crowd };
    let mut session = Session::new(subject, version);
    // The fourth Real and two more in FMI 2.0, of the fourth array the first element.
    let inputs = move |value: i16| {
        let count = if version == Version::V2 { 3 } else { 1 };
        let set = (0..count).map(move |k: u8| Call::Set(3 + k, 0, Real::Small(value * i16::from(k.max(1)))));
        set.collect::<Vec<_>>()
    };
    let parts = session.fmu.named("IntermediateSteps").and_then(|at| {
        session.fmu.integers.iter().position(|reference| *reference == at).map(|place| place as u8)
    });
    let rates = (0..3).map(|k| (Reference::Fitting(3 + k), Real::Small(512), None)).collect();
    let smaller = session.fmu.texts.len().saturating_sub(1 + OUTPUTS) as u8;
    let other = if version == Version::V2 { 1 } else { smaller };
    let first: Vec<Call> = match damaged.saved {
        Saved::Instantiated => vec![],
        Saved::Configuration => vec![Call::Plain(Plain::EnterConfigurationMode)],
        Saved::Initialization => [vec![Call::Prepare], inputs(256)].concat(),
        Saved::Running => [vec![Call::Start], inputs(2560), vec![Call::Step(1)]].concat(),
        Saved::Driven => {
            [inputs(2560), vec![Call::Start, Call::Step(2), Call::InputDerivatives(rates)]].concat()
        }
        Saved::Parts => [
            vec![Call::SetInteger(vec![Reference::Fitting(parts.unwrap_or(0))], vec![4], 0), Call::Start],
            inputs(2560),
            vec![Call::Step(2)],
        ]
        .concat(),
        Saved::Other => vec![Call::Choose(1, 3, other), Call::Start, Call::Step(1)],
        Saved::Terminated => vec![Call::Start, Call::Plain(Plain::Terminate)],
    };
    first.iter().for_each(|call| session.make(call, Nulls::NONE));
    session.saved = vec![session.instance().bytes()];
    session.make(&Call::Deserialize(0, 0, damaged.edits.clone(), damaged.seal), Nulls::NONE);
    let state = session.held[0].slots[0].state;
    if state.is_null() {
        return;
    }
    // What was read is written as it was read.
    let instance = session.instance();
    let (again, mut copy) = (instance.bytes_of(state), null_mut());
    assert_eq!(instance.deserialize(&again, &mut copy), Status::Ok);
    assert_eq!(instance.bytes_of(copy), again);
    instance.free(copy);
    let calls = [
        vec![
            Call::SetState(0),
            Call::Plain(Plain::ExitConfigurationMode),
            Call::Plain(Plain::ExitInitializationMode),
            Call::Step(1),
        ],
        inputs(25),
        vec![
            Call::Step(20),
            Call::Plain(Plain::Terminate),
            Call::Plain(Plain::Reset),
            Call::Start,
            Call::Step(3),
        ],
    ]
    .concat();
    calls.iter().for_each(|call| session.make(call, Nulls::NONE));
    assert_eq!(session.instance().terminate(), Status::Ok, "after a reset it runs as ever");
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The calls do what they are named for: else the fuzzers would only look at refusals.
    #[test]
    fn a_session_runs_saves_and_goes_back() {
        for version in Version::BOTH {
            let mut session = Session::new(Subject::Crowd, version);
            let parts = session
                .fmu
                .named("IntermediateSteps")
                .and_then(|at| session.fmu.integers.iter().position(|reference| *reference == at));
            let push = session.fmu.named(if version == Version::V2 { "agent[0].Fp.x" } else { "Fp" });
            let push = session.fmu.reals.iter().position(|reference| Some(*reference) == push).unwrap() as u8;
            let mut ok = |call: Call| {
                let before = session.instance().bytes();
                assert_eq!(session.perform(&call, &before), Status::Ok, "{call:?}");
                (session.instance().bytes(), session.held[0].updates.get())
            };
            if let Some(parts) = parts {
                ok(Call::SetInteger(vec![Reference::Fitting(parts as u8)], vec![4], 0));
            }
            ok(Call::Start);
            ok(Call::Set(push, 0, Real::Small(i16::MAX)));
            let (touching, updates) = ok(Call::Step(1));
            // Ten mechanical steps, made twice: callbacks after four and eight.
            assert_eq!(updates, if version == Version::V3 { 4 } else { 0 });
            assert_eq!(of_slave(&touching).1, 0.001);
            ok(Call::GetState(0));
            ok(Call::Serialize(0, 0));
            assert_ne!(ok(Call::Step(10)).0, touching);
            ok(Call::Deserialize(1, 1, vec![], Seal::Good));
            assert_eq!(ok(Call::SetState(1)).0, touching);
            ok(Call::Plain(Plain::Reset));
            let smaller = Call::Choose(1, 3, 4);
            ok(if version == Version::V3 { smaller } else { Call::Choose(0, 0, 1) });
            ok(Call::Start);
            let agents = if version == Version::V3 { 1 } else { 2 };
            assert_eq!(of_slave(&ok(Call::Step(1)).0).3.first().copied().unwrap_or(2), agents);
        }
    }

    /// Else no restored state would be looked at, or directories be made anywhere.
    #[test]
    fn the_output_directory_of_a_state_is_found() {
        let session = Session::new(Subject::Crowd, Version::V2);
        let text = (Reference::Raw(session.fmu.named("OutputDirectory").unwrap()), Text::Known(1));
        assert_eq!(session.set_string(&[text], 0), Status::Ok);
        for (bytes, place) in [(&session.pristine, 0), (&session.instance().bytes(), 1)] {
            let found = (session.fmu.output_directory)(&bytes[HEADER..]).unwrap();
            assert_eq!(found.as_bytes(), session.fmu.texts[place].as_bytes());
        }
    }

    #[test]
    fn a_good_seal_is_accepted_and_an_old_one_is_not() {
        let session = Session::new(Subject::Decision, Version::V2);
        let mut state = null_mut();
        for (seal, expected) in [(Seal::Old, Status::Error), (Seal::Good, Status::Ok)] {
            let last = Edit::Byte(u16::MAX, 0);
            let damaged = edited(&session.pristine, &[Edit::Real(1, Real::Special(2)), last], seal);
            assert_ne!(damaged, session.pristine);
            assert_eq!(session.instance().deserialize(&damaged, &mut state), expected);
        }
        session.instance().free(state);
    }
}
