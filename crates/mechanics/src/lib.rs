#![doc = include_str!("../README.md")]
//!
//! ## Modules
//!
//! | symbol | meaning | unit | where |
//! |---|---|---|---|
//! | `U = (v1, u1, beta1, u2)` | displacements (Eq 1) | m, m, rad, m | `geometry.rs` |
//! | `E`, `B` | deformations and their derivatives (Eqs 3-10) | m, rad | `geometry.rs`, `frame.rs` |
//! | `S`, `f_int = B' S` | forces of the bars, forces on `U` (Eqs 12, 16) | N, N m | `bar.rs`, `frame.rs` |
//! | `Phi(M, N)` | yield function (Eqs 26-29) | - | `yield_surface.rs` |
//! | `D`, `H` | strain rate and hardening of a hinge | - | `rate.rs`, `strength.rs` |
//! | `V_s`, `gamma_p` | resistance and plastic shear angle of the web of a bar | N, rad | `shear.rs` |
//! | `g`, `Lambda_N`, `epsilon` | gap, impact impulse, restitution (Eqs 33-38) | m, N s, - | `contact.rs` |
//! | Eqs 40, 44-46 | both time-stepping schemes | | `midpoint.rs`, `conserving_midpoint.rs` |
//!
//! `stepping.rs` makes a step of parts, a scheme states the equations of a part, `newton.rs` solves them, and `bar.rs`
//! returns the stresses to the yield surface. `response.rs` follows one impact to its end.

mod accuracy;
mod backbone;
mod bar;
mod bar_strength;
mod base_plate;
mod base_reactions;
mod base_resistance;
mod bracketing;
mod buckling;
mod bumper;
mod capacity;
mod capped_moments;
mod chain;
mod conserving_midpoint;
mod contact;
mod crush;
mod crushed_vehicle;
mod elastic_motion;
mod elastic_reach;
mod fracture;
mod frame;
mod geometry;
mod impact;
mod ledger;
mod midpoint;
mod model;
mod modes;
mod motion;
mod newton;
mod paired_search;
mod properties;
mod push_down_equations;
mod rate;
mod report;
mod response;
mod return_search;
mod sample;
mod section;
mod section_backbone;
mod shear;
mod sheared_moments;
mod simulation;
mod state;
mod statics;
mod step_length;
mod stepping;
mod strength;
mod study_response;
mod vehicle;
mod web_slide;
mod webs_of_state;
mod yield_surface;
mod yielding;

pub use accuracy::{ERROR_PER_DIFFERENCE, error_estimate, with_half_the_step};
pub use backbone::HingeFactors;
pub use bar::{Bar, BarForces, PerBar, PlasticFlow};
pub use base_plate::{Anchors, BaseFactors, BasePlate, BasePlateError, stress_area};
pub use base_reactions::BASE_WINDOW;
pub use base_resistance::{BaseFailure, BaseResistance};
pub use buckling::{
    BendingAxis, BucklingCurve, BucklingResistance, buckling_resistance, effective_length_factor,
};
pub use bumper::{carried_over, plastic_before_bumper, residual_without_bumper};
pub use capacity::{
    Capacity, CapacityEnd, CapacityError, KnownCapacity, MAX_IMPERFECTION,
    MAX_PUSH_DOWN_EVALUATIONS, MAX_PUSH_DOWN_INCREMENTS, PushDown, PushDownPoint, capacity,
    capacity_up_to, carried_load, plastic_plateau, push_down,
};
pub use chain::{Chain, ChainPart, ChainPoint, Crushed};
pub use conserving_midpoint::MAX_EVENTS_PER_STEP;
pub use contact::{Impactor, MAX_ELASTIC_IMPACT_IMPULSES, PERSISTENT_CONTACT_FRACTION};
pub use crush::SpringState;
pub use frame::Frame;
pub use geometry::Displacement;
pub use impact::{
    Impact, ImpactError, ImpactSpecification, MAX_TRANSVERSE_ACCELERATION, is_direction,
    share_in_plane,
};
pub use ledger::{Energies, Ledger};
pub use model::{MAX_BUMPER_SHARE, Model, ModelError, RestState};
pub use motion::{Collapse, LENGTH_RANGE, MAX_SHORTENING, MIN_EXTENT, StepError};
pub use properties::{
    ColumnProperties, ElasticLaw, RateLaw, RateProperties, Scheme, ShearProperties,
    SofteningProperties, Support, YieldExponents,
};
pub use rate::{HingeStrength, WebState};
pub use report::{BaseReport, End, HingeReport, Outcome, Report, VehicleReport, WebReport};
pub use response::{Progress, Response, SimulationError};
pub use sample::{
    BaseForces, HINGE_NAMES, HINGES, HingeSample, HingeState, Phase, Sample, VehicleSample,
    WEB_NAMES, WEBS, WebSample,
};
pub use section::{RolledSection, STEEL_DENSITY, SectionProperties};
pub use section_backbone::SectionBackbone;
pub use simulation::{follow, respond, simulate};
pub use state::{State, Velocity};
pub use statics::residual_state;
pub use step_length::{MAX_RECOMMENDED_STEP_NANOS, MIN_RECOMMENDED_STEP_NANOS, STEPS_PER_PERIOD};
pub use stepping::{MAX_HALVINGS, MAX_PARTS, begin_impact, step};
pub use study_response::{StudyModel, StudyResponse};
pub use vehicle::{CrushCurve, CrushSpring, MAX_CURVE_POINTS, MAX_MASSES, Vehicle, VehicleError};
pub use yield_surface::YieldSurface;
