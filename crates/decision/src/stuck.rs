//! People who do not get on give way, so that no arch in a door holds for ever.
//!
//! A person who wants to walk and gets on at less than a tenth of the desired speed, averaged over a second, is stuck.
//! After one to two seconds the person does something else for half a second to a second, and longer each time it does
//! not help, up to five times as long: steps back, sidles to the
//! left or to the right, stands still, or insists. Which, and for how long, follows from a seed, the person and how
//! often this has happened: the same on every machine, and for any number of threads.

use lemons_core::plane::{InPlane, Vec2};
use serde::{Deserialize, Serialize};

/// \[s\] Time over which the progress is averaged.
const MEMORY: f64 = 1.0;
/// Part of the desired speed: who is slower is stuck.
const STUCK: f64 = 0.1;
/// \[s\] Shortest time for which people stay stuck, and by how much it may be longer.
const WAIT: [f64; 2] = [1.0, 1.0];
/// \[s\] Shortest time for which they do something else at first, and by how much it may be longer.
const GIVE_WAY: [f64; 2] = [0.5, 0.5];
/// Part by which it takes longer each time it has not helped, and how often at most.
const LONGER: (f64, u32) = (0.5, 8);
/// Part of the desired speed for steps back and to the side.
const SLOWLY: f64 = 0.5;

/// Action of somebody who was stuck.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
enum Manoeuvre {
    Back,
    Left,
    Right,
    Stand,
    /// Walks on as if nobody was in the way.
    Insist,
}

/// Progress of somebody.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct StuckState {
    /// \[m/s\] Mean progress towards where the person wants to go.
    progress: f64,
    /// \[s\] For how long the person is stuck.
    stuck: f64,
    /// Manoeuvre instead, and for how long yet \[s\].
    instead: Option<(Manoeuvre, f64)>,
    /// Number of manoeuvres.
    times: u32,
    /// Number of those since the person got on.
    in_vain: u32,
}

/// Action of a person, besides the model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StuckAction {
    /// Walk as the model says.
    Walk,
    /// Walk with this velocity \[m/s\], facing as before.
    Step(Vec2),
    /// Walk straight on at this speed \[m/s\].
    Insist(f64),
}

/// A number that depends on a seed, a person and a count (SplitMix64: Steele, Lea, Flood, OOPSLA 2014).
pub fn draw(seed: u64, person: u64, count: u64) -> u64 {
    [person, count].into_iter().fold(seed, |state, part| {
        let mut z =
            state.wrapping_add(part.wrapping_mul(0x9E37_79B9_7F4A_7C15)).wrapping_add(0x9E37_79B9_7F4A_7C15);
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    })
}

/// Returns a random number in \[0, 1).
pub fn share(seed: u64, person: u64, count: u64) -> f64 {
    (draw(seed, person, count) >> 11) as f64 / (1u64 << 53) as f64
}

/// Returns a random number with a standard normal distribution, from two draws (Box, Muller 1958).
pub(crate) fn normal(seed: u64, person: u64, count: u64) -> f64 {
    // Other numbers than those of manoeuvres.
    let [a, b] = [2 * count, 2 * count + 1].map(|count| share(!seed, person, count));
    (-2.0 * libm::log(1.0 - a)).sqrt() * libm::cos(2.0 * std::f64::consts::PI * b)
}

