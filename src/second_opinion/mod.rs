//! The second opinion on an impact: the same hit on the same column, computed with the fibre beam of `column_beam` beside the two bars.
//!
//! [`evaluate`] computes both. Where the two models part, the action is the more severe one of both, and its reason names the model.
//!
//! ```no_run
//! use column_twin::parameters::{Parameters, parse_override};
//! use column_twin::second_opinion::evaluate;
//!
//! let oblique = parse_override("impact.direction:=0.17");
//! let parameters = Parameters::load(&["config/heb220_s355.yaml".into()], &[oblique])?;
//! let evaluated = evaluate(&parameters)?;
//! match &evaluated.second_opinion {
//!     Ok(opinion) => println!("{opinion}"),
//!     Err(reason) => println!("{reason}"),
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - answer.rs: What the beam computes of one hit: all that takes time, as plain data that another thread can compute
// - beam.rs: The column of the parameters as a fibre beam
// - criteria.rs: What the criteria of a verdict need of the two bars, before the beam replaces what it sees otherwise
// - evaluated.rs: One impact by both models, with the range of its verdict
// - joint.rs: The verdict of both models on one hit without its range, for studies of many hits
// - known_columns.rs: What undamaged columns bear by the beam, of the last columns that were computed: the next hit on one of
//   them, a variation of its speed, or the next cell of a map does not compute it again
// - oblique_range.rs: The range of the verdict on a hit as far as it takes the fibre beam: all of it for a hit out of the plane
//   of the two bars, and the beam with another hardening for one in the plane
// - opinion.rs: What the beam says of an impact beside the two bars, and where its verdict counts
// - two_threads.rs: Two parts of a second opinion at once, in a thread that has the priority and the processors of the one that
//   starts it

mod answer;
mod beam;
mod criteria;
mod evaluated;
mod joint;
mod known_columns;
mod oblique_range;
mod opinion;
mod two_threads;

pub use answer::{BeamAnswer, BeamDamageBefore, BeamTask, EarlierHit, beam_damage_after};
pub use beam::{NoSecondOpinion, beam_column};
pub use column_beam::{
    BeamColumn, BeamError, BeamModel, BeamOutcome, Damage as BeamDamage, Hit,
    Measurement as BeamMeasurement, Movement, Outcome as BeamEnd,
};
pub use evaluated::{Evaluated, evaluate};
pub use joint::{JointVerdict, JudgeError};
pub use oblique_range::ObliqueHit;
pub use opinion::{BAND, SecondOpinion, WhyItCounts, is_out_of_plane};
