//! What the node of a fleet does besides: topics of single columns while somebody listens there, the status of all columns in few
//! messages, vehicles that hit several columns, and the diagnostics of many columns.
//!
//! The number of endpoints does not depend on the number of columns, apart from those of columns to which somebody listens in
//! their namespaces. Every message has a `column_id`; messages for columns that are elsewhere are ignored and counted. A column that
//! is at rest publishes nothing but its line in `fleet_status`.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - column_topics.rs: The topics of single columns in their namespaces, such as `/garage/a3/twin_status`: they exist while
//   somebody listens there
// - diagnostics.rs: What `/diagnostics` has of a fleet besides the health of the node: a summary, its topics, and the columns
//   that need somebody
// - publishing.rs: What the publishing thread of a fleet publishes besides the outputs of its columns: the status of all
//   columns in few messages, copies in the namespaces of single columns, and which columns a vehicle does not hit
// - rows.rs: Vehicles that hit several columns of the fleet: events are checked with all columns that they name, and impacts
//   are submitted when they are due
// - sensors.rs: The health of the sensors of a fleet, for `/diagnostics` and `fleet_status`

mod column_topics;
mod diagnostics;
mod publishing;
mod rows;
mod sensors;

pub(super) use column_topics::{ColumnTopics, TopicCounts};
pub(super) use publishing::FleetPublishing;
pub(super) use rows::RowImpacts;
