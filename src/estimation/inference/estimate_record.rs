//! An estimate together with what made it so.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::column::{Impact, Vehicle};
use crate::estimation::detection::detector::Detection;
use crate::estimation::inference::estimate::ImpactEstimate;
use crate::estimation::inference::event_evidence::EventEvidence;
use crate::exact_number;
use crate::standing::StandingColumn;
use crate::time::Nanos;

/// One estimate of an impact, with what is needed to compute it again from recorded measurements, bit for bit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EstimateRecord {
    /// The twin's own identifier of the impact.
    pub event_id: Arc<str>,
    /// Number of this estimate among those of the impact, from 0.
    pub update: u32,
    /// No estimate of this impact follows.
    pub is_final: bool,
    /// How the impact was detected. Its times are seconds after `origin`.
    pub detection: Detection,
    /// The instant from which the times of the estimate count, by the clock of the twin \[ns\].
    pub origin: Nanos,
    /// The column for which the first estimate of an impact was computed; the later ones do not repeat it.
    pub column: Option<StandingColumn>,
    /// Batches of measurements that it rests on, counted from the first one of the program.
    pub batches: u64,
    /// The first of them whose samples were still known when the impact was detected, counted in the same way.
    pub first_batch: u64,
    /// The last of them, by which a recording that begins later finds the count: its sensor, and the time of its first sample.
    pub last_batch: (u16, Nanos),
    /// Batches lost before they reached the estimator, counted from the first one of the program; with any among those
    /// it rests on, it cannot be computed again.
    pub lost_batches: u64,
    /// Hypotheses whose responses were prepared when the impact was detected.
    pub prepared: u32,
    /// Responses that were drawn after the estimate before this one, before the data of this one were used.
    pub drawn_before: u32,
    /// Responses that were drawn with the data of this estimate.
    pub drawn: u32,
    /// Whether the answer of the fibre beam, which was asked for an earlier estimate, counts for this one.
    #[serde(default, skip_serializing_if = "is_false")]
    pub counts_beam: bool,
    /// What events say about the impact, which counted beside the data.
    pub events: Vec<EventEvidence>,
    /// What the data say.
    pub estimate: ImpactEstimate,
    /// The single impact that explains the data best on the column as the parameters describe it, with its vehicle: what
    /// the twin follows once the estimate is accepted.
    #[serde(with = "ExactImpact")]
    pub best: Impact,
}

/// An impact in JSON with numbers that read back to the last bit, whatever they are.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Impact", deny_unknown_fields)]
struct ExactImpact {
    #[serde(with = "exact_number")]
    mass: f64,
    #[serde(with = "exact_number")]
    velocity: f64,
    #[serde(with = "exact_number")]
    gap: f64,
    #[serde(with = "exact_number")]
    restitution: f64,
    vehicle: Option<Vehicle>,
    #[serde(with = "exact_number", default)]
    bumper_height: f64,
    // Absent in recordings of programs that know no such force, and 0 in every estimate.
    #[serde(default, with = "exact_number", skip_serializing_if = "is_zero")]
    transverse_force: f64,
}

#[allow(clippy::trivially_copy_pass_by_ref)] // as serde calls it
fn is_false(it: &bool) -> bool {
    !it
}

fn is_zero(number: &f64) -> bool {
    *number == 0.0
}
