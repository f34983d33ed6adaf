//! FMU states: saved in the middle of a contact, restored anywhere, damaged in every way.

use crate::fmu::*;
use std::ptr::null_mut;

/// Steps until agent 0 has met agent 1.
const MEETING: usize = 10;

/// An instance in the middle of a contact.
fn touching() -> Instance<'static> {
    let instance = Instance::pushed(Fmu::get());
    instance.must(instance.set("agent[0].Fp.y", 40.0)); // so that springs stretch
    instance.steps(0, MEETING);
    assert!(instance.get_integer("AgentContacts") > 0);
    assert!(instance.get("agent[1].NormalForce") > 0.0);
    instance
}

/// What comes after the meeting, step by step; the drive changes on the way.
fn future(instance: &Instance) -> Vec<Bits> {
    let seen = (MEETING..MEETING + 20).map(|k| {
        if k == MEETING + 10 {
            instance.must(instance.set_all(&[("agent[0].Fp.x", -200.0), ("agent[2].Mp", 3.0)]));
        }
        instance.steps(k, k + 1);
        instance.everything()
    });
    seen.collect()
}

#[test]
fn a_state_restored_runs_on_bit_for_bit() {
    let instance = touching();
    let state = instance.save();
    let now = instance.everything();
    let expected = future(&instance);
    assert_ne!(expected[19], now);

    // In the same instance, twice.
    for _ in 0..2 {
        instance.must(unsafe { (instance.fmu.c.fmi2SetFMUstate)(instance.raw, state) });
        assert_eq!(instance.everything(), now);
        assert_eq!(future(&instance), expected);
    }
    // In others: fresh, with other settings, already stepping, ended.
    let others: [fn(&Instance); 4] = [
        |_| (),
        |other| other.must(other.set_all(&[("agent[0].Mass", 120.0), ("agent[3].Position.x", 1.2)])),
        |other| {
            other.push_and_initialize();
            other.steps(0, 20);
        },
        |other| {
            other.initialize();
            other.must(unsafe { (other.fmu.c.fmi2Terminate)(other.raw) });
        },
    ];
    for prepare in others {
        let other = Instance::new(Fmu::get());
        prepare(&other);
        other.must(unsafe { (other.fmu.c.fmi2SetFMUstate)(other.raw, state) });
        assert_eq!(other.everything(), now);
        assert_eq!(future(&other), expected);
    }
    instance.free_state(state);
}

#[test]
fn a_state_goes_through_bytes_and_outlives_its_instance() {
    let instance = touching();
    let (bytes, now) = (instance.bytes(), instance.everything());
    let expected = future(&instance);
    drop(instance);
    let other = Instance::new(Fmu::get());
    other.must(other.restore_bytes(&bytes));
    assert!(other.everything() == now && other.bytes() == bytes);
    assert_eq!(future(&other), expected);
    // Importers may keep it in a longer buffer.
    other.must(other.restore_bytes(&[&bytes[..], &[0xAA; 100]].concat()));
    assert_eq!(future(&other), expected);
}

/// A state holds the settings of its instance: a run with other parameters is restored with them.
#[test]
fn a_state_carries_its_parameters() {
    let instance = Instance::new(Fmu::get());
    let settings = [
        ("agent[0].Mass", 60.0),
        ("contact.human_naked.human_naked.KineticFriction", 0.9),
        ("material.human_naked.YoungModulus", 3.5e6),
        ("agent[1].Position.y", 0.05),
    ];
    instance.must(instance.set_all(&settings));
    instance.push_and_initialize();
    instance.steps(0, MEETING);
    let bytes = instance.bytes();
    let expected = future(&instance);
    let other = Instance::pushed(Fmu::get());
    other.must(other.restore_bytes(&bytes));
    assert_eq!(other.get("agent[0].Mass"), 60.0);
    assert_eq!(future(&other), expected);
}

/// Before the world exists, and again in each state of the lifecycle.
#[test]
fn states_of_every_phase() {
    use crate::lifecycle::{STATES, reach};
    for phase in STATES {
        let saved = reach(phase).bytes();
        for other in STATES {
            let instance = reach(other);
            instance.must(instance.restore_bytes(&saved));
            assert!(instance.bytes() == saved, "{phase:?} in {other:?}");
        }
    }
}

