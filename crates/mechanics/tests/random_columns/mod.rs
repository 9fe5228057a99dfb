//! Random columns that are struck: the same in every run, or as many new ones as `COLUMN_TWIN_EXPLORE` says.

use column_mechanics::{ColumnProperties, Impact, Model, Response, State};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRng, TestRunner};

/// Checks `follow` for random impacts on random columns, and returns how many there were. A failure contains its case to the
/// last bit, for a rerun.
pub fn check(
    cases: u32,
    strikes: impl Strategy<Value = (ColumnProperties, Impact)>,
    follow: impl Fn(&ColumnProperties, &Impact) -> Result<(), TestCaseError>,
) -> u32 {
    let explored: Option<u32> = std::env::var("COLUMN_TWIN_EXPLORE").ok().map(|count| {
        count
            .parse()
            .expect("COLUMN_TWIN_EXPLORE is a number of columns")
    });
    let cases = explored.unwrap_or(cases);
    let config = Config {
        cases,
        max_global_rejects: cases.saturating_mul(20),
        max_local_rejects: cases.saturating_mul(20),
        ..Config::default()
    };
    let mut runner = if explored.is_some() {
        TestRunner::new(config)
    } else {
        let seed = TestRng::deterministic_rng(config.rng_algorithm);
        TestRunner::new_with_rng(config, seed)
    };
    runner
        .run(&strikes, |(properties, impact)| {
            follow(&properties, &impact).map_err(|failure| match failure {
                TestCaseError::Fail(reason) => {
                    let case = serde_json::json!({ "column": properties, "impact": impact });
                    TestCaseError::fail(format!("{reason}\n{case}"))
                }
                rejected => rejected,
            })
        })
        .unwrap_or_else(|failure| panic!("{failure}"));
    cases
}

/// The column at the event, and its response; a column that does not stand is not a case.
pub fn begin(
    properties: &ColumnProperties,
    impact: &Impact,
) -> Result<(Model, State, Response), TestCaseError> {
    let Ok(model) = Model::new(properties) else {
        return Err(TestCaseError::reject(
            "squashed or buckled by its load alone",
        ));
    };
    let mut state = State::at_rest(&model);
    let response = Response::begin(&model, &mut state, *impact, 1e3)
        .map_err(|e| TestCaseError::fail(e.to_string()))?;
    Ok((model, state, response))
}
