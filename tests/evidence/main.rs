//! Recordings as evidence: whatever happens to a twin, its recording can be computed anew, bit for bit, and nothing that
//! was changed in it goes unnoticed.
#![cfg(all(feature = "ros", feature = "record"))]
// A test may start an unnamed thread and listen without a bound: it ends with the test.
#![allow(clippy::disallowed_methods)]

mod commands;
mod courses;
#[path = "../ros/domain.rs"]
mod domain;
mod dropped;
mod forgeries;
mod full_disk;
#[allow(dead_code)] // the tests of the node use more of it
#[path = "../ros/incoming.rs"]
mod incoming;
mod killed;
mod node;
mod recorded_twin;
mod replayed;
#[path = "../../crates/recording/tests/recording/small_disk.rs"]
mod small_disk;