#[test]
fn state_pointers() {
    let instance = touching();
    let (c, i) = (&instance.fmu.c, instance.raw);
    let mut state = instance.save();
    let place = state;
    instance.steps(MEETING, MEETING + 1);
    let later = instance.everything();
    unsafe {
        // A state that is not NULL is overwritten in its place.
        instance.must((c.fmi2GetFMUstate)(i, &mut state));
        assert_eq!(state, place);
        instance.steps(MEETING + 1, MEETING + 2);
        instance.must((c.fmi2SetFMUstate)(i, state));
        assert_eq!(instance.everything(), later);
        // So it is by fmi2DeSerializeFMUstate; a refused one leaves it alone.
        let bytes = instance.bytes();
        instance.must((c.fmi2DeSerializeFMUstate)(i, bytes.as_ptr(), bytes.len(), &mut state));
        assert_eq!(state, place);
        instance.refused((c.fmi2DeSerializeFMUstate)(i, bytes.as_ptr(), 3, &mut state));
        assert_eq!(state, place);
        instance.must((c.fmi2SetFMUstate)(i, state));
        assert_eq!(instance.everything(), later);
        // A buffer one byte short.
        let mut buffer = vec![0xEE; bytes.len()];
        let short = bytes.len() - 1;
        let message = instance.refused((c.fmi2SerializeFMUstate)(i, state, buffer.as_mut_ptr(), short));
        assert!(
            message.contains(&short.to_string()) && message.contains(&bytes.len().to_string()),
            "{message}"
        );
        assert!(buffer.iter().all(|byte| *byte == 0xEE));

        instance.must((c.fmi2FreeFMUstate)(i, &mut state));
        assert!(state.is_null());
        instance.must((c.fmi2FreeFMUstate)(i, &mut state));
        instance.must((c.fmi2FreeFMUstate)(i, null_mut()));
    }
}

#[test]
fn damaged_states_are_refused() {
    let instance = touching();
    let (bytes, now) = (instance.bytes(), instance.everything());
    for length in 0..bytes.len() {
        instance.refused(instance.restore_bytes(&bytes[..length]));
    }
    for place in 0..bytes.len() {
        for bit in 0..8 {
            let mut damaged = bytes.clone();
            damaged[place] ^= 1 << bit;
            instance.refused(instance.restore_bytes(&damaged));
        }
    }
    assert_eq!(instance.everything(), now);
}

#[test]
fn a_state_of_another_version_is_refused_though_its_checksum_is_right() {
    let instance = touching();
    let (bytes, now) = (instance.bytes(), instance.everything());
    for place in 8..12 {
        let mut other = bytes.clone();
        other[place] ^= 1;
        let end = other.len() - 4;
        let checksum = crc32fast::hash(&other[..end]);
        other[end..].copy_from_slice(&checksum.to_le_bytes());
        let message = instance.refused(instance.restore_bytes(&other));
        assert!(message.contains("another version"), "{message}");
    }
    assert_eq!(instance.everything(), now);
}

/// The directory may have gone since, or be another machine's.
#[test]
fn a_restored_state_finds_its_output_directory() {
    let directory = tempfile::tempdir().unwrap();
    let output = directory.path().join("made/by the FMU");
    let instance = Instance::new(Fmu::get());
    instance.must(instance.set_string("OutputDirectory", output.to_str().unwrap()));
    instance.push_and_initialize();
    instance.steps(0, 2);
    let bytes = instance.bytes();
    std::fs::remove_dir_all(directory.path().join("made")).unwrap();
    let other = Instance::new(Fmu::get());
    other.must(other.restore_bytes(&bytes));
    other.steps(2, 3);
    assert!(output.join("AgentDynamics output t=0.03.xml").is_file());
    // Where it cannot be made the state is refused, and nothing has changed.
    std::fs::remove_dir_all(directory.path().join("made")).unwrap();
    std::fs::write(directory.path().join("made"), "a file").unwrap();
    let (third, fresh) = (Instance::new(Fmu::get()), Instance::new(Fmu::get()));
    let message = third.refused(third.restore_bytes(&bytes));
    assert!(message.contains("OutputDirectory") && message.contains("by the FMU"), "{message}");
    assert!(third.bytes() == fresh.bytes());
}

