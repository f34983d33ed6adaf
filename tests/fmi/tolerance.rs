//! The tolerance of an experiment may shorten the mechanical step, and never lengthens it.

use crate::fmu::*;

const PARAMETER: &str = "TimeStepMechanical";
/// \[s\] of the paper's Trial; one that is set; and the longest for a tolerance of 1e-4. The shortest period is 2π √(m*/k) = 10.9 ms: agent 1 on
/// concrete. √(1e-4 m / 5 m) of it is 48.9 µs.
const OWN: f64 = 2e-6;
const LONG: f64 = 1e-3;
const CHOSEN: f64 = 4.8e-5;

/// Leaves Initialization Mode, and returns what is said then.
#[track_caller]
fn exit(crowd: &Crowd) -> Vec<String> {
    let status = crowd.exit();
    let messages: Vec<String> = crowd.take_messages().into_iter().map(|message| message.text).collect();
    assert_eq!(status, OK, "{messages:?}");
    messages
}

/// In Initialization Mode, with a long step that was set.
fn entered(version: Version, tolerance: f64) -> Crowd {
    let crowd = Crowd::new(version);
    crowd.must(crowd.set(PARAMETER, LONG));
    crowd.must(crowd.enter(Some(tolerance), 0.0, None));
    crowd
}

/// A hundred times the mass and the moment of inertia, ten times the period.
fn make_heavy(crowd: &Crowd, agents: usize) {
    for name in ["Mass", "MomentOfInertia"] {
        for name in (0..agents).map(|i| format!("agent[{i}].{name}")) {
            crowd.must(crowd.set(&name, 100.0 * crowd.get(&name)));
        }
    }
}

#[test]
fn a_tolerance_only_shortens_the_step() {
    for version in BOTH {
        let crowd = entered(version, 1e-4);
        assert_eq!(crowd.get(PARAMETER), CHOSEN);
        make_heavy(&crowd, AGENTS);
        let heavy = crowd.get(PARAMETER);
        assert!((4.8e-4..=5e-4).contains(&heavy), "{heavy}");
        crowd.must(crowd.set(PARAMETER, 3e-5));
        exit(&crowd);
        assert_eq!(crowd.get(PARAMETER), 3e-5);
        // After a reset nothing of it is left. The Trial's step is shorter than such tolerances need, or none is given.
        for (tolerance, step) in [(Some(1e-4), OWN), (Some(1e3), OWN), (Some(0.0), OWN), (Some(1e-8), 4.8e-7)]
        {
            crowd.reset();
            crowd.must(crowd.enter(tolerance, 0.0, None));
            assert_eq!(exit(&crowd), Vec::<String>::new());
            assert_eq!(crowd.get(PARAMETER), step, "{tolerance:?}");
        }
        // The last experiment counts.
        crowd.reset();
        crowd.must(crowd.set_up(Some(1e-8), 0.0, None));
        crowd.initialize();
        assert_eq!(crowd.get(PARAMETER), OWN);
    }
}

#[test]
fn a_tolerance_chooses_neither_what_check_warns_of_nor_what_takes_for_ever() {
    // A twentieth of the period, 10.9 ms; and finer than anything that was compared.
    for (tolerance, range, words) in
        [(1e3, 5.0e-4..=5.6e-4, vec![]), (1e-30, 1e-7..=2e-7, vec!["is taken as 1e-9"])]
    {
        let crowd = entered(V2, tolerance);
        let messages = exit(&crowd);
        let step = crowd.get(PARAMETER);
        assert!(range.contains(&step), "{step}");
        assert!(
            messages.len() == words.len() && messages.iter().zip(words).all(|(a, b)| a.contains(b)),
            "{messages:?}"
        );
    }
    // A TimeStep of 0.05 s has at most 500 steps.
    let crowd = entered(V2, 1e-4);
    crowd.must(crowd.set("MostMechanicalSteps", 500.0));
    let messages = exit(&crowd);
    assert_eq!(crowd.get(PARAMETER), 1e-4);
    let words = ["MostMechanicalSteps = 500", "accurate to about 4.2e-4 m"];
    assert!(messages.len() == 1 && words.iter().all(|word| messages[0].contains(word)), "{messages:?}");
    crowd.must(crowd.try_step(0.0, 0.05));
}

#[test]
fn a_state_carries_the_tolerance() {
    for version in BOTH {
        let crowd = entered(version, 1e-4);
        let early = crowd.bytes();
        exit(&crowd);
        crowd.must(crowd.set("agent[0].Fp.x", 700.0));
        crowd.steps(0, 10);
        let bytes = crowd.bytes();
        crowd.steps(10, 18);
        let other = Crowd::new(version);
        other.must(other.restore(&bytes));
        assert_eq!(other.get(PARAMETER), CHOSEN);
        other.steps(10, 18);
        assert!(other.everything() == crowd.everything() && other.bytes() == crowd.bytes());
        // Saved during initialization: parameters that are set later still count.
        other.must(other.restore(&early));
        make_heavy(&other, AGENTS);
        exit(&other);
        assert!(other.get(PARAMETER) > 4.8e-4);
    }
}
