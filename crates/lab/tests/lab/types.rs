//! lab/src/generated.ts is what the Rust types say.

use lemons_lab::typescript::generated;
use std::fs;
use std::path::Path;

#[test]
fn committed_types_of_the_page_are_the_generated_ones() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../lab/src/generated.ts");
    if std::env::var_os("PAGE_TYPES").is_some_and(|what| what == "write") {
        fs::write(&path, generated()).unwrap();
    }
    assert!(
        fs::read_to_string(&path).unwrap() == generated(),
        "lab/src/generated.ts is not what the types of requests and replies say: make it again as its \
         first line says"
    );
}
