//! Estimates that are computed again from the measurements of the recording.

use std::sync::Arc;

use column_twin::estimation::{EstimateRecord, EventEvidence, Readings, Sensing, Work};
use column_twin::evidence::{JournalLine, Verification, verify};
use column_twin::messages::builtin_interfaces::Time;
use column_twin::messages::cdr;
use column_twin::messages::column_twin_msgs::Measurement;
use column_twin::messages::std_msgs::{self, Header};
use column_twin::parameters::{RecordMode, Value};
use column_twin::recording::RecorderOptions;
use column_twin::report::ReportDocument;
use column_twin::standing::StandingColumn;
use column_twin::time::Nanos;
use column_twin::twin::Command;

use super::copies::{messages, written};
use super::estimates::{changed_estimate, first_field};
use super::recorded_twin::{Finished, MS, RecordedTwin};
use super::signals::{Signal, with_sensors};

/// Columns of the signal: acceleration and displacement of the impact point, strain near the base.
const CHOSEN: [usize; 3] = [1, 3, 4];

/// Samples of a batch: 10 ms.
const SAMPLES: usize = 100;

/// Time from the last sample of a batch to its arrival.
const TRANSPORT: Nanos = 2 * MS;

/// Slices of refinement while a batch arrives.
const SLICES: usize = 3;

/// The sensors of a recorded twin, and the estimation of what they detect.
struct Detected {
    twin: RecordedTwin,
    names: Vec<String>,
    sensing: Sensing,
    /// Number of the next batch, and those that the estimation does not get.
    next: u64,
    lost: Vec<u64>,
}

impl Detected {
    fn new(
        signal: &Signal,
        options: impl FnOnce(RecorderOptions) -> RecorderOptions,
    ) -> (Self, Readings) {
        let (sensors, readings) = signal.readings(&CHOSEN, 3);
        let changes = [
            ("solver.dt", Value::from(1e-4)),
            ("state.directory", Value::from("")),
            ("assessment.ultimate_rotation", Value::from(0.0)),
            ("estimation.accept", Value::from("automatic")),
        ];
        let parameters = with_sensors(&signal.parameters(), &sensors);
        let parameters = parameters.with_changes(changes).expect("admissible");
        let twin = RecordedTwin::with_options(parameters, RecordMode::Always, options);
        let parameters = twin.twin.parameters();
        let column = StandingColumn::undamaged(parameters);
        let detected = Self {
            sensing: Sensing::new(parameters, column).expect("sensors"),
            twin,
            names: sensors.into_iter().map(|it| it.name).collect(),
            next: 0,
            lost: Vec::new(),
        };
        (detected, readings)
    }

    /// The sensors read these rows, and the recording has what `change` makes of them.
    fn measure(&mut self, rows: &[(f64, &[f64])], change: impl Fn(u64, &mut Measurement)) {
        let stamp = self.twin.now;
        let duration = rows.len() as Nanos * MS / 10;
        self.twin.advance(duration + TRANSPORT);
        for (sensor, name) in self.names.iter().enumerate() {
            let message = Measurement {
                header: Header {
                    stamp: Time::from_nanos(stamp).expect("a stamp"),
                    frame_id: String::new(),
                },
                column_id: self.twin.twin.column_id().to_string(),
                sensor_id: name.clone(),
                sample_period: 1e-4,
                values: rows.iter().map(|(_, it)| it[sensor] as f32).collect(),
            };
            let mut recorded = message.clone();
            change(self.next, &mut recorded);
            let batch = self.twin.measure_but_record(&message, &recorded);
            if !self.lost.contains(&self.next) {
                self.sensing.push(self.next, batch);
            }
            self.next += 1;
        }
        self.work(SLICES);
        // The next batch follows this one.
        self.twin.now -= TRANSPORT;
    }

    fn work(&mut self, mut slices: usize) {
        loop {
            match self.sensing.step() {
                Work::More { is_urgent: true } => {}
                Work::More { is_urgent: false } if slices > 0 => slices -= 1,
                Work::Estimate(record) => self.twin.execute(Command::Estimate(Arc::from(record))),
                Work::More { .. } | Work::Idle => return,
                Work::Missed(reason) => panic!("{reason}"),
            }
        }
    }

