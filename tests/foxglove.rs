//! A running node with Foxglove: what a client of another make finds, and what is wrong at the start.
#![cfg(all(feature = "cli", feature = "ros"))]
// A test may start an unnamed thread and listen without a bound: it ends with the test.
#![allow(clippy::disallowed_methods)]

#[path = "ros/domain.rs"]
#[allow(dead_code)] // for other tests
mod domain;
#[cfg(feature = "foxglove")]
#[path = "ros/foxglove_socket.rs"]
#[allow(dead_code)] // for the benchmark
mod foxglove_socket;
#[path = "../crates/alarm/tests/peers/free_port.rs"]
mod free_port;
#[cfg(feature = "foxglove")]
#[path = "ros/program.rs"]
#[allow(dead_code)] // for other tests
mod program;

use std::process::{Command, Output};

use domain::Domain;
use free_port::free_port;

fn parameters(port: u16, control: bool) -> Vec<String> {
    let given = [
        "column_id:=a3".to_owned(),
        "state.directory:=''".to_owned(),
        "record.mode:='off'".to_owned(),
        "real_time.priority:=0".to_owned(),
        "real_time.lock_memory:=false".to_owned(),
        "foxglove.mode:=serve".to_owned(),
        format!("foxglove.address:='127.0.0.1:{port}'"),
        format!("foxglove.control:={control}"),
    ];
    let arguments = given.into_iter().flat_map(|it| ["-p".to_owned(), it]);
    arguments.collect()
}

/// A node that cannot start.
fn run(domain: &Domain, parameters: &[String]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_column-twin"))
        .args(["run", "--ros-args"])
        .args(parameters)
        .env("ROS_DOMAIN_ID", domain.environment.domain_id.to_string())
        .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        .output()
        .expect("the program that was built with this test")
}

#[cfg(not(feature = "foxglove"))]
#[test]
fn a_program_without_foxglove_says_so_at_the_start() {
    let end = run(&Domain::fresh(), &parameters(free_port(), false));
    let text = String::from_utf8_lossy(&end.stderr).into_owned();
    assert_eq!(end.status.code(), Some(2), "{text}");
    assert!(
        text.contains("build it with the feature `foxglove`"),
        "{text}"
    );
}

#[cfg(feature = "foxglove")]
#[test]
fn a_port_in_use_is_an_error_at_the_start() {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").expect("a free port");
    let port = listener.local_addr().expect("is bound").port();
    let end = run(&Domain::fresh(), &parameters(port, false));
    let text = String::from_utf8_lossy(&end.stderr).into_owned();
    assert_eq!(end.status.code(), Some(2), "{text}");
    assert!(text.contains("foxglove.address"), "{text}");
}

/// `@foxglove/ws-protocol` reads every schema and a status, gets a prediction, and changes something only under control. Needs node,
/// and network the first time.
#[cfg(feature = "foxglove")]
#[test]
#[ignore = "needs node; run by .ci/run"]
fn a_client_of_another_make_finds_topics_parameters_and_services() {
    use std::path::Path;

    use program::Program;

    let interop = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/interop");
    let modules = Command::new(interop.join("node_environment.sh"))
        .output()
        .expect("bash");
    assert!(modules.status.success(), "{modules:?}");
    let modules = String::from_utf8(modules.stdout).expect("a path");
    for control in [false, true] {
        let (domain, folder) = (Domain::fresh(), tempfile::tempdir().expect("a folder"));
        let port = free_port();
        let given = parameters(port, control);
        let given: Vec<_> = given.iter().map(String::as_str).collect();
        let mut node = Program::ready(&domain, folder.path(), &given);
        let end = Command::new("node")
            .arg(interop.join("read_live.js"))
            .args([port.to_string(), control.to_string()])
            .env("NODE_PATH", modules.trim())
            .output()
            .expect("node");
        let told = String::from_utf8_lossy(&end.stderr).into_owned();
        assert!(end.status.success(), "{told}\n{:#?}", node.log_so_far());
        let found: serde_json::Value =
            serde_json::from_slice(&end.stdout).expect("what was found, as JSON");
        for topic in ["/column_state", "/impact_forecast", "/markers", "/rosout"] {
            let topics = found["topics"].as_array().expect("a list");
            assert!(topics.iter().any(|it| it == topic), "{found}");
        }
        // The stranger is told.
        node.wait_for("pages of \"https://evil.example\" may not connect");
        let (status, _, log) = node.terminate();
        assert!(status.success(), "{log:#?}");
    }
}

