//! Sequences of FMI 3.0 calls, and damaged states: as [`calls`](crate::calls), with whole arrays and their sizes.

use crate::calls::{At, CALLS, Edit, HEADER, MOST, RUN_WORK, Real, Reference, STEP_WORK, Seal, Text, edited};
use crate::importer::{Nulls, State, telling};
use crate::importer3::{Absent, Foreign, Importer3, Plain3, Within};
use crate::models::{Fmu, Fuzzed, OUTPUTS, SMALLER};
use crate::show_panics;
use arbitrary::{Arbitrary, Unstructured};
use crowd_mechanics::model::CrowdModel;
use lemons_decision::Decision;
use lemons_fmi::Status;
use lemons_fmi::v3::arrays::{Dimension, array_reference, size_reference};
use lemons_fmi::v3::{ArrayModel, token};
use lemons_fmi::variables::Kind;
use std::ffi::{CStr, CString};
use std::rc::Rc;

/// Longer arrays are not passed: they are refused at once.
const LONGEST: u64 = 256;

#[derive(Debug, Clone, Arbitrary)]
enum Call3 {
    /// As masters do: into Initialization Mode and out of it.
    Start,
    /// Into Initialization Mode.
    Prepare,
    /// Sizes and a Trial that belong together, or do not.
    Choose(u8, u8, u8),
    EnterInitialization(Real, Real, Option<Real>),
    Plain(Plain3),
    Foreign(Foreign, Nulls),
    Absent(Absent, Vec<Reference>, bool),
    Logging(bool, Vec<Text>, Nulls),
    /// References, and how many values more than fit.
    GetFloat64(Vec<Reference>, i8, Nulls),
    GetInt32(Vec<Reference>, i8, Nulls),
    GetUInt64(Vec<Reference>, i8, Nulls),
    GetString(Vec<Reference>, i8, Nulls),
    /// One element of one array, the others as they are.
    SetElement(u8, u8, Real),
    /// The values again and again.
    SetFloat64(Vec<Reference>, Vec<Real>, i8, Nulls),
    SetInt32(Vec<Reference>, Vec<i32>, i8, Nulls),
    SetUInt64(Vec<(Reference, u64)>, Nulls),
    SetString(Vec<(Reference, Text)>, i8, Nulls),
    OutputDerivatives(Vec<(Reference, Option<i8>)>, i8, Nulls),
    Dependencies(Reference, u8, Nulls),
    Within(Within),
    /// Some thousandths of a second from now.
    Step(u8),
    DoStep(At, Real, Nulls),
    GetState(u8, Nulls),
    SetState(u8),
    FreeState(u8, Nulls),
    Serialize(u8, i8, Nulls),
    Deserialize(u8, u8, Vec<Edit>, Seal, Nulls),
    Instantiate([Text; 3], [bool; 4]),
    /// The calls that follow go to the other instance.
    Other,
}

/// A state pointer of the importer's.
struct Slot {
    state: State,
    /// Whether `fmi3GetFMUState` gave it, here or elsewhere.
    genuine: bool,
    /// Whether files would be written only where they may.
    in_its_place: bool,
}

/// An instance and its states.
struct Instance<M: ArrayModel> {
    importer: Importer3<M>,
    slots: [Slot; 3],
}

impl<M: ArrayModel> Drop for Instance<M> {
    fn drop(&mut self) {
        for slot in &mut self.slots {
            self.importer.free_state(&mut slot.state, Nulls::NONE);
        }
    }
}

/// A live state, as bytes.
fn bytes<M: ArrayModel>(importer: &Importer3<M>) -> Vec<u8> {
    let mut state = State::NULL;
    assert_eq!(importer.get_state(&mut state, Nulls::NONE), Status::Ok);
    let bytes = serialized(importer, &state);
    assert_eq!(importer.free_state(&mut state, Nulls::NONE), Status::Ok);
    bytes
}

