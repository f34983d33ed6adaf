//! What only FMI 3.0 has: arrays, their sizes, and values within a step.

use crate::fmu::*;
use crowd_mechanics::model_description::model_description;
use crowd_mechanics::{pack::FmuFormat, setup};
use std::cell::RefCell;
use std::rc::Rc;

/// Arrays are read and set as FMI 2.0's variables are: the same bits, also where a drive is played and contacts are.
#[test]
fn arrays_have_the_bits_of_scalars() {
    let (scalars, arrays) = (Crowd::pushed(V2), Crowd::pushed(V3));
    let mut squeezed = 0;
    for k in 0..30 {
        scalars.steps(k, k + 1);
        arrays.steps(k, k + 1);
        squeezed += arrays.values("MeanNormalForce").iter().filter(|force| **force > 0.0).count();
        for name in &scalars.model.reals {
            assert_eq!(arrays.get(name).to_bits(), scalars.get(name).to_bits(), "{name}, step {k}");
        }
    }
    assert!(squeezed >= 4, "{squeezed}");
    assert_eq!(arrays.get("time"), 29.0 * STEP + STEP);
    let of_agents = |name| (0..AGENTS).map(move |i| format!("agent[{i}].{name}"));
    for name in of_agents("AgentContacts").chain(of_agents("ContactingAgents")) {
        assert_eq!(arrays.integer(&name), scalars.integer(&name));
    }
    for name in ["AgentContacts", "WallContacts", "CoincidentContacts"] {
        assert_eq!(arrays.integer(name), scalars.integer(name), "{name}");
    }
    let texts = |name: &str, length| {
        let (status, texts) = arrays.get_string(&[arrays.model.reference(name)], length);
        arrays.must(status);
        texts.into_iter().map(|text| text.into_string().unwrap()).collect::<Vec<_>>()
    };
    assert_eq!(texts("AgentId", AGENTS), ["0", "1", "2", "3", "4"]);
    assert_eq!(texts("MaterialId", 3), ["concrete", "human_clothes", "human_naked"]);
}

/// After each refusal nothing has changed.
#[test]
fn what_does_not_fit_is_refused_in_words() {
    let crowd = Crowd::new(V3);
    crowd.enter_initialization();
    let before = crowd.bytes();
    for (name, values, words) in [
        ("Fp", &[0.0; 9][..], "9 values for variables of 10"),
        ("Mass", &[80.0; 6], "6 values for variables of 5"),
        ("Mass", &[80.0, 80.0, -1.0, 80.0, 80.0], "Mass[2] = -1.0: must be positive"),
        ("Mp", &[0.0, f64::NAN, 0.0, 0.0, 0.0], "Mp[1] = NaN: must be finite"),
        ("TimeStepMechanical", &[0.0], "TimeStepMechanical = 0.0: must be positive"),
        ("LargestOverlap", &[0.0], "LargestOverlap cannot be set at all"),
        ("time", &[1.0], "time cannot be set at all"),
        ("KineticFriction", &[0.5, 0.4, 0.5, 0.5, 0.4, 0.4, 0.5, 0.4, 0.4], "must be symmetric"),
        ("Trial", &[0.0], "no variable of type Float64"),
    ] {
        let message = crowd.refused(crowd.set_values(name, values));
        assert!(message.contains(words), "{name}: {message}");
        assert!(crowd.bytes() == before, "{name} has changed something");
    }
    let message = crowd.refused(crowd.get_real(&[crowd.model.reference("Position")], 4).0);
    assert!(message.contains("4 values for variables of 10"), "{message}");
    // Matrices of materials are symmetric.
    let friction = crowd.values("KineticFriction");
    assert!((0..9).all(|k| friction[k] == friction[(k % 3) * 3 + k / 3]));
    let less: Vec<f64> = friction.iter().map(|value| 0.5 * value).collect();
    crowd.must(crowd.set_values("KineticFriction", &less));
    crowd.must(crowd.exit());
    assert_eq!(crowd.values("KineticFriction"), less);
}

#[test]
fn outputs_depend_on_nothing_at_a_communication_point() {
    let crowd = Crowd::pushed(V3);
    let (number, mut count) = (crowd.v3().fmi3GetNumberOfVariableDependencies, 7);
    // SAFETY: an instance and the place of a number.
    let mut ask = |reference| unsafe { number(crowd.raw, reference, &mut count) };
    let message = crowd.refused(ask(99));
    assert!(message.contains("99"), "{message}");
    crowd.must(ask(crowd.model.reference("Position")));
    assert_eq!(count, 0);
}

/// Resources with a Trial of three agents, and an instance with a number of agents that is configured.
fn configured(agents: u64) -> (Resources, Crowd) {
    let resources = Resources::with_fewer("Trial_three", 3);
    let crowd = Crowd::on(V3, &resources);
    crowd.must(crowd.enter_configuration());
    crowd.must(crowd.set_size(&[crowd.model.reference("Agents")], &[agents]));
    crowd.must(crowd.exit_configuration());
    (resources, crowd)
}

