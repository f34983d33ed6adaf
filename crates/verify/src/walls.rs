//! Nobody walks through a wall.

use crate::Check;
use crate::scenes::*;
use anyhow::Result;
use crowd_mechanics::engine::*;

pub(crate) const CHECKS: &[Check] = &[
    Check::new("walker at 1 m/s and a wall: farthest, beyond it", "the wall, x = 2 m", "m", 0.0, || {
        walker(1.0, 10.0)
    }),
    Check::new("walker at 20 m/s, TimeStep 0.1 s", "the wall, x = 2 m", "m", 0.0, || walker(20.0, 10.0)),
    Check::new("walker and 200 m of wall", "the wall, x = 2 m", "m", 0.0, || walker(1.0, 100.0)),
    Check::new("a straight wall in two pieces", "the wall in one", "m", 1e-12, pieces),
];

/// 80 kg, steady at `speed`, rates 2 /s, along y = 5, at a wall x = 2: how far beyond the wall the centre came \[m\].
fn walker(speed: f64, half_wall: f64) -> Result<f64> {
    let walls = [wall(&[(2.0, -half_wall), (2.0, half_wall)])];
    let mut world =
        world(&[pedestrian(80.0, 2.0)], &walls, CONCRETE, &[(at(0.0, 5.0), moving(speed, 0.0))], 1e-5);
    world.drive[0].force = vec2(80.0 * 2.0 * speed, 0.0);
    let mut farthest = f64::NEG_INFINITY;
    for _ in 0..40 {
        world.advance(0.1)?;
        farthest = farthest.max(world.state().poses[0].position.x);
    }
    anyhow::ensure!(world.work().contacts > 0, "the walker came to the wall");
    Ok((farthest - 2.0).max(0.0))
}

fn pieces() -> Result<f64> {
    let slide = |corners: &[(f64, f64)]| -> Result<Vec2> {
        let law = PairLaw { friction: 0.0, ..CONCRETE };
        let motion = [(at(-0.3, 0.199), moving(0.5, 0.0))];
        let mut world = world(&[disk(80.0, 0.2)], &[wall(corners)], law, &motion, 1e-5);
        world.drive[0].force = vec2(0.0, -500.0);
        world.advance(1.0)?;
        Ok(world.state().poses[0].position)
    };
    let whole = slide(&[(-1.0, 0.0), (1.0, 0.0)])?;
    Ok((whole - slide(&[(-1.0, 0.0), (0.0, 0.0), (1.0, 0.0)])?).norm())
}
