#![doc = include_str!("../README.md")]
#![expect(
    clippy::needless_range_loop,
    reason = "indices number degrees of freedom, which several matrices share"
)]

mod beam;
mod column;
mod contact;
mod damage;
mod element;
mod energy;
mod mesh;
mod newton;
mod opinion;
mod parts;
mod rate;
mod response;
mod section;
mod statics;
mod torsion;
mod tridiagonal;
mod web;

pub use column::{BeamColumn, BeamError, BowAxes, Torsion};
pub use damage::{Damage, DamageError};
pub use opinion::{BeamModel, BeamOutcome, Hit, Outcome};
pub use section::{Shape, Steel};