fn serialized<M: ArrayModel>(importer: &Importer3<M>, state: &State) -> Vec<u8> {
    let (status, size) = importer.serialized_size(state, Nulls::NONE);
    assert_eq!(status, Status::Ok);
    let (status, bytes) = importer.serialize(state, size, Nulls::NONE);
    assert_eq!(status, Status::Ok);
    bytes
}

/// Goes back to what [`bytes`] gave.
fn restore<M: ArrayModel>(importer: &Importer3<M>, bytes: &[u8]) {
    let mut state = State::NULL;
    assert_eq!(importer.deserialize(bytes, &mut state, Nulls::NONE), Status::Ok, "it was saved here");
    assert_eq!(importer.set_state(&state), Status::Ok, "it was saved here");
    importer.free_state(&mut state, Nulls::NONE);
}

/// Time \[s\] and sizes in a state.
fn of_slave(bytes: &[u8]) -> (f64, Vec<u64>) {
    /// Phase, time, experiment, sizes.
    type OfSlave = (u32, f64, Option<(f64, Option<f64>)>, Vec<u64>);
    let (_, time, _, sizes) = postcard::take_from_bytes::<OfSlave>(&bytes[HEADER..]).expect("a state").0;
    (time, sizes)
}

/// A variable that is an array.
#[derive(Clone, Copy)]
struct Variable {
    reference: u32,
    kind: Kind,
    dimensions: &'static [Dimension],
}

/// What the model description says.
struct Interface {
    path: CString,
    token: CString,
    variables: Vec<Variable>,
    sizes: Vec<u32>,
    texts: Vec<CString>,
    mechanical_step: Option<u32>,
    output: Option<u32>,
    intermediate: Option<u32>,
}

impl Interface {
    fn of<M: ArrayModel>(fmu: &Fmu) -> Interface {
        let arrays = M::arrays();
        let named = |name: &str| {
            let place = arrays.iter().position(|array| array.name == name);
            place.map(array_reference::<M>)
        };
        let text = |text: &str| CString::new(text).expect("no zero inside");
        let variable = |(place, array): (usize, &lemons_fmi::v3::Array<M::Block>)| Variable {
            reference: array_reference::<M>(place),
            kind: array.kind,
            dimensions: array.dimensions,
        };
        let uri = fmu.uri.to_str().expect("UTF-8");
        Interface {
            path: text(uri.trim_start_matches("file://")),
            token: text(&token::<M>().braced().to_string()),
            variables: arrays.iter().enumerate().map(variable).collect(),
            sizes: (0..M::SIZES.len()).map(size_reference).collect(),
            texts: fmu.texts.iter().cloned().chain([text(SMALLER)]).collect(),
            mechanical_step: named("TimeStepMechanical"),
            output: named("OutputDirectory"),
            intermediate: named("IntermediateSteps"),
        }
    }

    fn of_kind(&self, wanted: fn(Kind) -> bool) -> Vec<u32> {
        let variables = self.variables.iter().filter(|variable| wanted(variable.kind));
        variables.map(|variable| variable.reference).collect()
    }

    fn reals(&self) -> Vec<u32> {
        self.of_kind(|kind| matches!(kind, Kind::Real(_)))
    }

    fn integers(&self) -> Vec<u32> {
        self.of_kind(|kind| kind == Kind::Integer)
    }

    fn strings(&self) -> Vec<u32> {
        self.of_kind(|kind| kind == Kind::String)
    }

    /// The number of elements of variables of these sizes together.
    fn length(&self, references: &[u32], sizes: &[u64]) -> usize {
        let length = |reference: &u32| {
            let variable = self.variables.iter().find(|variable| variable.reference == *reference);
            variable.map_or(1, |variable| {
                let sizes = variable.dimensions.iter().map(|dimension| match *dimension {
                    Dimension::Fixed(size) => size,
                    Dimension::Size(place) => sizes[place].min(LONGEST),
                });
                sizes.product::<u64>().min(LONGEST)
            })
        };
        references.iter().map(length).sum::<u64>() as usize
    }
}

