//! ROS 2 interface definitions without an installed ROS 2: fields and constants, names, schema text, type hashes, CDR, IDL.
//!
//! An [`Interface`] is one `.msg` file or one half of a `.srv` file. What depends on other definitions takes the
//! [`Definitions`] in which to look them up.
//!
//! ```
//! use ros_interface::{Interface, Message, Part, cdr, type_hash::TypeHash};
//! use serde::{Deserialize, Serialize};
//!
//! #[derive(Serialize, Deserialize)]
//! struct Text {
//!     data: String,
//! }
//!
//! impl Message for Text {
//!     const INTERFACE: &'static Interface =
//!         &Interface::new("std_msgs", Part::Message, "String", "string data\n");
//! }
//!
//! let bytes = cdr::encode(&Text { data: "hello".to_owned() })?;
//! assert_eq!(cdr::decode::<Text>(&bytes)?.data, "hello");
//! let definitions = [Text::INTERFACE];
//! assert_eq!(Text::INTERFACE.dds_name(), "std_msgs::msg::dds_::String_");
//! assert_eq!(
//!     TypeHash::of(Text::INTERFACE, &definitions)?.to_string(),
//!     "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18",
//! );
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - bounded_sequence.rs: A bounded sequence of a message, such as `float64[<=3]`
// - cdr.rs: The bytes of a message: an encapsulation header of four bytes, then CDR (OMG RTPS 10.2, XTypes 7.4)
// - idl.rs: Messages as OMG IDL, for a monitor that uses plain DDS: names, order and types are those on the wire, the comments
//   are those of the definitions
// - interface.rs: A ROS 2 type: its names, its definition, and what follows from the definition
// - names.rs: What names of nodes, topics and services may look like
//   (<https://design.ros2.org/articles/topic_and_service_names.html>)
// - type_description.rs: Descriptions of types as REP-2011 and REP-2016 define them: what a type hash is computed over, and
//   what the service `~/get_type_description` answers
// - type_hash.rs: Type hashes as REP-2016 defines them (RIHS01) and as rosidl writes them to `share/<package>/msg/<Type>.json`

mod bounded_sequence;
pub mod cdr;
pub mod idl;
pub mod interface;
pub mod names;
pub mod type_description;
pub mod type_hash;

pub use bounded_sequence::BoundedSequence;
pub use interface::{Definitions, Interface, Message, Part, find};
