//! States lead back, also as bytes and with another Trial.

use crate::fmu::*;

#[test]
fn a_state_restored_runs_on_bit_for_bit() {
    let instance = Instance::new();
    instance.initialize();
    instance.push();
    instance.steps(0, 9);
    let (state, bytes) = (instance.save(), instance.bytes());
    instance.steps(9, 14);
    let expected = instance.motion();
    instance.must(unsafe { (instance.c.fmi3SetFMUState)(instance.raw, state) });
    instance.steps(9, 14);
    assert_eq!(instance.motion(), expected);
    instance.free(state);
    let other = Instance::new();
    other.must(other.restore(&bytes));
    other.steps(9, 14);
    assert_eq!(other.motion(), expected);
}

#[test]
fn a_state_brings_its_trial_and_sizes() {
    let three = Instance::new();
    three.must(unsafe { (three.c.fmi3EnterConfigurationMode)(three.raw) });
    three.must(three.try_set_size("Agents", 3));
    three.must(unsafe { (three.c.fmi3ExitConfigurationMode)(three.raw) });
    three.must(three.try_set_text("Trial", "Trial_three"));
    three.initialize();
    three.steps(0, 2);
    let bytes = three.bytes();
    let instance = Instance::new();
    instance.must(instance.restore(&bytes));
    assert_eq!((instance.size("Agents"), instance.texts("Trial", 1)), (3, vec!["Trial_three".into()]));
    instance.steps(2, 3);
    three.steps(2, 3);
    assert_eq!(instance.get("Position", 6), three.get("Position", 6));
}

#[test]
fn damaged_bytes_are_refused_and_change_nothing() {
    let instance = Instance::new();
    instance.initialize();
    let good = instance.bytes();
    for k in (0..good.len()).step_by(7) {
        let mut bytes = good.clone();
        bytes[k] ^= 0x55;
        let message = instance.refused(instance.restore(&bytes));
        assert!(message.contains("state"), "byte {k}: {message}");
        assert!(instance.restore(&good[..k]) != OK);
        instance.log.take();
    }
    for more in [1, 100] {
        let message = instance.refused(instance.restore(&[&good[..], &vec![0; more]].concat()));
        assert!(message.contains("bytes follow it"), "{message}");
    }
    assert!(instance.bytes() == good);
}

/// As often as hosts load an FMU in a thousand runs.
#[test]
fn loads_leave_nothing_behind() {
    let resident = || {
        let status = std::fs::read_to_string("/proc/self/status").unwrap();
        let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
        line.trim().trim_end_matches(" kB").parse::<i64>().unwrap()
    };
    let life = || {
        let fmu = Fmu::load();
        let instance = Instance::of(&fmu, None, false).unwrap();
        instance.initialize();
        instance.steps(0, 1);
        let state = instance.save();
        instance.free(state);
    };
    (0..100).for_each(|_| life());
    let before = resident();
    (100..1500).for_each(|_| life());
    let grown = resident() - before;
    // Other tests of this program run meanwhile.
    assert!(grown < 20_000, "{grown} kB more after 1400 further loads");
}
