//! A topic of a recording and its quality of service, in the terms of rosbag2.

use serde::{Deserialize, Serialize};

use crate::bounded_yaml;

/// A topic to be recorded.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TopicInfo {
    /// Resolved name, `/robot/odometry`.
    pub name: String,
    /// ROS name of the type, `std_msgs/msg/String`.
    pub type_name: String,
    /// Definition of the type and its dependencies in the encoding `ros2msg`.
    pub schema: String,
    /// Hash of the type, `RIHS01_...`; may be empty.
    pub type_hash: String,
    /// The quality of service that its publisher offers.
    pub qos: OfferedQos,
}

/// Quality of service that a publisher offers. Deadline and lifespan are infinite, liveliness is automatic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OfferedQos {
    /// Lost samples are sent again.
    pub reliable: bool,
    /// Late joiners get the last samples.
    pub transient_local: bool,
    /// Number of samples that are kept.
    pub depth: usize,
}

/// The duration that ROS 2 treats as infinite.
const INFINITE: Span = Span {
    sec: 9_223_372_036,
    nsec: 854_775_807,
};

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Span {
    sec: u64,
    nsec: u64,
}

/// A profile as rosbag2 writes it in version 9: with words for the policies.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct QosProfile {
    history: &'static str,
    depth: usize,
    reliability: &'static str,
    durability: &'static str,
    deadline: Span,
    lifespan: Span,
    liveliness: &'static str,
    liveliness_lease_duration: Span,
    avoid_ros_namespace_conventions: bool,
}

/// The part of a profile that is read, of any version.
#[derive(Debug, Deserialize)]
struct ReadProfile {
    #[serde(default)]
    depth: usize,
    #[serde(default)]
    reliability: WordOrNumber,
    #[serde(default)]
    durability: WordOrNumber,
}

/// A policy: up to version 8 a number of `rmw/types.h`, later a word.
#[derive(Debug, Default, Deserialize)]
#[serde(untagged)]
enum WordOrNumber {
    #[default]
    Missing,
    Word(String),
    Number(i64),
}

impl WordOrNumber {
    fn is(&self, word: &str, number: i64) -> bool {
        match self {
            Self::Missing => false,
            Self::Word(found) => found == word,
            Self::Number(found) => *found == number,
        }
    }
}

impl OfferedQos {
    pub(crate) fn profile(self) -> QosProfile {
        QosProfile {
            history: "keep_last",
            depth: self.depth,
            reliability: if self.reliable {
                "reliable"
            } else {
                "best_effort"
            },
            durability: if self.transient_local {
                "transient_local"
            } else {
                "volatile"
            },
            deadline: INFINITE,
            lifespan: INFINITE,
            liveliness: "automatic",
            liveliness_lease_duration: INFINITE,
            avoid_ros_namespace_conventions: false,
        }
    }

    /// The text for the channel metadata `offered_qos_profiles`.
    pub(crate) fn to_yaml(self) -> Result<String, serde_yaml_ng::Error> {
        serde_yaml_ng::to_string(&[self.profile()])
    }

    /// The first profile of such a text, of any version; `None` if none can be read.
    pub(crate) fn from_yaml(text: &str) -> Option<Self> {
        let profiles: Vec<ReadProfile> = bounded_yaml::parse(text).ok()?;
        profiles.first().map(|profile| Self {
            reliable: profile.reliability.is("reliable", 1),
            transient_local: profile.durability.is("transient_local", 1),
            depth: profile.depth,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_profile_reads_back() {
        for (reliable, transient_local, depth) in [(true, false, 1000), (false, true, 1)] {
            let qos = OfferedQos {
                reliable,
                transient_local,
                depth,
            };
            assert_eq!(OfferedQos::from_yaml(&qos.to_yaml().unwrap()), Some(qos));
        }
    }

    /// As `ros2 bag record` of Humble wrote them.
    #[test]
    fn numbers_of_older_versions_are_read() {
        let text = "- history: 3\n  depth: 7\n  reliability: 1\n  durability: 1\n  deadline:\n    sec: 9223372036\n    nsec: 854775807\n";
        let expected = OfferedQos {
            reliable: true,
            transient_local: true,
            depth: 7,
        };
        assert_eq!(OfferedQos::from_yaml(text), Some(expected));
        assert_eq!(OfferedQos::from_yaml(""), None);
        assert_eq!(OfferedQos::from_yaml("[1, {"), None);
    }
}
