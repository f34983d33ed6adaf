use super::*;
use lemons_core::plane::vec2;
use lemons_core::trial::{Agent, AgentDynamics, DriveTable, OpeningTimes, Trial};
use lemons_decision::{DecisionConfig, Plan};
use lemons_fmi::{
    FmuFormat, Model, Slave, Step, StepError, Version, description, instantiation_token, reference,
};
use lemons_sim::lint::RunEnd;

const STEP: f64 = 0.0625;

fn documents(trial: Trial, config: &str) -> Documents {
    let plan = Plan::of(&trial, &DecisionConfig::from_toml(config).unwrap()).unwrap();
    Documents::new(trial, DriveTable::default(), Some(plan))
}

/// Thirty people who leave a room by its door; each straight piece of its wall is a panel.
fn room() -> Documents {
    let mut trial = Trial::read(&lemons_testing::trial_door()).unwrap().0;
    trial.geometry.walls[0].panel_length = Some(100.0);
    trial.parameters.time_step = STEP;
    documents(trial, LEAVING)
}

const LEAVING: &str =
    "model = \"collision-free-speed\"\nexits = [{ name = \"door\", line = [[5.1, 2.05], [5.1, 2.95]] }]";
const FRONT: [f64; 4] = [2.5, 1.0, 5.0, 4.0];
/// Beside the door.
const PANELS: [usize; 2] = [3, 7];

fn front() -> SummaryConfig {
    let areas = vec![AreaConfig { name: "front".into(), corners: FRONT.to_vec() }];
    SummaryConfig { limit: Some(100.0), areas, panels: PANELS.to_vec(), ..SummaryConfig::default() }
}

/// People at places \[m\], without walls.
fn people(places: &[[f64; 2]]) -> Trial {
    let mut trial = Trial::read(&lemons_testing::trial_door()).unwrap().0;
    trial.geometry.walls.clear();
    trial.parameters.time_step = STEP;
    let (person, dynamics) = (trial.agents[0].clone(), trial.dynamics[0].clone());
    let id = |k: usize| k.to_string();
    trial.agents = (0..places.len()).map(|k| Agent { id: id(k), ..person.clone() }).collect();
    let at = |at: &[f64; 2]| AgentDynamics { position: (*at).into(), ..dynamics.clone() };
    trial.dynamics = places.iter().map(at).collect();
    trial
}

fn place(name: &str) -> usize {
    QUANTITIES.iter().position(|row| row.name == name).unwrap_or_else(|| panic!("{name}"))
}

impl Summary {
    fn value(&self, name: &str) -> f64 {
        self.values[place(name)]
    }

    fn put(&mut self, name: &str, value: f64) {
        self.values[place(name)] = value;
    }

    fn to(&mut self, time: f64) {
        let from = (self.simulation.time() / STEP).round() as usize;
        (from + 1..=(time / STEP).round() as usize).for_each(|k| self.step_to(k as f64 * STEP).unwrap());
    }
}

fn begun(documents: Documents, config: &SummaryConfig) -> Summary {
    let mut summary = Summary::new(documents, config).unwrap();
    summary.initialize(0.0).unwrap();
    summary
}

