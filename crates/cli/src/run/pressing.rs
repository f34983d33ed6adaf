//! People who walk straight on, whoever is in the way, and press instead of getting on.

use crate::crowd_run::agents_of;
use anyhow::Result;
use lemons_decision::gait::Gait;
use lemons_master::{Component, System, plan_in};
use lemons_record::columns::MEAN_SQUEEZE;

/// Part of the desired speed: who is slower and touched gets no further.
const STUCK: f64 = 0.1;

/// What is said at the end of a run with the model `straight` if more than half of the people who are `there` are pushed,
/// want to walk and get no further.
pub fn pressing(system: &System, there: usize) -> Result<Option<String>> {
    let all = || system.components().iter();
    let decider = all().find_map(|part| Some((part, plan_in(&part.fmu)?)));
    let Some((decider, plan)) = decider.filter(|(_, plan)| plan.gait == Gait::Straight) else {
        return Ok(None);
    };
    let people = plan.agents.len();
    let Some(crowd) = all().find(|part| agents_of(&part.fmu.description) == people) else { return Ok(None) };
    let read = |part: &Component, name: &str| {
        let all = part.instance.select((0..people).map(|i| format!("agent[{i}].{name}")))?;
        let mut values = vec![0.0; people];
        part.instance.get_real(&all, &mut values)?;
        Ok::<_, anyhow::Error>(values)
    };
    let [fx, fy, speed] = ["Fp.x", "Fp.y", "DesiredSpeed"].map(|name| read(decider, name));
    let [vx, vy, squeeze] = ["Velocity.x", "Velocity.y", MEAN_SQUEEZE.variable].map(|name| read(crowd, name));
    let (fx, fy, speed, vx, vy, squeeze) = (fx?, fy?, speed?, vx?, vy?, squeeze?);
    let stuck = |i: &usize| {
        fx[*i].hypot(fy[*i]) > 0.0 && squeeze[*i] > 0.0 && vx[*i].hypot(vy[*i]) < STUCK * speed[*i]
    };
    let mut squeezed: Vec<f64> = (0..people).filter(stuck).map(|i| squeeze[i]).collect();
    squeezed.sort_by(f64::total_cmp);
    let stuck = squeezed.len();
    Ok((2 * stuck > there && stuck > 1).then(|| {
        format!(
            "warning: at t = {:.3} s {stuck} of the {there} people who are there press on and get no further (median squeeze \
             {:.0} N): in the model \"straight\" people walk on, whoever is in the way (in decision.toml, model = \
             \"collision-free-speed\" makes them keep distances)",
            system.time(),
            squeezed[stuck / 2]
        )
    }))
}
