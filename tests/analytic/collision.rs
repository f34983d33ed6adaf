//! Collisions; the measured ones are rows of `lemons verify`.

use crowd_mechanics::engine::*;
use lemons_verify::checks::scenes::*;

#[test]
fn coincident_centres_push_nobody_and_are_counted() {
    let mut world = world(
        &[disk(80.0, 0.2), disk(80.0, 0.2)],
        &[],
        ELASTIC,
        &[(at(0.0, 0.0), moving(0.0, 0.0)), (at(0.0, 0.0), moving(0.0, 0.0))],
        1e-5,
    );
    world.advance(1e-3).unwrap();
    assert_eq!(world.work().coincident, 101); // once at the first instant, once each step
    assert!(world.state().poses.iter().all(|pose| pose.position == Vec2::ZERO));
}
