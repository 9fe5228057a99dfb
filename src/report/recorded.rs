//! The impacts of a recording, recomputed from its journal.

use std::collections::{HashMap, VecDeque};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::course::Struck;
use super::details::ReportDetails;
use super::detected_impact::DetectedImpact;
use super::document::{Origin, ReportDocument};
use super::reported_impact::ReportedImpact;
use super::words;
use crate::column::{Impact, ImpactSpecification, Model, Sample, State};
use crate::estimation::EstimateRecord;
use crate::evidence::{self, JournalEntry, Observed, Verification, VerifyError, sha256_of_file};
use crate::figures::HistoryThinning;
use crate::live::monotonic_nanos;
use crate::parameters::Parameters;
use crate::recording::{self, EventSummary, Reader, RecordingError, SealFinding};
use crate::second_opinion::Movement;
use crate::study::VehicleLimits;
use crate::time::Nanos;
use crate::twin::{
    ColumnSnapshot, Command, CommandRecord, ImpactCommand, Journal, KnownBeamDamage, Lengths,
    Output, ReportOutput, StateOutput, Twin, vehicle_name,
};

/// Maximum number of impacts with a section of their own; of more impacts, the last ones have one.
pub const MAX_SECTIONS: usize = 30;

/// A recording as the origin of a report.
#[derive(Debug, Clone)]
pub struct ReportedRecording {
    /// The recording as the user named it.
    pub path: PathBuf,
    /// Its files.
    pub files: Vec<RecordedFile>,
    /// Name and version of the program that wrote the recording.
    pub written_by: String,
    /// First and last time \[ns\]; `None` without messages.
    pub span: Option<(Nanos, Nanos)>,
    /// What is missing in the recording; `None` if it is complete.
    pub incomplete: Option<String>,
    /// Whether everything in its files can be read.
    pub is_whole: bool,
    /// Messages that the recorder declares as lost; `None`: unknown.
    pub lost: Option<u64>,
    /// What its seal proves.
    pub seal: SealFinding,
    /// The result of the verification, or why there is none.
    pub verification: Result<Verification, String>,
    /// Every impact in the messages of the recording.
    pub events: Vec<EventSummary>,
    /// Impacts with a report that have no section of their own, because there are too many.
    pub without_section: usize,
    /// How fast each vehicle may hit the column next, at the end of the recording; `None` if it is not known there.
    pub critical_velocities: Option<Arc<[VehicleLimits]>>,
    /// The last impacts that the sensors have detected, at most [`MAX_SECTIONS`], each with its estimates in their order.
    pub detected: Vec<DetectedImpact>,
}

/// A file of a recording.
#[derive(Debug, Clone)]
pub struct RecordedFile {
    /// Its name.
    pub name: String,
    /// Its size in bytes and its SHA-256; the error if it cannot be read again.
    pub fingerprint: Result<(u64, String), String>,
}

/// Why there is no report about a recording.
#[derive(Debug, thiserror::Error)]
pub enum RecordedReportError {
    /// The recording cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// It has no such column.
    #[error(transparent)]
    Column(VerifyError),
    /// It is of a fleet, and no column was named.
    #[error(
        "expected the recording of one column, found the recording of a fleet of {columns} in {}; name the column with --column (columns \
         in the recording: {})",
        path.display(),
        evidence::listed_columns(present)
    )]
    Fleet {
        /// The recording.
        path: PathBuf,
        /// Number of its columns.
        columns: usize,
        /// Those of which it has messages.
        present: Vec<String>,
    },
    /// It is not a recording of this program, or nothing happened in it.
    #[error(
        "{} contains no impact: expected messages of type column_twin_msgs/msg/ImpactEvent or column_twin_msgs/msg/ImpactReport, found \
         the topics {topics}; give a recording of column-twin run or of column-twin simulate --record", path.display()
    )]
    NoImpact {
        /// The recording.
        path: PathBuf,
        /// Its topics.
        topics: String,
    },
    /// The named event is not in the recording.
    #[error("expected one of the events {known} of {}, found --event {wanted}", path.display())]
    NoSuchEvent {
        /// The recording.
        path: PathBuf,
        /// As given.
        wanted: String,
        /// The identifiers of the recording, as many as fit into a line.
        known: String,
    },
}

