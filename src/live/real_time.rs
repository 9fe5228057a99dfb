//! Real-time properties of the solver's thread. All of them are optional, and reduce lateness.

use rustix::mm::{MlockAllFlags, mlockall};
use rustix::process::{Resource, geteuid, getpriority_process, getrlimit, setpriority_process};
use rustix::thread::{CpuSet, sched_setaffinity, set_current_timer_slack};
use thread_priority::{
    NormalThreadSchedulePolicy, RealtimeThreadSchedulePolicy, ThreadPriority, ThreadPriorityValue,
    ThreadSchedulePolicy, set_thread_priority_and_policy, thread_native_id, thread_schedule_policy,
};

use crate::parameters::{Parameters, processors};
use crate::time::Nanos;

/// The stack of each thread of a twin and its node \[B\]: a response needs a few kilobytes, messages and their text some tens. Where
/// the memory is locked, the whole stack takes room.
pub const THREAD_STACK: usize = 512 << 10;

/// The real-time properties to request from the system.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RealTime {
    /// Priority under SCHED_FIFO, 1 to 99; `None`: normal scheduling.
    pub fifo_priority: Option<u8>,
    /// The processors on which the solver's thread may run; empty: all.
    pub processors: Vec<usize>,
    /// Whether to lock the memory of the program, so that it is not swapped out.
    pub lock_memory: bool,
}

impl Default for RealTime {
    /// The properties of the default parameters.
    fn default() -> Self {
        Self::of(&Parameters::default())
    }
}

impl RealTime {
    /// The properties in the parameters `real_time.*`.
    #[must_use]
    pub fn of(parameters: &Parameters) -> Self {
        let settings = &parameters.settings().real_time;
        Self {
            fifo_priority: (settings.priority > 0).then_some(settings.priority),
            // The list was validated with the parameters.
            processors: processors(&settings.processors).unwrap_or_default(),
            lock_memory: settings.lock_memory,
        }
    }

    /// Requests nothing.
    #[must_use]
    pub fn none() -> Self {
        Self {
            fifo_priority: None,
            processors: Vec::new(),
            lock_memory: false,
        }
    }
}

/// The outcome of a request.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Grant {
    /// The property was not requested.
    #[default]
    NotRequested,
    /// The property was granted.
    Granted,
    /// The property was denied; the twin runs without it, and a warning is logged.
    Denied {
        /// The error of the system.
        reason: String,
        /// How to obtain the property.
        hint: &'static str,
    },
}

/// The outcome of all requests.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RealTimeGrants {
    /// SCHED_FIFO for the solver's thread.
    pub fifo: Grant,
    /// The processors of the solver's thread.
    pub affinity: Grant,
    /// Locked memory.
    pub memory: Grant,
}

impl RealTimeGrants {
    /// One line for each denied request.
    pub fn warnings(&self) -> impl Iterator<Item = String> {
        [
            ("SCHED_FIFO", &self.fifo),
            ("CPU affinity", &self.affinity),
            ("mlockall", &self.memory),
        ]
        .into_iter()
        .filter_map(|(name, grant)| match grant {
            Grant::Denied { reason, hint } => Some(format!("{name} not granted: {reason}; {hint}")),
            Grant::NotRequested | Grant::Granted => None,
        })
    }
}

/// Requests the properties for the calling thread.
pub(super) fn request(wanted: &RealTime) -> RealTimeGrants {
    // By default the system delays wake-ups by up to 50 microseconds to combine them.
    let _ = set_current_timer_slack(std::num::NonZeroU64::new(1));
    RealTimeGrants {
        fifo: wanted.fifo_priority.map_or(Grant::NotRequested, fifo),
        affinity: match wanted.processors.is_empty() {
            true => Grant::NotRequested,
            false => affinity(&wanted.processors),
        },
        memory: if wanted.lock_memory {
            memory()
        } else {
            Grant::NotRequested
        },
    }
}

/// Requests the properties for the calling thread, which publishes the outputs: one priority below the solver, so that
/// samples do not wait for programs without deadlines. Denials are not reported, because the solver reports the same ones.
pub fn request_for_publisher(wanted: &RealTime) {
    let _ = set_current_timer_slack(std::num::NonZeroU64::new(1));
    request_below_the_solver(wanted, 1);
}

/// The same for the thread of the DDS library that sends what is published, one priority lower still. It also receives: a flood of
/// messages delays neither solver nor publisher.
pub fn request_for_sender(wanted: &RealTime) {
    request_below_the_solver(wanted, 2);
}

fn request_below_the_solver(wanted: &RealTime, by: u8) {
    if let Some(priority @ 1..) = wanted.fifo_priority.and_then(|it| it.checked_sub(by)) {
        let _ = fifo(priority);
    }
}

