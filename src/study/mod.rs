//! Studies: many impacts on a column, computed on all processors.
//!
//! [`StudyColumn`] is a column that is prepared once for many impacts; [`StudyColumn::evaluate`] follows one impact and
//! reduces it to the numbers that a study compares, a [`Evaluation`]. [`Batch`] spreads any number of them over the
//! processors, in an order that does not depend on how many there are, and can be interrupted. [`DamageMap`] is the plane of
//! two quantities, [`DamageMap::refine`] finds the boundaries of its classes alone, [`CriticalSearch`] how fast a vehicle may
//! be, [`vehicle_limits`] the same for every vehicle of the catalogue. Without the feature `study`, which takes all processors,
//! there are only the last two and the column.
//!
//! ```
//! use column_twin::parameters::Parameters;
//! use column_twin::study::StudyColumn;
//!
//! let column = StudyColumn::undamaged(&Parameters::default())?;
//! let impact = column.impact(Some("mid_car"), None, 10.0)?;
//! let evaluation = column.evaluate(&impact)?;
//! assert!(evaluation.max_v1 > 0.0);
//! # Ok::<(), column_twin::study::StudyError>(())
//! ```

#[cfg(feature = "study")]
mod axis;
#[cfg(feature = "study")]
mod batch;
mod critical;
#[cfg(feature = "study")]
mod fleet_kinds;
#[cfg(feature = "study")]
mod map;
#[cfg(feature = "study")]
mod map_bands;
#[cfg(all(test, feature = "study"))]
mod map_bands_tests;
#[cfg(feature = "study")]
mod map_columns;
#[cfg(feature = "study")]
mod map_grid;
#[cfg(feature = "study")]
mod refine;
#[cfg(feature = "study")]
pub mod risk;
#[cfg(feature = "study")]
mod row_search;
mod study_column;
#[cfg(feature = "study")]
mod threads;
mod vehicle_limits;

#[cfg(feature = "study")]
pub use axis::{AxisError, AxisProblem, AxisValue, AxisValues, MAX_CELLS, MapAxis, MapQuantity};
#[cfg(feature = "study")]
pub use batch::{Batch, BatchEnd};
pub use critical::{
    ACTIONS, CRITICAL_TOLERANCE, CriticalSearch, CriticalVelocities, CriticalVelocity,
};
#[cfg(feature = "study")]
pub use fleet_kinds::{FleetKinds, part_of};
#[cfg(feature = "study")]
pub use map::{CellPlace, DamageMap, MapCell, MapError, MapTable, Variant};
#[cfg(feature = "study")]
pub use map_bands::{BandPoint, BoundaryBand, MapBands};
#[cfg(feature = "study")]
pub use map_columns::{ColumnKind, TableColumn, TableValue};
#[cfg(feature = "study")]
pub use map_grid::{GridCell, MapGrid};
#[cfg(feature = "study")]
pub use refine::{BoundaryPoint, ClassBoundary, LimitBoundary, RefinedMap, RowFault};
#[cfg(feature = "study")]
pub use row_search::{Limit, RefineError, RowBoundary};
pub use study_column::{Evaluation, Glance, StudyColumn, StudyError, VehicleImpacts};
#[cfg(feature = "study")]
pub use threads::{MAX_THREADS_PER_PROCESSOR, Threads};
pub use vehicle_limits::{LIMIT_VELOCITIES, VehicleLimits, vehicle_limits, vehicle_limits_on};
