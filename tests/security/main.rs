//! Keystores, and a node in one with secured peers of another make.
#![cfg(feature = "security")]
// A test may start an unnamed thread and listen without a bound: it ends with the test.
#![allow(clippy::disallowed_methods)]

mod commands;
#[path = "../ros/domain.rs"]
mod domain;
mod fast_dds;
mod made;
mod permissions;
mod plans;
#[allow(dead_code)] // the tests of the node use more of it
#[path = "../ros/program.rs"]
mod program;
mod quick_start;
