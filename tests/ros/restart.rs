//! Restarts of `column-twin run`: the damage is preserved, and unusable state files are reported.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use column_twin::messages::column_twin_msgs::{ColumnState, ImpactEvent, ImpactReport, TwinStatus};
use column_twin::messages::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus};
use column_twin::messages::std_srvs::{TriggerRequest, TriggerResponse};
use column_twin::parameters::Parameters;
use column_twin::ros::qos::{self, Endpoint};
use column_twin::ros::{ImpactOutcome, Node};

use super::domain::Domain;
use super::loopback::{Incoming, Outgoing, PATIENCE, event, impact, now, reader};
use super::program::Program;
use super::simulation;

/// No real-time scheduling.
const QUIET: [&str; 4] = [
    "-p",
    "real_time.priority:=0",
    "-p",
    "real_time.lock_memory:=false",
];

/// The state file of the default column for a program in this working folder.
fn state_file(folder: &Path) -> PathBuf {
    folder.join("column_twin/state/column.json")
}

fn status(node: &mut Node) -> TwinStatus {
    Incoming::<TwinStatus>::start(node, &qos::TWIN_STATUS).next()
}

#[test]
fn sigterm_during_a_response_keeps_its_damage() {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().unwrap();
    let patient = [&QUIET[..], &["-p", "response.duration:=20.0"]].concat();
    let program = Program::ready(&domain, folder.path(), &patient);
    let mut node = reader(&domain);
    let states = Incoming::<ColumnState>::start(&mut node, &qos::COLUMN_STATE);
    let forecasts = Incoming::<ImpactReport>::start(&mut node, &qos::IMPACT_FORECAST);
    // Ten seconds of approach: nothing has yielded yet when the program is told to stop.
    let on_its_way = || ImpactEvent {
        gap: 100.0,
        ..event("e1", now(), 1500.0, 10.0)
    };
    let events = Outgoing::<ImpactEvent>::start(&domain, &qos::IMPACT_EVENT);
    assert!(events.publish(on_its_way()));
    let forecast = forecasts.next();
    assert_eq!(states.next().phase, ColumnState::APPROACH);
    drop((states, forecasts, events, node));
    let (ended, took, log) = program.terminate();
    println!("ended within {took:?}");
    assert!(ended.success(), "{ended}: {log:#?}");

    let restarted = Program::ready(&domain, folder.path(), &QUIET);
    // What was restored, from which file, and of which time.
    let said = |it: &&String| it.contains("the damage of column \"column\" was restored from");
    let line = restarted
        .seen
        .iter()
        .find(said)
        .cloned()
        .unwrap_or_default();
    for part in [
        "column_twin/state/column.json",
        " UTC: it stands, v1 is ",
        "in 1 impacts",
        "\"e1\"",
    ] {
        assert!(line.contains(part), "{line:?} lacks {part}");
    }
    let status = status(&mut reader(&domain));
    let (_, simulated) = simulation::stream(&Parameters::default(), 1500.0, 10.0);
    assert_eq!(status.residual_v1, forecast.residual_v1);
    assert_eq!(status.impacts_since_reset, 1);
    assert_eq!(status.plastic_rotation, forecast.plastic_rotation);
    // The approach shifts the grid of the steps against the contact.
    let simulated = simulated.residual_v1.unwrap();
    let off = (forecast.residual_v1 - simulated).abs();
    assert!(off < 1e-3 * simulated, "{off}");
}

#[test]
fn the_log_level_debug_shows_inputs_commands_and_forecasts() {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().unwrap();
    let arguments = [&QUIET[..], &["--log-level", "column_twin:=debug"]].concat();
    let mut program = Program::ready(&domain, folder.path(), &arguments);
    assert!(impact(&domain, 1500.0, PATIENCE).is_ok());
    for shown in ["received impact event", "accepted", "of computing"] {
        program.wait_for(shown);
    }
}

#[test]
fn use_sim_time_without_a_clock_is_told_after_some_seconds() {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().unwrap();
    let arguments = [&QUIET[..], &["-p", "use_sim_time:=true"]].concat();
    let mut program = Program::ready(&domain, folder.path(), &arguments);
    program.wait_for("no message has arrived on /clock for 5 s");
}

#[test]
fn a_truncated_state_file_is_kept_aside_and_said() {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().unwrap();
    let program = Program::ready(&domain, folder.path(), &QUIET);
    let outcome = impact(&domain, 15_000.0, PATIENCE);
    assert!(
        matches!(outcome, Ok(ImpactOutcome::Forecast(_))),
        "{outcome:?}"
    );
    assert!(program.terminate().0.success());
    let path = state_file(folder.path());
    let whole = fs::read(&path).unwrap();
    let half = &whole[..whole.len() / 2];
    fs::write(&path, half).unwrap();

    let mut program = Program::ready(&domain, folder.path(), &QUIET);
    let said =
        |it: &&String| it.contains("the state file cannot be used, so the column starts undamaged");
    let line = program.seen.iter().find(said).cloned().unwrap_or_default();
    assert!(
        line.contains("it is truncated, or not a state file of column_twin"),
        "{:#?}",
        program.seen
    );
    assert!(line.contains("column.json.rejected-1"), "{line}");
    assert_eq!(status(&mut reader(&domain)).impacts_since_reset, 0);
    let kept = fs::read(
        folder
            .path()
            .join("column_twin/state/column.json.rejected-1"),
    )
    .unwrap();
    assert_eq!(kept, half);
    // It is as good a twin as any.
    assert!(impact(&domain, 1500.0, PATIENCE).is_ok());
    program.wait_for("accepted");
}