/// The outside: the frames of a run without it, and sums over them by hand.
#[test]
fn outputs_are_those_of_the_frames_of_a_run() {
    let mut summary = begun(room(), &front());
    let mut alone = Simulation::new(room(), Algorithm::Jacobi).unwrap();
    alone.begin(0.0, None).unwrap();
    let (mut end, mut frames) = (RunEnd::default(), vec![alone.frame()]);
    end.see(alone.frame());
    let lengths: Vec<f64> =
        alone.trial().geometry.panels().map(|(_, ends)| (ends[1] - ends[0]).norm()).collect();
    let (mut loaded, mut queued, mut above, mut flows) = (false, 0.0_f64, 0.0_f64, 0.0_f64);
    for k in 1..=400 {
        let time = f64::from(k) * STEP;
        alone.step_to(time).unwrap();
        summary.to(time);
        let frame = alone.frame();
        end.see(frame.clone());
        let left = end.departures.len() as f64;
        assert_eq!(summary.value("exit1_left"), left);
        assert_eq!((summary.value("people_left"), summary.value("people_inside")), (left, 30.0 - left));
        let recent = end.departures.iter().filter(|(at, _)| *at > time - 10.0).count() as f64;
        let flow = summary.value("exit1_flow");
        assert!((flow - recent / time.min(10.0)).abs() < 1e-12);
        let inside = |at: lemons_core::plane::Vec2| {
            FRONT[0] < at.x && at.x < FRONT[2] && FRONT[1] < at.y && at.y < FRONT[3]
        };
        let those: Vec<usize> =
            frame.present().filter(|(_, of)| inside(of.pose.position)).map(|(k, _)| k).collect();
        assert_eq!(summary.value("area1_density"), those.len() as f64 / 7.5);
        let waits = frame.present().filter(|(_, of)| {
            let at = of.pose.position;
            let off = (5.1 - at.x).hypot(at.y - at.y.clamp(2.05, 2.95));
            off <= 10.0 && of.twist.velocity.norm() < 0.3
        });
        assert_eq!(summary.value("exit1_queue"), waits.count() as f64);
        frames.push(frame);
        let last = &frames[frames.len() - 1];
        for (name, panel) in ["barrier1_load", "barrier2_load"].into_iter().zip(PANELS) {
            let force = last.panels.as_ref().unwrap()[panel].mean_normal_force;
            assert_eq!(summary.value(name), force / lengths[panel]);
            loaded |= force > 0.0;
        }
        // Means over a second are those of sixteen steps.
        let mean = |agent: &usize| {
            let of = |frame: &Frame| squeeze(frame, *agent, None).map_or(0.0, |(mean, _)| mean);
            frames[frames.len().saturating_sub(16)..].iter().map(of).sum::<f64>() / 16.0
        };
        let mut means: Vec<f64> = if k < 16 { Vec::new() } else { those.iter().map(mean).collect() };
        means.sort_by(f64::total_cmp);
        let near = |name: &str, expected: f64| {
            let value = summary.value(name);
            assert!((value - expected).abs() <= 1e-8 * expected.abs() + 1e-6, "{name} {value} {expected}");
        };
        let greatest = means.last().copied().unwrap_or_default();
        near("area1_squeeze_max", greatest);
        near("area1_squeeze_mean", means.iter().sum::<f64>() / (means.len() as f64).max(1.0));
        if !means.is_empty() {
            let at = 0.95 * (means.len() - 1) as f64;
            let (low, high) = (means[at.floor() as usize], means[at.ceil() as usize]);
            near("area1_squeeze_95", low + (high - low) * at.fract());
        }
        let count = means.iter().filter(|mean| **mean > 100.0).count() as f64;
        if means.iter().all(|mean| (mean - 100.0).abs() > 1e-6) {
            assert_eq!(summary.value("area1_above"), count);
        }
        (queued, above, flows) =
            (queued.max(summary.value("exit1_queue")), above.max(count), flows.max(flow));
    }
    assert!(summary.value("exit1_left") > 5.0 && queued > 3.0 && above > 0.0 && flows > 0.1, "it is seen");
    assert!(loaded, "somebody leans on the wall");
}

#[test]
fn a_state_goes_on_with_the_same_bits() {
    let run = |summary: &mut Summary| {
        summary.put("stop", 0.0);
        summary.put("push", 40.0);
        summary.to(10.0);
        summary.values.iter().map(|value| value.to_bits()).collect::<Vec<_>>()
    };
    let mut summary = begun(room(), &front());
    for (name, value) in [("speed_factor", 1.5), ("exit1_open", 0.0), ("push", 20.0)] {
        summary.put(name, value);
    }
    summary.to(5.0);
    summary.put("stop", 1.0);
    summary.put("exit1_open", 1.0);
    summary.to(6.0);
    let saved = summary.save();
    let whole = run(&mut summary);
    // Into another instance, before it has begun, and into one that is elsewhere.
    let mut other = Summary::new(room(), &front()).unwrap();
    other.restore(&saved).unwrap();
    assert_eq!(other.save(), saved);
    assert_eq!(run(&mut other), whole);
    summary.to(12.0);
    summary.restore(&saved).unwrap();
    assert_eq!(run(&mut summary), whole);
    summary.reset().unwrap();
    summary.initialize(0.0).unwrap();
    assert_eq!(summary.values, begun(room(), &front()).values);
    let mut damaged = saved.clone();
    damaged.values[place("push")] = -1.0;
    assert!(summary.restore(&damaged).is_err());
}

