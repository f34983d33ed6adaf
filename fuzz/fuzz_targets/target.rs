//! A fuzzer, which has the name of its target.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| lemons_verify::fuzz::run(env!("CARGO_BIN_NAME"), data));
