//! Parameters that are not compatible.

/// Parameters that are not compatible.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Inconsistency {
    /// The parameter that the message is about, then the others that it depends on.
    pub names: Vec<&'static str>,
    pub message: String,
}
