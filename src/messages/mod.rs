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

mod table;

pub mod builtin_interfaces;
pub mod column_twin_msgs;
mod column_twin_msgs_fleet;
mod column_twin_msgs_hinges;
mod column_twin_msgs_services;
pub mod diagnostic_msgs;
pub(crate) mod from_column;
pub mod geometry_msgs;
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
