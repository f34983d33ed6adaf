#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| lemons_verify::fuzz::run("drive_csv", data));
