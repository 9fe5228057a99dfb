//! What a fleet of columns is made of without ROS: its status, gathered for few messages, and its table for people.
//!
//! The parameters of its columns come from [`FleetColumns`](crate::parameters::FleetColumns), and
//! [`LiveFleet`](crate::live::LiveFleet) runs them. Here nothing reads a clock: time is passed in.

mod start;
mod status;
mod table;

pub use start::{FleetStartError, make_twins};
pub use status::{
    MAX_STATUSES_PER_MESSAGE, ROUND_PERIOD, STATUS_SPACING, StatusBatch, StatusBoard,
};
pub use table::{TableSize, table};
