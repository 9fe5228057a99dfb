//! The paper's example, from its configuration file.

use std::path::Path;

use column_twin::column::{ColumnProperties, Impact};
use column_twin::parameters::{Parameters, parse_override};

/// `config/heb220_paper.yaml` with some parameters changed, `name:=value` each: the column and what hits it.
pub fn example(overrides: &[&str]) -> (ColumnProperties, Impact) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/heb220_paper.yaml");
    let overrides: Vec<_> = overrides.iter().map(|text| parse_override(text)).collect();
    let parameters = Parameters::load(&[file], &overrides).expect("admissible parameters");
    (parameters.column_properties(), parameters.impact())
}