impl ReportDocument {
    /// The report about all impacts of a recording, or about the one with this identifier. The recording of a fleet needs the
    /// `column_id` of one of its columns.
    ///
    /// A recording that cannot be verified, or only in part, still gives a report; the report states what was not verified.
    ///
    /// # Errors
    /// The recording cannot be read, or contains no such impact.
    pub fn of_recording(
        path: &Path,
        column_id: Option<&str>,
        event_id: Option<&str>,
    ) -> Result<Self, RecordedReportError> {
        let reader = recording::open(path)?;
        let mut gathered = Gathered {
            wanted: event_id.map(str::to_owned),
            ..Gathered::default()
        };
        let verification =
            evidence::verify_observed(&reader, column_id, &mut |it| gathered.take(it));
        if let Err(error @ VerifyError::NoSuchColumn { .. }) = verification {
            return Err(RecordedReportError::Column(error));
        }
        if column_id.is_none()
            && let Ok(Verification {
                fleet: Some(fleet),
                columns,
                ..
            }) = &verification
        {
            return Err(RecordedReportError::Fleet {
                path: path.to_path_buf(),
                columns: *fleet,
                present: columns.keys().cloned().collect(),
            });
        }
        let (mut events, _) = recording::summarise_events(&reader)?;
        if let Some(column_id) = column_id {
            events.retain(|event| event.column_id == column_id);
        }
        add_commands(&mut events, &gathered.commands);
        check_events(path, &reader, &events, &gathered.detected, event_id)?;
        let reports = gathered.finished.len();
        let impacts: Vec<_> = gathered
            .finished
            .into_iter()
            .filter_map(Finished::reported)
            .collect();
        let recorded = ReportedRecording {
            path: path.to_path_buf(),
            files: reader
                .files()
                .iter()
                .map(|file| fingerprint(file))
                .collect(),
            written_by: written_by(&reader),
            span: reader.span(),
            incomplete: recording::incompleteness(&reader),
            is_whole: reader.wholeness().is_whole(),
            lost: reader.lost_messages(),
            seal: SealFinding::of(&reader).with_neighbours(&reader),
            verification: verification.map_err(|error: VerifyError| error.to_string()),
            events,
            without_section: gathered.without_section + reports - impacts.len(),
            critical_velocities: gathered.critical_velocities,
            detected: gathered.detected.into(),
        };
        Ok(Self {
            origin: Origin::Recording(Box::new(recorded)),
            impacts,
            details: ReportDetails::default(),
        })
    }
}

/// Adds what only the journal contains: events whose message was not recorded, and what the messages leave open.
fn add_commands(events: &mut Vec<EventSummary>, commands: &[(ImpactCommand, Option<String>)]) {
    let mut places: HashMap<String, usize> = HashMap::new();
    for (place, event) in events.iter().enumerate() {
        places.insert(event.event_id.clone(), place);
    }
    for (command, rejection) in commands {
        let place = *places.entry(command.event_id.clone()).or_insert_with(|| {
            events.push(EventSummary {
                event_id: command.event_id.clone(),
                column_id: command.column_id.clone(),
                rejected: rejection.clone(),
                ..EventSummary::default()
            });
            events.len() - 1
        });
        let event = &mut events[place];
        event.stamp.get_or_insert(command.stamp);
        let given = |number: f64| number.is_finite().then_some(number);
        event.mass = event.mass.or(given(command.impact.mass));
        event.velocity = event.velocity.or(given(command.impact.velocity));
    }
}

