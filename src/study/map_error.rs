//! Why there is no map.

use super::axis_problem::{AxisError, MAX_CELLS};
use super::study_column::StudyError;
use super::verdict_model::{BeamSwitchedOff, VerdictModel};
use crate::parameters::ParameterFaults;

/// Most columns that are compared by their values: each has its own parameters in memory.
pub const MAX_VARIANTS: u64 = 10_000;

/// Why there is no map.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MapError {
    /// An axis.
    #[error(transparent)]
    Axis(#[from] AxisError),
    /// Too many cells.
    #[error(
        "{rows} x {columns} cells of {variants} columns are too many; a map has at most {MAX_CELLS} cells"
    )]
    TooManyCells {
        /// Number of variants.
        variants: usize,
        /// Number of rows.
        rows: u64,
        /// Number of columns.
        columns: u64,
    },
    /// Two axes of the same quantity, or of quantities of which one determines the other.
    #[error("two axes determine the same parameter: {0} and {1}; vary two that are independent")]
    SameQuantity(&'static str, &'static str),
    /// A comparison varies what an axis varies, too.
    #[error("{0} is compared and varies along an axis, too; do one of both")]
    ComparedAndVaried(&'static str),
    /// Each vehicle has its own mass.
    #[error(
        "mass is compared, and every vehicle along the axis has its own mass; make mass an axis, and compare vehicles"
    )]
    MassOfVehicles,
    /// Too few axes.
    #[error("a map has two axes or more; found {0}")]
    TooFewAxes(usize),
    /// Too many combinations of compared values.
    #[error(
        "the values of {0} make more than {MAX_VARIANTS} combinations, each of which is a column of its own; give fewer values, or \
         compute several maps"
    )]
    TooManyVariants(String),
    /// There is no variant.
    #[error("there is no column to compare")]
    NoVariant,
    /// Two variants have the same label.
    #[error(
        "two of the compared columns are called {0}; give each one a name of its own (column_id)"
    )]
    SameLabel(String),
    /// The damage belongs to the column as it is.
    #[error(
        "{0} cannot vary, because an impact has damaged the column, and its damage belongs to the column as it is; vary mass, velocity, \
         vehicle or direction, or map the undamaged column"
    )]
    DamagedColumnVaries(&'static str),
    /// The fibre beam judges no map of a damaged column.
    #[error(
        "the map of a damaged column is judged by the two bars alone; omit the model {}, or compute its impacts one by one",
        .0.name()
    )]
    DamagedByBeam(VerdictModel),
    /// A model that the parameters of a column switch off.
    #[error(transparent)]
    BeamSwitchedOff(#[from] BeamSwitchedOff),
    /// The parameters.
    #[error("{}", .0.in_one_line())]
    Parameters(#[from] ParameterFaults),
    /// A damaged column that cannot be prepared.
    #[error(transparent)]
    Column(#[from] StudyError),
}