/// A thread has its priority of real time again this long before a deadline, so that it does not wait for a processor at the
/// deadline \[ns\].
pub(super) const URGENT_BEFORE_DEADLINE: Nanos = 300_000;

/// A forecast is computed with normal priority for at most this long \[ns\], longer than it takes on a processor of its own: on
/// processors that other programs keep busy, the rest gets the priority of real time, at the cost of readers and DDS threads.
const PATIENCE: u64 = 50_000_000;

/// Since when a forecast is computed.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Patience(Option<u64>);

impl Patience {
    /// Whether what is computed ahead can be computed with normal priority `now`, by the monotonic clock \[ns\]: always, if no
    /// forecast is awaited.
    pub fn lasts(&mut self, awaits_forecast: bool, now: u64) -> bool {
        if !awaits_forecast {
            self.0 = None;
            return true;
        }
        let since = *self.0.get_or_insert(now);
        now.saturating_sub(since) < PATIENCE
    }
}

/// The priority of a thread of real time that also computes for milliseconds what has no deadline.
///
/// Such work runs with normal priority. The system does not move a waiting thread of normal priority away from a processor that
/// one of real time keeps, even if another processor is idle: measured were readers and DDS threads that waited up to 5 ms
/// for the end of a forecast.
#[derive(Debug, Default)]
pub(super) struct Urgency {
    /// The priority under SCHED_FIFO, if it was granted.
    fifo_priority: Option<u8>,
    is_relaxed: bool,
}

impl Urgency {
    /// Of a thread that requested `wanted`, with the outcome `grants`.
    pub fn of(wanted: &RealTime, grants: &RealTimeGrants) -> Self {
        let fifo_priority = wanted
            .fifo_priority
            .filter(|_| grants.fifo == Grant::Granted);
        Self {
            fifo_priority,
            is_relaxed: false,
        }
    }

    /// Gives the calling thread normal priority.
    pub fn relax(&mut self) {
        if self.fifo_priority.is_some() && !self.is_relaxed {
            self.is_relaxed = schedule_normally();
        }
    }

    /// While the priority is normal, lets threads that wait for this processor run first. A kernel with lazy preemption would let them wait
    /// for its next tick, up to some milliseconds later: measured were readers and DDS threads whose slowest hundredth waited 2 ms, and
    /// 8 ms in the first 20 ms of a response.
    pub fn give_way(&self) {
        if self.is_relaxed {
            std::thread::yield_now();
        }
    }

    /// Gives the calling thread its priority of real time again.
    ///
    /// # Errors
    /// The system denies it now. It is not requested again.
    pub fn restore(&mut self) -> Result<(), String> {
        if !std::mem::take(&mut self.is_relaxed) {
            return Ok(());
        }
        match self.fifo_priority.map_or(Grant::NotRequested, fifo) {
            Grant::Denied { reason, hint } => {
                self.fifo_priority = None;
                Err(format!(
                    "SCHED_FIFO no longer granted to the solver's thread: {reason}; {hint}"
                ))
            }
            Grant::Granted | Grant::NotRequested => Ok(()),
        }
    }
}

/// Gives the calling thread the lowest priority, and these processors. `false` if it still has a
/// real-time priority, with which it would delay other threads.
pub(super) fn lower_priority(processors: Option<&CpuSet>) -> bool {
    const LEAST_NICE: i32 = 19;
    if let Some(processors) = processors {
        let _ = sched_setaffinity(None, processors);
    }
    let idle = ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Idle);
    let own = thread_native_id();
    // It fails for a program with a positive nice value, which has no effect under SCHED_IDLE, after the policy was set.
    let _ = set_thread_priority_and_policy(own, ThreadPriority::Min, idle);
    if thread_schedule_policy() != Ok(idle) {
        // Where SCHED_IDLE is not allowed.
        let other = ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Other);
        let _ = set_thread_priority_and_policy(own, ThreadPriority::Min, other);
        let _ = setpriority_process(None, LEAST_NICE);
    }
    matches!(
        thread_schedule_policy(),
        Ok(ThreadSchedulePolicy::Normal(_))
    )
}

/// Lets the calling thread give way to all threads of normal priority and to those of real time, and gives it these
/// processors.
pub(super) fn yield_to_others(processors: Option<&CpuSet>) {
    const NICE: i32 = 10;
    if let Some(processors) = processors {
        let _ = sched_setaffinity(None, processors);
    }
    // A thread inherits the policy of the one that starts it.
    schedule_normally();
    let _ = setpriority_process(None, NICE);
}

