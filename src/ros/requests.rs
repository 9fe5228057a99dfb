//! The services about what was felt and measured on the column.

use crate::messages::column_twin_msgs::{
    CalibrateRequest, CalibrateResponse, ConfirmEstimateRequest, ConfirmEstimateResponse,
};
use crate::sensors::Quantity;
use crate::twin::{Accepted, Command, EstimateDecision, Refusal, RefusalCode, ResidualMeasurement};

use super::qos;

impl ros2_client::Message for ConfirmEstimateRequest {}
impl ros2_client::Message for ConfirmEstimateResponse {}
impl ros2_client::Message for CalibrateRequest {}
impl ros2_client::Message for CalibrateResponse {}

/// Checks that a request to a single twin is for its column.
pub(super) fn check_column(own: &str, wanted: &str) -> Result<(), Refusal> {
    if wanted.is_empty() || wanted == own {
        return Ok(());
    }
    let reason =
        format!("the request is for column {wanted:?}, but this is the twin of column {own:?}");
    Err(Refusal::new(RefusalCode::OtherColumn, reason))
}

/// Passes a decision about an estimate to a twin.
pub(super) fn confirm_estimate(
    request: ConfirmEstimateRequest,
    execute: impl FnOnce(Command) -> Result<Accepted, Refusal>,
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
        Err(refusal) => not_decided(&refusal),
    }
}

/// The answer to a decision that was not taken.
pub(super) fn not_decided(refusal: &Refusal) -> ConfirmEstimateResponse {
    ConfirmEstimateResponse {
        success: false,
        refusal_code: refusal.code.number(),
        message: refusal.reason.to_string(),
    }
}

/// Passes a measurement on the column at rest to a twin.
pub(super) fn calibrate(
    request: &CalibrateRequest,
    execute: impl FnOnce(Command) -> Result<Accepted, Refusal>,
) -> CalibrateResponse {
    let quantity = match request.quantity {
        CalibrateRequest::DISPLACEMENT => Quantity::Displacement,
        CalibrateRequest::ROTATION => Quantity::Rotation,
        other => {
            let reason = format!("quantity = {other}: expected 0 (DISPLACEMENT) or 1 (ROTATION)");
            let code = RefusalCode::MeasurementImplausible;
            return not_calibrated(&Refusal::new(code, reason));
        }
    };
    let outcome = execute(Command::Calibrate(ResidualMeasurement {
        quantity,
        height: request.height,
        value: request.value,
        deviation: request.deviation,
        source: format!("service {}", qos::CALIBRATE.name).into(),
    }));
    match outcome {
        Ok(Accepted::Calibrated(it)) => CalibrateResponse {
            success: true,
            refusal_code: 0,
            message: it.in_words(),
            before: it.before,
            after: it.after,
            factor: it.factor,
        },
        Ok(_) => not_calibrated(&Refusal::new(
            RefusalCode::NoAnswer,
            "the twin has answered another command",
        )),
        Err(refusal) => not_calibrated(&refusal),
    }
}

/// The answer to a measurement that was not taken.
pub(super) fn not_calibrated(refusal: &Refusal) -> CalibrateResponse {
    CalibrateResponse {
        success: false,
        refusal_code: refusal.code.number(),
        message: refusal.reason.to_string(),
        before: f64::NAN,
        after: f64::NAN,
        factor: f64::NAN,
    }
}
