//! Studies: many impacts on a column, computed on all processors.
//!
//! [`StudyColumn`] is a column that is prepared once for many impacts; [`StudyColumn::screen`] follows one impact and
//! reduces it to the numbers that a study compares, a [`Screening`]. [`Batch`] spreads any number of them over the
//! processors, in an order that does not depend on how many there are, and can be interrupted. [`DamageMap`] is the plane of
//! two quantities, [`DamageMap::refine`] finds the boundaries of its classes alone, [`CriticalSearch`] how fast a vehicle may be.
//!
//! ```
//! use column_twin::parameters::Parameters;
//! use column_twin::study::StudyColumn;
//!
//! let column = StudyColumn::virgin(&Parameters::default())?;
//! let impact = column.impact(Some("mid_car"), None, 10.0)?;
//! let screening = column.screen(&impact)?;
//! assert!(screening.max_v1 > 0.0);
//! # Ok::<(), column_twin::study::StudyError>(())
//! ```

mod axis;
mod batch;
mod critical;
mod map;
mod map_columns;
mod map_grid;
mod refine;
pub mod risk;
mod row_search;
mod study_column;

pub use axis::{AxisError, AxisProblem, AxisValue, AxisValues, MAX_CELLS, MapAxis, Quantity};
pub use batch::{Batch, BatchEnd};
pub use critical::{
    CRITICAL_TOLERANCE, CriticalSearch, CriticalVelocities, CriticalVelocity, SEVERITIES,
};
pub use map::{CellPlace, DamageMap, MapCell, MapError, MapTable, Variant};
pub use map_columns::{ColumnKind, TableColumn, TableValue, severity_name};
pub use map_grid::{GridCell, MapGrid};
pub use refine::{BoundaryPoint, ClassBoundary, RefinedMap};
pub use row_search::{RefineError, RowBoundary};
pub use study_column::{Screening, StudyColumn, StudyError};
