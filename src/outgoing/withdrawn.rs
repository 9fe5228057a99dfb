//! A forecast that no longer holds, or that will never be there, as a message.

use crate::column::{HINGES, WEBS};
use crate::messages::column_twin_msgs::{BaseForces, ImpactReport, PerHinge, SecondOpinion};
use crate::twin::{ForecastEnd, WithdrawnForecast};

impl ImpactReport {
    /// A report of the kind WITHDRAWN or NO_FORECAST without the impact: all results are NaN.
    #[must_use]
    pub fn without_results(kind: u8, end: u8, reason: &str) -> Self {
        let unknown = PerHinge::from([f64::NAN; HINGES]);
        let of_webs = PerHinge::from([f64::NAN; WEBS]);
        Self {
            kind,
            outcome: Self::OUTCOME_UNKNOWN,
            max_v1: f64::NAN,
            max_v1_time: f64::NAN,
            residual_v1: f64::NAN,
            max_u2: f64::NAN,
            residual_u2: f64::NAN,
            release_time: f64::NAN,
            impactor_rebound: f64::NAN,
            peak_contact_force: f64::NAN,
            impulse: f64::NAN,
            plastic_work: f64::NAN,
            impact_loss: f64::NAN,
            ledger_residual: f64::NAN,
            compute_time: f64::NAN,
            first_yield_time: unknown,
            max_utilisation: unknown,
            plastic_rotation: unknown,
            web_first_yield_time: of_webs,
            web_max_utilisation: of_webs,
            shear_angle: of_webs,
            base_plateau: BaseForces::UNKNOWN,
            base_peak_shear: BaseForces::UNKNOWN,
            base_peak_shear_time: f64::NAN,
            base_reversed_shear: BaseForces::UNKNOWN,
            base_peak_moment: BaseForces::UNKNOWN,
            base_least_compressed: BaseForces::UNKNOWN,
            base_most_compressed: BaseForces::UNKNOWN,
            base_checked_moment: BaseForces::UNKNOWN,
            end,
            end_time: f64::NAN,
            max_dynamic_factor: unknown,
            undamaged_capacity: f64::NAN,
            residual_capacity: f64::NAN,
            capacity_ratio: f64::NAN,
            reserve: f64::NAN,
            beam: SecondOpinion::none(reason),
            action: Self::ACTION_UNKNOWN,
            action_reason: reason.to_owned(),
            range_least: Self::ACTION_UNKNOWN,
            range_most: Self::ACTION_UNKNOWN,
            error_estimate: f64::NAN,
            dt: f64::NAN,
            ..Self::default()
        }
    }
}

impl From<&WithdrawnForecast> for ImpactReport {
    /// Leaves header, column and event empty.
    fn from(withdrawn: &WithdrawnForecast) -> Self {
        let WithdrawnForecast {
            impact,
            was_known,
            error_estimate,
            end,
            reason,
        } = withdrawn;
        let kind = match was_known {
            true => Self::WITHDRAWN,
            false => Self::NO_FORECAST,
        };
        Self {
            error_estimate: error_estimate.unwrap_or(f64::NAN),
            ..Self::without_results(kind, end_code(*end), reason).struck_by(&impact.striking)
        }
    }
}

fn end_code(end: ForecastEnd) -> u8 {
    match end {
        ForecastEnd::Superseded => ImpactReport::END_SUPERSEDED,
        ForecastEnd::Reset => ImpactReport::END_RESET,
        ForecastEnd::Stopped => ImpactReport::END_STOPPED,
        ForecastEnd::Rejected => ImpactReport::END_REJECTED,
        ForecastEnd::NotComputed => ImpactReport::END_NOT_COMPUTED,
    }
}
