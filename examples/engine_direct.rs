//! The engine called directly, without FMI: reads a Trial, pushes its agents as a CSV file says
//! (`t,agent,Fp.x,Fp.y,Mp`), prints the same table that `lemons run` writes.
//!
//! ```text
//! cargo run --release --example engine_direct -- resources/Trial_push --steps 40 --drive resources/Trial_push/drive.csv
//! ```

use crowd_mechanics::engine::{World, Wrench, vec2};
use crowd_mechanics::setup::{self, Setup};
use lemons_core::trial::Trial;
use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

/// For each driven agent, by its place in Agents.xml: times \[s\] with Fp.x, Fp.y \[N\] and Mp \[N.m\].
type Drive = BTreeMap<usize, Vec<(f64, [f64; 3])>>;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let after = |name: &str| Some(&arguments[arguments.iter().position(|a| a == name)? + 1..][0]);
    let directory = arguments.first().ok_or("usage: engine_direct TRIAL --steps N [--drive FILE.csv]")?;

    let (trial, _warnings) = setup::read(directory.as_ref()).map_err(|problems| problems.to_string())?;
    let steps: u64 = after("--steps").ok_or("--steps is missing")?.parse()?;
    let drive = after("--drive").map_or(Ok(Drive::new()), |path| read_drive(path.as_ref(), &trial))?;

    let mut world = Setup::of(&trial).world()?;
    println!(
        "t,id,x,y,vx,vy,theta,omega,agent_contacts,wall_contacts,contacting_agents,normal_force,\
         mean_normal_force,peak_normal_force,peak_overlap,mean_wall_force,total_agent_contacts,total_wall_contacts"
    );
    print(&trial, &world, 0.0);
    let mut time = 0.0;
    for k in 1..=steps {
        for (&agent, rows) in &drive {
            world.drive[agent] = push(rows, time);
        }
        // Communication points are multiples of TimeStep, not sums of it.
        let end = k as f64 * trial.parameters.time_step;
        world.advance(end - time)?;
        time = end;
        print(&trial, &world, time);
    }
    Ok(())
}

fn print(trial: &Trial, world: &World, time: f64) {
    let (state, all) = (world.state(), world.contacts());
    for (i, agent) in trial.agents.iter().enumerate() {
        let (pose, twist) = (&state.poses[i], &state.twists[i]);
        let (contacts, step) = (&all.bodies[i], &world.exposures()[i]);
        println!(
            "{time:?},{},{:?},{:?},{:?},{:?},{:?},{:?},{},{},{},{:?},{:?},{:?},{:?},{:?},{},{}",
            agent.id,
            pose.position.x,
            pose.position.y,
            twist.velocity.x,
            twist.velocity.y,
            pose.orientation,
            twist.angular_velocity,
            contacts.agent_contacts,
            contacts.wall_contacts,
            contacts.touching_bodies,
            contacts.squeeze,
            step.mean_force,
            step.peak_force,
            step.peak_overlap,
            step.mean_wall_force,
            all.agent_contacts,
            all.wall_contacts,
        );
    }
}

/// Linear between the rows, zero before the first and after the last.
fn push(rows: &[(f64, [f64; 3])], time: f64) -> Wrench {
    let after = rows.partition_point(|row| row.0 <= time);
    let [x, y, torque] = match (rows[..after].last(), rows.get(after)) {
        (Some((t0, a)), Some((t1, b))) => {
            let share = (time - t0) / (t1 - t0);
            std::array::from_fn(|k| a[k] + share * (b[k] - a[k]))
        }
        (Some((t0, a)), None) if *t0 == time => *a,
        _ => [0.0; 3],
    };
    Wrench { force: vec2(x, y), torque }
}

fn read_drive(path: &Path, trial: &Trial) -> Result<Drive, Box<dyn Error>> {
    let text = std::fs::read_to_string(path)?;
    let rows = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    let mut drive = Drive::new();
    for line in rows {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        let [time, id, x, y, torque] = cells[..] else { return Err(format!("not 5 columns: {line}").into()) };
        let agent = trial.agents.iter().position(|agent| agent.id == id).ok_or("an unknown agent")?;
        let row = (time.parse()?, [x.parse()?, y.parse()?, torque.parse()?]);
        drive.entry(agent).or_default().push(row);
    }
    Ok(drive)
}
