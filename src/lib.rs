//! Digital twin of a steel column hit by a vehicle.
//!
//! ```
//! use column_twin::column::{Impact, simulate};
//! use column_twin::parameters::Parameters;
//!
//! // The default column: HEB 220 in S355.
//! let column = Parameters::default().column_properties();
//! let car = Impact::rigid(1500.0, 10.0);
//! let report = simulate(&column, &car, 2.0, &mut |_| {})?;
//! assert!(report.max_v1 > 0.1 && report.residual_v1.is_some());
//! # Ok::<(), column_twin::column::SimulationError>(())
//! ```
//!
//! The mechanics is in [`mod@column`], the parameters of a column are in [`parameters`], the twin with the damage of all
//! its impacts is in [`twin`], and the solver's thread in `live`. `ARCHITECTURE.md` describes all modules.

pub use column_mechanics as column;

pub mod assessment;
pub mod bounded_file;
pub mod endpoints;
#[cfg(feature = "record")]
pub mod evidence;
mod exact_number;
#[cfg(feature = "cli")]
pub mod figures;
pub mod fleet;
mod hexadecimal;
#[cfg(any(feature = "ros", feature = "record"))]
pub mod incoming;
#[cfg(feature = "security")]
pub mod keystore;
#[cfg(feature = "live")]
pub mod live;
pub mod messages;
#[cfg(feature = "study")]
mod numerics;
pub mod outgoing;
pub mod parameters;
pub mod printable;
#[cfg(feature = "record")]
pub mod recording;
#[cfg(feature = "cli")]
pub mod report;
pub mod results;
#[cfg(feature = "ros")]
pub mod ros;
pub mod senses;
pub mod sensors;
pub mod shape;
pub mod standing;
pub mod study;
pub mod time;
pub mod twin;
#[cfg(feature = "viewer")]
pub mod viewer;
#[cfg(any(feature = "cli", feature = "record"))]
pub mod whole_file;
