//! Random columns that are struck: the same in every run, or as many new ones as `COLUMN_TWIN_EXPLORE` says.

use std::time::SystemTime;

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
    let algorithm = config.rng_algorithm;
    let random = match explored {
        // Without its feature `std`, proptest draws the same columns in every run by itself.
        Some(_) => TestRng::from_seed(algorithm, &new_seed()),
        None => TestRng::deterministic_rng(algorithm),
    };
    let mut runner = TestRunner::new_with_rng(config, random);
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

/// A seed that no other run has.
fn new_seed() -> [u8; 32] {
    let now = SystemTime::now()
        .duration_since(SystemTime::UNIX_EPOCH)
        .expect("a clock after 1970");
    let mut seed = [0; 32];
    seed[..16].copy_from_slice(&now.as_nanos().to_le_bytes());
    seed[16..20].copy_from_slice(&std::process::id().to_le_bytes());
    seed
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
