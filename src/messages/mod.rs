//! The messages that the twin exchanges with other programs, as Rust types.
//!
//! The files in `msg/` and `srv/` are the single source of fields, order, constants, units and meaning. The structs
//! repeat only fields and constants, and tests compare them with the files; names, type hashes and the schema text in
//! recordings are derived from the files. Each module has the name of its ROS package.
//!
//! ```
//! use column_twin::messages::{Message, cdr, column_twin_msgs::ImpactEvent};
//!
//! let event = ImpactEvent { mass: 1500.0, velocity: 10.0, ..ImpactEvent::default() };
//! let bytes = cdr::encode(&event)?;
//! assert_eq!(cdr::decode::<ImpactEvent>(&bytes)?.mass, 1500.0);
//! assert_eq!(ImpactEvent::INTERFACE.dds_name(), "column_twin_msgs::msg::dds_::ImpactEvent_");
//! # Ok::<(), cdr::CdrError>(())
//! ```
//!
//! Not supported: `wstring`, whose characters have 2 or 4 bytes, depending on the vendor.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - builtin_interfaces.rs: `builtin_interfaces`: time stamps and durations
// - column_twin_msgs.rs: `column_twin`: the messages and services of this program
// - column_twin_msgs_beam.rs: What the fibre beam says, which the module of `column_twin_msgs` re-exports
// - column_twin_msgs_fleet.rs: `column_twin`: messages that only fleets use
// - column_twin_msgs_hinges.rs: What the arrays about hinges and webs consist of, which the module of `column_twin_msgs`
//   re-exports
// - column_twin_msgs_services.rs: The services of `column_twin`, which its module re-exports
// - diagnostic_msgs.rs: `diagnostic_msgs`: the messages on `/diagnostics`
// - from_column.rs: Conversions between the mechanics and messages
// - geometry_msgs.rs: `geometry_msgs`: points, vectors, orientations, accelerations
// - lifecycle_msgs.rs: `lifecycle_msgs`: states and transitions of managed nodes
// - rcl_interfaces.rs: `rcl_interfaces`: log messages and parameter changes, which every node publishes
// - rosgraph_msgs.rs: `rosgraph_msgs`: simulated time
// - sensor_msgs.rs: `sensor_msgs`: joint states, compressed images, readings of inertial sensors
// - service_msgs.rs: `service_msgs`: what every service type refers to for the introspection of services
// - std_msgs.rs: `std_msgs`: header, colour and text
// - std_srvs.rs: `std_srvs`: the service without arguments
// - table.rs: The table of message types: every struct with its ROS name and the file that defines it
// - visualization_msgs.rs: `visualization_msgs`: markers for RViz and Foxglove
// - words.rs: The words that people see for the numbers of phases and actions in messages

mod table;

pub mod builtin_interfaces;
pub mod column_twin_msgs;
mod column_twin_msgs_beam;
mod column_twin_msgs_fleet;
mod column_twin_msgs_hinges;
mod column_twin_msgs_services;
pub mod diagnostic_msgs;
pub(crate) mod from_column;
pub mod geometry_msgs;
pub mod lifecycle_msgs;
pub mod rcl_interfaces;
pub mod rosgraph_msgs;
pub mod sensor_msgs;
pub mod service_msgs;
pub mod std_msgs;
pub mod std_srvs;
pub mod visualization_msgs;
pub mod words;

pub use ros_interface::{
    BoundedSequence, Interface, Message, Part, cdr, idl, interface, type_description, type_hash,
};
pub use table::{INTERFACES, find};