struct Session<M: Fuzzed + ArrayModel> {
    interface: Interface,
    /// Alive as long as its directory is needed.
    _fmu: Rc<Fmu>,
    /// Of an instance to which nothing has happened.
    pristine: Vec<u8>,
    instances: Vec<Instance<M>>,
    at: usize,
    /// What was serialised.
    saved: Vec<Vec<u8>>,
    /// Mechanical steps that may still be made.
    work: f64,
}

fn instance<M: ArrayModel>(interface: &Interface, early: bool) -> Instance<M> {
    let name = [Some(c"crowd"), Some(&*interface.token), Some(&*interface.path)];
    let importer = Importer3::new(name, [true, false, early, true]).expect("an instance");
    let slot = || Slot { state: State::NULL, genuine: false, in_its_place: true };
    Instance { importer, slots: [(); 3].map(|()| slot()) }
}

impl<M: Fuzzed + ArrayModel> Session<M> {
    fn new() -> Session<M> {
        show_panics();
        let fmu = M::fmu();
        let interface = Interface::of::<M>(&fmu);
        let first = instance::<M>(&interface, false);
        let pristine = bytes(&first.importer);
        let (instances, saved) = (vec![first], vec![pristine.clone()]);
        Session { interface, _fmu: fmu, pristine, instances, at: 0, saved, work: RUN_WORK }
    }

    fn importer(&self) -> &Importer3<M> {
        &self.instances[self.at].importer
    }

    fn references(&self, wanted: impl Iterator<Item = Reference>, fitting: &[u32]) -> Vec<u32> {
        let count = self.interface.variables.len() as u32 + 5;
        let choose = |reference| match reference {
            Reference::Fitting(k) => {
                fitting.get(usize::from(k) % fitting.len().max(1)).copied().unwrap_or(u32::from(k))
            }
            Reference::Any(k) => u32::from(k) % count,
            Reference::Raw(raw) => raw,
        };
        wanted.take(MOST).map(choose).collect()
    }

    /// The length that these variables have, and some more or less.
    fn length(&self, references: &[u32], more: i8, before: &[u8]) -> usize {
        // Mostly the right one.
        let more = if more.unsigned_abs() < 96 { 0 } else { isize::from(more % 8) };
        self.interface.length(references, &of_slave(before).1).saturating_add_signed(more)
    }

    /// All values, bit for bit, with the status of the calls that return them.
    fn everything(&self, sizes: &[u64]) -> impl PartialEq + std::fmt::Debug {
        let (importer, interface) = (self.importer(), &self.interface);
        let length = |reference: u32| interface.length(&[reference], sizes);
        let reals = interface.reals().into_iter().map(|at| {
            let (status, values) = importer.get_float64(&[at], length(at), Nulls::NONE);
            (status, values.into_iter().map(f64::to_bits).collect::<Vec<_>>())
        });
        let integers = interface.integers().into_iter();
        let integers = integers.map(|at| importer.get_int32(&[at], length(at), Nulls::NONE));
        let strings = interface.strings().into_iter();
        let strings = strings.map(|at| importer.get_string(&[at], length(at), Nulls::NONE));
        (reals.collect::<Vec<_>>(), integers.collect::<Vec<_>>(), strings.collect::<Vec<_>>())
    }

    /// Whether files would be written only where they may. Asked before every call that may write.
    fn writes_in_its_place(&self) -> bool {
        let Some(output) = self.interface.output else { return true };
        let (status, texts) = self.importer().get_string(&[output], 1, Nulls::NONE);
        status != Status::Ok || self.interface.texts[..OUTPUTS].contains(&texts[0])
    }

    /// A call, and what a refusal promises: nothing has changed.
    fn make(&mut self, call: &Call3) {
        if let Call3::Other = call {
            self.at = 1 - self.at;
            if self.instances.len() == self.at {
                self.instances.push(instance(&self.interface, true));
            }
            return;
        }
        let before = bytes(self.importer());
        let status = self.perform(call, &before);
        if telling() {
            eprintln!("{call:?}: {status:?}");
        }
        if status == Status::Error {
            self.unchanged(call, &before);
        }
    }

