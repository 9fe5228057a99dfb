//! THE MECHANICS.
mod properties;
mod report;
mod sample;
mod section;

pub use properties::{ColumnProperties, ElasticLaw, Scheme, Support, YieldExponents};
pub use report::{End, HingeReport, Outcome, Report};
pub use sample::{HINGE_NAMES, HINGES, HingeSample, HingeState, Phase, Sample};
pub use section::{RolledSection, STEEL_DENSITY, SectionProperties};
