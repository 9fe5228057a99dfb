//! Recordings of a fleet in the viewer: one of its columns is shown as a single twin is.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use arrow_array::{Array as _, ArrayRef};
use column_twin::column::ImpactSpecification;
use column_twin::evidence::{JournalEntry, JournalLine};
use column_twin::parameters::{Parameters, RecordMode, Value};
use column_twin::recording::Message;
use column_twin::twin::{Command, ImpactCommand, Journal};
use column_twin::viewer::WALL_CLOCK;
use rerun::external::re_log_encoding::DecoderApp;
use rerun::external::re_log_types::{LogMsg, StoreKind};
use rerun::log::Chunk;

use super::commands::typed;
use super::copies::{messages, written};
use super::recomputed_estimates::recorded;
use super::recorded_twin::{MS, RecordedTwin, event, parameters, the_one_recording};
use super::scripted_fleet::ScriptedFleet;

const SECOND: i64 = 1_000_000_000;

/// Longer than a response \[ms\].
const LONGEST: i64 = 300;

/// Columns whose responses are short, with a height that is not that of other columns.
fn columns() -> Parameters {
    let values = [
        ("publish_rate", Value::from(500.0)),
        ("response.duration", Value::from(0.08)),
        ("geometry.length_above", Value::from(2.1)),
    ];
    parameters().with_changes(values).expect("admissible")
}

/// Two hits on a column, the second one after its top load has been changed, and a hit on another while the first one moves.
fn fleet() -> tempfile::TempDir {
    let mut fleet = ScriptedFleet::new(4, &columns(), RecordMode::Events);
    fleet.hit(1, hit("a", "c1", fleet.now));
    (0..5).for_each(|_| fleet.advance(MS));
    // The same identifier as that of the other column: both are in the same recording.
    fleet.hit(0, hit("a", "c0", fleet.now));
    (0..LONGEST).for_each(|_| fleet.advance(MS));
    assert!(!fleet.is_responding());
    fleet.advance(SECOND);
    fleet.execute(1, top_load());
    fleet.execute(3, top_load());
    fleet.advance(SECOND);
    fleet.hit(1, hit("b", "c1", fleet.now));
    fleet.until_rest();
    fleet.finish()
}

/// What happens to `c1` in [`fleet`], of a twin of its own.
fn twin() -> RecordedTwin {
    let own = [("column_id", Value::from("c1"))];
    let mut twin = RecordedTwin::with_mode(
        columns().with_changes(own).expect("admissible"),
        RecordMode::Events,
    );
    twin.hit(hit("a", "c1", twin.now));
    (0..5).for_each(|_| twin.advance(MS));
    (0..LONGEST).for_each(|_| twin.advance(MS));
    twin.advance(SECOND);
    twin.execute(top_load());
    twin.advance(SECOND);
    twin.hit(hit("b", "c1", twin.now));
    twin.until_rest();
    twin.advance(MS);
    twin
}

fn top_load() -> Command {
    Command::SetParameters {
        changes: vec![("top.load".to_owned(), Value::from(2e5))],
        source: "test".into(),
    }
}

/// Each column is hit at another speed.
fn hit(id: &str, column: &str, stamp: i64) -> ImpactCommand {
    let event = event(id, stamp);
    let velocity = if column == "c1" { 5.0 } else { 3.0 };
    ImpactCommand {
        column_id: column.to_owned(),
        impact: ImpactSpecification {
            velocity,
            height: Some(1.3),
            ..event.impact
        },
        ..event
    }
}

/// What a file for the viewer has, by entity: the times on each timeline, and the values of each component in the order in which
/// they were written.
#[derive(Debug, Default, PartialEq)]
struct Shown {
    times: BTreeMap<(String, String), Vec<i64>>,
    values: BTreeMap<(String, String), Vec<ArrayRef>>,
}

impl Shown {
    fn read(path: &Path) -> Self {
        let mut shown = Self::default();
        let file = BufReader::new(File::open(path).expect("readable"));
        for message in DecoderApp::decode_eager(file).expect("a file of Rerun") {
            let LogMsg::ArrowMsg(store, data) = message.expect("whole") else {
                continue;
            };
            if store.kind() != StoreKind::Recording {
                continue;
            }
            let chunk = Chunk::from_arrow_msg(&data).expect("a chunk");
            let entity = chunk.entity_path().to_string();
            // When the program ran.
            if entity.starts_with("/__properties") {
                continue;
            }
            for (name, timeline) in chunk.timelines() {
                // When the data were written.
                if name.as_str() == "log_time" || name.as_str() == "log_tick" {
                    continue;
                }
                let key = (entity.clone(), name.to_string());
                shown
                    .times
                    .entry(key)
                    .or_default()
                    .extend(timeline.times_raw());
            }
            for (component, column) in chunk.components().iter() {
                let key = (entity.clone(), component.to_string());
                let rows = shown.values.entry(key).or_default();
                for row in 0..column.list_array.len() {
                    rows.push(column.list_array.value(row));
                }
            }
        }
        shown
    }

    fn entities(&self) -> BTreeSet<&str> {
        self.values.keys().map(|it| it.0.as_str()).collect()
    }
}

/// What the file has that `replay` writes with these options.
fn shown(folder: &Path, bag: &Path, options: &str) -> Shown {
    let line = format!("replay {} --rrd shown.rrd{options}", bag.display());
    let (code, stdout, stderr) = typed(folder, &line);
    assert_eq!((code, stderr.as_str()), (0, ""), "{line}");
    assert_eq!(stdout, "rerun shown.rrd\n");
    Shown::read(&folder.join("shown.rrd"))
}

