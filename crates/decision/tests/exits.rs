//! Exits, goals and models, without FMUs: bodies that go exactly where they want to go.

use lemons_core::plane::{Motion, Pose, Vec2, segments_cross, vec2};
use lemons_core::trial::{Agent, AgentDynamics, OpeningTimes, Trial, Wall};
use lemons_decision::decision::Act;
use lemons_decision::target::{Destination, Target, Ways};
use lemons_decision::{Decision, DecisionConfig, Plan, PlanError};
use lemons_fmi::Model;
use std::fmt::Display;

const STEP: f64 = 0.05;

type Person = (Agent, AgentDynamics);

fn person(id: impl Display, x: f64, y: f64) -> Person {
    // Shoulders across the gaze, 0.46 m wide and 0.24 m deep.
    let disks = [[0.0, 0.11, 0.12], [0.0, 0.0, 0.12], [0.0, -0.11, 0.12]];
    let agent = Agent::new(id.to_string(), 80.0, 1.5, [2.0, 4.0]).with_disks(&disks);
    (agent, AgentDynamics { position: vec2(x, y), ..AgentDynamics::default() })
}

/// A room of 6 m by 4 m whose door, 1 m wide, is in the middle of its right side.
fn room() -> Vec<Vec2> {
    [(6.0, 2.5), (6.0, 4.0), (0.0, 4.0), (0.0, 0.0), (6.0, 0.0), (6.0, 1.5)].map(|(x, y)| vec2(x, y)).to_vec()
}

const DOOR: &str = "exits = [{ name = \"door\", line = [[6.5, 1.5], [6.5, 2.5]] }]\n";

fn plan(walls: &[Vec<Vec2>], people: &[Person], config: &str) -> Result<Plan, PlanError> {
    let walls = walls.iter().map(|wall| Wall::new("", "", wall.clone())).collect();
    Plan::of(&Trial::of(people.to_vec(), walls, STEP), &DecisionConfig::from_toml(config)?)
}

/// The models here do not look at velocities.
fn still(pose: Pose) -> Motion {
    Motion { pose, ..Motion::default() }
}

/// Everybody goes where the force leads in the end: v = F / (m / t). Returns the places at each step, while they are
/// there.
fn walk(plan: Plan, steps: usize) -> Vec<Vec<Option<Vec2>>> {
    let mut poses: Vec<Pose> = plan.agents.iter().map(|agent| agent.pose).collect();
    let mut decision = Decision::new(plan);
    let mut ways = Vec::new();
    for _ in 0..steps {
        decision.see(poses.iter().copied().map(still));
        let acts = decision.acts().unwrap();
        ways.push(poses.iter().zip(&acts).map(|(pose, act)| act.active.then_some(pose.position)).collect());
        decision.pass(STEP).unwrap();
        for (pose, Act { drive, active }) in poses.iter_mut().zip(acts) {
            if active {
                let [x, y] = drive.force.map(|force| force / (80.0 * 2.0));
                pose.position += vec2(x, y) * STEP;
                pose.orientation += 4.0 * STEP * drive.torque / (1.5 * 16.0);
            }
        }
    }
    ways
}

fn alone(way: &[Vec<Option<Vec2>>], who: usize) -> Vec<Vec2> {
    way.iter().map_while(|all| all[who]).collect()
}

#[test]
fn one_person_leaves_by_the_door_on_the_shortest_way() {
    for model in ["straight", "collision-free-speed", "social-force"] {
        let config = format!("model = \"{model}\"\n{DOOR}");
        let plan = plan(&[room()], &[person(0, 1.0, 3.5)], &config).unwrap();
        let way = alone(&walk(plan, 400), 0);
        // To the door's upper post, and on to the line.
        let shortest = (vec2(6.0, 2.5) - vec2(1.0, 3.5)).norm() + 0.5;
        let seconds = way.len() as f64 * STEP;
        assert!(way.len() < 400, "{model}: still there");
        assert!((shortest / 1.34..1.25 * shortest / 1.34 + 0.2).contains(&seconds), "{model}: {seconds} s");
        for (a, b) in way.iter().zip(&way[1..]) {
            let walls = room();
            let crossed = walls.windows(2).any(|ends| segments_cross(*a, *b, ends[0], ends[1]));
            assert!(!crossed, "{model}: through a wall at {a:?}");
        }
        assert!(way.last().unwrap().x > 6.3, "{model}");
    }
}

/// The outside: the model's own formula for two people one behind the other.
#[test]
fn behind_somebody_one_is_as_fast_as_the_gap_over_the_time_gap() {
    let config = format!("model = \"collision-free-speed\"\n{DOOR}[collision-free-speed]\ntime_gap = 0.8\n");
    // They face along x: half of each body's depth is 0.12 m.
    let people = [person(0, 2.0, 2.0), person(1, 2.9, 2.0)];
    let mut decision = Decision::new(plan(&[], &people, &config).unwrap());
    let acts = decision.acts().unwrap();
    let speed = |act: &Act| (act.drive.force[0] / 160.0).hypot(act.drive.force[1] / 160.0);
    let gap = 0.9 - 0.24;
    assert!((speed(&acts[0]) - gap / 0.8).abs() < 1e-9, "{}", speed(&acts[0]));
    assert!((speed(&acts[1]) - 1.34).abs() < 1e-9, "nobody is in front of the other");
    // Behind a wall they do not see each other.
    let wall = vec![vec2(2.45, 1.0), vec2(2.45, 3.0)];
    let mut decision = Decision::new(plan(&[wall], &people, &config).unwrap());
    assert!((speed(&decision.acts().unwrap()[0]) - 1.34).abs() < 1e-9);
}

