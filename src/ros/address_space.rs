//! How much address space the system grants to the node.

use rustix::process::{Resource, getrlimit};

/// Least address space with which a node starts \[bytes\]. The threads with their stacks, the sockets' buffers and the recorder take
/// about 250 MB at the start; further impacts, readers and viewers need the rest.
const NEEDED: u64 = 512 << 20;

/// The system grants too little address space. Without this error, the program would abort at the first allocation that does
/// not fit, perhaps in the middle of a response.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "the address space of the process is limited to {} MB, but a node needs at least {} MB; raise the limit (ulimit -v, LimitAS in a \
     systemd unit), or limit the memory of its control group instead (MemoryMax)",
    .0 >> 20,
    NEEDED >> 20
)]
pub struct TooLittleAddressSpace(u64);

/// To be called before the first thread is started.
pub(super) fn check_address_space() -> Result<(), TooLittleAddressSpace> {
    check(getrlimit(Resource::As).current)
}

fn check(limit: Option<u64>) -> Result<(), TooLittleAddressSpace> {
    match limit {
        Some(limit) if limit < NEEDED => Err(TooLittleAddressSpace(limit)),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_below_what_a_node_needs_is_an_error_that_says_how_much() {
        assert_eq!(check(None), Ok(()));
        assert_eq!(check(Some(NEEDED)), Ok(()));
        let said = check(Some(200_000 << 10))
            .expect_err("too little")
            .to_string();
        assert!(
            said.contains("limited to 195 MB") && said.contains("at least 512 MB"),
            "{said}"
        );
    }
}
