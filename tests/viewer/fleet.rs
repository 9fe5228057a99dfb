//! A fleet in the viewer: what a file contains of it, and with the real viewer what can be seen.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use column_twin::assessment::Action;
use column_twin::column::ImpactSpecification;
use column_twin::estimation::Batch;
use column_twin::fleet::make_twins;
use column_twin::live::{
    Clock, FleetHandle, FleetOptions, LiveFleet, RealTime, Receiver, SystemClock,
};
use column_twin::messages::column_twin_msgs::ImpactEstimate;
use column_twin::parameters::{FleetColumn, Parameters, Value, parse_override};
use column_twin::shape::action_colour;
use column_twin::time::Nanos;
use column_twin::twin::{Command, ImpactCommand, Output};
use column_twin::viewer::{
    ColumnMark, DetectedUpdate, FleetItem, FleetStream, IMPACT_TIME, LiveViewer, Shown, ShownFleet,
    VIEWER_QUEUE, ViewerItem, ViewerLogger, output_queue,
};
use rerun::external::re_log_encoding::DecoderApp;
use rerun::external::re_log_types::LogMsg;
use rerun::log::Chunk;

use super::detected::{self, rows};
use super::in_memory;
use super::real_viewer::{photograph, pixels, printed};
use super::twin::{MS, PATIENCE};
use super::wheel::program;

/// Most pictures that are taken of a file until one shows all of it.
const MAX_PICTURES: usize = 10;

/// Columns in rows of ten, six metres apart, whose responses are short.
fn columns(count: usize) -> Vec<FleetColumn> {
    let column = |number: usize| {
        let name = format!("c{number}");
        let values = [
            ("column_id", Value::from(name.as_str())),
            ("site.x", Value::from(6.0 * (number % 10) as f64)),
            ("site.y", Value::from(6.0 * (number / 10) as f64)),
            ("solver.dt", Value::from(1e-4)),
            ("response.duration", Value::from(0.2)),
        ];
        FleetColumn {
            name: format!("/hall/{name}"),
            parameters: Arc::new(Parameters::from_values(values).expect("admissible")),
        }
    };
    (0..count).map(column).collect()
}

/// Waits for an output of a column.
fn wait_for(outputs: &mut Receiver, column: u32, mut is: impl FnMut(&Output) -> bool) {
    let given_up = Instant::now() + PATIENCE;
    loop {
        assert!(Instant::now() < given_up, "nothing of column {column}");
        match outputs.try_next_of() {
            Some((of, output)) if of == column && is(&output) => return,
            Some(_) => {}
            None => outputs.wait(Duration::from_millis(10)),
        }
    }
}

/// Waits until every column has given its first status: before, the viewer knows nothing of it.
fn wait_for_first_statuses(outputs: &mut Receiver, count: usize) {
    let given_up = Instant::now() + PATIENCE;
    let mut known = vec![false; count];
    while known.contains(&false) {
        assert!(Instant::now() < given_up, "a column has no status");
        match outputs.try_next_of() {
            Some((of, Output::Status(_))) => known[of as usize] = true,
            Some(_) => {}
            None => outputs.wait(Duration::from_millis(10)),
        }
    }
}

/// Lets something happen to a fleet, and returns the file that the viewer's thread has written meanwhile.
fn file_during(
    folder: &Path,
    columns: &[FleetColumn],
    selected: Vec<u32>,
    happen: impl FnOnce(&FleetHandle, &mut Receiver, Nanos),
) -> PathBuf {
    let count = columns.len();
    let clock = Arc::new(SystemClock::new());
    let twins = make_twins(columns, &[], || 0, clock.now()).expect("stand");
    let options = FleetOptions {
        real_time: RealTime::none(),
        threads: 1,
        state_files: Vec::new(),
        journals: false,
        further_outputs: vec![output_queue(count)],
    };
    let (handle, mut outputs) = LiveFleet::start(twins, clock.clone(), options).expect("starts");
    let directory = folder.to_str().expect("a name");
    let node = Parameters::from_values([
        ("viewer.mode", Value::from("save")),
        ("viewer.directory", Value::from(directory)),
    ]);
    let log: ViewerLogger = Arc::new(|level, text| println!("{level:?}: {text}"));
    let viewer = LiveViewer::start(
        &node.expect("admissible"),
        Shown::Fleet(ShownFleet::new(columns, selected)),
        handle.outputs(VIEWER_QUEUE).expect("there"),
        handle.measurements().cloned(),
        clock.now(),
        log,
    );
    let viewer = viewer.expect("starts").expect("it is on");
    wait_for_first_statuses(&mut outputs, count);
    happen(&handle, &mut outputs, clock.now());
    handle.stop().expect("no panic");
    viewer.stop();
    let mut files = std::fs::read_dir(folder).expect("there");
    files.next().expect("a file").expect("readable").path()
}