/// Gives the calling thread normal scheduling with the nice value that it has. `false` if the system denies it.
fn schedule_normally() -> bool {
    // `thread_priority` sets the nice value, too, and `ThreadPriority::Min` would be 19, with which the thread hardly gets a
    // processor among busy programs. It expects a value of 0 to 99 for the 40 nice values, from 19 down to -20.
    let nice = getpriority_process(None).unwrap_or_default();
    let value = (99.0 * (1.0 - (f64::from(nice) + 20.5) / 39.0))
        .clamp(0.0, 99.0)
        .round() as u8;
    let normal = ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Other);
    ThreadPriorityValue::try_from(value).is_ok_and(|value| {
        let priority = ThreadPriority::Crossplatform(value);
        set_thread_priority_and_policy(thread_native_id(), priority, normal).is_ok()
    })
}

fn granted<E: std::fmt::Display>(result: Result<(), E>, hint: &'static str) -> Grant {
    match result {
        Ok(()) => Grant::Granted,
        Err(error) => Grant::Denied {
            reason: error.to_string(),
            hint,
        },
    }
}

fn fifo(priority: u8) -> Grant {
    let result = ThreadPriorityValue::try_from(priority).and_then(|priority| {
        set_thread_priority_and_policy(
            thread_native_id(),
            ThreadPriority::Crossplatform(priority),
            ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo),
        )
        .map_err(|error| format!("{error:?}"))
    });
    granted(
        result,
        "to reduce late samples, allow it: `rtprio 99` for this user in /etc/security/limits.conf, LimitRTPRIO=99 in a \
         systemd unit, or --cap-add=SYS_NICE for a container",
    )
}

fn affinity(processors: &[usize]) -> Grant {
    const HINT: &str = "choose processors that this program may use (see `taskset -p $$`)";
    if let Some(beyond) = processors.iter().find(|&&it| it >= CpuSet::MAX_CPU) {
        return Grant::Denied {
            reason: format!("there is no processor {beyond}"),
            hint: HINT,
        };
    }
    let mut set = CpuSet::new();
    processors.iter().for_each(|&processor| set.set(processor));
    granted(sched_setaffinity(None, &set), HINT)
}

fn memory() -> Grant {
    // Under a limit, future allocations must not be locked, because they would fail.
    let unlimited = geteuid().is_root() || getrlimit(Resource::Memlock).current.is_none();
    let future = if unlimited {
        MlockAllFlags::FUTURE
    } else {
        MlockAllFlags::empty()
    };
    granted(
        mlockall(MlockAllFlags::CURRENT | future),
        "to reduce late samples, allow it: `memlock unlimited` for this user in /etc/security/limits.conf, \
         LimitMEMLOCK=infinity in a systemd unit, or --ulimit memlock=-1 for a container",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lowest_priority_is_that_of_an_idle_processor() {
        let lowered = std::thread::Builder::new()
            .name("lowered".to_owned())
            .spawn(|| (lower_priority(None), thread_schedule_policy()))
            .expect("starts")
            .join()
            .expect("no panic");
        let idle = ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Idle);
        assert_eq!(lowered, (true, Ok(idle)));
    }

    #[test]
    fn patience_is_that_with_one_forecast() {
        let mut patience = Patience::default();
        assert!(patience.lasts(true, 5) && patience.lasts(true, 4 + PATIENCE));
        assert!(!patience.lasts(true, 5 + PATIENCE));
        // What is not awaited is never urgent, and the next forecast has its own time.
        assert!(patience.lasts(false, 6 + PATIENCE) && patience.lasts(true, 7 + PATIENCE));
        assert!(!patience.lasts(true, 7 + 2 * PATIENCE));
    }

    /// Where the system denies SCHED_FIFO, the priority is normal all the time.
    #[test]
    fn a_forecast_is_computed_with_normal_priority_and_a_sample_with_that_of_real_time() {
        let policies = std::thread::Builder::new()
            .name("urgency".to_owned())
            .spawn(|| {
                let wanted = RealTime {
                    fifo_priority: Some(7),
                    ..RealTime::none()
                };
                let grants = request(&wanted);
                let mut urgency = Urgency::of(&wanted, &grants);
                let _ = setpriority_process(None, 3);
                urgency.relax();
                let relaxed = (thread_schedule_policy(), getpriority_process(None));
                let restored = urgency.restore().map(|()| thread_schedule_policy());
                (grants.fifo, relaxed, restored)
            })
            .expect("starts")
            .join()
            .expect("no panic");
        let normal = ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Other);
        let fifo = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
        let (granted, relaxed, restored) = policies;
        // With a nice value of 19 it waited for hundreds of milliseconds among busy programs.
        assert_eq!(relaxed, (Ok(normal), Ok(3)));
        let expected = if granted == Grant::Granted {
            fifo
        } else {
            normal
        };
        assert_eq!(restored, Ok(Ok(expected)));
    }
}
