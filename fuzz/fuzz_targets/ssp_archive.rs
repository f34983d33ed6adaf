#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| lemons_fuzz_targets::run("ssp_archive", data));