#[cfg(feature = "foxglove")]
#[test]
fn a_recording_is_played_paused_and_sought_by_a_client() {
    use foxglove_socket::{Frame, Socket};

    let folder = tempfile::tempdir().expect("a folder");
    let program = || {
        let mut command = Command::new(env!("CARGO_BIN_EXE_column-twin"));
        command
            .current_dir(folder.path())
            .env("XDG_STATE_HOME", folder.path());
        command
    };
    let recorded = program()
        .args(["simulate", "--velocity", "10", "--record", "impact"])
        .args(["--record-stamp", "100", "-p", "response.duration:=0.1"])
        .output()
        .expect("the program that was built with this test");
    assert!(recorded.status.success(), "{recorded:?}");
    let port = free_port();
    let mut replay = program()
        .args(["replay", "impact", "--rate", "0.1"])
        .arg(format!("--foxglove=127.0.0.1:{port}"))
        .spawn()
        .expect("the program that was built with this test");
    let mut socket = Socket::connect(port);
    let next_text = |socket: &mut Socket| loop {
        if let Frame::Text(text) = socket.receive() {
            return text;
        }
    };
    let info = next_text(&mut socket);
    let capabilities = info["capabilities"].as_array().expect("a list");
    assert!(capabilities.iter().any(|it| it == "playbackControl"));
    let first = info["dataStartTime"]["sec"].as_u64().expect("a time");
    assert!((99..=100).contains(&first), "{info}");
    let channels = next_text(&mut socket);
    let channel = |topic: &str| {
        let all = channels["channels"].as_array().expect("a list");
        let found = all.iter().find(|it| it["topic"] == topic);
        found.and_then(|it| it["id"].as_u64()).expect(topic)
    };
    let request = |play: bool, speed: f32, seek: Option<u64>, id: u8| {
        let mut frame = vec![3, u8::from(!play)];
        frame.extend(speed.to_le_bytes());
        frame.push(u8::from(seek.is_some()));
        frame.extend(seek.unwrap_or_default().to_le_bytes());
        frame.extend([1, 0, 0, 0, id]);
        frame
    };
    // Status, time and request of the next state of the playback that answers `id`.
    let answer = |socket: &mut Socket, id: u8| loop {
        if let Frame::Binary(frame) = socket.receive()
            && frame[0] == 5
            && frame.last() == Some(&id)
        {
            let time = u64::from_le_bytes(frame[2..10].try_into().expect("8 bytes"));
            return (frame[1], time);
        }
    };
    socket.send(2, &request(false, 0.5, Some(0), b'a'));
    let (status, begin) = answer(&mut socket, b'a');
    assert_eq!(status, 1, "it is paused");
    assert!(begin / 1_000_000_000 == first, "at the first message");
    let state_and_report = [channel("/column_state"), channel("/impact_report")];
    for (id, channel) in state_and_report.into_iter().enumerate() {
        socket.subscribe(id, channel);
    }
    socket.send(2, &request(true, 0.5, None, b'b'));
    let (mut counts, mut has_ended) = ([0; 2], false);
    while !has_ended || counts.contains(&0) {
        if let Frame::Binary(frame) = socket.receive() {
            match frame[0] {
                1 => counts[usize::from(frame[1])] += 1,
                5 => has_ended |= frame[1] == 3,
                _ => {}
            }
        }
    }
    // Behind the end is the end, where the report is still known.
    socket.send(2, &request(true, 1.0, Some(u64::MAX), b'c'));
    let (_, end) = answer(&mut socket, b'c');
    assert!(end > begin);
    loop {
        if let Frame::Binary(frame) = socket.receive()
            && frame[..2] == [1, 1]
        {
            break;
        }
    }
    replay.kill().expect("it runs");
    replay.wait().expect("it has ended");
}
