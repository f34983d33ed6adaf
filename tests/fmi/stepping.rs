//! Times and steps that are refused, and those that are not.

use crate::fmu::*;
use crate::lifecycle::{State, state_of};

#[test]
fn experiments_are_checked() {
    for version in BOTH {
        let crowd = Crowd::new(version);
        let before = crowd.bytes();
        for (tolerance, start, stop) in [
            (None, f64::NAN, None),
            (None, f64::INFINITY, None),
            (None, 0.0, Some(f64::NAN)),
            (None, 0.0, Some(f64::INFINITY)),
            (None, 1.0, Some(0.5)),
            (Some(-1e-4), 0.0, None),
            (Some(f64::NAN), 0.0, None),
            (Some(f64::INFINITY), 0.0, None),
        ] {
            let message = crowd.refused(crowd.enter(tolerance, start, stop));
            let word = if tolerance.is_some() { "tolerance" } else { "time" };
            assert!(message.contains(word), "{message}");
        }
        assert!(crowd.bytes() == before);
        // An undefined stop time and tolerance are not looked at. The last experiment counts.
        crowd.must(crowd.set_up(None, -3.0, None));
        crowd.must(crowd.set("TimeStepMechanical", 1e-4));
        crowd.must(crowd.enter(None, 7.0, Some(7.02)));
        crowd.must(crowd.exit());
        let done = crowd.do_step(7.0, STEP);
        crowd.must(done.status);
        assert_eq!((done.early, done.time), (false, 7.0 + STEP));
    }
}

#[test]
fn refused_steps_change_nothing() {
    for version in BOTH {
        let crowd = Crowd::new(version);
        crowd.must(crowd.set("TimeStepMechanical", 1e-4));
        crowd.must(crowd.enter(None, 0.0, Some(0.05)));
        crowd.must(crowd.exit());
        crowd.steps(0, 2);
        let (before, values) = (crowd.bytes(), crowd.everything());
        for (from, step, word) in [
            (0.02, 0.0, "step"),
            (0.02, -STEP, "step"),
            (0.02, f64::NAN, "step"),
            (0.02, f64::INFINITY, "step"),
            (0.0, STEP, "communication point"),
            (0.03, STEP, "communication point"),
            (f64::NAN, STEP, "communication point"),
            (f64::INFINITY, STEP, "communication point"),
            (0.02, 0.04, "stop time"),
        ] {
            let message = crowd.refused(crowd.try_step(from, step));
            assert!(message.contains(word), "({from}, {step}): {message}");
        }
        assert!(crowd.bytes() == before && crowd.everything() == values);
        // As masters add up their times.
        crowd.must(crowd.try_step(0.019_999_999_999_999_997, 0.010_000_000_000_000_002));
        crowd.must(crowd.try_step(0.03, 0.020_000_000_000_000_004));
    }
}

/// Steps that nobody could wait for, or that lead beyond all numbers: `fmi2CancelStep` cannot reach a slave that steps
/// synchronously. They are refused before they begin.
#[test]
fn steps_without_end_are_refused() {
    for version in BOTH {
        for (mechanical, most, start, step, words) in [
            (1e-5, 1e9, 0.0, 50_000.0, ["5000000000 mechanical steps", "MostMechanicalSteps = 1000000000"]),
            (1e-3, 50.0, 0.0, 0.051, ["51 mechanical steps", "MostMechanicalSteps = 50"]),
            (1e-300, 1e300, 0.0, 0.05, ["too many steps", ""]),
            (1e308, 1e9, 1e308, 1e308, ["finite time", ""]),
        ] {
            let crowd = Crowd::new(version);
            let settings = [("TimeStepMechanical", mechanical), ("MostMechanicalSteps", most)];
            crowd.must(crowd.set_all(&settings));
            crowd.must(crowd.enter(None, start, None));
            crowd.must(crowd.exit());
            let state = crowd.bytes();
            let message = crowd.refused(crowd.try_step(start, step));
            assert!(words.iter().all(|word| message.contains(word)), "{message}");
            assert!(crowd.bytes() == state);
            // The parameters are of the state.
            crowd.must(crowd.restore(&state));
            crowd.refused(crowd.try_step(start, step));
            if mechanical < 1e300 && mechanical > 1e-300 {
                crowd.must(crowd.try_step(start, 0.05));
            }
        }
    }
}

#[test]
fn output_that_cannot_be_written_is_named() {
    let directory = tempfile::tempdir().unwrap();
    for version in BOTH {
        let output = directory.path().join("made/by the FMU");
        let crowd = Crowd::new(version);
        crowd.must(crowd.set_text("OutputDirectory", "/dev/null/at all"));
        crowd.must(crowd.set("TimeStepMechanical", 1e-4));
        crowd.enter_initialization();
        let message = crowd.refused(crowd.exit());
        assert!(message.contains("OutputDirectory") && message.contains("/dev/null/at all"), "{message}");
        crowd.must(crowd.set_text("OutputDirectory", output.to_str().unwrap()));
        crowd.must(crowd.exit());
        crowd.steps(0, 1);
        std::fs::remove_dir_all(&output).unwrap();
        let message = crowd.refused(crowd.try_step(STEP, STEP));
        assert!(message.contains("OutputDirectory") && message.contains("by the FMU"), "{message}");
        let failed = if version == V2 { State::Error } else { State::Terminated };
        assert_eq!(state_of(&crowd), failed);
    }
}

/// An importer may write anywhere, but not through a link that somebody else left there.
#[test]
fn output_does_not_go_through_a_link() {
    let directory = tempfile::tempdir().unwrap();
    let mine = directory.path().join("mine");
    std::fs::write(&mine, "precious").unwrap();
    let output = directory.path().join("output");
    std::fs::create_dir(&output).unwrap();
    for name in ["AgentDynamics output t=0.05.xml", "AgentInteractions t=0.05.xml"] {
        std::os::unix::fs::symlink(&mine, output.join(name)).unwrap();
        let crowd = Crowd::new(V2);
        crowd.must(crowd.set_text("OutputDirectory", output.to_str().unwrap()));
        crowd.must(crowd.set("TimeStepMechanical", 1e-4));
        crowd.initialize();
        let message = crowd.refused(crowd.try_step(0.0, 0.05));
        assert!(message.contains(name) && message.contains("there is a link"), "{message}");
        assert_eq!(std::fs::read_to_string(&mine).unwrap(), "precious");
        std::fs::remove_file(output.join(name)).unwrap();
    }
}