/// The outside: who walks alone comes to v₀, and a force adds F / (m / t).
#[test]
fn everybody_walks_as_the_inputs_say() {
    let own = &people(&[[0.0, 0.0]]).agents[0];
    let braked = own.mass * own.floor_damping;
    let far = "desired_speed = 1.2\nexits = [{ name = \"a\", line = [[900, -5], [900, 5]] }]";
    for (name, value, speed) in [
        ("speed_factor", 1.0, 1.2),
        ("speed_factor", 0.5, 0.6),
        ("speed_factor", 0.0, 0.0),
        ("push", 50.0, 1.2 + 50.0 / braked),
        ("stop", 1.0, 0.0),
    ] {
        // By an exit, and by a way-point, to which the paper's rule leads.
        for config in [far.to_owned(), format!("waypoints = [{{ x = 800, y = 0 }}]\n{far}")] {
            let mut summary = begun(documents(people(&[[0.0, 0.0]]), &config), &SummaryConfig::default());
            summary.to(1.0);
            summary.put(name, value);
            summary.to(10.0);
            let now = summary.simulation.frame().agents[0].twist.velocity;
            assert!((now - vec2(speed, 0.0)).norm() < 1e-6, "{name} {value}: {now:?}, {config}");
        }
    }
}

/// The outside: a Poisson process of twice the rate is one of twice the time.
#[test]
fn arrivals_come_at_the_rate_of_the_input() {
    let places: Vec<[f64; 2]> = (0..60).map(|k| [2.0 * f64::from(k), 0.0]).collect();
    let ids: Vec<String> = (0..60).map(|k| format!("{k:?}", k = k.to_string())).collect();
    let config = format!(
        "goals = [{{ line = [[0, 50], [200, 50]] }}]\n[[sources]]\npeople = [{}]\nrate = 1.5\nstart = 2.0",
        ids.join(", ")
    );
    let documents = documents(people(&places), &config);
    let due = documents.plan.as_ref().unwrap().sources[0].clone();
    let mut summary = begun(documents, &SummaryConfig::default());
    assert_eq!(summary.value("arrivals"), 1.5);
    // From 5 s on three per second, from 10 s on nobody, from 12 s on as planned.
    let clock = |time: f64| time + (time.clamp(5.0, 10.0) - 5.0) - (time.clamp(10.0, 12.0) - 10.0);
    for k in 1..=20 {
        let rate = match k {
            ..=5 => 1.5,
            6..=10 => 3.0,
            11 | 12 => 0.0,
            _ => 1.5,
        };
        summary.put("arrivals", rate);
        let time = f64::from(k);
        summary.to(time);
        // They are there from the step on that begins when they are due.
        let there = due.due(clock(time - STEP)) as f64;
        assert_eq!(summary.value("people_inside"), there, "{time}");
    }
    assert!(summary.value("people_inside") > 20.0);
}

#[test]
fn exits_and_doors_that_are_shut_let_nobody_through() {
    let shut_at = |name: &str, documents: Documents| {
        let mut summary = begun(documents, &front());
        summary.to(2.0);
        summary.put(name, 0.0);
        // Who is in a door when it closes walks on.
        summary.to(4.0);
        let before = summary.value("exit1_left");
        summary.to(15.0);
        assert_eq!(summary.value("exit1_left"), before, "{name}");
        summary.put(name, 1.0);
        summary.to(25.0);
        assert!(summary.value("exit1_left") > before + 3.0, "{name}");
    };
    shut_at("exit1_open", room());
    // A door across the room, which its times never close.
    let mut trial = Trial::read(&lemons_testing::trial_door()).unwrap().0;
    let material = trial.geometry.walls[0].material_id.clone();
    let ends = vec![vec2(5.0, 2.05), vec2(5.0, 2.95)];
    let always = Some(OpeningTimes::of_numbers(&[0.0, 1e6]).unwrap());
    trial.geometry.walls.push(lemons_core::trial::Wall {
        open: always,
        ..lemons_core::trial::Wall::new("gate", material, ends)
    });
    trial.geometry.walls[0].panel_length = Some(100.0);
    trial.parameters.time_step = STEP;
    shut_at("door1_open", documents(trial, LEAVING));
}

