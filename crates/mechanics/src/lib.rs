//! The mechanics of a steel column under impact, after Heng, Hjiaj and Battini, "A simplified model of a steel column
//! subjected to impact". Equation numbers are the paper's; `docs/theory.md` derives what differs.
//!
//! Two rigid bars, a below the impact point and b above it; four generalised elasto-plastic hinges: 3 at the base, 1a and
//! 1b at the impact point (one in each bar), 2 at the top; a spring, a mass and a constant load on the top.
//!
//! | symbol | meaning | unit | where |
//! |---|---|---|---|
//! | `U = (v1, u1, beta1, u2)` | displacements (Eq 1) | m, m, rad, m | `geometry.rs` |
//! | `E`, `B` | deformations and their derivatives (Eqs 3-10) | m, rad | `geometry.rs`, `assembly.rs` |
//! | `S`, `f_int = B' S` | forces of the bars, forces on `U` (Eqs 12, 16) | N, N m | `bar.rs`, `assembly.rs` |
//! | `Phi(M, N)` | yield function (Eqs 26-29) | - | `yield_surface.rs` |
//! | `g`, `Lambda_N`, `epsilon` | gap, percussion, restitution (Eqs 33-38) | m, N s, - | `contact.rs` |
//! | Eqs 40, 44-46 | the paper's time stepping, and its energy-conserving sibling | | `midpoint.rs`, `energy.rs` |
//!
//! A step: `stepping.rs` cuts it into parts, a scheme states the equations of a part, `newton.rs` solves them, `bar.rs`
//! returns the stresses to the yield surface. `response.rs` follows one impact to its end.
//!
//! Deliberately absent: files, clocks, threads, logging, allocation per step, and any knowledge of the rest of the crate.
//! Same input, same bits.

mod bar;
mod conserving_midpoint;
mod contact;
mod frame;
mod geometry;
mod impact;
mod ledger;
mod midpoint;
mod model;
mod modes;
mod motion;
mod newton;
mod properties;
mod report;
mod response;
mod sample;
mod section;
mod state;
mod statics;
mod stepping;
mod yield_surface;

pub use bar::{Bar, BarForces, PerBar, PlasticFlow};
pub use conserving_midpoint::MAX_EVENTS_PER_STEP;
pub use contact::{Impactor, PERSISTENT_CONTACT_FRACTION};
pub use frame::Frame;
pub use geometry::Displacement;
pub use impact::{Impact, ImpactError, ImpactSpecification};
pub use ledger::{Energies, Ledger};
pub use model::{Model, ModelError, RestState};
pub use motion::{Collapse, LENGTH_RANGE, MAX_SHORTENING, MIN_EXTENT, StepError};
pub use properties::{ColumnProperties, ElasticLaw, Scheme, Support, YieldExponents};
pub use report::{End, HingeReport, Outcome, Report};
pub use response::{Progress, Response, SimulationError, respond, simulate};
pub use sample::{HINGE_NAMES, HINGES, HingeSample, HingeState, Phase, Sample};
pub use section::{RolledSection, STEEL_DENSITY, SectionProperties};
pub use state::{State, Velocity};
pub use statics::residual_state;
pub use stepping::{MAX_HALVINGS, MAX_PARTS, begin_impact, step};
pub use yield_surface::YieldSurface;
