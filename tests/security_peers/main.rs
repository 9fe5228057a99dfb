//! DDS Security: enclaves on loopback, peers that must not get anything through, enclaves that cannot be used.
// A test may start an unnamed thread and listen without a bound: it ends with the test.
#![allow(clippy::disallowed_methods)]

mod broken_enclaves;
#[path = "../../crates/sros2_keystore/tests/keystore/by_openssl.rs"]
mod by_openssl;
#[path = "../ros/domain.rs"]
mod domain;
mod hostile;
#[allow(dead_code)] // the tests of recordings use more of it
#[path = "../ros/incoming.rs"]
mod incoming;
mod payload;
mod peer;
#[allow(dead_code)] // the tests of the node use more of it
#[path = "../ros/program.rs"]
mod program;
mod start;
