//! The report for people: one HTML file about one impact, all impacts of a recording, or an impact that was estimated from
//! the readings of sensors, with everything inside it.
//!
//! It needs no script, no other file and no network, and prints on A4. Every text that comes from outside is escaped. The
//! same input gives the same bytes: the file contains no date of its own.
//!
//! An impact has four pages and an annex. All parameters are in a JSON file beside the report. There is no PDF of its own:
//! a library would need each table laid out a second time, and Chromium prints the file.
//!
//! The first line of every impact is its verdict. It never claims more than the model knows: what a section needs and the
//! input does not contain is named as missing.

mod assessed;
mod assessment_section;
mod check_names;
mod checks;
mod course;
mod details;
mod detected_impact;
#[cfg(feature = "record")]
mod detected_section;
mod document;
mod energy_balance;
mod estimate_document;
mod estimate_section;
#[cfg(feature = "record")]
mod facts;
mod impact_section;
mod inspection;
mod limits;
mod limits_section;
mod pages;
mod provenance;
#[cfg(feature = "record")]
mod recorded;
#[cfg(feature = "record")]
mod recording_section;
mod reported_impact;
mod second_opinion_section;
mod shape_drawing;
mod sketch;
mod svg;
mod title_block;
mod uncertainty;
mod verdict;
mod words;

pub use course::Struck;
pub use details::{MAX_DETAIL_CHARS, ReportDetails, ReportDetailsError};
#[cfg(feature = "record")]
pub use detected_impact::{DetectedDecision, DetectedImpact};
pub use document::{Origin, ReportDocument, parameters_path};
pub use energy_balance::{EnergyBalance, EnergyEntry};
pub use estimate_document::EstimateDocument;
#[cfg(test)]
pub(crate) use limits::{FIBRE_AGREEMENT, FibreAgreement};
#[cfg(feature = "record")]
pub use recorded::{MAX_SECTIONS, RecordedFile, RecordedReportError, ReportedRecording};
pub use reported_impact::ReportedImpact;
pub use words::{base_rows, end_in_words, in_kilo, outcome_in_words, short, title};