#[test]
fn a_column_of_a_fleet_is_shown_as_a_single_twin_is() {
    let folder = tempfile::tempdir().expect("a folder");
    let (fleet, twin) = (fleet(), twin().finish());
    let of_fleet = the_one_recording(fleet.path());
    let show = |bag: &Path, options: &str| shown(folder.path(), bag, options);
    let own = show(&twin.path(), "");
    for entity in ["/column/steel", "/plots/energy", "/log", "/panel"] {
        assert!(own.entities().contains(entity), "{:?}", own.entities());
    }
    let column = show(&of_fleet, " --column c1");
    assert_eq!(column.entities(), own.entities());
    assert_eq!(column.times, own.times);
    for (key, values) in &own.values {
        assert_eq!(&column.values[key], values, "{key:?}");
    }
    // The same name is right for the recording of a single twin.
    assert_eq!(show(&twin.path(), " --column c1"), own);
    // The other column has had an impact of its own.
    let other = show(&of_fleet, " --column c0");
    let energy =
        |it: &Shown| it.times[&("/plots/energy".to_owned(), WALL_CLOCK.to_owned())].clone();
    assert!(!energy(&other).is_empty());
    assert_ne!(energy(&other), energy(&own));
}

#[test]
fn a_column_that_cannot_be_shown_is_an_error_that_names_those_that_can() {
    let folder = tempfile::tempdir().expect("a folder");
    let (fleet, twin) = (fleet(), twin().finish());
    let (of_fleet, of_twin) = (the_one_recording(fleet.path()), twin.path());
    let with_states = r#"columns with states: "c0", "c1")"#;
    for (bag, options, expected) in [
        (
            &of_fleet,
            "",
            vec!["found 4 columns", "--column", with_states],
        ),
        (
            &of_fleet,
            " --column c9",
            vec![r#"("c0", "c1", "c2", "c3"), found "c9""#],
        ),
        // Nothing has happened to it.
        (
            &of_fleet,
            " --column c2",
            vec![r#"nothing of column "c2" to show"#, with_states],
        ),
        // Its parameters were changed, and nothing else.
        (
            &of_fleet,
            " --column c3",
            vec![r#"nothing of column "c3" to show"#, with_states],
        ),
        (&of_twin, " --column c9", vec![r#"("c1"), found "c9""#]),
    ] {
        for show in ["--rrd shown.rrd", "--serve"] {
            let line = format!("replay {} {show}{options}", bag.display());
            let (code, stdout, stderr) = typed(folder.path(), &line);
            assert_eq!((code, stdout.as_str()), (2, ""), "{line}: {stderr}");
            // The error is broken into lines, which begin with a mark.
            let words = stderr.replace('│', " ");
            let text = words.split_whitespace().collect::<Vec<_>>().join(" ");
            for part in &expected {
                assert!(text.contains(part), "{line}: {stderr}");
            }
        }
    }
    assert!(!folder.path().join("shown.rrd").exists());
    // Only what is shown is chosen.
    let line = format!("replay {} --column c1", of_fleet.display());
    assert_eq!(typed(folder.path(), &line).0, 2);
}

/// The messages of a single twin with sensors as those of a column of a fleet, whose journal tells of the sensors in a line of their
/// own.
fn as_of_fleet(of_twin: Vec<Message>, column_id: &str) -> Vec<Message> {
    let mut of_fleet = Vec::new();
    let mut has_begun = false;
    for message in of_twin {
        if !message.topic.ends_with("/journal") {
            of_fleet.push(message);
            continue;
        }
        let mut line = JournalLine::decode(&message.data).expect("a line");
        let mut push = |line: JournalLine| {
            let data = line.encode().expect("a line");
            of_fleet.push(Message {
                data,
                ..message.clone()
            });
        };
        if let (JournalEntry::Twin(Journal::Checkpoint(start)), false) = (&line.entry, has_begun) {
            has_begun = true;
            let sensors = start.parameters.sensors();
            let mut of_sensors = line.clone().of_column(Some(column_id));
            of_sensors.entry = JournalEntry::Sensors { sensors };
            let mut list = line.clone();
            list.entry = JournalEntry::Fleet {
                columns: [column_id, "other"].map(Into::into).into(),
            };
            list.intake = None;
            push(list);
            push(of_sensors);
        }
        line.intake = None;
        push(line.of_column(Some(column_id)));
    }
    of_fleet
}

/// The stamps of the measurements are those of a simulated clock, and the recording goes by that of the system: readings that are
/// judged by the time of the recording are not shown.
#[test]
fn what_the_sensors_of_a_column_of_a_fleet_have_read_is_shown() {
    let folder = tempfile::tempdir().expect("a folder");
    let twin = recorded(&[], &|_, _| ());
    let own = shown(folder.path(), &twin.path(), "");
    let all = messages(&twin.path());
    let column_id = all.iter().find_map(|it| {
        let line = JournalLine::decode(&it.data).ok()?;
        match line.entry {
            JournalEntry::Twin(Journal::Checkpoint(it)) => {
                Some(it.parameters.settings().column_id.clone())
            }
            _ => None,
        }
    });
    let column_id = column_id.expect("a checkpoint");
    let (_directory, of_fleet) = written(&as_of_fleet(all, &column_id));
    let column = shown(folder.path(), &of_fleet, &format!(" --column {column_id}"));
    let read = own.times.iter().filter(|((entity, _), times)| {
        entity.starts_with("/detected/sensors/")
            && entity.ends_with("/measured")
            && !times.is_empty()
    });
    let sensors: BTreeSet<_> = read.map(|((entity, _), _)| entity).collect();
    assert_eq!(sensors.len(), 3, "{sensors:?}");
    assert_eq!(column.entities(), own.entities());
    assert!(column == own);
}
