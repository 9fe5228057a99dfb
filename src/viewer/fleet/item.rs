//! What can be shown of a fleet.

use std::sync::Arc;

use crate::assessment::Action;
use crate::fleet::Plan;
use crate::messages::column_twin_msgs::TwinStatus;
use crate::parameters::{FleetColumn, Parameters};
use crate::twin::{NoticeLevel, Status, TwinPhase};
use crate::viewer::item::ViewerItem;

/// The columns of a fleet that is shown.
#[derive(Debug, Clone)]
pub struct ShownFleet {
    /// Their names, such as `/garage/a3`, which are the paths of their entities.
    pub names: Vec<String>,
    /// Their identifiers.
    pub ids: Vec<Arc<str>>,
    /// Their parameters.
    pub parameters: Vec<Arc<Parameters>>,
    /// Indices of those that are always shown in full.
    pub selected: Vec<u32>,
    /// Where they stand.
    pub plan: Plan,
}

impl ShownFleet {
    /// The columns of a fleet, of which those with the indices `selected` are always shown in full.
    #[must_use]
    pub fn new(columns: &[FleetColumn], selected: Vec<u32>) -> Self {
        let settings = || columns.iter().map(|it| it.parameters.settings());
        let places: Vec<_> = settings().map(|it| [it.site.x, it.site.y]).collect();
        Self {
            names: columns.iter().map(|it| it.name.clone()).collect(),
            ids: settings().map(|it| it.column_id.as_str().into()).collect(),
            parameters: columns
                .iter()
                .map(|it| Arc::clone(&it.parameters))
                .collect(),
            selected,
            plan: Plan::new(&places),
        }
    }

    /// The identifier of a column.
    #[must_use]
    pub fn id(&self, column: u32) -> &str {
        self.ids.get(column as usize).map_or("", |it| it)
    }
}

/// What the plan shows of a column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColumnMark {
    /// What has to be done about the column at rest; `None`: not known.
    pub action: Option<Action>,
    /// The action that the forecast of the response under way predicts.
    pub predicted: Option<Action>,
    /// Where the column and its twin are.
    pub phase: TwinPhase,
    /// Accepted impacts since the last reset.
    pub impacts: u32,
    /// `v1` of the column at rest \[m\].
    pub residual_v1: f64,
    /// Residual capacity over the load \[-\]; `None`: not known.
    pub reserve: Option<f64>,
}

impl Default for ColumnMark {
    /// A column of which nothing is known.
    fn default() -> Self {
        Self {
            action: None,
            predicted: None,
            phase: TwinPhase::Idle,
            impacts: 0,
            residual_v1: 0.0,
            reserve: None,
        }
    }
}

impl ColumnMark {
    /// The action that counts: of a column that responds the worse one of that at rest and that of the forecast.
    #[must_use]
    pub fn worst(&self) -> Option<Action> {
        self.action.max(self.predicted)
    }

    /// Whether an impact is under way.
    #[must_use]
    pub fn is_responding(&self) -> bool {
        matches!(
            self.phase,
            TwinPhase::Approach | TwinPhase::Contact | TwinPhase::Free
        )
    }

    /// Whether the column takes no impact before it is reset: it has collapsed, is fractured, or cannot be computed.
    #[must_use]
    pub fn is_out_of_service(&self) -> bool {
        matches!(
            self.phase,
            TwinPhase::Collapsed | TwinPhase::Fractured | TwinPhase::Faulted
        )
    }

    /// Whether somebody has to look at the column.
    #[must_use]
    pub fn is_notable(&self) -> bool {
        self.is_responding()
            || self.is_out_of_service()
            || self.worst().is_some_and(|it| it > Action::None)
    }
}

impl From<&Status> for ColumnMark {
    fn from(status: &Status) -> Self {
        let assessed = status.assessed.as_deref();
        Self {
            action: assessed.map(|it| it.assessment.action),
            predicted: None,
            phase: status.phase,
            impacts: status.impacts_since_reset,
            residual_v1: status.residual_v1,
            reserve: assessed.and_then(|it| it.remaining.reserve),
        }
    }
}

/// The action with this number in messages; `None`: not known.
#[must_use]
pub(super) fn action_of(code: u8) -> Option<Action> {
    match code {
        TwinStatus::ACTION_NONE => Some(Action::None),
        TwinStatus::ACTION_INSPECT => Some(Action::Inspect),
        TwinStatus::ACTION_RESTRICT => Some(Action::Restrict),
        TwinStatus::ACTION_SHORE => Some(Action::Shore),
        TwinStatus::ACTION_EVACUATE => Some(Action::Evacuate),
        _ => None,
    }
}

/// Something to show of a fleet. Columns are named by their indices.
#[derive(Debug, Clone)]
#[expect(
    clippy::large_enum_variant,
    reason = "nearly all are states, which should not be allocated one by one"
)]
pub enum FleetItem {
    /// What the plan shows of a column from now on.
    Mark {
        /// The column.
        column: u32,
        /// Time of the item \[ns since the epoch\].
        stamp: i64,
        /// What is shown.
        mark: ColumnMark,
    },
    /// This column was hit last: it is shown in full from here on, in the place of the one before.
    Newest {
        /// The column.
        column: u32,
        /// Its parameters.
        parameters: Arc<Parameters>,
    },
    /// Something of a column that is shown in full.
    Column(u32, ViewerItem),
    /// A line for the log of the fleet.
    Line {
        /// Time of the item \[ns since the epoch\].
        stamp: i64,
        /// Its level.
        level: NoticeLevel,
        /// Text, which names the column.
        text: String,
    },
}
