//! Structural parameters: Trials of different sizes share an FMU.

use crate::fmu::*;

fn configure(instance: &Instance, agents: u64) {
    instance.must(unsafe { (instance.c.fmi3EnterConfigurationMode)(instance.raw) });
    instance.must(instance.try_set_size("Agents", agents));
    instance.must(unsafe { (instance.c.fmi3ExitConfigurationMode)(instance.raw) });
}

#[test]
fn a_trial_of_another_size_is_chosen() {
    let instance = Instance::new();
    configure(&instance, 3);
    instance.must(instance.try_set_text("Trial", "Trial_three"));
    instance.enter_initialization();
    assert_eq!((instance.size("Agents"), instance.size("Materials")), (3, 3));
    instance.set("Fp", &[500.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    instance.must(unsafe { (instance.c.fmi3ExitInitializationMode)(instance.raw) });
    instance.steps(0, 8);
    assert_eq!(instance.texts("AgentId", 3), ["0", "1", "2"]);
    assert!(instance.get("Position", 6)[0] > 0.05);
    let message = instance.refused(instance.try_get("Position", 10).0);
    assert!(message.contains("10 values for variables of 6"), "{message}");
    // Back to the first.
    instance.must(unsafe { (instance.c.fmi3Reset)(instance.raw) });
    instance.initialize();
    assert_eq!(instance.size("Agents"), 5);
    instance.get("Position", 10);
}

#[test]
fn sizes_that_do_not_agree_are_an_error_that_says_both() {
    let words = "Agents is 3, but what is loaded has 5";
    let instance = Instance::new();
    configure(&instance, 3);
    let message = instance.refused(instance.try_set("Mass", &[80.0; 3]));
    assert!(message.contains(words), "{message}");
    instance.enter_initialization();
    let message = instance.refused(unsafe { (instance.c.fmi3ExitInitializationMode)(instance.raw) });
    assert!(message.contains(words), "{message}");
    // Either is mended.
    instance.must(instance.try_set_text("Trial", "Trial_three"));
    instance.must(unsafe { (instance.c.fmi3ExitInitializationMode)(instance.raw) });

    let instance = Instance::new();
    instance.must(instance.try_set_text("Trial", "Trial_three"));
    instance.enter_initialization();
    let message = instance.refused(unsafe { (instance.c.fmi3ExitInitializationMode)(instance.raw) });
    assert!(message.contains("Agents is 5, but what is loaded has 3"), "{message}");
}

#[test]
fn sizes_are_set_in_configuration_mode_only() {
    let instance = Instance::new();
    let message = instance.refused(instance.try_set_size("Agents", 3));
    assert!(message.contains("outside Configuration Mode"), "{message}");
    instance.must(unsafe { (instance.c.fmi3EnterConfigurationMode)(instance.raw) });
    for wrong in [0, u64::MAX] {
        let message = instance.refused(instance.try_set_size("Agents", wrong));
        assert!(message.contains(&format!("Agents = {wrong}")), "{message}");
    }
    let message = instance.refused(instance.try_set("Mass", &[80.0; 5]));
    assert!(message.contains("in Configuration Mode"), "{message}");
    instance.must(unsafe { (instance.c.fmi3ExitConfigurationMode)(instance.raw) });
    instance.initialize();
}

#[test]
fn values_of_agents_that_a_trial_does_not_have_are_not_lost_in_silence() {
    let instance = Instance::new();
    instance.set("Mass", &[80.0; 5]);
    let message = instance.refused(instance.try_set_text("Trial", "Trial_three"));
    assert!(message.contains("choose the Trial before its values"), "{message}");
}