/// Bytes that somebody made up, checksum and all: refused or run, but not a crash and no fatal fault.
#[test]
fn forged_states_do_not_crash() {
    let original = touching();
    let bytes = original.bytes();
    let end = bytes.len() - 4;
    let forge = |place: usize, byte: u8| {
        let mut forged = bytes.clone();
        forged[place] = byte;
        let checksum = crc32fast::hash(&forged[..end]);
        forged[end..].copy_from_slice(&checksum.to_le_bytes());
        forged
    };
    let mut accepted = 0;
    for (place, &was) in bytes[..end].iter().enumerate() {
        for byte in [0x00, 0x01, 0x7f, 0x80, 0xff, was ^ 0x10] {
            let instance = Instance::new(Fmu::get());
            let status = instance.restore_bytes(&forge(place, byte));
            let case = format!("byte {place} = {byte:#x}: {status}, {:?}", instance.log.take());
            assert!(status == OK || status == ERROR, "{case}");
            if status == OK {
                accepted += 1;
                // One mechanical step; whatever the phase and the time have become.
                let status = instance.try_step(MEETING as f64 * STEP, 1e-5);
                let log = instance.log.take();
                assert!(status == OK || status == ERROR, "{case}, then {status}, {log:?}");
                let (status, _) = instance.try_get("agent[4].NormalForce");
                let log = instance.log.take();
                assert!(status == OK || status == ERROR, "{case}, then {status}, {log:?}");
            }
        }
    }
    assert!(accepted > 0, "most numbers may be other numbers");
}

/// With a part replaced where it first stands, and the checksum that belongs to it.
fn forged(bytes: &[u8], from: &[u8], to: &[u8]) -> Vec<u8> {
    assert_eq!(from.len(), to.len());
    let place = bytes.windows(from.len()).position(|part| part == from).expect("it is there");
    let mut forged = bytes.to_vec();
    forged[place..place + to.len()].copy_from_slice(to);
    let end = forged.len() - 4;
    let checksum = crc32fast::hash(&forged[..end]);
    forged[end..].copy_from_slice(&checksum.to_le_bytes());
    forged
}

/// What `fmi2Set…` refuses, a state does not bring in.
#[test]
fn states_with_impossible_numbers_are_refused() {
    let original = touching();
    let bytes = original.bytes();
    let place = original.get("agent[1].Position.x");
    for (was, value, word) in [
        (1e-5, f64::NAN, "domain"),
        (1e-5, -1e-5, "domain"),
        ((MEETING - 1) as f64 * STEP + STEP, f64::INFINITY, "time"),
        (place, f64::NAN, "finite"),
        (700.0, f64::NEG_INFINITY, "domain"),
    ] {
        let forged = forged(&bytes, &was.to_le_bytes(), &value.to_le_bytes());
        let message = original.refused(original.restore_bytes(&forged));
        assert!(message.contains("damaged") && message.contains(word), "{was} {value}: {message}");
        assert!(original.bytes() == bytes);
    }
}

/// A state does not lead out of the resources, even to a Trial that is the same.
#[test]
fn states_name_packed_trials() {
    let resources = Resources::new();
    let instance = instantiate(Fmu::get(), &Model::paper().guid, &resources.uri()).unwrap();
    copy_tree(&paper(), &resources.root.path().join("outside"));
    let forged = forged(&instance.bytes(), b"Trial_push", b"../outside");
    let message = instance.refused(instance.restore_bytes(&forged));
    assert!(message.contains("must be one of the packed Trials: Trial_push"), "{message}");
}

