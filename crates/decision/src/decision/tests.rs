use super::*;
use crate::WalkingModelName;
use crate::config::DecisionConfig;
use lemons_core::trial::{self, AgentDynamics, Trial};
use lemons_fmi::{Model, Phase};

pub(super) fn decision(config: &str) -> Decision {
    let person = |id: &str| (trial::Agent::new(id, 70.0, 1.3, [2.0, 4.0]), AgentDynamics::default());
    let trial = Trial::of(["0", "1"].map(person), Vec::new(), 0.05);
    Decision::new(Plan::of(&trial, &DecisionConfig::from_toml(config).unwrap()).unwrap())
}

#[test]
fn a_drive_beyond_all_numbers_is_an_error_that_names_it() {
    let mut decision = decision("waypoints = [{ x = 1, y = 0 }]");
    // An importer's, not a user's.
    decision.set(DecisionQuantity::DesiredSpeed, 0, 1.7e308, Phase::StepComplete);
    let error = decision.number(DecisionQuantity::Fp, 0).unwrap_err().to_string();
    assert!(error.contains("agent[0]") && error.contains("Fp.x"), "{error}");
}

#[test]
fn motivation_changes_at_its_time_and_a_saved_run_goes_on_alike() {
    let mut decision = decision(
        "model = \"rotational\"\nwaypoints = [{ x = 1, y = 2 }]\n\
         motivation = [{ time = 0.1, time_gap = 0.5 }, { time = 0.2, speed_factor = 0.5 },
         { time = 0.25, desired_speed = 2.0, speed_factor = 0.75 }]
         [agents.1]\ndesired_speed = 0.8",
    );
    let now = |decision: &Decision| {
        let [one, other] = [0, 1].map(|i| &decision.agents[i].walker);
        (one.time_gap, one.desired_speed, other.desired_speed)
    };
    let mut seen = Vec::new();
    for _ in 0..6 {
        seen.push(now(&decision));
        decision.pass(0.05).unwrap();
    }
    // A factor is of what each has; a desired speed is everybody's.
    let (before, after) = ((0.9, 1.34, 0.8), (0.5, 1.34, 0.8));
    assert_eq!(seen, [before, before, after, after, (0.5, 0.67, 0.4), (0.5, 1.5, 1.5)]);
    let mut other = decision.anew();
    other.restore(&decision.save()).unwrap();
    assert_eq!(other.save(), decision.save());
    assert_eq!(now(&decision.anew()), before);
}

#[test]
fn who_has_not_started_stands() {
    for model in WalkingModelName::ALL.iter().map(|model| model.name()) {
        let mut decision = decision(&format!(
            "model = \"{model}\"\nwaypoints = [{{ x = 5, y = 0 }}]\nstart = 0.1\n[agents.1]\nstart = 0"
        ));
        // Not where the other one is.
        decision.set(DecisionQuantity::Position, 1, 4.0, Phase::StepComplete);
        let mut seen = Vec::new();
        for _ in 0..4 {
            let [one, other] = [0, 2].map(|element| decision.number(DecisionQuantity::Fp, element).unwrap());
            seen.push((one.abs() > 1.0, other.abs() > 1.0));
            decision.pass(0.05).unwrap();
        }
        assert_eq!(seen, [(false, true), (false, true), (true, true), (true, true)], "{model}");
    }
}

#[test]
fn people_wait_at_way_points_and_a_saved_run_goes_on_alike() {
    for model in ["straight", "rotational"] {
        let mut decision = decision(&format!(
            "model = \"{model}\"\nwaypoints = [{{ x = 0.2, y = 0, wait = 0.2 }}, {{ x = 5, y = 0 }}]\n\
             [agents.1]\nwaypoints = [{{ x = 0, y = 9 }}]"
        ));
        decision.set(DecisionQuantity::Position, 3, 4.0, Phase::StepComplete);
        let mut seen = Vec::new();
        let mut other = decision.anew();
        for k in 0..6 {
            // Pushed away while it waits: it has been there.
            if k == 2 {
                decision.set(DecisionQuantity::Position, 0, -1.0, Phase::StepComplete);
                other.restore(&decision.save()).unwrap();
            }
            let next = decision.number(DecisionQuantity::NextWaypoint, 0).unwrap();
            seen.push((next, decision.number(DecisionQuantity::Fp, 0).unwrap() > 1.0));
            decision.pass(0.05).unwrap();
            if k >= 2 {
                other.pass(0.05).unwrap();
            }
        }
        let (waits, walks) = ((0.0, false), (1.0, true));
        assert_eq!(seen, [waits, waits, waits, waits, walks, walks], "{model}");
        assert!(other.save() == decision.save());
    }
}

