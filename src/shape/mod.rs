//! The geometry that everything that draws the column shares: its joints, the outline of its section, the solid that this
//! outline sweeps along the bent axis, the yield surface of its hinges, and the vehicle that hits it.
//!
//! The frame has its origin at the base, `z` up, `x` along the web and `y` along the flanges: the two bars bend in the plane of
//! `x` and `z`, about the strong axis of the section, towards `x` where the vehicle travels there. [`Heading`] is the direction in
//! which a vehicle travels. All lengths in \[m\].
//!
//! Drawings agree with the model: both bars are straight, and the axis of the solid passes through base, impact point and
//! top. Only a short part of each bar next to a joint is bent ([`BEND_LENGTH`]), so that a plastic hinge looks like one and
//! not like a broken stick.

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - action_colour.rs: The colours of the actions, in figures and in the viewer
// - bent_axis.rs: The axis of the deformed column: two straight bars with a short smooth bend at each joint
// - heading.rs: The direction in which a vehicle travels, seen from the column
// - joints.rs: The ends of the two bars
// - outline.rs: The outline of the section
// - round_number.rs: Round numbers for scales and axes
// - solid.rs: The solid that a section sweeps along the bent axis
// - vehicle.rs: The vehicle as it is drawn: a body of its real size whose nose shortens as its front crushes
// - yield_curve.rs: The yield surface as a curve

mod action_colour;
mod bent_axis;
mod heading;
mod joints;
mod outline;
mod round_number;
mod solid;
mod vehicle;
mod yield_curve;

pub use crate::twin::Lengths;
pub use action_colour::action_colour;
pub use bent_axis::{BEND_LENGTH, BentAxis, Station};
pub use heading::Heading;
pub use joints::{Joints, PlanePoint};
pub use outline::{Outline, Ring};
pub use round_number::round_number;
pub use solid::Solid;
pub use vehicle::{CrushedVehicle, Hull, VehicleBody, Wheel, hull_triangles};
pub use yield_curve::yield_curve;
