//! Tests of the viewer: what it is shown, and that it has no effect on the twin.
#![cfg(feature = "viewer")]
// A test may listen without a bound: it ends with the test.
#![allow(clippy::disallowed_methods)]

mod beam;
mod detected;
mod direction;
#[cfg(all(feature = "cli", feature = "ros"))]
#[path = "../ros/domain.rs"]
mod domain;
mod fleet;
mod in_memory;
mod live;
#[path = "../../examples/viewer_moments.rs"]
mod moments;
#[cfg(all(feature = "cli", feature = "ros"))]
#[allow(dead_code)] // the tests of the node use more of it
#[path = "../ros/program.rs"]
mod program;
mod real_viewer;
mod recordings;
mod twin;
mod wheel;
