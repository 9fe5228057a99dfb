//! The ROS 2 node: the twin's interface over ros2-client and RustDDS.
//!
//! This module implements what ROS users expect and the client library lacks: `--ros-args`, the environment variables,
//! names and remapping, parameters with descriptions and ranges, `/rosout`, `/diagnostics`, simulated time. The twin
//! runs behind [`LiveColumns`] and is independent of ROS.
//!
//! Deliberately absent: the `Spinner` of ros2-client (it subscribes to `/clock` with a wrong type, and its parameter
//! services support neither descriptions nor sets), and all default qualities of service of the libraries.

mod address_space;
mod arguments;
mod client;
mod client_error;
mod clock_watch;
mod counters;
mod dds_threads;
mod detected;
mod diagnostics;
mod duplicates;
mod environment;
mod face;
mod fleet;
mod fleet_view;
mod fresh_domain;
mod given_up;
mod guid_prefix;
mod inputs;
mod library_log;
mod lines;
mod live_columns;
mod log_limit;
mod loss_log;
mod lost_peers;
mod matches;
mod measure;
mod measurements;
mod missed;
mod names;
mod node;
mod node_viewer;
mod notice_log;
mod output_log;
mod parameter_services;
mod publishing;
pub mod qos;
mod raw;
mod receiving;
#[cfg(feature = "record")]
pub mod replay;
mod requests;
mod rosout;
mod row_client;
mod run;
pub mod security;
mod senders;
mod sending;
mod sensor_watch;
mod signals;
mod subscribed;
mod task;
mod twin_node;
mod type_descriptions;
mod utc;

pub use arguments::{ArgumentError, LogLevel, RosArguments};
pub use client::{
    ImpactOptions, ImpactOutcome, ImpactRequest, Shown, follow_impact, send_impact, watch,
};
pub use client_error::ClientError;
pub use detected::follow_sensors;
pub use environment::{DiscoveryRange, Environment, EnvironmentError, MAX_DOMAIN_ID};
pub use face::Face;
pub use fresh_domain::FreshDomain;
pub use lines::{
    Seen, action_word, actions_in_words, decision_word, in_unit, range_of, report_line,
};
pub use live_columns::{Health, LiveColumns, StartError};
pub use matches::Matches;
pub use measure::{MeasureOptions, Measured, send_measurements};
pub use names::{NameError, NameKind, Names, RemapRule, RemapTarget};
pub use node::{Node, NodeError};
pub use raw::Raw;
pub use rosout::{RosoutQueue, start_logging};
pub use row_client::{RowImpactOptions, send_row_impact};
pub use run::{RunEnd, RunError, RunOptions, run, run_fleet};
pub use signals::StopSignals;
pub use twin_node::TwinNode;

/// Default name of the node.
pub const NODE_NAME: &str = "column_twin";
