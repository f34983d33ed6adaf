//! Variables through the C functions: what is refused, how it is told, and that nothing of it is kept.

use crate::fmu::*;
use std::ffi::CStr;
use std::ptr::null;

#[test]
fn unknown_and_mistyped_references_are_named() {
    let instance = Instance::pushed(Fmu::get());
    let (c, i) = (&instance.fmu.c, instance.raw);
    let text = c"x".as_ptr();
    // References: a Real, an Integer, a String, one beyond the table, the largest.
    let end = instance.model.references.len() as u32;
    let [real, integer, string] = ["agent[0].Fp.x", "Threads", "Trial"].map(|n| instance.model.reference(n));
    for reference in [real, integer, string, end, u32::MAX] {
        let mut answers = Vec::new();
        unsafe {
            if reference != real {
                answers.push(("Real", instance.refused((c.fmi2GetReal)(i, &reference, 1, &mut 0.0))));
                answers.push(("Real", instance.refused((c.fmi2SetReal)(i, &reference, 1, &0.0))));
            }
            if reference != integer {
                answers.push(("Integer", instance.refused((c.fmi2GetInteger)(i, &reference, 1, &mut 0))));
                answers.push(("Integer", instance.refused((c.fmi2SetInteger)(i, &reference, 1, &1))));
            }
            if reference != string {
                answers.push(("String", instance.refused((c.fmi2GetString)(i, &reference, 1, &mut null()))));
                answers.push(("String", instance.refused((c.fmi2SetString)(i, &reference, 1, &text))));
            }
            answers.push(("Boolean", instance.refused((c.fmi2GetBoolean)(i, &reference, 1, &mut 0))));
            answers.push(("Boolean", instance.refused((c.fmi2SetBoolean)(i, &reference, 1, &0))));
        }
        for (kind, message) in answers {
            assert!(message.contains(kind) && message.contains(&reference.to_string()), "{message}");
        }
    }
}

#[test]
fn what_is_not_a_finite_number_is_refused_for_every_real() {
    let instance = Instance::new(Fmu::get());
    let before = instance.bytes();
    for (name, _) in &instance.model.reals {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let message = instance.refused(instance.set(name, value));
            assert!(message.contains(name), "{message}");
        }
    }
    instance.initialize();
    for name in ["agent[0].Fp.x", "agent[3].Fp.y", "agent[4].Mp"] {
        let message = instance.refused(instance.set(name, f64::NAN));
        assert!(message.contains(&format!("{name} = NaN")), "{message}");
    }
    instance.must(unsafe { (instance.fmu.c.fmi2Reset)(instance.raw) });
    assert!(instance.bytes() == before);
}

#[test]
fn unphysical_parameters_are_refused_and_named() {
    let instance = Instance::new(Fmu::get());
    let positive =
        ["TimeStepMechanical", "agent[1].Mass", "agent[4].MomentOfInertia", "material.concrete.ShearModulus"];
    let not_negative = [
        "agent[2].FloorDamping",
        "agent[2].AngularDamping",
        "contact.concrete.human_naked.GammaNormal",
        "contact.human_naked.human_naked.KineticFriction",
    ];
    let cases = positive.iter().flat_map(|name| [(name, 0.0), (name, -0.0), (name, -1.0)]);
    for (name, value) in cases.chain(not_negative.iter().map(|name| (name, -1e-9))) {
        let message = instance.refused(instance.set(name, value));
        assert!(message.contains(&format!("{name} = {value:?}: must be ")), "{message}");
    }
    for name in not_negative {
        instance.must(instance.set(name, 0.0));
    }
    for threads in [0, -1, i32::MIN] {
        let message = instance.refused(instance.set_integer("Threads", threads));
        assert!(message.contains(&format!("Threads = {threads}")), "{message}");
    }
    let message = instance.refused(instance.set_string("Trial", "Nowhere"));
    assert!(message.contains("Trial = \"Nowhere\"") && message.contains("Trial_push"), "{message}");
    instance.initialize();
}

/// Each good alone, but together no material: told when initialization ends, and can be put right then.
#[test]
fn moduli_that_make_no_material_are_told_when_they_are_used() {
    let instance = Instance::new(Fmu::get());
    let c = &instance.fmu.c;
    instance.must(instance.set("material.human_naked.YoungModulus", 1e9));
    unsafe {
        instance.enter_initialization();
        let message = instance.refused((c.fmi2ExitInitializationMode)(instance.raw));
        assert!(message.contains("human_naked"), "{message}");
        let message = instance.refused(instance.try_get("agent[0].NormalForce").0);
        assert!(message.contains("human_naked"), "{message}");
        instance.must(instance.set("material.human_naked.YoungModulus", 4e6));
        instance.must((c.fmi2ExitInitializationMode)(instance.raw));
    }
}