#[test]
fn more_than_fits_is_refused_with_what_to_do() {
    let exits = (0..5).map(|k| format!("{{ name = \"e{k}\", line = [[8.0, {k}], [8.0, {k}.5]] }}"));
    let config = format!("exits = [{}]", exits.collect::<Vec<_>>().join(", "));
    let five = || documents(people(&[[0.0, 0.0]]), &config);
    let refused = |config: SummaryConfig| Summary::new(five(), &config).err().unwrap().to_string();
    let told = refused(SummaryConfig::default());
    let first = "there are 5 exits, and a summary has room for 4: choose with --exit NAME, in the order of exit1 to exit4:\n  exit \
                 \"e0\": (8.0, 0.0) (8.0, 0.5) m\n";
    assert!(told.starts_with(first) && told.ends_with("\n  exit \"e4\": (8.0, 4.0) (8.0, 4.5) m"), "{told}");
    let chosen = |names: &[&str]| SummaryConfig {
        exits: names.iter().map(ToString::to_string).collect(),
        ..SummaryConfig::default()
    };
    assert_eq!(
        refused(chosen(&["e3", "e3"])),
        "--exit NAME e3: is given twice (there are e0, e1, e2, e3, e4)"
    );
    assert!(refused(chosen(&["door"])).starts_with("--exit NAME door: is not there"));
    let bow = AreaConfig { name: "bow".into(), corners: vec![0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 1.0] };
    let bow = SummaryConfig { areas: vec![bow], ..chosen(&["e0"]) };
    assert!(refused(bow).contains("\"bow\" must be"));
    assert!(refused(SummaryConfig { limit: Some(0.0), ..chosen(&["e0"]) }).contains("limit of 0.0 N"));
    // In the order that was chosen.
    let summary = Summary::new(five(), &chosen(&["e3", "e1"])).unwrap();
    assert_eq!((&summary.slots.exits[..], &*summary.slots.operated[1].1), (&[3, 1][..], "exit[1]"));
    let text = chosen(&["e3", "e1"]).to_toml().unwrap();
    assert_eq!(SummaryConfig::from_toml(&text).unwrap(), chosen(&["e3", "e1"]));
}

#[test]
fn what_is_not_there_is_not_described_and_has_no_value() {
    let mut summary = Summary::new(room(), &SummaryConfig { areas: Vec::new(), ..front() }).unwrap();
    let names: Vec<String> = summary.scalars().into_iter().map(|scalar| scalar.name).collect();
    assert!(
        names.iter().any(|name| name == "exit1_queue") && !names.iter().any(|name| name == "exit2_queue")
    );
    let xml = description::model_description(&mut summary, FmuFormat::Fmi3).unwrap();
    assert_eq!(xml.matches(" name=\"exit1_queue\"").count(), 1);
    assert!(xml.contains("exit &quot;door&quot;: people who have left by it") && !xml.contains("exit2"));
    assert!(!xml.contains("people_fallen") && !xml.contains("arrivals") && !xml.contains("area1"));
    let token = instantiation_token::<Summary>().to_string();
    let mut slave = Slave::new(summary, Version::V3, &token).unwrap();
    slave.setup_experiment(0.0, None, None).unwrap();
    slave.enter_initialization().unwrap();
    let of = |name: &str| reference::<Summary>(QUANTITIES[place(name)].quantity).unwrap();
    let mut value = [0_i32];
    slave.get(&[of("people_inside")], &mut value).unwrap();
    assert_eq!(value, [30], "before initialization ends");
    assert!(slave.get(&[of("exit2_queue")], &mut value).is_err());
    assert!(slave.get::<i32>(&[of("exit2_queue")], &mut []).is_ok(), "as of an array of size 0");
    assert!(slave.set(&[of("arrivals")], &[1.0]).is_err());
    slave.exit_initialization().unwrap();
    slave.step(0.0, STEP).unwrap();
    // Without people who walk, only the crowd is there.
    let trial = Trial::read(&lemons_testing::trial_push()).unwrap().0;
    let documents = Documents::new(trial, DriveTable::default(), None);
    let mut standing = begun(documents, &SummaryConfig { panels: Vec::new(), ..front() });
    let names: Vec<String> = standing.scalars().into_iter().map(|scalar| scalar.name).collect();
    assert_eq!(names[names.len() - 2..], ["people_left", "people_inside"]);
    standing.advance(Step::of(0.0, STEP)).unwrap();
    assert_eq!(standing.value("people_inside"), 5.0);
}

