//! Groups, without FMUs: bodies whose velocities relax as eq. 1 says, without contacts.

use lemons_core::plane::{Motion, Vec2, vec2};
use lemons_core::trial::{Agent, AgentDynamics, Trial, Wall};
use lemons_decision::plan::Planned;
use lemons_decision::{Decision, DecisionConfig, Plan, WalkingModelName};
use lemons_fmi::Model;

const STEP: f64 = 0.02;
fn models() -> impl Iterator<Item = &'static str> {
    WalkingModelName::ALL.iter().map(|model| model.name())
}

type Person = (Agent, AgentDynamics);

fn person(id: usize, x: f64, y: f64) -> Person {
    let disks = [[0.0, 0.11, 0.12], [0.0, 0.0, 0.12], [0.0, -0.11, 0.12]];
    let agent = Agent::new(id.to_string(), 80.0, 1.5, [4.0, 4.0]).with_disks(&disks);
    (agent, AgentDynamics { position: vec2(x, y), ..AgentDynamics::default() })
}

const FAR: &str = "exits = [{ line = [[45, -10], [45, 10]] }]\n";

fn plan(walls: &[Vec<Vec2>], people: &[Person], config: &str) -> Plan {
    let config = DecisionConfig::from_toml(config).unwrap();
    let walls = walls.iter().map(|wall| Wall::new("", "", wall.clone())).collect();
    Plan::of(&Trial::of(people.to_vec(), walls, STEP), &config).unwrap()
}

/// Walks for some time \[s\]; the places of everybody at each step. A state is saved and restored on the way.
fn walk(plan: Plan, seconds: f64) -> Vec<Vec<Vec2>> {
    let of = |agent: &Planned| Motion { pose: agent.pose, ..Motion::default() };
    let mut motions: Vec<Motion> = plan.agents.iter().map(of).collect();
    let mut decision = Decision::new(plan);
    let mut places = Vec::new();
    for step in 0..(seconds / STEP) as usize {
        decision.see(motions.iter().copied());
        let acts = decision.acts().unwrap();
        if step % 50 == 25 {
            let saved = decision.save();
            decision.pass(STEP).unwrap();
            let after = decision.save();
            decision.restore(&saved).unwrap();
            decision.pass(STEP).unwrap();
            assert_eq!(decision.save(), after);
        } else {
            decision.pass(STEP).unwrap();
        }
        for (Motion { pose, twist }, act) in motions.iter_mut().zip(acts) {
            twist.velocity += (Vec2::from(act.drive.force) * (1.0 / 80.0) - twist.velocity * 4.0) * STEP;
            pose.position += twist.velocity * STEP;
        }
        places.push(motions.iter().map(|motion| motion.pose.position).collect());
    }
    places
}

/// The outside: the formulas of Moussaïd et al. 2010, by hand.
#[test]
fn who_would_have_to_turn_the_head_slows_down() {
    // A desired speed of 1.34 m/s, and the other one 0.9 m away, 30° further behind than across: no attraction yet.
    let behind = vec2(-0.45, 0.9 * 0.75f64.sqrt());
    let config = format!("{FAR}groups.members = [[\"0\", \"1\"]]");
    let velocity = |other: Vec2, config: &str| {
        let people = [person(0, 0.0, 0.0), person(1, other.x, other.y)];
        let act = Decision::new(plan(&[], &people, config)).acts().unwrap()[0];
        Vec2::from(act.drive.force) * (1.0 / 320.0)
    };
    let expected = 1.34 / (1.0 + 0.5 * 4.0 * std::f64::consts::FRAC_PI_6);
    let found = velocity(behind, &config);
    assert!(
        (found.norm() - expected).abs() < 1e-3 && (velocity(behind, FAR).norm() - 1.34).abs() < 1e-9,
        "{found:?}"
    );
    // Side by side, 4 m apart: β₂ τ to the centre is more than half of the desired speed, which nobody exceeds.
    let found = velocity(vec2(0.0, 4.0), &config);
    assert!((found.norm() - 1.34).abs() < 1e-9 && (found.y / found.x - 0.5).abs() < 1e-6, "{found:?}");
    // Nearer than 0.8 m, beyond a range of 0.3 m: β₃ τ away.
    let found = velocity(vec2(0.0, 0.4), &config);
    assert!((found.y / found.x + 0.5 / 1.34).abs() < 1e-6, "{found:?}");
    // 5 m behind: nobody walks back.
    assert!(velocity(vec2(-5.0, 0.0), &config).norm() < 1e-9);
    // The other one is 1 m behind, and behind a wall, by the way around it, so far that nobody goes on.
    let wall = vec![vec2(1.0, -3.0), vec2(1.0, 3.0)];
    let people = [person(0, 0.5, 0.0), person(1, 1.5, 0.0)];
    let speed = |walls: &[Vec<Vec2>]| {
        Decision::new(plan(walls, &people, &config)).acts().unwrap()[1].drive.force[0] / 320.0
    };
    let expected = 1.34 / (1.0 + 0.5 * 4.0 * std::f64::consts::FRAC_PI_2);
    let [open, hidden] = [speed(&[]), speed(&[wall])];
    assert!((open - expected).abs() < 1e-3 && hidden.abs() < 1e-9, "{open} {hidden}");
}

