//! The tolerance of `fmi2SetupExperiment` chooses the mechanical step.

use crate::fmu::*;
use std::ffi::c_int;

const PARAMETER: &str = "TimeStepMechanical";
/// \[s\] of the paper's Trial.
const OWN: f64 = 2e-6;

fn set_up(instance: &Instance, tolerance: f64) -> c_int {
    unsafe { (instance.fmu.c.fmi2SetupExperiment)(instance.raw, 1, tolerance, 0.0, 0, 0.0) }
}

fn enter(instance: &Instance) {
    instance.must(unsafe { (instance.fmu.c.fmi2EnterInitializationMode)(instance.raw) });
}

/// Leaves Initialization Mode, and returns what is said then.
fn exit(instance: &Instance) -> Vec<String> {
    let status = unsafe { (instance.fmu.c.fmi2ExitInitializationMode)(instance.raw) };
    let said: Vec<String> = instance.log.take().iter().map(|message| message.text.clone()).collect();
    assert_eq!(status, OK, "{said:?}");
    said
}

fn initialized(tolerance: f64) -> (Instance<'static>, Vec<String>) {
    let instance = Instance::new(Fmu::get());
    instance.must(set_up(&instance, tolerance));
    enter(&instance);
    let said = exit(&instance);
    (instance, said)
}

#[test]
fn a_tolerance_chooses_the_step_that_is_read_back() {
    let instance = Instance::new(Fmu::get());
    instance.must(set_up(&instance, 1e-4));
    enter(&instance);
    // The shortest period is 2π √(m*/k) = 10.9 ms: agent 1 on concrete. √(1e-4 m / 5 m) of it is 48.9 µs.
    assert_eq!(instance.get(PARAMETER), 4.8e-5);
    // A hundred times the mass and the moment of inertia, ten times the period.
    for i in 0..5 {
        for name in ["Mass", "MomentOfInertia"] {
            let name = format!("agent[{i}].{name}");
            instance.must(instance.set(&name, 100.0 * instance.get(&name)));
        }
    }
    let heavy = instance.get(PARAMETER);
    assert!((4.8e-4..=5e-4).contains(&heavy), "{heavy}");
    exit(&instance);
    assert_eq!(instance.get(PARAMETER), heavy);
}

#[test]
fn a_step_that_is_set_wins_over_the_tolerance_and_the_tolerance_over_the_file() {
    let instance = Instance::new(Fmu::get());
    instance.must(instance.set(PARAMETER, 1e-5));
    instance.must(set_up(&instance, 1e-4));
    enter(&instance);
    assert_eq!(instance.get(PARAMETER), 1e-5);
    instance.must(instance.set(PARAMETER, 3e-5));
    exit(&instance);
    assert_eq!(instance.get(PARAMETER), 3e-5);
    // After a reset nothing of it is left.
    instance.must(unsafe { (instance.fmu.c.fmi2Reset)(instance.raw) });
    instance.initialize();
    assert_eq!(instance.get(PARAMETER), OWN);
    instance.must(unsafe { (instance.fmu.c.fmi2Reset)(instance.raw) });
    // The last experiment counts.
    instance.must(set_up(&instance, 1e-4));
    instance.initialize();
    assert_eq!(instance.get(PARAMETER), OWN);
}

#[test]
fn motions_are_as_accurate_as_the_tolerance() {
    let run = |instance: &Instance| {
        instance.must(instance.set("agent[0].Fp.x", 700.0));
        instance.steps(0, 50);
        (0..5).map(|i| instance.get(&format!("agent[{i}].Position.x"))).collect::<Vec<f64>>()
    };
    let exact = Instance::new(Fmu::get());
    exact.must(exact.set(PARAMETER, 1e-6));
    exact.initialize();
    let exact = run(&exact);
    assert!(exact[2] - 0.56 > 0.01, "the third one is pushed: {exact:?}");
    for tolerance in [1e-3, 1e-4, 1e-5] {
        let (instance, said) = initialized(tolerance);
        assert_eq!(said, [""; 0]);
        let apart = run(&instance).iter().zip(&exact).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        assert!(apart < tolerance && apart > 0.0, "{apart} {tolerance}");
    }
}

#[test]
fn what_is_no_tolerance_is_refused() {
    let instance = Instance::new(Fmu::get());
    let before = instance.bytes();
    for tolerance in [0.0, -1e-4, f64::NAN, f64::INFINITY] {
        let message = instance.refused(set_up(&instance, tolerance));
        assert!(message.contains("tolerance") && message.contains("positive and finite"), "{message}");
    }
    assert!(instance.bytes() == before);
    instance.must(set_up(&instance, 1e-4));
}

#[test]
fn a_tolerance_never_chooses_what_check_warns_of_or_what_takes_for_ever() {
    // A twentieth of the period, 10.9 ms.
    let (instance, said) = initialized(1e3);
    let longest = instance.get(PARAMETER);
    assert!((5.0e-4..=5.6e-4).contains(&longest) && said.is_empty(), "{longest} {said:?}");
    // Finer than anything that was compared.
    let (instance, said) = initialized(1e-30);
    let shortest = instance.get(PARAMETER);
    assert!((1e-7..=2e-7).contains(&shortest), "{shortest}");
    assert!(said.len() == 1 && said[0].contains("is taken as 1e-9"), "{said:?}");
    // A TimeStep of 0.05 s has at most 500 steps.
    let instance = Instance::new(Fmu::get());
    instance.must(set_up(&instance, 1e-4));
    enter(&instance);
    instance.must(instance.set("MostMechanicalSteps", 500.0));
    let said = exit(&instance);
    assert_eq!(instance.get(PARAMETER), 1e-4);
    assert!(said.len() == 1 && said[0].contains("MostMechanicalSteps = 500"), "{said:?}");
    assert!(said[0].contains("accurate to about 4.2e-4 m"), "{said:?}");
    instance.must(instance.try_step(0.0, 0.05));
}

#[test]
fn a_state_carries_the_tolerance() {
    let (instance, _) = initialized(1e-4);
    instance.must(instance.set("agent[0].Fp.x", 700.0));
    let meeting = (1..30).find(|k| {
        instance.steps(k - 1, *k);
        instance.get_integer("AgentContacts") > 0
    });
    let meeting = meeting.expect("a contact");
    let bytes = instance.bytes();
    instance.steps(meeting, meeting + 8);
    let (expected, end) = (instance.everything(), instance.bytes());
    let other = Instance::new(Fmu::get());
    other.must(other.restore_bytes(&bytes));
    assert_eq!(other.get(PARAMETER), 4.8e-5);
    other.steps(meeting, meeting + 8);
    assert!(other.everything() == expected && other.bytes() == end);
    // Saved during initialization: parameters that are set later still count.
    let early = Instance::new(Fmu::get());
    early.must(set_up(&early, 1e-4));
    enter(&early);
    let bytes = early.bytes();
    other.must(other.restore_bytes(&bytes));
    for i in 0..5 {
        for name in ["Mass", "MomentOfInertia"] {
            let name = format!("agent[{i}].{name}");
            other.must(other.set(&name, 100.0 * other.get(&name)));
        }
    }
    exit(&other);
    assert!(other.get(PARAMETER) > 4.8e-4);
}
