//! Prints all checks.
fn main() {
    for check in lemons_verify::checks() {
        match (check.measure)() {
            Ok(figure) => println!(
                "{} {} | {figure:.1e} | {:.0e}",
                if check.passes(figure) { "ok  " } else { "FAIL" },
                check.name,
                check.limit
            ),
            Err(error) => println!("ERR  {} {error}", check.name),
        }
    }
    println!("{}", lemons_verify::tables().unwrap());
}
