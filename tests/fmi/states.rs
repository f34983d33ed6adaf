//! FMU states: saved in the middle of a contact, restored anywhere, damaged in every way.

use crate::fmu::*;
use crate::lifecycle::{reach, states};
use std::ffi::c_void;
use std::ptr::null_mut;

/// Steps until agent 0 has met agent 1.
const MEETING: usize = 10;

/// An instance in the middle of a contact, with parameters that are not the Trial's.
fn touching(version: Version) -> Crowd {
    let crowd = Crowd::new(version);
    // Parameters other than the Trial's, and a push so that springs stretch.
    crowd.must(crowd.set_all(&[
        ("contact.human_naked.human_naked.KineticFriction", 0.9),
        ("material.human_naked.YoungModulus", 4.1e6),
        ("agent[2].Mass", 60.0),
        ("agent[0].Fp.y", 40.0),
    ]));
    crowd.push_and_initialize();
    crowd.steps(0, MEETING);
    assert!(crowd.integer("AgentContacts") > 0 && crowd.get("agent[1].NormalForce") > 0.0);
    crowd
}

/// Returns what comes after the meeting, step by step; the drive changes on the way.
fn future(crowd: &Crowd) -> Vec<Bits> {
    let seen = (MEETING..MEETING + 20).map(|k| {
        if k == MEETING + 10 {
            crowd.must(crowd.set_all(&[("agent[0].Fp.x", -200.0), ("agent[2].Mp", 3.0)]));
        }
        crowd.steps(k, k + 1);
        crowd.everything()
    });
    seen.collect()
}

#[test]
fn a_state_runs_on_bit_for_bit_wherever_it_is_restored() {
    for version in BOTH {
        let crowd = touching(version);
        let (state, bytes, now) = (crowd.save(), crowd.bytes(), crowd.everything());
        let expected = future(&crowd);
        assert_ne!(expected[19], now);
        crowd.must(crowd.set_state(state));
        assert_eq!(future(&crowd), expected, "in the same instance");
        // In others: fresh, with other parameters, further, over.
        let others: [fn(&Crowd); 4] = [
            |_| (),
            |other| other.must(other.set_all(&[("agent[0].Mass", 120.0), ("agent[3].Position.x", 1.2)])),
            |other| {
                other.push_and_initialize();
                other.steps(0, 20);
            },
            |other| {
                other.initialize();
                other.must(other.terminate());
            },
        ];
        for prepare in others {
            let other = Crowd::new(version);
            prepare(&other);
            other.must(other.set_state(state));
            assert_eq!(other.everything(), now);
            assert_eq!(future(&other), expected);
        }
        crowd.free(state);
        // As bytes it outlives its instance.
        drop(crowd);
        let other = Crowd::new(version);
        other.must(other.restore(&bytes));
        assert!(other.everything() == now && other.bytes() == bytes);
        assert_eq!(future(&other), expected);
        // In FMI 2.0 importers may keep it in a longer buffer.
        for more in [1, 100] {
            let status = other.restore(&[&bytes[..], &vec![0xAA; more]].concat());
            if version == V2 {
                other.must(status);
                assert_eq!(future(&other), expected);
            } else {
                assert!(other.refused(status).contains("bytes follow it"));
            }
        }
    }
}

/// Before the world exists, and again in each state of the lifecycle.
#[test]
fn states_of_every_phase() {
    for version in BOTH {
        for phase in states(version) {
            let saved = reach(version, phase).bytes();
            for other in states(version) {
                let crowd = reach(version, other);
                crowd.must(crowd.restore(&saved));
                assert!(crowd.bytes() == saved, "{phase:?} in {other:?}");
            }
        }
    }
}

#[test]
fn state_pointers() {
    for version in BOTH {
        let crowd = touching(version);
        let mut state = crowd.save();
        let place = state;
        crowd.steps(MEETING, MEETING + 1);
        let later = crowd.everything();
        // A state that is not NULL is overwritten in its place.
        crowd.must(crowd.get_state(&mut state));
        assert_eq!(state, place);
        crowd.steps(MEETING + 1, MEETING + 2);
        crowd.must(crowd.set_state(state));
        assert_eq!(crowd.everything(), later);
        // So it is by bytes; refused ones leave it alone.
        let bytes = crowd.bytes();
        crowd.must(crowd.deserialize(&bytes, &mut state));
        assert_eq!(state, place);
        crowd.refused(crowd.deserialize(&bytes[..3], &mut state));
        assert_eq!(state, place);
        crowd.must(crowd.set_state(state));
        assert_eq!(crowd.everything(), later);
        // A buffer one byte short.
        let short = bytes.len() - 1;
        let (status, buffer) = crowd.serialize(state, short);
        let message = crowd.refused(status);
        let numbers = [short, bytes.len()].map(|number| number.to_string());
        assert!(numbers.iter().all(|number| message.contains(number)), "{message}");
        assert!(buffer.iter().all(|byte| *byte == 0xEE));
        crowd.free(state);
    }
}

