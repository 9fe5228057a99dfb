//! Delivery against programs of other makes: the broker mosquitto, and an HTTPS server in Python.
//!
//! Ignored by default, because they need Debian's packages mosquitto and mosquitto-clients, and Python 3.

mod certificates;
mod mqtt;
mod programs;
mod webhook;

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant, SystemTime};

use column_alarm::{
    Alarms, Condition, Importance, Level, NODE_STOPPED, Notices, Rules, Statistics, Watched,
};

/// Longest wait for anything that is to happen.
const PATIENCE: Duration = Duration::from_secs(60);

fn rules() -> Rules {
    Rules::none().with("action", 2).with(NODE_STOPPED, 1)
}

fn condition(subject: &str, rank: u8) -> Condition {
    Condition {
        watched: Watched {
            kind: "action".to_owned(),
            subject: subject.to_owned(),
            part: None,
        },
        level: Level::new(rank, "restrict"),
        reason: "A vehicle hit the column.".to_owned(),
        cause: "event 1".to_owned(),
        time: SystemTime::now(),
    }
}

type Told = Arc<Mutex<Vec<(Importance, String)>>>;

fn listening() -> (Notices, Told) {
    let told = Told::default();
    let kept = Arc::clone(&told);
    let notices: Notices = Arc::new(move |importance, text| {
        kept.lock().unwrap().push((importance, text));
    });
    (notices, told)
}

/// Waits until the statistics are as they should be.
fn wait_until(alarms: &Alarms, what: &str, holds: impl Fn(&Statistics) -> bool) {
    let began = Instant::now();
    while !holds(&alarms.statistics()) {
        assert!(
            began.elapsed() < PATIENCE,
            "{what}: {:?}",
            alarms.statistics()
        );
        std::thread::sleep(Duration::from_millis(5));
    }
}
