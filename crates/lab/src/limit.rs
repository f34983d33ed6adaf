//! How long people are above a limit of the squeeze, over frames of a run.
//!
//! A page asks a lab of its own, without a run, as it draws. It numbers what it asks about: a run, and one beside it.

use crate::frame::numbers;
use crate::{Refused, Reply, require, within};
use lemons_results::measure::{Above, Exposed, SPANS, SqueezeOverTime};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// How many are known at a time.
const MOST: u32 = 4;

/// Place of 1 s among [`SPANS`].
const SECOND: usize = 1;
const _: () = assert!(SPANS[SECOND] == 1.0);

/// Frames more about a limit.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(deny_unknown_fields)]
pub struct LimitRequest {
    /// Number of what is asked about, below [`MOST`].
    number: u32,
    people: usize,
    /// \[s\] Of a communication step.
    step: f64,
    /// \[N\]
    limit: f64,
    /// \[s\] Of means that are compared with it.
    over: f64,
    /// Place of the first frame; 0 begins anew.
    from: u64,
}

/// How long people were above a limit.
#[derive(Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub(crate) struct Limit {
    /// `None`: the run is shorter than the means, or a step is longer.
    above: Option<AboveLimit>,
    /// `None`: nobody was squeezed yet over the time of its means.
    worst: Option<Sustained>,
}

/// The greatest of everybody's means of 1 s.
#[derive(Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub(crate) struct Sustained {
    /// \[N\]
    squeeze: f64,
    who: usize,
    /// \[s\] When it ends.
    at: f64,
}

/// People above a limit, and how long \[s\].
#[derive(Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub(crate) struct AboveLimit {
    people: usize,
    /// `None`: never.
    first: Option<f64>,
    /// The person who was above it longest without a break, and how long.
    who: usize,
    longest: f64,
    /// Of all of them.
    time: f64,
}

/// Search for times above a limit, as far as frames have come.
pub struct LimitProgress {
    of: LimitRequest,
    /// Place of the next frame.
    next: u64,
    exposure: SqueezeOverTime,
}

/// Adds frames. The bytes have a double for each person of each frame: the squeeze \[N\], not a number for who has left. The
/// answer: how many were above the limit, when at first \[s\], who was longest without a break and how long \[s\], and the time
/// of all of them \[s\], null if the run is shorter than the means, or a step is longer; and the greatest mean of 1 s.
///
/// # Errors
/// The bytes are no frames, or not those that are next.
pub fn add(
    limits: &mut BTreeMap<u32, LimitProgress>,
    wanted: &LimitRequest,
    bytes: &[u8],
) -> Result<Reply, Refused> {
    let LimitRequest { number, people, step, limit, over, from } = *wanted;
    require(number < MOST, || format!("number {number}: must be below {MOST}"))?;
    within("communication step [s]", step, [1e-9, 1e9])?;
    within("limit of the squeeze [N]", limit, [0.0, 1e9])?;
    within("time of means [s]", over, [1e-3, 1e4])?;
    require(people > 0 && bytes.len().is_multiple_of(8 * people), || {
        format!("{} bytes are not frames of {people} people", bytes.len())
    })?;
    let mut known = match limits.remove(&number) {
        _ if from == 0 => LimitProgress {
            of: *wanted,
            next: 0,
            exposure: SqueezeOverTime::new(people, &[limit], Some(over)),
        },
        Some(known)
            if known.next == from && known.of == (LimitRequest { from: known.of.from, ..*wanted }) =>
        {
            known
        }
        _ => {
            return Err(Refused::from(format!("frame {from} is not the next one of this limit: begin anew")));
        }
    };
    for frame in numbers(bytes).chunks(people) {
        let squeeze = frame.iter().map(|&squeeze| squeeze.is_finite().then_some((squeeze, squeeze)));
        known.exposure.add(known.next as f64 * step, squeeze);
        known.next += 1;
    }
    let so_far = known.exposure.so_far();
    limits.insert(number, known);
    let sustained = |(who, one): (usize, &Exposed)| {
        let squeeze = one.largest_mean[SECOND].filter(|squeeze| *squeeze > 0.0)?;
        Some(Sustained { squeeze, who, at: one.largest_mean_at[SECOND] })
    };
    let worst = so_far.iter().enumerate().filter_map(sustained);
    let worst = worst.reduce(|one, other| if other.squeeze > one.squeeze { other } else { one });
    let all: Option<Vec<Above>> = so_far.iter().map(|one| one.above[0]).collect();
    let above = all.map(|all| {
        let first = all.iter().filter_map(|one| one.first);
        let who = (1..people).fold(0, |a, b| if all[b].longest > all[a].longest { b } else { a });
        AboveLimit {
            people: first.clone().count(),
            first: first.reduce(f64::min),
            who,
            longest: all[who].longest,
            time: all.iter().map(|one| one.time).sum(),
        }
    });
    Reply::of(Limit { above, worst })
}
