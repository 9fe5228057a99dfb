//! Recordings as evidence: every recording of a twin can be recomputed bit for bit, and every change in it is found.
#![cfg(all(feature = "ros", feature = "record"))]
// A test may start an unnamed thread and listen without a bound: it ends with the test.
#![allow(clippy::disallowed_methods)]

mod commands;
mod copies;
mod critical;
#[path = "../ros/domain.rs"]
mod domain;
mod dropped;
mod estimates;
mod fleet;
mod forgeries;
#[allow(dead_code)] // the tests of the recordings use the rest
#[path = "../../crates/recording/tests/recording/forging.rs"]
mod forging;
mod full_disk;
#[allow(dead_code)] // the tests of the node use the rest
#[path = "../ros/incoming.rs"]
mod incoming;
mod killed;
mod measurements;
mod node;
#[allow(dead_code)] // the tests of the recordings use the rest
#[path = "../../crates/recording/tests/recording/random_damage.rs"]
mod random_damage;
mod range;
mod recomputed_estimates;
mod recorded_twin;
mod replayed;
mod rotations;
mod scenarios;
mod scripted_fleet;
mod sealed;
mod second_opinion;
#[cfg(feature = "viewer")]
mod shown;
#[allow(dead_code)] // the tests of the sensors use the rest
#[path = "../estimation/signals.rs"]
mod signals;
#[path = "../../crates/recording/tests/recording/small_disk.rs"]
mod small_disk;
mod tampering;
mod unsealed;
mod written;