    /// As in [`calls`](crate::calls): the same bytes, or the same phase, time and values. A step that fails leads to the
    /// phase of errors, perhaps after the first parts of it.
    fn unchanged(&self, call: &Call3, before: &[u8]) {
        const PHASE: usize = HEADER;
        const FAILED: u8 = 6;
        let importer = self.importer();
        let after = bytes(importer);
        if after == before {
            return;
        }
        let steps = matches!(call, Call3::Step(_) | Call3::DoStep(..));
        if steps && after[PHASE] == FAILED {
            return;
        }
        assert_eq!(after[PHASE], before[PHASE], "{call:?}: its phase");
        let (now, sizes) = of_slave(&after);
        assert_eq!((now, &sizes), (of_slave(before).0, &of_slave(before).1), "{call:?}: its time and sizes");
        let now = self.everything(&sizes);
        restore(importer, before);
        let then = self.everything(&sizes);
        restore(importer, &after);
        assert_eq!(then, now, "a refused {call:?} has changed something");
    }

    fn perform(&mut self, call: &Call3, before: &[u8]) -> Status {
        let (reals, integers, strings) =
            (self.interface.reals(), self.interface.integers(), self.interface.strings());
        match call {
            Call3::Other => Status::Ok,
            Call3::Prepare => {
                self.importer().enter_initialization(0.0, 0.0, None);
                Status::Ok
            }
            Call3::Start => {
                self.perform(&Call3::Prepare, before);
                self.perform(&Call3::Plain(Plain3::ExitInitializationMode), before);
                Status::Ok
            }
            Call3::Choose(first, second, trial) => {
                self.importer().plain(Plain3::EnterConfigurationMode);
                let values = [*first, *second].map(|size| u64::from(size % 4));
                self.importer().set_uint64(&self.interface.sizes, &values, Nulls::NONE);
                self.importer().plain(Plain3::ExitConfigurationMode);
                let known = &self.interface.texts[OUTPUTS..];
                let text = &*known[usize::from(*trial) % known.len()];
                let trial = strings.first().copied().unwrap_or(0);
                if Some(trial) != self.interface.output {
                    self.importer().set_string(&[trial], &[Some(text)], Nulls::NONE);
                }
                Status::Ok
            }
            Call3::EnterInitialization(tolerance, start, stop) => {
                let stop = stop.map(Real::value);
                self.importer().enter_initialization(tolerance.value(), start.value(), stop)
            }
            Call3::Plain(function) => self.plain(*function),
            Call3::Foreign(function, nulls) => self.importer().foreign(*function, *nulls),
            Call3::Absent(kind, references, set) => {
                let references = self.references(references.iter().copied(), &reals);
                self.importer().absent(*kind, &references, *set)
            }
            Call3::Logging(on, texts, nulls) => {
                let known = [c"logStatusWarning", c"logStatusError", c"logStatusFatal", c"logAll", c"events"];
                let known = known.map(CStr::to_owned);
                let texts: Vec<_> = texts.iter().take(MOST).map(|text| text.choose(&known)).collect();
                let texts: Vec<_> = texts.iter().map(Option::as_deref).collect();
                self.instances[self.at].importer.debug_logging(*on, &texts, *nulls)
            }
            Call3::GetFloat64(references, more, nulls) => {
                let references = self.references(references.iter().copied(), &reals);
                let length = self.length(&references, *more, before);
                let (status, values) = self.importer().get_float64(&references, length, *nulls);
                assert!(status != Status::Ok || values.iter().all(|value| value.is_finite()), "{values:?}");
                status
            }
            Call3::GetInt32(references, more, nulls) => {
                let references = self.references(references.iter().copied(), &integers);
                let length = self.length(&references, *more, before);
                self.importer().get_int32(&references, length, *nulls).0
            }
            Call3::GetUInt64(references, more, nulls) => {
                let references = self.references(references.iter().copied(), &self.interface.sizes);
                let length = self.length(&references, *more, before);
                self.importer().get_uint64(&references, length, *nulls).0
            }
            Call3::GetString(references, more, nulls) => {
                let references = self.references(references.iter().copied(), &strings);
                let length = self.length(&references, *more, before);
                self.importer().get_string(&references, length, *nulls).0
            }
            Call3::SetElement(array, element, value) => {
                let reference = reals[usize::from(*array) % reals.len()];
                let length = self.length(&[reference], 0, before);
                let (status, mut values) = self.importer().get_float64(&[reference], length, Nulls::NONE);
                if status != Status::Ok {
                    values.fill(1.0);
                }
                if let Some(at) = usize::from(*element).checked_rem(length) {
                    values[at] = value.value();
                }
                self.importer().set_float64(&[reference], &values, Nulls::NONE)
            }
            Call3::SetFloat64(references, values, more, nulls) => {
                let references = self.references(references.iter().copied(), &reals);
                let length = self.length(&references, *more, before);
                let values = values.iter().map(|real| real.value()).chain([1.0]);
                let values: Vec<f64> = values.collect::<Vec<_>>().into_iter().cycle().take(length).collect();
                self.importer().set_float64(&references, &values, *nulls)
            }
            Call3::SetInt32(references, values, more, nulls) => {
                let references = self.references(references.iter().copied(), &integers);
                let length = self.length(&references, *more, before);
                let values: Vec<i32> = values
                    .iter()
                    .copied()
                    .chain([1])
                    .collect::<Vec<_>>()
                    .into_iter()
                    .cycle()
                    .take(length)
                    .collect();
                self.importer().set_int32(&references, &values, *nulls)
            }
            Call3::SetUInt64(settings, nulls) => {
                let references = self.references(settings.iter().map(|(at, _)| *at), &self.interface.sizes);
                let values: Vec<u64> = settings.iter().take(MOST).map(|(_, value)| *value).collect();
                self.importer().set_uint64(&references, &values, *nulls)
            }
            Call3::SetString(settings, more, nulls) => self.set_string(settings, *more, *nulls, &strings),
            Call3::OutputDerivatives(wanted, more, nulls) => {
                let references = self.references(wanted.iter().map(|(at, _)| *at), &reals);
                let orders: Vec<i32> =
                    wanted.iter().take(MOST).map(|(_, order)| order.map_or(1, i32::from)).collect();
                let length = self.length(&references, *more, before);
                self.importer().output_derivatives(&references, &orders, length, *nulls)
            }
            Call3::Dependencies(reference, more, nulls) => {
                let reference = self.references([*reference].into_iter(), &reals)[0];
                let more = if *more < 240 { 0 } else { usize::from(more - 239) };
                self.importer().dependencies(reference, more, *nulls)
            }
            Call3::Within(within) => {
                self.importer().within(*within);
                Status::Ok
            }
            Call3::Step(thousandths) => {
                self.step(At::Now, f64::from(*thousandths) * 1e-3, Nulls::NONE, before)
            }
            Call3::DoStep(at, step, nulls) => self.step(*at, step.value(), *nulls, before),
            Call3::GetState(slot, nulls) => {
                let Instance { importer, slots } = &mut self.instances[self.at];
                let slot = &mut slots[usize::from(*slot) % 3];
                let status = importer.get_state(&mut slot.state, *nulls);
                if status == Status::Ok {
                    (slot.genuine, slot.in_its_place) = (true, true);
                }
                status
            }
            Call3::SetState(slot) => {
                let Instance { importer, slots } = &self.instances[self.at];
                let slot = &slots[usize::from(*slot) % 3];
                if !slot.in_its_place {
                    return Status::Ok;
                }
                let status = importer.set_state(&slot.state);
                assert!(status == Status::Ok || slot.state.is_null() || !slot.genuine, "it was saved");
                status
            }
            Call3::FreeState(slot, nulls) => {
                let Instance { importer, slots } = &mut self.instances[self.at];
                importer.free_state(&mut slots[usize::from(*slot) % 3].state, *nulls)
            }
            Call3::Serialize(slot, more, nulls) => {
                let Instance { importer, slots } = &self.instances[self.at];
                let slot = &slots[usize::from(*slot) % 3];
                let (status, size) = importer.serialized_size(&slot.state, Nulls::NONE);
                if status != Status::Ok {
                    return status;
                }
                let length = size.saturating_add_signed((*more).into());
                let (status, mut bytes) = importer.serialize(&slot.state, length, *nulls);
                assert_eq!(status == Status::Ok, length >= size && !nulls.at(0), "a buffer too small");
                bytes.truncate(size);
                if status == Status::Ok && slot.genuine && self.saved.len() < 8 {
                    self.saved.push(bytes);
                }
                status
            }
            Call3::Deserialize(saved, slot, edits, seal, nulls) => {
                let saved = &self.saved[usize::from(*saved) % self.saved.len()];
                let bytes = if edits.is_empty() { saved.clone() } else { edited(saved, edits, *seal) };
                let outputs = &self.interface.texts[..OUTPUTS];
                let Instance { importer, slots } = &mut self.instances[self.at];
                let slot = &mut slots[usize::from(*slot) % 3];
                let status = importer.deserialize(&bytes, &mut slot.state, *nulls);
                if status == Status::Ok {
                    let content = bytes.get(HEADER..).unwrap_or_default();
                    slot.genuine = edits.is_empty();
                    slot.in_its_place = M::output_directory(content)
                        .is_some_and(|name| outputs.iter().any(|own| own.as_bytes() == name.as_bytes()));
                }
                status
            }
            Call3::Instantiate(texts, flags) => {
                let known = [&self.interface.token, &self.interface.path].map(Clone::clone);
                let texts = texts.each_ref().map(|text| text.choose(&known));
                let made = Importer3::<M>::new(texts.each_ref().map(Option::as_deref), *flags);
                if let Some(importer) = made {
                    assert_eq!(bytes(&importer), self.pristine);
                }
                Status::Ok
            }
        }
    }

