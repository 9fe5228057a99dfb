//! Tests with the real viewer, headless: stopped, killed, restarted, and photographed. They are slow and need Python and
//! PyPI: `cargo test --release --test viewer -- --ignored --nocapture --test-threads 1`.

use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use column_twin::parameters::Value;

use super::moments;
use super::twin::{LiveColumn, PATIENCE, bits, parameters, without_viewer};
use super::wheel::{Running, free_port, program, resident, viewer};

/// Size of the pictures \[points\]; the file has four pixels per point.
const WINDOW: &str = "1600x1000";

fn connecting(port: u16) -> LiveColumn {
    LiveColumn::start(&parameters(&[
        ("mode", Value::from("connect")),
        ("port", Value::from(i64::from(port))),
        ("memory_limit", Value::from(20_000_000_i64)),
    ]))
}

/// The viewer is stopped for ten seconds while more happens than fits in any buffer: the stream to ROS is the same bit for
/// bit, the memory is bounded, what is not shown is counted, and stopping takes less than a second.
#[test]
#[ignore = "slow: installs and runs the real viewer"]
fn a_stopped_viewer_delays_nothing() {
    let velocities: Vec<f64> = (0..60).map(|_| 1.0).collect();
    let expected = without_viewer(&velocities);
    let port = free_port();
    let running = Running::headless(port);
    let mut column = connecting(port);
    let mut states = column.hit(velocities[0]);
    column.wait_for("connected to the viewer");
    running.signal("STOP");
    let stopped = Instant::now();
    let before = resident(std::process::id());
    for velocity in &velocities[1..] {
        states.extend(column.hit(*velocity));
    }
    assert_eq!(bits(&states), expected);
    let (dropped, after) = (column.dropped(), resident(std::process::id()));
    println!(
        "60 impacts while it was stopped: {dropped} states lost to the viewer, {before} -> {after} B"
    );
    assert!(dropped > 0 && after < before + 100_000_000);
    let rest = Duration::from_secs(10).saturating_sub(stopped.elapsed());
    std::thread::park_timeout(rest);
    println!("stopped with the viewer stopped: {:?}", column.stop());
    running.signal("CONT");
}

/// The viewer runs for a tenth of the time: nothing waits for it.
#[test]
#[ignore = "slow: installs and runs the real viewer"]
fn a_slow_viewer_delays_nothing() {
    let velocities = [3.0, 1.0, 2.0, 1.0, 1.0, 1.0];
    let expected = without_viewer(&velocities);
    let port = free_port();
    let running = Running::headless(port);
    let mut column = connecting(port);
    let mut states = column.hit(velocities[0]);
    column.wait_for("connected to the viewer");
    let slow = AtomicBool::new(true);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while slow.load(Ordering::SeqCst) {
                running.signal("STOP");
                std::thread::park_timeout(Duration::from_millis(90));
                running.signal("CONT");
                std::thread::park_timeout(Duration::from_millis(10));
            }
        });
        for velocity in &velocities[1..] {
            states.extend(column.hit(*velocity));
        }
        let dropped = column.dropped();
        let took = column.stop();
        slow.store(false, Ordering::SeqCst);
        println!("a slow viewer: {dropped} states lost to it; stopped within {took:?}");
    });
    assert_eq!(bits(&states), expected);
}

/// After a stop, the viewer shows what follows.
#[test]
#[ignore = "slow: installs and runs the real viewer"]
fn a_continued_viewer_receives_what_follows() {
    let port = free_port();
    let running = Running::headless(port);
    let mut column = connecting(port);
    column.hit(3.0);
    column.wait_for("connected to the viewer");
    running.signal("STOP");
    column.hit(1.0);
    running.signal("CONT");
    column.hit(1.0);
    let deadline = Instant::now() + PATIENCE;
    while column.waiting() > 0 {
        assert!(Instant::now() < deadline, "the queue does not empty");
        std::thread::park_timeout(Duration::from_millis(20));
    }
    println!(
        "memory of the viewer: {} B; stopped within {:?}",
        running.memory(),
        column.stop()
    );
}

