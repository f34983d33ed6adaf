//! The table of `lemons verify`. That each row passes is measured by the command itself: check.sh calls it.

#[test]
fn a_failing_figure_fails() {
    let check = lemons_verify::checks::all().remove(0);
    assert!(!check.passes(2.0 * check.limit));
    assert!(!check.passes(f64::NAN));
}

/// Rounding leaves a drift of what is conserved: a row without any has measured nothing.
#[test]
fn drifts_of_what_is_conserved_are_measured() {
    let all = lemons_verify::checks::all().into_iter().filter(|check| check.against == "conservation");
    let drifts: Vec<f64> = all.map(|check| (check.measure)().unwrap()).collect();
    assert!(drifts.len() == 3 && drifts.iter().all(|drift| *drift > 0.0), "{drifts:?}");
}
