use super::*;
use crate::stuck::draw;

fn person(at: Vec2, velocity: Vec2, direction: Vec2) -> Walking<'static> {
    Walking {
        at,
        velocity,
        theta: 0.0,
        disks: &[],
        direction: Some(direction),
        speed: 1.34,
        pace: 1.0,
        to_go: 10.0 - at.x,
        destination: 0,
        waypoint: None,
        relaxation: 0.22,
        time_gap: 0.9,
        standstill_gap: 0.09,
        reaction_time: 0.0,
        steering: 0.0,
        noise: 0.0,
        phase: 0.0,
        breadth: 0.48,
        depth: 0.25,
        stuck: false,
    }
}

/// Returns the speeds along x of people in a row who all walk at one speed, each a headway behind the next.
fn row(headway: f64, speed: f64) -> f64 {
    let velocity = vec2(speed, 0.0);
    let people = [0.0, headway].map(|x| Some(person(vec2(x, 0.0), velocity, vec2(1.0, 0.0))));
    Rotational::default().desired(&people, &[])[0].velocity.x
}

#[test]
fn the_speed_behind_somebody_is_the_gap_by_the_time_gap() {
    for headway in [0.5, 0.7, 1.0, 1.3] {
        let speed = (headway - 0.3 - 0.09) / 0.9;
        assert!((row(headway, speed) - speed).abs() < 1e-12, "{headway}");
    }
    assert!((row(5.0, 1.34) - 1.34).abs() < 1e-12);
    // Pushes are limited: 4 m/s² for 0.22 s.
    assert!((row(5.0, 0.0) - 0.88).abs() < 1e-12);
}

/// Of two who come nearer at 0.4 m/s, the gap is that of the time by which the body follows, less the reaction time.
#[test]
fn who_reacts_late_sees_an_earlier_gap() {
    for reaction_time in [0.0, 0.22, 0.5] {
        let ahead = vec2(1.0, 0.0);
        let one = Walking { reaction_time, ..person(Vec2::zeros(), ahead * 0.7, ahead) };
        let people = [one, person(ahead, ahead * 0.3, ahead)].map(Some);
        let speed = Rotational::default().desired(&people, &[])[0].velocity.x;
        let gap = 1.0 - 0.3 - 0.4 * (0.22 - reaction_time);
        assert!((speed - (gap - 0.09) / 0.9).abs() < 1e-12, "{reaction_time}: {speed}");
    }
}

#[test]
fn two_who_meet_both_step_aside_by_what_is_missing_and_those_with_one_destination_do_not() {
    let meet = |offset: f64, destination, waypoint| {
        let (there, back) = (vec2(1.0, 0.0), vec2(-1.0, 0.0));
        let one = person(Vec2::zeros(), there, there);
        let other = Walking { destination, waypoint, ..person(vec2(3.3, offset), back, back) };
        let both = Rotational::default().desired(&[Some(one), Some(other)], &[]);
        [both[0].steering, both[1].steering]
    };
    // After 1.5 s they are 3 m nearer, two radii apart. What is missing of 0.6 m is divided by this time.
    for (offset, missing) in [(0.0, 0.6), (0.1, 0.5), (0.3, 0.3), (0.6, 0.0), (0.7, 0.0)] {
        let angle = ASIDE * missing / 1.5;
        let [one, other] = meet(offset, 1, None);
        assert_eq!(meet(offset, 0, Some(vec2(-5.0, 0.0))), [one, other]);
        // Both turn to their right if the other one is on the left.
        let sign = if offset > 0.0 { -1.0 } else { 1.0 };
        assert!(
            (one - sign * angle).abs() < 1e-12 && (other - one).abs() < 1e-12,
            "{offset}: {one}, {other}"
        );
    }
    assert_eq!(meet(0.1, 0, None), [0.0, 0.0]);
}

#[test]
fn nobody_overtakes_into_the_way_of_somebody_oncoming() {
    let (there, back) = (vec2(1.0, 0.0), vec2(-1.0, 0.0));
    // Overtaking on the left is near; the third one passes beyond the clearance.
    let steering = |y: f64| {
        let slow = person(vec2(0.8, -0.1), there * 0.3, there);
        let other = Walking { destination: 1, ..person(vec2(3.5, y), back, back) };
        let people = [person(Vec2::zeros(), there, there), slow, other].map(Some);
        Rotational::default().desired(&people, &[])[0].steering
    };
    // There, one walks behind the slow one: to the right.
    let weight = (-(0.8 / AHEAD + 0.1 / ACROSS)).exp() * 0.1 / (0.1 + OFFSET);
    assert!((steering(0.8) + BEHIND * weight.tanh()).abs() < 1e-12);
    assert!(steering(-0.8) > 0.1 && steering(1.0) > 0.1);
}

/// Returns a crowd of random people, of whom some stand, in two to three streams.
fn crowd(seed: u64, size: Vec2, count: usize) -> Vec<Walking<'static>> {
    let share = |count| (draw(seed, 0, count) >> 11) as f64 / (1u64 << 53) as f64;
    let mut count_drawn = 0;
    let mut next = || {
        count_drawn += 1;
        share(count_drawn)
    };
    let one = |k: usize| {
        let at = vec2(size.x * next(), size.y * next());
        let way = vec2(if k.is_multiple_of(3) { -1.0 } else { 1.0 }, next() - 0.5).unit(0.0).unwrap();
        Walking { destination: k % 3, ..person(at, way * next(), way) }
    };
    (0..count).map(one).collect()
}

