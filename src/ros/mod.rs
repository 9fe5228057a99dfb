//! The ROS 2 node: the twin's interface over ros2-client and RustDDS.
//!
//! This module implements what ROS users expect and the client library lacks: `--ros-args`, the environment variables,
//! names and remapping, parameters with descriptions and ranges, `/rosout`, `/diagnostics`, simulated time. The twin
//! runs behind [`LiveColumns`] and is independent of ROS.
//!
//! Deliberately absent: the `Spinner` of ros2-client (it subscribes to `/clock` with a wrong type, and its parameter
//! services support neither descriptions nor sets), and all default qualities of service of the libraries.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - address_space.rs: How much address space the system grants to the node
// - alarms.rs: Alarms of the node: which outputs of the columns are conditions, and the delivery that the parameters describe
// - alarms_absent.rs: Alarms in a program without the feature `alarm`: says so if the parameters ask for them
// - client.rs: Terminal client of the twin: sends an impact or shows what the twin publishes, without a ROS installation
// - client_error.rs: Why a client of the twin ends without what it was asked for
// - counters.rs: Losses of the node itself, counted for `/diagnostics` and the log
// - dds_threads.rs: The threads of the DDS library, and those of the node that use it
// - detected.rs: Follows a twin whose sensors detect an impact, without a ROS installation
// - diagnostics.rs: `/diagnostics`: the twin, its solver, its queues, its recording, its sensors and the node, for people and
//   aggregators
// - duplicates.rs: Warns about another node with the same name, and about another twin of the same column, on the network
// - exposition.rs: Metrics in the text format that Prometheus reads (version 0.0.4)
// - face.rs: The two faces of a node
// - fleet/: What the node of a fleet does besides: topics of single columns while somebody listens there, the status of all
//   columns in few messages, vehicles that hit several columns, and the diagnostics of many columns
// - fleet_view.rs: What is known of the columns of fleets, from their statuses
// - foxglove.rs: Live topics, parameters and services of the node for Foxglove, past DDS
// - foxglove_absent.rs: Foxglove in a program without the feature `foxglove`: says so if the parameters ask for it
// - inputs.rs: The inputs of the node: impact events, parameters, the clock, and service requests
// - lifecycle.rs: The state of a managed node, and what it means for inputs and outputs
// - lifecycle_services.rs: The services and the topic by which others read and change the state of a managed node, as `ros2
//   lifecycle` does
// - lifecycle_states.rs: States and transitions of a managed node
// - lines.rs: Lines that show the twin's messages to people
// - live_columns.rs: The live columns of a node, one or many: commands, health and clock, from start to stop
// - loss_log.rs: Losses of the node in its log: periods that the solver skipped, after a stop of the process or because the
//   machine is overloaded, and messages that no reader got
// - measure.rs: `column-twin measure`: publishes a table of readings as the sensors would, in real time
// - measurements.rs: The measurements over DDS: from the topics of the sensors through their intake to the recording and to the
//   queue
// - metrics.rs: The metrics of the node: what the publishing thread knows, as a page for Prometheus
// - metrics_server.rs: The port from which Prometheus reads the metrics
// - node.rs: A node: participant, names, and endpoints created from the table
// - node_viewer.rs: The viewer of a node, as configured by the parameters `viewer.*`
// - notice_log.rs: Lines of the log with the level of a notice
// - output_log.rs: The log of what leaves the columns: rejections and notices, and at the level `debug` every output and where
//   it leaves late
// - parameter_services.rs: The six services behind `ros2 param`, and `/parameter_events`
// - publishing.rs: The publishing thread: publishes the outputs of all columns
// - qos.rs: Converts the quality of service of every endpoint for ros2-client
// - qos_overrides.rs: The quality of service that parameters ask for in the place of the table's, topic by topic
// - receiving.rs: What every input has in common: who may send, what the recording and the log are told, and what cannot be
//   read or was lost
// - replay/: `column-twin replay`: publishes a recording over DDS, with its original bytes and timing
// - requests.rs: Answers of services: about what was detected and measured on the column, and about resets
// - row_client.rs: Terminal client of a fleet: sends a vehicle that hits several columns
// - run.rs: `column-twin run` and `column-twin fleet`: run a node from its arguments to a clean stop
// - security_health.rs: The state of security for `/diagnostics`
// - senders.rs: Which senders the node accepts, and how often: an allow-list and a rate limit per sender, independent of DDS
//   security
// - sending.rs: How a message leaves the node: to its readers, and to the recording
// - sensor_watch.rs: The health of the sensors, in `/diagnostics` and in the log
// - standing_action.rs: What has to be done with a column, as its outputs say it: for alarms and metrics
// - subscribed.rs: What a client of the twin subscribes to, and its waits
// - task.rs: Named threads that run futures until they are stopped
// - transport.rs: The endpoints of a node, whichever transport carries their messages: DDS by ros2-client, or Zenoh
// - transport_error.rs: What a transport could not do, in the words of its library
// - twin_node.rs: The node of one column or many: all topics and services, in separate threads
// - unannounced.rs: Which parameters have not been announced on `/parameter_events` as new yet, and when they are
// - utc.rs: A time for people
// - withheld.rs: Outputs that are published once the damage of their column is written: a node that is killed must not have
//   lost an impact whose forecast is known
// - zenoh/: Zenoh as the transport of a node, as `rmw_zenoh` speaks it: its keys with type hashes, its liveliness tokens for
//   the graph, its attachments, and CDR
// - zenoh_absent.rs: Zenoh in a program without the feature `zenoh`: says so if it is asked for

