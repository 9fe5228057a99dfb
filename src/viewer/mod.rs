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
//! every interface; it answers to any host name.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - beam.rs: The fibre beam in front of the two bars in a Rerun stream: its axis at its peak and at rest, and the fibres that
//   have yielded
// - blueprint.rs: The layout of the viewer, for a laptop screen: column, panel and log on the left, curves in the middle, yield
//   surfaces on the right
// - branch.rs: A part of the tree of entities of a Rerun stream: that of one column
// - camera.rs: Where the scene is looked at from, so that the column, the whole vehicle and all labels are in the picture
// - colour.rs: Colours, one for each meaning, in the scene and in the plots
// - connection.rs: A connection to a running viewer, which may stop, end and come back
// - curve_styles.rs: How the curves look
// - curves.rs: The curves of an impact in a Rerun stream: one column of data per entity for a batch of states
// - damage_map.rs: A damage map in the viewer: an image of its classes with one pixel per cell, the boundaries, the axes and a
//   legend
// - destination.rs: The destination of the frames of a running twin, selected by `viewer.mode`
// - detected.rs: What the sensors say about an impact, and what they have read beside what was predicted, as the viewer shows
//   it
// - detected_views.rs: The curves about an impact that the sensors detect: forecast, momentum and action over the time of the
//   data, and each sensor
// - drawn_vehicle.rs: The vehicle in the scene, where it comes from: its parts and its label
// - error.rs: What the viewer reports to the program that runs it: errors and log lines
// - events.rs: The events of an impact with their times: from a report if there is one, otherwise from the states
// - file.rs: A file for the viewer, from a simulation or a recording
// - fleet/: A fleet in the viewer: the plan of all columns, coloured by action, and in full the columns that are selected and
//   the one that was hit last
// - force_crush.rs: The springs of the vehicle in a diagram of force over crush: their envelopes, paths and present positions
// - frame_budget.rs: How many frames of the scene are drawn
// - frames.rs: Frames of the scene in a Rerun stream: the column, its hinges, its top and the vehicle
// - guard.rs: Keeps web pages away from the server for viewers, which belongs to Rerun and answers to any host name (DNS
//   rebinding)
// - item.rs: The items that are shown in the viewer; they come from a running twin, a simulation or a recording
// - labels.rs: Labels that do not cover one another
// - live_items.rs: The items of a column of a running twin that is shown in full: its outputs, and beside its estimates its
//   newest measurements
// - live_viewer.rs: The viewer of a running twin: a thread of its own that reads a queue of its own
// - map_blueprint.rs: The layout of damage maps in the viewer: the image of each variant with its boundaries and axes, and
//   beside it what they mean
// - panel.rs: The panel beside the scene, as Markdown: what the impact does to the column, what hits it, and what the colours
//   mean
// - picture.rs: What a stream shows: one column, or a fleet
// - plots.rs: The curves over time: their quantities, units and the ranges of their axes
// - point.rs: Points and vectors in space
// - recorded_message.rs: Converts the messages of a recording to items for the viewer
// - rerun_types.rs: Conversions to Rerun's own types
// - scene.rs: The visible scene of the column at one instant, as plain numbers without any type of Rerun
// - server.rs: A server for viewers on this machine
// - spawned.rs: A viewer process that this program starts
// - static_scene.rs: The parts of the scene that do not move: undeformed column, supports and yield surfaces
// - stream.rs: Writes items to a Rerun stream: static data once, states in batches with one column of data per entity
// - timeline.rs: The three timelines on which everything is shown

mod beam;
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
mod drawn_vehicle;
mod error;
mod events;
mod file;
mod fleet;
mod force_crush;
mod frame_budget;
mod frames;
mod guard;
mod item;
mod labels;
mod live_items;
mod live_viewer;
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

pub use beam::{AxisMark, BeamMark};
pub use blueprint::APPLICATION;
pub use camera::{Camera, VIEW};
pub use damage_map::write_map_rrd;
pub use detected::{DetectedImpacts, DetectedUpdate, SensorCourse};
pub use error::{RERUN_VERSION, ViewerError, ViewerLogger};
pub use events::{Event, EventDetector, summary};
pub use file::{from_samples, write_rrd};
pub use fleet::{ColumnMark, FleetFeed, FleetItem, FleetStream, ShownFleet};
pub use frame_budget::FrameBudget;
pub use item::{Announcement, ViewerItem};
pub use labels::Label;
pub use live_viewer::{LiveViewer, Shown, VIEWER_QUEUE, VIEWER_THREAD, output_queue};
pub use panel::{PANEL, Told, panel};
pub use recorded_message::{RecordedMessage, from_messages};
pub use scene::{BoxMark, Drawing, FULL_ARC, ForceArrow, HingeMark, Scene, VehicleMark};
pub use server::{Served, serve};
pub use stream::{StreamOptions, ViewerStream};
pub use timeline::{IMPACT_TIME, Moment, Placed, STEP, Timeline, WALL_CLOCK};