#[test]
fn a_group_walks_side_by_side_at_the_speed_of_the_slowest() {
    for model in models() {
        let config = format!(
            "model = {model:?}\n{FAR}groups.members = [[\"0\", \"1\", \"2\"]]\n[agents.0]\ndesired_speed = 0.9\n\
             [agents.1]\ndesired_speed = 1.6"
        );
        let people = [person(0, 0.0, 0.0), person(1, 2.5, 0.8), person(2, 0.5, 1.6), person(3, 0.0, -9.0)];
        let places = walk(plan(&[], &people, &config), 30.0);
        let [half, end] = [places.len() / 2, places.len() - 1];
        let speed = |who: usize| (places[end][who].x - places[half][who].x) / 15.0;
        for who in 0..3 {
            assert!((0.65..0.91).contains(&speed(who)), "{model}: {who} {}", speed(who));
            // Attraction begins at 1 m from the centre.
            let centre = (places[end][0] + places[end][1] + places[end][2]) * (1.0 / 3.0);
            let far = (places[end][who] - centre).norm();
            assert!(far < 1.5, "{model}: {far}");
        }
        assert!((speed(3) - 1.34).abs() < 0.01, "{model}: {}", speed(3));
    }
}

#[test]
fn who_is_ahead_waits_and_without_a_group_does_not() {
    for model in models() {
        let apart = |groups: &str| {
            let people = [person(0, 0.0, 0.0), person(1, 8.0, 1.0)];
            let places = walk(plan(&[], &people, &format!("model = {model:?}\n{FAR}{groups}")), 20.0);
            (places.last().unwrap()[1] - places.last().unwrap()[0]).norm()
        };
        let (together, alone) = (apart("groups.members = [[\"0\", \"1\"]]"), apart(""));
        assert!(together < 1.6 && alone > 7.5, "{model}: {together} m, {alone} m");
    }
}

/// Those in front of a closed door, of two groups that stand in each other's way.
#[test]
fn groups_that_hold_each_other_up_go_on() {
    let config = format!("model = \"rotational\"\n{FAR}groups.members = [[\"0\", \"2\"], [\"1\", \"3\"]]");
    let people = [person(0, 6.0, 0.0), person(1, 5.4, 0.0), person(2, 4.8, 0.0), person(3, 4.2, 0.0)];
    let wall = |y: f64| vec![vec2(0.0, y), vec2(40.0, y)];
    let places = walk(plan(&[wall(-0.35), wall(0.35)], &people, &config), 30.0);
    let last = places.last().unwrap();
    assert!(last.iter().all(|at| at.x > 12.0), "{last:?}");
}

#[test]
fn a_group_starts_together_and_takes_one_exit() {
    let exits = "exits = [{ name = \"left\", line = [[-10, 0], [-10, 4]] }, { name = \"right\", line = [[10, 0], [10, 4]] }]\n";
    let members = "groups.members = [[\"0\", \"1\"]]\n";
    // On either side of the middle.
    let people = [person(0, -0.5, 2.0), person(1, 0.5, 2.0), person(2, 6.0, 2.0)];
    let ends = |config: &str| {
        walk(plan(&[], &people, config), 9.0).last().unwrap().iter().map(|at| at.x).collect::<Vec<f64>>()
    };
    let (apart, together) = (ends(exits), ends(&format!("{exits}{members}")));
    assert!(apart[0] < -9.0 && apart[1] > 9.0, "{apart:?}");
    assert!(together[0] < -5.0 && together[1] < -5.0 && together[2] > 9.0, "{together:?}");
    // The exit of whoever has one.
    let own = ends(&format!("{exits}{members}[agents.1]\nexit = \"right\"\n"));
    assert!(own[0] > 5.0 && own[1] > 5.0, "{own:?}");
    // The last one's start.
    let places = walk(plan(&[], &people, &format!("{exits}{members}agents.1.start = 2.0")), 3.0);
    for who in [0, 1] {
        let begins =
            places.iter().position(|at| (at[who].x - people[who].1.position.x).abs() > 1e-6).unwrap();
        assert!((begins as f64 * STEP - 2.0).abs() < 2.0 * STEP, "{who}: {begins}");
    }
    // By shares, and by the expected time.
    for config in [exits.replace("]] }", "]], share = 1 }"), format!("exit_choice = \"time\"\n{exits}")] {
        for seed in 0..8 {
            let ends = ends(&format!("seed = {seed}\n{config}{members}"));
            assert_eq!(ends[0] > 0.0, ends[1] > 0.0, "{config}: {ends:?}");
        }
    }
}

