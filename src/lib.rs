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

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - assessment/: Assessment of a column after an impact: criteria with value, limit, margin, edition and tag, and one action
// - cli/: The command line
// - commissioning/: The check of the sensors when they are commissioned: readings of a column that vibrates from ambient
//   excitation or from a tap, against what the model says about frequencies, signs and amplitudes
// - endpoints.rs: All endpoints of the node with their quality of service, which never relies on the defaults of a library
// - estimation/: Sensors on the column: what they read, and what their readings say about an impact
// - evidence/: Recordings as evidence: what is recorded of the twin, and how a recording is verified by recomputation
// - exact_number.rs: Numbers in JSON that read back bit for bit, including numbers that are not finite
// - figures/: The figures of one impact: the paper's Figures 5 to 8, the shape of the column, the energy ledger, the contact
//   force and its equivalent static force, the crush of the vehicle, the path of every hinge in its yield surface, and the same
//   hit by the fibre beam, each as SVG and, rendered from the same SVG, as PNG
// - fleet/: What a fleet of columns is made of without ROS: its status, gathered for few messages, its table for people, its
//   plan for pictures, vehicles that hit several columns, and which columns have topics of their own
// - host_header.rs: The host that an HTTP request asks for
// - incoming.rs: Converts received messages to commands, and measurements to batches
// - keystore/: What the enclaves of twins, of monitors and of operators may do: keystores of the crate `sros2_keystore` for the
//   topics and services of this program
// - live/: One twin or many in real time: clocks, deadlines, bounded queues, a pool of solver threads
// - main.rs: The program `column-twin`
// - messages/: The messages that the twin exchanges with other programs, as Rust types
// - numerics/: Numerical methods that know nothing of columns and give the same bits on every processor
// - observables.rs: What can be observed of a column at an instant, and at which hinges and webs: one table of quantities and
//   one of places
// - outgoing/: Converts the outputs of the twin to messages
// - parameters/: Parameters: declaration, validation and documentation follow from one table
// - recording/: The crate `rosbag2_mcap` with the names, message definitions and parameters of this program
// - report/: The report for people: one HTML file about one impact, all impacts of a recording, or an impact that was estimated
//   from the readings of sensors, with everything inside it
// - results/: Results under the names that programs see, which are a stable interface: the JSON of the command line, and the
//   Python package
// - ros/: The ROS 2 node: the twin's interface over ros2-client and RustDDS
// - second_opinion/: The second opinion on an impact: the same hit on the same column, computed with the fibre beam of
//   `column_beam` beside the two bars
// - sensors/: A sensor as a thing on the column: what it measures, where, and how well
// - shape/: The geometry that everything that draws the column shares: its joints, the outline of its section, the solid that
//   this outline sweeps along the bent axis, the yield surface of its hinges, and the vehicle that hits it
// - standing/: A column at rest with its damage, as the next impact will find it
// - state_home.rs: Folders below the state folder of the user (XDG Base Directory Specification 0.8), as parameters name them
// - study/: Studies: many impacts on a column, computed on all processors
// - time.rs: Time as this program counts it
// - twin/: The digital twin of one column over its life, from impact to impact
// - viewer/: Shows an engineer the deformed column, the vehicle, where the column yields and how far it is from failure, in the
//   Rerun viewer (feature `viewer`)
// - whole_file.rs: A file that appears whole or not at all

pub use column_mechanics as column;

pub mod assessment;
pub mod commissioning;
pub mod endpoints;
pub mod estimation;
#[cfg(feature = "record")]
pub mod evidence;
mod exact_number;
#[cfg(feature = "cli")]
pub mod figures;
pub mod fleet;
#[cfg(any(feature = "ros", feature = "viewer"))]
mod host_header;
#[cfg(any(feature = "ros", feature = "record"))]
pub mod incoming;
#[cfg(feature = "security")]
pub mod keystore;
#[cfg(feature = "live")]
pub mod live;
pub mod messages;
mod numerics;
pub mod observables;
pub mod outgoing;
pub mod parameters;
#[cfg(feature = "record")]
pub mod recording;
#[cfg(feature = "cli")]
pub mod report;
pub mod results;
#[cfg(feature = "ros")]
pub mod ros;
pub mod second_opinion;
pub mod sensors;
pub mod shape;
pub mod standing;
pub mod state_home;
pub mod study;
pub mod time;
pub mod twin;
#[cfg(feature = "viewer")]
pub mod viewer;
#[cfg(any(feature = "cli", feature = "record"))]
pub mod whole_file;
