#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| lemons_verify::fuzz::run("decision_toml", data));
