//! What the node of a fleet does besides: topics of single columns while somebody listens there, the status of all columns in few
//! messages, vehicles that hit several columns, and the diagnostics of many columns.
//!
//! The number of endpoints does not depend on the number of columns, apart from those of columns to which somebody listens in
//! their namespaces. Every message has a `column_id`; messages for columns that are elsewhere are ignored and counted. A column that
//! is at rest publishes nothing but its line in `fleet_status`.

mod column_topics;
mod diagnostics;
mod publishing;
mod rows;
mod sensors;

pub(super) use column_topics::{ColumnTopics, TopicCounts};
pub(super) use publishing::FleetPublishing;
pub(super) use rows::RowImpacts;
