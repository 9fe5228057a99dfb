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

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - accuracy.rs: How wrong a response is by the length of its step
// - backbone.rs: The strength of a hinge over its accumulated plastic rotation
// - bar.rs: One bar: two hinges that share one normal force
// - bar_strength.rs: The strength of the two hinges and of the web of one bar over one part of a step
// - base_plate.rs: The base plate of a column of an I section: moment, shear and uplift that it bears, and its stiffness, by
//   the component method of EN 1993-1-8 (6.2.8, 6.2.6.9 to 6.2.6.12, 6.2.2, 6.3.4)
// - base_reactions.rs: What the column bears upon its base: shear force, moment and normal force, with the inertia of the lower
//   bar; their means over a millisecond, which are what loads anchors and concrete, and the extremes of a response
// - base_resistance.rs: What the base of a column bears, moment with normal force and shear, whatever connects it
// - bracketing.rs: The solution of the equations of a part of a step where Newton's method fails: Newton's method for the
//   unknowns that carry mass, and brackets for the massless ones at each of its iterations
// - buckling.rs: Flexural buckling resistance and equivalent imperfections of EN 1993-1-1
// - bumper.rs: A column at rest before another bumper, or before none: what remains of its plastic deformation where it is
// - capacity.rs: The residual axial capacity: a static push-down of a column at rest, undamaged or with the plastic strains of
//   an impact
// - capped_moments.rs: The moments of a bar's two hinges within their caps: two hinges that an elastic law may couple
// - chain.rs: The motion of a deformable vehicle: a chain of masses over one part of a step
// - conserving_midpoint.rs: The energy-conserving midpoint rule
// - contact.rs: Unilateral contact and Newton's impact law (Eqs 33-38)
// - crush.rs: The force law of a spring that crushes, and its mean over a part of a step
// - crushed_vehicle.rs: What is left of a vehicle that earlier impacts have crushed
// - elastic_motion.rs: The elastic motion of a column in long explicit steps, for studies: between two plastic flows, before a
//   deformable vehicle or without contact
// - elastic_reach.rs: How far the energy that is left in a column can carry it: whether it can still reach a yield surface, and
//   between which displacements of the impact point it stays
// - force_spectrum.rs: The equivalent static force of a contact: what a neighbouring member that is pushed by the same force
//   would feel, by its period
// - fracture.rs: When a hinge, a web or the anchors of the base fracture
// - frame.rs: The two bars and the spring at the top: from displacements to deformations of the bars, from forces of the bars
//   to forces on the displacements, `f_int = B^T S` (Eqs 10, 15-16), and the tangent `B^T D B` with its geometric part
// - geometry.rs: From displacements to deformations, and the gradients that map forces back (Eqs 1-10)
// - impact.rs: What strikes the column: the specification of an impact, with its open values and completed
// - ledger.rs: Energy balance: kinetic + elastic (column and vehicle) + plastic work + impact loss + damping work + crush of
//   the vehicle - P u2 - F x_c is constant, with the transverse force `F` on the vehicle and the position `x_c` of its centre
//   of mass
// - midpoint.rs: The paper's midpoint rule (Eqs 40, 44-46): equations of motion and flow rule at `n + 1/2`
// - model.rs: The constants of one column, derived and checked once
// - modes.rs: Elastic modes about a state: the slowest period, and the modal damping of the column at rest
// - motion.rs: What both schemes share: inertia, damping and load of a part of a step, the failure of a step, and the shape
//   that a column must keep
// - newton.rs: The nonlinear equations of a part of a step or of a static equilibrium: Newton's method with the massless
//   rotation condensed
// - paired_search.rs: The scalar problem of a return to the surfaces of two hinges of different strength, `strength.rs`, and of
//   the web between them, `shear.rs`
// - properties.rs: The properties of a column as an engineer gives them: numbers in SI units, from which the model is derived
// - push_down_equations.rs: The equations of one increment of a push-down: static equilibrium with plastic flow, under a
//   prescribed force or along a path that may lead through limit points
// - rate.rs: Strain rate and hardening of the hinges: the factors by which they enlarge the yield surfaces
// - report.rs: The outcome of one impact
// - response.rs: One impact from its event to rest: when a response is over, and its summary
// - return_search.rs: The scalar problem of a return to the yield surface, whose derivative is monotone: a bracketed root
//   search never fails, corners and tips included
// - sample.rs: The observable quantities of the column at one instant: a row of a history, the content of a message
// - section.rs: Cross-sections of hot-rolled I and H profiles, computed from their five dimensions
// - section_backbone.rs: The monotonic backbone of a hinge in a wide-flange section, from regressions over tests
// - shear.rs: Shear of the web of a bar: a plastic slider in series with its two hinges
// - sheared_moments.rs: The moments of a bar's two hinges within their caps and their sum within that of the web: three
//   mechanisms, two moments
// - simulation.rs: One impact on the undamaged column, from the event to the end of the response
// - state.rs: The state of a column under impact
// - statics.rs: Equilibrium without inertia: of the whole column with its plastic deformation frozen, and of its massless
//   unknowns
// - step_length.rs: How long a step should be
// - stepping.rs: The event of an impact and the time step with either scheme: a step is made in parts, which are halved where
//   they do not converge, a bounded number of times
// - strength.rs: One bar whose two hinges differ in strength: strain rate and hardening enlarge the whole yield surface of a
//   hinge
// - study_response.rs: One impact, followed only as closely as a study needs it
// - vehicle.rs: A deformable vehicle: a chain of masses with crushable springs in front of them
// - web_slide.rs: The return of a stress where the web of a bar flows alone, without its hinges
// - web_strength.rs: The strength of the web of one bar over a response: what it remembers, and how it hardens
// - webs_of_state.rs: What can be observed of the webs in a state of the column
// - yield_surface.rs: The superellipse family of yield surfaces (Eqs 26-31)
// - yielding.rs: How close hinges and webs come to yielding, and at which instant of a step they do

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
mod force_spectrum;
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
mod web_strength;
mod webs_of_state;
mod yield_surface;
mod yielding;