    fn plain(&self, function: Plain3) -> Status {
        if function == Plain3::ExitInitializationMode && !self.writes_in_its_place() {
            return Status::Ok;
        }
        let importer = self.importer();
        let status = importer.plain(function);
        if function == Plain3::Reset {
            assert_eq!(status, Status::Ok, "allowed in every state");
            assert_eq!(bytes(importer), self.pristine, "as after fmi3InstantiateCoSimulation");
        }
        status
    }

    fn set_string(&self, settings: &[(Reference, Text)], more: i8, nulls: Nulls, fitting: &[u32]) -> Status {
        let (output, known) = (self.interface.output, &self.interface.texts);
        let references = self.references(settings.iter().map(|(at, _)| *at), fitting);
        let texts = settings.iter().zip(&references).map(|((_, text), at)| match text {
            // Files are written there.
            Text::Bytes(_) if Some(*at) == output => Text::Known(1).choose(&known[..OUTPUTS]),
            text if Some(*at) == output => text.choose(&known[..OUTPUTS]),
            text => text.choose(known),
        });
        let mut texts: Vec<Option<CString>> = texts.collect();
        // Mostly as many as there are variables.
        if more > 120 {
            texts.push(None);
        } else if more < -120 {
            texts.pop();
        }
        let texts: Vec<_> = texts.iter().map(Option::as_deref).collect();
        self.importer().set_string(&references, &texts, nulls)
    }

