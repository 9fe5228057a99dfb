//! The health of the sensors, in `/diagnostics` and in the log.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::estimation::{BatchRejection, SensorCondition, SensorCounts, SensorHealth, Strays};
use crate::messages::diagnostic_msgs::DiagnosticStatus;
use crate::time::Nanos;

use ros_node::log_limit::LogLimit;

/// Most lines about sensors per [`LOG_PERIOD`]; what they would say is counted.
const MAX_LINES: u64 = 20;

/// Period of [`MAX_LINES`].
const LOG_PERIOD: Duration = Duration::from_secs(10);

/// So long after samples were lost or clipped, the diagnostics warn of it \[ns\].
const RECENT: Nanos = 10_000_000_000;

/// So long after the start, a sensor that has not sent anything is logged \[ns\].
const MAX_WAIT: Nanos = 5_000_000_000;

/// Most characters of a sensor's name from outside that a log shows.
const MAX_NAMED_CHARS: usize = 64;

/// The status of all sensors.
pub(super) struct SensorStatus {
    pub level: u8,
    pub message: String,
    pub values: Vec<(String, String)>,
}

/// Limits the lines about sensors, of one column or of all columns of a fleet.
#[derive(Debug)]
pub(super) struct SensorLog(Mutex<LogLimit>);

impl Default for SensorLog {
    fn default() -> Self {
        Self(Mutex::new(LogLimit::new(MAX_LINES, LOG_PERIOD)))
    }
}

impl SensorLog {
    fn admit(&self, now: Instant) -> Option<u64> {
        let mut limit = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        limit.admit(now)
    }
}

/// Sees what changes, and logs it.
pub(super) struct SensorWatch {
    started: Nanos,
    sensors: Vec<Watched>,
    /// Batches that the queue had dropped.
    lost_by_queue: u64,
    unknown: u64,
    /// Why these sensors show no impact.
    undetected: Option<String>,
    /// Names the column of a fleet in a line about a sensor; empty for a single twin.
    of: String,
    log: Arc<SensorLog>,
}

#[derive(Debug, Clone)]
struct Watched {
    condition: SensorCondition,
    counts: SensorCounts,
    is_corrected: bool,
    is_missed: bool,
    /// When samples were last found to be lost, and to be clipped.
    lost_at: Option<Nanos>,
    saturated_at: Option<Nanos>,
}

impl SensorWatch {
    /// `undetected` says why these sensors show no impact, if they are too slow, which the sensing logs. `of` names the column of a
    /// fleet in a line about a sensor, and is empty for a single twin; the columns share a log.
    pub fn new(
        sensors: usize,
        undetected: Option<String>,
        started: Nanos,
        of: String,
        log: Arc<SensorLog>,
    ) -> Self {
        let watched = Watched {
            condition: SensorCondition::Waiting,
            counts: SensorCounts::default(),
            is_corrected: false,
            is_missed: false,
            lost_at: None,
            saturated_at: None,
        };
        Self {
            started,
            sensors: vec![watched; sensors],
            lost_by_queue: 0,
            unknown: 0,
            undetected,
            of,
            log,
        }
    }

    /// Logs that a batch was not taken.
    pub fn rejected(&mut self, sensor: &str, rejection: &BatchRejection, now: Instant) {
        let Some(hidden) = self.log.admit(now) else {
            return;
        };
        let sensor: String = sensor.chars().take(MAX_NAMED_CHARS).collect();
        let hidden = told(hidden);
        let of = &self.of;
        tracing::warn!("a batch of sensor {sensor:?}{of} was dropped: {rejection}{hidden}");
    }

    /// Logs what has changed since the last call, and returns the status.
    pub fn status(
        &mut self,
        sensors: &[SensorHealth],
        strays: &Strays,
        lost_by_queue: u64,
        now: Nanos,
    ) -> SensorStatus {
        let problems = self.problems(sensors, strays, lost_by_queue, now);
        let mut values = values(sensors);
        let Strays {
            other_column,
            unknown_sensor,
            last,
        } = strays;
        let detected = self.undetected.as_deref().unwrap_or("yes");
        values.push(("impacts are detected".to_owned(), detected.to_owned()));
        let count = |key: &str, count: u64| (key.to_owned(), count.to_string());
        values.push(count("batches for other columns", *other_column));
        values.push(count("batches of unknown sensors", *unknown_sensor));
        if let Some(last) = last {
            values.push(("last unknown sensor".to_owned(), last.to_string()));
        }
        let (level, message) = match problems.is_empty() {
            true => (DiagnosticStatus::OK, "all sensors send".to_owned()),
            false => (DiagnosticStatus::WARN, problems.join("; ")),
        };
        SensorStatus {
            level,
            message,
            values,
        }
    }