#[test]
fn states_of_another_model_are_refused() {
    let ours = touching();
    let before = ours.bytes();
    let guid = &Model::paper().guid;

    // The same interface, other numbers: the state can be read, but not set.
    for (file, from, to) in [
        ("static/Agents.xml", "89.0", "88.0"),
        ("static/Materials.xml", "0.7e3", "0.8e3"),
        ("static/Geometry.xml", "-0.2,-0.57395", "-0.3,-0.57395"),
        ("dynamic/AgentDynamics.xml", "0.279", "0.289"),
        ("Parameters.xml", "0.05", "0.06"),
    ] {
        let resources = Resources::edited(file, from, to);
        let other = instantiate(Fmu::get(), guid, &resources.uri()).unwrap();
        let untouched = other.bytes();
        let message = other.refused(other.restore_bytes(&before));
        assert!(message.contains("another model") && message.contains("Trial_push"), "{message}");
        assert!(other.bytes() == untouched);
        let state = other.save();
        let message = ours.refused(unsafe { (ours.fmu.c.fmi2SetFMUstate)(ours.raw, state) });
        assert!(message.contains("another model"), "{message}");
        other.free_state(state);
    }

    // Another interface.
    let resources = fewer_agents();
    let guid = Model::of(&resources.trial()).guid;
    let other = instantiate(Fmu::get(), &guid, &resources.uri()).unwrap();
    let message = other.refused(other.restore_bytes(&before));
    assert!(message.contains("another model") && message.contains("GUID"), "{message}");
    let state = other.save();
    let message = ours.refused(unsafe { (ours.fmu.c.fmi2SetFMUstate)(ours.raw, state) });
    assert!(message.contains("another model"), "{message}");
    other.free_state(state);
    assert!(ours.bytes() == before);
}

/// The paper's Trial without its last agent.
fn fewer_agents() -> Resources {
    let resources = Resources::new();
    for file in ["static/Agents.xml", "dynamic/AgentDynamics.xml"] {
        let path = resources.trial().join(file);
        let text = std::fs::read_to_string(&path).unwrap();
        let (start, end) = (text.rfind("<Agent ").unwrap(), text.rfind("</Agents>").unwrap());
        std::fs::write(&path, text[..start].to_owned() + &text[end..]).unwrap();
    }
    resources
}

/// A state of a Trial that lies beside ours and has other variables: its Trial is found, and is what it
/// was, but it is no Trial of this FMU.
#[test]
fn a_state_of_a_neighbouring_trial_with_other_variables_is_refused() {
    let theirs = fewer_agents();
    let guid = Model::of(&theirs.trial()).guid;
    let other = instantiate(Fmu::get(), &guid, &theirs.uri()).unwrap();
    let state = other.save();

    let beside = Resources::new();
    copy_tree(&paper(), &beside.directory().join("A_first"));
    std::fs::remove_dir_all(beside.trial()).unwrap();
    copy_tree(&theirs.trial(), &beside.trial());
    let ours = instantiate(Fmu::get(), &Model::paper().guid, &beside.uri()).unwrap();
    let message = ours.refused(unsafe { (ours.fmu.c.fmi2SetFMUstate)(ours.raw, state) });
    assert!(message.contains("another model"), "{message}");
    other.free_state(state);
    ours.initialize();
    ours.everything();
}

/// Many at a time, freed in another order than made.
#[test]
fn many_states() {
    let instance = touching();
    let mut states = Vec::new();
    for k in MEETING..MEETING + 10 {
        states.push((instance.save(), instance.everything()));
        instance.steps(k, k + 1);
    }
    for (state, values) in states.iter().rev() {
        instance.must(unsafe { (instance.fmu.c.fmi2SetFMUstate)(instance.raw, *state) });
        assert_eq!(instance.everything(), *values);
    }
    for (state, _) in states {
        instance.free_state(state);
    }
}

/// Some importers free states by a wrong pointer.
#[test]
fn pointers_that_are_no_states_are_errors() {
    let instance = touching();
    let c = &instance.fmu.c;
    let (state, before) = (instance.save(), instance.bytes());
    let mut freed = state;
    instance.free_state(state);
    let mut bytes = [0; 10_000];
    for pointer in [freed, instance.raw, std::ptr::without_provenance_mut(16)] {
        let mut wrong = pointer;
        let messages = unsafe {
            [
                instance.refused((c.fmi2SetFMUstate)(instance.raw, wrong)),
                instance.refused((c.fmi2GetFMUstate)(instance.raw, &mut wrong)),
                instance.refused((c.fmi2SerializedFMUstateSize)(instance.raw, wrong, &mut 0)),
                instance.refused((c.fmi2SerializeFMUstate)(instance.raw, wrong, bytes.as_mut_ptr(), 10_000)),
                instance.refused((c.fmi2FreeFMUstate)(instance.raw, &mut wrong)),
            ]
        };
        assert!(messages.iter().all(|message| message.contains("not a state")), "{messages:?}");
        assert_eq!(wrong, pointer, "it is not changed");
    }
    instance.refused(unsafe { (c.fmi2FreeFMUstate)(instance.raw, &mut freed) });
    assert!(instance.bytes() == before);
}