    /// A step that makes at most some hundred mechanical steps, with their number.
    fn bounded(&self, step: f64) -> (f64, f64) {
        /// More are refused at once: see `engine::step_count`.
        const REFUSED: f64 = 2e12;
        let Some(reference) = self.interface.mechanical_step else { return (step, 0.0) };
        let (status, value) = self.importer().get_float64(&[reference], 1, Nulls::NONE);
        let steps = step / value[0];
        match status {
            Status::Ok if !(1.0..REFUSED).contains(&steps) => (step, 1.0),
            Status::Ok if steps > STEP_WORK => (value[0] * STEP_WORK, STEP_WORK),
            Status::Ok => (step, steps),
            _ => (step, 1.0),
        }
    }

    /// A step. If it is made, its outputs are finite, and made again from the state before it ends in the same one. If it
    /// returned early, a step to where it ended does.
    fn step(&mut self, at: At, step: f64, nulls: Nulls, before: &[u8]) -> Status {
        let (step, steps) = self.bounded(step);
        if self.work < steps || !self.writes_in_its_place() {
            return Status::Ok;
        }
        self.work -= steps;
        let importer = self.importer();
        let now = of_slave(before).0;
        let from = match at {
            At::Now => now,
            At::Near(ulps) => f64::from_bits(now.to_bits().saturating_add_signed(ulps.into())),
            At::Real(real) => real.value(),
        };
        let updates = importer.updates();
        let done = importer.do_step(from, step, nulls);
        if done.status == Status::Ok {
            assert!(!done.early || importer.updates() > updates, "only the callback asks for it");
            let (reached, sizes) = of_slave(&bytes(importer));
            assert!(nulls.at(3) || done.time.to_bits() == reached.to_bits(), "the time that it has reached");
            let reals = self.interface.reals();
            let length = self.interface.length(&reals, &sizes);
            let (status, values) = importer.get_float64(&reals, length, Nulls::NONE);
            assert!(status != Status::Ok || values.iter().all(|value| value.is_finite()), "{values:?}");
            let after = bytes(importer);
            restore(importer, before);
            let again = importer.do_step(from, step, nulls);
            assert_eq!((again.status, again.early), (Status::Ok, done.early), "as before");
            assert_eq!(bytes(importer), after, "the same step from the same state");
        }
        done.status
    }
}

