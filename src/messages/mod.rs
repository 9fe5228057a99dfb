//! The messages that the twin exchanges with other programs, as Rust types.
//!
//! The files in `msg/` and `srv/` are the single source of fields, order, constants, units and meaning: `build.rs` writes the structs, the
//! constants and the table of all types from them, and names, type hashes and the schema text in recordings are derived from them,
//! too. Each module has the name of its ROS package.
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
// - arrays.rs: What the arrays about hinges, webs and masses consist of
// - from_column.rs: Conversions between the mechanics and messages
// - parameter_entry.rs: One parameter of a message
// - statuses.rs: What the statuses of a twin and of a column of a fleet say
// - time.rs: Times of messages as nanoseconds
// - words.rs: The words that people see for the numbers of phases and actions in messages

mod arrays;
pub(crate) mod from_column;
mod parameter_entry;
mod statuses;
mod time;
pub mod words;

mod definitions {
    use ros_interface::{Interface, Message, Part};

    include!(concat!(env!("OUT_DIR"), "/messages.rs"));
}

pub use definitions::{
    INTERFACES, builtin_interfaces, diagnostic_msgs, geometry_msgs, lifecycle_msgs, rcl_interfaces,
    rosgraph_msgs, sensor_msgs, service_msgs, std_msgs, std_srvs, visualization_msgs,
};
pub use ros_interface::{
    BoundedSequence, Interface, Message, Part, cdr, idl, interface, type_description, type_hash,
};

/// `column_twin_msgs`: the messages and services of this program.
pub mod column_twin_msgs {
    pub use super::arrays::{MAX_HINGES, PerHinge, PerMass};
    pub use super::definitions::column_twin_msgs::*;
    pub use super::parameter_entry::ParameterEntry;
}

/// The type with this ROS name, for example `column_twin_msgs/msg/ColumnState`.
pub fn find(ros_name: &str) -> Option<&'static Interface> {
    ros_interface::find(ros_name, INTERFACES)
}
