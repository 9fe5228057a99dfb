//! What the arrays about hinges, webs and masses consist of. They are stored in place.

use ros_interface::BoundedSequence;

use crate::column::MAX_MASSES;

/// Most hinges, and most webs, that a message has room for: those of a column of eight bars.
pub const MAX_HINGES: usize = 16;

/// One value for each hinge, or for each web, in the order of [`HingeDescription`](super::column_twin_msgs::HingeDescription) in `TwinStatus`.
pub type PerHinge<T = f64> = BoundedSequence<T, MAX_HINGES>;

/// One value for each mass of a deformable vehicle, or for the spring in front of it, front first.
pub type PerMass = BoundedSequence<f64, MAX_MASSES>;