fn calls<M: Fuzzed + ArrayModel>(data: &[u8]) {
    let mut session = Session::<M>::new();
    let mut input = Unstructured::new(data);
    for _ in 0..CALLS {
        let (false, Ok(call)) = (input.is_empty(), Call3::arbitrary(&mut input)) else { break };
        session.make(&call);
    }
}

/// FMI 3.0 calls on a crowd of two people.
pub fn fmi3_calls(data: &[u8]) {
    calls::<CrowdModel>(data);
}

/// FMI 3.0 calls on the Decision of two people.
pub fn decision3_calls(data: &[u8]) {
    calls::<Decision>(data);
}

/// Where a state is saved that is then damaged.
#[derive(Debug, Clone, Copy, Arbitrary)]
enum Saved {
    Instantiated,
    Configuration,
    Initialization,
    Running,
    /// After a step in parts.
    Parts,
    /// Of a Trial of another size.
    Smaller,
    Terminated,
}

/// A state saved somewhere, damaged, restored and run on.
#[derive(Debug, Clone, Arbitrary)]
struct Damaged {
    saved: Saved,
    seal: Seal,
    edits: Vec<Edit>,
}

/// Damaged states of FMI 3.0: refused, or restored and run on.
pub fn states3(data: &[u8]) {
    let Some((&model, data)) = data.split_first() else { return };
    let Ok(damaged) = Damaged::arbitrary_take_rest(Unstructured::new(data)) else { return };
    if model % 4 == 3 { run_on::<Decision>(&damaged) } else { run_on::<CrowdModel>(&damaged) }
}

