//! An accepted impact that has no report.

use std::sync::Arc;

use super::striking::Striking;
use crate::time::Nanos;

/// An accepted impact that has no report.
#[derive(Debug, Clone)]
pub struct WithdrawnImpact {
    /// Stamp of the event.
    pub stamp: Nanos,
    /// Its identifier.
    pub event_id: Arc<str>,
    /// What hits the column.
    pub striking: Striking,
}
