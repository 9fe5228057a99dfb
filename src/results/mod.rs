//! Results under the names that programs see, which are a stable interface: the JSON of the command line, and the Python package.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - beam_fields.rs: What the fibre beam says of an impact, under the names that programs see
// - capacity_fields.rs: The capacity of a column under the names that programs see
// - impact_fields.rs: The outcome of one impact under the names that programs see

mod beam_fields;
mod capacity_fields;
mod impact_fields;

pub use beam_fields::BeamAnswer;
pub use capacity_fields::CapacityFields;
pub use impact_fields::{ImpactFields, Travel, outcome_word};
