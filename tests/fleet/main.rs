//! Many columns in one process: their parameters, their solver threads, their node.
#![cfg(all(feature = "cli", feature = "ros"))]
// A test may start an unnamed thread and listen without a bound: it ends with the test.
#![allow(clippy::disallowed_methods)]

mod all_at_once;
mod column_topics;
mod detected;
#[path = "../ros/domain.rs"]
mod domain;
mod drivers;
#[path = "../ros/incoming.rs"]
#[allow(dead_code)] // the tests of a single twin use more of it
mod incoming;
mod memory;
mod node;
mod parameter_services;
mod parameters;
mod pool;
#[path = "../ros/program.rs"]
#[allow(dead_code)] // the tests of a single twin use more of it
mod program;
mod real_peers;
mod row;
mod sensors;
mod shard;
mod studies;
