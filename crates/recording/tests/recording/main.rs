//! Recordings as files: written, cut off, damaged, read and repaired.
// A test may wait for another thread as it likes: it ends with the test.
#![allow(clippy::disallowed_methods)]

mod bad_input;
mod crash;
mod forged_index;
mod forging;
mod full_disk;
mod index_forging;
mod killed_process;
mod layout;
mod mutations;
mod random_damage;
mod recorder;
mod resealing;
mod sample;
mod seal;
mod seal_keys;
mod sealed_repairs;
mod sealed_sessions;
mod slow_input;
mod small_disk;
mod unsealed_notes;