/// The outside: the formula, A exp(−gap/B), besides the force for the desired speed.
#[test]
fn the_social_force_is_that_of_the_paper() {
    let config = format!("model = \"social-force\"\n{DOOR}[social-force]\nstrength = 1500\nrange = 0.1\n");
    let people = [person(0, 2.0, 2.0), person(1, 2.5, 2.0)];
    let mut decision = Decision::new(plan(&[], &people, &config).unwrap());
    let act = decision.acts().unwrap()[0];
    let wanted = 80.0 * 1.34 * 2.0 - 1500.0 * (-(0.5 - 0.24) / 0.1f64).exp();
    assert!((act.drive.force[0] - wanted).abs() < 1e-6, "{} instead of {wanted}", act.drive.force[0]);
}

#[test]
fn people_take_the_nearest_exit_their_own_or_one_by_shares() {
    let exits = "exits = [{ name = \"left\", line = [[-1, 1], [-1, 3]]SHARE1 }, { name = \"right\", line = [[11, 1], [11, 3]]SHARE2 }]\n";
    let people: Vec<Person> = (0..10).map(|k| person(k, 0.5 + k as f64, 2.0)).collect();
    let leaves_right = |config: &str| {
        let way = walk(plan(&[], &people, config).unwrap(), 400);
        (0..10).map(|k| alone(&way, k).last().unwrap().x > 5.0).collect::<Vec<bool>>()
    };
    let plain = exits.replace("SHARE1", "").replace("SHARE2", "");
    assert_eq!(leaves_right(&plain), [0, 1, 2, 3, 4, 5, 6, 7, 8, 9].map(|k| k > 4));
    let own = format!("{plain}[agents.0]\nexit = \"right\"\n");
    assert!(leaves_right(&own)[0]);
    let shared = exits.replace("SHARE1", ", share = 3").replace("SHARE2", ", share = 7");
    let right = |seed: u32| leaves_right(&format!("seed = {seed}\n{shared}"));
    assert_eq!(right(1).iter().filter(|right| **right).count(), 7);
    assert_eq!(right(1), right(1));
    assert!((2..10).any(|seed| right(seed) != right(1)), "the seed chooses who");
}

/// Total turning \[rad\] of somebody who is jostled to and fro by 0.2 m, once in 2 s for 20 s, where two exits are equally far.
fn turning(exit_choice: &str) -> f64 {
    let exits = "exits = [{ line = [[0, 0], [0, 4]] }, { line = [[10, 0], [10, 4]] }]";
    let config = format!("exit_choice = \"{exit_choice}\"\n{exits}");
    let mut decision = Decision::new(plan(&[], &[person(0, 4.9, 2.0)], &config).unwrap());
    let (mut theta, mut spin, mut total) = (0.0, 0.0, 0.0);
    for step in 0..400 {
        let x = 5.0 - 0.1 * (0.05 * f64::from(step) * std::f64::consts::PI).cos();
        decision.see(std::iter::once(still(Pose::new(x, 2.0, theta))));
        let torque = decision.acts().unwrap()[0].drive.torque;
        decision.pass(STEP).unwrap();
        // The moment of inertia and the angular damping of the person.
        spin += STEP * (torque / 1.5 - 4.0 * spin);
        theta += STEP * spin;
        total += STEP * f64::abs(spin);
    }
    total
}

/// By the distance on foot, such a person would turn round and round.
#[test]
fn who_chooses_by_time_does_not_turn_to_and_fro_between_two_exits() {
    let (distance, time) = (turning("distance"), turning("time"));
    assert!(distance > 27.0 && time < 2.0 * std::f64::consts::PI, "{distance} rad and {time} rad");
}

/// The outside: with a queue of 20 at a door of 1 m, an exit 8 m further is quicker. The direction relaxes in 0.3 s.
#[test]
fn who_changes_to_another_exit_does_not_turn_at_once() {
    let exits =
        "exits = [{ line = [[0, 1.5], [0, 2.5]] }, { line = [[20, 0], [20, 4]] }]\nexit_choice = \"time\"";
    let mut people: Vec<Person> = (0..40).map(|k| person(k, 1.0, 2.0)).collect();
    people.push(person(40, 6.0, 2.0));
    let mut decision = Decision::new(plan(&[], &people, exits).unwrap());
    let mut directions = Vec::new();
    // Before they are stuck.
    for _ in 0..24 {
        let [x, y] = decision.acts().unwrap()[40].drive.force;
        directions.push(y.atan2(x).abs());
        // A saved state goes on alike.
        let saved = decision.save();
        decision.pass(STEP).unwrap();
        let after = decision.save();
        decision.restore(&saved).unwrap();
        decision.pass(STEP).unwrap();
        assert_eq!(decision.save(), after);
    }
    assert!(directions[0] > 3.0 && directions[23] < 0.3, "{directions:?}");
    let most = directions.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
    assert!(most < 0.5, "{most} rad in a step");
}

