//! `column-twin repair`: a recording that was cut off, written anew.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use super::{Exit, Failure};
use crate::recording::{self, RecordingError};

/// What `column-twin repair` is told.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct RepairArgs {
    /// Directory of the recording, or its .mcap file
    #[arg(value_name = "BAG")]
    bag: PathBuf,
    /// Directory to write to; default: beside the recording, with _repaired behind its name
    #[arg(long, short, value_name = "DIR")]
    output: Option<PathBuf>,
}

const EXAMPLE: &str = "\
Example: what the node recorded until the power went
  column-twin repair recordings/column_twin_2026_11_21-07_40_00

The original is never changed, and nothing is overwritten.
Exit codes: 0 all records are saved, or there is nothing to repair; 1 failed, 2 bad input or
usage, 3 what can be read is saved, but a damaged or incomplete record is left out.";

/// Writes the recording anew and says what was saved.
pub fn run(arguments: &RepairArgs, out: &mut impl Write) -> Result<(), Failure> {
    let repaired =
        recording::repair(&arguments.bag, arguments.output.as_deref()).map_err(failure)?;
    let Some(repaired) = repaired else {
        // Nobody to tell if this cannot be printed.
        let _ = writeln!(
            out,
            "{} is whole; there is nothing to repair.",
            arguments.bag.display()
        );
        return Ok(());
    };
    let _ = writeln!(out, "{repaired}");
    if repaired.left_out > 0 || repaired.in_record {
        return Err(Failure::plain(
            Exit::Lossy,
            "an incomplete or damaged part of the recording could not be saved",
        ));
    }
    Ok(())
}

/// How a command ends that cannot read or write a recording.
pub(super) fn failure(error: RecordingError) -> Failure {
    let exit = match error.is_bad_input() {
        true => Exit::BadInput,
        false => Exit::Failed,
    };
    match error.repairable() {
        Some(path) => {
            let command = format!("column-twin repair {}", path.display());
            Failure::plain(exit, format!("{error}, with: {command}"))
        }
        None => Failure::plain(exit, error),
    }
}
