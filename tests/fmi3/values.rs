//! Arrays are read and set as FMI 2.0's variables are: the same bits.

use crate::fmu::*;
use crowd_mechanics::model::CrowdModel;
use crowd_mechanics::variables::{AgentQuantity, Quantity};
use lemons_fmi::Model;
use lemons_fmi::location::Location;
use lemons_fmi::v2::{Slave, guid};

/// The crowd by its FMI 2.0 variables.
fn scalars() -> Slave<CrowdModel> {
    let path = Resources::shared().path().to_str().unwrap().to_owned();
    let crowd = CrowdModel::load(Location::Uri(&path)).unwrap();
    let guid = guid(&crowd.table()).to_string();
    Slave::new(crowd, &guid).unwrap()
}

fn get(crowd: &mut Slave<CrowdModel>, quantity: Quantity) -> f64 {
    let path = Resources::shared().path().to_str().unwrap().to_owned();
    let table = CrowdModel::load(Location::Uri(&path)).unwrap().table();
    let place = table.iter().position(|row| row.quantity == quantity).unwrap();
    let mut value = [f64::NAN];
    crowd.get_real(&[place as u32], &mut value).unwrap();
    value[0]
}

#[test]
fn arrays_have_the_bits_of_scalars() {
    let instance = Instance::new();
    let mut crowd = scalars();
    crowd.setup_experiment(0.0, None, None).unwrap();
    crowd.enter_initialization().unwrap();
    instance.enter_initialization();
    instance.push();
    let path = Resources::shared().path().to_str().unwrap().to_owned();
    let table = CrowdModel::load(Location::Uri(&path)).unwrap().table();
    let push = table.iter().position(|row| row.name == "agent[0].Fp.x").unwrap();
    crowd.set_real(&[push as u32], &[500.0]).unwrap();
    crowd.exit_initialization().unwrap();
    instance.must(unsafe { (instance.c.fmi3ExitInitializationMode)(instance.raw) });
    for k in 0..14 {
        crowd.do_step(f64::from(k) * STEP, STEP).unwrap();
        instance.steps(k, k + 1);
    }
    use AgentQuantity::*;
    let position = instance.get("Position", 2 * AGENTS);
    let (theta, squeeze) = (instance.get("Theta", AGENTS), instance.get("MeanNormalForce", AGENTS));
    assert!(squeeze.iter().any(|force| *force > 0.0), "{squeeze:?}");
    for i in 0..AGENTS {
        let of = |quantity| Quantity::Agent(i as u32, quantity);
        assert_eq!(position[2 * i], get(&mut crowd, of(PositionX)));
        assert_eq!(position[2 * i + 1], get(&mut crowd, of(PositionY)));
        assert_eq!(theta[i], get(&mut crowd, of(Theta)));
        assert_eq!(squeeze[i], get(&mut crowd, of(MeanNormalForce)));
    }
    assert_eq!(instance.get("LargestOverlap", 1)[0], get(&mut crowd, Quantity::LargestOverlap));
    assert_eq!(instance.get("time", 1), [14.0 * STEP]);
    let contacts: i32 = instance.get_integers("AgentContacts", AGENTS).iter().sum();
    assert_eq!(contacts, 2 * instance.get_integers("TotalAgentContacts", 1)[0]);
}

#[test]
fn ids_are_texts() {
    let instance = Instance::new();
    instance.initialize();
    assert_eq!(instance.texts("AgentId", AGENTS), ["0", "1", "2", "3", "4"]);
    assert_eq!(instance.texts("MaterialId", 3), ["concrete", "human_clothes", "human_naked"]);
    assert_eq!(instance.texts("Trial", 1), ["Trial_push"]);
}

