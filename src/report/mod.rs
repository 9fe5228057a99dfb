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

// What each file of this folder holds, in its own words (`UPDATE_DOCS=1 cargo test --test tidy`):
//
// - assessed.rs: What the impact has left of the column: its residual capacity, judged by the criteria
// - assessment_section.rs: The residual capacity as a table
// - beam_words.rs: What the fibre beam says of the column, in the words of the first pages
// - checks.rs: The checks as a table: the names people use, clause and edition, value, limit, utilisation, and what follows
// - course.rs: The course of one response, computed from the instant at which the impact begins
// - details.rs: What an office writes into a report beside the numbers: project, site, author and the like
// - detected_impact.rs: An impact of a recording that the sensors have detected, and what has become of it
// - detected_section.rs: The section about the impacts of a recording that the sensors have detected
// - document.rs: The HTML file
// - energy_balance.rs: Where the energy of an impact went
// - estimate_document.rs: The report about an impact that was estimated from the readings of sensors
// - estimate_section.rs: What a report says of the estimates of one impact, the last of which counts
// - facts.rs: A row of a table of facts, as every section of the report writes it
// - impact_section.rs: What one impact was, and the annex with its computation
// - inspection.rs: What must be looked at on site, with the reason: what the checks find, and what they cannot see
// - limits.rs: What the model cannot know, in plain words
// - limits_section.rs: The section of the report about what the model cannot know
// - numbered_figures.rs: The figures of a section of the report, numbered in the order in which they appear
// - pages.rs: The four pages about one impact: what has to be done, the checks, the column after the hit, and how sure that is
// - provenance.rs: Where the numbers of the report come from
// - recorded.rs: The impacts of a recording, recomputed from its journal
// - recording_section.rs: What the report says of a recording as a whole: the overview of its impacts, its origin and its
//   verification
// - reported_impact.rs: One impact with everything that the report needs of it
// - second_opinion_section.rs: The page of the report about the second opinion
// - shape_drawing.rs: The shape of the column before and after the hit: to scale, and with its displacements magnified
// - sketch.rs: The sketch of the first page: elevation and plan of column and hit, each to its scale
// - svg.rs: Drawings to scale: lines, areas and texts in a small coordinate system, as SVG
// - title_block.rs: The title block: project, site, author, checker, date, revision and signatures, with lines to be filled in
//   by hand
// - uncertainty.rs: How far the numbers of an impact may be off: the time step, the range of the verdict, and the band of
//   hardening and softening
// - verdict.rs: The first lines of the report: what has to be done, then the cause in plain words, then the number and its
//   limit
// - words.rs: The wording that summary and report share

mod assessed;
mod assessment_section;
mod beam_words;
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
mod facts;
mod impact_section;
mod inspection;
mod limits;
mod limits_section;
mod numbered_figures;
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
pub use words::{
    base_rows, end_in_words, in_kilo, instead_of_a_residual, outcome_in_words, short, title,
};