/// Many at a time, freed in another order than made; and some importers free states by a wrong pointer.
#[test]
fn many_states_and_pointers_that_are_none() {
    let crowd = touching(V2);
    let mut states = Vec::new();
    for k in MEETING..MEETING + 10 {
        states.push((crowd.save(), crowd.everything()));
        crowd.steps(k, k + 1);
    }
    for (state, values) in states.iter().rev() {
        crowd.must(crowd.set_state(*state));
        assert_eq!(crowd.everything(), *values);
    }
    states.iter().for_each(|(state, _)| crowd.free(*state));
    let before = crowd.bytes();
    for pointer in [states[3].0, crowd.raw, std::ptr::without_provenance_mut(16)] {
        let mut wrong: *mut c_void = pointer;
        let messages = [
            crowd.refused(crowd.set_state(wrong)),
            crowd.refused(crowd.get_state(&mut wrong)),
            crowd.refused(crowd.serialized_size(wrong).0),
            crowd.refused(crowd.serialize(wrong, 10_000).0),
            crowd.refused(crowd.free_state(&mut wrong)),
        ];
        assert!(messages.iter().all(|message| message.contains("not a state")), "{messages:?}");
        assert_eq!(wrong, pointer, "it is not changed");
    }
    assert!(crowd.bytes() == before);
}

/// Returns bytes with the checksum that belongs to them.
fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let end = bytes.len() - 4;
    let checksum = crc32fast::hash(&bytes[..end]);
    bytes[end..].copy_from_slice(&checksum.to_le_bytes());
    bytes
}

/// Returns bytes with a part replaced where it first stands, and the checksum that belongs to it.
fn forged(bytes: &[u8], from: &[u8], to: &[u8]) -> Vec<u8> {
    assert_eq!(from.len(), to.len());
    let place = bytes.windows(from.len()).position(|part| part == from).expect("it is there");
    let mut forged = bytes.to_vec();
    forged[place..place + to.len()].copy_from_slice(to);
    sealed(forged)
}

#[test]
fn damaged_states_are_refused() {
    for version in BOTH {
        let crowd = touching(version);
        let (bytes, now) = (crowd.bytes(), crowd.everything());
        for length in 0..bytes.len() {
            crowd.refused(crowd.restore(&bytes[..length]));
        }
        for place in 0..bytes.len() {
            for bit in 0..8 {
                let mut damaged = bytes.clone();
                damaged[place] ^= 1 << bit;
                crowd.refused(crowd.restore(&damaged));
            }
        }
        // Of another version, though its checksum is right.
        for place in 8..12 {
            let mut other = bytes.clone();
            other[place] ^= 1;
            let message = crowd.refused(crowd.restore(&sealed(other)));
            assert!(message.contains("another version"), "{message}");
        }
        assert_eq!(crowd.everything(), now);
    }
}

