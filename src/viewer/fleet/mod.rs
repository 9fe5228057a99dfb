//! A fleet in the viewer: the plan of all columns, coloured by action, and in full the columns that are selected and the one that
//! was hit last.
//!
//! [`FleetFeed`] turns what columns give out into [`FleetItem`]s, of which there are few: a column at rest has none. A [`FleetStream`]
//! writes them to a Rerun stream, all columns of the plan as one batch of points.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - feed.rs: Decides what of a fleet is shown: the marks of all columns, and everything of those in full
// - item.rs: What can be shown of a fleet
// - layout.rs: The layout of a fleet in the viewer: on the left the plan with its legend, the columns that need somebody and
//   the log; on the right, in tabs, the column that was hit last and those that are selected
// - overview.rs: The plan of a fleet in a Rerun stream: all columns as one batch of points, and over it the few to which
//   something has happened
// - panel.rs: The panel below the plan, as Markdown: how many columns need somebody, and which ones first
// - place_labels.rs: Places the labels of a plan so that none covers another, or the mark of a column that has a label
// - stream.rs: Writes the items of a fleet to a Rerun stream

mod feed;
mod item;
mod layout;
mod overview;
mod panel;
mod place_labels;
mod stream;

pub use feed::FleetFeed;
pub use item::{ColumnMark, FleetItem, ShownFleet};
pub use stream::FleetStream;
