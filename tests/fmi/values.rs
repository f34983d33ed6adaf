//! Variables: what is refused, how it is told, and that nothing of it is kept.

use crate::fmu::*;
use crowd_mechanics::model::CrowdModel;
use crowd_mechanics::setup;
use lemons_core::trial::DriveTable;
use lemons_fmi::testing::bounds;

#[test]
fn unknown_and_mistyped_references_are_named() {
    for version in BOTH {
        let crowd = Crowd::pushed(version);
        let [real, integer, boolean, string] =
            ["agent[0].Fp.x", "Threads", "PlayDrive", "Trial"].map(|name| crowd.model.reference(name));
        let types = if version == V2 {
            ["Real", "Integer", "Boolean", "String"]
        } else {
            ["Float64", "Int32", "Boolean", "String"]
        };
        for reference in [real, integer, boolean, string, 9999, u32::MAX] {
            let at = [reference];
            let answers: [(u32, &dyn Fn() -> Status); 8] = [
                (real, &|| crowd.get_real(&at, 1).0),
                (real, &|| crowd.set_real(&at, &[0.0])),
                (integer, &|| crowd.get_integer(&at, 1).0),
                (integer, &|| crowd.set_integer(&at, &[1])),
                (boolean, &|| crowd.get_boolean(&at, 1).0),
                (boolean, &|| crowd.set_boolean(&at, &[1])),
                (string, &|| crowd.get_string(&at, 1).0),
                (string, &|| crowd.set_string(&at, &[Some(c"x")])),
            ];
            for (place, (of, call)) in answers.into_iter().enumerate().filter(|(_, (of, _))| *of != reference)
            {
                let message = crowd.refused(call());
                let kind = format!("no variable of type {}", types[place / 2]);
                let named = message.contains(&kind) && message.contains(&reference.to_string());
                assert!(named, "{of}: {message}");
            }
        }
    }
}

#[test]
fn what_is_not_a_finite_number_is_refused_for_every_real() {
    for version in BOTH {
        let crowd = Crowd::new(version);
        let before = crowd.bytes();
        for name in &crowd.model.reals {
            for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                let status = crowd.set(name, value);
                let message = if computed(name) { crowd.refused(status) } else { crowd.discarded(status) };
                assert!(version == V3 || message.contains(name), "{message}");
            }
        }
        crowd.initialize();
        crowd.reset();
        assert!(crowd.bytes() == before);
    }
}

#[test]
fn unphysical_parameters_are_refused_and_named() {
    const POSITIVE: [&str; 4] =
        ["TimeStepMechanical", "agent[1].Mass", "agent[4].MomentOfInertia", "material.concrete.ShearModulus"];
    const NOT_NEGATIVE: [&str; 4] = [
        "agent[2].FloorDamping",
        "agent[2].AngularDamping",
        "contact.concrete.human_naked.GammaNormal",
        "contact.human_naked.human_naked.KineticFriction",
    ];
    for version in BOTH {
        let crowd = Crowd::new(version);
        let cases = POSITIVE.iter().flat_map(|name| [(name, 0.0), (name, -0.0), (name, -1.0)]);
        for (name, value) in cases.chain(NOT_NEGATIVE.iter().map(|name| (name, -1e-9))) {
            let message = crowd.discarded(crowd.set(name, value));
            let named = version == V3 || message.contains(&format!("{name} = {value:?}"));
            assert!(named && message.contains(&format!("= {value:?}: must be ")), "{message}");
        }
        for name in NOT_NEGATIVE {
            crowd.must(crowd.set(name, 0.0));
        }
        for threads in [0, -1, i32::MIN] {
            let message = crowd.discarded(crowd.try_integer("Threads", threads));
            assert!(message.contains(&format!("Threads = {threads}")), "{message}");
        }
        let message = crowd.refused(crowd.set_text("Trial", "Nowhere"));
        assert!(message.contains("Trial = \"Nowhere\"") && message.contains("Trial_push"), "{message}");
        let message = crowd
            .refused(crowd.set_string(&[crowd.model.reference("OutputDirectory")], &[Some(c"/tmp/\xff")]));
        assert!(message.contains("UTF-8"), "{message}");
        crowd.initialize();
    }
}