    /// Logs what has changed since the last call, and returns what is wrong with the sensors.
    pub fn problems(
        &mut self,
        sensors: &[SensorHealth],
        strays: &Strays,
        lost_by_queue: u64,
        now: Nanos,
    ) -> Vec<String> {
        let of = self.of.clone();
        let lost = lost_by_queue.saturating_sub(self.lost_by_queue);
        self.lost_by_queue = lost_by_queue;
        if lost > 0 {
            self.log(true, &|| {
                format!(
                    "{lost} batches of measurements{of} were lost, because the estimation did not take them in time"
                )
            });
        }
        let mut problems = Vec::from_iter(self.undetected.clone());
        for (index, health) in sensors.iter().enumerate() {
            self.tell_changes(index, health, now);
            problems.extend(problem(health, &self.sensors[index], now));
        }
        if strays.unknown_sensor > std::mem::replace(&mut self.unknown, strays.unknown_sensor) {
            problems.push("batches of unknown sensors arrive".to_owned());
        }
        problems
    }

    fn tell_changes(&mut self, index: usize, health: &SensorHealth, now: Nanos) {
        let before = self.sensors[index].clone();
        let name = &format!("{}{}", health.name, self.of);
        let counts = health.counts;
        let lost = counts.lost.saturating_sub(before.counts.lost);
        let saturated = counts.saturated.saturating_sub(before.counts.saturated);
        let waited = now.saturating_sub(self.started) > MAX_WAIT;
        let is_missed = health.condition == SensorCondition::Waiting && waited;
        let is_corrected = health.clock_correction != 0;
        self.sensors[index] = Watched {
            condition: health.condition,
            counts,
            is_corrected,
            is_missed,
            lost_at: if lost > 0 { Some(now) } else { before.lost_at },
            saturated_at: match saturated {
                0 => before.saturated_at,
                _ => Some(now),
            },
        };
        if lost > 0 {
            self.log(true, &|| {
                format!(
                    "{lost} samples of sensor {name} were lost on their way, {} since the start",
                    counts.lost
                )
            });
        }
        if saturated > 0 {
            self.log(false, &|| {
                format!("{saturated} samples of sensor {name} are at the end of its range")
            });
        }
        if is_corrected && !before.is_corrected {
            let offset = 1e-9 * health.clock_offset as f64;
            self.log(false, &|| {
                format!(
                    "the clock of sensor {name} is {offset:.3} s behind the clock of the twin; its times are corrected; synchronise \
                     the clocks for exact times"
                )
            });
        }
        if is_missed && !before.is_missed {
            self.log(false, &|| {
                let reason = health.last_rejection.as_ref();
                let reason = reason.map_or_else(String::new, |it| format!(": {it}"));
                format!("nothing of sensor {name} was taken since the start{reason}")
            });
        }
        let kind = |condition| std::mem::discriminant(&condition);
        if kind(health.condition) == kind(before.condition) {
            return;
        }
        match health.condition {
            SensorCondition::Waiting => {}
            SensorCondition::Alive => {
                tracing::info!("sensor {name} sends readings");
            }
            SensorCondition::Stuck => self.log(false, &|| {
                format!(
                    "sensor {name} is stuck: it repeats one value for longer than its noise allows"
                )
            }),
            SensorCondition::Dead(silent) => self.log(false, &|| {
                format!(
                    "sensor {name} is dead: no reading for {:.1} s",
                    1e-9 * silent as f64
                )
            }),
        }
    }

    /// Logs a loss as an error, and anything else as a warning, unless there are too many lines.
    fn log(&mut self, is_loss: bool, line: &dyn Fn() -> String) {
        let Some(hidden) = self.log.admit(Instant::now()) else {
            return;
        };
        let (line, hidden) = (line(), told(hidden));
        match is_loss {
            true => tracing::error!("{line}{hidden}"),
            false => tracing::warn!("{line}{hidden}"),
        }
    }
}

/// What was counted of each sensor.
pub(super) fn values(sensors: &[SensorHealth]) -> Vec<(String, String)> {
    let mut values: Vec<_> = sensors.iter().map(value).collect();
    for health in sensors {
        if let Some(rejection) = &health.last_rejection {
            let key = format!("{}: last batch that was dropped", health.name);
            values.push((key, rejection.to_string()));
        }
    }
    values
}

fn told(hidden: u64) -> String {
    match hidden {
        0 => String::new(),
        _ => format!(" ({hidden} lines about sensors before this one are only counted)"),
    }
}

/// What is wrong with a sensor, in few words that do not change while it lasts.
fn problem(health: &SensorHealth, watched: &Watched, now: Nanos) -> Option<String> {
    let name = &health.name;
    let is_recent = |at: Option<Nanos>| at.is_some_and(|at| now.saturating_sub(at) <= RECENT);
    Some(match health.condition {
        SensorCondition::Waiting => format!("{name} has not sent anything"),
        SensorCondition::Dead(_) => format!("{name} is dead"),
        SensorCondition::Stuck => format!("{name} is stuck"),
        SensorCondition::Alive if is_recent(watched.lost_at) => {
            format!("samples of {name} are lost")
        }
        SensorCondition::Alive if is_recent(watched.saturated_at) => {
            format!("{name} is at the end of its range")
        }
        SensorCondition::Alive => return None,
    })
}