    /// An impact from a second before it to its final estimate, and the rest of the column after it.
    fn play(&mut self, readings: &Readings, change: &dyn Fn(u64, &mut Measurement)) {
        let rows: Vec<(f64, &[f64])> = readings.rows().collect();
        for _ in 0..160 {
            self.measure(&rows[..SAMPLES], change);
        }
        for rows in rows.chunks(SAMPLES) {
            self.measure(rows, change);
        }
        self.sensing.note_time(self.twin.now + 2_000 * MS);
        self.work(usize::MAX);
        self.twin.until_rest();
        self.twin.advance(1_200 * MS);
    }

    fn play_twice(&mut self, readings: &Readings, change: &dyn Fn(u64, &mut Measurement)) {
        self.play(readings, change);
        let snapshot = self.twin.twin.snapshot();
        let column = snapshot.standing().expect("it stands").expect("at rest");
        let parameters = Arc::clone(self.twin.twin.parameters());
        let followed = self.sensing.set_column(&parameters, column);
        followed.expect("a column");
        self.play(readings, change);
    }
}

/// Two impacts of the signal.
pub fn recorded(lost: &[u64], change: &dyn Fn(u64, &mut Measurement)) -> Finished {
    let signal = Signal::read("s02_rigid_10");
    let (mut detected, readings) = Detected::new(&signal, |options| options);
    detected.lost = lost.to_vec();
    detected.play_twice(&readings, change);
    detected.twin.finish()
}

fn assert_computed_again(found: &Verification) {
    assert!(found.is_equal(), "{found}");
    assert!(found.estimates.compared > 5, "{found}");
    assert_eq!(found.estimates.differing, 0, "{found}");
    assert_eq!(
        found.estimates.compared, found.estimates.recorded,
        "{found}"
    );
    assert_eq!(found.unchecked, Vec::<String>::new(), "{found}");
}

#[test]
fn estimates_are_computed_again_bit_for_bit_and_forged_records_are_found() {
    let original = recorded(&[], &|_, _| {});
    let found = original.verify();
    println!("{found}");
    assert_computed_again(&found);

    // A recording that begins with a checkpoint between the two impacts, as after a rotation.
    let all = messages(&original.path());
    let is_checkpoint = |it: &column_twin::recording::Message| {
        it.topic.ends_with("/journal")
            && JournalLine::decode(&it.data)
                .expect("a line")
                .is_checkpoint()
    };
    let is_estimate = |it: &column_twin::recording::Message| it.topic.ends_with("/impact_estimate");
    let estimates: Vec<_> = (0..all.len()).filter(|it| is_estimate(&all[*it])).collect();
    let middle = estimates[estimates.len() / 2];
    let mut places = (0..all.len()).filter(|it| is_checkpoint(&all[*it]));
    let begin = places.clone().rfind(|it| *it < middle);
    let (_directory, path) = written(&all[begin.expect("a checkpoint")..]);
    let later = verify(&path).expect("can be verified");
    assert_computed_again(&later);
    assert!(
        later.estimates.recorded < found.estimates.recorded,
        "{later}"
    );

    let forged = |update: u32, change: fn(&mut EstimateRecord)| {
        let found = changed_estimate(&original, update, change);
        assert!(found.estimates.differing > 0, "{found}");
        first_field(&found).to_owned()
    };
    let field = forged(2, |it| {
        it.estimate.mass.mean = it.estimate.mass.mean.next_up()
    });
    assert_eq!(field, "recorded estimate: estimate.mass.mean");
    let field = forged(1, |it| it.best.velocity = it.best.velocity.next_down());
    assert_eq!(field, "recorded estimate: best.velocity");
    let field = forged(1, |it| it.prepared -= 1);
    assert_eq!(field, "recorded estimate: prepared");
    let field = forged(2, |it| it.origin += 1);
    assert_eq!(field, "recorded estimate: origin");
    let field = forged(2, |it| it.detection.contact.deviation *= 2.0);
    assert_eq!(field, "recorded estimate: detection.contact.deviation");
    // An event that nobody has sent.
    let field = forged(2, |it| {
        it.events.push(EventEvidence {
            event_id: "camera".into(),
            mass: 1500.0,
            mass_deviation: 0.3,
            velocity: 10.0,
            velocity_deviation: 0.15,
        });
    });
    assert!(field.starts_with("recorded estimate: "), "{field}");
    // The last checkpoint tells of ten times as many batches, and more.
    let last = places.next_back().expect("a checkpoint");
    let mut changed = all.clone();
    let mut text: std_msgs::String = cdr::decode(&changed[last].data).expect("a text");
    let counted = "\"channels\":[{\"batches\":";
    assert!(text.data.contains(counted));
    text.data = text.data.replacen(counted, &format!("{counted}1"), 1);
    changed[last].data = cdr::encode(&text).expect("bytes");
    let (_directory, path) = written(&changed);
    let found = verify(&path).expect("can be verified");
    assert_eq!(first_field(&found), "intake.channels[0].batches");

    let field = forged(3, |it| it.batches += 10_000);
    assert_eq!(field, "recorded estimate");
    let field = forged(3, |it| it.batches -= 3);
    assert!(field.starts_with("recorded estimate: "), "{field}");
}

