//! Compiles and runs the example of `docs/guide.md`, and compares the two texts.

use std::path::Path;

// guide begins
use column_twin::column::{Outcome, simulate};
use column_twin::parameters::{Parameters, parse_override};

fn example() -> Result<(), Box<dyn std::error::Error>> {
    let files = ["config/heb220_s355.yaml".into()];
    let parameters = Parameters::load(&files, &[parse_override("impact.velocity:=5.0")])?;
    let mut peak_moment: f64 = 0.0;
    let report = simulate(
        &parameters.column_properties(),
        &parameters.impact(),
        parameters.response_duration(),
        &mut |sample| peak_moment = peak_moment.max(sample.hinges[3].moment.abs()),
    )?;
    println!(
        "peak v1 {:.1} mm, peak moment at the base {:.0} kNm",
        1e3 * report.max_v1,
        1e-3 * peak_moment
    );
    assert_eq!(report.outcome, Outcome::Elastic);
    Ok(())
}
// guide ends

#[test]
fn the_example_of_the_guide_runs() {
    example().unwrap();
}

#[test]
fn the_guide_shows_this_example() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let source = std::fs::read_to_string(root.join("tests/guide.rs")).unwrap();
    let guide = std::fs::read_to_string(root.join("docs/guide.md")).unwrap();
    let example = source
        .split_once("// guide begins\n")
        .and_then(|(_, rest)| rest.split_once("// guide ends\n"))
        .map(|(example, _)| example)
        .unwrap();
    assert!(
        guide.contains(&format!("```rust\n{example}```\n")),
        "docs/guide.md must show:\n{example}"
    );
}
