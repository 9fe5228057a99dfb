//! Bytes and type hashes are those that other programs compute: `tests/data/messages/golden.json` is written by
//! `rosbags` and rosidl, see `tests/interop/check_messages.py`.

use std::collections::BTreeMap;

use column_twin::messages::type_hash::TypeHash;
use column_twin::messages::{INTERFACES, Message, cdr, std_msgs};
use serde::Deserialize;

use super::{ForEachType, for_each_type};

/// What other programs say of one type.
#[derive(Deserialize)]
pub struct Golden {
    pub type_hash: String,
    /// A filled message in CDR with encapsulation, hexadecimal.
    pub cdr: String,
    /// The same message as JSON.
    pub sample: serde_json::Value,
}

impl Golden {
    pub fn bytes(&self) -> Vec<u8> {
        (0..self.cdr.len())
            .step_by(2)
            .map(|at| u8::from_str_radix(&self.cdr[at..at + 2], 16).unwrap())
            .collect()
    }
}

/// By ROS name.
pub fn golden() -> BTreeMap<String, Golden> {
    serde_json::from_str(include_str!("../data/messages/golden.json")).unwrap()
}

struct SameBytes(BTreeMap<String, Golden>);

impl ForEachType for SameBytes {
    fn visit<M: Message + PartialEq + std::fmt::Debug>(&mut self) {
        let name = M::INTERFACE.ros_name();
        let golden = &self.0[&name];
        let message: M = serde_json::from_value(golden.sample.clone()).unwrap();
        assert_eq!(
            hexadecimal(&cdr::encode(&message).unwrap()),
            golden.cdr,
            "{name}"
        );
        assert_eq!(
            cdr::decode::<M>(&golden.bytes()).unwrap(),
            message,
            "{name}"
        );
    }
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[test]
fn every_type_has_the_bytes_that_rosbags_writes() {
    for_each_type(&mut SameBytes(golden()));
}

#[test]
fn every_type_has_the_hash_that_rosidl_writes() {
    let golden = golden();
    for interface in INTERFACES {
        let name = interface.ros_name();
        assert_eq!(
            TypeHash::of(interface, INTERFACES).unwrap().to_string(),
            golden[&name].type_hash,
            "{name}"
        );
    }
    assert_eq!(golden.len(), INTERFACES.len());
}

/// The two hashes that everybody can look up, independent of the golden data.
#[test]
fn hashes_of_string_and_header_are_the_published_ones() {
    let string = TypeHash::of(std_msgs::String::INTERFACE, INTERFACES).unwrap();
    assert_eq!(
        string.to_string(),
        "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
    );
    let header = TypeHash::of(std_msgs::Header::INTERFACE, INTERFACES).unwrap();
    assert_eq!(
        header.to_string(),
        "RIHS01_f49fb3ae2cf070f793645ff749683ac6b06203e41c891e17701b1cb597ce6a01"
    );
}