/// The outside: the shares of sizes that are asked for.
#[test]
fn groups_are_drawn_from_those_who_are_near() {
    let people: Vec<Person> = (0..2000).map(|k| person(k, (k % 50) as f64, (k / 50) as f64)).collect();
    let drawn =
        |config: &str| plan(&[], &people, &format!("waypoints = [{{ x = 1, y = 1 }}]\n{config}")).groups;
    let groups = drawn("groups = { share = 0.5, sizes = [6, 3, 1] }\nseed = 3");
    let count = |size: usize| groups.iter().filter(|group| group.len() == size).count() as f64;
    let all = groups.len() as f64;
    assert_eq!(groups.iter().map(Vec::len).sum::<usize>(), 1000);
    for (size, share) in [(2, 0.6), (3, 0.3), (4, 0.1f64)] {
        // Four standard errors.
        let error = 4.0 * (share * (1.0 - share) / all).sqrt();
        assert!((count(size) / all - share).abs() < error, "{size}: {} of {all}", count(size));
    }
    let at = |i: usize| people[i].1.position;
    assert!(groups.iter().all(|group| group.iter().all(|&i| (at(i) - at(group[0])).norm() <= 3.0)));
    let mut members: Vec<usize> = groups.iter().flatten().copied().collect();
    members.sort_unstable();
    members.dedup();
    assert_eq!(members.len(), 1000, "nobody is in two groups");
    let config = "groups = { share = 0.5, sizes = [6, 3, 1] }\nseed = ";
    assert!(groups == drawn(&format!("{config}3")) && groups != drawn(&format!("{config}4")));
    // Nobody through a wall, nobody who goes elsewhere.
    let pairs = [person(0, 0.0, 0.0), person(1, 0.5, 0.0), person(2, 1.0, 0.0)];
    let wall = vec![vec2(0.75, -1.0), vec2(0.75, 1.0)];
    for seed in 0..8 {
        let config = format!("seed = {seed}\n{FAR}groups.share = 1");
        let mut groups = plan(std::slice::from_ref(&wall), &pairs, &config).groups;
        groups.iter_mut().for_each(|group| group.sort_unstable());
        assert_eq!(groups, [vec![0, 1]]);
        let config = format!("{config}\nagents.1.exit = \"exit 0\"");
        let groups = plan(&[], &pairs, &config).groups;
        assert!(groups.iter().flatten().all(|&i| i != 1), "{groups:?}");
    }
}

#[test]
fn wrong_groups_times_and_preferences_are_named() {
    let people = [person(0, 0.0, 0.0), person(1, 1.0, 0.0)];
    let config = "exit_choice = \"time\"\ngroups.members = [[\"0\", \"1\"]]\n\
                  exits = [{ line = [[5, 0], [5, 4]], open = [[0.1, 7], [8, 9.5]], time_factor = 0.7 }]";
    let many: Vec<[usize; 2]> = (0..1001).map(|k| [2 * k, 2 * k + 1]).collect();
    for (good, bad, words) in [
        ("[[0.1, 7], [8, 9.5]]", &*format!("{many:?}"), "1001 pairs; at most 1000"),
        ("[\"0\", \"1\"]", "[\"0\", \"2\"]", "there is no agent with this Id"),
        ("[\"0\", \"1\"]", "[\"1\", \"1\"]", "is in a group already"),
        ("[\"0\", \"1\"]", "[\"0\"]", "has 1 members"),
        ("[0.1, 7]", "[0.1, 8.5]", "above the one before"),
        ("[0.1, 7]", "[0.1, 0.11]", "shorter than the time step of 0.02 s"),
        ("time_factor = 0.7", "time_factor = -1.0", "positive"),
    ] {
        assert!(config.contains(good), "{config}");
        let made = DecisionConfig::from_toml(&config.replace(good, bad));
        let trial = Trial::of(people.clone(), Vec::new(), STEP);
        let message = made.and_then(|config| Plan::of(&trial, &config)).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
}
