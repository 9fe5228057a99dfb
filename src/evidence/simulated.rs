//! Records a simulated impact on an undamaged column as a node would record it, without ROS and faster than real time.

use std::path::Path;
use std::sync::Arc;

use super::entry_encoder::EntryEncoder;
use super::journal_line::{JournalEntry, JournalError};
use super::topics::Topics;
use crate::column::{ImpactSpecification, ModelError, Report};
use crate::endpoints::{self, Endpoint, NodeKind};
use crate::live::monotonic_nanos;
use crate::messages::builtin_interfaces::Time;
use crate::messages::cdr::{self, CdrError};
use crate::messages::column_twin_msgs::ImpactEvent;
use crate::messages::std_msgs::Header;
use crate::outgoing::Outgoing;
use crate::parameters::Parameters;
use crate::recording::{Finished, RecordingError, Writer, WriterOptions};
use crate::time::Nanos;
use crate::twin::{Command, ImpactCommand, Output, Rejection, Twin};

/// Identifier of the event.
const SIMULATED_EVENT: &str = "simulated";

/// A completed recording.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedImpact {
    /// The files.
    pub finished: Finished,
    /// The outcome of the impact; `None` if the response could not be computed to its end.
    pub report: Option<Report>,
}

/// Why an impact cannot be recorded.
#[derive(Debug, thiserror::Error)]
pub enum SimulatedRecordingError {
    /// The recording cannot be written.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The column is impossible.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A message cannot be encoded.
    #[error(transparent)]
    Message(#[from] CdrError),
    /// An entry of the journal cannot be encoded.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// The twin rejects the impact.
    #[error("the impact was rejected: {0}")]
    Rejected(#[from] Rejection),
    /// The start time cannot be represented in a message.
    #[error(
        "expected a start time between 1970 and 2038 for the recording, found {0} ns after 1970"
    )]
    Origin(Nanos),
}

/// Simulates the impact that the parameters describe on an undamaged column, and records it in a directory, which must not
/// exist. `origin` is the stamp of the event, where the times of the recording start.
///
/// # Errors
/// The column or the impact is impossible, or the recording cannot be written.
pub fn record_impact(
    parameters: &Parameters,
    origin: Nanos,
    directory: &Path,
    options: &WriterOptions,
) -> Result<RecordedImpact, SimulatedRecordingError> {
    let stamp = Time::from_nanos(origin)
        .filter(|_| origin >= 0)
        .ok_or(SimulatedRecordingError::Origin(origin))?;
    let settings = parameters.settings();
    let impact = ImpactSpecification {
        direction: Some(parameters.direction()).filter(|it| *it != 0.0),
        ..parameters.whole_impact().into()
    };
    let command = ImpactCommand {
        event_id: SIMULATED_EVENT.to_owned(),
        column_id: settings.column_id.clone(),
        stamp: origin,
        vehicle: String::new(),
        impact,
    };
    let message = ImpactEvent {
        header: Header {
            stamp,
            frame_id: settings.frame_id.clone(),
        },
        column_id: command.column_id.clone(),
        event_id: command.event_id.clone(),
        ..ImpactEvent::from(&impact)
    };
    let mut twin = Twin::new(parameters.clone(), None, Box::new(monotonic_nanos), origin)?;
    let topics = Topics::of_default_node(NodeKind::Single);
    let mut recorder = ImpactRecorder {
        writer: Writer::create(directory, options, &topics.declared()?)?,
        encoder: EntryEncoder::new(&topics, false),
        outgoing: Outgoing::new(parameters),
        report: None,
    };
    let written = recorder
        .simulate(&mut twin, command, &message, origin)
        .and_then(|end| recorder.line(JournalEntry::End {}, end));
    let finished = recorder.writer.finish();
    written?;
    Ok(RecordedImpact {
        finished: finished?,
        report: recorder.report,
    })
}

/// Writes the outputs of a twin.
struct ImpactRecorder {
    writer: Writer,
    encoder: EntryEncoder,
    outgoing: Outgoing,
    report: Option<Report>,
}

impl ImpactRecorder {
    /// The time at the end of the response.
    fn simulate(
        &mut self,
        twin: &mut Twin,
        command: ImpactCommand,
        message: &ImpactEvent,
        origin: Nanos,
    ) -> Result<Nanos, SimulatedRecordingError> {
        let mut out = Vec::new();
        twin.advance_to(origin, &mut out);
        self.write(&mut out, origin)?;
        let bytes: Arc<[u8]> = cdr::encode(message)?.into();
        let received = EntryEncoder::received(&endpoints::IMPACT_EVENT, &bytes, origin);
        self.message(&endpoints::IMPACT_EVENT, bytes, origin)?;
        self.line(received, origin)?;
        let accepted = twin.handle(Command::Impact(command), origin, &mut out);
        twin.run_ahead(u64::MAX, origin, &mut out);
        let mut now = origin;
        loop {
            twin.advance_to(now, &mut out);
            self.write(&mut out, now)?;
            if !twin.is_responding() {
                accepted?;
                return Ok(now);
            }
            now = twin.next_deadline(now).max(now);
        }
    }

    fn write(&mut self, out: &mut Vec<Output>, now: Nanos) -> Result<(), SimulatedRecordingError> {
        for output in out.drain(..) {
            let mut messages = Vec::new();
            self.outgoing
                .convert(&output, |message| messages.push(message));
            for message in messages {
                let endpoint = message.topic().endpoint();
                self.message(endpoint, message.encode()?.into(), now)?;
            }
            match output {
                Output::Journal(entry) => self.line(JournalEntry::Twin(entry), now)?,
                Output::Report(report) => self.report = Some(report.report),
                _ => {}
            }
        }
        Ok(())
    }

    fn message(
        &mut self,
        endpoint: &Endpoint,
        bytes: Arc<[u8]>,
        now: Nanos,
    ) -> Result<(), RecordingError> {
        if let Some(entry) = self.encoder.message(endpoint, bytes, now, now) {
            self.writer.write(&entry)?;
            self.encoder.recorded_message(endpoint, now);
        }
        Ok(())
    }

    fn line(&mut self, entry: JournalEntry, now: Nanos) -> Result<(), SimulatedRecordingError> {
        if let Some(entry) = self.encoder.line(entry, None, now, None)? {
            self.writer.write(&entry)?;
            self.encoder.recorded_line();
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::column::End;
    use crate::evidence::verify;
    use crate::twin::failing_step;

    /// The last state of such a response is given out when its next step was tried, and has the stamp of the one before.
    #[test]
    fn a_response_that_ended_in_a_solver_error_verifies() {
        let parameters = Parameters::from_values([("solver.dt", 1e-4.into())]).expect("admissible");
        let directory = tempfile::TempDir::new().expect("a directory");
        for step in [0, 1, 30, 37, 222] {
            let path = directory.path().join(step.to_string());
            failing_step::set(Some(step));
            let recorded = record_impact(
                &parameters,
                1_800_000_000_000_000_000,
                &path,
                &WriterOptions::default(),
            );
            let end = recorded.expect("recorded").report.map(|it| it.end);
            assert_eq!(end, Some(End::NotConverged));
            let found = verify(&path).expect("readable");
            assert!(found.is_equal() && found.unchecked.is_empty(), "{found}");
            assert_eq!((found.missing(), found.unchecked_messages()), (0, 0));
            // A program that can compute the step does not confirm the recording.
            failing_step::set(None);
            let found = verify(&path).expect("readable");
            assert!(found.is_contradicted(), "{found}");
        }
    }
}
