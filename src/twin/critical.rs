//! The critical velocities of the column at rest: how fast each vehicle may hit it next. The twin tells what is to be computed
//! and keeps the result; another thread computes it.

use std::sync::Arc;

use super::plant::Plant;
use crate::assessment::Action;
use crate::column::ColumnProperties;
use crate::parameters::Parameters;
use crate::standing::{is_same_height, with_impact_height};
use crate::study::{StudyColumn, VehicleLimits, vehicle_limits_on};

/// All on which the critical velocities of the column at rest depend, as plain data for another thread.
#[derive(Debug, Clone, PartialEq)]
pub struct CriticalVelocityTask {
    pub(super) parameters: Arc<Parameters>,
    pub(super) at_rest: Plant,
    pub(super) action: Action,
}

impl CriticalVelocityTask {
    /// Computes the critical velocities, see [`vehicle_limits_on`]; `go_on` is asked before each response, and `None` is the
    /// result once it returns false. Where the hinges at the impact point are not damaged, each vehicle strikes where it does if
    /// the column is given by its height, otherwise at the height of the parameters; hinges that are damaged take all impacts.
    /// Empty for a column that cannot be computed.
    pub fn compute(&self, go_on: &mut dyn FnMut() -> bool) -> Option<Arc<[VehicleLimits]>> {
        let properties = self.parameters.column_properties();
        let struck_at = |properties: &ColumnProperties| {
            let moved = self.at_rest.with_hinges_at_impact(properties);
            let (model, rest) = moved.unwrap_or((self.at_rest.model, self.at_rest.state));
            StudyColumn::at_rest(&self.parameters, model, rest)
        };
        let Ok(column) = struck_at(&properties) else {
            return Some(Arc::default());
        };
        // By height; the catalogue has few.
        let mut others: Vec<(f64, Arc<StudyColumn>)> = Vec::new();
        let mut elsewhere = |vehicle: &str| {
            let height = self.parameters.impact_height_of(vehicle)?;
            if is_same_height(height, properties.length_below) {
                return None;
            }
            let known = others.iter().find(|(known, _)| *known == height);
            if let Some((_, known)) = known {
                return Some(Arc::clone(known));
            }
            let there = struck_at(&with_impact_height(&properties, height)).ok()?;
            let there = Arc::new(there);
            others.push((height, Arc::clone(&there)));
            Some(there)
        };
        vehicle_limits_on(&column, &mut elsewhere, self.action, go_on).map(Arc::from)
    }

    /// Whether impacts have left damage on the column.
    #[must_use]
    pub fn is_damaged(&self) -> bool {
        self.at_rest.is_damaged()
    }

    /// Whether the result is that of another task: the columns differ by their names only.
    #[must_use]
    pub fn has_the_result_of(&self, other: &Self) -> bool {
        self.at_rest == other.at_rest
            && self.action == other.action
            && self.parameters.differs_by_names_only(&other.parameters)
    }
}

/// Critical velocities, and the column to which they belong.
#[derive(Debug)]
pub(super) struct KnownCriticalVelocities {
    pub task: CriticalVelocityTask,
    pub vehicles: Arc<[VehicleLimits]>,
}
