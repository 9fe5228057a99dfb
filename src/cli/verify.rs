//! `column-twin verify`: verifies a recording by recomputation.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use super::failure::{Exit, Failure, printed};
use column_twin::evidence;
use column_twin::recording::{self, Reader, SealFinding};

/// Arguments of `column-twin verify`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct VerifyArgs {
    /// Directory of the recording, or its MCAP file
    #[arg(value_name = "RECORDING")]
    bag: PathBuf,
    /// Recompute this column of a fleet only
    #[arg(long, value_name = "ID")]
    column: Option<String>,
    /// Public key by which the recording must be sealed, may be repeated: a file in PEM, or 64 hexadecimal digits
    #[arg(long, value_name = "FILE|KEY")]
    trusted_key: Vec<String>,
    /// Fail if the recording is not sealed up to its end: without a seal, with messages that it does not cover, or cut off
    #[arg(long)]
    require_seal: bool,
}

const EXAMPLE: &str = "\
Runs the twin again from the recorded state, parameters and commands, and compares every message
that the twin publishes about its column, such as column_state, impact_report, twin_status or
markers, with the recording: its values, its place, and whether it is there. impact_event and
column_parameters are compared with the commands in the journal. Estimates from sensors are computed
again from the recorded measurements and compared with impact_estimate, and /parameter_events with
the parameters. The journal counts the messages on all other topics. Log and publish times are
compared with the times in the journal.

A message may be missing only if the recording declares the loss: in twin_status, by its
recorder, by a damaged file, or by a crash that cut off its end. The output lists the data that
cannot be recomputed.

The recording of a fleet is verified column by column, and every finding names its column. Columns
that have executed no command are not in the recording. The columns in fleet_status are compared
with their last twin_status.

The seal of a recording is also checked. It proves that nothing was changed since it was recorded,
and that the index leads other programs to the same messages.
Only a key that you trust (--trusted-key) proves who recorded it. A recording without a final seal
was cut off, by a crash or by a person, which is an error only with --require-seal. A recording with
-p record.seal:=false is not sealed, which is an error only with --require-seal or --trusted-key.

Example: record a simulated impact, and verify the recording
  column-twin simulate --record impact && column-twin verify impact
Example: make a key, seal recordings with it, and demand that a recording is sealed by it
  openssl genpkey -algorithm ed25519 -out seal_key.pem
  openssl pkey -in seal_key.pem -pubout -out seal_key_public.pem
  column-twin simulate --record impact -p record.seal_key:=seal_key.pem
  column-twin verify impact --trusted-key seal_key_public.pem

Exit codes: 0 everything that could be checked is equal, and the seal holds, 1 the recording
differs, more messages are missing than it declares as lost, nothing could be checked, or less
than half of a damaged recording, or the seal does not hold or is not as demanded, 2 the
recording cannot be read or has no journal of this version, or a key cannot be read.";

/// Verifies the recording and prints the result.
pub fn run(arguments: &VerifyArgs, out: &mut impl Write) -> Result<(), Failure> {
    let bad_input = |error: &dyn std::fmt::Display| Failure::plain(Exit::BadInput, error);
    let trusted = arguments
        .trusted_key
        .iter()
        .map(|text| recording::public_key(text))
        .collect::<Result<Vec<_>, _>>()
        .map_err(|error| bad_input(&error))?;
    let reader = Reader::open(&arguments.bag).map_err(|error| bad_input(&error))?;
    let mut seal = SealFinding::of(&reader).with_neighbours(&reader);
    if arguments.require_seal || !trusted.is_empty() {
        seal = seal.required(trusted);
    }
    if arguments.require_seal {
        seal = seal.to_the_end();
    }
    let bag = arguments.bag.display();
    let seal_fault = seal.fault();
    let verified = match &arguments.column {
        None => evidence::verify_reader(&reader),
        Some(column_id) => evidence::verify_column(&reader, column_id),
    };
    let found = match verified {
        Ok(found) => found,
        Err(error) => {
            // What the seal proves holds for a recording that this program cannot recompute, too.
            printed(write!(out, "{seal}"))?;
            return Err(match seal_fault {
                Some(fault) => Failure::plain(Exit::Failed, format!("{bag}: {fault}; {error}")),
                None => bad_input(&error),
            });
        }
    };
    printed(write!(out, "{found}{seal}"))?;
    let mut reasons = Vec::new();
    if found.is_contradicted() {
        reasons.push(format!(
            "{bag} differs from the recomputation: {} differences, {} messages missing without a declared loss",
            found.differences, found.undeclared
        ));
    } else if found.is_too_little() && !found.is_unchecked() {
        let (compared, all) = found.extent();
        reasons.push(format!(
            "only {compared} of the {all} messages in {bag} could be compared, expected at least {:.0} %; the reasons are above",
            100.0 * evidence::LEAST_SHARE
        ));
    } else if !found.is_equal() {
        reasons.push(format!(
            "nothing in {bag} could be checked, for the reasons above; verify the previous or the next recording"
        ));
    }
    reasons.extend(seal_fault.map(|fault| format!("{bag}: {fault}")));
    match reasons.is_empty() {
        true => Ok(()),
        false => Err(Failure::plain(Exit::Failed, reasons.join("\n"))),
    }
}
