//! Zenoh as the transport of a node, as `rmw_zenoh` speaks it: its keys with type hashes, its liveliness tokens for the graph, its
//! attachments, and CDR.
//!
//! It stands on `zenoh` and `zenoh-ext` and not on the backend of ros2-client: that one sends no history to late joiners and knows the
//! type hashes of its own table only.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - endpoints.rs: Publishers, subscriptions and servers over Zenoh
// - graph.rs: The endpoints on the network, from the liveliness tokens of all sessions, and which of them match those of this
//   session
// - keys.rs: The key expressions of rmw_zenoh: topics and services, and the liveliness tokens by which endpoints announce
//   themselves (<https://github.com/ros2/rmw_zenoh/blob/rolling/docs/design.md>)
// - queue.rs: What has arrived and is not taken yet: keeps the last messages, within a number and a size
// - session.rs: The session of a process: its configuration, its connection to a router, and its nodes
// - type_hashes.rs: Type hashes of everything that a node speaks, which rmw_zenoh has in its keys

mod endpoints;
mod graph;
mod keys;
mod queue;
mod session;
mod type_hashes;

pub use endpoints::{ZenohPublisher, ZenohServer, ZenohSubscription};
pub(super) use session::{ZenohNode, ZenohSession, check_zenoh};
