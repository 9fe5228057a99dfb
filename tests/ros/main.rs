//! The node on the wire: against itself here, against ROS 2 and a DDS program in `real_peers`.
#![cfg(feature = "ros")]

mod bad_input;
mod domain;
mod live_twin;
mod loopback;
mod real_peers;
mod scripted_twin;