fn check_events(
    path: &Path,
    reader: &Reader,
    events: &[EventSummary],
    detected: &VecDeque<DetectedImpact>,
    wanted: Option<&str>,
) -> Result<(), RecordedReportError> {
    const MAX_NAMED: usize = 20;
    if events.is_empty() && detected.is_empty() {
        let topics: Vec<_> = reader.topics().iter().map(|topic| &*topic.name).collect();
        return Err(RecordedReportError::NoImpact {
            path: path.to_path_buf(),
            topics: match topics.is_empty() {
                true => "none".to_owned(),
                false => topics.join(", "),
            },
        });
    }
    let Some(wanted) = wanted else {
        return Ok(());
    };
    let is_detected = detected.iter().any(|it| it.event_id() == Some(wanted));
    if is_detected || events.iter().any(|event| event.event_id == wanted) {
        return Ok(());
    }
    let known: Vec<_> = events.iter().map(|event| event.event_id.as_str()).collect();
    let more = match known.len() > MAX_NAMED {
        true => format!(" and {} more", known.len() - MAX_NAMED),
        false => String::new(),
    };
    Err(RecordedReportError::NoSuchEvent {
        path: path.to_path_buf(),
        wanted: wanted.to_owned(),
        known: known[..known.len().min(MAX_NAMED)].join(", ") + &more,
    })
}

fn fingerprint(file: &Path) -> RecordedFile {
    let read =
        || -> io::Result<(u64, String)> { Ok((file.metadata()?.len(), sha256_of_file(file)?)) };
    RecordedFile {
        name: file
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned(),
        fingerprint: read().map_err(|error| error.to_string()),
    }
}

fn written_by(reader: &Reader) -> String {
    let notes = reader.start_notes();
    let noted = notes.and_then(|it| Some(format!("{} {}", it.get("program")?, it.get("version")?)));
    noted.unwrap_or_else(|| reader.library().to_owned())
}

/// An accepted impact whose report has not come yet.
struct Announced {
    command: ImpactCommand,
    /// The completed impact.
    impact: Option<Impact>,
    /// The column at rest before it; `None` if it was moving.
    before: Option<ColumnSnapshot>,
}

/// An impact with its report.
struct Finished {
    announced: Option<Announced>,
    output: ReportOutput,
    samples: Vec<Sample>,
    lengths: Option<Lengths>,
    parameters: Option<Arc<Parameters>>,
    /// The column at the checkpoint after it.
    after: Option<State>,
    /// The event that took up the response again.
    superseded_by: Option<String>,
}

/// Collects the impacts of a recording while it is verified.
#[derive(Default)]
struct Gathered {
    wanted: Option<String>,
    /// The twin at the last checkpoint, with the changes of parameters since then.
    at_rest: Option<Twin>,
    announced: HashMap<String, Announced>,
    /// Every impact in the journal, with the reason if it was rejected.
    commands: Vec<(ImpactCommand, Option<String>)>,
    /// The states of the response that runs, by their event.
    running: Option<(Arc<str>, Vec<Sample>, Option<Lengths>)>,
    finished: VecDeque<Finished>,
    without_section: usize,
    critical_velocities: Option<Arc<[VehicleLimits]>>,
    detected: VecDeque<DetectedImpact>,
    /// Who has decided about an estimate last.
    decided_by: Option<Arc<str>>,
}

impl Gathered {
    fn take(&mut self, observed: Observed<'_>) {
        match observed {
            Observed::Entry(JournalEntry::Twin(Journal::Checkpoint(checkpoint))) => {
                if let Some(last) = self.finished.back_mut() {
                    last.after.get_or_insert(checkpoint.state);
                }
                self.critical_velocities
                    .clone_from(&checkpoint.critical_velocities);
                self.at_rest = Twin::from_checkpoint(checkpoint, Box::new(monotonic_nanos)).ok();
            }
            Observed::Entry(JournalEntry::Twin(Journal::Command(record))) => self.command(record),
            Observed::Recomputed(Output::State(state)) => self.state(state),
            Observed::Recomputed(Output::Report(output)) => self.report(output),
            Observed::Recomputed(Output::Supplemented(again)) if again.is_result => {
                let output = &again.report;
                let same = |it: &&mut Finished| it.output.event_id == output.event_id;
                if let Some(finished) = self.finished.iter_mut().rev().find(same) {
                    finished.output = output.clone();
                }
            }
            Observed::Recomputed(Output::Estimate(output)) => {
                let mut detected = self.detected.iter_mut().rev();
                let event_id = Some(&*output.record.event_id);
                if let Some(detected) = detected.find(|it| it.event_id() == event_id) {
                    detected.decide(output, &mut self.decided_by);
                }
            }
            Observed::Compared {
                event_id,
                comparisons,
            } => {
                let last = self.detected.back_mut();
                if let Some(detected) = last.filter(|it| it.event_id() == Some(event_id)) {
                    detected.comparisons = comparisons.to_vec();
                }
            }
            Observed::Entry(_) | Observed::Recomputed(_) => {}
        }
    }

