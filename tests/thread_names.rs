//! The names of the threads of a twin, in a process of their own: no other test runs threads with the same names.
#![cfg(target_os = "linux")]

use std::time::{Duration, Instant};

use column_twin::live::{
    Live, LiveOptions, RealTime, SOLVER_THREAD, STATE_WRITER_THREAD, SimClock,
};
use column_twin::parameters::Parameters;
use column_twin::time::Nanos;
use column_twin::twin::Twin;

const START: Nanos = 1_800_000_000_000_000_000;

/// The names of all threads of this process as `top -H` shows them, which has 15 characters of each.
fn names() -> Vec<String> {
    let tasks = std::fs::read_dir("/proc/self/task").expect("readable");
    tasks
        .filter_map(|task| std::fs::read_to_string(task.ok()?.path().join("comm")).ok())
        .map(|name| name.trim().to_owned())
        .collect()
}

#[test]
fn threads_have_names() {
    let known = |name: &str| names().iter().any(|it| it == &name[..15]);
    let of_twin = [SOLVER_THREAD, STATE_WRITER_THREAD];
    assert_eq!(of_twin.map(known), [false, false], "{:?}", names());
    let folder = tempfile::tempdir().expect("a folder");
    let options = LiveOptions {
        state_file: Some(folder.path().join("column.json")),
        real_time: RealTime::none(),
        ..LiveOptions::default()
    };
    let twin = Twin::new(Parameters::default(), None, Box::new(|| 0), START);
    let twin = twin.expect("the column stands");
    let live = Live::start(twin, SimClock::new(START), options).expect("starts");
    live.snapshot().expect("an answer");
    // A thread gives itself its name once it runs.
    let deadline = Instant::now() + Duration::from_secs(60);
    while of_twin.map(known) != [true, true] {
        assert!(Instant::now() < deadline, "{:?}", names());
        std::thread::yield_now();
    }
    live.stop().expect("no panic");
}