#[test]
fn all_of_a_set_or_nothing() {
    let instance = Instance::new(Fmu::get());
    let good = [("agent[0].Fp.x", 5.0), ("agent[0].Position.x", -1.0), ("agent[0].Mass", 70.0)];
    let before = instance.bytes();
    for bad in [("agent[1].Mass", -1.0), ("agent[1].Fp.x", f64::NAN), ("agent[1].NormalForce", 1.0)] {
        let [a, b, c] = good;
        let message = instance.refused(instance.set_all(&[a, b, c, bad]));
        assert!(message.contains(bad.0), "{message}");
        instance.refused(instance.set_all(&[a, bad, b, c]));
    }
    let unknown = [instance.model.reference("agent[0].Fp.x"), u32::MAX];
    instance.refused(instance.set_references(&unknown, &[5.0, 5.0]));
    let strings = ["OutputDirectory", "Trial"].map(|name| instance.model.reference(name));
    let texts = [c"/tmp".as_ptr(), c"Nowhere".as_ptr()];
    instance.refused(unsafe {
        (instance.fmu.c.fmi2SetString)(instance.raw, strings.as_ptr(), 2, texts.as_ptr())
    });
    let integers = ["Threads", "AgentContacts"].map(|name| instance.model.reference(name));
    let values = [2, 2];
    instance.refused(unsafe {
        (instance.fmu.c.fmi2SetInteger)(instance.raw, integers.as_ptr(), 2, values.as_ptr())
    });
    assert!(instance.bytes() == before);

    instance.push_and_initialize();
    instance.steps(0, 2);
    let (before, values) = (instance.bytes(), instance.everything());
    for bad in ["agent[0].Mass", "agent[0].Position.x", "agent[0].NormalForce", "TimeStepMechanical"] {
        let message = instance.refused(instance.set_all(&[("agent[0].Fp.x", 5.0), (bad, 1.0)]));
        assert!(message.contains(bad) && message.contains("cannot be set"), "{message}");
    }
    for (name, set) in [
        ("Threads", (|i| i.set_integer("Threads", 2)) as fn(&Instance) -> i32),
        ("OutputDirectory", |i| i.set_string("OutputDirectory", "/tmp")),
        ("Trial", |i| i.set_string("Trial", "Trial_push")),
    ] {
        let message = instance.refused(set(&instance));
        assert!(message.contains(name) && message.contains("after initialization"), "{message}");
    }
    assert!(instance.bytes() == before && instance.everything() == values);
}

#[test]
fn what_is_set_is_what_is_got() {
    let instance = Instance::new(Fmu::get());
    let values: Vec<(&str, f64)> = (instance.model.reals.iter())
        .zip(0..)
        .filter(|((name, _), _)| !computed(name))
        .map(|((name, _), k)| (&**name, 0.1 + f64::from(k)))
        .collect();
    instance.must(instance.set_all(&values));
    instance.must(instance.set_string("OutputDirectory", "/tmp/a b/ü"));
    instance.must(instance.set_integer("Threads", 3));
    instance.enter_initialization();
    for (name, value) in values {
        assert_eq!(instance.get(name), value, "{name}");
    }
    assert_eq!(instance.get_string("OutputDirectory"), "/tmp/a b/ü");
    assert_eq!(instance.get_string("Trial"), "Trial_push");
    assert_eq!(instance.get_integer("Threads"), 3);
}

/// Start values are the Trial's; inputs set between steps are seen at once, poses are not touched.
#[test]
fn inputs_and_outputs_at_a_communication_point() {
    let instance = Instance::pushed(Fmu::get());
    assert_eq!(instance.get("agent[1].Position.x"), 0.279);
    assert_eq!(instance.get("agent[1].Position.y"), 0.030);
    assert_eq!(instance.get("agent[0].Mass"), 89.0);
    assert_eq!(instance.get("agent[0].Fp.x"), 700.0);
    instance.steps(0, 3);
    let x = instance.get("agent[0].Position.x");
    assert!(x > 0.0);
    instance.must(instance.set("agent[0].Fp.x", -50.0));
    assert_eq!((instance.get("agent[0].Fp.x"), instance.get("agent[0].Position.x")), (-50.0, x));
}

