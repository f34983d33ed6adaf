//! A model that panics: the host is told in words, and the instance refuses all calls but fmi2FreeInstance.
//! FMI's state "fatal", the column of section 4.2.4 that no call of a sound model reaches.

use lemons_fmi::location::Location;
use lemons_fmi::testing::fmi2;
use lemons_fmi::testing::instance::{Arguments, VersionFunctions};
use lemons_fmi::testing::{LoggedMessage, TestInstance};
use lemons_fmi::variables::{Dependencies, Known, Scalar, Size, Variable, VariableType, row, types};
use lemons_fmi::{Answer, Model, Phase, Status, Step, StepError, guid};
use std::ffi::{CStr, CString};

static X: [Variable<()>; 1] = [row((), "x", &[], VariableType::Real(types::FORCE)).input("")];

/// Its one variable is an input; at 13 it breaks.
struct Brittle {
    x: f64,
}

impl Model for Brittle {
    type Quantity = ();
    type Saved = f64;

    const NAME: &'static str = "brittle";
    const IDENTIFIER: &'static str = "Brittle";
    const DESCRIPTION: &'static str = "";
    const STOP_TIME: f64 = 1.0;
    const STATE_VERSION: u32 = 1;
    const SIZES: &'static [Size] = &[];
    const VARIABLES: &'static [Variable<()>] = &X;

    fn load(location: Location<'_>) -> Answer<Brittle> {
        assert!(location.text() != "broken", "no such place");
        Ok(Brittle { x: 0.0 })
    }

    fn size(&self, _: usize) -> u64 {
        unreachable!()
    }

    fn scalars(&self) -> Vec<Scalar<()>> {
        X[0].scalars(0, "", "").collect()
    }

    fn step_size(&self) -> f64 {
        1.0
    }

    fn number(&mut self, (): (), _: usize) -> Answer<f64> {
        Ok(self.x)
    }

    fn text(&self, (): (), _: usize) -> &str {
        unreachable!()
    }

    fn set(&mut self, (): (), _: usize, value: f64, _: Phase) {
        self.x = value;
    }

    fn dependencies(&self, (): (), _: Known) -> Dependencies<()> {
        Dependencies::All(Vec::new())
    }

    fn initialize(&mut self, _: f64) -> Answer<()> {
        Ok(())
    }

    fn advance(&mut self, _: Step) -> Result<(), StepError> {
        assert!(self.x != 13.0, "x is {}", self.x);
        Ok(())
    }

    fn reset(&mut self) -> Answer<()> {
        Ok(())
    }

    fn save(&self) -> f64 {
        self.x
    }

    fn restore(&mut self, saved: &f64) -> Answer<()> {
        self.x = *saved;
        Ok(())
    }
}

fn instantiate_at(location: &CStr) -> Result<TestInstance, Vec<LoggedMessage>> {
    let guid = CString::new(guid(&Brittle { x: 0.0 }.scalars()).braced().to_string()).unwrap();
    let functions = VersionFunctions::V2(Box::new(fmi2::Functions::of_model::<Brittle>()));
    TestInstance::new(&functions, &Arguments::new(&guid, location))
}

#[track_caller]
fn fatal(messages: &[LoggedMessage], words: [&str; 2]) {
    let [LoggedMessage { status: Status::Fatal, text, .. }] = messages else { panic!("{messages:?}") };
    assert!(words.iter().all(|word| text.contains(word)), "{text}");
}

#[test]
fn a_panic_is_fatal_and_told_and_the_instance_can_be_freed() {
    let (instance, sound) = (instantiate_at(c"sound").unwrap(), instantiate_at(c"sound").unwrap());
    for instance in [&instance, &sound] {
        instance.initialize();
        instance.must(instance.do_step(0.0, 1.0).status);
    }
    instance.must(instance.set_real(&[0], &[13.0]));
    assert_eq!(instance.do_step(1.0, 1.0).status, Status::Fatal);
    fatal(&instance.take_messages(), ["fmi2DoStep", "x is 13"]);
    let probes = fmi2::Functions::probes();
    assert_eq!(probes.len(), 30, "all but those that make and free instances, and two that tell the version");
    for probe in probes {
        assert_eq!(probe.call(instance.v2(), instance.raw, None), Some(Status::Fatal), "{}", probe.name);
        fatal(&instance.take_messages(), [probe.name, ""]);
    }
    drop(instance);
    sound.must(sound.do_step(1.0, 1.0).status);
    assert!(sound.take_messages().is_empty(), "another instance is not touched");
}

#[test]
fn a_panic_while_instantiating_gives_no_instance_and_words() {
    let Err(messages) = instantiate_at(c"broken") else { panic!("an instance") };
    fatal(&messages, ["fmi2Instantiate", "no such place"]);
}
