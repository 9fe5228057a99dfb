//! A column at rest with its damage, as the next impact will find it.
//!
//! `standing_column.rs` is the column, `impact_height.rs` says where its hinges 1a and 1b are.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - impact_height.rs: The height of hinges 1a and 1b, and with that of the impact
// - standing_column.rs: The column as an impact finds it: undamaged, or with the damage that earlier impacts have left

mod impact_height;
mod standing_column;

pub use impact_height::HEIGHT_TOLERANCE;
pub(crate) use impact_height::{is_same_height, with_impact_height};
pub use standing_column::{Damage, StandingColumn};