/// Each good alone, but together no material, or forces that are no numbers, with which a state could be saved but not
/// restored: told when initialization ends, and can be put right then.
#[test]
fn values_that_do_not_fit_together_are_told_when_they_are_used() {
    type Values<'a> = &'a [(&'a str, f64)];
    const YOUNG: &str = "material.human_naked.YoungModulus";
    const CASES: [(Values<'static>, &str, Values<'static>); 2] = [
        (&[(YOUNG, 1e9)], "human_naked", &[(YOUNG, 4e6)]),
        (
            &[("agent[1].Position.x", 0.2), ("agent[1].Velocity.x", -1e308)],
            "agent \"0\": the forces on it are not finite",
            &[("agent[1].Velocity.x", 0.0)],
        ),
    ];
    for version in BOTH {
        for (bad, words, good) in CASES {
            let crowd = Crowd::new(version);
            crowd.must(crowd.set_all(bad));
            crowd.enter_initialization();
            for refused in [crowd.exit(), crowd.try_get("agent[0].NormalForce").0] {
                assert_eq!(refused, if version == V2 { ERROR } else { DISCARD });
            }
            let messages = crowd.take_messages();
            assert!(
                messages.len() == 2 && messages.iter().all(|told| told.text.contains(words)),
                "{messages:?}"
            );
            crowd.must(crowd.set_all(good));
            crowd.must(crowd.exit());
        }
    }
}

#[test]
fn all_of_a_set_or_nothing() {
    for version in BOTH {
        let crowd = Crowd::new(version);
        let good = [("agent[0].Fp.x", 5.0), ("agent[0].Position.x", -1.0), ("agent[0].Mass", 70.0)];
        let before = crowd.bytes();
        for bad in
            [("agent[1].MomentOfInertia", -1.0), ("agent[1].Fp.y", f64::NAN), ("agent[1].NormalForce", 1.0)]
        {
            let [a, b, c] = good;
            for all in [[a, b, c, bad], [a, bad, b, c]] {
                let status = crowd.set_all(&all);
                // Only an output cannot be set at all.
                let message = match bad.0 {
                    "agent[1].NormalForce" => crowd.refused(status),
                    _ => crowd.discarded(status),
                };
                assert!(version == V3 || message.contains(bad.0), "{message}");
            }
        }
        crowd.refused(crowd.try_texts(&[("OutputDirectory", "/tmp"), ("Trial", "Nowhere")]));
        let integers = ["Threads", "AgentContacts"].map(|name| crowd.model.reference(name));
        crowd.refused(crowd.set_integer(&integers, &[2, 2]));
        assert!(crowd.bytes() == before);

        crowd.push_and_initialize();
        crowd.steps(0, 2);
        let (before, values) = (crowd.bytes(), crowd.everything());
        for (bad, quantity) in [
            ("agent[0].Mass", "Mass"),
            ("agent[0].Position.x", "Position"),
            ("agent[0].NormalForce", "NormalForce"),
            ("TimeStepMechanical", "TimeStepMechanical"),
        ] {
            let message = crowd.refused(crowd.set_all(&[("agent[0].Fp.x", 5.0), (bad, 1.0)]));
            assert!(message.contains(quantity) && message.contains("cannot be set"), "{message}");
        }
        for (name, status) in [
            ("Threads", crowd.try_integer("Threads", 2)),
            ("OutputDirectory", crowd.set_text("OutputDirectory", "/tmp")),
            ("Trial", crowd.set_text("Trial", "Trial_push")),
        ] {
            assert_eq!(status, ERROR, "{name}");
        }
        let messages = crowd.take_messages();
        assert!(messages.iter().all(|message| message.text.contains("after initialization")), "{messages:?}");
        assert!(crowd.bytes() == before && crowd.everything() == values);
    }
}

#[test]
fn what_is_set_is_what_is_got() {
    for version in BOTH {
        let crowd = Crowd::new(version);
        let values: Vec<(&str, f64)> = (crowd.model.reals.iter().filter(|name| !computed(name)).zip(0..))
            .map(|(name, k)| (&**name, 0.1 + f64::from(k)))
            .collect();
        crowd.must(crowd.set_all(&values));
        crowd.must(crowd.set_text("OutputDirectory", "/tmp/a b/ü"));
        crowd.must(crowd.try_integer("Threads", 3));
        crowd.enter_initialization();
        for (name, value) in values {
            assert_eq!(crowd.get(name), value, "{name}");
        }
        assert_eq!(crowd.text("OutputDirectory"), "/tmp/a b/ü");
        assert_eq!((crowd.text("Trial"), crowd.integer("Threads")), ("Trial_push".into(), 3));
        // Pointers from one call hold together.
        let references = ["Trial", "OutputDirectory", "Trial"].map(|name| crowd.model.reference(name));
        let (status, texts) = crowd.get_string(&references, 3);
        crowd.must(status);
        assert_eq!(texts, [c"Trial_push".into(), c"/tmp/a b/ü".to_owned(), c"Trial_push".into()]);
    }
}

/// Finite numbers may still be absurd: then a step fails in words, or its outputs are numbers.
#[test]
fn absurd_numbers_do_not_break_the_boundary() {
    let model = Model::paper(V2);
    // All agents and materials alike.
    let others =
        |name: &&String| computed(name) || name.starts_with("agent[") && !name.starts_with("agent[1]");
    for name in model.reals.iter().filter(|name| !others(name)) {
        for value in [1e308, -1e308, 1e154, 1e20, -1e20, 1e-20, f64::MIN_POSITIVE, 5e-324] {
            let case = format!("{name} = {value:?}");
            let crowd = Crowd::new(V2);
            let told = |status: Status| {
                let log = crowd.take_messages();
                let refused = [ERROR, DISCARD].contains(&status) && !log.is_empty();
                assert!(status == OK || refused, "{case}: {status:?} {log:?}");
                status == OK
            };
            crowd.must(crowd.set_all(&[("TimeStepMechanical", 1e-3), ("agent[0].Fp.x", 700.0)]));
            if !told(crowd.set(name, value)) {
                assert!(value < f64::MIN_POSITIVE, "{case}");
                continue;
            }
            crowd.enter_initialization();
            if !told(crowd.exit()) {
                continue;
            }
            for k in 0..3 {
                if !told(crowd.try_step(f64::from(k) * 0.05, 0.05)) {
                    break;
                }
                let (reals, _) = crowd.everything();
                assert!(reals.iter().all(|bits| f64::from_bits(*bits).is_finite()), "{case}, step {k}");
            }
        }
    }
}

/// Somebody goes behind another's back, and comes back where the other is now.
#[test]
fn who_comes_back_inside_another_is_warned_of() {
    let warnings = |crowd: &Crowd| {
        let messages = crowd.take_messages().into_iter().filter(|message| message.status == WARNING);
        messages.map(|message| message.text).collect::<Vec<_>>()
    };
    let crowd = Crowd::new(V2);
    crowd.must(crowd.set_all(&[("TimeStepMechanical", 1e-5), ("agent[0].Velocity.x", 0.5)]));
    crowd.must(crowd.set("agent[0].FloorDamping", 0.0));
    crowd.set_flag("PlayDrive", false);
    crowd.set_flag("agent[1].Active", false);
    crowd.initialize();
    // From 0 m towards 0.279 m, where the other one was.
    crowd.steps(0, 50);
    let apart = (crowd.get("agent[1].Position.x") - crowd.get("agent[0].Position.x")).abs();
    assert!(apart < 0.05, "{apart}");
    assert_eq!(warnings(&crowd), [""; 0]);
    // Here and away again within the same pause is no return.
    crowd.set_flag("agent[1].Active", true);
    crowd.set_flag("agent[1].Active", false);
    assert_eq!(crowd.try_step(0.5, 1e-3), OK);
    assert_eq!(warnings(&crowd), [""; 0]);
    crowd.set_flag("agent[1].Active", true);
    let _ = crowd.try_step(0.501, 1e-3);
    let told = warnings(&crowd);
    let begin =
        "pairs of disks of different agents overlap where agents come back at t = 0.501 s, the deepest by ";
    let [message] = &told[..] else { panic!("{told:?}") };
    let deepest = message.split(begin).nth(1).and_then(|rest| rest.split(' ').next()).expect(message);
    // A disk of radius 0.095 m and more lies in another one.
    assert!(
        deepest.parse::<f64>().unwrap() > 100.0 && message.ends_with("(agents \"0\" and \"1\")"),
        "{message}"
    );
    // Once.
    let _ = crowd.try_step(0.502, 1e-3);
    assert_eq!(warnings(&crowd), [""; 0]);
}

/// What a description declares, both versions.
#[test]
fn declared_bounds_are_kept() {
    let (trial, _) = setup::read(&paper()).unwrap();
    bounds::are_kept(|| CrowdModel::of_trial(trial.clone(), DriveTable::default()));
}
