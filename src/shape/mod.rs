//! The shape of the deformed column, for everything that draws it: where its joints are, the outline of its section, and
//! the solid that this outline sweeps along the bent axis.
//!
//! The frame has its origin at the base, `z` up, `x` in the vehicle's direction of travel and `y` along the flanges: the
//! column bends in the plane of `x` and `z`, about the strong axis of its section. All lengths in \[m\].
//!
//! What is drawn to scale is drawn where the model says: both bars are straight, and the solid's axis passes through base,
//! impact point and top. Only a short part of each bar next to a joint is bent ([`BEND_LENGTH`]), so that a plastic hinge
//! looks like one and not like a broken stick.

mod axis;
mod joints;
mod outline;
mod solid;

pub use axis::{Axis, BEND_LENGTH, Station};
pub use joints::{Joints, PlanePoint};

pub use crate::twin::Lengths;
pub use outline::{Outline, drawn_section};
pub use solid::Solid;
