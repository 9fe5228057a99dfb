//! What comes into the twin.

use std::sync::Arc;
use std::sync::mpsc::SyncSender;

use serde::{Deserialize, Serialize};

use super::exact_number;
use super::parameter_change::Change;
use super::present::{Blow, Present};
use crate::parameters::Value;

/// Nanoseconds since the epoch of the clock that the twin is driven by: that of ROS, or simulated time.
pub type Nanos = i64;

/// One thing that the twin is asked to do. A reply goes into a channel of its sender, which should have room for one;
/// where it has none, or the sender is gone, the reply is dropped.
#[derive(Debug, Clone)]
pub enum Input {
    /// Something hits the column.
    Impact(ImpactEvent),
    /// Change parameters, all or none.
    Parameters {
        /// Names and values.
        changes: Vec<(String, Value)>,
        /// Who asks, for logs.
        source: Arc<str>,
        /// What became of it, or why it was refused.
        reply: Option<SyncSender<Result<Change, Arc<str>>>>,
    },
    /// A change of parameters that was found wrong before it came here: it cannot be read, or is for another column.
    /// Refused, and said, as every other one.
    RefusedChange {
        /// Why.
        reason: Arc<str>,
        /// Who asks, for logs.
        source: Arc<str>,
    },
    /// Back to the virgin column.
    Reset {
        /// Who asks, for logs.
        source: Arc<str>,
        /// Told when it is done.
        reply: Option<SyncSender<()>>,
    },
    /// A copy of the column as it is, for [`Present::predict`] in the caller's own thread.
    Look {
        /// Gets the copy.
        reply: SyncSender<Present>,
    },
}

/// An impact event as its sender tells it; nothing of it is trusted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImpactEvent {
    /// Chosen by the sender, 1 to [`MAX_EVENT_ID_CHARS`](super::MAX_EVENT_ID_CHARS) characters.
    pub event_id: String,
    /// The column that is hit.
    pub column_id: String,
    /// Instant of contact, or of the gap's measurement where the gap is not zero.
    pub stamp: Nanos,
    /// Mass of the vehicle \[kg\], > 0.
    #[serde(with = "exact_number")]
    pub impact_mass: f64,
    /// Speed of the vehicle towards the column, over the ground; the closing speed on a column at rest
    /// \[m/s\], > 0.
    #[serde(with = "exact_number")]
    pub velocity: f64,
    /// Distance to the column at the stamp \[m\], >= 0; `None`: parameter `impact.gap`.
    #[serde(with = "exact_number::option")]
    pub gap: Option<f64>,
    /// Newton's coefficient of restitution, 0 to 1; `None`: parameter `impact.restitution`.
    #[serde(with = "exact_number::option")]
    pub restitution: Option<f64>,
    /// Height of the impact above the base \[m\]; `None`: parameter `geometry.length_below`.
    #[serde(with = "exact_number::option")]
    pub height: Option<f64>,
}

impl ImpactEvent {
    /// The part that the mechanics needs.
    pub fn blow(&self) -> Blow {
        Blow {
            mass: self.impact_mass,
            velocity: self.velocity,
            gap: self.gap,
            restitution: self.restitution,
            height: self.height,
        }
    }
}
