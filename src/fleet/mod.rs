//! What a fleet of columns is made of without ROS: its status, gathered for few messages, its table for
//! people, its plan for pictures, vehicles that hit several columns, and which columns have topics of their own.
//!
//! The parameters of its columns come from [`FleetColumns`](crate::parameters::FleetColumns), and
//! `LiveFleet` of the module `live` runs them. Here nothing reads a clock: time is passed in.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - demand.rs: Which columns have topics of their own, because somebody listens there
// - plan.rs: Where the columns of a fleet stand in plan, for pictures
// - row.rs: One vehicle that hits several columns one after another: which impacts follow from its event, when each is due, and
//   what is left of the vehicle behind a column that gives way
// - start.rs: The twins of a fleet at its start
// - status.rs: Gathers the statuses of the columns of a fleet for few messages: what has changed, and all of them now and then
// - table.rs: A fleet as a table that fits a terminal: the worst columns first

mod demand;
mod plan;
mod row;
mod start;
mod status;
mod table;

pub use demand::{Demand, DemandChange, LINGER, MAX_ENDPOINTS_PER_SECOND, MAX_OPEN_COLUMNS};
pub use plan::Plan;
pub use row::{
    LeftOver, MAX_ROW_COLUMNS, MAX_ROW_DISTANCE, MAX_ROW_OFFSET, MAX_ROWS, NotHit, RowImpact, Rows,
};
pub use start::{FleetStartError, make_twins};
pub use status::{
    MAX_STATUSES_PER_MESSAGE, ROUND_PERIOD, STATUS_SPACING, StatusBatch, StatusBoard,
};
pub use table::{TableSize, table};