#[test]
fn a_state_file_of_another_column_is_kept_aside_and_said() {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().unwrap();
    let program = Program::ready(&domain, folder.path(), &QUIET);
    assert!(impact(&domain, 1500.0, PATIENCE).is_ok());
    assert!(program.terminate().0.success());
    let other = folder.path().join("column_twin/state/other.json");
    fs::copy(state_file(folder.path()), &other).unwrap();

    let another_name = [&QUIET[..], &["-p", "column_id:=other"]].concat();
    let program = Program::ready(&domain, folder.path(), &another_name);
    let of_another = "it belongs to column \"column\", but this is the twin of column \"other\"";
    assert!(
        program.seen.iter().any(|it| it.contains(of_another)),
        "{:#?}",
        program.seen
    );
    assert!(program.terminate().0.success());

    let another_section = [&QUIET[..], &["-p", "section.name:=HEB300"]].concat();
    let program = Program::ready(&domain, folder.path(), &another_section);
    let of_other_steel = "differ from those with which it was damaged";
    assert!(
        program.seen.iter().any(|it| it.contains(of_other_steel)),
        "{:#?}",
        program.seen
    );
    assert!(program.terminate().0.success());
}

#[test]
fn one_state_file_serves_one_program() {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().unwrap();
    let first = Program::ready(&domain, folder.path(), &QUIET);
    let (ended, log) = Program::start(&domain, folder.path(), &QUIET).end();
    assert_eq!(ended.code(), Some(1), "{log:#?}");
    let reason = "is in use by another running twin of this column";
    assert!(log.iter().any(|it| it.contains(reason)), "{log:#?}");
    // The first one has not noticed.
    let outcome = impact(&domain, 1500.0, PATIENCE);
    assert!(
        matches!(outcome, Ok(ImpactOutcome::Forecast(_))),
        "{outcome:?}"
    );
    assert!(first.terminate().0.success());
    let after = Program::ready(&domain, folder.path(), &QUIET);
    assert!(after.terminate().0.success());
}

/// Asks for a reset until it is answered: a request or an answer that comes before its reader is known is lost.
fn reset(node: &mut Node) {
    let endpoint = Endpoint {
        name: "/column_twin/reset",
        ..qos::RESET
    };
    let client = node
        .client::<TriggerRequest, TriggerResponse>(&endpoint)
        .unwrap();
    let deadline = Instant::now() + PATIENCE;
    while !matches!(client.receive_response(), Ok(Some((_, answer))) if answer.success) {
        assert!(Instant::now() < deadline, "the node resets nothing");
        client.send_request(TriggerRequest::default()).unwrap();
        std::thread::park_timeout(Duration::from_millis(200));
    }
}

/// The defaults were relative: after a start from another folder, the damage was gone without a word.
#[test]
fn a_node_that_is_started_from_another_folder_finds_its_damage() {
    let domain = Domain::fresh();
    let [home, first, second] = [(); 3].map(|()| tempfile::tempdir().unwrap());
    let start = |folder: &Path, home: Option<&Path>| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_column-twin"));
        command.args(["run", "--ros-args"]).args(QUIET);
        command.args(["-p", "record.mode:=events"]);
        command.env_remove("XDG_STATE_HOME").env_remove("HOME");
        if let Some(home) = home {
            command.env("HOME", home);
        }
        let mut program = Program::spawn(&domain, folder, command);
        program.wait_for("is ready in domain");
        program
    };
    let has = |program: &Program, part: &str| program.seen.iter().any(|it| it.contains(part));
    let program = start(first.path(), Some(home.path()));
    let place = home.path().join(".local/state/column_twin");
    for [said, folder] in [
        ["the damage is saved in", "state"],
        ["recordings are written to", "recordings"],
    ] {
        let line = format!("{said} {}", place.join(folder).display());
        assert!(has(&program, &line), "{:#?} lacks {line}", program.seen);
    }
    assert!(impact(&domain, 1500.0, PATIENCE).is_ok());
    assert!(program.terminate().0.success());
    assert!(place.join("state/column.json").is_file());
    assert_eq!(fs::read_dir(place.join("recordings")).unwrap().count(), 1);

    let program = start(second.path(), Some(home.path()));
    assert!(
        has(
            &program,
            "the damage of column \"column\" was restored from"
        ),
        "{:#?}",
        program.seen
    );
    assert!(program.terminate().0.success());
    for folder in [&first, &second] {
        assert_eq!(
            fs::read_dir(folder.path()).unwrap().count(),
            0,
            "nothing is left behind"
        );
    }

    // Without a home only the current folder remains, and the node says so.
    let program = start(second.path(), None);
    let is_warning =
        |it: &String| it.contains("WARN") && it.contains("neither XDG_STATE_HOME nor HOME");
    assert!(program.seen.iter().any(is_warning), "{:#?}", program.seen);
    assert!(program.terminate().0.success());
    assert!(second.path().join("column_twin/state").is_dir());
}

