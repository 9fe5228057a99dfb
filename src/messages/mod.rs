//! What travels between the twin and the world: the types of `msg/` and `srv/`, their bytes, names and hashes.
//!
//! The `.msg` and `.srv` files are the single source of fields, order, constants, units and meaning. The structs
//! here repeat fields and constants only, and tests hold them to the files; names, type hashes and the text that
//! recordings embed are computed from the files. A module bears the name of its ROS package.
//!
//! ```
//! use column_twin::messages::{Message, cdr, column_twin::ImpactEvent};
//!
//! let event = ImpactEvent { mass: 1500.0, velocity: 10.0, ..ImpactEvent::default() };
//! let bytes = cdr::encode(&event)?;
//! assert_eq!(cdr::decode::<ImpactEvent>(&bytes)?.mass, 1500.0);
//! assert_eq!(ImpactEvent::INTERFACE.dds_name(), "column_twin::msg::dds_::ImpactEvent_");
//! # Ok::<(), cdr::CdrError>(())
//! ```
//!
//! Deliberately absent: the type hash of a service as a whole (nothing announces or records it) and `wstring`
//! (2 against 4 bytes per character between vendors).

pub mod cdr;
pub mod idl;
pub mod interface;
mod table;
pub mod type_hash;

pub mod builtin_interfaces;
pub mod column_twin;
pub mod diagnostic_msgs;
mod from_column;
pub mod geometry_msgs;
pub mod rcl_interfaces;
pub mod rosgraph_msgs;
pub mod sensor_msgs;
pub mod std_msgs;
pub mod std_srvs;
pub mod visualization_msgs;

pub use interface::{Interface, Message};
pub use table::{INTERFACES, find};
