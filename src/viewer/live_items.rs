//! The items of a column of a running twin that is shown in full: its outputs, and beside its estimates its newest measurements.

use std::sync::Arc;

use super::detected::DetectedImpacts;
use super::item::ViewerItem;
use crate::live::FleetMeasurements;
use crate::parameters::Parameters;
use crate::twin::Output;

/// Makes items of what a column gives out.
#[derive(Debug)]
pub(super) struct LiveItems {
    column: u32,
    detected: DetectedImpacts,
    /// `None`: without sensors, or their measurements are not known.
    measurements: Option<FleetMeasurements>,
}

impl LiveItems {
    /// For the column with this index, which has these parameters.
    pub fn new(
        column: u32,
        parameters: Arc<Parameters>,
        measurements: Option<FleetMeasurements>,
    ) -> Self {
        Self {
            column,
            detected: DetectedImpacts::new(parameters),
            measurements,
        }
    }

    /// What an output of the column shows; `None` if nothing.
    pub fn of_output(&mut self, output: Output) -> Option<ViewerItem> {
        if let Output::ParametersChanged(it) = &output {
            self.detected.change(Arc::clone(&it.parameters));
        }
        let Output::Estimate(estimate) = &output else {
            return ViewerItem::of_twin(output);
        };
        let measured = |from, until| match &self.measurements {
            Some(it) => it.recent(self.column, from, until),
            None => Vec::new(),
        };
        let update = self.detected.of_twin(estimate, measured);
        Some(ViewerItem::Detected(Box::new(update)))
    }
}