    fn command(&mut self, record: &CommandRecord) {
        if let Command::Impact(command) = &record.command {
            let rejection = record.rejection.as_ref().map(ToString::to_string);
            self.commands.push((command.clone(), rejection));
        }
        if record.rejection.is_some() {
            return;
        }
        match &record.command {
            Command::Estimate(estimate) => self.detect(estimate),
            Command::DecideEstimate(decision) => {
                self.decided_by = Some(Arc::clone(&decision.source));
            }
            _ => {}
        }
        if let (Some(impact), Some(estimate)) = (record.impact, self.accepted_estimate(record)) {
            self.announce_estimate(record, impact, &estimate);
        }
        // Whatever else is accepted may change the column.
        self.critical_velocities = match &record.command {
            Command::CriticalVelocities { vehicles } => Some(Arc::clone(vehicles)),
            Command::SecondOpinion(_) | Command::VerdictRange(_) => self.critical_velocities.take(),
            _ => None,
        };
        let is_at_rest = record.position.step.is_none() && !record.taken_back;
        match &record.command {
            Command::Impact(command) => {
                if record.taken_back
                    && let Some(last) = self.finished.back_mut()
                {
                    last.superseded_by = Some(command.event_id.clone());
                }
                let before = self.at_rest.as_ref().filter(|_| is_at_rest);
                let announced = Announced {
                    command: command.clone(),
                    impact: record.impact,
                    before: before.map(Twin::snapshot),
                };
                self.announced.insert(command.event_id.clone(), announced);
            }
            // What has led to an impact is not a change of the column at rest.
            other if is_at_rest && record.impact.is_none() => {
                if let Some(twin) = &mut self.at_rest {
                    // Without effect if it is rejected, and it was accepted when it was recorded.
                    let _ = twin.handle(other.clone(), record.now, &mut Vec::new());
                }
            }
            _ => {}
        }
    }

    /// The estimate that has become the impact of a command, or has replaced it.
    fn accepted_estimate(&self, record: &CommandRecord) -> Option<Arc<EstimateRecord>> {
        match &record.command {
            Command::Estimate(estimate) => Some(Arc::clone(estimate)),
            Command::DecideEstimate(_) => self.detected.back()?.estimates.last().cloned(),
            _ => None,
        }
    }

    /// Takes the impact that an estimate has become, on the column before the first one.
    fn announce_estimate(
        &mut self,
        record: &CommandRecord,
        impact: Impact,
        estimate: &EstimateRecord,
    ) {
        let event_id = estimate.event_id.to_string();
        let is_same = |it: &&Finished| *it.output.event_id == *event_id;
        let finished = self.finished.back().filter(is_same);
        let earlier = self.announced.get(&event_id);
        let earlier = earlier.or(finished.and_then(|it| it.announced.as_ref()));
        let is_at_rest = record.position.step.is_none() && !record.taken_back;
        let before = match earlier {
            Some(earlier) => earlier.before.clone(),
            None => {
                let at_rest = self.at_rest.as_ref().filter(|_| is_at_rest);
                at_rest.map(Twin::snapshot)
            }
        };
        let contact = estimate.estimate.contact_time.mean;
        let command = ImpactCommand {
            event_id: event_id.clone(),
            column_id: String::new(),
            stamp: estimate
                .origin
                .saturating_add((1e9 * contact).round() as i64),
            vehicle: vehicle_name(estimate).to_string(),
            impact: ImpactSpecification {
                mass: impact.mass,
                velocity: impact.velocity,
                gap: Some(impact.gap),
                restitution: Some(impact.restitution),
                height: None,
                // The sensors say what happened in the plane of the two bars.
                direction: Some(0.0),
            },
        };
        if earlier.is_none() {
            self.commands.push((command.clone(), None));
        }
        let announced = Announced {
            command,
            impact: Some(impact),
            before,
        };
        self.announced.insert(event_id, announced);
    }

