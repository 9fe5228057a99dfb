//! What a transport could not do, in the words of its library.

use std::fmt;

/// Why a message cannot be sent, or what was received cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct TransportError(String);

impl TransportError {
    /// With the words of the library.
    pub(super) fn new(reason: impl fmt::Display) -> Self {
        Self(reason.to_string())
    }
}
