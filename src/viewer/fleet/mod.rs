//! A fleet in the viewer: the plan of all columns, coloured by action, and in full the columns that are selected and the one that
//! was hit last.
//!
//! [`FleetFeed`] turns what columns give out into [`FleetItem`]s, of which there are few: a column at rest has none. A [`FleetStream`]
//! writes them to a Rerun stream, all columns of the plan as one batch of points.

mod feed;
mod item;
mod layout;
mod overview;
mod panel;
mod place_labels;
mod stream;

pub use feed::{Fact, FleetFeed};
pub use item::{ColumnMark, FleetItem, ShownFleet};
pub use stream::FleetStream;
