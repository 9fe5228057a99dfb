//! The node on the wire: against itself here, against ROS 2 and a DDS program in `real_peers`.
#![cfg(feature = "ros")]
// A test may start an unnamed thread and listen without a bound: it ends with the test.
#![allow(clippy::disallowed_methods)]

mod bad_input;
mod departure;
#[cfg(feature = "record")]
mod detected;
mod domain;
mod duplicates;
mod hostile;
#[allow(dead_code)] // the tests of recordings use more of it
mod incoming;
mod lifecycle;
mod live_twin;
mod loopback;
mod measurements;
mod memory;
mod network;
mod parameter_events;
mod program;
mod qos_overrides;
mod real_peers;
mod real_time;
mod restart;
mod senders;
mod service_bursts;
#[allow(dead_code)] // the tests of the sensors use the rest
#[path = "../estimation/signals.rs"]
mod signals;
mod simulation;
mod stop;
#[cfg(all(feature = "cli", feature = "record"))]
mod stopped;
mod transport;
