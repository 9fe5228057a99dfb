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
Runs the twin again from the recorded state, parameters and commands, and compares every message
of column_state, hinge_forces, impact_forecast, impact_report, twin_status, joint_states and
markers with the recording: its values, its place, and whether it is there. impact_event and
column_parameters are compared with the commands in the journal. The journal counts the messages
on all other topics. Log and publish times are compared with those in the journal.

A message may be missing only if the recording declares the loss: in twin_status, by its recorder,
by a damaged file, or by a crash that cut off its end. The output lists what cannot be recomputed.

Example: record a simulated impact, and verify the recording
  column-twin simulate --record impact && column-twin verify impact

Exit codes: 0 everything that could be checked is equal, 1 the recording differs, more messages are
missing than it declares as lost, or nothing could be checked, 2 the recording cannot be read or
has no journal of this version.";

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
                "{bag} differs from the recomputation: {} differences, {} messages missing without a declared loss",
                found.differences, found.undeclared
            ),
            false => format!(
                "nothing in {bag} could be checked, for the reasons above; verify the previous or the next recording"
            ),
        },
    ))
}
