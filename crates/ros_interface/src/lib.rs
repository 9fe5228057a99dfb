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

mod bounded_sequence;
pub mod cdr;
pub mod idl;
pub mod interface;
pub mod type_description;
pub mod type_hash;

pub use bounded_sequence::BoundedSequence;
pub use interface::{Definitions, Interface, Message, Part, find};