pub use accuracy::{COMMON_ERROR, ERROR_PER_DIFFERENCE, error_estimate, with_half_the_step};
pub use backbone::HingeFactors;
pub use bar::{Bar, BarForces, PerBar, PerBarHinges, PlasticFlow};
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
pub use force_spectrum::{ForceSpectrum, SPECTRUM_PERIODS};
pub use frame::Frame;
pub use geometry::Displacement;
pub use impact::{
    Impact, ImpactError, ImpactSpecification, MAX_TRANSVERSE_ACCELERATION, is_direction,
    is_seen_by_the_bars, share_in_plane,
};
pub use ledger::{Energies, Ledger};
pub use model::{MAX_BUMPER_SHARE, Model, ModelError, RestState};
pub use motion::{Collapse, LENGTH_RANGE, MAX_SHORTENING, MIN_EXTENT, StepError};
pub use properties::{
    ColumnProperties, ElasticLaw, RateLaw, RateProperties, Scheme, ShearProperties,
    SofteningProperties, Support, YieldExponents,
};
pub use rate::HingeStrength;
pub use report::{BaseReport, End, HingeReport, Outcome, Report, VehicleReport, WebReport};
pub use response::{Progress, Response, SimulationError};
pub use sample::{
    BaseForces, HINGE_NAMES, HINGES, HingeSample, HingeState, Phase, Sample, VehicleSample,
    WEB_NAMES, WEBS, WebSample,
};
pub use section::{RolledSection, STEEL_DENSITY, SectionProperties};
pub use section_backbone::SectionBackbone;
pub use simulation::{follow, follow_from, respond, simulate};
pub use state::{State, Velocity};
pub use statics::residual_state;
pub use step_length::{MAX_RECOMMENDED_STEP_NANOS, MIN_RECOMMENDED_STEP_NANOS, STEPS_PER_PERIOD};
pub use stepping::{MAX_HALVINGS, MAX_PARTS, begin_impact, step};
pub use study_response::{StudyModel, StudyResponse};
pub use vehicle::{CrushCurve, CrushSpring, MAX_CURVE_POINTS, MAX_MASSES, Vehicle, VehicleError};
pub use web_strength::WebState;
pub use yield_surface::YieldSurface;
