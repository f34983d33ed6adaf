//! People who come later, and exits that close after some people.

use lemons_core::plane::{Motion, Twist, vec2};
use lemons_core::trial::{Agent, AgentDynamics, Trial, Wall};
use lemons_decision::source::SourceConfig;
use lemons_decision::{Decision, DecisionConfig, Plan};
use lemons_fmi::Model;

const STEP: f64 = 0.05;
const EXIT: &str = "exits = [{ name = \"a\", line = [[9, -5], [9, 5]] }]\n";

/// People at places \[m\], who come with 1 m/s.
fn trial(places: &[[f64; 2]], walls: &[[[f64; 2]; 2]]) -> Trial {
    let disks = [[0.0, 0.11, 0.12], [0.0, 0.0, 0.12], [0.0, -0.11, 0.12]];
    let person = |(k, at): (usize, &[f64; 2])| {
        let dynamics =
            AgentDynamics { position: (*at).into(), velocity: vec2(1.0, 0.0), ..Default::default() };
        (Agent::new(k.to_string(), 80.0, 1.5, [2.0, 4.0]).with_disks(&disks), dynamics)
    };
    let wall = |ends: &[[f64; 2]; 2]| Wall::new("", "", ends.map(Into::into).to_vec());
    Trial::of(places.iter().enumerate().map(person), walls.iter().map(wall).collect(), STEP)
}

/// Returns in each step who is there, if nobody moves until they are moved.
fn there(trial: &Trial, config: &str, steps: usize) -> Vec<Vec<bool>> {
    let plan = Plan::of(trial, &DecisionConfig::from_toml(config).unwrap()).unwrap();
    let mut decision = Decision::new(plan.clone());
    let mut seen = Vec::new();
    for k in 0..steps {
        // A run that goes on from a state does the same.
        if k == steps / 2 {
            let mut other = Decision::new(plan.clone());
            other.restore(&decision.save()).unwrap();
            decision = other;
        }
        decision.see(trial.dynamics.iter().map(|own| Motion { twist: Twist::default(), ..own.motion() }));
        seen.push(decision.acts().unwrap().iter().map(|act| act.active).collect());
        decision.pass(STEP).unwrap();
    }
    seen
}

/// The outside: the Poisson distribution, whose variance is its mean; and gaps with the mean 1/rate, and so a deviation.
#[test]
fn arrivals_by_a_rate_are_those_of_a_poisson_process() {
    let source = SourceConfig { rate: Some(1.5), start: Some(10.0), ..SourceConfig::default() };
    let (mut counts, mut gaps) = (Vec::new(), Vec::new());
    for seed in 0..2000 {
        let times = source.due("", 150, seed, 0).unwrap();
        assert!(times.is_sorted() && times[0] > 10.0);
        counts.push(times.iter().filter(|time| **time < 50.0).count() as f64);
        gaps.extend(times.windows(2).map(|pair| pair[1] - pair[0]));
    }
    let moments = |all: &[f64]| {
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        (mean, all.iter().map(|one| (one - mean).powi(2)).sum::<f64>() / (all.len() - 1) as f64)
    };
    let (mean, variance) = moments(&counts);
    // Four standard errors: √(60/2000) and 60 √(2/2000).
    assert!((mean - 60.0).abs() < 0.7 && (variance - 60.0).abs() < 7.6, "{mean} {variance}");
    let (mean, variance) = moments(&gaps);
    assert!((mean - 2.0 / 3.0).abs() < 0.005 && (variance - 4.0 / 9.0).abs() < 0.01, "{mean} {variance}");
    // Sources of one seed are independent.
    assert_ne!(source.due("", 9, 1, 0).unwrap(), source.due("", 9, 1, 1).unwrap());
}

/// The outside: the times themselves. The act is for the step that begins then.
#[test]
fn who_is_due_comes_at_the_first_point_that_is_not_before() {
    let places = [[0.0, 0.0], [2.0, 0.0], [4.0, 0.0], [6.0, 0.0]];
    for (when, steps) in [("every = 0.1, start = 0.1", [2, 4, 6]), ("times = [0.12, 0.12, 0.3]", [3, 3, 6])] {
        let config = format!("{EXIT}sources = [{{ people = [\"1\", \"2\", \"3\"], {when} }}]");
        let seen = there(&trial(&places, &[]), &config, 10);
        let first = [1, 2, 3].map(|i| seen.iter().position(|there| there[i]).unwrap());
        assert_eq!(first, steps, "{when}");
        assert!(seen.iter().all(|there| there[0]) && seen[9] == [true; 4]);
    }
}