/// After each refusal nothing has changed.
#[test]
fn what_does_not_fit_is_refused_in_words() {
    let instance = Instance::new();
    instance.enter_initialization();
    let before = instance.bytes();
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
        let message = instance.refused(instance.try_set(name, values));
        assert!(message.contains(words), "{name}: {message}");
        assert!(instance.bytes() == before, "{name} has changed something");
    }
    let message = instance.refused(instance.try_get("Position", 4).0);
    assert!(message.contains("4 values for variables of 10"), "{message}");
    let message = instance.refused(instance.try_set_integer("Threads", 0));
    assert!(message.contains("Threads = 0"), "{message}");
    let message = instance.refused(instance.try_set_text("Trial", "nowhere"));
    assert!(message.contains("Trial_push, Trial_three"), "{message}");
    let message = instance
        .refused(unsafe { (instance.c.fmi3GetFloat32)(instance.raw, &reference("Mass"), 1, &mut 0.0, 1) });
    assert!(message.contains("no variable of type Float32"), "{message}");
    let none = std::ptr::null_mut();
    let message = instance
        .refused(unsafe { (instance.c.fmi3GetFloat64)(instance.raw, &reference("Mass"), 1, none, 5) });
    assert!(message.contains("values is NULL"), "{message}");
}

#[test]
fn parameters_of_materials_are_symmetric_matrices() {
    let instance = Instance::new();
    instance.enter_initialization();
    let friction = instance.get("KineticFriction", 9);
    for (k, value) in friction.iter().enumerate() {
        assert_eq!(*value, friction[(k % 3) * 3 + k / 3]);
    }
    let less: Vec<f64> = friction.iter().map(|value| 0.5 * value).collect();
    instance.set("KineticFriction", &less);
    assert_eq!(instance.get("KineticFriction", 9), less);
    let hard: Vec<f64> = instance.get("YoungModulus", 3).iter().map(|modulus| 1.1 * modulus).collect();
    instance.set("YoungModulus", &hard);
    instance.must(unsafe { (instance.c.fmi3ExitInitializationMode)(instance.raw) });
    assert_eq!((instance.get("KineticFriction", 9), instance.get("YoungModulus", 3)), (less, hard));
}

/// Beside a central difference over two short steps.
#[test]
fn derivatives_of_outputs_are_those_of_the_motion() {
    const SHORT: f64 = 1e-6;
    let instance = Instance::new();
    instance.initialize();
    instance.push();
    instance.steps(0, 12);
    let from = 12.0 * STEP;
    instance.must(instance.try_step(from, SHORT).0);
    let names = ["Position", "Velocity", "Theta", "Omega"];
    let references = names.map(reference);
    let mut rates = [f64::NAN; 6 * AGENTS];
    instance.must(unsafe {
        let get = instance.c.fmi3GetOutputDerivatives;
        get(instance.raw, references.as_ptr(), 4, [1; 4].as_ptr(), rates.as_mut_ptr(), rates.len())
    });
    let values = || -> Vec<f64> {
        let of = |(name, n)| instance.get(name, n * AGENTS);
        names.into_iter().zip([2, 2, 1, 1]).flat_map(of).collect()
    };
    let before = values();
    instance.must(instance.try_step(from + SHORT, SHORT).0);
    for ((rate, before), after) in rates.iter().zip(before).zip(values()) {
        let difference = (after - before) / SHORT;
        assert!((rate - difference).abs() <= 0.02 * (1.0 + difference.abs()), "{rate} beside {difference}");
    }
    assert!(rates.iter().filter(|rate| rate.abs() > 0.1).count() >= 4, "{rates:?}");
    // Who is not there does not move: the first elements of the arrays are of agent 0.
    let there = [false, true, true, true, true];
    let set = instance.c.fmi3SetBoolean;
    instance.must(unsafe { set(instance.raw, &reference("Active"), 1, there.as_ptr(), AGENTS) });
    instance.must(unsafe {
        let get = instance.c.fmi3GetOutputDerivatives;
        get(instance.raw, references.as_ptr(), 4, [1; 4].as_ptr(), rates.as_mut_ptr(), rates.len())
    });
    for first in [0, 1, 2 * AGENTS, 2 * AGENTS + 1, 4 * AGENTS, 5 * AGENTS] {
        assert_eq!(rates[first], 0.0, "{first}");
    }
    for (name, order, words) in [
        ("Mass", 1, "not known"),
        ("Omega", 0, "order 0"),
        ("Omega", 2, "order 2"),
        ("PeakOverlap", 1, "not known"),
    ] {
        let message = instance.refused(unsafe {
            let get = instance.c.fmi3GetOutputDerivatives;
            get(instance.raw, &reference(name), 1, &order, rates.as_mut_ptr(), AGENTS)
        });
        assert!(message.contains(words) && message.contains(name), "{message}");
    }
}

