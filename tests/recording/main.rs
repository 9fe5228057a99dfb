//! Recordings of this program: layout, commands, and other programs that read them.
#![cfg(feature = "record")]
// A test may wait for another thread as it likes: it ends with the test.
#![allow(clippy::disallowed_methods)]

mod commands;
mod earlier;
#[allow(dead_code)] // the tests of the crate use the rest
#[path = "../../crates/recording/tests/recording/forging.rs"]
mod forging;
#[path = "../../crates/recording/tests/recording/killed_process.rs"]
mod killed_process;
mod layout;
mod other_readers;
#[path = "../../crates/recording/tests/recording/random_damage.rs"]
mod random_damage;
mod sample;
