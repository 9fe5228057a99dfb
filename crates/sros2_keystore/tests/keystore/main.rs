//! Keystores, and the enclaves in them, on disk.

#[allow(dead_code)] // the tests of the node use more of it
mod by_openssl;
mod enclave;
mod made;
mod store;