mod address_space;
#[cfg_attr(not(feature = "alarm"), path = "alarms_absent.rs")]
mod alarms;
mod client;
mod client_error;
mod counters;
mod dds_threads;
mod detected;
mod diagnostics;
mod duplicates;
mod exposition;
mod face;
mod fleet;
mod fleet_view;
#[cfg_attr(not(feature = "foxglove"), path = "foxglove_absent.rs")]
mod foxglove;
mod inputs;
mod lifecycle;
mod lifecycle_services;
mod lifecycle_states;
mod lines;
mod live_columns;
mod loss_log;
mod measure;
mod measurements;
mod metrics;
mod metrics_server;
mod node;
mod node_viewer;
mod notice_log;
mod output_log;
mod parameter_services;
mod publishing;
pub mod qos;
mod qos_overrides;
mod receiving;
#[cfg(feature = "record")]
pub mod replay;
mod requests;
mod row_client;
mod run;
mod security_health;
mod senders;
mod sending;
mod sensor_watch;
mod standing_action;
mod subscribed;
mod task;
mod transport;
mod transport_error;
mod twin_node;
mod unannounced;
mod utc;
mod withheld;
#[cfg_attr(not(feature = "zenoh"), path = "zenoh_absent.rs")]
mod zenoh;

pub use client::{
    ImpactOptions, ImpactOutcome, ImpactRequest, Shown, follow_impact, send_impact, watch,
};
pub use client_error::ClientError;
pub use detected::follow_sensors;
pub use face::Face;
pub use lines::{
    Seen, action_word, actions_in_words, decision_word, in_unit, range_of, report_line,
};
pub use live_columns::{Health, LiveColumns, StartError};
pub use measure::{MeasureOptions, Measured, send_measurements};
pub use node::{Node, NodeError, check_transport};
pub use ros_node::arguments::{ArgumentError, GivenParameters, LogLevel, RosArguments};
pub use ros_node::environment::{
    DiscoveryRange, Environment, EnvironmentError, Transport, ZenohVariables,
};
pub use ros_node::fresh_domain::FreshDomain;
pub use ros_node::matches::Matches;
pub use ros_node::names::{NameError, NameKind, Names, RemapRule, RemapTarget};
pub use ros_node::raw::Raw;
pub use ros_node::rosout::{RosoutQueue, start_logging};
pub use ros_node::security;
pub use ros_node::signals::StopSignals;
pub use row_client::{RowImpactOptions, send_row_impact};
#[cfg(feature = "alarm")]
pub use run::try_alarms;
pub use run::{RunEnd, RunError, RunOptions, run, run_fleet};
pub use transport::{Publisher, Server, Subscription};
pub use transport_error::TransportError;
pub use twin_node::{StartOptions, TwinNode};
pub use zenoh::{ZenohPublisher, ZenohServer, ZenohSubscription};

/// Default name of the node.
pub const NODE_NAME: &str = "column_twin";