#[test]
fn speeds_and_starts_are_drawn_with_the_seed() {
    let drawn = |seed: u32| {
        let decision = decision(&format!(
            "seed = {seed}\nwaypoints = [{{ x = 5, y = 0 }}]\nstart = {{ min = 10, max = 100 }}\n\
             desired_speed = {{ mean = 1.34, sd = 0.26, min = 0.5, max = 2 }}\n[agents.1]\nstart = 3"
        ));
        let [one, other] = [0, 1].map(|i| &decision.agents[i].walker);
        (one.start, other.start, one.desired_speed, other.desired_speed)
    };
    let (start, own, one, other) = drawn(1);
    assert!((10.0..100.0).contains(&start) && own == 3.0 && one != other && (0.5..2.0).contains(&one));
    assert!(drawn(1) == drawn(1) && drawn(1) != drawn(2));
    let refused = |text: &str| {
        let config = DecisionConfig::from_toml(&format!("waypoints = [{{ x = 5, y = 0 }}]\n{text}")).unwrap();
        Plan::of(&Trial::of([], Vec::new(), 0.05), &config).unwrap_err().to_string()
    };
    let message = refused("start = { min = 2, max = 1 }");
    assert_eq!(message, "everybody: start: min = 2, max = 1: min must be below max");
    let message = refused("desired_speed = { mean = 9, sd = 1, min = 1, max = 2 }");
    assert!(message.contains("more than 6 standard deviations"), "{message}");
    assert!(refused("start = -1").contains("from 0 to 1e9"));
}

#[test]
fn states_with_impossible_numbers_or_of_another_plan_are_refused() {
    let mut decision = decision("waypoints = [{ x = 1, y = 2 }]");
    let good = decision.save();
    let forgeries: [fn(&mut AgentState); 6] = [
        |agent| agent.legs.at.x = f64::INFINITY,
        |agent| agent.pose.position.x = f64::NAN,
        |agent| agent.walker.mass = 0.0,
        |agent| agent.walker.waypoints[0].radius = -1.0,
        |agent| agent.choice.exit = Some(0),
        |agent| agent.choice.turn = f64::NAN,
    ];
    for forge in forgeries {
        let mut forged = good.clone();
        forge(&mut forged.agents[0]);
        assert!(decision.restore(&forged).is_err(), "{forged:?}");
        assert_eq!(decision.save(), good);
    }
    let other = self::decision("waypoints = [{ x = 1, y = 3 }]").save();
    assert!(decision.restore(&other).unwrap_err().message.contains("another Trial or decision.toml"));
    decision.restore(&good).unwrap();
}

#[test]
fn who_insists_keeps_turned_shoulders() {
    let mut decision = decision("model = \"rotational\"\nwaypoints = [{ x = 5, y = 0 }]");
    // Close to the other one.
    decision.set(DecisionQuantity::Position, 2, 0.5, Phase::StepComplete);
    decision.set(DecisionQuantity::Position, 3, 0.3, Phase::StepComplete);
    let (way, speed) = decision.goes(0).unwrap();
    let turned = decision.intent(0).facing.unwrap();
    assert!(turned.dot(&way) < 0.9, "{turned}");
    let stuck = &mut decision.agents[0].stuck;
    while !matches!(stuck.action(way, speed), StuckAction::Insist(_)) {
        stuck.follow(1.0, Vec2::zeros(), Some((way, speed)), 0, 0);
    }
    assert_eq!(decision.intent(0).facing, Some(turned));
}