/// Values that setting refuses, a state does not bring in; nor does it lead out of the resources.
#[test]
fn states_with_impossible_content_are_refused() {
    /// Where the content begins: phase, time, the experiment's start and stop, sizes.
    const CONTENT: usize = 36;
    for version in BOTH {
        let original = touching(version);
        let bytes = original.bytes();
        let place = original.get("agent[1].Position.x");
        let squeeze = original.get("agent[1].PeakNormalForce");
        let by_value = [
            (1e-5, f64::NAN, "domain"),
            (1e-5, -1e-5, "domain"),
            ((MEETING - 1) as f64 * STEP + STEP, f64::INFINITY, "time"),
            (place, f64::NAN, "finite"),
            (squeeze, f64::INFINITY, "finite"),
            (700.0, f64::NEG_INFINITY, "domain"),
        ]
        .map(|(was, value, word)| (forged(&bytes, &was.to_le_bytes(), &value.to_le_bytes()), word));
        let by_place = [
            (0, &[4][..], "phase"),
            (10, &f64::NAN.to_le_bytes(), "time"),
            (10, &f64::INFINITY.to_le_bytes(), "time"),
            // FMI 2.0 has no sizes: there the model begins.
            (20, &[0], if version == V3 { "sizes" } else { "malformed" }),
        ]
        .map(|(at, wrong, word)| {
            let mut forged = bytes.clone();
            forged[CONTENT + at..][..wrong.len()].copy_from_slice(wrong);
            (sealed(forged), word)
        });
        for (forged, word) in by_value.into_iter().chain(by_place) {
            let message = original.refused(original.restore(&forged));
            assert!(message.contains("damaged") && message.contains(word), "{word}: {message}");
            assert!(original.bytes() == bytes);
        }
    }
    let resources = Resources::new();
    let crowd = Crowd::on(V2, &resources);
    copy_tree(&paper(), &resources.root.path().join("outside"));
    let message = crowd.refused(crowd.restore(&forged(&crowd.bytes(), b"Trial_push", b"../outside")));
    assert!(message.contains("must be one of the packed Trials: Trial_push"), "{message}");
}

/// The directory may have gone since, or be another machine's.
#[test]
fn a_restored_state_finds_its_output_directory() {
    let directory = tempfile::tempdir().unwrap();
    let output = directory.path().join("made/by the FMU");
    let crowd = Crowd::new(V2);
    crowd.must(crowd.set_text("OutputDirectory", output.to_str().unwrap()));
    crowd.push_and_initialize();
    crowd.steps(0, 2);
    let bytes = crowd.bytes();
    std::fs::remove_dir_all(directory.path().join("made")).unwrap();
    let other = Crowd::new(V2);
    other.must(other.restore(&bytes));
    other.steps(2, 3);
    assert!(output.join("AgentDynamics output t=0.03.xml").is_file());
    // Where it cannot be made the state is refused, and nothing has changed.
    std::fs::remove_dir_all(directory.path().join("made")).unwrap();
    std::fs::write(directory.path().join("made"), "a file").unwrap();
    let (third, fresh) = (Crowd::new(V2), Crowd::new(V2));
    let message = third.refused(third.restore(&bytes));
    assert!(message.contains("OutputDirectory") && message.contains("by the FMU"), "{message}");
    assert!(third.bytes() == fresh.bytes());
}

/// A state from elsewhere, as bytes and as a pointer, is refused by both instances.
#[track_caller]
fn foreign(ours: &Crowd, other: &Crowd, words: &str) {
    let (before, untouched) = (ours.bytes(), other.bytes());
    let message = other.refused(other.restore(&before));
    assert!(message.contains("another model") && message.contains(words), "{message}");
    let state = other.save();
    let message = ours.refused(ours.set_state(state));
    assert!(message.contains("another model"), "{message}");
    other.free(state);
    assert!(ours.bytes() == before && other.bytes() == untouched);
}

#[test]
fn states_of_another_model_are_refused() {
    let ours = touching(V2);
    // The same interface, other numbers: the state can be read, but not set.
    for (file, from, to) in [
        ("static/Agents.xml", "89.0", "88.0"),
        ("static/Materials.xml", "0.7e3", "0.8e3"),
        ("static/Geometry.xml", "-0.2,-0.57395", "-0.3,-0.57395"),
        ("dynamic/AgentDynamics.xml", "0.279", "0.289"),
        ("Parameters.xml", "0.05", "0.06"),
    ] {
        foreign(&ours, &Crowd::on(V2, &Resources::edited(file, from, to)), "Trial_push");
    }
    // Another interface.
    let resources = Resources::with_fewer("Trial_push", 4);
    let token = Model::of(&resources.trial(), V2).token;
    let other = instantiate(Fmu::get(), V2, &token, &V2.location(&resources.directory())).unwrap();
    foreign(&ours, &other, "GUID");
    // A Trial that lies beside ours, and is what it was, but is no Trial of this FMU.
    let beside = Resources::new();
    beside.add("A_first", "0.279,0.030");
    copy_tree(&resources.directory(), &beside.directory());
    let ours = Crowd::on(V2, &beside);
    let (state, mut none) = (other.save(), null_mut());
    let message = ours.refused(ours.set_state(state));
    assert!(message.contains("another model"), "{message}");
    other.free(state);
    ours.must(ours.free_state(&mut none));
    ours.initialize();
}