/// A viewer that replaces a killed one receives everything from the beginning.
#[test]
#[ignore = "slow: installs and runs the real viewer"]
fn a_restarted_viewer_receives_everything() {
    let velocities = [3.0, 1.0, 1.0];
    let expected = without_viewer(&velocities);
    let (port, program) = (free_port(), program());
    let folder = tempfile::tempdir().expect("a folder");
    let received = folder.path().join("received.rrd");
    let running = Running::headless(port);
    let mut column = connecting(port);
    let mut states = column.hit(velocities[0]);
    column.wait_for("connected to the viewer");
    drop(running);
    states.extend(column.hit(velocities[1]));
    column.wait_for("has closed the connection");
    column.log.lock().expect("no panic").clear();
    // The same program, which saves what it receives.
    let mut saving = viewer(&program);
    saving.arg("--save").arg(&received);
    let saver = Running::start(saving, port);
    column.wait_for("connected to the viewer");
    states.extend(column.hit(velocities[2]));
    assert_eq!(bits(&states), expected);
    println!("stopped within {:?}", column.stop());
    let wanted = [
        "/column/steel",
        "/ghost",
        "/panel",
        "/plots/energy",
        "/yield/3/surface",
        "/log",
        "forecast of impact-1",
        "forecast of impact-2",
        "forecast of impact-3",
    ];
    // The viewer may still be processing what it has received.
    let deadline = Instant::now() + PATIENCE;
    loop {
        let print = printed(&program, &received);
        let missing: Vec<_> = wanted.iter().filter(|it| !print.contains(**it)).collect();
        if missing.is_empty() {
            break;
        }
        assert!(
            Instant::now() < deadline,
            "missing in what was received: {missing:?}"
        );
        std::thread::park_timeout(Duration::from_millis(500));
    }
    saver.signal("INT");
    photograph(&program, &received, &folder.path().join("received.png"));
}

/// The contents of a file, as the viewer prints them.
pub fn printed(program: &Path, recording: &Path) -> String {
    let print = viewer(program)
        .args(["rrd", "print", "-vvv"])
        .arg(recording)
        .stdout(Stdio::piped())
        .output()
        .expect("runs");
    String::from_utf8_lossy(&print.stdout).into_owned()
}

/// The memory for viewers that connect late stays below the limit, however much is shown.
#[test]
#[ignore = "slow: serves as much as it can"]
fn served_data_take_no_more_memory_than_the_limit() {
    const LIMIT: u64 = 5_000_000;
    // Memory of the allocator, the channels and the column itself.
    const OVERHEAD: u64 = 25_000_000;
    const IMPACTS: usize = 600;
    let grown = |limit: u64| {
        let mut column = LiveColumn::start(&parameters(&[
            ("mode", Value::from("serve")),
            ("port", Value::from(i64::from(free_port()))),
            (
                "memory_limit",
                Value::from(i64::try_from(limit).expect("fits")),
            ),
        ]));
        column.wait_for("to watch");
        column.hit(1.0);
        let before = resident(std::process::id());
        for _ in 0..IMPACTS {
            column.hit(1.0);
            // So that everything is shown and nothing dropped.
            while column.waiting() > 0 {
                std::thread::park_timeout(Duration::from_millis(1));
            }
        }
        let grown = resident(std::process::id()).saturating_sub(before);
        println!("limit {limit} B: {grown} B more after {IMPACTS} impacts");
        column.stop();
        grown
    };
    let small = grown(LIMIT);
    assert!(small < LIMIT + OVERHEAD, "{small}");
    // Without the limit it takes more, so the limit has an effect.
    let large = grown(1_000_000_000);
    assert!(large > 2 * small, "{large} and {small}");
}

