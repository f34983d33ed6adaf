//! Derivatives: of outputs, and of inputs that vary linearly within a step (FMI 2.0).

use crate::fmu::*;

/// Order 1, of variables by their names.
fn rates(crowd: &Crowd, values: &[(&str, i32, f64)]) -> Status {
    let references: Vec<u32> = values.iter().map(|(name, ..)| crowd.model.reference(name)).collect();
    let orders: Vec<i32> = values.iter().map(|(_, order, _)| *order).collect();
    let values: Vec<f64> = values.iter().map(|(.., value)| *value).collect();
    crowd.set_input_derivatives(&references, &orders, &values)
}

/// \[m/s\] of a mass under the force `f + j t` and relaxation at a rate, from rest.
fn speed(mass: f64, rate: f64, f: f64, j: f64, t: f64) -> f64 {
    // dv/dt + λ v = (f + j t)/m: a particular solution is linear in t, the rest dies out.
    let linear = |t: f64| (f - j / rate + j * t) / (rate * mass);
    linear(t) - linear(0.0) * (-rate * t).exp()
}

/// Agent 4 is the last of the row and walks away from it: nothing touches it.
#[test]
fn a_force_rises_within_the_step_as_the_closed_form_has_it() {
    let crowd = Crowd::new(V2);
    crowd.initialize();
    let (mass, rate) = (crowd.get("agent[4].Mass"), crowd.get("agent[4].FloorDamping"));
    let (f, j, h) = (30.0, 400.0, 0.2);
    crowd.must(crowd.set("agent[4].Fp.x", f));
    crowd.must(rates(&crowd, &[("agent[4].Fp.x", 1, j)]));
    crowd.must(crowd.try_step(0.0, h));
    let (found, expected) = (crowd.get("agent[4].Velocity.x"), speed(mass, rate, f, j, h));
    assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    assert!(expected > 1.5 * speed(mass, rate, f, 0.0, h), "the rate matters");
    assert_eq!(crowd.get("agent[4].Fp.x"), f, "an input keeps the value that was set");
}

#[test]
fn a_rate_counts_for_one_step_and_zero_is_held() {
    let [with, zero, without] = [(); 3].map(|()| Crowd::pushed(V2));
    without.steps(0, 12);
    with.must(rates(&with, &[("agent[0].Fp.x", 1, 500.0), ("agent[3].Mp", 1, -3.0)]));
    with.steps(0, 1);
    for k in 0..12 {
        zero.must(rates(&zero, &[("agent[0].Fp.x", 1, 0.0), ("agent[3].Mp", 1, -0.0)]));
        zero.steps(k, k + 1);
    }
    assert_eq!(zero.everything(), without.everything());
    // From here on nothing remembers the rate but the motion.
    let state = with.bytes();
    with.steps(1, 12);
    let other = Crowd::new(V2);
    other.must(other.restore(&state));
    for k in 1..12 {
        other.must(rates(&other, &[("agent[0].Fp.x", 1, 0.0), ("agent[3].Mp", 1, 0.0)]));
        other.steps(k, k + 1);
    }
    assert_eq!(with.everything(), other.everything());
    assert_ne!(with.everything(), without.everything());
}

#[test]
fn a_state_holds_rates_that_wait_for_their_step() {
    let crowd = Crowd::pushed(V2);
    crowd.steps(0, 3);
    crowd.must(rates(&crowd, &[("agent[0].Fp.x", 1, 9000.0)]));
    let (waiting, other) = (crowd.bytes(), Crowd::new(V2));
    crowd.steps(3, 5);
    // A refused step does not use them up.
    for refused in [false, true] {
        other.must(other.restore(&waiting));
        if refused {
            other.refused(other.try_step(3.0 * STEP, -STEP));
        }
        other.steps(3, 5);
        assert_eq!(other.everything(), crowd.everything());
    }
    // Nor does a reset keep them.
    other.must(other.restore(&waiting));
    other.reset();
    assert!(other.bytes() == Crowd::new(V2).bytes());
}