/// Pointers from one call of `fmi2GetString` hold together.
#[test]
fn several_strings_at_once() {
    let instance = Instance::pushed(Fmu::get());
    let references = ["Trial", "OutputDirectory", "Trial"].map(|name| instance.model.reference(name));
    let mut texts = [null(); 3];
    instance.must(unsafe {
        (instance.fmu.c.fmi2GetString)(instance.raw, references.as_ptr(), 3, texts.as_mut_ptr())
    });
    let texts = texts.map(|text| unsafe { CStr::from_ptr(text) });
    assert_eq!(texts, [c"Trial_push", c"", c"Trial_push"]);
}

#[test]
fn texts_that_are_no_utf8_are_refused() {
    let instance = Instance::new(Fmu::get());
    let reference = instance.model.reference("OutputDirectory");
    let text = c"/tmp/\xff".as_ptr();
    let message =
        instance.refused(unsafe { (instance.fmu.c.fmi2SetString)(instance.raw, &reference, 1, &text) });
    assert!(message.contains("UTF-8"), "{message}");
}

/// Finite numbers may still be absurd: then a step fails in words, or its outputs are numbers.
#[test]
fn absurd_numbers_do_not_break_the_boundary() {
    let quick = [("TimeStepMechanical", 1e-3), ("agent[0].Fp.x", 700.0)];
    for (name, _) in &Model::paper().reals {
        // All agents and materials alike.
        if computed(name) || name.starts_with("agent[") && !name.starts_with("agent[1]") {
            continue;
        }
        for value in [1e308, -1e308, 1e154, 1e20, -1e20, 1e-20, 5e-324] {
            let case = format!("{name} = {value:?}");
            let instance = Instance::new(Fmu::get());
            instance.must(instance.set_all(&quick));
            if instance.set(name, value) == ERROR {
                assert!(value < 0.0, "{case}");
                continue;
            }
            let c = &instance.fmu.c;
            unsafe {
                instance.enter_initialization();
                let status = (c.fmi2ExitInitializationMode)(instance.raw);
                let log = instance.log.take();
                assert!(status == OK || status == ERROR && !log.is_empty(), "{case}: {status} {log:?}");
                if status == ERROR {
                    continue;
                }
            }
            for k in 0..3 {
                let status = instance.try_step(f64::from(k) * 0.05, 0.05);
                let log = instance.log.take();
                assert!(status == OK || status == ERROR && !log.is_empty(), "{case}: {status} {log:?}");
                if status == ERROR {
                    break;
                }
                for (output, _) in &instance.model.reals {
                    let value = instance.get(output);
                    assert!(value.is_finite(), "{case}: {output} is {value} after step {k}");
                }
            }
        }
    }
}

/// Somebody goes behind another's back, and comes back where the other is now.
#[test]
fn who_comes_back_inside_another_is_warned_of() {
    let warnings = |instance: &Instance| {
        let said = instance.log.take().into_iter().filter(|message| message.status == WARNING);
        said.map(|message| message.text).collect::<Vec<_>>()
    };
    let instance = Instance::new(Fmu::get());
    instance.must(instance.set_all(&[("TimeStepMechanical", 1e-5), ("agent[0].Velocity.x", 0.5)]));
    instance.must(instance.set_boolean("PlayDrive", false));
    instance.must(instance.set_boolean("agent[1].Active", false));
    instance.must(instance.set("agent[0].FloorDamping", 0.0));
    instance.initialize();
    // From 0 m towards 0.279 m, where the other one was.
    instance.steps(0, 50);
    let apart = (instance.get("agent[1].Position.x") - instance.get("agent[0].Position.x")).abs();
    assert!(apart < 0.05, "{apart}");
    assert_eq!(warnings(&instance), [""; 0]);
    // Here and away again within the same pause is no return.
    instance.must(instance.set_boolean("agent[1].Active", true));
    instance.must(instance.set_boolean("agent[1].Active", false));
    assert_eq!(instance.try_step(0.5, 1e-3), OK);
    assert_eq!(warnings(&instance), [""; 0]);
    instance.must(instance.set_boolean("agent[1].Active", true));
    let _ = instance.try_step(0.501, 1e-3);
    let said = warnings(&instance);
    let begin =
        "pairs of disks of different agents overlap where agents come back at t = 0.501 s, the deepest by ";
    let [said] = &said[..] else { panic!("{said:?}") };
    let deepest = said.split(begin).nth(1).and_then(|rest| rest.split(' ').next()).expect(said);
    // A disk of radius 0.095 m and more lies in another one.
    assert!(deepest.parse::<f64>().unwrap() > 100.0 && said.ends_with("(agents \"0\" and \"1\")"), "{said}");
    // Once.
    let _ = instance.try_step(0.502, 1e-3);
    assert_eq!(warnings(&instance), [""; 0]);
}