#[test]
fn a_step_that_the_crowd_refuses_can_be_another_one() {
    let with = |step: f64, mechanical: f64| {
        let mut documents = room();
        documents.trial.parameters.time_step = step;
        documents.trial.parameters.time_step_mechanical = mechanical;
        begun(documents, &front())
    };
    // More mechanical steps than MostMechanicalSteps, and fewer.
    let mut summary = with(20.0, 1e-8);
    let Err(StepError::Refused(refusal)) = summary.advance(Step::of(0.0, 15.0)) else {
        panic!("it is refused")
    };
    assert!(refusal.message.contains("MostMechanicalSteps"), "{}", refusal.message);
    let mut other = with(20.0, 1e-8);
    for summary in [&mut summary, &mut other] {
        summary.advance(Step::of(0.0, 1e-5)).unwrap();
    }
    assert_eq!(summary.simulation.save(), other.simulation.save());
}

#[test]
fn an_area_where_nobody_is_and_a_crowd_that_does_not_walk_are_noted() {
    let area = |name: &str, corners: [f64; 4]| AreaConfig { name: name.into(), corners: corners.to_vec() };
    let areas =
        vec![area("in", FRONT), area("partly", [-9.0, 0.0, 1.0, 1.0]), area("far", [60.0, 0.0, 70.0, 5.0])];
    let config = SummaryConfig { areas, ..front() };
    let [far] = &config.notes(&room())[..] else { panic!("one note") };
    assert!(far.starts_with("the area \"far\" is outside of the walls around people"), "{far}");
    let standing = Documents { plan: None, ..room() };
    assert!(config.notes(&standing)[0].starts_with("nobody walks"));
}

/// The outside: the same with shorter communication steps.
#[test]
fn a_long_step_is_made_of_steps_of_the_trial() {
    let [mut short, mut long] = [(); 2].map(|()| Summary::new(room(), &front()).unwrap());
    short.begin(0.0).unwrap();
    long.begin(0.0).unwrap();
    let names = ["barrier1_load", "barrier2_load"];
    let mut pressed = 0.0;
    for k in 1..=24 {
        let mut means = [0.0; 2];
        for part in 1..=4 {
            short.step_to((4 * (k - 1) + part) as f64 * STEP).unwrap();
            means.iter_mut().zip(names).for_each(|(mean, name)| *mean += short.value(name) / 4.0);
        }
        long.step_to(k as f64 * 4.0 * STEP).unwrap();
        for (row, (of_short, of_long)) in QUANTITIES.iter().zip(short.values.iter().zip(&long.values)) {
            let load = names.iter().position(|name| *name == row.name);
            let wanted = load.map_or(*of_short, |place| means[place]);
            assert!((wanted - of_long).abs() <= 1e-12 * wanted.abs(), "{}", row.name);
        }
        pressed += means[0] + means[1];
        assert_eq!(short.simulation.save(), long.simulation.save());
    }
    assert!(pressed > 0.0 && short.value("exit1_left") > 0.0);
}
