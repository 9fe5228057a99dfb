//! `column-twin report`: a report about the impacts of a recording, for people.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;

use super::failure::{Exit, Failure, printed};
use column_twin::report::{
    Origin, RecordedReportError, ReportDetails, ReportDocument, parameters_path,
};
use column_twin::whole_file;

/// Arguments of `column-twin report`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct ReportArgs {
    /// Directory of the recording, or its MCAP file
    #[arg(value_name = "RECORDING")]
    bag: PathBuf,
    /// HTML file to write; an existing file is replaced
    #[arg(long, short, value_name = "FILE", default_value = "report.html")]
    output: PathBuf,
    /// File with project, site, author and other details for the title block
    #[arg(long, value_name = "FILE")]
    report_details: Option<PathBuf>,
    /// Report about this column of a fleet
    #[arg(long, value_name = "ID")]
    column: Option<String>,
    /// Report about this impact only
    #[arg(long, value_name = "ID")]
    event: Option<String>,
}

const EXAMPLE: &str = "\
Writes one HTML file that any browser opens without a network and prints on A4. Each impact has
four pages: the required action and the places to inspect, with sketch and title block; the
checks; the column after the hit; the uncertainty. An annex holds the figures and the result of
the verification by recomputation. All parameters go to a JSON file next to it.

The file of --report-details has lines such as project: Car park North. Missing lines are left
blank, to be filled in by hand: project, site, client, document, revision, date, author,
checker, hit_direction.

Example: record a simulated impact, and report about it
  column-twin simulate --record impact && column-twin report impact -o impact.html

Exit codes: 0 done, and everything that could be checked is equal to the recomputation, 1
failed, or the recording differs from its recomputation or its seal does not hold (the report
shows where), 2 bad input or usage, 3 done, but the recording could not be verified or is not
complete.";

/// Writes the report and prints where it is.
pub fn run(arguments: &ReportArgs, out: &mut impl Write) -> Result<(), Failure> {
    let details = match &arguments.report_details {
        Some(path) => {
            ReportDetails::read(path).map_err(|fault| Failure::new(Exit::BadInput, fault))?
        }
        None => ReportDetails::default(),
    };
    let mut document = ReportDocument::of_recording(
        &arguments.bag,
        arguments.column.as_deref(),
        arguments.event.as_deref(),
    )
    .map_err(|error| match error {
        RecordedReportError::Recording(error) => error.into(),
        other => Failure::plain(Exit::BadInput, other),
    })?;
    document.details = details;
    let html = document
        .html()
        .map_err(|error| Failure::new(Exit::Failed, error))?;
    let written = |path: &Path, text: &str| {
        whole_file::write(path, text.as_bytes()).map_err(|reason| {
            let path = path.display();
            let reason = format!("cannot write the report to {path}: {reason}; name a file in an existing, writable folder");
            Failure::plain(Exit::Failed, reason)
        })
    };
    written(&arguments.output, &html)?;
    written(
        &parameters_path(&arguments.output),
        &document.parameters_json(),
    )?;
    printed(writeln!(out, "{}", arguments.output.display()))?;
    let Origin::Recording(recorded) = &document.origin else {
        return Ok(());
    };
    let bag = arguments.bag.display();
    let (exit, reason) = match (&recorded.verification, &recorded.incomplete) {
        (Ok(found), _) if found.is_contradicted() => (
            Exit::Failed,
            format!(
                "{bag} differs from its recomputation: {} differences, {} messages missing; the report shows where",
                found.differences,
                found.missing()
            ),
        ),
        (Err(reason), _) => (
            Exit::Lossy,
            format!("{bag} could not be verified: {reason}"),
        ),
        (Ok(found), _) if found.is_unchecked() => (
            Exit::Lossy,
            format!("nothing in {bag} could be verified; the report names the reasons"),
        ),
        (Ok(_), _) if recorded.seal.fault().is_some() => (
            Exit::Failed,
            format!(
                "{bag}: {}; the report contains the remainder",
                recorded.seal.fault().unwrap_or_default()
            ),
        ),
        // Of a repaired recording the report contains all that is left.
        (Ok(_), Some(why)) if !recorded.is_whole => (
            Exit::Lossy,
            format!(
                "{bag} is not complete: {why}; the report contains the readable part; save it with: column-twin repair {bag}"
            ),
        ),
        (Ok(_), _) => return Ok(()),
    };
    Err(Failure::plain(exit, reason))
}