fn agents(crowd: &Crowd) -> u64 {
    let (status, sizes) = crowd.get_size(&["Agents", "Materials"].map(|name| crowd.model.reference(name)), 2);
    crowd.must(status);
    assert_eq!(sizes[1], 3);
    sizes[0]
}

#[test]
fn a_trial_of_another_size_is_chosen_and_its_state_brings_it() {
    let (resources, crowd) = configured(3);
    crowd.must(crowd.set_text("Trial", "Trial_three"));
    // A tolerance is about what is loaded.
    crowd.must(crowd.set("TimeStepMechanical", 1e-3));
    crowd.must(crowd.enter(Some(1e-4), 0.0, None));
    assert_eq!(agents(&crowd), 3);
    crowd.must(crowd.set_values("Fp", &[500.0, 0.0, 0.0, 0.0, 0.0, 0.0]));
    crowd.must(crowd.exit());
    let step = crowd.get("TimeStepMechanical");
    assert!((2e-5..1e-4).contains(&step), "{step}");
    crowd.steps(0, 20);
    let position = crowd.model.reference("Position");
    let message = crowd.refused(crowd.get_real(&[position], 10).0);
    assert!(message.contains("10 values for variables of 6"), "{message}");
    let other = Crowd::on(V3, &resources);
    other.must(other.restore(&crowd.bytes()));
    assert_eq!((agents(&other), other.text("Trial")), (3, "Trial_three".to_owned()));
    crowd.steps(20, 30);
    other.steps(20, 30);
    let (found, expected) = (other.get_real(&[position], 6), crowd.get_real(&[position], 6));
    assert!(found == expected && found.1[0] > 0.05, "{found:?}");
    // Back to the first; without a tolerance it is the Trial's own step.
    other.reset();
    other.initialize();
    assert_eq!((agents(&other), other.get("TimeStepMechanical")), (5, 2e-6));
}

#[test]
fn sizes_that_do_not_agree_are_an_error_that_says_both() {
    let words = "Agents is 3, but what is loaded has 5";
    let (resources, crowd) = configured(3);
    let message = crowd.refused(crowd.set_values("Mass", &[80.0; 3]));
    assert!(message.contains(words), "{message}");
    crowd.enter_initialization();
    let message = crowd.refused(crowd.exit());
    assert!(message.contains(words), "{message}");
    // Either is mended.
    crowd.must(crowd.set_text("Trial", "Trial_three"));
    crowd.must(crowd.exit());
    let crowd = Crowd::on(V3, &resources);
    crowd.must(crowd.set_text("Trial", "Trial_three"));
    crowd.enter_initialization();
    let message = crowd.refused(crowd.exit());
    assert!(message.contains("Agents is 5, but what is loaded has 3"), "{message}");
    // Values of agents that a Trial does not have are not lost in silence.
    let crowd = Crowd::on(V3, &resources);
    crowd.must(crowd.set_values("Mass", &[80.0; 5]));
    let message = crowd.refused(crowd.set_text("Trial", "Trial_three"));
    assert!(message.contains("choose the Trial before its values"), "{message}");
}

#[test]
fn sizes_are_set_in_configuration_mode_only() {
    let crowd = Crowd::new(V3);
    let set = |value| crowd.set_size(&[crowd.model.reference("Agents")], &[value]);
    let message = crowd.refused(set(3));
    assert!(message.contains("outside Configuration Mode"), "{message}");
    crowd.must(crowd.enter_configuration());
    for wrong in [0, 1 << 60] {
        let message = crowd.refused(set(wrong));
        assert!(message.contains(&format!("Agents = {wrong}")), "{message}");
    }
    let message = crowd.refused(crowd.set_values("Mass", &[80.0; 5]));
    assert!(message.contains("in Configuration Mode"), "{message}");
    crowd.must(crowd.exit_configuration());
    crowd.initialize();
}

/// Times \[s\] and positions \[m\] that the callback of an instance saw.
type Seen = Rc<RefCell<Vec<(f64, f64)>>>;

/// An instance that is seen after every 5000 mechanical steps of 2 µs, every 10 ms, and may return early.
fn watched(stop: Option<f64>) -> (Rc<Crowd>, Seen) {
    let token = std::ffi::CString::new(&*Model::paper(V3).token).unwrap();
    let location = std::ffi::CString::new(V3.location(&packed().join("resources"))).unwrap();
    let arguments =
        Arguments { updates: true, early_return: stop.is_some(), ..Arguments::new(&token, &location) };
    let crowd = Rc::new(Crowd::with(Fmu::get(), V3, &arguments).unwrap_or_else(|log| panic!("{log:?}")));
    let (weak, seen) = (Rc::downgrade(&crowd), Seen::default());
    let kept = seen.clone();
    crowd.on_update(Box::new(move |time, can_return| {
        let crowd = weak.upgrade().expect("it steps");
        kept.borrow_mut().push((time, crowd.get("agent[0].Position.x")));
        // Nothing can be set or saved now.
        let refused = [crowd.set("agent[0].Fp.x", 0.0), crowd.get_state(&mut std::ptr::null_mut())];
        crowd.take_messages();
        assert_eq!((refused, can_return), ([ERROR; 2], stop.is_some()));
        stop
    }));
    crowd.must(crowd.try_integer("IntermediateSteps", 5000));
    push(&crowd);
    (crowd, seen)
}