/// The environment variable `COLUMN_TWIN_KEEP_REPORTS` names a folder that keeps the report.
#[test]
fn a_report_shows_what_each_sensor_has_read_against_what_the_last_estimate_predicts() {
    let html = |recording: &Finished| {
        let document = ReportDocument::of_recording(&recording.path(), None, None);
        document.expect("a report").html().expect("figures")
    };
    let shown = html(&recorded(&[], &|_, _| {}));
    if let Some(folder) = std::env::var_os("COLUMN_TWIN_KEEP_REPORTS") {
        let path = std::path::Path::new(&folder).join("detected_recording.html");
        std::fs::write(path, &shown).expect("a folder");
    }
    let unknown = "The prediction of the last estimate for each sensor is not known";
    for sensor in ["a_impact", "v1", "bend_base"] {
        // One for each of the two impacts.
        let title = format!("Sensor {sensor}: measured and predicted");
        assert_eq!(shown.matches(&title).count(), 2, "{sensor}");
        let caption =
            format!("Readings of {sensor} and their prediction by the weighted responses");
        assert!(shown.contains(&caption), "{sensor}");
    }
    assert!(!shown.contains(unknown));

    // An estimate that rests on a batch which was lost is not computed again, and nor are the later ones of its impact.
    let lost = html(&recorded(&[3 * 163 + 2], &|_, _| {}));
    assert_eq!(lost.matches(unknown).count(), 1);
    let title = "Sensor v1: measured and predicted";
    assert_eq!(lost.matches(title).count(), 1);
}

#[test]
fn a_forged_measurement_is_found_although_its_digest_fits() {
    // The batch of the laser with the peak of the first impact.
    const BATCH: u64 = 3 * 166 + 1;
    let found = recorded(&[], &|number, it| {
        if number == BATCH {
            it.values[50] *= 1.1;
        }
    })
    .verify();
    assert!(found.estimates.differing > 0, "{found}");
    let field = first_field(&found);
    assert!(field.starts_with("recorded estimate: "), "{field}");
}

#[test]
fn estimates_on_lost_batches_are_no_differences() {
    let found = recorded(&[3 * 163 + 2], &|_, _| {}).verify();
    assert!(found.is_equal(), "{found}");
    assert!(found.estimates.unchecked > 0, "{found}");
    assert!(found.estimates.compared > 0, "{found}");
    assert_eq!(found.estimates.differing, 0, "{found}");
    let says = |it: &String| it.contains("1 batches of measurements were lost");
    assert!(found.unchecked.iter().any(says), "{found}");
}

#[test]
fn measurements_that_could_not_be_recorded_are_no_differences() {
    let signal = Signal::read("s02_rigid_10");
    // A batch of so many values exceeds the queue of the recorder, everything else together does not, however slowly it is written.
    const LARGE: usize = 65_536;
    let (mut detected, readings) = Detected::new(&signal, |options| RecorderOptions {
        // Each value has four bytes.
        queue_bytes: 3 * LARGE,
        ..options
    });
    let nothing = vec![f64::NAN; CHOSEN.len()];
    let rows = vec![(0.0, nothing.as_slice()); LARGE];
    detected.measure(&rows, |_, _| {});
    detected.play_twice(&readings, &|_, _| {});
    let found = detected.twin.finish_with_loss(CHOSEN.len() as u64).verify();
    assert!(found.is_equal(), "{found}");
    // The checkpoint after the first impact tells how the intake was.
    assert!(found.estimates.unchecked > 0, "{found}");
    assert!(found.estimates.compared > 0, "{found}");
    let says = |it: &String| it.contains("measurements that the node took could not be recorded");
    assert!(found.unchecked.iter().any(says), "{found}");
}
