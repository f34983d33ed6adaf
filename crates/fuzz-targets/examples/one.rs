//! Runs one input of a fuzzer without it: `cargo run -p lemons-fuzz-targets --example one TARGET FILE`.
//! With `FUZZ_TOLD=1` in the environment every call of an FMU is shown, with its status and what was logged.

fn main() {
    let mut arguments = std::env::args().skip(1);
    let (Some(target), Some(file)) = (arguments.next(), arguments.next()) else {
        panic!("give a target and a file");
    };
    lemons_fuzz_targets::run(&target, &std::fs::read(file).expect("a file that can be read"));
}
