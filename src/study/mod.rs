//! Studies: many impacts on a column, computed on all processors.
//!
//! [`StudyColumn`] is a column that is prepared once for many impacts; [`StudyColumn::evaluate`] follows one impact and
//! reduces it to the numbers that a study compares, a [`Evaluation`]. [`Batch`] spreads any number of them over the
//! processors, in an order that does not depend on how many there are, and can be interrupted. [`DamageMap`] is the plane of
//! two quantities, [`DamageMap::refine`] finds the boundaries of its classes alone, [`CriticalSearch`] how fast a vehicle may
//! be, [`vehicle_limits`] the same for every vehicle of the catalogue.
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

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - axis.rs: The axes of a damage map: what varies, and through which values
// - axis_problem.rs: Why a text does not describe an axis of a map
// - batch.rs: Many independent computations on all processors
// - critical.rs: Critical velocities: how fast a vehicle may be before its impact has a given action
// - fleet_kinds.rs: The kinds of columns of a fleet: columns that differ by their names only are computed once
// - map.rs: Damage maps: what an impact leads to, over a plane of two quantities
// - map_bands.rs: The bands of the boundaries between actions: between which values each of them lies if what is not known
//   exactly of the impact and of the column differs
// - map_columns.rs: The columns of a map in files: one table of names, units and values for every format
// - map_error.rs: Why there is no map
// - map_grid.rs: The cells of a map as pictures need them, in a bounded memory
// - map_variants.rs: The columns of a map: one for each combination of the values of what its rows and columns do not show
// - refine.rs: The boundaries of the action classes of a map, computed only where the classes change
// - risk/: Risk: how often does a vehicle damage the column, and how severely?
// - row_search.rs: The search for the boundaries of the classes in one row of a map
// - study_column.rs: A column that is prepared once for many impacts, and what one impact on it leads to
// - threads.rs: How many threads compute independent results
// - vehicle_limits.rs: How fast each vehicle may hit a column next
// - verdict_model.rs: By which model a study judges an impact, and what the fibre beam says of it

mod axis;
mod axis_problem;
mod batch;
mod critical;
mod fleet_kinds;
mod map;
mod map_bands;
#[cfg(test)]
mod map_bands_tests;
mod map_columns;
mod map_error;
mod map_grid;
mod map_variants;
mod refine;
pub mod risk;
mod row_search;
mod study_column;
mod threads;
mod vehicle_limits;
mod verdict_model;

pub use axis::{AxisValue, AxisValues, MapAxis, MapQuantity};
pub use axis_problem::{AxisError, AxisProblem, MAX_CELLS};
pub use batch::{Batch, BatchEnd};
pub use critical::{
    ACTIONS, CRITICAL_TOLERANCE, CriticalSearch, CriticalVelocities, CriticalVelocity,
};
pub use fleet_kinds::{FleetKinds, part_of};
pub use map::{CellPlace, DamageMap, MapCell, MapTable};
pub use map_bands::{BandPoint, BoundaryBand, MapBands};
pub use map_columns::{ColumnKind, TableColumn, TableValue};
pub use map_error::{MAX_VARIANTS, MapError};
pub use map_grid::{GridCell, MapGrid};
pub use map_variants::{Variant, arranged_axes};
pub use refine::{BoundaryPoint, ClassBoundary, LimitBoundary, RefinedMap, RowFault};
pub use row_search::{Limit, RefineError, RowBoundary};
pub use study_column::{Evaluation, Glance, StudyColumn, StudyError, VehicleImpacts};
pub use threads::{MAX_THREADS_PER_PROCESSOR, Threads};
pub use vehicle_limits::{LIMIT_VELOCITIES, VehicleLimits, vehicle_limits, vehicle_limits_on};
pub use verdict_model::{BeamSwitchedOff, StudyOpinion, VerdictModel};
