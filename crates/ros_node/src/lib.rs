//! What users of ROS 2 expect of a node and ros2-client lacks. It knows neither the topics of a program nor what it computes.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - arguments.rs: The arguments after `--ros-args`, as in rcl
//   (<https://design.ros2.org/articles/ros_command_line_arguments.html>)
// - clock_watch.rs: Warns if the node uses simulated time, but no message arrives on `/clock`, or none any more during a
//   response
// - environment.rs: The environment variables of ROS 2 for domain, discovery and namespace
// - fresh_domain.rs: An unused DDS domain on loopback, for a demonstration or a test
// - given_up.rs: Messages that are given up because they are too long
// - guid_prefix.rs: The part of a GUID that names the participant
// - library_log.rs: The warnings and errors of RustDDS and ros2-client, which write to the `log` crate, in the log of this
//   program
// - log_limit.rs: A limit on how many messages go into a log per period
// - lost_peers.rs: Peers that fell silent, because of a broken network or because they were killed, and peers that came back
// - matches.rs: Which of the node's endpoints are matched with a peer
// - missed.rs: Detects lost messages
// - names.rs: Names of topics and services: validation, expansion and remapping
//   (<https://design.ros2.org/articles/topic_and_service_names.html>, static remapping as in rcl)
// - raw.rs: Messages as encoded bytes
// - rosout.rs: Log messages: on the terminal in the format of ROS, and on `/rosout`
// - security/: DDS Security: which enclave a participant belongs to, and whether its files can be used
// - signals.rs: SIGINT and SIGTERM: the first signal asks the program to stop, the second ends it immediately
// - type_descriptions.rs: `~/get_type_description`: what the types of the node look like, as every node of rclcpp and rclpy
//   answers it

pub mod arguments;
pub mod clock_watch;
pub mod environment;
pub mod fresh_domain;
pub mod given_up;
pub mod guid_prefix;
pub mod library_log;
pub mod log_limit;
pub mod lost_peers;
pub mod matches;
pub mod missed;
pub mod names;
pub mod raw;
pub mod rosout;
pub mod security;
pub mod signals;
pub mod type_descriptions;
