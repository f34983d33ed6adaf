//! Queues that push: who waits leans on who is in front.

use lemons_core::plane::{Motion, Pose, Twist, vec2};
use lemons_core::trial::{Agent, AgentDynamics, Trial, Wall};
use lemons_decision::{Decision, DecisionConfig, Plan, WalkingModelName};
use lemons_fmi::Model;
use lemons_fmi::testing::dependencies::moved;
use lemons_fmi::variables::Known;

const STEP: f64 = 0.05;
/// \[1/s\] 1/t_transl.
const DAMPING: f64 = 2.0;
const MASS: f64 = 80.0;
/// \[N\] m g s/l of the usual support and stature.
const FEET: f64 = MASS * 9.81 * 0.25 / (0.56 * 1.75);

/// People at these places \[m\], 0.24 m deep and 0.46 m broad, who face along x and want to get far along it.
fn decision(places: &[[f64; 2]], config: &str, wall: Option<f64>) -> Decision {
    let disks = [[0.0, 0.11, 0.12], [0.0, 0.0, 0.12], [0.0, -0.11, 0.12]];
    let person = |(k, place): (usize, &[f64; 2])| {
        let agent = Agent::new(k.to_string(), MASS, 1.5, [DAMPING, 4.0]).with_disks(&disks);
        (agent, AgentDynamics { position: (*place).into(), ..AgentDynamics::default() })
    };
    let wall = wall.map(|x| Wall::new("", "", vec![vec2(x, -1.0), vec2(x, 1.0)]));
    let people: Vec<_> = places.iter().enumerate().map(person).collect();
    let trial = Trial::of(people, wall.into_iter().collect(), STEP);
    let far = if config.contains("waypoints") { "" } else { "\nwaypoints = [{ x = 1e6, y = 0 }]" };
    let config = format!("{config}{far}");
    Decision::new(Plan::of(&trial, &DecisionConfig::from_toml(&config).unwrap()).unwrap())
}

/// Sees everybody in a line, with one velocity along x \[m/s\]; returns the forces \[N\] along x besides those that keep it.
fn pushes(decision: &mut Decision, places: &[[f64; 2]], velocity: f64) -> Vec<f64> {
    let twist = Twist { velocity: vec2(velocity, 0.0), ..Twist::default() };
    decision.see(places.iter().map(|[x, y]| Motion { pose: Pose::new(*x, *y, 0.0), twist }));
    let acts = decision.acts().unwrap();
    acts.iter().map(|act| act.drive.force[0] - MASS * DAMPING * velocity).collect()
}

#[track_caller]
fn near(seen: f64, expected: f64, tolerance: f64) {
    assert!((seen - expected).abs() <= tolerance, "{seen} is not {expected}");
}

/// Of three in a row, the first has nobody ahead, the second touches the first, the third is 0.1 m behind.
#[test]
fn who_waits_and_touches_somebody_ahead_leans_in_every_model() {
    let places = [[5.0, 0.0], [4.765, 0.0], [4.4, 0.0]];
    for model in WalkingModelName::ALL.iter().map(|model| model.name()) {
        let config = |push: f64| {
            format!("model = {model:?}\nseed = 3\ndesired_speed = 0.6\nqueue = {{ push = {push:?} }}")
        };
        let [mut none, mut leaning] = [0.0, 150.0].map(|push| decision(&places, &config(push), None));
        for velocity in [0.0, 0.15, 0.3, -0.1] {
            let before = pushes(&mut none, &places, velocity);
            let after = pushes(&mut leaning, &places, velocity);
            assert_eq!((after[0], after[2]), (before[0], before[2]), "{model} {velocity}");
            // Less with the speed, in a line; who pushes more pushes as before.
            let part = (1.0 - velocity / 0.3).clamp(0.0, 1.0);
            near(after[1], before[1] + part * (150.0 - before[1]).max(0.0), 1e-9);
            let leans = velocity < 0.3 && model != "straight";
            assert!(!leans || after[1] > before[1], "{model} {velocity}");
        }
    }
}

#[test]
fn a_wall_ahead_is_leaned_on_and_one_at_the_side_is_not() {
    let push = |config: &str, wall: f64| {
        let mut decision = decision(&[[5.0, 0.0]], config, Some(wall));
        pushes(&mut decision, &[[5.0, 0.0]], 0.0)[0]
    };
    let [alone, leaning] = ["", "\nqueue = { push = 150.0 }"]
        .map(|queue| format!("model = \"collision-free-speed\"\ndesired_speed = 0.6{queue}"));
    near(push(&leaning, 5.125), 150.0, 1e-9);
    // 8 cm ahead, and behind.
    for wall in [5.2, 4.875] {
        near(push(&leaning, wall), push(&alone, wall), 1e-9);
    }
}

/// Who stands at a goal, does not want to walk, or waits at a way-point, presses nobody.
#[test]
fn who_does_not_want_to_get_on_does_not_lean() {
    let places = [[5.0, 0.0], [4.765, 0.0]];
    let goal = "goals = [{ polygon = [[0, -5], [9, -5], [9, 5], [0, 5]] }]\nwaypoints = []";
    for wants in [goal, "desired_speed = 0", "start = 9"] {
        let of = |queue: &str| format!("model = \"rotational\"\nseed = 3\n{queue}\n{wants}");
        let [mut none, mut leaning] =
            ["", "queue = { push = 150.0 }"].map(|queue| decision(&places, &of(queue), None));
        assert_eq!(pushes(&mut none, &places, 0.0), pushes(&mut leaning, &places, 0.0), "{wants}");
    }
}