    /// Takes an estimate: another one of the last impact that was detected, or the first one of the next.
    fn detect(&mut self, record: &Arc<EstimateRecord>) {
        let is_other = |wanted: &str| *wanted != *record.event_id;
        if self.wanted.as_deref().is_some_and(is_other) {
            return;
        }
        let event_id = Some(&*record.event_id);
        match self
            .detected
            .back_mut()
            .filter(|it| it.event_id() == event_id)
        {
            Some(detected) => {
                detected.estimates.push(Arc::clone(record));
                detected.comparisons.clear();
            }
            None => {
                let parameters = self.at_rest.as_ref();
                let sensors = parameters.map(|twin| twin.parameters().sensors());
                self.detected.push_back(DetectedImpact {
                    estimates: vec![Arc::clone(record)],
                    decisions: Vec::new(),
                    sensors: sensors.unwrap_or_default(),
                    comparisons: Vec::new(),
                });
            }
        }
        if self.detected.len() > MAX_SECTIONS {
            self.detected.pop_front();
        }
    }

    fn state(&mut self, state: &StateOutput) {
        if !matches!(&self.running, Some((event_id, ..)) if *event_id == state.event_id) {
            self.running = Some((Arc::clone(&state.event_id), Vec::new(), state.lengths));
        }
        if let Some((_, samples, _)) = &mut self.running {
            // A response that was taken up again repeats its last states.
            while samples
                .last()
                .is_some_and(|last| last.time >= state.sample.time)
            {
                samples.pop();
            }
            samples.push(state.sample);
        }
    }

    fn report(&mut self, output: &ReportOutput) {
        let announced = self.announced.remove(&*output.event_id);
        let running = self.running.take();
        if self
            .wanted
            .as_deref()
            .is_some_and(|wanted| *wanted != *output.event_id)
        {
            return;
        }
        let (samples, lengths) = running
            .filter(|(event_id, ..)| *event_id == output.event_id)
            .map_or((Vec::new(), None), |(_, samples, lengths)| {
                (samples, lengths)
            });
        // A later estimate of the same impact has another report.
        self.finished
            .retain(|it| it.output.event_id != output.event_id);
        self.finished.push_back(Finished {
            announced,
            output: output.clone(),
            samples,
            lengths,
            parameters: self
                .at_rest
                .as_ref()
                .map(|twin| Arc::clone(twin.parameters())),
            after: None,
            superseded_by: None,
        });
        if self.finished.len() > MAX_SECTIONS {
            self.finished.pop_front();
            self.without_section += 1;
        }
    }
}

/// Relative difference of two peaks of the beam that are the same, of which one is that of a thinned course.
const SAME_PEAK: f64 = 1e-3;

/// Name of the vehicle that hits: the event's, or that of the parameters.
fn vehicle_of<'n>(command: &'n ImpactCommand, parameters: &'n Parameters) -> &'n str {
    match command.vehicle.as_str() {
        "" => &parameters.settings().vehicle.name,
        name => name,
    }
}

