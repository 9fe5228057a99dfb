//! Processor time and memory of another process.

use std::time::{Duration, Instant};

/// Unit of the times in `/proc` \[1/s\], the same on all common builds of Linux.
const USER_HZ: f64 = 100.0;

/// Processor time that a process has used \[s\], from fields 14 and 15 of `/proc/PID/stat`.
fn processor_time(id: u32) -> f64 {
    let stat = std::fs::read_to_string(format!("/proc/{id}/stat")).expect("it runs");
    // The program name is in brackets and may contain any character.
    let behind_name = stat.rsplit_once(')').expect("a name").1;
    let ticks = |field: usize| -> f64 {
        let text = behind_name.split_ascii_whitespace().nth(field - 3);
        text.and_then(|it| it.parse().ok()).expect("a number")
    };
    (ticks(14) + ticks(15)) / USER_HZ
}

/// Processor time that the present threads of a process have used \[s\], to the nanosecond.
fn time_of_threads(id: u32) -> f64 {
    let threads = std::fs::read_dir(format!("/proc/{id}/task")).expect("it runs");
    let nanos = threads.map(|thread| -> f64 {
        let path = thread.expect("a thread").path().join("schedstat");
        let text = std::fs::read_to_string(path).expect("the times of a thread");
        let used = text.split_ascii_whitespace().next();
        used.and_then(|it| it.parse().ok()).expect("a number")
    });
    1e-9 * nanos.sum::<f64>()
}

/// By how much a processor time grows during a function call, over the time that this takes.
fn share_by(used: impl Fn() -> f64, doing: impl FnOnce()) -> f64 {
    let (before, began) = (used(), Instant::now());
    doing();
    (used() - before) / began.elapsed().as_secs_f64()
}

/// The share of a processor that a process uses during a function call.
pub fn share_during(id: u32, doing: impl FnOnce()) -> f64 {
    share_by(|| processor_time(id), doing)
}

/// The share of a processor that a process at rest, which neither starts nor ends threads, uses during a function call.
pub fn share_at_rest(id: u32, doing: impl FnOnce()) -> f64 {
    share_by(|| time_of_threads(id), doing)
}

/// The share of a processor that these processes use together during a sleep.
pub fn share_together(ids: &[u32], span: Duration) -> f64 {
    let used = || ids.iter().map(|id| processor_time(*id)).sum();
    share_by(used, || std::thread::sleep(span))
}

/// The resident memory of a process \[MiB\], from `VmRSS` in `/proc/PID/status`.
pub fn resident_mebibytes(id: u32) -> f64 {
    let status = std::fs::read_to_string(format!("/proc/{id}/status")).expect("it runs");
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kibibytes = line.and_then(|line| line.trim().strip_suffix("kB"));
    let kibibytes: Option<f64> = kibibytes.and_then(|it| it.trim().parse().ok());
    kibibytes.expect("a number") / 1024.0
}
