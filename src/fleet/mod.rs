//! What a fleet of columns is made of without ROS: its status, gathered for few messages, its table for
//! people, its plan for pictures, vehicles that hit several columns, and which columns have topics of their own.
//!
//! The parameters of its columns come from [`FleetColumns`](crate::parameters::FleetColumns), and
//! `LiveFleet` of the module `live` runs them. Here nothing reads a clock: time is passed in.

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