#[test]
fn who_is_not_there_and_of_no_source_never_comes() {
    let mut trial = trial(&[[0.0, 0.0], [2.0, 0.0], [4.0, 0.0]], &[]);
    (trial.dynamics[1].absent, trial.dynamics[2].absent) = (true, true);
    let config = format!("{EXIT}sources = [{{ people = [\"1\"], times = [0.1] }}]");
    assert_eq!(there(&trial, &config, 9)[8], [true, true, false]);
    let plan = Plan::of(&trial, &DecisionConfig::from_toml(&config).unwrap()).unwrap();
    assert_eq!(plan.leaving(), [true, true, false]);
}

#[test]
fn nobody_comes_where_somebody_stands_or_a_wall_is_and_another_one_comes_instead() {
    // Person 1 has the place of person 0, 2 stands in a wall, 3 and 4 are at one place, 5 is alone.
    let places = [[0.0, 0.0], [0.2, 0.1], [2.0, 0.0], [4.0, 0.0], [4.1, 0.0], [6.0, 0.0]];
    let people = "people = [\"1\", \"2\", \"3\", \"4\", \"5\"]";
    let config = format!("{EXIT}sources = [{{ {people}, times = [0.1, 0.2, 0.3, 0.4, 0.5] }}]");
    let seen = there(&trial(&places, &[[[2.1, -1.0], [2.1, 0.1]]]), &config, 20);
    let first: Vec<_> = (1..6).map(|i| seen.iter().position(|there| there[i])).collect();
    assert_eq!(first, [None, None, Some(2), None, Some(4)]);
    // In front of somebody who comes near, there is no room either: 0.05 s at 2 m/s and more are 0.15 m.
    let alone = trial(&[[0.0, 0.0], [0.55, 0.0]], &[]);
    let config = format!("{EXIT}sources = [{{ people = [\"1\"], times = [{STEP}] }}]");
    let plan = Plan::of(&alone, &DecisionConfig::from_toml(&config).unwrap()).unwrap();
    let comes = |velocity: f64| {
        let mut decision = Decision::new(plan.clone());
        let twist = Twist { velocity: vec2(velocity, 0.0), ..Twist::default() };
        decision.see(alone.dynamics.iter().map(|own| Motion { twist, ..own.motion() }));
        decision.pass(STEP).unwrap();
        decision.acts().unwrap()[1].active
    };
    // The gap is 0.31 m.
    assert_eq!([2.0, 6.0].map(comes), [true, false]);
}

#[test]
fn an_exit_closes_after_so_many_people() {
    let places: Vec<[f64; 2]> = (0..6).map(|k| [8.5, f64::from(k) - 2.5]).collect();
    let config =
        "exits = [{ name = \"a\", line = [[9, -5], [9, 5]], most = 4 }, { line = [[-9, -5], [-9, 5]] }]";
    let trial = trial(&places, &[]);
    let plan = Plan::of(&trial, &DecisionConfig::from_toml(config).unwrap()).unwrap();
    let mut decision = Decision::new(plan.clone());
    // All cross the line in one step.
    let at = |x: f64| {
        let mut motions: Vec<Motion> = trial.dynamics.iter().map(AgentDynamics::motion).collect();
        motions.iter_mut().for_each(|motion| motion.pose.position.x = x);
        motions
    };
    for x in [8.5, 9.1, 9.2] {
        decision.see(at(x).into_iter());
        decision.acts().unwrap();
        decision.pass(STEP).unwrap();
    }
    let left = |decision: &mut Decision| decision.acts().unwrap().iter().filter(|act| !act.active).count();
    assert_eq!((left(&mut decision), decision.arrived().unwrap()), (4, 4));
    // The others go to the other exit, also after a restart; who crosses the line again does not leave.
    let mut other = Decision::new(plan);
    other.restore(&decision.save()).unwrap();
    for mut decision in [decision, other] {
        for x in [9.2, 8.9, 9.2] {
            decision.see(at(x).into_iter());
            assert_eq!(left(&mut decision), 4);
            let acts = decision.acts().unwrap();
            assert!(acts[4..].iter().all(|act| act.active && act.drive.force[0] < -10.0), "{acts:?}");
            decision.pass(STEP).unwrap();
        }
        decision.see(at(-9.1).into_iter());
        decision.acts().unwrap();
        assert_eq!(left(&mut decision), 6);
    }
}