#[test]
fn at_a_goal_people_stay_and_come_together_in_its_middle() {
    // At a line they come to rest.
    let line = "goals = [{ line = [[5, 0], [5, 4]] }]";
    let way = walk(plan(&[], &[person(0, 3.0, 2.0)], line).unwrap(), 400);
    let (before, last) = (way[398][0].unwrap(), way[399][0].unwrap());
    assert!((last - before).norm() < 1e-4 && (last.x - 5.0).abs() < 0.3, "{last:?}");
    let goal = "goals = [{ polygon = [[4, 1], [6, 1], [6, 3], [4, 3]] }]";
    let people = [person(0, 1.0, 2.0), person(1, 0.2, 1.0)];
    let way = walk(plan(&[], &people, goal).unwrap(), 400);
    let last = way.last().unwrap();
    for place in last {
        assert!((place.unwrap() - vec2(5.0, 2.0)).norm() < 0.5, "{place:?}");
    }
    let mut decision = Decision::new(plan(&[], &people, goal).unwrap());
    assert_eq!(decision.arrived().unwrap(), 0);
    decision.see(last.iter().map(|at| still(Pose::new(at.unwrap().x, at.unwrap().y, 0.0))));
    assert_eq!((decision.arrived().unwrap(), decision.going().unwrap()), (2, vec![false; 2]));
    assert!(decision.acts().unwrap().iter().all(|act| act.active));
}

#[test]
fn who_waits_for_a_closed_exit_or_to_start_does_not_want_to_get_on() {
    let exit = "exits = [{ line = [[1.0, 0.0], [1.0, 4.0]], open = [[0.1, 9.0]] }]\n[agents.1]\nstart = 1.0";
    let people = [person(0, 3.0, 2.0), person(1, 5.0, 2.0)];
    let mut decision = Decision::new(plan(&[], &people, exit).unwrap());
    assert_eq!(decision.going().unwrap(), [false, false], "it is closed");
    for _ in 0..10 {
        decision.pass(STEP).unwrap();
    }
    assert_eq!(decision.going().unwrap(), [true, false], "it is open, and one waits");
}

/// Of the desired speed, that which everybody walks with.
fn times(numbers: &[f64]) -> OpeningTimes {
    OpeningTimes::of_numbers(numbers).unwrap()
}

/// A wall that opens.
fn gate(ends: [[f64; 2]; 2], open: OpeningTimes) -> Wall {
    Wall { open: Some(open), ..Wall::new("", "", ends.map(Vec2::from).to_vec()) }
}

fn speeds(decision: &mut Decision) -> Vec<f64> {
    let drive = |act: &Act| vec2(act.drive.force[0], act.drive.force[1]).norm() / (80.0 * 2.0 * 1.34);
    decision.acts().unwrap().iter().map(drive).collect()
}

/// The wall waits for them: a disk of 0.12 m reaches into it by 7 cm, by 0.5 cm, and not.
#[test]
fn who_is_in_a_door_that_closes_walks_on() {
    let people = [person(0, 5.95, 2.0), person(1, 5.885, 2.0), person(2, 5.87, 2.0)];
    let mut plan = plan(&[room()], &people, DOOR).unwrap();
    for agent in &mut plan.agents {
        agent.disks = vec![[0.0, 0.11, 0.12], [0.0, 0.0, 0.12], [0.0, -0.11, 0.12]];
    }
    plan.doors = vec![gate([[6.0, 1.5], [6.0, 2.5]], times(&[0.0, 0.1, 0.2, 0.3]))];
    let mut decision = Decision::new(plan);
    let mut seen = Vec::new();
    for _ in 0..5 {
        seen.push(
            speeds(&mut decision).into_iter().map(|speed| (1e6 * speed).round() / 1e6).collect::<Vec<_>>(),
        );
        decision.pass(STEP).unwrap();
    }
    let (open, closed) = (vec![1.0; 3], vec![1.0, 0.1, 0.0]);
    assert_eq!(seen, [open.clone(), open.clone(), closed.clone(), closed, open]);
}

/// With way-points, too: as far as the next one, and as far as the next wall.
#[test]
fn a_closed_door_matters_on_the_way_only() {
    let door = gate([[6.0, 0.0], [6.0, 4.0]], times(&[1.0, 9.0]));
    let wall = vec![vec2(5.8, 0.0), vec2(5.8, 4.0)];
    let people = [person(0, 5.0, 2.0), person(1, 5.0, 3.0)];
    for model in ["straight", "rotational"] {
        for (x, walls, expected) in
            [(10.0, vec![], 0.5), (5.8, vec![], 1.0), (6.0, vec![], 0.5), (10.0, vec![wall.clone()], 1.0)]
        {
            let config =
                format!("model = \"{model}\"\nwaypoints = [{{ x = {x}, y = 2 }}]\n[agents.1]\nstart = 9");
            let mut plan = plan(&walls, &people, &config).unwrap();
            plan.walls = walls.to_vec();
            plan.doors = vec![door.clone()];
            let speed = Decision::new(plan).acts().unwrap()[0].drive.force[0] / (80.0 * 2.0 * 1.34);
            // Walls and others slow people, too.
            let close = if model == "straight" { 1e-9 } else { 0.1 };
            assert!((speed - expected).abs() < close, "{model}, {x}: {speed} instead of {expected}");
        }
    }
}

