#![doc = include_str!("../README.md")]
#![expect(

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - assembly.rs: The stiffness of a trial increment, from what its evaluation has found of each element: only where a direction
//   is sought, because an increment that is in balance needs none
// - beam.rs: The beam: its nodes, its state, and the forces and stiffness of a trial increment
// - collapse.rs: The test of a collapse by displacement: whether the column finds an equilibrium under its load, wherever its
//   top is held
// - column.rs: A column as an engineer gives it, and the beam that is built from it
// - contact.rs: The vehicle: its face, stiff contact springs between the face and the nodes behind it, and what moves the face
// - correction.rs: Corrects the damage by what was measured on the column at rest: plastic strains and plastic shear angles are
//   multiplied by one factor, so that the shape remains that of the hits, and the column is brought into its new equilibrium
// - curve.rs: Steel: its stress over the plastic strain, in straight pieces
// - damage.rs: What an impact leaves in the column: as little as possible, so that a fleet can keep it
// - element.rs: The deformations of an element between two nodes, which turn and move by any amount
// - energy.rs: The energy of a beam
// - history.rs: What instruments on the beam read during an impact and after it: signals whose truth another model knows
// - mesh.rs: Where the nodes are: close together where the column yields, further apart between
// - modes.rs: Free vibrations of small amplitude in the plane of the web, of the straight column under its load
// - movement.rs: How the column moves during a hit, for those who draw it
// - newton.rs: Newton's method with a line search for a step in time or an increment of equilibrium
// - opinion.rs: The second opinion: an impact on a column, computed as a beam
// - outcome.rs: What the beam says of a hit, in numbers
// - pair.rs: Two independent parts of a computation; the caller decides whether they run in parallel
// - parts.rs: What a beam is made of: elements, their shear, and the springs of its supports
// - rate.rs: The growth of the yield strength with the strain rate of the outer fibre, which passes a low-pass filter
// - remains.rs: What a hit leaves of the column at rest, from where it is in the undamaged column
// - response.rs: One impact, from the touch to the peak displacement, and what remains after it
// - section.rs: The cross-section as fibres: their strains, stresses and plastic strains
// - statics.rs: Equilibrium: under the load before an impact, after it, and while the top is pushed down
// - torsion.rs: The torsional rigidity with which uniform torsion gives the twist that restrained warping leaves at the impact
//   point
// - tridiagonal.rs: Symmetric equations whose unknowns couple with those of the neighbouring node only
// - web.rs: The fibres of a sheared web, with `sigma^2 + 3 tau^2` in their yield condition, some at once

clippy::needless_range_loop,
    reason = "indices number degrees of freedom, which several matrices share"
)]

mod assembly;
mod beam;
mod collapse;
mod column;
mod contact;
mod correction;
mod curve;
mod damage;
mod element;
mod energy;
mod history;
mod mesh;
mod modes;
mod movement;
mod newton;
mod opinion;
mod outcome;
mod pair;
mod parts;
mod rate;
mod remains;
mod response;
mod section;
mod statics;
mod torsion;
mod tridiagonal;
mod web;

pub use column::{BeamColumn, BeamError, BowAxes, Torsion};
pub use correction::Measurement;
pub use curve::Steel;
pub use damage::{Damage, DamageError};
pub use history::{History, Instrument, Sampling, history};
pub use modes::{Mode, modes};
pub use movement::{Movement, YieldedFibre};
pub use opinion::{BeamModel, BeamOpinion, Hit, Undamaged, is_in_plane};
pub use outcome::{BeamOutcome, Outcome, PLASTIC_ZONE};
pub use pair::{InTurn, Pair, both};
pub use section::Shape;
pub use statics::CollapseTest;