/// Lets cars hit some columns of a fleet, one after another, and returns the file that the viewer's thread has written.
fn file_of_fleet(folder: &Path, count: usize, hits: &[(u32, f64)], selected: Vec<u32>) -> PathBuf {
    let columns = columns(count);
    file_during(folder, &columns, selected, |handle, outputs, _| {
        for (number, (column, velocity)) in hits.iter().enumerate() {
            let impact = ImpactSpecification {
                mass: 1500.0,
                velocity: *velocity,
                gap: Some(0.0),
                restitution: None,
                height: None,
                direction: None,
            };
            let command = ImpactCommand {
                event_id: format!("hit-{number}"),
                column_id: columns[*column as usize]
                    .parameters
                    .settings()
                    .column_id
                    .clone(),
                stamp: SystemClock::new().now(),
                vehicle: String::new(),
                impact,
            };
            handle
                .execute(*column, Command::Impact(command))
                .expect("accepted");
            wait_for(outputs, *column, |it| matches!(it, Output::Report(_)));
            wait_for(
                outputs,
                *column,
                |it| matches!(it, Output::Status(status) if status.impacts_since_reset > 0 && status.assessed.is_some()),
            );
        }
    })
}

fn has_name(path: &Path) -> bool {
    path.file_name()
        .and_then(|it| it.to_str())
        .is_some_and(|it| it.starts_with("fleet_"))
}

/// Without the real viewer: a file is written, whose size depends little on the number of columns that nothing has hit.
#[test]
fn a_fleet_becomes_a_file() {
    let size = |count: usize| {
        let folder = tempfile::tempdir().expect("a folder");
        let file = file_of_fleet(folder.path(), count, &[(3, 4.0)], Vec::new());
        assert!(has_name(&file), "{}", file.display());
        let content = std::fs::read(&file).expect("there");
        assert_eq!(&content[..4], b"RRF2");
        content.len()
    };
    let (few, many) = (size(20), size(1_000));
    println!("20 columns: {few} B, 1000 columns: {many} B");
    // In full a column takes 200 kB and more.
    assert!(few > 100_000 && many < few + 1_000_000);
}

/// Of the column whose sensors have seen an impact, a fleet's viewer shows what that of a single column does: the estimates, and the
/// readings beside what was predicted. Nobody has confirmed the impact, so that the twin does not respond.
#[test]
fn a_fleet_shows_estimates_and_readings_beside_the_predicted_ones_of_the_struck_column() {
    let column = |number: usize| FleetColumn {
        name: format!("/hall/c{number}"),
        parameters: {
            let id = parse_override(&format!("column_id:=c{number}"));
            Arc::new(Parameters::load(&detected::files(), &[id]).expect("parameters"))
        },
    };
    let columns: Vec<_> = (0..3).map(column).collect();
    let (mut batches, _) = detected::struck(&columns[1].parameters);
    batches.sort_by_key(|it| it.first);
    let folder = tempfile::tempdir().expect("a folder");
    // The first estimate comes before the last readings, which it therefore predicts.
    let later = batches.partition_point(|it| it.first < detected::BEGIN + 140 * MS);
    let mut last = None;
    let file = file_during(
        folder.path(),
        &columns,
        Vec::new(),
        |handle, outputs, now| {
            let measurements = handle.measurements().expect("sensors");
            let send = |batches: &[Batch]| {
                for batch in batches {
                    let first = now + batch.first - detected::BEGIN;
                    let batch = batch.clone();
                    measurements.push(1, Batch { first, ..batch });
                }
            };
            send(&batches[..later]);
            wait_for(outputs, 1, |it| matches!(it, Output::Estimate(_)));
            send(&batches[later..]);
            wait_for(outputs, 1, |it| match it {
                Output::Estimate(it) => {
                    last = Some(it.record.update);
                    it.record.is_final
                }
                _ => false,
            });
        },
    );
    let updates = 1 + last.expect("a final estimate") as usize;
    let content = BufReader::new(File::open(&file).expect("there"));
    let messages: Vec<_> = DecoderApp::decode_lazy(content)
        .map(|it| it.expect("whole"))
        .collect();
    let rows = rows(&messages);
    let of = |entity: &str| {
        let entity = format!("/hall/c1/detected/{entity}");
        rows.get(&entity).copied().unwrap_or_default()
    };
    for entity in ["forecast", "momentum", "action"] {
        assert_eq!(of(entity), updates, "{entity}: {rows:?}");
    }
    for sensor in ["accelerometer", "laser", "base_strain"] {
        let [measured, predicted, explained] =
            ["measured", "predicted", "explained"].map(|it| of(&format!("sensors/{sensor}/{it}")));
        // One for each millisecond from 5 ms before contact on; the first estimate has seen what it does not predict.
        assert!(measured > 60 && explained == measured, "{rows:?}");
        assert!(predicted > 0 && predicted < measured, "{rows:?}");
    }
    let others = rows.keys().filter(|it| it.contains("/detected"));
    assert!(
        others.into_iter().all(|it| it.starts_with("/hall/c1/")),
        "{rows:?}"
    );
}