impl Finished {
    /// The impact computed again in every step from the column before it or, where that is not known, as it was published.
    fn reported(self) -> Option<ReportedImpact> {
        let mut reported = self.recomputed().or_else(|| self.published())?;
        let assessed = self.output.assessed.as_ref();
        reported.second_opinion = assessed.and_then(|it| it.second_opinion.clone());
        reported.beam = self.movement(&reported);
        // Where the movement is not that of the recorded opinion, the damage is not, either.
        let before = self.announced.as_ref().and_then(|it| it.before.as_ref());
        let damage = before.map(ColumnSnapshot::beam_damage);
        let is_known = |it: &&KnownBeamDamage| reported.beam.is_some() || it.is_undamaged();
        reported.beam_before = damage.filter(is_known).cloned();
        reported.event = Some((self.output.event_id.to_string(), self.output.stamp));
        if let Some(later) = &self.superseded_by {
            reported.remarks.push(format!(
                "Impact \"{later}\" hit the column before this response was over, and was announced afterwards: this outcome no \
                 longer holds."
            ));
        }
        Some(reported)
    }

    fn recomputed(&self) -> Option<ReportedImpact> {
        let Announced {
            command, before, ..
        } = self.announced.as_ref()?;
        let before = before.as_ref()?;
        let (model, state, response) = before.struck(&command.vehicle, &command.impact).ok()?;
        let impact = state.impactor?.impact;
        let struck = Struck {
            model,
            state,
            response,
        };
        let parameters = Arc::clone(before.parameters());
        let vehicle = vehicle_of(command, before.parameters());
        let reported = ReportedImpact::computed(
            parameters,
            vehicle,
            impact,
            (
                self.output.striking.velocity(),
                self.output.striking.direction(),
            ),
            &struck,
        )
        .ok()?;
        // Otherwise the beginning was not that of the recorded response.
        (reported.report == self.output.report).then_some(reported)
    }

    /// How the beam moved by the recorded second opinion.
    fn movement(&self, reported: &ReportedImpact) -> Option<Movement> {
        let opinion = reported.second_opinion.as_ref()?;
        let before = self.announced.as_ref()?.before.as_ref()?;
        let movement = before.movement(&reported.model.properties, &self.output.striking)?;
        let before_it = movement.points.first().map_or(0.0, |point| point[1]);
        let found = movement.largest()[1] - before_it;
        let expected = opinion.beam.max_displacement_m;
        // Otherwise the damage before it was not that of the recorded hit.
        ((found - expected).abs() <= SAME_PEAK * expected).then_some(movement)
    }

    fn published(&self) -> Option<ReportedImpact> {
        let Self {
            announced,
            output,
            samples,
            lengths,
            parameters,
            after,
            ..
        } = self;
        let parameters = Arc::clone(parameters.as_ref()?);
        let mut properties = parameters.column_properties();
        if let Some(lengths) = lengths {
            (properties.length_below, properties.length_above) = (lengths.below, lengths.above);
        }
        let model = Model::new(&properties).ok()?;
        let announced = announced.as_ref()?;
        let impact = announced.impact?;
        let vehicle = vehicle_of(&announced.command, &parameters);
        let (velocity, direction) = (output.striking.velocity(), output.striking.direction());
        let mut thinning = HistoryThinning::new(samples.len() as u64, output.report.end_time);
        samples.iter().for_each(|sample| thinning.push(sample));
        let samples = thinning.finish();
        if samples.is_empty() {
            return None;
        }
        let rate = parameters.settings().publish_rate;
        let why = match announced.before {
            None => "The column was still moving when this impact began.",
            Some(_) => {
                "The response cannot be computed again from the vehicle's name and numbers alone."
            }
        };
        Some(ReportedImpact {
            title: words::title(
                &parameters,
                vehicle,
                &Impact { velocity, ..impact },
                properties.length_below,
                direction,
            ),
            event: None,
            vehicle: vehicle.to_owned(),
            impact,
            velocity,
            direction,
            model,
            samples,
            report: output.report,
            // Published states are too far apart for it.
            spectrum: None,
            settled: after.filter(|_| output.report.residual_v1.is_some()),
            struck: None,
            second_opinion: None,
            beam: None,
            beam_before: None,
            remarks: vec![format!(
                "{why} The histories have the values that were published, at most {rate} per second, which are too few for the \
                 contact force spectrum; the error of the time step was not estimated."
            )],
            parameters,
        })
    }
}