/// 0.5 m in front of the closed door people stand, 1 m in front they walk with half of the speed, and 1.5 m away with all.
#[test]
fn people_slow_down_in_front_of_a_closed_door() {
    let people = [person(0, 5.5, 2.0), person(1, 5.0, 2.0), person(2, 4.5, 2.0), person(3, 6.2, 2.0)];
    let plan = plan(&[room()], &people, DOOR).unwrap();
    let door = gate([[6.0, 1.5], [6.0, 2.5]], times(&[0.1, 9.0]));
    let mut decision = Decision::new(Plan { doors: vec![door], ..plan });
    // The last one is beyond it.
    for (speed, expected) in speeds(&mut decision).into_iter().zip([0.0, 0.5, 1.0, 1.0]) {
        assert!((speed - expected).abs() < 0.02, "{speed} instead of {expected}");
    }
    assert_eq!(
        decision.going().unwrap(),
        [false, false, false, true],
        "a queue wants to get on once it is open"
    );
    for _ in 0..3 {
        decision.pass(STEP).unwrap();
    }
    assert!(speeds(&mut decision).into_iter().all(|speed| (speed - 1.0).abs() < 1e-9), "it is open");
    assert_eq!(decision.going().unwrap(), [true; 4]);
}

/// The outside: the time is the distance over the speed. The line, or a thin area, lies anywhere on the grid of ways, at any
/// angle; the velocity follows at once.
#[test]
fn who_is_slow_crosses_any_line_in_the_time_of_the_way() {
    let mut worst = (0.0, String::new());
    for k in 0..11 {
        let turn = lemons_core::plane::rotation(0.29 * f64::from(k));
        let middle = vec2(3.0 + 0.01 * f64::from(k), 2.0 + 0.017 * f64::from(k));
        let corner = |x: f64, y: f64| <[f64; 2]>::from(middle + turn * vec2(x, y));
        let from = middle + turn * vec2(-1.0, 0.3);
        let ends = [corner(0.0, -1.5), corner(0.0, 1.5)];
        let thin = [ends[0], ends[1], corner(0.04, 1.5), corner(0.04, -1.5)];
        for (place, own) in [
            (format!("line = {ends:?}"), ""),
            (format!("line = {ends:?}"), "[agents.0]\nexit = \"out\""),
            (format!("polygon = {thin:?}"), ""),
        ] {
            for (model, speed) in [
                ("rotational", 0.1),
                ("rotational", 0.3),
                ("rotational", 0.45),
                ("straight", 0.2),
                ("collision-free-speed", 0.2),
                ("straight", 1.34),
            ] {
                let config = format!(
                    "model = \"{model}\"\ndesired_speed = {speed}\nexits = [{{ name = \"out\", {place} }}]\n{own}"
                );
                let steps = (3.0 / speed / STEP) as usize;
                let plan = plan(&[], &[person(0, from.x, from.y)], &config).unwrap();
                let way = alone(&walk(plan, steps), 0);
                let late = (way.len() as f64 * STEP - 1.0 / speed).abs() - STEP;
                if late * speed > worst.0 {
                    worst = (late * speed, format!("{model}, {speed} m/s, {place} {own}: {late} s"));
                }
            }
        }
    }
    assert!(worst.0 < 0.03, "{} m: {}", worst.0, worst.1);
}

/// The outside: by hand. A room, turned by any angle, has a door of 1.2 m in a wall, and the line of the exit lies on this
/// wall: between the posts, or along the wall as well, where nobody leaves. All is written in millimetres, or in
/// centimetres. Who stands before the door walks straight on; the others keep clear of the wall.
#[test]
fn an_exit_on_the_line_of_a_wall_is_left_by_its_door() {
    for k in 0..24 {
        let angle = [7.0f64, 30.0, 45.0, 63.0, 117.0, 211.0, 19.0, 81.0][k % 8].to_radians();
        let turn = lemons_core::plane::rotation(angle);
        let digits = if k < 12 { 1e3 } else { 1e2 };
        let put = |(x, y): (f64, f64)| (turn * vec2(x, y)).map(|value| (digits * value).round() / digits);
        let room = [(6.0, 2.6), (6.0, 4.0), (0.0, 4.0), (0.0, 0.0), (6.0, 0.0), (6.0, 1.4)];
        // The grid begins elsewhere.
        let far = -3.0 - 0.013 * k as f64;
        let walls = [room.map(put).to_vec(), vec![vec2(far, far), vec2(far - 1.0, far)]];
        for (low, high) in [(1.4, 2.6), (0.0, 4.0), (1.4, 4.0), (-3.0, 7.0)] {
            let ends = [(6.0, low), (6.0, high)].map(|at| <[f64; 2]>::from(put(at)));
            for (x, y, speed) in
                [(4.0, 2.0), (5.0, 1.8), (2.0, 0.5), (5.8, 0.5), (5.6, 3.6), (5.85, 3.0), (5.87, 1.2)]
                    .into_iter()
                    .flat_map(|(x, y)| [0.3, 1.3].map(|speed| (x, y, speed)))
            {
                let case = format!("{k}, {ends:?}, {speed} m/s from {x}, {y}");
                let config =
                    format!("model = \"straight\"\ndesired_speed = {speed}\nexits = [{{ line = {ends:?} }}]");
                let from = put((x, y));
                let plan = plan(&walls, &[person(0, from.x, from.y)], &config).unwrap();
                let way = alone(&walk(plan, (9.0 / speed / STEP) as usize), 0);
                let last = lemons_core::plane::rotation(-angle) * *way.last().unwrap();
                // Points get nearer to a post than bodies.
                assert!((1.35..2.65).contains(&last.y) && last.x > 5.9, "{case}: ends at {last:?}");
                // To the door's nearest post, and there.
                let shortest = (6.0 - x).hypot(f64::max(1.4 - y, y - 2.6).max(0.0));
                let late = way.len() as f64 * STEP - shortest / speed;
                let most = if (1.4..2.6).contains(&y) { 0.03 } else { 0.4 };
                assert!((-STEP..STEP + most / speed).contains(&late), "{case}: {late} s late");
            }
        }
    }
}