#[test]
fn outputs_depend_on_nothing_at_a_communication_point() {
    let instance = Instance::new();
    instance.initialize();
    let mut count = 7;
    let number = instance.c.fmi3GetNumberOfVariableDependencies;
    instance.must(unsafe { number(instance.raw, reference("Position"), &mut count) });
    assert_eq!(count, 0);
    let message = instance.refused(unsafe { number(instance.raw, 99, &mut count) });
    assert!(message.contains("99"), "{message}");
}

/// As `fmi2SetupExperiment` does: tests/fmi2/tolerance.rs has more.
#[test]
fn a_tolerance_chooses_the_mechanical_step() {
    let enter = |instance: &Instance, tolerance: f64| unsafe {
        (instance.c.fmi3EnterInitializationMode)(instance.raw, true, tolerance, 0.0, false, 0.0)
    };
    let instance = Instance::new();
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let message = instance.refused(enter(&instance, tolerance));
        assert!(message.contains("tolerance") && message.contains("positive and finite"), "{message}");
    }
    instance.must(enter(&instance, 1e-4));
    // As in FMI 2.0.
    assert_eq!(instance.get("TimeStepMechanical", 1), [4.8e-5]);
    instance.must(unsafe { (instance.c.fmi3ExitInitializationMode)(instance.raw) });
    instance.push();
    instance.steps(0, 2);
    assert_eq!(instance.get("TimeStepMechanical", 1), [4.8e-5]);
    let other = Instance::new();
    other.set("TimeStepMechanical", &[4.8e-5]);
    other.must(enter(&other, 1e-6));
    other.must(unsafe { (other.c.fmi3ExitInitializationMode)(other.raw) });
    other.push();
    other.steps(0, 2);
    assert_eq!(other.get("TimeStepMechanical", 1), [4.8e-5], "what is set wins");
    assert_eq!(instance.motion(), other.motion());
}

#[test]
fn a_tolerance_holds_for_the_trial_that_is_chosen_in_its_states_and_until_reset() {
    let step = |instance: &Instance| instance.get("TimeStepMechanical", 1)[0];
    let exit = |instance: &Instance| {
        instance.must(unsafe { (instance.c.fmi3ExitInitializationMode)(instance.raw) });
    };
    let instance = Instance::new();
    instance.must(unsafe { (instance.c.fmi3EnterConfigurationMode)(instance.raw) });
    instance.must(instance.try_set_size("Agents", 3));
    instance.must(unsafe { (instance.c.fmi3ExitConfigurationMode)(instance.raw) });
    instance.must(instance.try_set_text("Trial", "Trial_three"));
    let enter = instance.c.fmi3EnterInitializationMode;
    instance.must(unsafe { enter(instance.raw, true, 1e-4, 0.0, false, 0.0) });
    let early = instance.bytes();
    // The period of the shortest contact, 2π √(m*/k), grows tenfold with a hundred times the mass and inertia.
    let light = step(&instance);
    for (name, masses) in
        [("Mass", instance.get("Mass", 3)), ("MomentOfInertia", instance.get("MomentOfInertia", 3))]
    {
        instance.set(name, &masses.iter().map(|mass| 100.0 * mass).collect::<Vec<_>>());
    }
    exit(&instance);
    let heavy = step(&instance);
    assert!((9.9..=10.4).contains(&(heavy / light)), "{light} {heavy}");
    instance.steps(0, 3);
    let other = Instance::new();
    other.must(other.restore(&instance.bytes()));
    assert_eq!((other.size("Agents"), step(&other)), (3, heavy));
    // Saved during initialization.
    other.must(other.restore(&early));
    exit(&other);
    assert_eq!(step(&other), light);
    // Without a tolerance it is the Trial's own step.
    other.must(unsafe { (other.c.fmi3Reset)(other.raw) });
    other.initialize();
    assert_eq!((other.size("Agents"), step(&other)), (5, 2e-6));
}