fn value(health: &SensorHealth) -> (String, String) {
    let condition = match health.condition {
        SensorCondition::Waiting => "waiting for the first batch".to_owned(),
        SensorCondition::Alive => "alive".to_owned(),
        SensorCondition::Stuck => "stuck".to_owned(),
        SensorCondition::Dead(silent) => format!("dead for {:.1} s", 1e-9 * silent as f64),
    };
    let SensorCounts {
        batches,
        samples,
        missing,
        saturated,
        lost,
        interruptions,
        duplicates,
        late,
        doubted,
        clock_jumps,
        rejected,
    } = health.counts;
    let text = format!(
        "{condition}; {samples} samples in {batches} batches, {missing} no numbers, {saturated} clipped, {lost} lost, \
         {duplicates} duplicates, {late} late, {doubted} with doubted times, {rejected} batches rejected, {interruptions} \
         interruptions, {clock_jumps} jumps of the clock; clock {:.6} s behind, corrected by {:.6} s",
        1e-9 * health.clock_offset as f64,
        1e-9 * health.clock_correction as f64,
    );
    (health.name.to_string(), text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn watch(sensors: usize) -> SensorWatch {
        SensorWatch::new(sensors, None, 0, String::new(), Arc::default())
    }

    fn health(condition: SensorCondition, counts: SensorCounts) -> SensorHealth {
        SensorHealth {
            name: "laser".into(),
            condition,
            counts,
            clock_offset: 2_000_000,
            clock_correction: 0,
            last_rejection: None,
        }
    }

    #[test]
    fn faults_are_warnings_as_long_as_they_last() {
        let mut watch = watch(1);
        let mut status = |condition, counts, now| {
            let sensors = [health(condition, counts)];
            let status = watch.status(&sensors, &Strays::default(), 0, now);
            (status.level, status.message)
        };
        let counts = SensorCounts::default();
        let warn = |text: &str| (DiagnosticStatus::WARN, text.to_owned());
        let ok = (DiagnosticStatus::OK, "all sensors send".to_owned());
        let alive = SensorCondition::Alive;
        assert_eq!(
            status(SensorCondition::Waiting, counts, 0),
            warn("laser has not sent anything")
        );
        assert_eq!(status(alive, counts, 1), ok);
        assert_eq!(
            status(SensorCondition::Dead(2_000_000_000), counts, 2),
            warn("laser is dead")
        );
        assert_eq!(
            status(SensorCondition::Stuck, counts, 3),
            warn("laser is stuck")
        );
        let clipped = SensorCounts {
            saturated: 5,
            ..counts
        };
        assert_eq!(
            status(alive, clipped, 4),
            warn("laser is at the end of its range")
        );
        let lossy = SensorCounts {
            lost: 100,
            ..clipped
        };
        assert_eq!(status(alive, lossy, 5), warn("samples of laser are lost"));
        assert_eq!(
            status(alive, lossy, RECENT),
            warn("samples of laser are lost")
        );
        assert_eq!(status(alive, lossy, RECENT + 6), ok);
    }

    #[test]
    fn sensors_that_are_too_slow_for_an_impact_are_a_warning() {
        let slow = "no sensor is fast enough".to_owned();
        let mut watch = SensorWatch::new(1, Some(slow.clone()), 0, String::new(), Arc::default());
        let sensors = [health(SensorCondition::Alive, SensorCounts::default())];
        let status = watch.status(&sensors, &Strays::default(), 0, 0);
        assert_eq!(
            (status.level, &status.message),
            (DiagnosticStatus::WARN, &slow)
        );
        let expected = ("impacts are detected".to_owned(), slow);
        assert!(status.values.contains(&expected), "{:?}", status.values);
    }

    #[test]
    fn strays_and_counts_are_shown() {
        let mut watch = watch(1);
        let strays = Strays {
            other_column: 7,
            unknown_sensor: 3,
            last: Some(BatchRejection::Empty),
        };
        let sensors = [health(SensorCondition::Alive, SensorCounts::default())];
        let first = watch.status(&sensors, &strays, 0, 0);
        assert_eq!(first.message, "batches of unknown sensors arrive");
        let find = |key: &str| first.values.iter().find(|(it, _)| it == key);
        assert_eq!(find("batches for other columns").expect("there").1, "7");
        assert!(
            find("laser")
                .expect("there")
                .1
                .starts_with("alive; 0 samples")
        );
        let second = watch.status(&sensors, &strays, 0, 1);
        assert_eq!(second.level, DiagnosticStatus::OK);
    }
}