/// The outside: by hand. A wall at any angle has no door.
#[test]
fn an_exit_on_a_slanted_wall_is_refused() {
    for k in 0..90 {
        let turn = lemons_core::plane::rotation(f64::from(k).to_radians());
        let put = |(x, y): (f64, f64)| turn * vec2(x, y);
        let room = [(0.0, 0.0), (6.0, 0.0), (6.0, 4.0), (0.0, 4.0), (0.0, 0.0)].map(put).to_vec();
        let ends = [(6.0, 1.0), (6.0, 3.0)].map(|at| <[f64; 2]>::from(put(at)));
        let from = put((3.0, 2.0));
        let message =
            plan(&[room], &[person(0, from.x, from.y)], &format!("exits = [{{ line = {ends:?} }}]"));
        let message = message.map(|_| "taken".to_owned()).unwrap_or_else(|error| error.to_string());
        assert!(message.contains("lies on walls"), "{k}°: {message}");
    }
}

/// The outside: by hand. A wall lies between somebody and the near line: the way to it is round the wall's end.
#[test]
fn the_last_step_to_a_line_is_not_through_a_wall() {
    let wall = vec![vec2(2.0, -4.0), vec2(2.0, 2.0)];
    let config = "desired_speed = 0.5\nexits = [{ line = [[2.1, 0], [2.1, 1]] }]";
    let plan = plan(&[wall], &[person(0, 1.88, 0.5)], config).unwrap();
    let way = alone(&walk(plan, 400), 0);
    let high = way.iter().map(|at| at.y).fold(0.0, f64::max);
    assert!(way.len() < 400 && high > 2.0, "{} steps, up to {high} m", way.len());
}

/// The outside: by hand. The near exit lets out for 30 s more than its door, 1 m before it, is open. At 1.34 m/s, who is
/// 2 m from the door is through before it shuts, and who is 6 m from it is not, and takes the other exit at once. The door
/// is shut for good.
#[test]
fn who_cannot_pass_a_door_in_time_takes_another_exit() {
    let line = |points: &[(f64, f64)]| points.iter().map(|&(x, y)| vec2(x, y)).collect::<Vec<Vec2>>();
    let walls =
        [line(&[(0.0, 0.0), (10.0, 0.0), (10.0, 1.0)]), line(&[(10.0, 2.0), (10.0, 3.0), (0.0, 3.0)])];
    let door = |open: [f64; 2]| gate([[10.0, 1.0], [10.0, 2.0]], times(&open));
    let exits = "exits = [{ line = [[11, 0], [11, 3]], open = [[0, 32.5]] }, { line = [[-8, 0], [-8, 3]] }]";
    for choice in ["time", "distance"] {
        let leaves_at = 12.0 / 1.34;
        let people = [person(0, 8.0, 1.5), person(1, 4.0, 1.5)];
        let mut plan = plan(&walls, &people, &format!("exit_choice = \"{choice}\"\n{exits}")).unwrap();
        plan.doors = vec![door([0.0, 2.5])];
        let way = walk(plan, 800);
        let (near, far) = (alone(&way, 0), alone(&way, 1));
        let seconds = [&near, &far].map(|way| way.len() as f64 * STEP);
        assert!(
            near.last().unwrap().x > 10.5 && (seconds[0] - 3.0 / 1.34).abs() < 0.3,
            "{choice}: {seconds:?}"
        );
        assert!(far.last().unwrap().x < -7.5, "{choice}: {:?}", far.last());
        assert!((seconds[1] - leaves_at).abs() < 1.6, "{choice}: {seconds:?} instead of {leaves_at}");
    }
}

/// The outside: by hand. Of two doorways in a wall, people go through that with the door, whose line is the exit, or a
/// little behind it, anywhere on the grid and at any angle. The other one has no door, and its
/// way ends at that with the door only if the line does.
#[test]
fn a_door_on_the_line_of_an_exit_is_on_the_way() {
    for k in 0..60 {
        let turn = lemons_core::plane::rotation(if k < 20 { 0.0 } else { 0.11 * f64::from(k - 20) });
        let shift = vec2(0.01 * f64::from(k), 0.003 * f64::from(k));
        let put = |x: f64, y: f64| turn * (vec2(x, y) + shift);
        let wall = |from: f64, to: f64| vec![put(10.0, from), put(10.0, to)];
        let walls = [wall(-3.0, 0.0), wall(1.2, 4.0), wall(5.2, 8.0)];
        // Between the posts, and along the wall.
        for (behind, low, high) in [(0.0, 0.0, 1.2), (0.0, -3.0, 8.0), (0.02, -3.0, 8.0), (0.06, -3.0, 8.0)] {
            let corners = [put(10.0 + behind, low), put(10.0 + behind, high)].map(Into::into).to_vec();
            let exit = Target {
                name: String::new(),
                stay: false,
                corners,
                open: None,
                most: None,
                time_factor: 1.0,
            };
            let [before, other] = [put(7.0, 0.6), put(7.0, 4.6)];
            let people = [before, other, put(0.0, 0.0)].map(|at| (at, Destination::Target(0)));
            let ways = Ways::new(&walls, &[], &[exit], people.into_iter()).unwrap();
            let ways = ways.with_doors(vec![vec![[put(10.0, 0.0), put(10.0, 1.2)]]]).unwrap();
            for (at, count) in [(before, 1), (put(9.9, 0.5), 1), (other, usize::from(high == 1.2))] {
                let doors: Vec<(usize, f64)> = ways.doors_to(0, at).collect();
                assert_eq!(doors.len(), count, "{k}, {behind} m behind, to {high}, from {at:?}: {doors:?}");
                assert!(doors.iter().all(|(_, far)| *far <= 0.3), "{k}: {doors:?}");
            }
        }
    }
}