/// A damaged column looked undamaged, with one warning at the start.
#[test]
fn a_rejected_state_file_calls_for_an_inspection_until_the_reset() {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir_all(folder.path().join("column_twin/state")).unwrap();
    fs::write(state_file(folder.path()), "half of a file").unwrap();
    let calls = |it: &TwinStatus| {
        it.action == TwinStatus::ACTION_INSPECT
            && it.action_reason.contains("could not be used")
            && it.action_reason.contains("~/reset")
    };
    // Also when it is restarted, and no other file is rejected.
    for _ in 0..2 {
        let program = Program::ready(&domain, folder.path(), &QUIET);
        let mut node = reader(&domain);
        let statuses = Incoming::<TwinStatus>::start(&mut node, &qos::TWIN_STATUS);
        let diagnostics = Incoming::<DiagnosticArray>::start(&mut node, &qos::DIAGNOSTICS);
        statuses.find("a status that calls for an inspection", calls);
        diagnostics.find("a warning about the column", |array| {
            array.status.iter().any(|it| {
                it.name.ends_with("twin")
                    && it.level == DiagnosticStatus::WARN
                    && it.message.contains("state file")
            })
        });
        drop((statuses, diagnostics, node));
        assert!(program.terminate().0.success());
    }
    let program = Program::ready(&domain, folder.path(), &QUIET);
    let mut node = reader(&domain);
    let statuses = Incoming::<TwinStatus>::start(&mut node, &qos::TWIN_STATUS);
    reset(&mut node);
    statuses.find("a status without a reason", |it| {
        it.action == TwinStatus::ACTION_NONE && !it.action_reason.contains("could not be used")
    });
    drop((statuses, node));
    assert!(program.terminate().0.success());
    let program = Program::ready(&domain, folder.path(), &QUIET);
    assert!(!calls(&status(&mut reader(&domain))));
    assert!(program.terminate().0.success());
}

/// As on a full disk: the loss was logged once, and the exit code was 0.
#[test]
fn damage_that_cannot_be_saved_is_an_error_in_diagnostics_and_of_the_program() {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().unwrap();
    let mut program = Program::ready(&domain, folder.path(), &QUIET);
    let mut node = reader(&domain);
    let diagnostics = Incoming::<DiagnosticArray>::start(&mut node, &qos::DIAGNOSTICS);
    // Where the new file would be written.
    let new = folder.path().join("column_twin/state/column.json.new");
    fs::create_dir(new).unwrap();
    assert!(impact(&domain, 1500.0, PATIENCE).is_ok());
    let line = program.wait_for("cannot be written");
    assert!(line.contains("ERROR"), "{line}");
    diagnostics.find("an error of the solver", |array| {
        array.status.iter().any(|it| {
            it.name.ends_with("solver")
                && it.level == DiagnosticStatus::ERROR
                && it.message.contains("damage may be missing after a restart")
        })
    });
    drop((diagnostics, node));
    let (ended, _, log) = program.terminate();
    assert_eq!(ended.code(), Some(3), "{log:#?}");
}

/// The write of the last damage fails after everything else has ended: nothing told of it.
#[test]
fn a_state_file_that_cannot_be_written_at_the_stop_makes_the_exit_code_3() {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().unwrap();
    let program = Program::ready(&domain, folder.path(), &QUIET);
    // A file in the place of the folder.
    fs::remove_dir_all(folder.path().join("column_twin/state")).unwrap();
    fs::write(folder.path().join("column_twin/state"), "").unwrap();
    let (ended, _, log) = program.terminate();
    assert_eq!(ended.code(), Some(3), "{log:#?}");
    let is_told = |it: &String| it.contains("ERROR") && it.contains("state file");
    assert!(log.iter().any(is_told), "{log:#?}");
}

/// Of 30 nodes that were killed, one had lost the impact whose forecast it had just given out.
#[test]
#[ignore = "slow: 30 nodes are killed and started again"]
fn no_impact_with_a_forecast_is_missing_after_30_kills() {
    const KILLS: u32 = 30;
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().unwrap();
    for kill in 0..=KILLS {
        let program = Program::ready(&domain, folder.path(), &QUIET);
        let mut node = reader(&domain);
        let restored = status(&mut node).impacts_since_reset;
        assert_eq!(restored, kill, "after kill {kill}");
        let forecasts = Incoming::<ImpactReport>::start(&mut node, &qos::IMPACT_FORECAST);
        let events = Outgoing::<ImpactEvent>::start(&domain, &qos::IMPACT_EVENT);
        let id = format!("kill-{kill}");
        assert!(events.publish(event(&id, now(), 1500.0, 2.0)));
        forecasts.find("the forecast", |it| it.event_id == id);
        // At once, and later while it goes on.
        std::thread::sleep(Duration::from_millis(u64::from(kill % 6) * 3));
        drop(program);
    }
}
