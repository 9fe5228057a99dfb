//! What the delivery tells its host, for the log.

use std::sync::Arc;

/// How important a notice is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Importance {
    /// Good to know.
    Info,
    /// Something does not work; it is tried again.
    Warning,
    /// A message is lost, or may be.
    Error,
}

/// Takes notices. It is called from the threads of the delivery and must not wait.
pub type Notices = Arc<dyn Fn(Importance, String) + Send + Sync>;