/// The outside: by hand. A door is 1 m before the exit: 3 cm before the door it is ahead, 3 cm behind it no more.
#[test]
fn a_door_that_somebody_has_passed_is_not_ahead() {
    for k in 0..40 {
        let turn = lemons_core::plane::rotation(0.08 * f64::from(k));
        let put = |x: f64, y: f64| turn * vec2(x + 0.013 * f64::from(k), y);
        let corners = [put(11.0, 0.0), put(11.0, 1.2)].map(Into::into).to_vec();
        let exit =
            Target { name: String::new(), stay: false, corners, open: None, most: None, time_factor: 1.0 };
        let walls = [vec![put(10.0, -3.0), put(10.0, 0.0)], vec![put(10.0, 1.2), put(10.0, 4.0)]];
        let people = [(put(7.0, 0.6), Destination::Target(0))];
        let ways = Ways::new(&walls, &[], &[exit], people.into_iter()).unwrap();
        let ways = ways.with_doors(vec![vec![[put(10.0, 0.0), put(10.0, 1.2)]]]).unwrap();
        let count = |x: f64| ways.doors_to(0, put(x, 0.6)).count();
        assert_eq!((count(9.97), count(10.03)), (1, 0), "{k}");
    }
}

/// The outside: by hand. Somebody 8 m from one exit and 12 m from the other is carried on by 4 m; an exit may close, so
/// that people choose.
#[test]
fn who_is_carried_to_another_exit_takes_it_within_a_second() {
    let exits = "exits = [{ line = [[0, 0], [0, 4]], open = [[0, 900]] }, { line = [[20, 0], [20, 4]] }]";
    let mut decision = Decision::new(plan(&[], &[person(0, 8.0, 2.0)], exits).unwrap());
    let mut force = |x: f64| {
        decision.see(std::iter::once(still(Pose::new(x, 2.0, 0.0))));
        let force = decision.acts().unwrap()[0].drive.force[0];
        decision.pass(STEP).unwrap();
        force
    };
    assert!(force(8.0) < 0.0);
    let forces: Vec<f64> = (0..60).map(|_| force(12.0)).collect();
    // The direction takes a while to turn.
    assert!(forces[0] < 0.0 && forces[40..].iter().all(|force| *force > 0.0), "{forces:?}");
}

/// The outside: by hand. At 1.34 m/s, it is 20 m to a gate and 26 m to the exit behind it, and 40 m to the other exit. Who
/// may come through the gate goes there straight on; it opens once, or to and fro. A second gate behind the first one may
/// be shut for good by then.
#[test]
fn nobody_turns_round_for_a_gate_whose_times_are_known() {
    let line = |points: &[(f64, f64)]| points.iter().map(|&(x, y)| vec2(x, y)).collect::<Vec<Vec2>>();
    let sides = [line(&[(-45.0, 0.0), (30.0, 0.0)]), line(&[(-45.0, 3.0), (30.0, 3.0)])];
    let gate = |x: f64, open: &[f64]| gate([[x, 0.0], [x, 3.0]], times(open));
    let cycle: Vec<f64> = (0..20).flat_map(|k| [6.0 * f64::from(k), 6.0 * f64::from(k) + 2.0]).collect();
    let exits = "exits = [{ line = [[26, 0], [26, 3]] }, { line = [[-40, 0], [-40, 3]] }]";
    for choice in ["time", "distance"] {
        for (name, doors, last) in [
            ("opens soon", vec![gate(20.0, &[5.0, 90.0])], 26.0 / 1.34),
            ("cyclic", vec![gate(20.0, &cycle)], 18.0 + 6.0 / 1.34),
            ("opens late", vec![gate(20.0, &[60.0, 90.0])], 40.0 / 1.34),
            ("shuts before", vec![gate(20.0, &[0.0, 14.0])], 40.0 / 1.34),
            ("second shuts", vec![gate(20.0, &[18.0, 90.0]), gate(24.0, &[0.0, 19.0])], 40.0 / 1.34),
            ("second is open", vec![gate(20.0, &[18.0, 90.0]), gate(24.0, &[0.0, 40.0])], 18.0 + 6.0 / 1.34),
        ] {
            let mut plan =
                plan(&sides, &[person(0, 0.0, 1.5)], &format!("exit_choice = \"{choice}\"\n{exits}"))
                    .unwrap();
            plan.doors = doors;
            let way = alone(&walk(plan, 800), 0);
            let (walked, seconds) =
                (way.windows(2).map(|at| (at[1] - at[0]).norm()).sum::<f64>(), way.len() as f64 * STEP);
            let there = way.last().unwrap().x;
            let far = if there > 0.0 { 26.0 } else { 40.0 };
            // By time everybody has the nearest exit at first, for up to a second.
            let detour = if choice == "time" { 2.8 } else { 0.3 };
            assert!(walked < far + detour, "{choice}, {name}: {walked} m");
            assert!(
                (-0.6..3.4).contains(&(seconds - last)),
                "{choice}, {name}: {seconds} s instead of {last} s, at {there} m"
            );
            assert_eq!(there > 0.0, last < 29.0, "{choice}, {name}");
        }
    }
}

