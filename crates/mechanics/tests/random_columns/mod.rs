//! Random columns that are struck: the same in every run, or as many new ones as `COLUMN_TWIN_EXPLORE` says.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};
use std::thread;
use std::time::SystemTime;

use column_mechanics::{ColumnProperties, Impact, Model, Response, State};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRng, TestRunner};

/// Columns that [`check_in_parts`] draws from one seed.
const PART: u32 = 5_000;

/// How many new columns are to be drawn; `None` for those of every run.
fn explored() -> Option<u32> {
    std::env::var("COLUMN_TWIN_EXPLORE").ok().map(|count| {
        count
            .parse()
            .expect("COLUMN_TWIN_EXPLORE is a number of columns")
    })
}

/// Checks `follow` for random impacts on random columns, and returns how many there were. A failure contains its case to the
/// last bit, for a rerun.
pub fn check(
    cases: u32,
    strikes: impl Strategy<Value = (ColumnProperties, Impact)>,
    follow: impl Fn(&ColumnProperties, &Impact) -> Result<(), TestCaseError>,
) -> u32 {
    let explored = explored();
    let cases = explored.unwrap_or(cases);
    let algorithm = Config::default().rng_algorithm;
    let random = match explored {
        // Without its feature `std`, proptest draws the same columns in every run by itself.
        Some(_) => TestRng::from_seed(algorithm, &new_seed()),
        None => TestRng::deterministic_rng(algorithm),
    };
    check_drawn(cases, random, strikes, follow).unwrap_or_else(|failure| panic!("{failure}"));
    cases
}

/// Draws as many columns, in parts that all processors share and that do not depend on how many there are. `check_part` checks
/// the part of an index with [`check_drawn`]; after a failure, which this function panics with, no further part begins.
#[allow(dead_code, reason = "not every test takes hours")]
pub fn check_in_parts(
    cases: u32,
    check_part: impl Fn(u32, u32, TestRng) -> Result<(), String> + Sync,
) -> u32 {
    let explored = explored();
    let cases = explored.unwrap_or(cases);
    let seed = explored.map_or([0; 32], |_| new_seed());
    let (next, failure) = (AtomicU32::new(0), Mutex::new(None));
    let work = || {
        while failure.lock().expect("no panic").is_none() {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(left) = cases.checked_sub(index * PART).filter(|left| *left > 0) else {
                return;
            };
            let mut seed = seed;
            seed[28..].copy_from_slice(&index.to_le_bytes());
            let random = TestRng::from_seed(Config::default().rng_algorithm, &seed);
            if let Err(found) = check_part(index, left.min(PART), random) {
                failure.lock().expect("no panic").get_or_insert(found);
            }
        }
    };
    let processors = thread::available_parallelism().map_or(1, usize::from);
    thread::scope(|scope| {
        for _ in 0..processors {
            scope.spawn(work);
        }
    });
    if let Some(failure) = failure.into_inner().expect("no panic") {
        panic!("{failure}");
    }
    cases
}

/// As [`check`], of `cases` columns that are drawn from `random`.
///
/// # Errors
/// The failure, with its case to the last bit.
pub fn check_drawn(
    cases: u32,
    random: TestRng,
    strikes: impl Strategy<Value = (ColumnProperties, Impact)>,
    follow: impl Fn(&ColumnProperties, &Impact) -> Result<(), TestCaseError>,
) -> Result<(), String> {
    let config = Config {
        cases,
        max_global_rejects: cases.saturating_mul(20),
        max_local_rejects: cases.saturating_mul(20),
        ..Config::default()
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
        .map_err(|failure| failure.to_string())
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
