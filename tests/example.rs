//! The configuration of the paper's example describes the column of the mechanics' tests.

#[path = "../crates/mechanics/tests/example/mod.rs"]
mod example;

use std::path::Path;

use column_twin::column::ColumnProperties;
use column_twin::parameters::Parameters;

#[test]
fn the_configuration_file_is_the_example_of_the_mechanics() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/heb220_paper.yaml");
    let parameters = Parameters::load(&[file], &[]).expect("admissible parameters");
    let configured = (parameters.column_properties(), parameters.impact());
    let (column, impact) = example::paper();
    // The program always watches for fractured hinges; the mechanics of the paper do not know them.
    let column = ColumnProperties {
        ultimate_rotation: 0.15,
        ..column
    };
    assert_eq!(configured, (column, impact));
}