/// The outside: by hand. A body of two disks, 0.5 m before and behind its centre, lies across the door without touching it.
#[test]
fn who_lies_across_a_door_that_closes_walks_on() {
    let disks = vec![[0.5, 0.0, 0.1], [-0.5, 0.0, 0.1]];
    let share = |x: f64| {
        let mut plan =
            plan(&[room()], &[person(0, x, 2.0)], "exits = [{ line = [[9, 1], [9, 3]] }]").unwrap();
        plan.agents[0].disks.clone_from(&disks);
        plan.doors = vec![gate([[6.0, 1.5], [6.0, 2.5]], times(&[1e6, 2e6]))];
        Decision::new(plan).acts().unwrap()[0].drive.force[0] / (80.0 * 2.0 * 1.34)
    };
    assert!(
        (share(5.9) - 1.0).abs() < 1e-9 && (share(6.0) - 1.0).abs() < 1e-9,
        "{} {}",
        share(5.9),
        share(6.0)
    );
    // Before it: 0.7 m away it walks with 0.2 of the speed.
    assert!((share(5.3) - 0.2).abs() < 1e-9, "{}", share(5.3));
}

#[test]
fn who_has_left_stays_away_and_is_not_seen() {
    let config = format!("model = \"collision-free-speed\"\n{DOOR}");
    let people = [person(0, 6.5, 2.0), person(1, 5.9, 2.0)];
    let mut decision = Decision::new(plan(&[room()], &people, &config).unwrap());
    assert_eq!(decision.arrived().unwrap(), 1, "on the line");
    decision.pass(STEP).unwrap();
    // Carried back into the room, and left there for a step.
    let back = Pose::new(3.0, 2.0, 0.0);
    for _ in 0..2 {
        decision.see([back, Pose::new(2.6, 2.0, 0.0)].map(still).into_iter());
        decision.pass(STEP).unwrap();
    }
    let acts = decision.acts().unwrap();
    assert_eq!(acts[0], Act { drive: Default::default(), active: false });
    let speed = acts[1].drive.force[0] / 160.0;
    assert!((speed - 1.34).abs() < 0.05, "nobody is in the way: {speed}");
    // From one step to the next over the line, and far beyond it.
    let mut decision = Decision::new(plan(&[room()], &people[1..], &config).unwrap());
    decision.see(std::iter::once(still(Pose::new(6.1, 2.0, 0.0))));
    decision.pass(STEP).unwrap();
    decision.see(std::iter::once(still(Pose::new(7.5, 2.1, 0.0))));
    assert!(!decision.acts().unwrap()[0].active);
}

/// The outside: straight lines. It is 3 m to the exit; in front of it, people stop at 0.5 m.
#[test]
fn people_wait_in_front_of_a_closed_exit_and_leave_when_it_opens() {
    let config = "exits = [{ line = [[5, 0], [5, 4]], open = [[10, 12], [30, 40]] }]";
    let people = [person(0, 2.0, 2.0), person(1, 5.0, 2.0), person(2, -20.0, 2.0)];
    let ways = walk(plan(&[], &people, config).unwrap(), 1000);
    let left: Vec<f64> = (0..3).map(|who| alone(&ways, who).len() as f64 * STEP).collect();
    assert!((left[0] - 10.0 - 0.5 / 1.34).abs() < 0.2, "{left:?}");
    // Who stands on the line leaves in the step in which it opens; who comes after it has closed waits for the next time.
    assert!((left[1] - 10.0).abs() < 1.5 * STEP && (30.0..31.0).contains(&left[2]), "{left:?}");
    let waits = ways[190][0].unwrap();
    assert!((5.0 - waits.x - 0.5).abs() < 0.15 && (waits - ways[180][0].unwrap()).norm() < 0.01, "{waits:?}");
}

/// Two exits, the nearer one open for 2 s. With a state saved and restored at each step.
#[test]
fn those_on_their_way_to_an_exit_that_closes_turn_to_another() {
    for choice in ["distance", "time"] {
        let config = format!(
            "exit_choice = \"{choice}\"\nexits = [{{ line = [[0, 0], [0, 4]], open = [[0, 2]] }}, {{ line = [[20, 0], [20, 4]] }}]"
        );
        let people = [person(0, 8.0, 2.0), person(1, 1.5, 2.0)];
        let mut poses: Vec<Pose> = people.iter().map(|person| person.1.motion().pose).collect();
        let mut decision = Decision::new(plan(&[], &people, &config).unwrap());
        let mut forces = Vec::new();
        for step in 0..100 {
            decision.see(poses.iter().copied().map(still));
            let acts = decision.acts().unwrap();
            let saved = decision.save();
            decision.pass(STEP).unwrap();
            let after = decision.save();
            decision.restore(&saved).unwrap();
            decision.pass(STEP).unwrap();
            assert_eq!(decision.save(), after);
            for (pose, act) in poses.iter_mut().zip(&acts).filter(|(_, act)| act.active) {
                pose.position.x += STEP * act.drive.force[0] / 160.0;
            }
            forces.push(acts[0].drive.force[0]);
            assert_eq!(acts[1].active, step < 23, "{choice} {step}");
        }
        // By distance people see what is closed; by time they know before.
        let turns = forces.iter().position(|force| *force > 0.0).unwrap();
        let expected = if choice == "time" { 0..25 } else { 38..50 };
        assert!(
            expected.contains(&turns) && forces[turns..].iter().all(|force| *force > 0.0),
            "{choice} {turns}"
        );
    }
}

