//! Records a simulated impact on a virgin column as a node would record it, without ROS and faster than real time.

use std::path::Path;
use std::sync::Arc;

use super::entry_encoder::EntryEncoder;
use super::journal_line::JournalError;
use super::topics::Topics;
use crate::column::{ImpactSpecification, ModelError, Report};
use crate::endpoints;
use crate::live::monotonic_nanos;
use crate::messages::builtin_interfaces::Time;
use crate::messages::cdr::{self, CdrError};
use crate::messages::column_twin::ImpactEvent;
use crate::messages::std_msgs::Header;
use crate::outgoing::Outgoing;
use crate::parameters::Parameters;
use crate::recording::{Entry, Finished, RecordingError, Writer, WriterOptions};
use crate::twin::{Command, ImpactCommand, Nanos, Output, Refusal, Twin};

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
    Refused(#[from] Refusal),
    /// The start time cannot be represented in a message.
    #[error(
        "expected a start time between 1970 and 2038 for the recording, found {0} ns after 1970"
    )]
    Origin(Nanos),
}

/// Simulates the impact that the parameters describe on a virgin column, and records it in a directory, which must not
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
    let impact = ImpactSpecification::from(parameters.impact());
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
    let topics = Topics::of_default_node();
    let mut recorder = ImpactRecorder {
        writer: Writer::create(directory, options, &topics.declared()?)?,
        encoder: EntryEncoder::new(&topics),
        outgoing: Outgoing::new(parameters),
        report: None,
    };
    let written = recorder.simulate(&mut twin, command, &message, origin);
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
    fn simulate(
        &mut self,
        twin: &mut Twin,
        command: ImpactCommand,
        message: &ImpactEvent,
        origin: Nanos,
    ) -> Result<(), SimulatedRecordingError> {
        let mut out = Vec::new();
        twin.advance_to(origin, &mut out);
        self.write(&mut out, origin)?;
        let bytes = cdr::encode(message)?.into();
        self.put(EntryEncoder::message(
            &endpoints::IMPACT_EVENT,
            bytes,
            origin,
            origin,
        ))?;
        let accepted = twin.handle(Command::Impact(command), origin, &mut out);
        twin.run_ahead(u64::MAX, origin, &mut out);
        let mut now = origin;
        loop {
            twin.advance_to(now, &mut out);
            self.write(&mut out, now)?;
            if !twin.is_responding() {
                accepted?;
                return Ok(());
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
                let bytes = Arc::from(message.encode()?);
                self.put(EntryEncoder::message(endpoint, bytes, now, now))?;
            }
            match output {
                Output::Journal(entry) => {
                    let entry = self.encoder.journal(&entry, now)?;
                    self.put(entry)?;
                }
                Output::Report(report) => self.report = Some(report.report),
                _ => {}
            }
        }
        Ok(())
    }

    fn put(&mut self, entry: Option<Entry>) -> Result<(), RecordingError> {
        entry.map_or(Ok(()), |entry| self.writer.write(&entry))
    }
}