fn run_on<M: Fuzzed + ArrayModel>(damaged: &Damaged) {
    let mut session = Session::<M>::new();
    let drive = |value: i16| Call3::SetElement(3, 0, Real::Small(value));
    let parts = session.interface.intermediate.map_or(0, |at| {
        let place = session.interface.integers().iter().position(|reference| *reference == at);
        place.unwrap_or(0) as u8
    });
    let first: Vec<Call3> = match damaged.saved {
        Saved::Instantiated => vec![],
        Saved::Configuration => vec![Call3::Plain(Plain3::EnterConfigurationMode)],
        Saved::Initialization => vec![Call3::Prepare, drive(256)],
        Saved::Running => vec![Call3::Start, drive(2560), Call3::Step(1)],
        Saved::Parts => vec![
            Call3::SetInt32(vec![Reference::Fitting(parts)], vec![4], 0, Nulls::NONE),
            Call3::Start,
            drive(2560),
            Call3::Step(2),
        ],
        // One agent, three materials, and the last of the texts.
        Saved::Smaller => vec![
            Call3::Choose(1, 3, session.interface.texts.len() as u8 - 1 - OUTPUTS as u8),
            Call3::Start,
            Call3::Step(1),
        ],
        Saved::Terminated => vec![Call3::Start, Call3::Plain(Plain3::Terminate)],
    };
    first.iter().for_each(|call| session.make(call));
    session.saved = vec![bytes(session.importer())];
    session.make(&Call3::Deserialize(0, 0, damaged.edits.clone(), damaged.seal, Nulls::NONE));
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
    session.make(&Call3::SetState(0));
    for call in [
        Call3::Plain(Plain3::ExitConfigurationMode),
        Call3::Plain(Plain3::ExitInitializationMode),
        Call3::Step(1),
        drive(25),
        Call3::Step(20),
        Call3::Plain(Plain3::Terminate),
        Call3::Plain(Plain3::Reset),
        Call3::Start,
        Call3::Step(3),
    ] {
        session.make(&call);
    }
    let last = session.importer().plain(Plain3::Terminate);
    assert_eq!(last, Status::Ok, "after a reset it runs as ever");
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The calls do what they are named for: else the fuzzers would only look at refusals.
    #[test]
    fn a_session_runs_in_parts_saves_and_goes_back() {
        let mut session = Session::<CrowdModel>::new();
        let at = session.interface.intermediate.unwrap();
        let parts = session.interface.integers().iter().position(|it| *it == at).unwrap() as u8;
        let fp = session.interface.reals().iter().position(|it| {
            session.interface.variables.iter().any(|of| of.reference == *it && of.dimensions.len() == 2)
        });
        let fp = fp.unwrap() as u8;
        let mut ok = |call: Call3| {
            let before = bytes(session.importer());
            assert_eq!(session.perform(&call, &before), Status::Ok, "{call:?}");
            (bytes(session.importer()), session.importer().updates())
        };
        ok(Call3::SetInt32(vec![Reference::Fitting(parts)], vec![4], 0, Nulls::NONE));
        ok(Call3::Start);
        ok(Call3::SetElement(fp, 0, Real::Small(i16::MAX)));
        let (touching, updates) = ok(Call3::Step(1));
        // Ten mechanical steps, made twice: callbacks after four and eight.
        assert_eq!(updates, 4);
        assert_eq!(of_slave(&touching), (0.001, vec![2, 3]));
        ok(Call3::GetState(0, Nulls::NONE));
        ok(Call3::Serialize(0, 0, Nulls::NONE));
        assert_ne!(ok(Call3::Step(10)).0, touching);
        ok(Call3::Deserialize(1, 1, vec![], Seal::Good, Nulls::NONE));
        assert_eq!(ok(Call3::SetState(1)).0, touching);
        ok(Call3::Plain(Plain3::Reset));
        let last = session.interface.texts.len() as u8 - 1 - OUTPUTS as u8;
        let mut ok = |call: Call3| {
            let before = bytes(session.importer());
            assert_eq!(session.perform(&call, &before), Status::Ok, "{call:?}");
            of_slave(&bytes(session.importer()))
        };
        ok(Call3::Choose(1, 3, last));
        ok(Call3::Start);
        assert_eq!(ok(Call3::Step(1)), (0.001, vec![1, 3]));
    }
}