/// The outside: everybody is looked at, in the order of the list.
#[test]
fn nobody_who_counts_is_left_out() {
    let walls = [[vec2(0.0, -0.2), vec2(6.0, -0.2)], [vec2(0.0, 1.2), vec2(3.0, 1.2)]];
    let mut opposed = 0;
    for (seed, (side, count)) in
        (0..40).zip([(4.0, 70), (8.0, 100), (2.0, 20), (12.0, 30)].into_iter().cycle())
    {
        let mut people = crowd(seed, vec2(side, side), count);
        for (k, one) in people.iter_mut().enumerate() {
            // All ways; some stand, some have a steering angle, and in dense crowds all are slow.
            let turn = rotation(seed as f64 + if seed.is_multiple_of(2) { 0.0 } else { k as f64 });
            let slow = if seed.is_multiple_of(3) { 0.1 } else { 1.0 };
            one.direction = one.direction.filter(|_| !k.is_multiple_of(11)).map(|way| turn * way);
            one.velocity = turn * one.velocity * slow;
            one.steering = if k.is_multiple_of(5) { 0.7 } else { 0.0 };
            one.reaction_time = if k.is_multiple_of(7) { 2.5 } else { 0.0 };
        }
        let people: Vec<_> = people.into_iter().map(Some).collect();
        let surroundings = Surroundings::new(&people, &walls);
        for walking in people.iter().flatten() {
            let Some(goal) = walking.direction else { continue };
            let view = View::new(walking, goal, &people, &surroundings);
            let mut all = view.nobody();
            for (person, other) in people.iter().flatten().enumerate() {
                let Walking { at, velocity, breadth, depth, .. } = *other;
                let direction = other.direction.unwrap_or(Vec2::zeros());
                view.see(&Other { at, velocity, direction, person, breadth, depth }, &mut all);
            }
            assert_eq!(view.see_all(&surroundings), all, "{seed}: {:?}", walking.at);
            opposed += usize::from(all.blocked != [false; 2]);
        }
    }
    assert!(opposed > 100, "{opposed}");
}

#[test]
fn nobody_walks_behind_somebody_who_stands() {
    let (there, back) = (vec2(1.0, 0.0), vec2(-1.0, 0.0));
    let steering = |direction| {
        let leader = Walking { direction, ..person(vec2(0.8, -0.1), Vec2::zeros(), there) };
        let other = Walking { destination: 1, ..person(vec2(3.5, 0.8), back, back) };
        let people = [person(Vec2::zeros(), there, there), leader, other].map(Some);
        Rotational::default().desired(&people, &[])[0].steering
    };
    assert!(steering(Some(there)) < -0.1);
    assert_eq!(steering(None), 0.0);
}

#[test]
fn neither_the_grid_nor_the_order_of_people_nor_the_side_counts() {
    let crowd = crowd(5, vec2(12.0, 8.0), 300);
    let walls = [[vec2(0.0, -0.2), vec2(12.0, -0.2)], [vec2(5.0, 3.0), vec2(6.0, 5.0)]];
    let model = Rotational::default();
    let of = |people: &[Walking<'_>], walls: &[[Vec2; 2]]| {
        let people: Vec<_> = people.iter().copied().map(Some).collect();
        model.desired(&people, walls)
    };
    let near = |a: &DesiredMotion, b: &DesiredMotion, sign: f64| {
        let facing = (a.facing.unwrap(), b.facing.unwrap());
        (a.velocity.x - b.velocity.x).abs() < 1e-9
            && (a.velocity.y - sign * b.velocity.y).abs() < 1e-9
            && (facing.0.y - sign * facing.1.y).abs() < 1e-6
            && (a.steering - sign * b.steering).abs() < 1e-9
    };
    let plain = of(&crowd, &walls);
    let moved = |by: Vec2| {
        let people: Vec<_> = crowd.iter().map(|one| Walking { at: one.at + by, ..*one }).collect();
        of(&people, &walls.map(|wall| wall.map(|end| end + by)))
    };
    // Somebody far away makes the cells others.
    let mut others = crowd.clone();
    others.reverse();
    others.push(person(vec2(-7.13, -9.31), Vec2::zeros(), vec2(1.0, 0.0)));
    let other = of(&others, &walls);
    let mirror = |at: Vec2| vec2(at.x, -at.y);
    let mirrored: Vec<_> = crowd
        .iter()
        .map(|one| Walking {
            at: mirror(one.at),
            velocity: mirror(one.velocity),
            direction: one.direction.map(mirror),
            ..*one
        })
        .collect();
    let mirrored = of(&mirrored, &walls.map(|wall| wall.map(mirror)));
    let by = moved(vec2(0.37, -41.0));
    for (k, one) in plain.iter().enumerate() {
        assert!(near(one, &by[k], 1.0) && near(one, &other[crowd.len() - 1 - k], 1.0), "{k}");
        // Whether the left or the right foot comes first is not mirrored.
        assert!(crowd[k].velocity.norm() < SWAY.2 || near(one, &mirrored[k], -1.0), "{k}");
    }
}