/// Two columns whose sensors have seen an impact each, and which have not responded: the second one does not begin where the first one
/// has begun, but after it.
#[test]
fn what_the_sensors_of_another_column_see_follows_what_was_seen_before() {
    let (stream, storage, options) = in_memory::stream();
    let parameters = Parameters::load(&detected::files(), &[]).expect("parameters");
    let parameters = Arc::new(parameters);
    let column = |number: usize| FleetColumn {
        name: format!("/hall/c{number}"),
        parameters: Arc::clone(&parameters),
    };
    let columns: Vec<_> = (0..2).map(column).collect();
    let fleet = Arc::new(ShownFleet::new(&columns, Vec::new()));
    let marks = vec![ColumnMark::default(); columns.len()];
    let mut shown = FleetStream::new(stream, fleet, marks, options).expect("a stream");
    for (column, until) in [(0, 0.08), (1, 0.02)] {
        let update = DetectedUpdate {
            stamp: 0,
            estimate: Box::new(ImpactEstimate {
                event_id: format!("detected-{column}"),
                ..ImpactEstimate::default()
            }),
            until,
            is_new: true,
            sensors: Vec::new(),
        };
        let newest = FleetItem::Newest {
            column,
            parameters: Arc::clone(&parameters),
        };
        let detected = FleetItem::Column(column, ViewerItem::Detected(Box::new(update)));
        shown.show([newest, detected]).expect("written");
    }
    shown.stream().flush_blocking().expect("written");
    let mut times = BTreeMap::new();
    for message in storage.take() {
        if let LogMsg::ArrowMsg(_, data) = message
            && let Ok(chunk) = Chunk::from_arrow_msg(&data)
            && let mut of_chunk = chunk.timelines().iter()
            && let Some((_, time)) = of_chunk.find(|(name, _)| name.as_str() == IMPACT_TIME)
        {
            let entity = chunk.entity_path().to_string();
            times.insert(entity, time.times_raw().to_vec());
        }
    }
    assert_eq!(times["/hall/c0/detected/forecast"], [80 * MS]);
    // 10 ms lie between two impacts.
    assert_eq!(times["/hall/c1/detected/forecast"], [(80 + 10 + 20) * MS]);
}

/// The part of a picture that has this colour.
fn part_of(picture: &[u8], [red, green, blue]: [u8; 3]) -> f64 {
    let near = |one: u8, other: u8| one.abs_diff(other) <= 2;
    let has = |it: &&[u8]| near(it[0], red) && near(it[1], green) && near(it[2], blue);
    let count = picture.chunks(4).filter(has).count();
    count as f64 / (picture.len() / 4) as f64
}

/// The real viewer shows the struck column in the colour of its action, which no other has, and it and the selected column in full.
#[test]
#[ignore = "slow: installs and runs the real viewer"]
fn the_real_viewer_shows_the_struck_column_and_the_selected_one() {
    let program = program();
    let folder = tempfile::tempdir().expect("a folder");
    let file_of = |name: &str, hits: &[(u32, f64)], selected: Vec<u32>| {
        let within = folder.path().join(name);
        std::fs::create_dir(&within).expect("made");
        file_of_fleet(&within, 200, hits, selected)
    };
    // The viewer takes the picture whether it has read all of the file or not.
    let picture_with = |file: &Path, is_complete: &dyn Fn(&[u8]) -> bool| {
        let picture = folder.path().join("picture.png");
        let mut pictures = (0..MAX_PICTURES).map(|_| {
            photograph(&program, file, &picture);
            pixels(&picture)
        });
        let complete = pictures.find(|it| is_complete(it));
        complete.expect("a picture of everything that the file contains")
    };
    let none = action_colour(Action::None);
    let evacuate = action_colour(Action::Evacuate);
    // The legend shows every colour once or a few times, the plan that of the columns without damage 200 times.
    let before = file_of("before", &[], Vec::new());
    let before = picture_with(&before, &|it| {
        part_of(it, none) > 10.0 * part_of(it, evacuate)
    });
    let file = file_of("after", &[(57, 25.0)], vec![3]);
    let after = picture_with(&file, &|it| {
        part_of(it, evacuate) > part_of(&before, evacuate)
    });
    for (name, picture) in [("before", &before), ("after", &after)] {
        let parts = Action::ALL.map(|it| part_of(picture, action_colour(it)));
        println!("parts of the picture {name} by action: {parts:?}");
    }
    let content = printed(&program, &file);
    for entity in [
        "/overview/plan/columns",
        "/overview/plan/rings",
        "/overview/plan/labels",
        "/overview/panel",
        "/overview/log",
        "/hall/c57/column/steel",
        "/hall/c57/plots/energy",
        "/hall/c3/column/steel",
        "c57: result of hit-0",
    ] {
        assert!(content.contains(entity), "{entity} is missing");
    }
    assert!(!content.contains("/hall/c58"), "it is in the plan only");
}
