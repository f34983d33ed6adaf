//! Runs one input of a fuzzer without it: `cargo run -p lemons-verify --features fuzz --example one TARGET FILE`.

fn main() {
    let mut arguments = std::env::args().skip(1);
    let (Some(target), Some(file)) = (arguments.next(), arguments.next()) else {
        panic!("give a target and a file");
    };
    lemons_verify::fuzz::run(&target, &std::fs::read(file).expect("a file that can be read"));
}
