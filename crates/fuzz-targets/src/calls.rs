//! Sequences of FMI calls, and damaged states.

use crate::importer::{Importer, Nulls, Plain, State, StatusOf, telling};
use crate::models::{Fmu, Fuzzed, OUTPUTS};
use crate::show_panics;
use arbitrary::{Arbitrary, Unstructured};
use crowd_mechanics::model::CrowdModel;
use lemons_decision::Decision;
use lemons_fmi::Status;
use std::ffi::{CStr, CString, c_int};
use std::rc::Rc;

/// Mechanical steps in one communication step, and in one run.
pub(crate) const STEP_WORK: f64 = 200.0;
pub(crate) const RUN_WORK: f64 = 1000.0;

/// Calls in one run.
pub(crate) const CALLS: usize = 100;

/// A number, often one of interest.
#[derive(Debug, Clone, Copy, Arbitrary)]
pub(crate) enum Real {
    Small(i16),
    Special(u8),
    Bits(u64),
}

impl Real {
    pub(crate) fn value(self) -> f64 {
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
pub(crate) enum Reference {
    /// Of the type that the call is about.
    Fitting(u8),
    Any(u8),
    Raw(u32),
}

/// At most this many elements in an array.
pub(crate) const MOST: usize = 12;

#[derive(Debug, Clone, Arbitrary)]
pub(crate) enum Text {
    Known(u8),
    Bytes(Vec<u8>),
    Null,
}

impl Text {
    pub(crate) fn choose(&self, known: &[CString]) -> Option<CString> {
        match self {
            Text::Known(k) => known.get(usize::from(*k) % known.len()).cloned(),
            Text::Bytes(bytes) => {
                CString::new(bytes.iter().copied().filter(|byte| *byte != 0).collect::<Vec<u8>>()).ok()
            }
            Text::Null => None,
        }
    }
}

/// A change to a serialised state, in its content unless said otherwise.
#[derive(Debug, Clone, Arbitrary)]
pub(crate) enum Edit {
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
pub(crate) enum Seal {
    Good,
    Old,
}

/// Magic, version, GUID, length: see `lemons_fmi::slave`.
pub(crate) const HEADER: usize = 36;

pub(crate) fn edited(bytes: &[u8], edits: &[Edit], seal: Seal) -> Vec<u8> {
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
pub(crate) enum At {
    Now,
    Near(i8),
    Real(Real),
}

#[derive(Debug, Clone, Arbitrary)]
enum Call {
    /// As masters do: from `fmi2SetupExperiment` to `fmi2ExitInitializationMode`.
    Start,
    /// Half of it.
    Prepare,
    /// One number of one variable: arrays are mostly refused for one of their elements.
    Set(u8, Real),
    Setup(Real, Real, Option<Real>),
    Plain(Plain),
    Logging(bool, Vec<Text>, Nulls),
    GetReal(Vec<Reference>, Nulls),
    GetInteger(Vec<Reference>, Nulls),
    GetBoolean(Vec<Reference>, Nulls),
    GetString(Vec<Reference>, Nulls),
    SetReal(Vec<(Reference, Real)>, Nulls),
    SetInteger(Vec<(Reference, c_int)>, Nulls),
    SetBoolean(Vec<(Reference, c_int)>, Nulls),
    SetString(Vec<(Reference, Text)>, Nulls),
    InputDerivatives(Vec<(Reference, Real, Option<i8>)>, Nulls),
    Derivatives(Vec<Reference>, Nulls),
    /// Some thousandths of a second from now.
    Step(u8),
    DoStep(At, Real),
    Status(StatusOf, i8, Nulls),
    GetState(u8, Nulls),
    SetState(u8),
    FreeState(u8, Nulls),
    Serialize(u8, i8, Nulls),
    Deserialize(u8, u8, Vec<Edit>, Seal, Nulls),
    Instantiate([Text; 3], i8, bool),
    /// The calls that follow go to the other instance.
    Other,
}

/// A state pointer of the importer's.
struct Slot {
    state: State,
    /// Whether `fmi2GetFMUstate` gave it, here or elsewhere.
    genuine: bool,
    /// Whether files would be written only where they may.
    in_its_place: bool,
}

/// An instance and its states.
struct Instance<M: Fuzzed> {
    importer: Importer<M>,
    slots: [Slot; 3],
}

impl<M: Fuzzed> Instance<M> {
    fn new(fmu: &Fmu) -> Instance<M> {
        let name = [Some(c"crowd"), Some(&*fmu.guid), Some(&*fmu.uri)];
        let importer = Importer::new(name, 1, 0).expect("an instance");
        Instance {
            importer,
            slots: [(); 3].map(|()| Slot { state: State::NULL, genuine: false, in_its_place: true }),
        }
    }
}

impl<M: Fuzzed> Drop for Instance<M> {
    fn drop(&mut self) {
        for slot in &mut self.slots {
            self.importer.free_state(&mut slot.state, Nulls::NONE);
        }
    }
}

/// A live state, as bytes.
fn bytes<M: Fuzzed>(importer: &Importer<M>) -> Vec<u8> {
    let mut state = State::NULL;
    assert_eq!(importer.get_state(&mut state, Nulls::NONE), Status::Ok);
    let bytes = serialized(importer, &state);
    assert_eq!(importer.free_state(&mut state, Nulls::NONE), Status::Ok);
    bytes
}

fn serialized<M: Fuzzed>(importer: &Importer<M>, state: &State) -> Vec<u8> {
    let (status, size) = importer.serialized_size(state, Nulls::NONE);
    assert_eq!(status, Status::Ok);
    let (status, bytes) = importer.serialize(state, size, Nulls::NONE);
    assert_eq!(status, Status::Ok);
    bytes
}

/// Goes back to what [`bytes`] gave.
fn restore<M: Fuzzed>(importer: &Importer<M>, bytes: &[u8]) {
    let mut state = State::NULL;
    assert_eq!(importer.deserialize(bytes, &mut state, Nulls::NONE), Status::Ok, "it was saved here");
    assert_eq!(importer.set_state(&state), Status::Ok, "it was saved here");
    importer.free_state(&mut state, Nulls::NONE);
}

/// All values, bit for bit, with the status of the calls that return them.
fn everything<M: Fuzzed>(importer: &Importer<M>, fmu: &Fmu) -> impl PartialEq + std::fmt::Debug {
    let reals = fmu.reals.iter().map(|at| importer.get_real(&[*at], Nulls::NONE));
    let reals: Vec<(Status, u64)> = reals.map(|(status, value)| (status, value[0].to_bits())).collect();
    let integers = fmu.integers.iter().map(|at| importer.get_integer(&[*at], Nulls::NONE));
    (reals, integers.collect::<Vec<_>>(), importer.get_string(&fmu.strings, Nulls::NONE))
}

/// All Reals, where they can be had, are finite.
fn finite<M: Fuzzed>(importer: &Importer<M>, fmu: &Fmu) {
    let (status, values) = importer.get_real(&fmu.reals, Nulls::NONE);
    if status == Status::Ok {
        for (reference, value) in fmu.reals.iter().zip(values) {
            assert!(value.is_finite(), "variable {reference} is {value} after Ok");
        }
    }
}

/// Whether files would be written only where they may. Asked before every call that may write: a damaged
/// state may name any directory.
fn writes_in_its_place<M: Fuzzed>(importer: &Importer<M>, fmu: &Fmu) -> bool {
    let Some(output) = fmu.output else { return true };
    let (status, texts) = importer.get_string(&[output], Nulls::NONE);
    status != Status::Ok || fmu.texts[..OUTPUTS].contains(&texts[0])
}

/// A step that makes at most some hundred mechanical steps, with their number.
fn bounded<M: Fuzzed>(importer: &Importer<M>, fmu: &Fmu, step: f64) -> (f64, f64) {
    /// More are refused at once: see `engine::step_count`.
    const REFUSED: f64 = 2e12;
    let Some(reference) = fmu.mechanical_step else { return (step, 0.0) };
    let (status, value) = importer.get_real(&[reference], Nulls::NONE);
    let steps = step / value[0];
    match status {
        Status::Ok if !(1.0..REFUSED).contains(&steps) => (step, 1.0),
        Status::Ok if steps > STEP_WORK => (value[0] * STEP_WORK, STEP_WORK),
        Status::Ok => (step, steps),
        _ => (step, 1.0),
    }
}

struct Session<M: Fuzzed> {
    fmu: Rc<Fmu>,
    /// Of an instance to which nothing has happened.
    pristine: Vec<u8>,
    instances: Vec<Instance<M>>,
    at: usize,
    /// What was serialised.
    saved: Vec<Vec<u8>>,
    /// Mechanical steps that may still be made.
    work: f64,
}

impl<M: Fuzzed> Session<M> {
    fn new() -> Session<M> {
        show_panics();
        let fmu = M::fmu();
        let first = Instance::new(&fmu);
        let pristine = bytes(&first.importer);
        let (instances, saved) = (vec![first], vec![pristine.clone()]);
        Session { fmu, pristine, instances, at: 0, saved, work: RUN_WORK }
    }

    fn importer(&self) -> &Importer<M> {
        &self.instances[self.at].importer
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

    /// A call, and what a refusal promises: nothing has changed.
    fn make(&mut self, call: &Call) {
        if let Call::Other = call {
            self.at = 1 - self.at;
            if self.instances.len() == self.at {
                self.instances.push(Instance::new(&self.fmu));
            }
            return;
        }
        let before = bytes(self.importer());
        let status = self.perform(call, &before);
        if telling() {
            eprintln!("{call:?}: {status:?}");
        }
        if matches!(status, Status::Error | Status::Discard) {
            self.unchanged(call, &before);
        }
    }

    /// The same bytes, or at least the same phase, time and values: a refused step or question may have
    /// computed what is not kept yet. A step that fails leads to the phase of errors, and nowhere else.
    fn unchanged(&self, call: &Call, before: &[u8]) {
        const PHASE: usize = HEADER;
        const TIME: std::ops::Range<usize> = HEADER + 1..HEADER + 9;
        const FAILED: u8 = 6;
        let importer = self.importer();
        let after = bytes(importer);
        if after == before {
            return;
        }
        let steps = matches!(call, Call::Step(_) | Call::DoStep(..));
        assert!(after[PHASE] == before[PHASE] || steps && after[PHASE] == FAILED, "{call:?}: its phase");
        assert_eq!(after[TIME], before[TIME], "{call:?}: its time");
        let now = everything(importer, &self.fmu);
        restore(importer, before);
        let then = everything(importer, &self.fmu);
        restore(importer, &after);
        assert_eq!(then, now, "a refused {call:?} has changed something");
    }

    fn perform(&mut self, call: &Call, before: &[u8]) -> Status {
        let fmu = self.fmu.clone();
        match call {
            Call::Other => Status::Ok,
            Call::Prepare => {
                self.importer().setup_experiment(0.0, 0.0, None);
                self.importer().plain(Plain::EnterInitializationMode);
                Status::Ok
            }
            Call::Start => {
                self.perform(&Call::Prepare, before);
                self.perform(&Call::Plain(Plain::ExitInitializationMode), before);
                Status::Ok
            }
            Call::Setup(tolerance, start, stop) => {
                let stop = stop.map(Real::value);
                self.importer().setup_experiment(tolerance.value(), start.value(), stop)
            }
            Call::Plain(function) => self.plain(*function),
            Call::Logging(on, texts, nulls) => {
                let known = [c"logStatusWarning", c"logStatusError", c"logStatusFatal", c"logAll", c"events"];
                let known = known.map(CStr::to_owned);
                let texts: Vec<_> = texts.iter().take(MOST).map(|text| text.choose(&known)).collect();
                let texts: Vec<_> = texts.iter().map(Option::as_deref).collect();
                self.instances[self.at].importer.debug_logging(*on, &texts, *nulls)
            }
            Call::GetReal(references, nulls) => {
                let references = self.references(references.iter().copied(), &fmu.reals);
                self.importer().get_real(&references, *nulls).0
            }
            Call::GetInteger(references, nulls) => {
                let references = self.references(references.iter().copied(), &fmu.integers);
                self.importer().get_integer(&references, *nulls).0
            }
            Call::GetBoolean(references, nulls) => {
                let references = self.references(references.iter().copied(), &[]);
                self.importer().get_boolean(&references, *nulls)
            }
            Call::GetString(references, nulls) => {
                let references = self.references(references.iter().copied(), &fmu.strings);
                self.importer().get_string(&references, *nulls).0
            }
            Call::Set(place, value) => {
                let reference = fmu.reals[usize::from(*place) % fmu.reals.len()];
                self.importer().set_real(&[reference], &[value.value()], Nulls::NONE)
            }
            Call::SetReal(settings, nulls) => {
                let references = self.references(settings.iter().map(|(at, _)| *at), &fmu.reals);
                let values: Vec<f64> = settings.iter().take(MOST).map(|(_, real)| real.value()).collect();
                self.importer().set_real(&references, &values, *nulls)
            }
            Call::SetInteger(settings, nulls) => {
                let references = self.references(settings.iter().map(|(at, _)| *at), &fmu.integers);
                let values: Vec<c_int> = settings.iter().take(MOST).map(|(_, value)| *value).collect();
                self.importer().set_integer(&references, &values, *nulls)
            }
            Call::SetBoolean(settings, nulls) => {
                let references = self.references(settings.iter().map(|(at, _)| *at), &[]);
                let values: Vec<c_int> = settings.iter().take(MOST).map(|(_, value)| *value).collect();
                self.importer().set_boolean(&references, &values, *nulls)
            }
            Call::SetString(settings, nulls) => self.set_string(settings, *nulls),
            Call::InputDerivatives(settings, nulls) => {
                let references = self.references(settings.iter().map(|(at, _, _)| *at), &fmu.reals);
                let (values, orders): (Vec<f64>, Vec<c_int>) = settings
                    .iter()
                    .take(MOST)
                    .map(|(_, real, order)| (real.value(), order.map_or(1, c_int::from)))
                    .unzip();
                self.importer().set_input_derivatives(&references, &orders, &values, *nulls)
            }
            Call::Derivatives(references, nulls) => {
                let references = self.references(references.iter().copied(), &fmu.reals);
                self.importer().get_derivatives(&references, *nulls);
                Status::Error
            }
            Call::Step(thousandths) => self.step(At::Now, f64::from(*thousandths) * 1e-3, before),
            Call::DoStep(at, step) => self.step(*at, step.value(), before),
            Call::Status(of, kind, nulls) => self.importer().status(*of, (*kind).into(), *nulls),
            Call::GetState(slot, nulls) => {
                let Instance { importer, slots } = &mut self.instances[self.at];
                let slot = &mut slots[usize::from(*slot) % 3];
                let status = importer.get_state(&mut slot.state, *nulls);
                if status == Status::Ok {
                    (slot.genuine, slot.in_its_place) = (true, true);
                }
                status
            }
            Call::SetState(slot) => {
                let Instance { importer, slots } = &self.instances[self.at];
                let slot = &slots[usize::from(*slot) % 3];
                if !slot.in_its_place {
                    return Status::Ok;
                }
                let status = importer.set_state(&slot.state);
                assert!(status == Status::Ok || slot.state.is_null() || !slot.genuine, "it was saved");
                status
            }
            Call::FreeState(slot, nulls) => {
                let Instance { importer, slots } = &mut self.instances[self.at];
                importer.free_state(&mut slots[usize::from(*slot) % 3].state, *nulls)
            }
            Call::Serialize(slot, surplus, nulls) => {
                let Instance { importer, slots } = &self.instances[self.at];
                let slot = &slots[usize::from(*slot) % 3];
                let (status, size) = importer.serialized_size(&slot.state, *nulls);
                if status != Status::Ok {
                    return status;
                }
                let buffer = size.saturating_add_signed((*surplus).into());
                let (status, bytes) = importer.serialize(&slot.state, buffer, *nulls);
                assert!(status != Status::Ok || size <= buffer, "the buffer is too small");
                if status == Status::Ok && slot.genuine && self.saved.len() < 8 {
                    self.saved.push(bytes);
                }
                status
            }
            Call::Deserialize(saved, slot, edits, seal, nulls) => {
                let saved = &self.saved[usize::from(*saved) % self.saved.len()];
                let bytes = if edits.is_empty() { saved.clone() } else { edited(saved, edits, *seal) };
                let Instance { importer, slots } = &mut self.instances[self.at];
                let slot = &mut slots[usize::from(*slot) % 3];
                let status = importer.deserialize(&bytes, &mut slot.state, *nulls);
                if status == Status::Ok {
                    let content = bytes.get(HEADER..).unwrap_or_default();
                    slot.genuine = edits.is_empty();
                    slot.in_its_place = M::output_directory(content).is_some_and(|name| {
                        fmu.texts[..OUTPUTS].iter().any(|own| own.as_bytes() == name.as_bytes())
                    });
                }
                status
            }
            Call::Instantiate(texts, kind, logging) => {
                let known = [&fmu.guid, &fmu.uri].map(Clone::clone);
                let texts = texts.each_ref().map(|text| text.choose(&known));
                let made = Importer::<M>::new(
                    texts.each_ref().map(Option::as_deref),
                    (*kind).into(),
                    (*logging).into(),
                );
                if let Some(importer) = made {
                    assert_eq!(bytes(&importer), self.pristine);
                }
                Status::Ok
            }
        }
    }

    fn plain(&self, function: Plain) -> Status {
        let importer = self.importer();
        if function == Plain::ExitInitializationMode && !writes_in_its_place(importer, &self.fmu) {
            return Status::Ok;
        }
        let status = importer.plain(function);
        if function == Plain::Reset {
            assert_eq!(status, Status::Ok, "allowed in every state");
            assert_eq!(bytes(importer), self.pristine, "as after fmi2Instantiate");
        }
        status
    }

    fn set_string(&self, settings: &[(Reference, Text)], nulls: Nulls) -> Status {
        let fmu = &*self.fmu;
        let references = self.references(settings.iter().map(|(at, _)| *at), &fmu.strings);
        let texts: Vec<Option<CString>> = settings
            .iter()
            .zip(&references)
            .map(|((_, text), at)| {
                let known = if Some(*at) == fmu.output { &fmu.texts[..OUTPUTS] } else { &fmu.texts };
                match text {
                    // Files are written there.
                    Text::Bytes(_) if Some(*at) == fmu.output => Text::Known(1).choose(known),
                    text => text.choose(known),
                }
            })
            .collect();
        let texts: Vec<_> = texts.iter().map(Option::as_deref).collect();
        self.importer().set_string(&references, &texts, nulls)
    }

    /// A step. If it is made, its outputs are finite, and made again from the state before it ends in the same one.
    fn step(&mut self, at: At, step: f64, before: &[u8]) -> Status {
        let fmu = self.fmu.clone();
        let (step, steps) = bounded(self.importer(), &fmu, step);
        if self.work < steps || !writes_in_its_place(self.importer(), &fmu) {
            return Status::Ok;
        }
        self.work -= steps;
        let importer = self.importer();
        let now = importer.time().unwrap_or(0.0);
        let from = match at {
            At::Now => now,
            At::Near(ulps) => f64::from_bits(now.to_bits().saturating_add_signed(ulps.into())),
            At::Real(real) => real.value(),
        };
        let status = importer.do_step(from, step);
        if status == Status::Ok {
            finite(importer, &fmu);
            let after = bytes(importer);
            restore(importer, before);
            assert_eq!(importer.do_step(from, step), Status::Ok, "as before");
            assert_eq!(bytes(importer), after, "the same step from the same state");
        }
        status
    }
}

fn calls<M: Fuzzed>(data: &[u8]) {
    let mut session = Session::<M>::new();
    let mut input = Unstructured::new(data);
    for _ in 0..CALLS {
        let (false, Ok(call)) = (input.is_empty(), Call::arbitrary(&mut input)) else { break };
        session.make(&call);
    }
}

/// FMI calls on a crowd of two people.
pub fn fmi_calls(data: &[u8]) {
    calls::<CrowdModel>(data);
}

/// FMI calls on the Decision of two people.
pub fn decision_calls(data: &[u8]) {
    calls::<Decision>(data);
}

/// Where a state is saved that is then damaged.
#[derive(Debug, Clone, Copy, Arbitrary)]
enum Saved {
    Instantiated,
    Initialization,
    Running,
    /// With a drive and its rate.
    Driven,
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
pub fn states(data: &[u8]) {
    let Some((&model, data)) = data.split_first() else { return };
    let Ok(damaged) = Damaged::arbitrary_take_rest(Unstructured::new(data)) else { return };
    if model % 4 == 3 { run_on::<Decision>(&damaged) } else { run_on::<CrowdModel>(&damaged) }
}

fn run_on<M: Fuzzed>(damaged: &Damaged) {
    let mut session = Session::<M>::new();
    let inputs = |value: i16| {
        let settings = (0..3).map(|k| (Reference::Fitting(3 + k), Real::Small(value * i16::from(k))));
        settings.collect::<Vec<_>>()
    };
    let first: Vec<Call> = match damaged.saved {
        Saved::Instantiated => vec![],
        Saved::Initialization => vec![Call::Prepare, Call::SetReal(inputs(256), Nulls::NONE)],
        Saved::Running => vec![Call::Start, Call::Step(1)],
        Saved::Driven => {
            let rates = inputs(512).into_iter().map(|(at, rate)| (at, rate, None)).collect();
            vec![
                Call::SetReal(inputs(2560), Nulls::NONE),
                Call::Start,
                Call::Step(2),
                Call::InputDerivatives(rates, Nulls::NONE),
            ]
        }
        Saved::Terminated => vec![Call::Start, Call::Plain(Plain::Terminate)],
    };
    first.iter().for_each(|call| session.make(call));
    session.saved = vec![bytes(session.importer())];
    session.make(&Call::Deserialize(0, 0, damaged.edits.clone(), damaged.seal, Nulls::NONE));
    let slot = &session.instances[0].slots[0];
    if slot.state.is_null() {
        return;
    }
    // What was read is written as it was read.
    let again = serialized(session.importer(), &slot.state);
    let mut state = State::NULL;
    assert_eq!(session.importer().deserialize(&again, &mut state, Nulls::NONE), Status::Ok);
    assert_eq!(serialized(session.importer(), &state), again);
    session.importer().free_state(&mut state, Nulls::NONE);
    session.make(&Call::SetState(0));
    for call in [
        Call::Plain(Plain::ExitInitializationMode),
        Call::Step(1),
        Call::SetReal(inputs(25), Nulls::NONE),
        Call::Step(20),
        Call::Plain(Plain::Terminate),
        Call::Plain(Plain::Reset),
        Call::Start,
        Call::Step(3),
    ] {
        session.make(&call);
    }
    let last = session.importer().plain(Plain::Terminate);
    assert_eq!(last, Status::Ok, "after a reset it runs as ever");
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The calls do what they are named for: else the fuzzers would only look at refusals.
    #[test]
    fn a_session_runs_saves_and_goes_back() {
        let mut session = Session::<CrowdModel>::new();
        let push = vec![(Reference::Fitting(3), Real::Small(i16::MAX))];
        let mut ok = |call: Call| {
            let before = bytes(session.importer());
            assert_eq!(session.perform(&call, &before), Status::Ok, "{call:?}");
            (bytes(session.importer()), session.importer().time())
        };
        ok(Call::Start);
        ok(Call::SetReal(push, Nulls::NONE));
        let (touching, time) = ok(Call::Step(1));
        assert_eq!(time, Some(0.001));
        ok(Call::GetState(0, Nulls::NONE));
        ok(Call::Serialize(0, 0, Nulls::NONE));
        assert_ne!(ok(Call::Step(10)).0, touching);
        ok(Call::Deserialize(1, 1, vec![], Seal::Good, Nulls::NONE));
        assert_eq!(ok(Call::SetState(1)).0, touching);
        let (_, contacts) = session.importer().get_integer(&session.fmu.integers, Nulls::NONE);
        // Threads, contacts of agents, contacts with walls.
        assert!(contacts[1] > 0 && contacts[2] > 0, "{contacts:?}");
    }

    /// Else no restored state would be looked at, or directories be made anywhere.
    #[test]
    fn the_output_directory_of_a_state_is_found() {
        let session = Session::<CrowdModel>::new();
        let text = (Reference::Any(u8::try_from(session.fmu.output.unwrap()).unwrap()), Text::Known(1));
        assert_eq!(session.set_string(&[text], Nulls::NONE), Status::Ok);
        for (bytes, place) in [(&session.pristine, 0), (&bytes(session.importer()), 1)] {
            let found = CrowdModel::output_directory(&bytes[HEADER..]).unwrap();
            assert_eq!(found.as_bytes(), session.fmu.texts[place].as_bytes());
        }
    }

    #[test]
    fn a_good_seal_is_accepted_and_an_old_one_is_not() {
        let session = Session::<Decision>::new();
        let (importer, mut state) = (session.importer(), State::NULL);
        for (seal, expected) in [(Seal::Old, Status::Error), (Seal::Good, Status::Ok)] {
            let last = Edit::Byte(u16::MAX, 0);
            let damaged = edited(&session.pristine, &[Edit::Real(1, Real::Special(2)), last], seal);
            assert_ne!(damaged, session.pristine);
            assert_eq!(importer.deserialize(&damaged, &mut state, Nulls::NONE), expected);
        }
        importer.free_state(&mut state, Nulls::NONE);
    }
}