impl StuckState {
    /// Follows a person over a step \[s\] by a way \[m\]. `wanted` is the direction and the desired speed \[m/s\], if the
    /// person wants to walk.
    pub fn follow(&mut self, step: f64, way: Vec2, wanted: Option<(Vec2, f64)>, seed: u64, person: u64) {
        let Some((direction, speed)) = wanted.filter(|(_, speed)| *speed > 0.0) else {
            *self = StuckState { times: self.times, ..StuckState::default() };
            return;
        };
        if let Some((_, left)) = &mut self.instead {
            *left -= step;
            if *left <= 0.0 {
                (self.instead, self.stuck) = (None, 0.0);
            }
            return;
        }
        let weight = (step / MEMORY).min(1.0);
        self.progress += weight * (way.dot(&direction) / step - self.progress);
        if self.progress >= STUCK * speed {
            (self.stuck, self.in_vain) = (0.0, 0);
            return;
        }
        self.stuck += step;
        let count = 3 * u64::from(self.times);
        if self.stuck > WAIT[0] + WAIT[1] * share(seed, person, count) {
            use Manoeuvre::{Back, Insist, Left, Right, Stand};
            let all = [Back, Left, Right, Stand, Insist, Insist];
            let which = all[(share(seed, person, count + 1) * all.len() as f64) as usize];
            let longer = 1.0 + LONGER.0 * f64::from(self.in_vain.min(LONGER.1));
            let time = longer * (GIVE_WAY[0] + GIVE_WAY[1] * share(seed, person, count + 2));
            self.instead = Some((which, time));
            (self.times, self.in_vain) = (self.times.wrapping_add(1), self.in_vain.saturating_add(1));
        }
    }

    /// Returns whether the person does not get on.
    pub fn is_stuck(&self) -> bool {
        self.stuck > 0.0
    }

    /// Returns what the person does who wants to go in a direction at a speed \[m/s\].
    pub fn action(&self, direction: Vec2, speed: f64) -> StuckAction {
        let slowly = SLOWLY * speed;
        match self.instead {
            None => StuckAction::Walk,
            Some((Manoeuvre::Back, _)) => StuckAction::Step(direction * -slowly),
            Some((Manoeuvre::Left, _)) => StuckAction::Step(direction.left() * slowly),
            Some((Manoeuvre::Right, _)) => StuckAction::Step(direction.left() * -slowly),
            Some((Manoeuvre::Stand, _)) => StuckAction::Step(Vec2::zeros()),
            Some((Manoeuvre::Insist, _)) => StuckAction::Insist(slowly),
        }
    }

    /// Returns whether the numbers are possible.
    pub fn is_sound(&self) -> bool {
        let left = self.instead.map_or(0.0, |(_, left)| left);
        [self.progress, self.stuck, left].iter().all(|number| number.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lemons_core::plane::vec2;

    const AHEAD: Vec2 = vec2(1.0, 0.0);

    fn follow(state: &mut StuckState, speed: f64, seconds: f64, person: u64) -> Vec<StuckAction> {
        let steps = (seconds / 0.05) as usize;
        (0..steps)
            .map(|_| {
                state.follow(0.05, vec2(0.05 * speed, 0.0), Some((AHEAD, 1.3)), 7, person);
                state.action(AHEAD, 1.3)
            })
            .collect()
    }

    #[test]
    fn who_gets_on_walks_and_who_does_not_gives_way_after_a_while() {
        let mut state = StuckState::default();
        assert!(follow(&mut state, 1.0, 60.0, 0).iter().all(|action| *action == StuckAction::Walk));
        let actions = follow(&mut state, 0.0, 60.0, 0);
        let first = actions.iter().position(|action| *action != StuckAction::Walk).unwrap();
        // Two seconds until the mean is low, one or two of patience.
        assert!((50..100).contains(&first), "{first}");
        let other = actions.iter().filter(|action| **action != StuckAction::Walk).count();
        assert!((actions.len() / 5..2 * actions.len() / 3).contains(&other), "{other} of {}", actions.len());
        // Not only one kind.
        for wanted in [AHEAD * -0.65, vec2(0.0, 0.65), vec2(0.0, -0.65), Vec2::zeros()] {
            let found = (0..20).any(|person| {
                follow(&mut StuckState::default(), 0.0, 30.0, person).contains(&StuckAction::Step(wanted))
            });
            assert!(found, "{wanted:?}");
        }
    }

    #[test]
    fn people_do_not_all_do_the_same_but_each_always_the_same_and_who_wants_nothing_is_not_stuck() {
        let actions = |person| follow(&mut StuckState::default(), 0.0, 20.0, person);
        assert_eq!(actions(3), actions(3));
        assert!((0..10).any(|person| actions(person) != actions(10)));
        let mut state = StuckState::default();
        (0..200).for_each(|_| state.follow(0.05, Vec2::zeros(), None, 7, 0));
        assert_eq!(state, StuckState::default());
    }
}
