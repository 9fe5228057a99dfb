//! `column-twin repair`: repairs a recording that was cut off or damaged.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use super::failure::{Exit, Failure};
use column_twin::recording;

/// Arguments of `column-twin repair`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct RepairArgs {
    /// Directory of the recording, or its MCAP file
    #[arg(value_name = "RECORDING")]
    bag: PathBuf,
    /// Directory to write to; default: next to the recording, with _repaired appended to its name
    #[arg(long, short, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

const EXAMPLE: &str = "\
Example: repair a recording that a power failure has cut off
  column-twin repair ~/.local/state/column_twin/recordings/column_twin_2026_11_21-07_40_00

The original is never changed, and nothing is overwritten.
Exit codes: 0 all records were saved or no repair was needed, 1 failed, 2 bad input or usage,
3 everything readable was saved, but a damaged or incomplete record was left out.";

/// Repairs the recording and prints what was saved.
pub fn run(arguments: &RepairArgs, out: &mut impl Write) -> Result<(), Failure> {
    let repaired = recording::repair(&arguments.bag, arguments.output.as_deref())?;
    let Some(repaired) = repaired else {
        // A failure to print cannot be reported.
        let _ = writeln!(
            out,
            "{} is complete; there is nothing to repair.",
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
