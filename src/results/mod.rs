//! Results under the names that programs see, which are a stable interface: the JSON and the CSV of the command line, and
//! the Python package.

mod beam_fields;
mod capacity_fields;
mod history_columns;
mod impact_fields;

pub use beam_fields::BeamAnswer;
pub use capacity_fields::CapacityFields;
pub use history_columns::HistoryColumns;
pub use impact_fields::{ImpactFields, outcome_word};
