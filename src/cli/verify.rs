//! `column-twin verify`: is a recording what the model gives?

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use super::{Exit, Failure};
use crate::evidence;

/// What `column-twin verify` is told.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct VerifyArgs {
    /// A recording: its directory, or an MCAP file of it
    #[arg(value_name = "BAG")]
    bag: PathBuf,
}

const EXAMPLE: &str = "\
Runs the twin anew from the recorded state, parameters and inputs, and compares every value of
column_state, hinge_forces, impact_forecast, impact_report, twin_status, joint_states and markers
with what was recorded. The same build computes the same bits. How long computing took and what
other threads of the node did cannot be recomputed and is left out.

Example: simulate an impact, and prove the recording of it
  column-twin simulate --record impact && column-twin verify impact

Exit codes: 0 equal as far as it can be checked, 1 it differs, messages are missing without a
word about it, or nothing could be checked, 2 it cannot be read or has no journal.";

/// Prints what was found.
pub fn run(arguments: &VerifyArgs, out: &mut impl Write) -> Result<(), Failure> {
    let found =
        evidence::verify(&arguments.bag).map_err(|error| Failure::plain(Exit::BadInput, error))?;
    super::printed(write!(out, "{found}"))?;
    if found.is_equal() {
        return Ok(());
    }
    let bag = arguments.bag.display();
    Err(Failure::plain(
        Exit::Failed,
        match found.is_contradicted() {
            true => format!(
                "{bag} is not what this model gives: {} differences, {} messages missing",
                found.differences,
                found.missing()
            ),
            false => format!(
                "nothing in {bag} could be checked, for the reasons above; verify the recording before or after it"
            ),
        },
    ))
}
