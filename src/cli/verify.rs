//! `column-twin verify`: verifies a recording by recomputation.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use super::failure::{Exit, Failure, printed};
use column_twin::evidence;

/// Arguments of `column-twin verify`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct VerifyArgs {
    /// Directory of the recording, or its MCAP file
    #[arg(value_name = "BAG")]
    bag: PathBuf,
}

const EXAMPLE: &str = "\
Runs the twin again from the recorded state, parameters and inputs, and compares every value of
column_state, hinge_forces, impact_forecast, impact_report, twin_status, joint_states and markers
with the recording. The same build computes the same bits. Computing times and counts of other
threads cannot be recomputed and are not compared.

Example: record a simulated impact, and verify the recording
  column-twin simulate --record impact && column-twin verify impact

Exit codes: 0 everything that could be checked is equal, 1 the recording differs, messages are
missing although no loss is declared, or nothing could be checked, 2 the recording cannot be read
or has no journal.";

/// Verifies the recording and prints the result.
pub fn run(arguments: &VerifyArgs, out: &mut impl Write) -> Result<(), Failure> {
    let found =
        evidence::verify(&arguments.bag).map_err(|error| Failure::plain(Exit::BadInput, error))?;
    printed(write!(out, "{found}"))?;
    if found.is_equal() {
        return Ok(());
    }
    let bag = arguments.bag.display();
    Err(Failure::plain(
        Exit::Failed,
        match found.is_contradicted() {
            true => format!(
                "{bag} differs from the recomputation: {} differences, {} messages missing",
                found.differences,
                found.missing()
            ),
            false => format!(
                "nothing in {bag} could be checked, for the reasons above; verify the previous or the next recording"
            ),
        },
    ))
}
