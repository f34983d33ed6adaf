//! What contacts do during a step, who stands in one place, and steps that nobody could wait for.

use crate::fmu::*;

fn of_agents(instance: &Instance, output: &str) -> Vec<f64> {
    (0..5).map(|i| instance.get(&format!("agent[{i}].{output}"))).collect()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

/// The push, in communication steps of a duration: the greatest sample, peak, LargestOverlap, and what the contacts'
/// impulse on agent 2 adds up to \[N.s\].
fn push(step: f64) -> [f64; 4] {
    let instance = Instance::new(Fmu::get());
    instance.must(instance.set("TimeStepMechanical", 1e-5));
    instance.push_and_initialize();
    let steps = (0.5 / step).round() as usize;
    let (mut sample, mut peak, mut overlap, mut impulse) = (0.0f64, 0.0f64, 0.0f64, 0.0);
    for k in 0..steps {
        instance.must(instance.try_step(step * k as f64, step));
        let (samples, peaks) = (of_agents(&instance, "NormalForce"), of_agents(&instance, "PeakNormalForce"));
        let means = of_agents(&instance, "MeanNormalForce");
        for ((sample, peak), mean) in samples.iter().zip(&peaks).zip(&means) {
            assert!(sample <= peak && mean <= peak && *mean >= 0.0, "{sample} {mean} {peak}");
        }
        let deepest = instance.get("LargestOverlap");
        assert_eq!(deepest, largest(&of_agents(&instance, "PeakOverlap")));
        (sample, peak) = (sample.max(largest(&samples)), peak.max(largest(&peaks)));
        overlap = overlap.max(deepest);
        impulse += means[2] * step;
    }
    [sample, peak, overlap, impulse]
}

/// The greatest squeeze of a run was what a communication point happened to meet: 2.6 kN or 18.8 kN of one push.
#[test]
fn peaks_and_impulses_do_not_depend_on_the_communication_step() {
    let [sample, peak, overlap, impulse] = push(0.05);
    assert!(sample < 0.7 * peak, "the sample misses the peak: {sample} {peak}");
    for step in [0.01, 0.001] {
        let found = push(step);
        for (found, coarse) in found[1..].iter().zip([peak, overlap, impulse]) {
            assert!((found / coarse - 1.0).abs() < 2e-3, "{step}: {found} {coarse}");
        }
    }
}

#[test]
fn before_the_first_step_they_are_those_of_the_start() {
    let instance = Instance::new(Fmu::get());
    instance.must(instance.set("agent[1].Position.x", 0.2));
    instance.initialize();
    let squeeze = of_agents(&instance, "NormalForce");
    assert!(squeeze[0] > 1e4 && squeeze[4] == 0.0);
    assert_eq!(of_agents(&instance, "MeanNormalForce"), squeeze);
    assert_eq!(of_agents(&instance, "PeakNormalForce"), squeeze);
    let overlaps = of_agents(&instance, "PeakOverlap");
    assert!(overlaps[0] > 0.01 && overlaps[0] == overlaps[1] && overlaps[4] == 0.0, "{overlaps:?}");
}

/// One-disk agents whose centres coincide had no force for ever, and nobody said so.
#[test]
fn agents_at_one_place_are_counted_and_told() {
    let resources = Resources::new();
    let agent = |id: usize| {
        format!(
            r#"<Agent Type="pedestrian" Id="{id}" Mass="70" Height="1.7" MomentOfInertia="1" FloorDamping="4.5"
            AngularDamping="4.5"><Shape Type="disk" Radius="0.1" MaterialId="human_naked" Position="0,0"/></Agent>"#
        )
    };
    let agents: String = (0..5).map(agent).collect();
    std::fs::write(resources.trial().join("static/Agents.xml"), format!("<Agents>{agents}</Agents>"))
        .unwrap();
    let guid = &Model::of(&resources.trial()).guid;
    let instance = instantiate(Fmu::get(), guid, &resources.uri()).unwrap();
    // Agent 2 stands at (0.692, −0.067).
    let beside = [("agent[3].Position.x", 0.692 + 4e-10), ("agent[3].Position.y", -0.067)];
    instance.must(instance.set_all(&beside));
    instance.enter_initialization();
    let told = |status| {
        assert_eq!(status, OK);
        let messages = instance.log.take();
        messages.into_iter().filter(|message| message.text.contains("at one place")).map(|m| m.text).collect()
    };
    let said: Vec<String> = told(unsafe { (instance.fmu.c.fmi2ExitInitializationMode)(instance.raw) });
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(said[0].contains(r#"agents "2" and "3""#), "{said:?}");
    for k in 0..2 {
        let again = told(instance.try_step(0.05 * f64::from(k), 0.05));
        assert_eq!(again, [""; 0], "it is told once");
        assert_eq!(instance.get_integer("CoincidentContacts"), 1);
        assert_eq!(instance.get_integer("agent[2].AgentContacts"), 1);
        assert_eq!(instance.get_integer("agent[3].ContactingAgents"), 1);
        assert_eq!(instance.get("LargestOverlap"), 0.2);
    }
    // They part.
    instance.must(instance.set("agent[3].Fp.x", 300.0));
    instance.must(instance.try_step(0.1, 0.05));
    assert_eq!(instance.get_integer("CoincidentContacts"), 0);
}

/// It would run for hours, and `fmi2CancelStep` cannot reach a slave that steps synchronously.
#[test]
fn a_step_of_more_than_a_thousand_million_mechanical_steps_is_refused() {
    let instance = Instance::new(Fmu::get());
    instance.must(instance.set("TimeStepMechanical", 1e-5));
    instance.initialize();
    let message = instance.refused(instance.try_step(0.0, 50_000.0));
    for part in ["5000000000 mechanical steps", "MostMechanicalSteps = 1000000000"] {
        assert!(message.contains(part), "{message}");
    }
    // Refused before it began: the instance goes on.
    instance.must(instance.try_step(0.0, 0.05));

    let strict = Instance::new(Fmu::get());
    strict.must(strict.set_all(&[("TimeStepMechanical", 1e-3), ("MostMechanicalSteps", 50.0)]));
    strict.initialize();
    let state = strict.bytes();
    strict.refused(strict.try_step(0.0, 0.051));
    strict.must(strict.try_step(0.0, 0.05));
    strict.must(strict.restore_bytes(&state));
    strict.refused(strict.try_step(0.0, 0.051));
    assert_eq!(strict.get("MostMechanicalSteps"), 50.0);
}