#[test]
fn with_times_so_many_leave_in_each_of_them() {
    let places: Vec<[f64; 2]> = (0..9).map(|k| [8.5, f64::from(k) - 4.5]).collect();
    let config = "exits = [{ line = [[9, -5], [9, 5]], most = 2, open = [[0, 1], [2, 3], [4, 5]] }]";
    let seen = |x: f64| {
        let mut trial = trial(&places, &[]);
        let plan = Plan::of(&trial, &DecisionConfig::from_toml(config).unwrap()).unwrap();
        let mut decision = Decision::new(plan);
        trial.dynamics.iter_mut().for_each(|own| own.position.x = x);
        let mut left = Vec::new();
        for k in 0..120 {
            decision.see(trial.dynamics.iter().map(AgentDynamics::motion));
            let gone = decision.acts().unwrap().iter().filter(|act| !act.active).count();
            left.extend((k % 20 == 10).then_some(gone));
            decision.pass(STEP).unwrap();
        }
        left
    };
    // On the line, and before it.
    assert_eq!([seen(9.0), seen(8.0)], [[2, 2, 4, 4, 6, 6], [0; 6]]);
}

#[test]
fn what_cannot_be_is_told_with_its_key() {
    let refused = |source: &str, more: &str| {
        let config = DecisionConfig::from_toml(&format!("{EXIT}sources = [{source}]\n{more}"));
        let trial = trial(&[[0.0, 0.0], [2.0, 0.0]], &[]);
        config.and_then(|config| Plan::of(&trial, &config)).unwrap_err().to_string()
    };
    let people = "people = [\"1\"]";
    for (source, said) in [
        ("rate = 1e300", "sources[0]: rate = 1e300: must be from 1e-6 to 1000 people per s"),
        ("rate = 0", "sources[0]: rate = 0.0: must be"),
        ("rate = -1", "sources[0]: rate = -1.0: must be"),
        ("rate = nan", "sources[0]: rate = NaN: must be"),
        ("every = 0", "sources[0]: every = 0.0: must be from 0.001 to 1e6 s"),
        ("every = 1, start = inf", "sources[0]: start = inf: must be from 0 to 1e9"),
        ("times = [2, 1]", "sources[0]: times = [2.0, 1.0]: must be in order"),
        ("times = []", "sources[0]: times = 0 times for 1 people: must be as many"),
        ("times = [-1]", "sources[0]: times = -1.0"),
        ("rate = 1, every = 1", "sources[0]: give `rate`, `every` or `times`, one of the three"),
        ("name = \"a\"", "sources[0]: give `rate`"),
        ("rat = 1", "unknown field `rat`"),
    ] {
        let message = refused(&format!("{{ {people}, {source} }}"), "");
        assert!(message.contains(said), "{source}: {message}");
    }
    let twice = "{ name = \"s\", people = [\"1\"], rate = 1 }, { name = \"s\", people = [\"0\"], rate = 1 }";
    assert!(refused(twice, "").contains("sources[1]: the name \"s\" is that of another source"));
    let same = "{ people = [\"1\"], rate = 1 }, { people = [\"1\"], rate = 1 }";
    assert!(refused(same, "").contains("sources[1]: people: \"1\": comes twice"));
    assert!(refused("{ people = [\"7\"], rate = 1 }", "").contains("\"7\": there is no agent with this Id"));
    let group = refused("{ people = [\"1\"], rate = 1 }", "groups.members = [[\"0\", \"1\"]]");
    assert!(group.contains("comes later"), "{group}");
    let goal = "goals = [{ line = [[1, 1], [2, 1]], most = 3 }]";
    assert!(refused("", goal).contains("most: only exits have it"));
}
