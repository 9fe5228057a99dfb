//! Answers of services: about what was detected and measured on the column, and about resets.

use crate::messages::column_twin_msgs::{
    ConfirmEstimateRequest, ConfirmEstimateResponse, CorrectDamageRequest, CorrectDamageResponse,
    ResetColumnResponse,
};
use crate::messages::std_srvs::TriggerResponse;
use crate::sensors::Quantity;
use crate::twin::{
    Accepted, Command, EstimateDecision, Rejection, RejectionCode, ResidualMeasurement,
};

use super::qos;

impl ros2_client::Message for ConfirmEstimateRequest {}
impl ros2_client::Message for ConfirmEstimateResponse {}
impl ros2_client::Message for CorrectDamageRequest {}
impl ros2_client::Message for CorrectDamageResponse {}

/// The answer to the reset of a single twin.
pub(super) fn was_reset(outcome: Result<Accepted, Rejection>) -> TriggerResponse {
    TriggerResponse {
        success: outcome.is_ok(),
        message: match outcome {
            Ok(_) => "the column is undamaged".to_owned(),
            Err(rejection) => rejection.tagged(),
        },
    }
}

/// The answer to the reset of a column of a fleet.
pub(super) fn column_was_reset(outcome: Result<Accepted, Rejection>) -> ResetColumnResponse {
    match outcome {
        Ok(_) => ResetColumnResponse {
            success: true,
            ..ResetColumnResponse::default()
        },
        Err(Rejection { code, reason }) => ResetColumnResponse {
            success: false,
            rejection_code: code.number(),
            message: reason.to_string(),
        },
    }
}

/// Passes a decision about an estimate to a twin.
pub(super) fn confirm_estimate(
    request: ConfirmEstimateRequest,
    execute: impl FnOnce(Command) -> Result<Accepted, Rejection>,
) -> ConfirmEstimateResponse {
    let message = match request.accept {
        true => "the impact is one of the twin",
        false => "the impact is rejected",
    };
    let outcome = execute(Command::DecideEstimate(EstimateDecision {
        event_id: request.event_id,
        accept: request.accept,
        source: format!("service {}", qos::CONFIRM_ESTIMATE.name).into(),
    }));
    match outcome {
        Ok(_) => ConfirmEstimateResponse {
            success: true,
            message: message.to_owned(),
            ..ConfirmEstimateResponse::default()
        },
        Err(rejection) => not_decided(&rejection),
    }
}

/// The answer to a decision that was not taken.
pub(super) fn not_decided(rejection: &Rejection) -> ConfirmEstimateResponse {
    ConfirmEstimateResponse {
        success: false,
        rejection_code: rejection.code.number(),
        message: rejection.reason.to_string(),
    }
}

/// Passes a measurement on the column at rest to a twin.
pub(super) fn correct_damage(
    request: &CorrectDamageRequest,
    execute: impl FnOnce(Command) -> Result<Accepted, Rejection>,
) -> CorrectDamageResponse {
    let quantity = match request.quantity {
        CorrectDamageRequest::DISPLACEMENT => Quantity::Displacement,
        CorrectDamageRequest::ROTATION => Quantity::Rotation,
        other => {
            let reason = format!("quantity = {other}: expected 0 (DISPLACEMENT) or 1 (ROTATION)");
            let code = RejectionCode::MeasurementImplausible;
            return not_corrected(&Rejection::new(code, reason));
        }
    };
    let outcome = execute(Command::CorrectDamage(ResidualMeasurement {
        quantity,
        height: request.height,
        value: request.value,
        deviation: request.deviation,
        source: format!("service {}", qos::CORRECT_DAMAGE.name).into(),
    }));
    match outcome {
        Ok(Accepted::DamageCorrected(it)) => CorrectDamageResponse {
            success: true,
            rejection_code: 0,
            message: it.in_words(),
            before: it.before,
            after: it.after,
            factor: it.factor,
        },
        Ok(_) => not_corrected(&Rejection::new(
            RejectionCode::NoAnswer,
            "the twin has answered another command",
        )),
        Err(rejection) => not_corrected(&rejection),
    }
}

/// The answer to a measurement that was not taken.
pub(super) fn not_corrected(rejection: &Rejection) -> CorrectDamageResponse {
    CorrectDamageResponse {
        success: false,
        rejection_code: rejection.code.number(),
        message: rejection.reason.to_string(),
        before: f64::NAN,
        after: f64::NAN,
        factor: f64::NAN,
    }
}
