//! Reports about recordings: what they contain, what they say of recordings that cannot be verified, and how they look in a
//! real browser.
#![cfg(all(feature = "cli", feature = "record"))]
// A test may start an unnamed thread: it ends with the test.
#![allow(clippy::disallowed_methods)]

mod browser;
#[allow(dead_code)] // the tests of the evidence use more of it
#[path = "../evidence/copies.rs"]
mod copies;
mod estimates;
mod pages;
#[allow(dead_code)] // the tests of the evidence use more of it
#[path = "../evidence/recorded_twin.rs"]
mod recorded_twin;
mod recordings;
