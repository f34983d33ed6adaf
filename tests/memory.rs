//! How much memory the engine needs for each agent: bytes counted, not measured.

#![allow(unsafe_code)] // an allocator that counts

use crowd_mechanics::engine::vec2;
use crowd_mechanics::scenes::crowded;
use crowd_mechanics::setup::{self, Setup};
use lemons_testing::trial_push;
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// \[byte\] allocated at present, and the most since it was last set.
static PRESENT: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

struct Counting;

// SAFETY: the system's allocator does everything.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        MOST.fetch_max(PRESENT.fetch_add(layout.size(), Relaxed) + layout.size(), Relaxed);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        PRESENT.fetch_sub(layout.size(), Relaxed);
        unsafe { System.dealloc(place, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// Seven people per square metre, pressed and pushing: what an agent takes between communication steps, and the most
/// within one, its files left aside.
#[test]
fn an_agent_takes_less_than_two_kilobytes() {
    const AGENTS: usize = 10_000;
    const LIMIT: usize = 2_048;
    let mut trial = crowded(setup::read(&trial_push()).unwrap().0, AGENTS, vec2(0.285, 0.5));
    trial.parameters.time_step_mechanical = 1e-4;

    let before = PRESENT.load(Relaxed);
    let each = |bytes: &AtomicUsize| (bytes.load(Relaxed) - before) / AGENTS;
    let mut world = Setup::of(&trial).world().unwrap();
    MOST.store(PRESENT.load(Relaxed), Relaxed);
    for _ in 0..4 {
        world.advance(0.005).unwrap();
    }
    let (lasting, most) = (each(&PRESENT), each(&MOST));
    let contacts = world.contacts().contacts.len() as f64 / AGENTS as f64;
    println!("per agent: {contacts:.2} contacts, {lasting} bytes, {most} bytes within a step");
    assert!(contacts > 0.7, "a dense crowd: {contacts} contacts per agent");
    assert!(lasting <= LIMIT && most <= LIMIT, "{lasting} bytes, {most} bytes within a step, per agent");
}
