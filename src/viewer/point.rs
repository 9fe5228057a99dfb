//! Points and vectors in space.

/// A point or a vector in space \[m\].
pub type Point3 = [f32; 3];
