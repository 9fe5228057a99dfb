//! The part of a GUID that names the participant.

use std::fmt;

use ros2_client::Gid;

use printable::Hexadecimal;

/// Bytes of a GUID that are the same for everything that belongs to a participant.
pub const GUID_PREFIX_BYTES: usize = 12;

/// A participant on the network.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct GuidPrefix(pub [u8; GUID_PREFIX_BYTES]);

impl From<Gid> for GuidPrefix {
    fn from(gid: Gid) -> Self {
        let mut prefix = [0; GUID_PREFIX_BYTES];
        prefix.copy_from_slice(&gid.to_bytes16()[..GUID_PREFIX_BYTES]);
        Self(prefix)
    }
}

impl fmt::Display for GuidPrefix {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        Hexadecimal(&self.0).fmt(f)
    }
}
