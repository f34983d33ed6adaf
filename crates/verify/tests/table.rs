//! Every row of the table passes.

#[test]
fn every_check_passes() {
    let mut failed = Vec::new();
    for check in lemons_verify::checks::all() {
        let figure = (check.measure)().unwrap_or_else(|error| panic!("{}: {error:#}", check.name));
        println!("{:70} {figure:9.2e} within {:.0e}", check.name, check.limit);
        if !check.passes(figure) {
            failed.push(check.name);
        }
    }
    println!("{}", lemons_verify::checks::tables().unwrap());
    assert!(failed.is_empty(), "{failed:?}");
}

#[test]
fn a_failing_figure_fails() {
    let check = lemons_verify::checks::all().remove(0);
    assert!(!check.passes(2.0 * check.limit));
    assert!(!check.passes(f64::NAN));
}