/// The outside: by hand. It is 4 s to the exit that opens after 8 s, and 11 s to the other one.
#[test]
fn who_chooses_by_time_waits_for_an_exit_that_opens_soon() {
    let leaves_left = |opens: f64| {
        let config = format!(
            "exit_choice = \"time\"\nexits = [{{ line = [[0, 0], [0, 4]], open = [[{opens}, 99]] }}, {{ line = [[20, 0], [20, 4]] }}]"
        );
        let way = walk(plan(&[], &[person(0, 5.36, 2.0)], &config).unwrap(), 600);
        alone(&way, 0).last().unwrap().x < 10.0
    };
    assert!(leaves_left(8.0) && !leaves_left(14.0));
}

#[test]
fn as_many_people_take_a_way_as_its_share_says() {
    let ways = "ways = [{ waypoints = [{ x = 0, y = 9 }], share = 7 }, { waypoints = [{ x = 9, y = 0 }], share = 3 }]";
    let people: Vec<Person> = (0..50).map(|k| person(k, k as f64, 2.0)).collect();
    let up = |seed: u32, more: &str| {
        let agents = plan(&[], &people, &format!("seed = {seed}\n{ways}\n{more}")).unwrap().agents;
        agents.iter().map(|agent| agent.walker.waypoints[0].y == 9.0).collect::<Vec<bool>>()
    };
    assert_eq!(up(1, "").iter().filter(|up| **up).count(), 35);
    assert!(up(1, "") == up(1, "") && up(1, "") != up(2, ""));
    // A way of somebody's own counts; a group has one way.
    let own = "groups.members = [[\"1\", \"2\", \"3\"]]\nagents.0.waypoints = [{ x = 1, y = 1 }]";
    for seed in 0..10 {
        let up = up(seed, own);
        assert!(!up[0] && up[1] == up[2] && up[2] == up[3]);
    }
}

/// Way-points first, then the exit; and nobody who only has way-points leaves.
#[test]
fn waypoints_come_before_the_exit() {
    let config = format!("waypoints = [{{ x = 1.0, y = 1.0 }}]\n{DOOR}");
    let way = alone(&walk(plan(&[room()], &[person(0, 4.0, 2.0)], &config).unwrap(), 600), 0);
    let nearest = way.iter().map(|at| (*at - vec2(1.0, 1.0)).norm()).fold(f64::INFINITY, f64::min);
    assert!(nearest < 0.35 && way.len() < 600, "{nearest}, {} steps", way.len());
}

#[test]
fn pushes_of_people_have_the_distribution_that_is_asked_for() {
    let people: Vec<Person> = (0..4000).map(|id| person(id, id as f64, 2.0)).collect();
    let config = "push = 150\npush_sd = 50\nseed = 3\nwaypoints = [{ x = 1, y = 1 }]\n[agents.7]\npush = 20";
    let plan = plan(&[], &people, config).unwrap();
    let pushes: Vec<f64> = plan.agents.iter().map(|agent| agent.walker.push).collect();
    let mean = pushes.iter().sum::<f64>() / 4000.0;
    let deviation = (pushes.iter().map(|push| (push - mean).powi(2)).sum::<f64>() / 4000.0).sqrt();
    // Within three standard errors; nearly nobody is below 0.
    assert!((mean - 150.0).abs() < 2.4 && (deviation - 50.0).abs() < 1.7, "{mean} {deviation}");
    assert!(pushes[7] == 20.0 && pushes.iter().all(|push| *push >= 0.0));
}

#[test]
fn mistakes_are_named() {
    let closed = [(0.0, 0.0), (6.0, 0.0), (6.0, 4.0), (0.0, 4.0), (0.0, 0.0)].map(|(x, y)| vec2(x, y));
    let people = [person(0, 2.0, 2.0), person("two words", 3.0, 2.0)];
    for line in include_str!("mistakes.txt").lines().filter(|line| !line.starts_with('#')) {
        let (config, words) = line.split_once(" | ").unwrap();
        let message =
            plan(&[closed.to_vec()], &people, &config.replace("\\n", "\n")).unwrap_err().to_string();
        assert!(words.split(" | ").all(|word| message.contains(word)), "{config}: {message}");
    }
    let nobody = plan(&[], &[], "waypoints = [{ x = 1, y = 2 }]").unwrap_err();
    assert!(matches!(nobody, PlanError::Impossible(message) if message.id == "plan.empty"));
}

#[test]
fn settings_are_for_everybody_or_for_one() {
    let people = [person(0, 0.0, 0.0), person("two words", 1.0, 0.0)];
    let own = "waypoints = [{ x = 0, y = 0, radius = 2 }, { x = 3, y = 4 }]";
    let config =
        format!("desired_speed = 1\nwaypoints = [{{ x = 1, y = 2.5 }}]\n[agents.\"two words\"]\n{own}");
    let agents = plan(&[], &people, &config).unwrap().agents;
    let radii = |k: usize| agents[k].walker.waypoints.iter().map(|point| point.radius).collect::<Vec<_>>();
    assert_eq!((radii(0), radii(1)), (vec![0.3], vec![2.0, 0.3]));
    assert!(agents.iter().all(|agent| agent.walker.desired_speed == 1.0));
}
