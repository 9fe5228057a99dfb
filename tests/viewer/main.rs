//! What a viewer is shown, and that the twin never knows of it.
#![cfg(feature = "viewer")]
// A test may listen without a bound: it ends with the test.
#![allow(clippy::disallowed_methods)]

mod live;
#[path = "../../examples/viewer_moments.rs"]
mod moments;
mod real_viewer;
mod recordings;
mod twin;
mod wheel;
