//! A run whose instructions are counted by `benches/instructions.sh`:
//!
//! `cargo run --release -p lemons-verify --features bench --example instructions [ROW]`
//!
//! Without a row it prints each one's name, number of people and number of mechanical steps.

use lemons_verify::bench::counted::{CALLS, Call, rows};

fn main() -> anyhow::Result<()> {
    let Some(name) = std::env::args().nth(1) else {
        for row in rows() {
            println!("{} {} {}", row.name, row.people, row.steps * CALLS as u64);
        }
        return Ok(());
    };
    let row = rows().into_iter().find(|row| row.name == name);
    counted_calls(&mut (row.ok_or_else(|| anyhow::anyhow!("no row {name}"))?.make)()?)
}

/// Callgrind counts what happens in here.
#[inline(never)]
fn counted_calls(call: &mut Call) -> anyhow::Result<()> {
    (0..CALLS).try_for_each(|_| call())
}