fn push(crowd: &Crowd) {
    crowd.must(crowd.set("agent[0].Fp.x", 500.0));
    crowd.initialize();
}

/// Who looks sees what short steps give, and changes nothing.
#[test]
fn values_within_a_step_are_those_of_short_steps_and_change_nothing() {
    let (crowd, seen) = watched(None);
    let (short, plain) = (Crowd::new(V3), Crowd::new(V3));
    push(&short);
    plain.must(plain.try_integer("IntermediateSteps", 5000));
    push(&plain);
    let mut squeezed = 0;
    for k in 0..12 {
        let from = f64::from(k) * 0.05;
        crowd.must(crowd.try_step(from, 0.05));
        plain.must(plain.try_step(from, 0.05));
        squeezed += plain.values("MeanNormalForce").iter().filter(|value| **value > 0.0).count();
        assert!(crowd.everything() == plain.everything() && crowd.bytes() == plain.bytes(), "step {k}");
    }
    assert!(squeezed >= 6, "{squeezed}");
    let seen = seen.take();
    assert_eq!(seen.len(), 12 * 4);
    for (k, (time, x)) in seen[..4].iter().enumerate() {
        short.must(short.try_step(k as f64 * 0.01, 0.01));
        assert!((time - (k + 1) as f64 * 0.01).abs() < 1e-12, "{time}");
        assert_eq!(*x, short.get("agent[0].Position.x"));
    }
}

/// A strict importer reads only what is continuous and marked.
#[test]
fn what_is_marked_can_be_read_within_a_step() {
    let xml = model_description(&setup::read(&paper()).unwrap().0, FmuFormat::Fmi3);
    let variables = xml.split('<').filter(|tag| tag.contains(" valueReference=\"") && tag.contains(" name="));
    let (mut marked, mut outputs) = (Vec::new(), Vec::new());
    for tag in variables {
        let value =
            |name: &str| tag.split(&format!(" {name}=\"")).nth(1).map(|rest| rest.split('"').next().unwrap());
        let reference: u32 = value("valueReference").unwrap().parse().unwrap();
        if value("intermediateUpdate") == Some("true") {
            marked.push(reference);
        }
        if value("causality") == Some("output") && value("variability") == Some("continuous") {
            outputs.push((reference, value("name").unwrap().to_owned()));
        }
    }
    assert!(
        marked.len() > 10 && marked.iter().eq(outputs.iter().map(|(reference, _)| reference)),
        "{marked:?}"
    );
    assert!(xml.contains("providesIntermediateUpdate=\"true\""));
    assert!(xml.contains("canReturnEarlyAfterIntermediateUpdate=\"true\""));
    let (crowd, _) = watched(None);
    let (weak, count) = (Rc::downgrade(&crowd), Rc::new(RefCell::new(0)));
    let read = count.clone();
    crowd.on_update(Box::new(move |_, _| {
        let crowd = weak.upgrade().expect("it steps");
        for (_, name) in &outputs {
            crowd.values(name);
            *read.borrow_mut() += 1;
        }
        None
    }));
    crowd.must(crowd.try_step(0.0, 0.05));
    assert_eq!(*count.borrow(), 4 * marked.len());
}

/// Values are seen every 10 ms: within a part, within the last one, at a point, when it is too late, and never.
#[test]
fn a_step_returns_early_where_the_importer_asks() {
    for (asked, reached, count) in [
        (0.015, 0.015, 1),
        (0.047, 0.047, 4),
        (0.03, 0.03, 2),
        (0.002, 0.01, 1),
        (f64::NAN, 0.01, 1),
        (0.05, 0.05, 4),
        (f64::INFINITY, 0.05, 4),
    ] {
        let (crowd, seen) = watched(Some(asked));
        let first = crowd.do_step(0.0, 0.05);
        crowd.must(first.status);
        assert_eq!((first.early, first.time), (reached < 0.05, reached), "{asked}");
        assert_eq!((seen.borrow().len(), crowd.get("time")), (count, reached), "{asked}");
        // The same as a step of this length.
        let plain = Crowd::new(V3);
        plain.must(plain.try_integer("IntermediateSteps", 5000));
        push(&plain);
        plain.must(plain.try_step(0.0, reached));
        assert!(crowd.bytes() == plain.bytes(), "{asked}");
        // It goes on from there.
        if first.early {
            crowd.on_update(Box::new(|_, _| Some(f64::INFINITY)));
            let second = crowd.do_step(reached, 0.05 - reached);
            crowd.must(second.status);
            assert!(!second.early && (second.time - 0.05).abs() < 1e-12, "{second:?}");
        }
    }
}