#[test]
fn what_is_no_first_derivative_of_an_input_is_refused_and_named() {
    let crowd = Crowd::pushed(V2);
    crowd.steps(0, 1);
    let before = crowd.bytes();
    for (bad, words) in [
        (("agent[0].Fp.x", 2, 1.0), ["agent[0].Fp.x", "order 2"]),
        (("agent[0].Fp.x", 0, 1.0), ["agent[0].Fp.x", "order 0"]),
        (("agent[0].Fp.y", 1, f64::NAN), ["agent[0].Fp.y", "finite"]),
        (("agent[0].Mp", 1, f64::INFINITY), ["agent[0].Mp", "finite"]),
        (("agent[0].Velocity.x", 1, 1.0), ["agent[0].Velocity.x", "not an input"]),
        (("agent[0].Mass", 1, 1.0), ["agent[0].Mass", "not an input"]),
        (("Threads", 1, 1.0), ["no variable of type Real", "reference"]),
    ] {
        let message = crowd.refused(rates(&crowd, &[("agent[1].Fp.x", 1, 5.0), bad]));
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
        assert!(crowd.bytes() == before, "{message}: something was set");
    }
}

/// Beside the outputs of two short steps: a central difference.
#[test]
fn derivatives_of_outputs_are_those_of_the_motion() {
    const SHORT: f64 = 1e-6;
    let outputs = ["Position.x", "Position.y", "Theta", "Velocity.x", "Velocity.y", "Omega"];
    let names = outputs.map(|name| (0..AGENTS).map(|i| format!("agent[{i}].{name}")).collect::<Vec<_>>());
    for version in BOTH {
        let crowd = Crowd::pushed(version);
        crowd.steps(0, 12);
        let time = 12.0 * STEP;
        crowd.must(crowd.try_step(time, SHORT));
        let derivatives = || {
            let of = |name: &String| {
                let (status, value) = crowd.try_derivative(name, 1);
                crowd.must(status);
                value
            };
            names.iter().flatten().map(of).collect::<Vec<f64>>()
        };
        let values = || names.iter().flatten().map(|name| crowd.get(name)).collect::<Vec<f64>>();
        let (rates, before) = (derivatives(), values());
        crowd.must(crowd.try_step(time + SHORT, SHORT));
        for ((rate, before), after) in rates.iter().zip(before).zip(values()) {
            // Forces change within the short step, most of all where a contact begins.
            let difference = (after - before) / SHORT;
            assert!(
                (rate - difference).abs() <= 0.02 * (1.0 + difference.abs()),
                "{rate} beside {difference}"
            );
        }
        assert!(rates.iter().filter(|rate| rate.abs() > 0.1).count() >= 4, "a push is on: {rates:?}");
        // Who is not there does not move, whatever the drive.
        crowd.must(crowd.set("agent[0].Fp.y", 300.0));
        crowd.set_flag("agent[0].Active", false);
        for stepped in [false, true] {
            if stepped {
                crowd.must(crowd.try_step(time + 2.0 * SHORT, SHORT));
            }
            let rates = derivatives();
            assert!(rates.iter().step_by(AGENTS).all(|rate| *rate == 0.0), "{stepped}");
            assert!(rates.iter().any(|rate| rate.abs() > 0.1));
        }
        // Only order 1, only of motion, of inputs not.
        for (name, quantity, order, why) in [
            ("agent[0].Omega", "Omega", 2, "order 2"),
            ("agent[0].Omega", "Omega", 0, "order 0"),
            ("agent[0].Mass", "Mass", 1, "not known"),
            ("agent[0].Mp", "Mp", 1, "not known"),
        ] {
            let (status, value) = crowd.try_derivative(name, order);
            let message = crowd.refused(status);
            assert!(message.contains(quantity) && message.contains(why) && value == 1.0, "{message}");
        }
    }
}

/// Every continuous output has a derivative: an importer that extrapolates all of them holds forces and overlaps.
#[test]
fn forces_and_overlaps_are_held() {
    for version in BOTH {
        let crowd = Crowd::pushed(version);
        let pressed = (0..40).any(|k| {
            crowd.steps(k, k + 1);
            crowd.get("agent[1].MeanNormalForce") > 0.0
        });
        assert!(pressed);
        for name in crowd.model.reals.iter().filter(|name| computed(name)) {
            let (status, value) = crowd.try_derivative(name, 1);
            crowd.must(status);
            assert_eq!(value, 0.0, "{name}");
        }
    }
}
