//! What contacts do during a step, and who stands in one place.

use crate::fmu::*;

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

/// Peaks and means of a step are not what a communication point happens to meet.
#[test]
fn contacts_between_communication_points_are_seen() {
    let crowd = Crowd::pushed(V2);
    let (mut sample, mut peak) = (0.0f64, 0.0f64);
    for k in 0..10 {
        crowd.must(crowd.try_step(0.05 * f64::from(k), 0.05));
        let [samples, peaks, means] =
            ["NormalForce", "PeakNormalForce", "MeanNormalForce"].map(|name| crowd.of_agents(name));
        assert!((0..AGENTS).all(|i| samples[i].max(means[i]) <= peaks[i] && means[i] >= 0.0));
        assert_eq!(crowd.get("LargestOverlap"), largest(&crowd.of_agents("PeakOverlap")));
        (sample, peak) = (sample.max(largest(&samples)), peak.max(largest(&peaks)));
    }
    assert!(sample < 0.7 * peak, "the sample misses the peak: {sample} {peak}");
}

#[test]
fn before_the_first_step_they_are_those_of_the_start() {
    let crowd = Crowd::new(V2);
    crowd.must(crowd.set("agent[1].Position.x", 0.2));
    crowd.initialize();
    let squeeze = crowd.of_agents("NormalForce");
    assert!(squeeze[0] > 1e4 && squeeze[4] == 0.0);
    assert_eq!(crowd.of_agents("MeanNormalForce"), squeeze);
    assert_eq!(crowd.of_agents("PeakNormalForce"), squeeze);
    assert_eq!(crowd.of_agents("MeanPeopleForce"), squeeze);
    let overlaps = crowd.of_agents("PeakOverlap");
    assert!(overlaps[0] > 0.01 && overlaps[0] == overlaps[1] && overlaps[4] == 0.0, "{overlaps:?}");
}

/// The last agent is pushed to the wall before it; in FMI 3.0 also with values within steps.
#[test]
fn walls_get_what_they_give() {
    let of_walls =
        |crowd: &Crowd, name: &str| (0..4).map(|k| crowd.get(&format!("wall[{k}].{name}"))).collect();
    for (version, parts) in [(V2, 0), (V3, 0), (V3, 700)] {
        let crowd = Crowd::new(version);
        if parts > 0 {
            crowd.must(crowd.try_integer("IntermediateSteps", parts));
        }
        crowd.must(crowd.set("agent[4].Fp.x", 800.0));
        crowd.must(crowd.set("agent[4].Position.x", 1.61));
        crowd.initialize();
        let mut pressed = 0;
        for k in 0..40 {
            let (on, most): (Vec<f64>, Vec<f64>) =
                (of_walls(&crowd, "MeanNormalForce"), of_walls(&crowd, "PeakNormalForce"));
            let [all, people, walls] =
                ["MeanNormalForce", "MeanPeopleForce", "MeanWallForce"].map(|name| crowd.of_agents(name));
            let sum: f64 = walls.iter().sum();
            assert!((on.iter().sum::<f64>() - sum).abs() <= 1e-12 * sum, "{on:?} {walls:?}");
            assert!((0..AGENTS).all(|i| (people[i] + walls[i] - all[i]).abs() <= 1e-15 * all[i]));
            assert!((0..4).all(|k| most[k] >= on[k]) && (k > 0 || on[1] > 1e3), "{on:?} {most:?}");
            assert!(people[4] == 0.0 && walls[..4] == [0.0; 4], "{people:?} {walls:?}");
            pressed += usize::from(walls[4] > 0.0);
            crowd.must(crowd.try_step(0.01 * f64::from(k), 0.01));
        }
        assert!(pressed > 3, "{pressed}");
        let other = Crowd::new(version);
        other.must(other.restore(&crowd.bytes()));
        assert_eq!(other.everything(), crowd.everything());
    }
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
    let file = resources.trial().join("static/Agents.xml");
    std::fs::write(file, format!("<Agents>{agents}</Agents>")).unwrap();
    let crowd = Crowd::on(V2, &resources);
    // Agent 2 stands at (0.692, −0.067).
    let beside = [("agent[3].Position.x", 0.692 + 4e-10), ("agent[3].Position.y", -0.067)];
    crowd.must(crowd.set_all(&beside));
    crowd.enter_initialization();
    let told = |status: Status| -> Vec<String> {
        assert_eq!(status, OK);
        let texts = crowd.take_messages().into_iter().map(|message| message.text);
        texts.filter(|text| text.contains("at one place")).collect()
    };
    let messages = told(crowd.exit());
    assert!(messages.len() == 1 && messages[0].contains(r#"agents "2" and "3""#), "{messages:?}");
    for k in 0..2 {
        assert_eq!(told(crowd.try_step(0.05 * f64::from(k), 0.05)), [""; 0], "it is told once");
        let counts = ["CoincidentContacts", "agent[2].AgentContacts", "agent[3].ContactingAgents"];
        assert_eq!(counts.map(|name| crowd.integer(name)), [1; 3]);
        assert_eq!(crowd.get("LargestOverlap"), 0.2);
    }
    // They part.
    crowd.must(crowd.set("agent[3].Fp.x", 300.0));
    crowd.must(crowd.try_step(0.1, 0.05));
    assert_eq!(crowd.integer("CoincidentContacts"), 0);
}
