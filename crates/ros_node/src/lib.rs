//! What users of ROS 2 expect of a node and ros2-client lacks. It knows neither the topics of a program nor what it computes.

pub mod arguments;
pub mod clock_watch;
pub mod environment;
pub mod exposition;
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