/// The node starts a viewer, shows it everything and exits within a second; the viewer stays open.
#[test]
#[ignore = "slow: installs and runs the real viewer"]
#[cfg(all(feature = "cli", feature = "ros"))]
fn a_viewer_is_started_and_stays_when_the_node_ends() {
    use super::domain::Domain;
    use super::program::Program;
    use std::os::unix::fs::PermissionsExt;

    let folder = tempfile::tempdir().expect("a folder");
    let (real, wheel) = (program(), viewer(&program()));
    let pid = folder.path().join("pid");
    // There is no screen.
    let script = format!(
        "#!/bin/sh\n[ \"$1\" = --version ] && exec {0} --version\necho $$ >{1}\nexec {0} --headless \"$@\"\n",
        real.display(),
        pid.display()
    );
    let wrapper = folder.path().join("rerun");
    std::fs::write(&wrapper, script).expect("written");
    std::fs::set_permissions(&wrapper, PermissionsExt::from_mode(0o755)).expect("executable");
    let domain = Domain::fresh();
    let mut command = Command::new(env!("CARGO_BIN_EXE_column-twin"));
    command
        .args(["run", "--ros-args", "-p", "viewer.mode:=spawn", "-p"])
        .arg(format!("viewer.port:={}", free_port()))
        .env(
            "PATH",
            format!(
                "{}:{}",
                folder.path().display(),
                std::env::var("PATH").unwrap_or_default()
            ),
        )
        .envs(
            wheel
                .get_envs()
                .filter_map(|(name, value)| Some((name, value?))),
        )
        // It would apply to the node, too.
        .env_remove("RUST_LOG");
    let _ended = KilledByFile(&pid);
    let mut node = Program::spawn(&domain, folder.path(), command);
    node.wait_for("is ready in domain");
    node.wait_for("connected to the viewer");
    let (status, took, log) = node.terminate();
    println!("ended within {took:?} with the viewer that it had started");
    assert!(status.success(), "{status}: {log:#?}");
    let warned = |line: &String| line.contains("WARN") && line.contains("viewer");
    assert!(!log.iter().any(warned), "{log:#?}");
    let is_there = kill("-0", &pid).expect("it was started").success();
    assert!(is_there, "the viewer has ended with the node");
}

/// Sends a signal to the process whose number is in a file.
fn kill(signal: &str, file: &Path) -> std::io::Result<std::process::ExitStatus> {
    let pid = std::fs::read_to_string(file)?;
    Command::new("kill").args([signal, pid.trim()]).status()
}

/// Ends the process whose number is in a file when the test ends.
struct KilledByFile<'a>(&'a Path);

impl Drop for KilledByFile<'_> {
    fn drop(&mut self) {
        let _ = kill("-KILL", self.0); // it may have ended
    }
}

/// Takes a picture of a file with the real viewer.
pub fn photograph(program: &Path, recording: &Path, picture: &Path) {
    let status = viewer(program)
        .arg(recording)
        .args(["--headless", "--window-size", WINDOW, "--bind", "127.0.0.1"])
        .args(["--port", &free_port().to_string()])
        .arg("--screenshot-to")
        .arg(picture)
        .status()
        .expect("runs");
    assert!(status.success(), "{}: {status}", recording.display());
}

/// The pixels of a picture.
pub fn pixels(path: &Path) -> Vec<u8> {
    let file = std::io::BufReader::new(std::fs::File::open(path).expect("there"));
    let mut reader = png::Decoder::new(file).read_info().expect("a picture");
    let size = reader.output_buffer_size().expect("fits");
    let mut pixels = vec![0; size];
    reader.next_frame(&mut pixels).expect("a picture");
    pixels
}

/// The pictures of four moments show something, and no two are alike.
#[test]
#[ignore = "slow: installs and runs the real viewer"]
fn pictures_of_four_moments_are_not_empty_and_differ() {
    let program = program();
    let folder = tempfile::tempdir().expect("a folder");
    let config = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/heb220_paper.yaml");
    moments::write(&config, folder.path()).expect("written");
    let pictures: Vec<_> = ["before", "first_yield", "peak", "rest"]
        .iter()
        .map(|name| {
            let picture = folder.path().join(format!("{name}.png"));
            photograph(
                &program,
                &folder.path().join(format!("{name}.rrd")),
                &picture,
            );
            pixels(&picture)
        })
        .collect();
    for (number, picture) in pictures.iter().enumerate() {
        let mut colours: Vec<_> = picture.chunks(4).map(<[u8]>::to_vec).collect();
        colours.sort_unstable();
        colours.dedup();
        println!(
            "picture {number}: {} bytes, {} colours",
            picture.len(),
            colours.len()
        );
        assert!(colours.len() > 1_000, "picture {number} is nearly empty");
        for other in &pictures[..number] {
            assert_eq!(picture.len(), other.len());
            let differ = picture
                .iter()
                .zip(other)
                .filter(|(one, other)| one != other);
            let part = differ.count() as f64 / picture.len() as f64;
            println!(
                "picture {number} differs from an earlier one in {:.2} %",
                100.0 * part
            );
            assert!(part > 0.005);
        }
    }
}