#[test]
fn feet_hold_no_more_than_their_support() {
    let places = [[5.0, 0.0], [4.765, 0.0]];
    let lean = |config: &str| pushes(&mut decision(&places, config, None), &places, 0.0)[1];
    near(lean("model = \"rotational\"\nqueue = { push = 900.0 }"), FEET, 1e-9);
    let narrow = "model = \"rotational\"\nqueue = { push = 900.0 }\npendulum = { support = 0.1 }\nbalance = \"pendulum\"";
    // Who stands on legs, too.
    near(lean(narrow), 0.4 * FEET, 1e-9);
}

/// Somebody on legs leans on a person who does not give way, for a long time: the force stays what it is.
#[test]
fn who_leans_on_legs_goes_on_leaning() {
    let places = [[5.0, 0.0], [4.765, 0.0]];
    // Legs of two levels are repelled by those in front: the body leans further, by at most m v λ.
    for (balance, more) in [("pendulum", 0.0), ("two-level", MASS * 0.7 * DAMPING)] {
        let config = format!("model = \"rotational\"\nbalance = {balance:?}\nqueue = {{ push = 100.0 }}");
        let mut decision = decision(&places, &config, None);
        let seen: Vec<f64> = (0..400)
            .map(|_| {
                let push = pushes(&mut decision, &places, 0.0)[1];
                decision.pass(STEP).unwrap();
                push
            })
            .collect();
        let range = 100.0 - 1e-9..=100.0 + more + 1e-9;
        assert!(seen[1..].iter().all(|push| range.contains(push)), "{balance}: {seen:?}");
    }
}

/// 400 people for 100 s: each has a force of its own, drawn from the distribution, which changes in about 10 s.
#[test]
fn forces_follow_their_distribution_and_change_slowly() {
    let places: Vec<[f64; 2]> =
        (0..800).map(|k| [5.0 - 0.235 * f64::from(k % 2), 3.0 * f64::from(k / 2)]).collect();
    let config = "model = \"collision-free-speed\"\nseed = 5\ndesired_speed = 1e-3\n\
                  queue = { push = { min = 20.0, max = 140.0 }, push_time = 10.0 }";
    let mut decision = decision(&places, config, None);
    let mut seen: Vec<Vec<f64>> = Vec::new();
    for k in 0..2000 {
        if k % 100 == 0 {
            let all = pushes(&mut decision, &places, 0.0);
            seen.push(all.into_iter().skip(1).step_by(2).collect());
        }
        decision.pass(STEP).unwrap();
    }
    let all: Vec<f64> = seen.iter().flatten().copied().collect();
    let mean = |all: &[f64]| all.iter().sum::<f64>() / all.len() as f64;
    let sd = (all.iter().map(|push| (push - mean(&all)).powi(2)).sum::<f64>() / all.len() as f64).sqrt();
    // To the sides it is 1e-3 rad.
    assert!(all.iter().all(|push| (19.99..=140.0).contains(push)));
    near(mean(&all), 80.0, 3.0);
    near(sd, 120.0 / 12f64.sqrt(), 1.5);
    // Of the same person 5 s later. A uniform number of a normal one has a correlation of 6/π asin(ρ/2).
    let pairs = seen.windows(2).flat_map(|pair| pair[0].iter().zip(&pair[1]));
    let products: Vec<f64> = pairs.map(|(a, b)| (a - 80.0) * (b - 80.0)).collect();
    let correlation = mean(&products) / (sd * sd);
    let expected = 6.0 / std::f64::consts::PI * (0.5 * (-0.5f64).exp()).asin();
    near(correlation, expected, 0.03);
}

#[test]
fn a_saved_queue_goes_on_with_the_same_bits() {
    let places = [[5.0, 0.0], [4.765, 0.0]];
    let config = "model = \"rotational\"\nseed = 2\nqueue = { push = { mean = 100.0, sd = 40.0, min = 0.0, max = 300.0 } }";
    let mut one = decision(&places, config, None);
    for _ in 0..50 {
        pushes(&mut one, &places, 0.0);
        one.pass(STEP).unwrap();
    }
    let mut other = decision(&places, config, None);
    other.restore(&one.save()).unwrap();
    for _ in 0..50 {
        let [a, b] = [&mut one, &mut other].map(|decision| {
            let push = pushes(decision, &places, 0.0)[1];
            decision.pass(STEP).unwrap();
            push.to_bits()
        });
        assert_eq!(a, b);
    }
    assert_eq!(one.save(), other.save());
}

#[test]
fn what_cannot_be_is_refused_by_key() {
    for (queue, message) in [
        ("{ push = -1.0 }", "queue.push"),
        ("{ push = { min = 5.0, max = 1.0 } }", "queue.push"),
        ("{ push = 1.0, push_time = 0.0 }", "push_time"),
        ("{ pull = 1.0 }", "pull"),
    ] {
        let config = DecisionConfig::from_toml(&format!("waypoints = [{{ x = 1, y = 0 }}]\nqueue = {queue}"));
        let trial =
            Trial::of([(Agent::new("0", 80.0, 1.5, [2.0, 4.0]), AgentDynamics::default())], Vec::new(), STEP);
        let error = config.and_then(|config| Plan::of(&trial, &config)).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
}

/// The helper changes each input and parameter, and looks into both descriptions.
#[test]
fn who_leans_depends_on_everybody_as_it_is_declared() {
    let places = [[5.0, 0.0], [4.765, 0.0]];
    for config in ["queue = { push = 150.0 }", "queue = { push = 150.0 }\nbalance = \"pendulum\""] {
        let initialized = || {
            let mut decision = decision(&places, &format!("desired_speed = 0.6\n{config}"), None);
            decision.initialize(0.0).unwrap();
            decision
        };
        let moved = moved(initialized, Known::Inputs);
        assert!(["Position", "Velocity"].iter().all(|on| moved.contains(&("Fp", on))), "{moved:?}");
    }
}
