//! Shows an engineer the deformed column, the vehicle, where the column yields and how far it is from failure, in the Rerun
//! viewer (feature `viewer`).
//!
//! [`ViewerItem`]s are what can be shown; they come from a running twin, a simulation or a recording. A [`ViewerStream`]
//! writes them to a Rerun stream: the scene ([`Drawing`], plain numbers), the curves ([`plots`]), the log and the blueprint.
//! [`write_rrd`] writes them to a file, [`serve`] shows them to viewers that connect, and [`LiveViewer`] shows a running twin
//! from a thread of its own, at the destination that `viewer.mode` selects. A [`FleetStream`] shows the plan of a fleet, and some
//! of its columns in full.
//!
//! Nothing flows back: a viewer that is slow, stopped or gone loses frames, which are counted, and never delays the solver.
//! The code guards against these properties of Rerun 0.36.3: a client without a viewer buffers data and then blocks for
//! ever, also in its destructor; it never reconnects; a server on a port in use fails silently; by default it listens on
//! every interface.

mod blueprint;
mod branch;
mod camera;
mod colour;
mod connection;
mod curve_styles;
mod curves;
mod damage_map;
mod destination;
mod detected;
mod detected_views;
mod error;
mod events;
mod file;
mod fleet;
mod force_crush;
mod frame_budget;
mod frames;
mod item;
mod labels;
mod live_viewer;
#[cfg(feature = "study")]
mod map_blueprint;
mod panel;
mod picture;
pub mod plots;
mod point;
mod recorded_message;
mod rerun_types;
mod scene;
mod server;
mod spawned;
mod static_scene;
mod stream;
mod timeline;

pub use blueprint::APPLICATION;
pub use camera::{Camera, VIEW};
pub use damage_map::write_map_rrd;
pub use detected::{DetectedImpacts, DetectedUpdate, SensorCourse};
pub use error::{RERUN_VERSION, ViewerError, ViewerLogger};
pub use events::{Event, EventDetector, summary};
pub use file::{from_samples, write_rrd};
pub use fleet::{ColumnMark, Fact, FleetFeed, FleetItem, FleetStream, ShownFleet};
pub use frame_budget::FrameBudget;
pub use item::{Announcement, ViewerItem};
pub use labels::Label;
pub use live_viewer::{LiveViewer, VIEWER_QUEUE, VIEWER_THREAD, fleet_output_queue, output_queue};
pub use panel::{PANEL, Told, panel};
pub use recorded_message::{RecordedMessage, from_messages};
pub use scene::{BoxMark, Drawing, FULL_ARC, ForceArrow, HingeMark, Scene, VehicleMark};
pub use server::{Served, serve};
pub use stream::{StreamOptions, ViewerStream};
pub use timeline::{IMPACT_TIME, Moment, Placed, STEP, Timeline, WALL_CLOCK};
