//! Writes lab/src/generated.ts: the types of requests and replies, for the page.

fn main() -> std::io::Result<()> {
    let path = std::env::args().nth(1).expect("usage: types FILE");
    std::fs::write(path, lemons_lab::typescript::generated())
}
