//! Recordings as files: written, cut off, repaired, damaged, exported; read by us and by others.
#![cfg(feature = "record")]
// A test may wait for another thread as it likes: it ends with the test.
#![allow(clippy::disallowed_methods)]

mod bad_input;
mod commands;
mod crash;
mod full_disk;
mod layout;
mod mutations;
mod other_readers;
mod recorder;
mod sample;
mod small_disk;
