//! The table of `lemons verify`. That each row passes is measured by the command itself: check.sh calls it.

#[test]
fn a_failing_figure_fails() {
    let check = lemons_verify::checks::all().remove(0);
    assert!(!check.passes(2.0 * check.limit));
    assert!(!check.passes(f64::NAN));
}
