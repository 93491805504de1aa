//! Every fast case of `validate`, as a test: the engine against closed forms, papers and other programs.

use sturz_tests::cases::{Tier, registry};

#[test]
fn every_fast_case_is_within_its_tolerance() {
    let cases: Vec<_> = registry().into_iter().filter(|case| case.tier == Tier::Fast).collect();
    assert!(cases.len() >= 20, "only {} cases", cases.len());
    let mut failed = Vec::new();
    for case in cases {
        let rows = case.rows();
        assert!(!rows.is_empty(), "{} compares nothing", case.id);
        failed.extend(rows.into_iter().filter(|row| !row.pass));
    }
    let text: Vec<String> = failed
        .iter()
        .map(|row| {
            format!("{} {}: {:e}, reference {:e} +- {:e}", row.id, row.metric, row.value, row.reference, row.tolerance)
        })
        .collect();
    assert!(failed.is_empty(), "\n{}", text.join("\n"));
}
