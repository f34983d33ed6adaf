//! FIRE, the fast inertial relaxation engine (Bitzek et al. 2006; with the half step back of Guénolé et al. 2020): it
//! moves downhill and stops whenever it would go uphill.

use super::soft_disks::{Coordinates, Pressure, SoftDisks};

/// Largest time step at which the stiffest contacts are stable: a pair of disks has stiffness 1, a shape has mass 1 and
/// up to about ten contacts.
const LONGEST: f64 = 0.35;
const SHORTEST: f64 = 1e-3;
const BEGIN: f64 = 0.1;
const LONGER: f64 = 1.1;
const SHORTER: f64 = 0.5;
/// Fraction of the velocity that is turned towards the force at first, and the factor by which it decreases.
const MIXING: f64 = 0.25;
const FADING: f64 = 0.99;
/// Number of steps downhill before the time step grows.
const PATIENCE: u32 = 5;
/// \[m\] Largest displacement in a step.
const FURTHEST: f64 = 0.03;

/// A relaxation of a [`SoftDisks`].
#[derive(Debug)]
pub struct Fire {
    velocity: Vec<Coordinates>,
    step: f64,
    mixing: f64,
    downhill: u32,
    pressure: Pressure,
    /// Σ F².
    force_square: f64,
}

impl Fire {
    /// Begins at rest.
    pub fn new(disks: &mut SoftDisks) -> Fire {
        let pressure = disks.press();
        let velocity = vec![[0.0; 3]; disks.bodies.len()];
        let force_square = disks.force.iter().flatten().map(|f| f * f).sum();
        Fire { velocity, step: BEGIN, mixing: MIXING, downhill: 0, pressure, force_square }
    }

    pub fn pressure(&self) -> Pressure {
        self.pressure
    }

    /// Returns Σ F² / 2E: near 1 if nothing holds the shapes, near 0 if the forces on each shape balance.
    pub fn imbalance(&self) -> f64 {
        if self.pressure.energy > 0.0 { 0.5 * self.force_square / self.pressure.energy } else { 0.0 }
    }

    pub fn step(&mut self, disks: &mut SoftDisks) {
        let along = |v: &[Coordinates], f: &[Coordinates]| -> f64 {
            v.iter().zip(f).map(|(v, f)| v[0] * f[0] + v[1] * f[1] + v[2] * f[2]).sum()
        };
        if along(&self.velocity, &disks.force) > 0.0 {
            self.downhill += 1;
            if self.downhill > PATIENCE {
                self.step = (self.step * LONGER).min(LONGEST);
                self.mixing *= FADING;
            }
        } else {
            // Half a step back, then again from rest.
            let (velocity, back) = (&self.velocity, -0.5 * self.step);
            disks.shift(|k| velocity[k].map(|v| v * back));
            self.velocity.fill([0.0; 3]);
            self.downhill = 0;
            self.step = (self.step * SHORTER).max(SHORTEST);
            self.mixing = MIXING;
        }
        let step = self.step;
        let mut square = 0.0;
        for (v, f) in self.velocity.iter_mut().zip(&disks.force) {
            for k in 0..3 {
                v[k] += f[k] * step;
                square += v[k] * v[k];
            }
        }
        let along_force =
            if self.force_square > 0.0 { self.mixing * (square / self.force_square).sqrt() } else { 0.0 };
        for (v, f) in self.velocity.iter_mut().zip(&disks.force) {
            let mut way_square = 0.0;
            for k in 0..3 {
                v[k] = (1.0 - self.mixing) * v[k] + along_force * f[k];
                way_square += v[k] * v[k];
            }
            let way = way_square.sqrt() * step;
            if way > FURTHEST {
                *v = v.map(|v| v * (FURTHEST / way));
            }
        }
        let velocity = &self.velocity;
        disks.shift(|k| velocity[k].map(|v| v * step));
        self.pressure = disks.press();
        self.force_square = disks.force.iter().flatten().map(|f| f * f).sum();
    }
}
