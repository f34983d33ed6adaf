//! lab/src/generated.ts is what the Rust types say.

use lemons_lab::typescript::generated;
use std::path::Path;

#[test]
fn committed_types_of_the_page_are_the_generated_ones() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../lab/src/generated.ts");
    let committed = std::fs::read_to_string(path).unwrap();
    assert!(
        committed == generated(),
        "lab/src/generated.ts is not what the types of requests and replies say. Regenerate it: \
         cargo run -p lemons-lab --features typescript --example types -- lab/src/generated.ts"
    );
}
